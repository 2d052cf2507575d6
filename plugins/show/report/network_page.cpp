#include "show/report/network_page.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/packed_symmetric.hpp"
#include "geometry/relative_points.hpp"

namespace plumbline::report {

namespace {

bool is_angular(const std::string& kind) {
  return kind == "direction" || kind == "zenith_angle" || kind == "angle" || kind == "azimuth";
}

std::vector<NetworkPage::Point> points_of(const SurveyNetworkT& network) {
  std::map<std::string, const NetworkEllipsoidT*> ellipsoids;
  for (const auto& e : network.ellipsoids) ellipsoids[e->id] = e.get();
  std::set<std::string> stations;
  for (const auto& set_up : network.set_ups) stations.insert(set_up->station);
  const std::set<std::string> datum(network.datum_points.begin(), network.datum_points.end());
  std::vector<NetworkPage::Point> points;
  for (const auto& point : network.points) {
    NetworkPage::Point& p = points.emplace_back();
    p.id = point->id, p.position = point->position;
    const auto ellipsoid = ellipsoids.find(point->id);
    if (ellipsoid != ellipsoids.end())
      p.covariance = covariance_of(*ellipsoid->second);
    else if (network.validity != "invalid")  // what is no result has no ellipses
      p.covariance = point->sigma.cwiseAbs2().asDiagonal();
    p.station = stations.count(point->id) > 0, p.datum = datum.count(point->id) > 0;
  }
  return points;
}

NetworkPage::Observation observation_of(const NetworkObservationT& from) {
  NetworkPage::Observation o;
  o.kind = from.kind, o.from = from.from, o.to = from.to;
  if (!from.detail.empty()) o.to += " (" + from.detail + ")";
  o.angular = is_angular(from.kind);
  o.value = from.value, o.residual = from.residual, o.sigma = from.sigma, o.redundancy_number = from.redundancy_number,
  o.w = from.w;
  o.estimated_blunder = from.estimated_blunder, o.mdb = from.mdb, o.external_effect = from.external_effect;
  o.flagged = from.flagged, o.removed = from.removed;
  if (!from.file.empty()) o.source = from.line > 0 ? from.file + ":" + std::to_string(from.line) : from.file;
  return o;
}

/// "X south" for an axis of a file, e.g. 's'.
std::string axis_name(char letter, char direction) {
  const std::map<char, std::string> names = {{'e', "east"}, {'n', "north"}, {'w', "west"}, {'s', "south"}};
  const auto found = names.find(direction);
  return std::string(1, letter) + (found == names.end() ? "" : " " + found->second);
}

void fill_coordinates(const SurveyNetworkT& network, NetworkPage& page) {
  if (network.axes.size() == 2 && network.axes != "en")
    page.axis_names = {axis_name('x', network.axes[0]), axis_name('y', network.axes[1]), "z up"};
  std::map<std::string, const NetworkEllipsoidT*> ellipsoids;
  for (const auto& e : network.ellipsoids) ellipsoids[e->id] = e.get();
  for (const auto& p : network.points) {
    NetworkPage::Coordinates& row = page.coordinates.emplace_back();
    row.id = p->id, row.position = p->position, row.sigma = p->sigma;
    if (const auto e = ellipsoids.find(p->id); e != ellipsoids.end())
      row.plan_95 = e->second->plan_semi_axis_95, row.height_95 = e->second->height_half_length_95;
  }
}

void add_relative(const PointT& from, const PointT& to, const Eigen::Matrix3d& c, NetworkPage& page) {
  constexpr double factor_1d = 1.959964, factor_2d = 2.447747;  // 95 %
  if (!c.allFinite()) return;
  NetworkPage::Relative& row = page.relative.emplace_back();
  row.from = from.id, row.to = to.id;
  row.distance = (to.position - from.position).norm();
  row.plan_95 = confidence_ellipse(c.topLeftCorner<2, 2>(), factor_2d).major;
  row.sigma_height = std::sqrt(c(2, 2)), row.height_95 = factor_1d * row.sigma_height;
}

void sort_relative(NetworkPage& page) {
  std::stable_sort(page.relative.begin(), page.relative.end(),
                   [](const auto& a, const auto& b) { return a.height_95 > b.height_95; });
}

/// Of a network without a joint covariance, what the adjustment kept of pairs.
void fill_neighbours(const SurveyNetworkT& network, const PointsT& points, NetworkPage& page) {
  std::map<std::string, const PointT*> by_name;
  for (const auto& p : points.points) by_name[p->id] = p.get();
  for (const auto& entry : network.covariances)
    if (!entry->to.empty())
      add_relative(*by_name.at(entry->from), *by_name.at(entry->to),
                   unpack_symmetric(entry->values, 3, "the points " + entry->from + " and " + entry->to), page);
  sort_relative(page);
}

/// Every marker with its four nearest, weakest height first.
void fill_relative(const SurveyNetworkT& network, const PointsT& points, NetworkPage& page) {
  if (network.validity == "invalid") return;
  if (points.covariance.empty()) return fill_neighbours(network, points, page);
  const Eigen::MatrixXd covariance = unpack_symmetric(points.covariance, 3 * points.points.size(), "the points");
  std::set<std::string> stations;
  for (const auto& s : network.set_ups) stations.insert(s->station);
  std::vector<int> markers;
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    if (stations.contains(points.points[i]->id)) continue;
    markers.push_back(static_cast<int>(i));
    positions.push_back(points.points[i]->position);
  }
  for (const auto& [i, j] : neighbours(positions, 4)) {
    const int a = markers[i], b = markers[j];
    add_relative(*points.points[a], *points.points[b], relative_covariance(covariance, a, b), page);
  }
  sort_relative(page);
}

void fill_tests(const NetworkTestsT& tests, NetworkPage& page) {
  page.statistic = tests.statistic, page.lower = tests.lower, page.upper = tests.upper, page.alpha = tests.alpha;
  page.verdict = tests.verdict;
  page.critical_w = tests.critical_w, page.alpha0 = tests.alpha0, page.power = tests.power;
}

}  // namespace

