// A workbook that spreadsheet programs open: Office Open XML (ECMA-376, SpreadsheetML), one table a sheet with a
// frozen, filtered head. Nothing depends on a locale or a clock, so the same content has the same bytes.
#pragma once

#include <string>
#include <variant>
#include <vector>

namespace plumbline::report {

/// A text, or a number; one that is not finite is an empty cell.
using SheetCell = std::variant<std::string, double>;

struct Sheet {
  std::string name;                ///< at most 31 characters, none of []:*?/\ .
  std::vector<std::string> heads;  ///< of the columns
  std::vector<int> decimals;       ///< shown of numbers in each column; the cells hold all of them
  std::vector<std::vector<SheetCell>> rows;
};

/// The .xlsx. Throws std::invalid_argument for a name that no program takes, a row that is not as wide as the head, and
/// more rows than a sheet holds (1 048 576).
std::string write_workbook(const std::vector<Sheet>& sheets);

}  // namespace plumbline::report
