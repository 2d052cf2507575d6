// Staked points of layout tools as reports.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "base/text/words.hpp"
#include "loop/fit/facade.hpp"
#include "loop/job/layout_files.hpp"
#include "loop/job/staked_columns.hpp"
#include "loop/state/date.hpp"

namespace plumbline::loop {
namespace {

/// "# Units: metres", "# Units = m", "# coordinates in units [m]". Throws std::runtime_error if a comment says that
/// they are others. What is called a unit and is none of lengths ("Total station unit: TS16") says nothing.
void look_at_units(std::string_view comment, std::size_t line, const std::string& source) {
  static const std::regex said("(^[#/;\\s]*|\\b)units?\\b(?: of)?[\\s:=(\\[]*([^\\])]*)");
  static const std::regex metres("m(et(re|er)s?)?\\b.*"),
      others(
          "(us|u\\.s\\.|survey|international|ft|sft|feet|foot|[mck]m|(milli|centi|kilo)met(re|er)s?|in|inch(es)?|yards?"
          ")\\b.*");
  const std::string words = text::to_lower(comment.substr(0, 200));  // the expressions go deeper with each letter
  std::smatch found;
  if (!std::regex_search(words, found, said)) return;
  const bool heads = text::trim(found.prefix().str() + found[1].str()).find_first_not_of("#/; ") == std::string::npos;
  const std::string unit(text::trim(found[2].str()));
  if (std::regex_match(unit, metres) || (!std::regex_match(unit, others) && !heads)) return;
  throw std::runtime_error(source + ":" + std::to_string(line) + ": its units are '" + unit +
                           "'; expected metres: export it in metres");
}

/// Where ';' separates cells a comma is that of a decimal fraction.
std::optional<double> staked_number(std::string_view cell, LayoutFormat format) {
  const std::string_view text = text::trim(cell);
  const bool comma = format == LayoutFormat::hilti && text.find(',') != std::string_view::npos &&
                     text.find('.') == std::string_view::npos;
  const auto number = text::parse_number(text, comma ? ',' : '.');
  return number && std::isfinite(*number) ? number : std::nullopt;
}

/// A point of the file.
struct StakedRow {
  std::size_t line;
  std::string name, at;
  Eigen::Vector3d place;
};

/// Throws std::runtime_error that says why a line is no point.
StakedRow row_of(const std::vector<std::string_view>& cells, std::size_t line, const StakedColumns& columns,
                 LayoutFormat format) {
  if (cells.size() <= columns.most())
    throw std::runtime_error("found " + std::to_string(cells.size()) +
                             " columns, expected a name and three coordinates");
  StakedRow row{line, std::string(text::trim(cells[columns.name])), {}, {}};
  int k = 0;
  for (const std::size_t column : {columns.east, columns.north, columns.height}) {
    const auto number = staked_number(cells[column], format);
    if (!number) throw std::runtime_error("the coordinates of '" + row.name + "' are no numbers");
    row.place[k++] = *number;
  }
  if (columns.date < cells.size()) row.at = std::string(text::trim(cells[columns.date]));
  return row;
}

/// Of one point's rows the one that counts: they say the same, or one is later than all others; else none.
std::optional<StakedRow> last_of(const std::vector<StakedRow>& rows) {
  constexpr double kSame = 1e-4;  // what files are rounded to [m]
  const bool agree = std::all_of(rows.begin(), rows.end(), [&](const StakedRow& row) {
    return (row.place - rows.front().place).cwiseAbs().maxCoeff() <= kSame && row.at == rows.front().at;
  });
  if (agree) return rows.front();
  const StakedRow* last = nullptr;
  double newest = 0;
  for (const StakedRow& row : rows) {
    const auto seconds = seconds_of(row.at);
    if (!seconds || (last && *seconds == newest)) return std::nullopt;
    if (!last || *seconds > newest) last = &row, newest = *seconds;
  }
  return *last;
}

/// Each point once, in the order of the file. Rows that do not count are refused with their lines.
std::vector<StakedRow> each_once(const std::vector<StakedRow>& rows, const std::string& source,
                                 std::vector<std::string>& refused) {
  std::map<std::string, std::vector<StakedRow>> of_name;
  for (const StakedRow& row : rows) of_name[row.name].push_back(row);
  std::vector<StakedRow> out;
  for (const StakedRow& row : rows) {
    const std::vector<StakedRow>& same = of_name.at(row.name);
    const auto last = last_of(same);
    if (last && last->line == row.line) out.push_back(row);
    if (same.size() == 1 || row.line == same.front().line) continue;
    const double off = (row.place - same.front().place).norm();
    const bool is_dated = std::any_of(same.begin(), same.end(), [&](const auto& r) { return r.at != row.at; });
    refused.push_back(source + ":" + std::to_string(row.line) + ": '" + row.name + "' stands in line " +
                      std::to_string(same.front().line) + " too, " + text::millimetres(off) + " from here; " +
                      (last ? "line " + std::to_string(last->line) + " is taken, " +
                                  (is_dated ? "the last by its date" : "they say the same")
                            : "no date says which is the last one, and none is taken: keep that row alone"));
  }
  return out;
}

/// Reads a file line by line: heads, comments, points.
class StakedReader {
 public:
  StakedReader(LayoutFormat format, const std::string& source, ActualsT& out)
      : format_(format), source_(source), out_(out) {
    if (format == LayoutFormat::trimble) columns_.north = 1, columns_.east = 2;
  }

  void read(const text::Line& line) {
    if (text::trim(line.text).empty()) return;
    // Some writers put what they are before the head.
    if (text::trim(line.text).front() == '#') return look_at_units(line.text, line.number, source_);
    const auto split = text::split(line.text, format_ == LayoutFormat::hilti ? ';' : ',');
    const std::vector<std::string_view> cells(split.begin(), split.end());
    // A first point with one coordinate that cannot be read is no head.
    const bool is_head = (std::exchange(first_, false) || names_all_coordinates(cells)) &&
                         std::none_of(cells.begin() + 1, cells.end(),
                                      [&](std::string_view cell) { return staked_number(cell, format_).has_value(); });
    if (is_head) return read_head(cells, source_, columns_, out_.ignored);
    try {
      rows_.push_back(row_of(cells, line.number, columns_, format_));
    } catch (const std::runtime_error& error) {
      out_.refused.push_back(source_ + ":" + std::to_string(line.number) + ": " + error.what());
    }
  }

  std::vector<StakedRow> points() { return each_once(rows_, source_, out_.refused); }

 private:
  LayoutFormat format_;
  const std::string& source_;
  ActualsT& out_;
  StakedColumns columns_;
  bool first_ = true;
  std::vector<StakedRow> rows_;
};

}  // namespace

ActualsT read_staked(const std::string& text, LayoutFormat format, const std::string& source,
                     const SurveyLink& survey) {
  ActualsT out;
  out.sources.push_back(source);
  const std::string decoded = text::decode_text(text).text;
  StakedReader reader(format, source, out);
  for (const text::Line& line : text::split_lines(decoded)) reader.read(line);
  for (const StakedRow& row : reader.points()) {
    auto actual = std::make_unique<ActualT>();
    actual->item = row.name, actual->outcome = "done", actual->by = source, actual->at = row.at;
    actual->source = source + ":" + std::to_string(row.line), actual->measured = row.place;
    actual->sigma.setConstant(kUnknown), actual->setting.setConstant(kUnknown);
    bring_to_building(*actual, survey);
    out.items.push_back(std::move(actual));
  }
  return out;
}

}  // namespace plumbline::loop
