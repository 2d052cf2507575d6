// Columns of survey tables: the many names they go by, and values of a row in SI units.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/text/csv_table.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/survey_csv.hpp"

namespace plumbline::survey {

/// What a normalised header cell may be called -> our name of the column.
const std::map<std::string, std::string>& survey_column_names();

/// Access to one table's rows by column name. A value that cannot be read is recorded as skipped in the builder.
class SurveyColumns {
 public:
  /// Takes the columns from `options.columns` or the header of `table`; throws SurveyReadError for names and units it
  /// does not know.
  SurveyColumns(const text::CsvTable& table, const SurveyCsvOptions& options, SurveyBuilder& builder);

  /// Angle columns whose unit neither header nor options say; their values cannot be read before `set_angle_unit`.
  const std::vector<std::string>& untold() const { return untold_; }
  /// Of columns of lengths without a unit.
  std::string length_unit() const { return options_.length_unit.empty() ? "m" : options_.length_unit; }
  /// Columns of lengths that have no unit in a table that names none for any, where the options do not say one either.
  std::vector<std::string> untold_lengths() const {
    return lengths_told_.empty() && options_.length_unit.empty() ? lengths_untold_ : std::vector<std::string>();
  }
  /// A header says "Grad": a degree in German and a gon in French.
  bool says_grad() const { return says_grad_; }
  void set_angle_unit(const std::string& unit);

  bool has(const std::string& column) const { return columns_.contains(column); }
  /// Our names of the table's columns, in their order there.
  std::vector<std::string> names() const;
  /// What the table itself calls the column; our name where it has no header.
  std::string written(const std::string& column) const;
  void select(const text::CsvRow& row) { row_ = &row, failed_ = false; }
  const text::CsvRow& row() const { return *row_; }
  SourcePosition position() const { return builder_.at(row_->line, 1); }
  /// Whether a value of the selected row could not be read.
  bool failed() const { return failed_; }

  /// Text of the column; empty if the column or the cell is missing.
  std::string text(const std::string& column) const;
  /// [m], [rad], plain number, integer; NaN or nullopt for a missing or empty cell, and after a failure.
  double length(const std::string& column);
  double angle(const std::string& column);
  double number(const std::string& column);
  int integer(const std::string& column, int otherwise);
  /// `value` in `unit` (a length or an angle unit) in SI, NaN if the unit is unknown.
  static double in_si(double value, const std::string& unit);

  /// E, N, H (also named x, y, z), NaN where missing.
  Eigen::Vector3d coordinates();
  /// From cov_ee ... or sigma_e ...; all NaN if the table or the row has none. Fails unless positive definite.
  Eigen::Matrix3d covariance();

  void fail(const std::string& column, const std::string& expected);
  /// Lengths and coordinates such as "1,000", of which nothing tells whether they are 1 or 1000.
  void refuse_thousands() const;

 private:
  struct Column {
    std::size_t index = 0;
    std::string unit;
  };
  const text::CsvCell* cell(const std::string& column) const;
  void take_order(const std::string& order);
  void take_header();
  void take_axes();
  bool named_after_xy(const std::string& column) const;
  [[noreturn]] void refuse_axes(const std::string& found) const;
  void place(const std::string& name, std::size_t index, const std::string& unit);
  double measured(const std::string& column, bool is_angle);

  const text::CsvTable& table_;
  const SurveyCsvOptions& options_;
  SurveyBuilder& builder_;
  std::map<std::string, Column> columns_;
  const text::CsvRow* row_ = nullptr;
  bool failed_ = false;
  bool of_points_ = false;  ///< a table of points, whose columns of accuracies are those of control
  std::vector<std::string> untold_, lengths_told_, lengths_untold_;
  bool says_grad_ = false;
};

}  // namespace plumbline::survey
