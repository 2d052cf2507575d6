#include "building/judgement/tolerance_classes.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>

#include "base/text/csv_table.hpp"

namespace plumbline::judgement {
namespace {

constexpr const char* kColumns =
    "class, select and at least one of vertical_mm, horizontal_mm, in_plane_mm, out_of_plane_mm, space_mm, joint_mm";

const std::map<std::string, std::string>& column_names() {
  static const std::map<std::string, std::string> names = {{"class", "class"},
                                                           {"klasse", "class"},
                                                           {"select", "select"},
                                                           {"selection", "select"},
                                                           {"auswahl", "select"},
                                                           {"note", "note"},
                                                           {"remark", "note"},
                                                           {"bemerkung", "note"},
                                                           {"optional", "optional"},
                                                           {"vertical", "vertical"},
                                                           {"vertikal", "vertical"},
                                                           {"horizontal", "horizontal"},
                                                           {"in_plane", "in_plane"},
                                                           {"in_ebene", "in_plane"},
                                                           {"out_of_plane", "out_of_plane"},
                                                           {"aus_ebene", "out_of_plane"},
                                                           {"space", "space"},
                                                           {"raum", "space"},
                                                           {"joint", "joint"},
                                                           {"fuge", "joint"}};
  return names;
}

bool is_axis(const std::string& name) {
  return std::any_of(std::begin(kAxes), std::end(kAxes), [&](Axis axis) { return name == name_of(axis); });
}

/// A cell with the decimal point that rules have; nothing if it is neither a length nor two sides.
std::optional<std::string> length_of(const text::CsvCell& cell, char decimal) {
  const std::size_t slash = cell.text.find('/');
  for (const std::string& part :
       {cell.text.substr(0, slash), slash == std::string::npos ? "0" : cell.text.substr(slash + 1)})
    if (!text::parse_number(part, decimal)) return {};
  const std::string_view trimmed = text::trim(cell.text);
  if (slash == std::string::npos && (trimmed[0] == '-' || trimmed[0] == '+')) return {};
  std::string written = cell.text;
  std::replace(written.begin(), written.end(), decimal, '.');
  return written;
}

class ClassTable {
 public:
  ClassTable(std::string_view csv, std::string shown)
      : shown_(std::move(shown)), table_(text::read_csv(csv, column_names())) {}

  std::vector<ToleranceRule> rules() {
    if (table_.header.empty())
      throw std::runtime_error(shown_ + ":1: found no header line, expected the columns " + kColumns);
    take_header();
    raise();
    for (const text::CsvRow& row : table_.doubtful)
      wrong(row.line, "found a row that begins with '" + row.cells[0].text + "': " + text::kDoubtfulRow);
    for (const text::CsvRow& row : table_.rows) take_row(row);
    if (table_.rows.empty() && wrong_.empty()) wrong(table_.header_line, "found a header and no row under it");
    raise();
    return std::move(rules_);
  }

 private:
  void wrong(int line, const std::string& what) { wrong_.push_back(shown_ + ":" + std::to_string(line) + ": " + what); }

  void raise() const {
    constexpr std::size_t kMost = 25;
    if (wrong_.empty()) return;
    std::string text;
    for (std::size_t i = 0; i < std::min(kMost, wrong_.size()); ++i) text += (i > 0 ? "\n" : "") + wrong_[i];
    if (wrong_.size() > kMost) text += "\nand " + std::to_string(wrong_.size() - kMost) + " more of the kind";
    throw std::runtime_error(text);
  }

  /// A column that nothing knows may be a tolerance that nothing would hold anybody to: it is refused.
  void take_header() {
    for (std::size_t i = 0; i < table_.header.size(); ++i) {
      const auto& [name, unit, written] = table_.header[i];
      if (written.empty() && is_empty(i)) continue;  // spreadsheets end lines with delimiters
      const bool axis = is_axis(name);
      if (!axis && name != "class" && name != "select" && name != "note" && name != "optional")
        wrong(table_.header_line, "unknown column '" + written + "', expected " + kColumns + ", note, optional");
      else if (axis && unit != "mm" && unit != "m")
        wrong(table_.header_line, "column '" + written + "' has " +
                                      (unit.empty() ? std::string("no unit") : "the unit '" + unit + "'") +
                                      ", expected it behind the name, mm or m: " + name + "_mm");
      else if (!columns_.emplace(name, i).second)
        wrong(table_.header_line, "the column '" + name + "' stands here twice");
    }
    for (const char* needed : {"class", "select"})
      if (!columns_.contains(needed))
        wrong(table_.header_line, std::string("found no column '") + needed + "', expected " + kColumns);
  }

