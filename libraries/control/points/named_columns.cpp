#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "control/points/point_columns.hpp"
#include "control/points/table_source.hpp"

namespace plumbline::control {
namespace {

using text::CsvRow;

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t most = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i > 0 ? ", " : "") + text::quoted(names[i]);
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

class NamedColumns {
 public:
  explicit NamedColumns(const TableSource& source) : source_(source), options_(source.options), table_(source.table) {}
  ControlTable read();

 private:
  struct Column {
    std::size_t index = 0;
    double unit = 1;
    std::string written;
    bool says_unit = false;
  };

  [[noreturn]] void fail(const CsvRow& row, const std::string& what) const { source_.fail(row, what); }
  [[noreturn]] void fail_header(const std::string& what) const { source_.fail_header(what); }
  void take_columns();
  void take_column(std::size_t index, const text::CsvHeaderCell& cell);
  void take_axes();
  void require_places() const;
  void require_units() const;
  void refuse_thousands();
  void tell_feet();
  void rename(const std::string& from, const std::string& to);
  bool has(const std::string& name) const { return columns_.count(name) > 0; }
  std::string cell(const CsvRow& row, const std::string& name) const;
  double number(const CsvRow& row, const std::string& name) const;
  ControlPoint point(const CsvRow& row) const;
  void read_sigmas(const CsvRow& row, ControlPoint& p) const;
  void read_covariance(const CsvRow& row, ControlPoint& p) const;

