#include "tables.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "base/text/csv_table.hpp"
#include "geometry/packed_symmetric.hpp"
#include "geometry/relative_points.hpp"
#include "least_squares/problem/reliability.hpp"

namespace plumbline::survey {

namespace {

/// Rows of cells, joined as the format says; an unknown number is an empty cell.
class Table {
 public:
  explicit Table(const TableFormat& format) : format_(format) {}
  void text(const std::string& value) { cell(text::csv_field(value)); }
  void number(double value, int decimals) {
    if (!std::isfinite(value)) return cell("");
    std::array<char, 400> buffer;
    const auto end =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals);
    std::string digits(buffer.data(), end.ptr);
    if (digits[0] == '-' && digits.find_first_of("123456789") == std::string::npos) digits.erase(0, 1);
    if (const auto point = digits.find('.'); point != std::string::npos) digits[point] = format_.decimal;
    cell(digits);
  }
  void millimetres(double metres) { number(1e3 * metres, 3); }
  void end_row() { out_ += "\r\n", first_ = true; }
  std::string out() && { return std::move(out_); }

 private:
  void cell(const std::string& content) {
    if (!first_) out_ += format_.delimiter;
    first_ = false;
    out_ += content;
  }
  TableFormat format_;
  std::string out_;
  bool first_ = true;
};

std::set<std::string> stations_of(const SurveyNetworkT& network) {
  std::set<std::string> stations;
  for (const auto& s : network.set_ups) stations.insert(s->station);
  return stations;
}

/// "east", "north", "height", or "x_south", "y_west", "z_up" for a file with axes of its own.
std::array<std::string, 3> axis_names(const std::string& axes) {
  if (axes.empty() || axes == "en") return {"east", "north", "height"};
  const std::map<char, std::string> names = {{'e', "east"}, {'n', "north"}, {'w', "west"}, {'s', "south"}};
  return {"x_" + names.at(axes.at(0)), "y_" + names.at(axes.at(1)), "z_up"};
}

/// Components that do not exist, such as the height in a plane network, are NaN and count as 0.
template <typename Matrix>
Matrix known(const Matrix& m) {
  return m.array().isNaN().select(0.0, m);
}

Eigen::MatrixXd covariance_of(const PointsT& points) {
  Eigen::MatrixXd c = unpack_symmetric(points.covariance, 3 * points.points.size(), "the points");
  if (c.size() == 0) throw std::runtime_error("'points' has no covariance");
  return c;
}

void write_precision(Table& table, const Eigen::Matrix3d& covariance) {
  const ConfidenceEllipse plan =
      confidence_ellipse(covariance.topLeftCorner<2, 2>(), least_squares::confidence_factor(0.95, 2));
  table.millimetres(plan.major);
  table.millimetres(plan.minor);
  table.number(plan.azimuth * 200 / std::numbers::pi, 1);
  table.millimetres(least_squares::confidence_factor(0.95, 1) * std::sqrt(covariance(2, 2)));
}

std::pair<std::string, std::string> split_pair(const std::string& text) {
  const std::size_t at = text.find_first_of("; ");
  if (at == std::string::npos || at == 0 || at + 1 == text.size())
    throw std::runtime_error("the pair '" + text + "': expected two names, as in 'A B' or 'A;B'");
  return {text.substr(0, at), text.substr(text.find_first_not_of(' ', at + 1))};
}

std::vector<std::pair<int, int>> chosen_pairs(const SurveyNetworkT& network, const PointsT& points,
                                              const std::vector<std::string>& wanted, int neighbour_count) {
  std::map<std::string, int> index;
  for (std::size_t i = 0; i < points.points.size(); ++i) index[points.points[i]->id] = static_cast<int>(i);
  std::vector<std::pair<int, int>> pairs;
  for (const std::string& text : wanted) {
    const auto [a, b] = split_pair(text);
    for (const std::string& id : {a, b})
      if (!index.contains(id))
        throw std::runtime_error("the pair '" + text + "': no point '" + id + "' in the network");
    pairs.emplace_back(index[a], index[b]);
  }
  const std::set<std::string> stations = stations_of(network);
  std::vector<int> markers;
  for (const auto& [id, i] : index)
    if (!stations.contains(id)) markers.push_back(i);
  if (markers.size() < 2) {
    markers.clear();
    for (const auto& [id, i] : index) markers.push_back(i);
  }
  std::sort(markers.begin(), markers.end());
  std::vector<Eigen::Vector3d> positions;
  for (const int i : markers) positions.push_back(known(points.points[static_cast<std::size_t>(i)]->position));
  for (const auto& [a, b] : neighbours(positions, neighbour_count))
    pairs.emplace_back(markers[static_cast<std::size_t>(a)], markers[static_cast<std::size_t>(b)]);
  return pairs;
}

void header(Table& table, std::initializer_list<const char*> names) {
  for (const char* name : names) table.text(name);
}

}  // namespace

