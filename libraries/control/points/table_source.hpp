// What the two readers of a table of points have in common: its cells, its file, and where an error is. Private to
// libraries/control/points.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "base/text/csv_table.hpp"
#include "control/points/control_table.hpp"

namespace plumbline::control {

inline constexpr const char* kExpectedColumns =
    "id, E, N, H (or x, y, z) and optionally sigma (or sigma_E, sigma_N, sigma_H) and role";
inline constexpr const char* kShortened =
    ", which a spreadsheet has shortened: its last digit stands for a metre or more. Give the column a number format "
    "with decimals there and save the table again";

struct TableSource {
  std::string file;
  ControlOptions options;
  text::CsvTable table;

  [[noreturn]] void fail(const text::CsvRow& row, const std::string& what) const;
  [[noreturn]] void fail_header(const std::string& what) const;
};

/// What is wrong with the rows of a table, so that all of it is told at once.
class RowProblems {
 public:
  /// Runs `read` of a row; what it throws is kept.
  template <typename Read>
  void attempt(const Read& read) {
    try {
      read();
    } catch (const std::runtime_error& error) {
      lines_.emplace_back(error.what());
    }
  }
  /// Throws std::runtime_error with a line for each row, if there are any: the first ten, and how many more.
  void raise() const;

 private:
  std::vector<std::string> lines_;
};

/// Points of a table with a header, and of one without. Neither looks for names that occur twice.
ControlTable read_named_columns(const TableSource& source);
ControlTable read_ordered_columns(const TableSource& source);

}  // namespace plumbline::control
