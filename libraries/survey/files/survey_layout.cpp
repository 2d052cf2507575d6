#include "survey/files/survey_layout.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include "base/text/csv_table.hpp"

namespace plumbline::survey {
namespace {

constexpr const char* kColumns =
    "kind, id, east_m, north_m, height_m and, where known, floor, column, facing_azimuth_deg, sees";

class LayoutReader {
 public:
  LayoutReader(std::string_view bytes, const std::string& file) : file_(file) {
    static const std::map<std::string, std::string> known = {
        {"kind", "kind"},     {"id", "id"},         {"name", "id"},
        {"east", "east"},     {"e", "east"},        {"x", "east"},
        {"north", "north"},   {"n", "north"},       {"y", "north"},
        {"height", "height"}, {"h", "height"},      {"z", "height"},
        {"floor", "floor"},   {"column", "column"}, {"facing_azimuth", "facing_azimuth"},
        {"sees", "sees"}};
    table_ = text::read_csv(bytes, known);
    if (table_.header.empty())
      throw SurveyReadError({file_, 1, 0}, "no header line", std::string("the columns ") + kColumns);
    for (const auto& row : table_.doubtful)
      fail(row.line, "a row that begins with '" + row.cells[0].text + "'", text::kDoubtfulRow);
    for (size_t i = 0; i < table_.header.size(); ++i) {
      const std::string& name = table_.header[i].name;
      const bool is_known = std::any_of(known.begin(), known.end(), [&](const auto& k) { return k.second == name; });
      if (!is_known) fail(table_.header_line, "the column '" + name + "'", std::string("the columns ") + kColumns);
      if (!columns_.emplace(name, i).second) fail(table_.header_line, "the column '" + name + "' twice", "it once");
      factors_[name] = factor(name, table_.header[i].unit);
    }
    for (const char* needed : {"kind", "id", "east", "north", "height"})
      if (!columns_.contains(needed))
        fail(table_.header_line, std::string("no column '") + needed + "'", std::string("the columns ") + kColumns);
  }

  SiteLayout read() {
    for (const auto& row : table_.rows) {
      const std::string kind = text::to_lower(text(row, "kind"));
      const std::string id = text(row, "id");
      if (id.empty()) fail(row.line, "no id", "a name in the column 'id'");
      if (!ids_.insert(id).second) fail(row.line, "'" + id + "' a second time", "one row for each point");
      if (kind == "marker")
        layout_.markers.push_back(
            {id, position(row), whole(row, "floor", 1), whole(row, "column", 0), number(row, "facing_azimuth", false)});
      else if (kind == "set_up")
        add_set_up(row, id);
      else
        fail(row.line, "'" + kind + "' in the column 'kind'", "marker or set_up");
    }
    if (layout_.markers.empty()) fail(table_.header_line, "no row of kind 'marker'", "one for each planned marker");
    if (layout_.set_ups.empty()) fail(table_.header_line, "no row of kind 'set_up'", "one for each planned set-up");
    expand();
    return std::move(layout_);
  }

 private:
  [[noreturn]] void fail(int line, const std::string& found, const std::string& expected, int column = 0) const {
    throw SurveyReadError({file_, line, column}, found, expected);
  }

  double factor(const std::string& name, const std::string& unit) const {
    static const std::map<std::string, double> lengths = {{"", 1}, {"m", 1}, {"mm", 1e-3}};
    static const std::map<std::string, double> angles = {
        {"deg", std::numbers::pi / 180}, {"gon", std::numbers::pi / 200}, {"rad", 1}};
    const bool angle = name == "facing_azimuth";
    if (!angle && name != "east" && name != "north" && name != "height") return 1;
    const auto& units = angle ? angles : lengths;
    const auto at = units.find(unit);
    if (at == units.end())
      fail(table_.header_line, "column '" + name + "' in '" + unit + "'", angle ? "_deg, _gon or _rad" : "_m or _mm");
    return at->second;
  }

  const text::CsvCell* cell(const text::CsvRow& row, const std::string& name) const {
    const auto at = columns_.find(name);
    return at == columns_.end() || at->second >= row.cells.size() ? nullptr : &row.cells[at->second];
  }
  std::string text(const text::CsvRow& row, const std::string& name) const {
    const auto* c = cell(row, name);
    return c ? c->text : "";
  }
  double number(const text::CsvRow& row, const std::string& name, bool required) const {
    const auto* c = cell(row, name);
    if (!c || c->text.empty()) {
      if (required) fail(row.line, "no value in the column '" + name + "'", "a number");
      return kNotGiven;
    }
    const auto value = table_.number(*c);
    if (!value) fail(row.line, "'" + c->text + "' in the column '" + name + "'", "a number", c->column);
    return *value * factors_.at(name);
  }
  int whole(const text::CsvRow& row, const std::string& name, int fallback) const {
    const double value = number(row, name, false);
    if (std::isnan(value)) return fallback;
    if (value != std::floor(value) || value < 0 || value > 1000)
      fail(row.line, "'" + text(row, name) + "' in the column '" + name + "'", "a whole number from 0 to 1000");
    return static_cast<int>(value);
  }
  Eigen::Vector3d position(const text::CsvRow& row) const {
    return {number(row, "east", true), number(row, "north", true), number(row, "height", true)};
  }

  void add_set_up(const text::CsvRow& row, const std::string& id) {
    LayoutSetUp set_up{id, position(row), {}};
    std::istringstream patterns(text(row, "sees"));
    for (std::string pattern; patterns >> pattern;) set_up.sees.push_back(pattern);
    lines_.push_back(row.line);
    layout_.set_ups.push_back(std::move(set_up));
  }

  void expand() {
    for (size_t s = 0; s < layout_.set_ups.size(); ++s) {
      std::vector<std::string> patterns = std::move(layout_.set_ups[s].sees), names;
      for (const std::string& pattern : patterns)
        if (std::none_of(layout_.markers.begin(), layout_.markers.end(),
                         [&](const auto& m) { return matches_pattern(m.id, pattern); }))
          fail(lines_[s], "'" + pattern + "' in the column 'sees'", "the name of a marker, or a pattern that fits one");
      for (const auto& m : layout_.markers)
        if (std::any_of(patterns.begin(), patterns.end(), [&](const auto& p) { return matches_pattern(m.id, p); }))
          names.push_back(m.id);
      layout_.set_ups[s].sees = std::move(names);
    }
  }

  std::string file_;
  text::CsvTable table_;
  std::map<std::string, size_t> columns_;
  std::map<std::string, double> factors_;
  std::set<std::string> ids_;
  std::vector<int> lines_;  // of the set-ups
  SiteLayout layout_;
};

}  // namespace

bool matches_pattern(std::string_view name, std::string_view pattern) {
  // Greedy with one point of return: the last star.
  size_t n = 0, p = 0, star = std::string_view::npos, restart = 0;
  while (n < name.size()) {
    if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n]) && pattern[p] != '*') {
      ++n, ++p;
    } else if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      restart = n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++restart;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

SiteLayout read_survey_layout(std::string_view bytes, const std::string& file) {
  return LayoutReader(bytes, file).read();
}

}  // namespace plumbline::survey
