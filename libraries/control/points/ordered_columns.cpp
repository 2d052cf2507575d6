#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "base/text/text.hpp"
#include "control/points/point_columns.hpp"
#include "control/points/table_source.hpp"
#include "geometry/median.hpp"

namespace plumbline::control {
namespace {

using text::CsvRow;

constexpr double kHighest = 20000;  // [m]

class OrderedColumns {
 public:
  explicit OrderedColumns(const TableSource& source)
      : source_(source), options_(source.options), table_(source.table) {}
  ControlTable read();

 private:
  [[noreturn]] void fail(const CsvRow& row, const std::string& what) const { source_.fail(row, what); }
  std::vector<std::string> words(const CsvRow& row) const;
  std::optional<double> parsed(const std::string& word) const;
  bool second_word_is_a_name() const;
  ControlPoint point(const CsvRow& row, bool named) const;
  void exchange_if_northing_stands_first();

  const TableSource& source_;
  const ControlOptions& options_;
  const text::CsvTable& table_;
  ControlTable result_;
};

std::optional<double> OrderedColumns::parsed(const std::string& word) const {
  return text::parse_number(word, table_.decimal);
}

/// The cells without empty ones at the end; where a row has fewer than a point needs, another delimiter than that of
/// the table stands in it.
std::vector<std::string> OrderedColumns::words(const CsvRow& row) const {
  std::vector<std::string> all;
  for (const auto& cell : row.cells) {
    all.push_back(cell.text);
    while (table_.delimiter == ' ' && (all.back().ends_with(',') || all.back().ends_with(';'))) all.back().pop_back();
  }
  while (!all.empty() && all.back().empty()) all.pop_back();
  const bool number_and_name = options_.has_second_names && !all.empty() && all[0].find(' ') != std::string::npos;
  if (all.size() >= 4 && !number_and_name) return all;
  std::vector<std::string> split;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all.size() >= 4 && i > 0) {
      split.push_back(all[i]);
      continue;
    }
    for (char& c : all[i])
      if (c == ';' || c == '\t' || (c == ',' && table_.decimal != ',')) c = ' ';
    for (const std::string_view word : text::split_blanks(all[i])) split.emplace_back(word);
  }
  return split;
}

/// Five numbers are a name, coordinates and a standard deviation, or a number, a number as name and coordinates: names
/// are numbers without a point in all lines, where not all coordinates are. Throws if nothing tells.
bool OrderedColumns::second_word_is_a_name() const {
  const CsvRow* undecided = nullptr;
  bool whole = true, fraction = false, only_last = true;
  for (const CsvRow& row : table_.rows) {
    const auto all = words(row);
    std::size_t numbers = 1;
    while (numbers < all.size() && parsed(all[numbers])) ++numbers;
    if (numbers != 5) continue;
    undecided = &row;
    const auto has_point = [&](const std::string& word) { return word.find(table_.decimal) != std::string::npos; };
    whole = whole && all[1].find_first_not_of("0123456789") == std::string::npos;
    fraction = fraction || has_point(all[2]) || has_point(all[3]);
    only_last = only_last && has_point(all[4]);
  }
  if (undecided == nullptr || !whole || fraction) return whole;
  if (!only_last) {
    std::string shown;
    for (const auto& word : words(*undecided)) shown += (shown.empty() ? "" : " ") + word;
    fail(*undecided, "found '" + shown +
                         "': is the second number a name or X? Say it in a line at the head of the file, "
                         "'id, name, X, Y, Z' or 'id, X, Y, Z, sigma'");
  }
  return false;
}

ControlPoint OrderedColumns::point(const CsvRow& row, bool named) const {
  const auto all = words(row);
  const auto run_from = [&](std::size_t first) {
    std::size_t end = first;
    while (end < all.size() && parsed(all[end])) ++end;
    return end - first;
  };
  std::size_t labels = 0;
  for (const std::size_t l : {std::size_t{1}, std::size_t{2}}) {
    const std::size_t numbers = all.size() > l ? run_from(l) : 0;
    if (numbers != 3 && numbers != 4 && numbers != 6) continue;
    if (labels == 0 || named || !parsed(all[1])) labels = l;
  }
  if (labels == 0)
    fail(row, "found " + std::to_string(all.size()) + " columns and no header (" + table_.dialect() +
                  "); expected a name, E, N, H and perhaps standard deviations, or a header with the columns " +
                  kExpectedColumns);
  const std::size_t numbers = run_from(labels);
  std::array<double, 6> value{};
  for (std::size_t i = 0; i < numbers; ++i) {
    if (i < 3 && is_shortened(all[labels + i])) fail(row, "found '" + all[labels + i] + "'" + kShortened);
    value[i] = *parsed(all[labels + i]);
  }
  ControlPoint p{all[0], {value[0], value[1], value[2]}, Eigen::Vector3d::Constant(kNotGiven), false};
  if (labels == 2) p.second_name = all[1];
  if (std::abs(p.position.z()) > kHighest)
    fail(row,
         "found the height " + all[labels + 2] +
             " in a table without a header; expected metres: another column may be in front (a zone), or these are "
             "geocentric coordinates. Name the columns");
  if (numbers == 4) p.sigma.setConstant(value[3]);
  if (numbers == 6) p.sigma = {value[3], value[4], value[5]};
  if (numbers > 3 && p.sigma.minCoeff() < 0) fail(row, "point '" + p.name + "' has a negative standard deviation");
  if (numbers == 4 && p.sigma.x() >= 1)
    fail(row, "found a fourth number, " + all[labels + 3] +
                  ", in a table without a header: is it a standard deviation [m] or a code? Name the columns");
  return p;
}

void OrderedColumns::exchange_if_northing_stands_first() {
  std::vector<double> first, second;
  for (const ControlPoint& p : result_.points) first.push_back(p.position.x()), second.push_back(p.position.y());
  const double a = upper_median(std::move(first)), b = upper_median(std::move(second));
  const bool exchanged =
      options_.axes == Axes::x_north || (options_.axes == Axes::as_named && is_northing_beside(a, b));
  if (options_.axes == Axes::as_named)
    result_.axes = std::string("the table has no header: columns are taken as name, ") +
                   (exchanged ? "N, E, H, since only so the values are coordinates of a map" : "E, N, H") + " (" +
                   table_.dialect() + "); a first line with their names says it";
  if (!exchanged) return;
  for (ControlPoint& p : result_.points) std::swap(p.position.x(), p.position.y()), std::swap(p.sigma.x(), p.sigma.y());
}

ControlTable OrderedColumns::read() {
  const bool named = second_word_is_a_name();
  bool text_behind = false;
  const auto read_row = [&](const CsvRow& row) {
    ControlPoint p = point(row, named);
    text_behind = text_behind || !parsed(words(row).back());
    if (p.name.empty()) fail(row, "found no name, expected that of a point");
    if (!options_.has_second_names && !p.second_name.empty())
      fail(row, "found two names, '" + p.name + "' and '" + p.second_name +
                    "', in a table without a header; expected one, or a header that says which is the point's");
    result_.points.push_back(std::move(p));
  };
  RowProblems problems;
  for (const CsvRow& row : table_.rows) problems.attempt([&] { read_row(row); });
  problems.raise();
  if (text_behind) result_.notes.push_back("text behind the numbers is not used");
  exchange_if_northing_stands_first();
  return std::move(result_);
}

}  // namespace

ControlTable read_ordered_columns(const TableSource& source) { return OrderedColumns(source).read(); }

}  // namespace plumbline::control
