#include "control/points/control_table.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "control/points/point_columns.hpp"
#include "control/points/table_source.hpp"

namespace plumbline::control {
namespace {

using text::CsvRow;

constexpr double kCoarsest = 0.5;  // [m]; a standard deviation of control beyond it may be millimetres
constexpr double kFarthest = 1e9;  // [m]

/// Text behind " # " is a remark, unless it stands in quotes. Line numbers stay.
std::string without_remarks(const std::string& bytes) {
  const std::string text = text::decode_text(bytes).text;
  std::string kept;
  for (const text::Line& line : text::split_lines(text)) {
    bool quoted = false;
    std::size_t end = line.text.size();
    for (std::size_t i = 0; i < line.text.size() && end == line.text.size(); ++i) {
      quoted ^= line.text[i] == '"';
      const bool blank_before = i > 0 && (line.text[i - 1] == ' ' || line.text[i - 1] == '\t');
      const bool blank_behind = i + 1 == line.text.size() || line.text[i + 1] == ' ';
      if (line.text[i] == '#' && !quoted && blank_before && blank_behind && !text::trim(line.text.substr(0, i)).empty())
        end = i;
    }
    kept.append(line.text.substr(0, end)).push_back('\n');
  }
  return kept;
}

/// A row in one cell under several columns has another delimiter than its header.
void tidy_rows(text::CsvTable& table) {
  for (CsvRow& row : table.rows) {
    if (table.header.empty() || row.cells.size() > 1) continue;
    const std::string whole = row.cells[0].text;
    row.cells.clear();
    for (const std::string_view word : text::split_blanks(whole)) row.cells.push_back({std::string(word), 1});
  }
}

void require_names_once(const TableSource& source, const std::vector<ControlPoint>& points) {
  std::set<std::string> seen;
  const auto hold = [&](std::size_t i) {  // a row each
    const ControlPoint& p = points[i];
    for (int k = 0; k < 3; ++k)
      if (std::abs(p.position(k)) > kFarthest)
        source.fail(source.table.rows[i], "point '" + p.name + "' is farther than 1 000 000 km");
    if (!seen.insert(p.name).second) source.fail(source.table.rows[i], "point '" + p.name + "' stands in it twice");
  };
  RowProblems problems;
  for (std::size_t i = 0; i < points.size(); ++i) problems.attempt([&] { hold(i); });
  problems.raise();
}

/// Millimetres without a unit look like metres: 2 for 2 mm is no accuracy of control.
void warn_of_coarse_sigmas(ControlTable& table) {
  std::size_t coarse = 0, given = 0;
  double example = 0;
  for (const ControlPoint& p : table.points)
    for (int k = 0; k < 3; ++k) {
      if (std::isnan(p.sigma(k))) continue;
      ++given;
      if (p.sigma(k) >= kCoarsest) ++coarse, example = p.sigma(k);
    }
  table.has_sigmas = given > 0;
  if (!table.sigmas_say_unit && given > 0 && 2 * coarse > given)
    table.warnings.push_back("standard deviations such as " + text::format_shortest(example) +
                             " are taken in metres, since no unit is given; name their columns sigma_mm or sigma_E_mm "
                             "if they are millimetres");
}

}  // namespace

void TableSource::fail(const CsvRow& row, const std::string& what) const {
  throw std::runtime_error(file + ":" + std::to_string(row.line) + ": " + what);
}

void RowProblems::raise() const {
  constexpr std::size_t most = 10;
  if (lines_.empty()) return;
  std::string text;
  for (std::size_t i = 0; i < std::min(lines_.size(), most); ++i) text += (i ? "\n" : "") + lines_[i];
  if (lines_.size() > most) text += "\nand " + std::to_string(lines_.size() - most) + " more rows of the table";
  throw std::runtime_error(text);
}

void TableSource::fail_header(const std::string& what) const {
  throw std::runtime_error(file + ":" + std::to_string(table.header_line) + ": " + what);
}

ControlTable parse_control_table(const std::string& text, const std::string& file, const ControlOptions& options) {
  TableSource source{file, options,
                     text::read_csv(without_remarks(text), point_column_names(), text::TitleRows::passed_over)};
  if (!source.table.doubtful.empty())
    source.fail(
        source.table.doubtful.front(),
        "found a row that begins with '" + source.table.doubtful.front().cells[0].text + "': " + text::kDoubtfulRow);
  tidy_rows(source.table);
  if (source.table.rows.empty() && source.table.header.empty())
    throw std::runtime_error(file + ": found no table; expected a CSV table with the columns " + kExpectedColumns);
  ControlTable result = source.table.header.empty() ? read_ordered_columns(source) : read_named_columns(source);
  if (source.table.titles > 0) result.notes.push_back(text::titles_left_out(source.table.titles));
  require_names_once(source, result.points);
  warn_of_coarse_sigmas(result);
  return result;
}

}  // namespace plumbline::control
