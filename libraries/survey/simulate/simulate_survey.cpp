#include "survey/simulate/simulate_survey.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "geometry/random.hpp"
#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

namespace {

constexpr double kTurn = 2 * std::numbers::pi, kRefraction = 0.13;

double in_circle(double angle) { return angle - kTurn * std::floor(angle / kTurn); }

const SimulatedPoint& point_of(const SurveyLayout& layout, const std::string& id) {
  for (const SimulatedPoint& p : layout.points)
    if (p.id == id) return p;
  throw std::invalid_argument("the layout has no point '" + id + "'");
}

struct SightTaken {
  double direction = 0, zenith = 0, slope = 0, horizontal = 0;
};

SightTaken exact_sight(const Eigen::Vector3d& axis, double orientation, const Eigen::Vector3d& target) {
  const Eigen::Vector3d d = target - axis;
  SightTaken s;
  s.horizontal = d.head<2>().norm();
  s.slope = d.norm();
  if (!(s.horizontal > kShortestHorizontal)) throw std::invalid_argument("a set-up stands on what it sights");
  s.direction = in_circle(std::atan2(d.x(), d.y()) - orientation);
  s.zenith = std::atan2(s.horizontal, d.z() - (1 - kRefraction) * s.horizontal * s.horizontal / (2 * kEarthRadius));
  return s;
}

Eigen::Vector3d axis_of(const SurveyLayout& layout, const SimulatedSetUp& s) {
  return point_of(layout, s.station).position + Eigen::Vector3d(0, 0, s.instrument_height);
}

std::vector<std::string> targets_of(const SurveyLayout& layout, const SimulatedSetUp& s) {
  if (!s.sees.empty()) return s.sees;
  std::vector<std::string> targets;
  for (const SimulatedPoint& p : layout.points)
    if (std::none_of(layout.set_ups.begin(), layout.set_ups.end(), [&](const auto& o) { return o.station == p.id; }))
      targets.push_back(p.id);
  return targets;
}

void add_sight(const SightTaken& exact, const SimulatedSetUp& set_up, int number, const std::string& to,
               const SimulationOptions& options, Random& random, SurveyObservations& survey) {
  const InstrumentProfile p = options.profile.without_instrument_centring();  // free stations
  const double values[] = {exact.direction, exact.zenith, exact.slope};
  const double sigmas[] = {p.direction(exact.horizontal, exact.slope, options.sets, false),
                           p.zenith_angle(exact.slope, options.sets, false), p.distance(exact.slope, options.sets)};
  const ObservationKind kinds[] = {ObservationKind::direction, ObservationKind::zenith_angle,
                                   ObservationKind::slope_distance};
  const int pointing = static_cast<int>(survey.observations.size() / 3);
  for (int k = 0; k < 3; ++k) {
    Observation o;
    o.kind = kinds[k];
    o.set_up = number;
    o.pointing = pointing;
    o.from = set_up.station;
    o.to = to;
    o.value = values[k] + random.normal(options.noise * sigmas[k]);
    if (options.sigmas) o.sigma = sigmas[k];
    o.source.line = static_cast<int>(survey.observations.size()) + 1;
    survey.observations.push_back(std::move(o));
  }
}

/// Observations of a set-up, sight by sight in the order of reading.
std::vector<std::vector<int>> sights_of(const SurveyObservations& survey, int set_up) {
  std::vector<std::vector<int>> sights;
  int pointing = -1;
  for (int i = 0; i < static_cast<int>(survey.observations.size()); ++i) {
    const Observation& o = survey.observations[i];
    if (o.set_up != set_up) continue;
    if (sights.empty() || o.pointing != pointing) sights.emplace_back();
    pointing = o.pointing;
    sights.back().push_back(i);
  }
  return sights;
}

bool is_distance(const Observation& o) {
  return o.kind == ObservationKind::slope_distance || o.kind == ObservationKind::horizontal_distance;
}

void rename(const SurveyMistake& m, SurveyObservations& survey, std::vector<int>& wrong) {
  const bool swap = m.kind == SurveyMistake::Kind::swapped_names;
  for (int i = 0; i < static_cast<int>(survey.observations.size()); ++i) {
    Observation& o = survey.observations[i];
    if (o.set_up != m.set_up || (o.to != m.first && (!swap || o.to != m.second))) continue;
    o.to = o.to == m.first ? m.second : m.first;
    wrong.push_back(i);
  }
  if (wrong.empty())
    throw std::invalid_argument("set-up " + std::to_string(m.set_up) + " sights neither '" + m.first + "' nor '" +
                                m.second + "'");
}

/// Readings as they are from another place, with the noise they have.
void move_instrument(const SurveyMistake& m, const SurveyLayout& layout, const std::vector<int>& sight,
                     SurveyObservations& survey) {
  const SimulatedSetUp& set_up = layout.set_ups.at(m.set_up);
  const Eigen::Vector3d axis = axis_of(layout, set_up);
  for (int i : sight) {
    Observation& o = survey.observations[i];
    const Eigen::Vector3d target = point_of(layout, o.to).position;
    const SightTaken before = exact_sight(axis, set_up.orientation, target);
    const SightTaken after = exact_sight(axis + Eigen::Vector3d(m.size, 0, 0), set_up.orientation, target);
    o.value += o.kind == ObservationKind::direction      ? wrap_angle(after.direction - before.direction)
               : o.kind == ObservationKind::zenith_angle ? after.zenith - before.zenith
                                                         : after.slope - before.slope;
  }
}

}  // namespace