Eigen::Matrix3d covariance_of(const NetworkEllipsoidT& e) {
  Eigen::Matrix3d axes;
  axes << e.first_axis, e.second_axis, e.first_axis.cross(e.second_axis);
  return axes * e.semi_axes.cwiseAbs2().asDiagonal() * axes.transpose();
}

NetworkPage network_page(const SurveyNetworkT& network, const SurveyNetworkT* in_file_axes, const PointsT* points) {
  NetworkPage page;
  fill_coordinates(in_file_axes ? *in_file_axes : network, page);
  if (points) fill_relative(network, *points, page);
  page.stochastic_model = network.stochastic_model;
  page.without_readings = network.without_readings;
  page.validity = network.validity, page.outcome = network.verdict;
  page.instrument = network.instrument, page.date = network.date, page.files = network.files;
  for (const auto& s : network.set_ups)
    page.set_ups.push_back({s->id, s->station, s->orientation, s->orientation_sigma, s->instrument_height,
                            s->instrument_height_correction, s->index, s->index_sigma, s->constant, s->constant_sigma,
                            s->scale, s->scale_sigma, s->collimation, s->collimation_sigma});
  page.points = points_of(network);
  for (const auto& o : network.observations) page.observations.push_back(observation_of(*o));
  for (const auto& s : network.snooping)
    page.steps.push_back({static_cast<std::size_t>(s->observation), s->action, s->w, s->estimated_blunder});
  for (const auto& g : network.groups)
    page.groups.push_back({g->name, g->ratio, g->redundancy, g->observations, g->applied_factor});
  for (const auto& p : network.pointings)
    page.pointings.push_back({p->set_up, p->to, p->statistic, p->critical, p->rank, p->flagged});
  for (const auto& f : network.findings) page.findings.push_back({f->severity, f->text});
  page.datum = network.datum;
  if (network.statistics) {
    page.sigma0 = network.statistics->sigma0;
    page.degrees_of_freedom = network.statistics->degrees_of_freedom;
    page.unknowns = network.statistics->unknowns;
  }
  if (network.tests) fill_tests(*network.tests, page);
  return page;
}

}  // namespace plumbline::report
