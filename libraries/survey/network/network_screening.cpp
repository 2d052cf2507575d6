// Which observations can take part, judged by the approximate coordinates.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "geometry/median.hpp"
#include "survey/network/network_model_steps.hpp"

namespace plumbline::survey {

void find_lengths(NetworkModel& m) {
  std::map<std::tuple<int, std::string, double>, Eigen::Vector2d> measured;  // slope, zenith angle
  const auto key = [](const Observation& o) {
    return std::tuple(o.set_up, o.to, std::isnan(o.target_height) ? 0.0 : o.target_height);
  };
  for (const MeanObservation& mean : m.observations) {
    const Observation& o = mean.observation;
    if (o.set_up < 0) continue;
    Eigen::Vector2d& sight = measured.try_emplace(key(o), kNotGiven, kNotGiven).first->second;
    if (o.kind == ObservationKind::slope_distance) sight[0] = o.value;
    if (o.kind == ObservationKind::zenith_angle) sight[1] = o.value;
  }
  for (const MeanObservation& mean : m.observations) {
    const Observation& o = mean.observation;
    const Eigen::Vector3d d = m.initial[m.index.at(o.to)] - m.initial[m.index.at(o.from)];
    Eigen::Vector2d lengths(d.head<2>().norm(), d.norm());
    if (const auto at = measured.find(key(o)); o.set_up >= 0 && at != measured.end() && !at->second.hasNaN())
      lengths = {at->second[0] * std::abs(std::sin(at->second[1])), at->second[0]};
    m.lengths.push_back(lengths.cwiseMax(kShortestHorizontal));
  }
}

void drop_unusable(NetworkModel& m) {
  m.dropped.assign(m.observations.size(), 0);
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const Observation& o = m.observations[i].observation;
    const int from = m.index.at(o.from), to = m.index.at(o.to);
    const Eigen::Vector3d d = m.initial[to] - m.initial[from];
    const bool needs_plan = o.kind != ObservationKind::height_difference;
    const bool needs_height = o.kind == ObservationKind::height_difference || o.kind == ObservationKind::zenith_angle ||
                              o.kind == ObservationKind::slope_distance;
    std::string reason;
    const auto lacks = [&](int p, int axis) { return m.roles[p][axis] == CoordinateRole::unused; };
    if (from == to) reason = "it sights its own station";
    if (needs_plan && (lacks(from, 0) || lacks(to, 0))) reason = "one end has no plan position";
    if (needs_height && (lacks(from, 2) || lacks(to, 2))) reason = "one end has no height";
    const double h = d.head<2>().norm();
    if (reason.empty() && (o.kind == ObservationKind::direction || o.kind == ObservationKind::azimuth) &&
        h < kShortestHorizontal)
      reason = "the sight is vertical, a direction means nothing there";
    if (reason.empty() && o.kind == ObservationKind::zenith_angle && h < 1e-3) reason = "the sight is exactly vertical";
    if (reason.empty()) continue;
    m.dropped[i] = 1;
    m.findings.push_back({Finding::Severity::warning, name_of(o) + " is not used: " + reason, {o.from, o.to}});
  }
}

namespace {

/// What the approximate coordinates disagree with an observation, as a length at the target [m].
double misclosure(const NetworkModel& m, const Observation& o, double orientation) {
  const auto or_zero = [](double v) { return std::isnan(v) ? 0.0 : v; };
  const double own = o.set_up >= 0 ? m.survey.set_ups[o.set_up].instrument_height : 0.0;
  const double instrument = or_zero(std::isnan(o.instrument_height) ? own : o.instrument_height);
  const auto sight = [&](const std::string& to, double height) {
    Eigen::Vector3d d = m.initial[m.index.at(to)] - m.initial[m.index.at(o.from)];
    d.z() += or_zero(height) - instrument;
    return d;
  };
  const Eigen::Vector3d d = sight(o.to, o.target_height);
  const double h = d.head<2>().norm(), azimuth = std::atan2(d.x(), d.y());
  switch (o.kind) {
    case ObservationKind::direction:
      return h * wrap_angle(azimuth - orientation - o.value);
    case ObservationKind::azimuth:
      return h * wrap_angle(azimuth - o.value);
    case ObservationKind::angle:
      return 0;
    case ObservationKind::zenith_angle:
      return d.norm() * wrap_angle(std::atan2(h, d.z()) - o.value);
    case ObservationKind::slope_distance:
      return d.norm() - o.value;
    case ObservationKind::horizontal_distance:
      return h - o.value;
    case ObservationKind::height_difference:
      return d.z() - o.value;
  }
  return 0;
}

bool is_known(const NetworkModel& m, const std::string& id) {
  for (const Point& p : m.survey.points)
    for (size_t k = 0; k < 3 && p.id == id; ++k)
      if (p.known[k] || p.roles[k] == CoordinateRole::fixed) return true;
  for (const CoordinateGroup& g : m.survey.coordinates)
    for (const auto& component : g.components)
      if (g.is_control && component.point == id) return true;
  return false;
}

}  // namespace

void drop_outlying(NetworkModel& m) {
  const double tolerance = m.survey.info.largest_misclosure;
  if (std::isnan(tolerance)) return;
  std::map<int, std::vector<double>> turns;
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const Observation& o = m.observations[i].observation;
    if (m.dropped[i] || o.kind != ObservationKind::direction) continue;
    const Eigen::Vector3d d = m.initial[m.index.at(o.to)] - m.initial[m.index.at(o.from)];
    auto& list = turns[o.set_up];
    const double turn = std::atan2(d.x(), d.y()) - o.value;
    list.push_back(list.empty() ? turn : list.front() + wrap_angle(turn - list.front()));
  }
  std::map<std::string, std::pair<int, int>> of_point;  // readings, left out
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const Observation& o = m.observations[i].observation;
    if (m.dropped[i] || o.kind == ObservationKind::angle) continue;  // its arms have no one length
    for (const std::string& id : {o.from, o.to}) ++of_point[id].first;
    const bool direction = o.kind == ObservationKind::direction;
    const double size = misclosure(m, o, direction ? upper_median(turns.at(o.set_up)) : 0.0);
    if (!(std::abs(size) > tolerance)) continue;
    m.dropped[i] = 1;
    for (const std::string& id : {o.from, o.to}) ++of_point[id].second;
    m.findings.push_back({Finding::Severity::warning,
                          name_of(o) + " is not used: it contradicts the approximate coordinates by " +
                              std::to_string(std::abs(size)) + " m",
                          {o.from, o.to}});
  }
  for (const auto& [id, readings] : of_point)
    if (readings.first == readings.second && is_known(m, id)) m.outlying_known.push_back(id);
}

}  // namespace plumbline::survey