SurveyObservations simulate_survey(const SurveyLayout& layout, const SimulationOptions& options, std::uint64_t seed) {
  SurveyObservations survey;
  for (const SimulatedPoint& p : layout.points) {
    Point point;
    point.id = p.id;
    if (options.coordinates) point.coordinates = p.position;
    survey.points.push_back(std::move(point));
  }
  Random random(seed, "survey");
  for (size_t i = 0; i < layout.set_ups.size(); ++i) {
    const SimulatedSetUp& s = layout.set_ups[i];
    survey.set_ups.push_back({s.id, s.station, s.instrument_height, {}});
    for (const std::string& to : targets_of(layout, s))
      add_sight(exact_sight(axis_of(layout, s), s.orientation, point_of(layout, to).position), s, static_cast<int>(i),
                to, options, random, survey);
  }
  return survey;
}

SurveyLayout facade_layout(int markers, int set_ups, std::uint64_t seed) {
  constexpr double kColumn = 2.0, kRow = 3.0, kMissed = 0.1;
  Random random(seed, "facade");
  SurveyLayout layout;
  const int columns = std::max(1, (markers + 4) / 5);
  for (int m = 0; m < markers; ++m)
    layout.points.push_back(
        {"M" + std::to_string(m + 1), {100 + kColumn * (m % columns), 250 + 0.3 * (m % 3), 1 + kRow * (m / columns)}});
  const double length = kColumn * columns;
  for (int i = 0; i < set_ups; ++i)
    layout.points.push_back(
        {"S" + std::to_string(i + 1), {100 + length * (i + 0.5) / set_ups, 250 - 14.0 - 3.0 * (i % 2), 0.1 * i}});
  for (int i = 0; i < set_ups; ++i) {
    SimulatedSetUp s;
    s.id = s.station = "S" + std::to_string(i + 1);
    s.instrument_height = random.uniform(1.4, 1.7);
    s.orientation = random.uniform(0, kTurn);
    for (const SimulatedPoint& p : layout.points)
      if (p.id != s.station && (p.id[0] == 'S' || random.uniform() >= kMissed)) s.sees.push_back(p.id);
    layout.set_ups.push_back(std::move(s));
  }
  return layout;
}

std::vector<int> plant(const SurveyMistake& m, const SurveyLayout& layout, SurveyObservations& survey) {
  using Kind = SurveyMistake::Kind;
  if (m.set_up < 0 || m.set_up >= static_cast<int>(survey.set_ups.size()))
    throw std::invalid_argument("there is no set-up " + std::to_string(m.set_up));
  std::vector<int> wrong;
  const auto change = [&](int i, double by) {
    survey.observations[i].value += by;
    wrong.push_back(i);
  };
  if (m.kind == Kind::reading) {
    if (m.observation < 0 || m.observation >= static_cast<int>(survey.observations.size()))
      throw std::invalid_argument("there is no observation " + std::to_string(m.observation));
    change(m.observation, m.size);
  } else if (m.kind == Kind::swapped_names || m.kind == Kind::wrong_name) {
    rename(m, survey, wrong);
  } else if (m.kind == Kind::instrument_height) {
    survey.set_ups[m.set_up].instrument_height += m.size;
  } else {
    const auto sights = sights_of(survey, m.set_up);
    for (size_t s = 0; s < sights.size(); ++s) {
      const bool after = static_cast<int>(s) >= m.from_sight;
      if (m.kind == Kind::moved_instrument && after) {
        move_instrument(m, layout, sights[s], survey);
        wrong.insert(wrong.end(), sights[s].begin(), sights[s].end());
      }
      for (int i : sights[s]) {
        const Observation& o = survey.observations[i];
        if (m.kind == Kind::turned_circle && after && o.kind == ObservationKind::direction) change(i, m.size);
        if (!is_distance(o)) continue;
        if (m.kind == Kind::prism) change(i, m.size);
        if (m.kind == Kind::scale) change(i, m.size * o.value);
        if (m.kind == Kind::unit) change(i, o.value / m.size - o.value);
      }
    }
  }
  return wrong;
}

}  // namespace plumbline::survey