  const TableSource& source_;
  const ControlOptions& options_;
  const text::CsvTable& table_;
  std::map<std::string, Column> columns_;
  ControlTable result_;
};

void NamedColumns::take_column(std::size_t index, const text::CsvHeaderCell& cell) {
  const bool length = cell.name.size() == 1 || cell.name.starts_with("sigma");
  const bool squared = cell.name.starts_with("cov_");
  double unit = squared && cell.unit == "mm2"                         ? 1e-6
                : squared && (cell.unit == "m2" || cell.unit.empty()) ? 1
                                                                      : kNotGiven;
  if (!squared) unit = length ? metres_in(cell.unit) : 1;
  if (std::isnan(unit))
    fail_header("the column '" + cell.written + "' is in '" + cell.unit + "', expected " +
                (squared ? "m2 or mm2" : "m, cm, mm, ft or usft"));
  std::string name = cell.name;
  if (name == "id" && has("id") && options_.has_second_names && !has("second_name")) name = "second_name";
  if (const auto [at, is_new] = columns_.insert({name, {index, unit, cell.written, !cell.unit.empty()}}); !is_new) {
    if (name == "code" || name == "description" || name == "role") {
      result_.notes.push_back("the second column '" + cell.written + "' is not used");
      return;
    }
    fail_header("two columns say the same: " + text::quoted(at->second.written) + " and " + text::quoted(cell.written) +
                "; expected one" + (name == "id" ? ": rename that which is not the point's name" : ""));
  }
}

void NamedColumns::take_columns() {
  const auto& names = point_column_names();
  std::vector<std::string> unused;
  for (std::size_t i = 0; i < table_.header.size(); ++i) {
    const text::CsvHeaderCell& cell = table_.header[i];
    const bool known =
        std::any_of(names.begin(), names.end(), [&](const auto& entry) { return entry.second == cell.name; });
    if (known)
      take_column(i, cell);
    else if (looks_like_an_accuracy(cell.written))
      fail_header("the column '" + cell.written + "' looks like an accuracy and is none of those known; expected " +
                  kExpectedColumns + ", each a standard deviation of one coordinate");
    else if (!cell.written.empty())
      unused.push_back(cell.written);
  }
  for (const char* name : {"code", "description"})
    if (has(name)) unused.push_back(columns_.at(name).written);
  if (!unused.empty()) result_.notes.push_back("columns that are not used: " + list_of(unused));
  if (has("latitude") || has("longitude"))
    fail_header(
        "found latitudes and longitudes, expected coordinates of a plane in metres (E, N): project them before");
}

void NamedColumns::rename(const std::string& from, const std::string& to) {
  if (!has(from)) return;
  if (has(to))
    fail_header("two columns say the same: " + text::quoted(columns_.at(from).written) + " and " +
                text::quoted(columns_.at(to).written) + "; expected one");
  columns_[to] = columns_.at(from);
  columns_.erase(from);
}

void NamedColumns::take_axes() {
  const bool xy = has("x") && has("y"), en = has("e") && has("n");
  if (xy && en) {
    result_.notes.push_back("columns X and Y are not used, E and N are");
    for (const char* name : {"x", "y"}) columns_.erase(name);
  }
  bool y_is_east = false;
  if (has("x") && has("y")) {
    if (options_.axes == Axes::as_named) {
      const double height = has("h") ? typical_value(table_, columns_.at("h").index, columns_.at("h").unit) : 0;
      const PlanAxes axes = axes_of_xy(table_.header, columns_.at("y").index < columns_.at("x").index,
                                       typical_value(table_, columns_.at("x").index, columns_.at("x").unit),
                                       typical_value(table_, columns_.at("y").index, columns_.at("y").unit), height);
      if (!axes.refusal.empty())
        fail_header("found " + axes.refusal +
                    ", expected columns that say which is which: E and N, or Rechtswert and Hochwert");
      y_is_east = axes.y_is_east;
      result_.axes = std::string("columns X and Y are taken as ") +
                     (y_is_east ? "Y = east and X = north" : "X = east and Y = north") + " (" + axes.reason +
                     "); if that is wrong, name them E and N";
    } else {
      y_is_east = options_.axes == Axes::x_north;
    }
  } else if (options_.axes == Axes::x_north) {
    throw std::runtime_error(source_.file +
                             ": axes is x_north, but the file says itself which coordinate is east; leave axes out");
  }
  rename("x", y_is_east ? "n" : "e");
  rename("y", y_is_east ? "e" : "n");
  rename("sigma_x", y_is_east ? "sigma_n" : "sigma_e");
  rename("sigma_y", y_is_east ? "sigma_e" : "sigma_n");
  if (y_is_east && has("cov_ee") && columns_.at("cov_ee").written == "cov_xx") {
    std::swap(columns_["cov_ee"], columns_["cov_nn"]);
    std::swap(columns_["cov_eh"], columns_["cov_nh"]);
    for (const char* name : {"cov_ee", "cov_nn", "cov_eh", "cov_nh"})
      if (columns_.at(name).written.empty()) columns_.erase(name);
  }
}

void NamedColumns::require_places() const {
  const auto missing = [&](const std::string& what) {
    throw std::runtime_error(source_.file + ": the column '" + what + "' is missing; expected " + kExpectedColumns);
  };
  if (!has("id")) missing("id");
  if (has("e") != has("n")) missing(has("e") ? "N" : "E");
  if (!has("e") && !has("h")) missing("E");
  const bool any = has("sigma_e") || has("sigma_n") || has("sigma_h") || has("sigma_plan");
  const bool e = has("sigma_e") || has("sigma_plan") || has("sigma"),
             n = has("sigma_n") || has("sigma_plan") || has("sigma");
  const bool h = has("sigma_h") || has("sigma");
  if (any && ((has("e") && !(e && n)) || (has("h") && !h)))
    fail_header(
        "standard deviations are given for some of x, y and z only; expected sigma, or sigma_E, sigma_N and "
        "sigma_H");
  if (has("sigma_plan") && (has("sigma_e") || has("sigma_n")))
    fail_header("standard deviations of the plan are given twice, in '" + columns_.at("sigma_plan").written +
                "' and one by one; expected one of them");
}

std::string NamedColumns::cell(const CsvRow& row, const std::string& name) const {
  const auto found = columns_.find(name);
  if (found == columns_.end() || found->second.index >= row.cells.size()) return {};
  return row.cells[found->second.index].text;
}

double NamedColumns::number(const CsvRow& row, const std::string& name) const {
  const std::string text = cell(row, name);
  if (text.empty()) return kNotGiven;
  const Column& column = columns_.at(name);
  const auto value = table_.number(row.cells[column.index]);
  if (!value) fail(row, "'" + column.written + "' is '" + text + "', expected a number (" + table_.dialect() + ")");
  return column.unit * *value;
}

void NamedColumns::read_covariance(const CsvRow& row, ControlPoint& p) const {
  const char* axes = "enh";
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) {
      const double value = number(row, std::string("cov_") + axes[i] + axes[j]);
      matrix(i, j) = matrix(j, i) = std::isnan(value) && i != j ? 0 : value;
    }
  for (int i = 0; i < 3; ++i) {
    if (std::isnan(p.position(i))) continue;
    if (!(matrix(i, i) > 0)) fail(row, "point '" + p.name + "' lacks a variance above zero for " + "ENH"[i]);
    p.sigma(i) = std::sqrt(matrix(i, i));
  }
  const int pairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (int k = 0; k < 3; ++k) {
    const double scale = p.sigma(pairs[k][0]) * p.sigma(pairs[k][1]);
    p.correlation(k) = scale > 0 ? matrix(pairs[k][0], pairs[k][1]) / scale : 0;
  }
  const Eigen::Vector3d& r = p.correlation;
  const double determinant = 1 + 2 * r(0) * r(1) * r(2) - r.squaredNorm();
  if (!(r.cwiseAbs().maxCoeff() < 1) || !(determinant > 0))
    fail(row, "point '" + p.name + "' has a covariance that is not positive definite");
}

void NamedColumns::read_sigmas(const CsvRow& row, ControlPoint& p) const {
  if (has("cov_ee") || has("cov_nn") || has("cov_hh")) return read_covariance(row, p);
  const char* axes[] = {"sigma_e", "sigma_n", "sigma_h"};
  int given = 0, wanted = 0;
  for (int k = 0; k < 3; ++k) {
    double sigma = number(row, axes[k]);
    if (std::isnan(sigma) && k < 2) sigma = number(row, "sigma_plan");
    if (std::isnan(sigma)) sigma = number(row, "sigma");
    if (sigma < 0) fail(row, "point '" + p.name + "' has a negative standard deviation");
    if (std::isnan(p.position(k))) continue;
    p.sigma(k) = sigma;
    ++wanted, given += !std::isnan(sigma);
  }
  if (given > 0 && given < wanted)
    fail(row, "point '" + p.name + "' lacks a standard deviation for some of E, N and H");
}

