// Tables in Excel's own files (.xlsx): SpreadsheetML of ECMA-376-1, 18.3 (sheets), 18.4 (shared strings) and 18.8
// (number formats), in a ZIP archive. Numbers are taken as the file holds them, not as a sheet shows them rounded;
// days as 2026-05-03, because Excel makes them of what somebody typed as two lengths, "5/3".
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace plumbline::campaign {

/// Whether the name ends in .xlsx or .xlsm.
bool is_workbook(const std::filesystem::path& path);

struct WorkbookSheet {
  std::string name;
  /// Its cells as CSV, with ',' and '.', and a line for each row, so that a line's number is that of the row. Empty if
  /// no cell holds anything.
  std::string csv;
};

/// The sheets of a workbook that are not hidden, in its order. `file` is for messages. Throws CampaignError that names
/// file, sheet and cell: for what is no workbook, and for a formula without its value. An error in place of a value
/// is its text ("#REF!"): whoever takes the column refuses it.
std::vector<WorkbookSheet> sheets_of(const std::string& bytes, const std::filesystem::path& file);

/// The text of a table: that of the file, or of a workbook the one sheet that `is_it` knows by its columns; where only
/// one sheet holds anything that, whatever its columns are. `what` is it in messages: "a table of plates". Throws
/// CampaignError where none or several are.
std::string table_text(const std::filesystem::path& file, const std::function<bool(const std::string&)>& is_it,
                       const std::string& what);

/// The same for known points: sheets with E and N, and those of heights alone that are called control; where there is
/// none of either, one of heights, which a sheet of panels ("Nr, Breite, Höhe") looks like, too.
std::string control_text(const std::filesystem::path& file);

}  // namespace plumbline::campaign
