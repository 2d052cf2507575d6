#include "tables.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>

#include "base/text/csv_table.hpp"
#include "geometry/packed_symmetric.hpp"
#include "geometry/relative_points.hpp"
#include "least_squares/problem/reliability.hpp"
#include "plumbline/stop.hpp"

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

/// Of points and of differences of points: from their joint covariance, or of a large network what it has of them.
class Covariances {
 public:
  Covariances(const SurveyNetworkT& network, const PointsT& points)
      : points_(points), joint_(unpack_symmetric(points.covariance, 3 * points.points.size(), "the points")) {
    if (joint_.size() > 0) return;
    if (network.covariances.empty()) throw std::runtime_error("'points' has no covariance");
    std::map<std::string, int> index;
    for (std::size_t i = 0; i < points.points.size(); ++i) index[points.points[i]->id] = static_cast<int>(i);
    for (const auto& entry : network.covariances) {
      const Eigen::Matrix3d c = unpack_symmetric(entry->values, 3, "point " + entry->from);
      const int from = index.at(entry->from), to = entry->to.empty() ? from : index.at(entry->to);
      if (!entries_.try_emplace({from, to}, c).second || from == to) continue;
      pairs_.emplace_back(from, to);
    }
  }

  bool is_joint() const { return joint_.size() > 0; }
  const std::vector<std::pair<int, int>>& pairs() const { return pairs_; }  ///< those at hand, of no joint covariance
  Eigen::Matrix3d own(int point) const {
    return is_joint() ? Eigen::Matrix3d(joint_.block<3, 3>(3 * point, 3 * point)) : entry(point, point);
  }
  Eigen::Matrix3d relative(int a, int b) const {
    if (is_joint()) return relative_covariance(joint_, a, b);
    if (a == b) return Eigen::Matrix3d::Zero();
    return entry(a, b);
  }

 private:
  const Eigen::Matrix3d& entry(int a, int b) const {
    const auto found = entries_.find({a, b});
    if (found != entries_.end()) return found->second;
    if (const auto back = entries_.find({b, a}); back != entries_.end()) return back->second;
    const std::string from = points_.points[a]->id, to = points_.points[b]->id;
    throw std::runtime_error("the pair '" + from + ";" + to +
                             "': of a network of this size the adjustment keeps neighbouring markers and the pairs "
                             "that it was asked for only; give it to the adjustment: network.with.pairs=[\"" +
                             from + ";" + to + "\"]");
  }

  const PointsT& points_;
  Eigen::MatrixXd joint_;
  std::map<std::pair<int, int>, Eigen::Matrix3d> entries_;
  std::vector<std::pair<int, int>> pairs_;
};

void write_precision(Table& table, const Eigen::Matrix3d& covariance) {
  const ConfidenceEllipse plan =
      confidence_ellipse(covariance.topLeftCorner<2, 2>(), least_squares::confidence_factor(0.95, 2));
  table.millimetres(plan.major);
  table.millimetres(plan.minor);
  table.number(plan.azimuth * 200 / std::numbers::pi, 1);
  table.millimetres(least_squares::confidence_factor(0.95, 1) * std::sqrt(covariance(2, 2)));
}

std::vector<std::pair<int, int>> chosen_pairs(const SurveyNetworkT& network, const PointsT& points,
                                              const std::vector<std::string>& wanted, int neighbour_count,
                                              const Covariances& covariances) {
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
  if (!covariances.is_joint()) {
    if (neighbour_count > 0) pairs.insert(pairs.end(), covariances.pairs().begin(), covariances.pairs().end());
    return pairs;
  }
  std::vector<std::string> ids;
  std::vector<Eigen::Vector3d> positions;
  for (const auto& point : points.points) ids.push_back(point->id), positions.push_back(point->position);
  for (const auto& [a, b] : neighbouring_markers(ids, positions, stations_of(network), neighbour_count))
    pairs.emplace_back(static_cast<int>(a), static_cast<int>(b));
  return pairs;
}

