#include "survey/plan/plan_layout.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "base/text/words.hpp"

namespace plumbline::survey {

namespace {

double incidence(const PlannedMarker& m, const Eigen::Vector3d& from) {
  return std::acos(std::clamp((from - m.position).normalized().dot(m.normal.normalized()), -1.0, 1.0));
}

}  // namespace

PlanLayout::PlanLayout(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                       const PlanOptions& options)
    : markers_(markers), options_(options) {
  if (markers.empty() || set_ups.empty())
    throw std::runtime_error("a plan needs markers and set-ups; there are " + std::to_string(markers.size()) + " and " +
                             std::to_string(set_ups.size()));
  std::set<int> floors;
  std::set<std::string> ids;
  for (const auto& m : markers) {
    floors.insert(m.floor);
    if (!ids.insert(m.id).second) throw std::runtime_error("marker '" + m.id + "' is planned twice");
    if (!m.position.allFinite())
      throw std::runtime_error("marker '" + m.id + "' has no complete coordinates; give E, N and H");
  }
  floors_.assign(floors.begin(), floors.end());
  for (const auto& s : set_ups) {
    if (!ids.insert(s.id).second) throw std::runtime_error("set-up '" + s.id + "' has the name of another point");
    add_set_up(s);
  }
}

void PlanLayout::add_set_up(const PlannedSetUp& set_up) {
  if (!set_up.position.allFinite())
    throw std::runtime_error("planned set-up '" + set_up.id + "' has no complete coordinates; give E, N and H");
  const size_t s = set_ups_.size();
  set_ups_.push_back(set_up);
  std::vector<char> possible(markers_.size());
  for (size_t m = 0; m < markers_.size(); ++m) possible[m] = allowed(markers_[m], set_up.position);
  possible_.push_back(possible);
  planned_.push_back(set_up.sees.empty() ? possible : std::vector<char>(markers_.size(), 0));
  for (const std::string& id : set_up.sees) {
    const auto at = std::find_if(markers_.begin(), markers_.end(), [&](const auto& m) { return m.id == id; });
    if (at == markers_.end())
      throw std::runtime_error("set-up '" + set_up.id + "' is to sight '" + id + "', which is no planned marker");
    const auto m = static_cast<size_t>(at - markers_.begin());
    planned_.back()[m] = possible[m];
    if (!possible[m]) refused_.push_back(sight(s, m));
  }
}

bool PlanLayout::allowed(const PlannedMarker& m, const Eigen::Vector3d& from) const {
  const Eigen::Vector3d d = m.position - from;
  if (d.norm() > options_.largest_range || d.head<2>().norm() < 0.5) return false;
  if (std::atan2(std::abs(d.z()), d.head<2>().norm()) > options_.steepest_sight) return false;
  const double angle = incidence(m, from);
  return std::isnan(angle) || angle <= options_.largest_incidence;
}

PlannedSight PlanLayout::sight(size_t s, size_t m) const {
  const Eigen::Vector3d& from = set_ups_[s].position;
  return {set_ups_[s].id, markers_[m].id, (markers_[m].position - from).norm(), incidence(markers_[m], from)};
}

std::vector<int> PlanLayout::columns() const {
  std::set<int> columns;
  for (const auto& m : markers_)
    if (m.column > 0) columns.insert(m.column);
  return {columns.begin(), columns.end()};
}

std::vector<size_t> PlanLayout::on_floor(int floor) const {
  std::vector<size_t> which;
  for (size_t m = 0; m < markers_.size(); ++m)
    if (markers_[m].floor == floor) which.push_back(m);
  return which;
}

int PlanLayout::set_ups_seeing(size_t marker) const {
  return static_cast<int>(
      std::count_if(planned_.begin(), planned_.end(), [&](const auto& sees) { return sees[marker]; }));
}

int PlanLayout::sightings() const {
  int n = 0;
  for (const auto& sees : planned_) n += static_cast<int>(std::count(sees.begin(), sees.end(), 1));
  return n;
}

bool PlanLayout::sees_floor(size_t s, int floor) const {
  for (size_t m = 0; m < markers_.size(); ++m)
    if (planned_[s][m] && markers_[m].floor == floor) return true;
  return false;
}

std::vector<size_t> PlanLayout::seen_on_floor(int floor) const {
  std::vector<size_t> which;
  for (size_t m : on_floor(floor))
    if (set_ups_seeing(m) > 0) which.push_back(m);
  return which;
}

int PlanLayout::shared_markers(int lower, int upper) const {
  std::set<size_t> below, above;
  for (size_t s = 0; s < set_ups_.size(); ++s) {
    if (!sees_floor(s, lower) || !sees_floor(s, upper)) continue;
    for (size_t m = 0; m < markers_.size(); ++m) {
      if (!planned_[s][m]) continue;
      if (markers_[m].floor == lower) below.insert(m);
      if (markers_[m].floor == upper) above.insert(m);
    }
  }
  return static_cast<int>(std::min(below.size(), above.size()));
}

SurveyObservations PlanLayout::readings(int sets) const {
  SurveyObservations s;
  const auto add_point = [&](const std::string& id, const Eigen::Vector3d& p) {
    Point point;
    point.id = id;
    point.coordinates = p;
    s.points.push_back(point);
  };
  for (size_t m = 0; m < markers_.size(); ++m)
    if (set_ups_seeing(m) > 0) add_point(markers_[m].id, markers_[m].position);
  for (size_t i = 0; i < set_ups_.size(); ++i) {
    if (std::count(planned_[i].begin(), planned_[i].end(), 1) == 0) continue;
    add_point(set_ups_[i].id, set_ups_[i].position);
    s.set_ups.push_back({set_ups_[i].id, set_ups_[i].id, kNotGiven, {}});
    for (size_t m = 0; m < markers_.size(); ++m)
      if (planned_[i][m]) add_sighting(s, static_cast<int>(s.set_ups.size() - 1), markers_[m], sets);
  }
  return s;
}

void PlanLayout::add_sighting(SurveyObservations& s, int set_up, const PlannedMarker& m, int sets) const {
  const std::string& from = s.set_ups[set_up].id;
  const Eigen::Vector3d d = m.position - s.points.back().coordinates;
  const double h = d.head<2>().norm(), length = d.norm();
  const double values[] = {std::atan2(d.x(), d.y()), std::atan2(h, d.z()), length};
  const InstrumentProfile p = options_.profile.without_instrument_centring();  // free stations
  const double sigmas[] = {p.direction(h, length, sets, false), p.zenith_angle(length, sets, false),
                           p.distance(length, sets)};
  const ObservationKind kinds[] = {ObservationKind::direction, ObservationKind::zenith_angle,
                                   ObservationKind::slope_distance};
  const int pointing = static_cast<int>(s.observations.size() / 3);
  for (int k = 0; k < 3; ++k) {
    Observation o;
    o.kind = kinds[k];
    o.set_up = set_up;
    o.pointing = pointing;
    o.from = from;
    o.to = m.id;
    o.value = values[k];
    o.sigma = sigmas[k];
    s.observations.push_back(std::move(o));
  }
}

AdjustOptions PlanLayout::adjustment() const {
  AdjustOptions options;
  options.largest_whole = std::numeric_limits<int>::max();  // sights that might be added are tried against all of it
  options.curvature = Switch::off;
  options.datum = DatumMode::inner;
  for (size_t m : seen_on_floor(floors_.front())) options.datum_points.push_back(markers_[m].id);
  return options;
}

HeightWeights transfer_weights(const std::vector<size_t>& lower, const std::vector<size_t>& upper) {
  HeightWeights weights;
  for (size_t m : lower) weights.emplace_back(m, -1.0 / static_cast<double>(lower.size()));
  for (size_t m : upper) weights.emplace_back(m, 1.0 / static_cast<double>(upper.size()));
  return weights;
}

PlanPrediction predict(const PlanLayout& layout, int sets) {
  PlanPrediction prediction;
  try {
    const AdjustOptions options = layout.adjustment();
    if (options.datum_points.empty()) throw NetworkError("no marker of the lowest floor is seen");
    NetworkResult network = adjust_network(layout.readings(sets), options);
    // In the field the rest of a network is worth having; a plan is to determine all of it.
    for (const Finding& f : network.findings)
      if (f.subject == Finding::Subject::left_out) throw NetworkError(f.cause);
    prediction.network = std::move(network);
    prediction.adjustable = true;
  } catch (const NetworkError& error) {
    prediction.problem = error.what();
  }
  return prediction;
}

double PlanPrediction::height_sigma(const PlanLayout& layout, const HeightWeights& weights) const {
  double variance = 0;
  for (const auto& [a, wa] : weights)
    for (const auto& [b, wb] : weights)
      variance +=
          wa * wb *
          network.covariance(network.point(layout.markers()[a].id), network.point(layout.markers()[b].id))(2, 2);
  return std::sqrt(std::max(0.0, variance));
}

double transfer_sigma(const PlanLayout& layout, const PlanPrediction& prediction, int lower, int upper) {
  const auto below = layout.seen_on_floor(lower), above = layout.seen_on_floor(upper);
  if (!prediction.adjustable || below.empty() || above.empty()) return std::numeric_limits<double>::infinity();
  return prediction.height_sigma(layout, transfer_weights(below, above));
}

SurveyObservations planned_readings(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                                    const PlanOptions& options) {
  return PlanLayout(markers, set_ups, options).readings(options.sets);
}

AdjustOptions planned_adjustment(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                                 const PlanOptions& options) {
  return PlanLayout(markers, set_ups, options).adjustment();
}

}  // namespace plumbline::survey