  bool is_empty(std::size_t column) const {
    return std::all_of(table_.rows.begin(), table_.rows.end(),
                       [&](const auto& row) { return column >= row.cells.size() || row.cells[column].text.empty(); });
  }

  const text::CsvCell* cell(const text::CsvRow& row, const std::string& column) const {
    const auto at = columns_.find(column);
    if (at == columns_.end() || at->second >= row.cells.size() || row.cells[at->second].text.empty()) return nullptr;
    return &row.cells[at->second];
  }

  /// Whether a building may have nothing of this row.
  bool is_optional(const text::CsvRow& row) {
    const text::CsvCell* given = cell(row, "optional");
    if (!given || given->text == "no" || given->text == "nein") return false;
    if (given->text != "yes" && given->text != "ja" && given->text != "x")
      wrong(row.line, "column 'optional' is '" + given->text + "', expected yes, no or nothing");
    return true;
  }

  void take_row(const text::CsvRow& row) {
    const text::CsvCell *named = cell(row, "class"), *select = cell(row, "select");
    const std::size_t before = wrong_.size();
    if (row.cells.size() > table_.header.size())
      wrong(row.line, "found " + std::to_string(row.cells.size()) + " cells under a header of " +
                          std::to_string(table_.header.size()) + " columns (" + table_.dialect() +
                          "); a cell that holds the delimiter is put in quotes");
    if (!named) wrong(row.line, "column 'class' is empty, expected the name of the class");
    if (!select)
      wrong(row.line,
            "column 'select' is empty, expected which elements, such as class=IfcPlate & storey=Level 2, or *");
    const bool optional = is_optional(row);
    std::string lengths;
    for (const Axis axis : kAxes) {
      const text::CsvCell* given = cell(row, name_of(axis));
      if (!given) continue;
      const auto length = length_of(*given, table_.decimal);
      const std::string unit = table_.header[columns_.at(name_of(axis))].unit;
      if (!length)
        wrong(row.line, std::string("column '") + name_of(axis) + "_" + unit + "' is '" + given->text +
                            "', expected a length in " + unit + ", such as " + (unit == "mm" ? "3 or +5/-2" : "0.003") +
                            "; 0: not judged; empty: not said (" + table_.dialect() + ")");
      else
        lengths += (lengths.empty() ? "" : ", ") + std::string(name_of(axis)) + "=" + *length + unit;
    }
    if (lengths.empty() && wrong_.size() == before)
      wrong(row.line, "found no tolerance in this row, expected one at least");
    if (wrong_.size() > before) return;
    try {
      ToleranceRule rule = parse_rule(select->text + ": " + lengths);
      rule.text = shown_ + ":" + std::to_string(row.line) + ", class " + named->text + ": " + rule.text;
      rule.of_table = true, rule.optional = optional;
      rules_.push_back(std::move(rule));
    } catch (const std::runtime_error& error) {
      wrong(row.line, error.what());
    }
  }

  std::string shown_;
  text::CsvTable table_;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::string> wrong_;
  std::vector<ToleranceRule> rules_;
};

}  // namespace

bool is_table_of_tolerances(std::string_view csv) {
  bool select = false, axis = false;
  for (const auto& column : text::read_csv(csv, column_names()).header) {
    select = select || column.name == "select";
    axis = axis || is_axis(column.name);
  }
  return select && axis;
}

std::vector<ToleranceRule> parse_tolerance_classes(std::string_view csv, const std::string& shown) {
  if (csv.empty()) return {};
  return ClassTable(csv, shown).rules();
}

}  // namespace plumbline::judgement