std::string coordinate_table(const SurveyNetworkT& network, const PointsT& points, const TableFormat& format) {
  if (network.points.size() != points.points.size())
    throw std::runtime_error("'network' has " + std::to_string(network.points.size()) + " points, 'points' " +
                             std::to_string(points.points.size()) + ": expected two outputs of one adjustment");
  const Eigen::MatrixXd covariance = covariance_of(points);
  const std::set<std::string> stations = stations_of(network);
  const std::set<std::string> datum(network.datum_points.begin(), network.datum_points.end());
  Table table(format);
  table.text("point");
  const auto axes = axis_names(network.axes);
  for (const std::string& axis : axes) table.text(axis + "_m");
  for (const std::string& axis : axes) table.text("sigma_" + axis + "_mm");
  header(table, {"plan_major_95_mm", "plan_minor_95_mm", "azimuth_major_gon", "height_95_mm", "kind", "datum"});
  table.end_row();
  for (std::size_t i = 0; i < network.points.size(); ++i) {
    const PointT& p = *network.points[i];
    table.text(p.id);
    for (int k = 0; k < 3; ++k) table.number(p.position[k], 5);
    for (int k = 0; k < 3; ++k) table.millimetres(p.sigma[k]);
    const auto at = static_cast<Eigen::Index>(3 * i);
    write_precision(table, covariance.block<3, 3>(at, at));
    table.text(stations.contains(p.id) ? "station" : "marker");
    table.text(datum.contains(p.id) ? "yes" : "no");
    table.end_row();
  }
  return std::move(table).out();
}

std::string relative_table(const SurveyNetworkT& network, const PointsT& points, const std::vector<std::string>& wanted,
                           int neighbour_count, const TableFormat& format) {
  const Eigen::MatrixXd covariance = covariance_of(points);
  Table table(format);
  header(table, {"from",
                 "to",
                 "d_east_m",
                 "d_north_m",
                 "d_height_m",
                 "distance_m",
                 "sigma_d_east_mm",
                 "sigma_d_north_mm",
                 "sigma_d_height_mm",
                 "sigma_distance_mm",
                 "plan_major_95_mm",
                 "plan_minor_95_mm",
                 "azimuth_major_gon",
                 "height_95_mm",
                 "cov_ee_mm2",
                 "cov_en_mm2",
                 "cov_eh_mm2",
                 "cov_nn_mm2",
                 "cov_nh_mm2",
                 "cov_hh_mm2"});
  table.end_row();
  for (const auto& [a, b] : chosen_pairs(network, points, wanted, neighbour_count)) {
    const PointT &from = *points.points[static_cast<std::size_t>(a)], &to = *points.points[static_cast<std::size_t>(b)];
    const Eigen::Vector3d d = to.position - from.position;
    const Eigen::Matrix3d c = relative_covariance(covariance, a, b);
    table.text(from.id);
    table.text(to.id);
    for (int k = 0; k < 3; ++k) table.number(d[k], 5);
    const Eigen::Vector3d sight = known(d);
    table.number(sight.norm(), 5);
    for (int k = 0; k < 3; ++k) table.millimetres(std::sqrt(c(k, k)));
    table.millimetres(std::sqrt(sight.dot(known(c) * sight)) / sight.norm());
    write_precision(table, c);
    for (const auto& [r, k] : {std::pair{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}) table.number(1e6 * c(r, k), 6);
    table.end_row();
  }
  return std::move(table).out();
}

}  // namespace plumbline::survey