ControlPoint NamedColumns::point(const CsvRow& row) const {
  ControlPoint p{cell(row, "id"),
                 {number(row, "e"), number(row, "n"), number(row, "h")},
                 Eigen::Vector3d::Constant(kNotGiven),
                 false};
  p.second_name = cell(row, "second_name");
  if (p.name.empty()) fail(row, "found no name, expected that of a point");
  for (const char* name : {"e", "n", "h"})
    if (is_shortened(cell(row, name)))
      fail(row, "'" + columns_.at(name).written + "' is '" + cell(row, name) + "'" + kShortened);
  if (std::isnan(p.position.x()) != std::isnan(p.position.y()))
    fail(row, "point '" + p.name + "' has one coordinate of the plan, expected E and N or neither");
  if (p.position.array().isNaN().all()) fail(row, "point '" + p.name + "' has no coordinates");
  const std::string role = text::to_lower(cell(row, "role"));
  p.check = role == "check";
  if (!role.empty() && role != "check" && role != "control")
    fail(row, "'role' is '" + role + "', expected control or check");
  read_sigmas(row, p);
  return p;
}

/// Of a sigma without a unit beside coordinates in feet or millimetres nobody knows what it is in.
void NamedColumns::require_units() const {
  const bool coordinates_say_unit = std::any_of(columns_.begin(), columns_.end(), [](const auto& c) {
    return c.first.size() == 1 && c.second.says_unit && c.second.unit != 1;
  });
  for (const auto& [name, column] : columns_)
    if (name.starts_with("sigma") && !column.says_unit && coordinates_say_unit)
      fail_header("the column '" + column.written +
                  "' has no unit and the coordinates are not in metres; say it, as in sigma_mm");
}

/// "1,000" is a metre or a kilometre; which of the two the other numbers may say.
void NamedColumns::refuse_thousands() {
  std::vector<std::size_t> places;
  for (const char* name : {"e", "n", "h"})
    if (has(name)) places.push_back(columns_.at(name).index);
  const text::Thousands found = text::thousands_of(table_, places);
  if (found.example.empty()) return;
  if (found.integers)
    fail_header("found coordinates such as '" + found.example + "' beside whole numbers: '" + table_.decimal +
                "' may separate decimals or thousands; expected decimals in all of them, or no separator of thousands");
  result_.warnings.push_back("coordinates such as '" + found.example + "' are read with '" + table_.decimal +
                             "' as the decimal separator, not as thousands: nothing in the table tells");
}

/// Two feet differ by 2 ppm, of coordinates of a map by metres.
void NamedColumns::tell_feet() {
  constexpr double kDifference = 1200.0 / 3937.0 / 0.3048 - 1, kLeast = 0.001;  // [m]
  for (const char* name : {"e", "n", "h"}) {
    if (!has(name) || columns_.at(name).unit != 0.3048) continue;
    double largest = 0;
    for (const CsvRow& row : table_.rows)
      if (const double value = number(row, name); std::isfinite(value)) largest = std::max(largest, std::abs(value));
    std::string text = "'" + columns_.at(name).written + "' is taken in feet of 0.3048 m";
    if (largest * kDifference > kLeast)
      text += "; in US survey feet, as maps of the USA have them, the points lie " +
              text::format_fixed(largest * kDifference, largest * kDifference > 0.1 ? 1 : 3) +
              " m elsewhere: name the column " + columns_.at(name).written + "_usft then";
    result_.notes.push_back(text);
  }
}

ControlTable NamedColumns::read() {
  take_columns();
  take_axes();
  require_places();
  require_units();
  if (table_.rows.empty()) fail_header("found a header and no row under it");
  refuse_thousands();
  for (const auto& [name, column] : columns_)
    if (name.starts_with("sigma") || name.starts_with("cov_"))
      result_.sigmas_say_unit = result_.sigmas_say_unit || column.says_unit;
  const auto read_row = [&](const CsvRow& row) {
    for (std::size_t i = table_.header.size(); i < row.cells.size(); ++i)
      if (!row.cells[i].text.empty())
        fail(row, "found " + std::to_string(row.cells.size()) + " cells under a header of " +
                      std::to_string(table_.header.size()) + " (" + table_.dialect() + ")");
    result_.points.push_back(point(row));
  };
  RowProblems problems;
  for (const CsvRow& row : table_.rows) problems.attempt([&] { read_row(row); });
  problems.raise();
  tell_feet();
  return std::move(result_);
}

}  // namespace

ControlTable read_named_columns(const TableSource& source) { return NamedColumns(source).read(); }

}  // namespace plumbline::control
