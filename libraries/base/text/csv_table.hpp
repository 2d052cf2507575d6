// A table in text whose delimiter and decimal separator nobody wrote down: both are found by which pair makes most
// cells numbers. Header cells may carry a unit: "Hz [gon]", "sigma_e (mm)", "E_m".
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/text/text.hpp"

namespace plumbline::text {

struct CsvCell {
  std::string text;  ///< without quotes and blanks around
  int column = 0;    ///< of its first character in the line, from 1
};

struct CsvRow {
  int line = 0;
  std::vector<CsvCell> cells;
};

struct CsvHeaderCell {
  std::string name;     ///< lower case, letters, digits and '_' only, unit taken off
  std::string unit;     ///< lower case; empty if none was given
  std::string written;  ///< the name as the file has it, normalised likewise but not replaced by the known one
};

struct CsvTable {
  DecodedText decoded;
  char delimiter = ',';  ///< ' ' stands for any run of blanks
  char decimal = '.';
  std::vector<CsvHeaderCell> header;  ///< empty if the first row holds data
  int header_line = 0;
  int titles = 0;            ///< rows above the header that were passed over as titles
  std::vector<CsvRow> rows;  ///< without header, comments, empty lines and rows of empty cells
  /// Lines that begin with a comment mark and a name at once and hold numbers as a row does ("#7,12.5,3.1,0.2"): a
  /// point called #7, or a row taken out. The reader of the table refuses them with kDoubtfulRow.
  std::vector<CsvRow> doubtful;

  /// The number in `cell`, with this table's decimal separator.
  std::optional<double> number(const CsvCell& cell) const { return parse_number(cell.text, decimal); }
  /// "delimiter ';', decimal separator ','", for messages.
  std::string dialect() const;
};

/// What to do about a doubtful row.
inline constexpr const char* kDoubtfulRow =
    "if that is a name, put it in quotes (\"#7\"); if the row is a comment, put a blank after the mark";

/// What rows above the header are: of the table, so that there is no header, or titles as people write them above a
/// table in a spreadsheet ("Project Tower East", "as of 5 May"). A title has fewer cells filled than the header and at
/// most one number, and stands among the first rows, so no row of values is taken for one.
enum class TitleRows { refused, passed_over };

/// Reads `bytes` as a table. Lines that begin with '#', '%' or "//" are comments. The first row (a comment too, if it
/// is one) is the header when at least two of its cells are in `known_names` and none but the first is a number.
/// `known_names` maps what a normalised header cell may be called to the name used for it in CsvTable::header; names
/// that are not in it are kept as they are. Never throws; a text of no table has no rows or rows of one cell.
CsvTable read_csv(std::string_view bytes, const std::map<std::string, std::string>& known_names,
                  TitleRows titles = TitleRows::refused);

/// "2 rows above the header are titles, and are left out", for messages.
std::string titles_left_out(int titles);

/// Numbers of `columns` that are thousands as well as decimals, as "1,000": each number of the table that has the
/// decimal separator has three digits behind it and one to three before it.
struct Thousands {
  std::string example;    ///< one of them; empty: there is none, or another number shows what the separator is
  bool integers = false;  ///< others have no separator: so are small numbers written that are grouped by thousands
};
Thousands thousands_of(const CsvTable& table, const std::vector<std::size_t>& columns);

/// `text` as a CSV field: quoted where it holds a delimiter or quotes, line ends as blanks. Text that a spreadsheet
/// would take for a formula (=, +, - or @ in front, but not a number) gets an apostrophe in front, which read_csv takes
/// off again.
std::string csv_field(std::string_view text);

}  // namespace plumbline::text