void header(Table& table, std::initializer_list<const char*> names) {
  for (const char* name : names) table.text(name);
}

}  // namespace

std::pair<std::string, std::string> split_pair(const std::string& text) {
  const std::size_t at = text.find_first_of("; ");
  if (at == std::string::npos || at == 0 || at + 1 == text.size())
    throw std::runtime_error("the pair '" + text + "': expected two names, as in 'A B' or 'A;B'");
  return {text.substr(0, at), text.substr(text.find_first_not_of(' ', at + 1))};
}

std::vector<std::pair<std::size_t, std::size_t>> neighbouring_markers(const std::vector<std::string>& ids,
                                                                      const std::vector<Eigen::Vector3d>& positions,
                                                                      const std::set<std::string>& stations,
                                                                      int count) {
  std::vector<std::size_t> markers;
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (!stations.contains(ids[i])) markers.push_back(i);
  if (markers.size() < 2) {
    markers.resize(ids.size());
    std::iota(markers.begin(), markers.end(), std::size_t{0});
  }
  std::vector<Eigen::Vector3d> places;
  for (const std::size_t i : markers) places.push_back(known(positions[i]));
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [a, b] : neighbours(places, count)) pairs.emplace_back(markers[a], markers[b]);
  return pairs;
}

std::string coordinate_table(const SurveyNetworkT& network, const PointsT& points, const TableFormat& format) {
  if (network.points.size() != points.points.size())
    throw std::runtime_error("'network' has " + std::to_string(network.points.size()) + " points, 'points' " +
                             std::to_string(points.points.size()) + ": expected two outputs of one adjustment");
  const Covariances covariances(network, points);
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
    write_precision(table, covariances.own(static_cast<int>(i)));
    table.text(stations.contains(p.id) ? "station" : "marker");
    table.text(datum.contains(p.id) ? "yes" : "no");
    table.end_row();
  }
  return std::move(table).out();
}

std::string observation_table(const SurveyNetworkT& network, const TableFormat& format) {
  Table table(format);
  header(table, {"kind", "set_up", "from", "to", "detail", "unit", "value", "residual_milli", "sigma_milli",
                 "redundancy_number", "w", "mdb_milli", "effect_mm", "effect_on", "control", "flag", "file", "line"});
  table.end_row();
  for (const auto& o : network.observations) {
    stop_point();
    const bool angular =
        o->kind == "direction" || o->kind == "zenith_angle" || o->kind == "angle" || o->kind == "azimuth";
    const double unit = angular ? 200 / std::numbers::pi : 1;
    for (const std::string* text : {&o->kind, &o->set_up, &o->from, &o->to, &o->detail}) table.text(*text);
    table.text(angular ? "gon" : "m");
    table.number(unit * o->value, 5);
    table.number(1e3 * unit * o->residual, 3);
    table.number(1e3 * unit * o->sigma, 3);
    table.number(o->redundancy_number, 3);
    table.number(o->w, 2);
    table.number(1e3 * unit * o->mdb, 3);
    table.millimetres(o->external_effect);
    table.text(o->external_point);
    table.text(o->control);
    table.text(o->removed ? "removed" : o->flagged ? "suspect" : "");
    table.text(o->file);
    table.number(o->line, 0);
    table.end_row();
  }
  return std::move(table).out();
}

std::string relative_table(const SurveyNetworkT& network, const PointsT& points, const std::vector<std::string>& wanted,
                           int neighbour_count, const TableFormat& format) {
  const Covariances covariances(network, points);
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
  for (const auto& [a, b] : chosen_pairs(network, points, wanted, neighbour_count, covariances)) {
    stop_point();
    const PointT &from = *points.points[a], &to = *points.points[b];
    const Eigen::Vector3d d = to.position - from.position;
    const Eigen::Matrix3d c = covariances.relative(a, b);
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
