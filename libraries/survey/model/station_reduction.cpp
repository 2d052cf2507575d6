#include "survey/model/station_reduction.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

namespace {

constexpr double kPi = std::numbers::pi;

/// In face 1: direction - pi, 2 pi - zenith angle.
double reduced_to_face_1(const Observation& o) {
  if (o.face != 2) return o.value;
  if (o.kind == ObservationKind::direction) return o.value - kPi;
  if (o.kind == ObservationKind::zenith_angle) return o.value > kPi ? 2 * kPi - o.value : o.value;
  return o.value;
}

bool is_angular(ObservationKind kind) {
  return kind == ObservationKind::direction || kind == ObservationKind::zenith_angle ||
         kind == ObservationKind::angle || kind == ObservationKind::azimuth;
}

double or_zero(double v) { return std::isnan(v) ? 0.0 : v; }

using Key = std::tuple<int, ObservationKind, std::string, std::string, std::string, double, double>;

Key key_of(const Observation& o) {
  return {o.set_up, o.kind, o.from, o.to, o.second_to, or_zero(o.instrument_height), or_zero(o.target_height)};
}

/// Offsets of the circle between sets: median over the targets a set has in common with those before it.
/// A circle that was not touched gives offsets of a few seconds, which are noise and must stay in the means.
std::map<std::pair<int, int>, double> circle_offsets(const SurveyObservations& survey) {
  constexpr double kTouched = 0.01;  // [rad]
  std::map<std::pair<int, int>, std::vector<const Observation*>> sets;
  for (const Observation& o : survey.observations)
    if (o.kind == ObservationKind::direction && o.set_number > 0) sets[{o.set_up, o.set_number}].push_back(&o);
  std::map<std::pair<int, int>, double> offsets;
  std::map<std::pair<int, std::string>, double> reference;
  for (const auto& [set, directions] : sets) {
    std::vector<double> differences;
    for (const Observation* o : directions) {
      const auto known = reference.find({o->set_up, o->to});
      if (known != reference.end()) differences.push_back(wrap_angle(reduced_to_face_1(*o) - known->second));
    }
    double offset = 0;
    if (!differences.empty()) {
      std::nth_element(differences.begin(), differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2),
                       differences.end());
      offset = differences[differences.size() / 2];
    }
    if (std::abs(offset) < kTouched) offset = 0;
    offsets[set] = offset;
    for (const Observation* o : directions) reference.try_emplace({o->set_up, o->to}, reduced_to_face_1(*o) - offset);
  }
  return offsets;
}

MeanObservation mean_of(const SurveyObservations& survey, const std::vector<int>& members,
                        const std::map<std::pair<int, int>, double>& offsets) {
  MeanObservation mean;
  mean.members = members;
  mean.observation = survey.observations[members.front()];
  Observation& first = mean.observation;
  std::vector<double> values[3];  // by face
  const double origin = reduced_to_face_1(first);
  for (int m : members) {
    const Observation& o = survey.observations[m];
    double value = reduced_to_face_1(o);
    const auto offset = offsets.find({o.set_up, o.set_number});
    if (o.kind == ObservationKind::direction && offset != offsets.end()) value -= offset->second;
    values[o.face].push_back(is_angular(o.kind) ? wrap_angle(value - origin) : value - origin);
  }
  // The mean of the two face means: with unequal counts the errors of the instrument still cancel.
  const auto average = [](const std::vector<double>& list) {
    double sum = 0;
    for (double v : list) sum += v;
    return list.empty() ? 0.0 : sum / static_cast<double>(list.size());
  };
  const bool both = !values[1].empty() && !values[2].empty();
  std::vector<double> sets;
  if (both) {
    const size_t pairs = std::max(values[1].size(), values[2].size());
    for (size_t k = 0; k < pairs; ++k)
      sets.push_back(0.5 * ((k < values[1].size() ? values[1][k] : average(values[1])) +
                            (k < values[2].size() ? values[2][k] : average(values[2]))));
    first.value = origin + 0.5 * (average(values[1]) + average(values[2]));
  } else {
    for (const auto& list : values) sets.insert(sets.end(), list.begin(), list.end());
    first.value = origin + average(sets);
    mean.single_face = is_angular(first.kind) && !values[1].empty() + !values[2].empty() == 1;
  }
  mean.sets = static_cast<int>(sets.size());
  double squares = 0;
  for (double v : sets) squares += (v - average(sets)) * (v - average(sets));
  if (sets.size() > 1) mean.spread = std::sqrt(squares / static_cast<double>(sets.size() - 1));
  if (first.face == 2 || both) first.corrections.push_back(both ? "mean of both faces" : "face 2 reduced");
  if (mean.sets > 1) first.corrections.push_back("mean of " + std::to_string(mean.sets) + " sets");
  first.face = both ? 0 : first.face;
  return mean;
}

}  // namespace

MeanResult mean_observations(const SurveyObservations& survey) {
  std::vector<char> correlated(survey.observations.size(), 0);
  for (const auto& c : survey.covariances)
    for (int i : c.indices) correlated[i] = 1;
  MeanResult result;
  std::map<Key, size_t> groups;
  std::vector<std::vector<int>> members;
  for (int i = 0; i < static_cast<int>(survey.observations.size()); ++i) {
    const Observation& o = survey.observations[i];
    const bool alone = correlated[i] || !std::isnan(o.sigma) || o.set_up < 0;
    if (!alone) {
      const auto [at, is_new] = groups.try_emplace(key_of(o), members.size());
      if (!is_new) {
        members[at->second].push_back(i);
        continue;
      }
    }
    members.push_back({i});
  }
  const auto offsets = circle_offsets(survey);
  for (const auto& list : members) {
    MeanObservation mean = mean_of(survey, list, offsets);
    // Ten times what a 20" instrument or a tape would spread: not noise, but a wrong point or a moved target.
    const double limit = is_angular(mean.observation.kind) ? 1e-3 : 0.02;
    if (mean.spread > limit)
      result.notes.push_back("readings from " + mean.observation.from + " to " + mean.observation.to + " (" +
                             place(mean.observation.source) +
                             ") differ among the sets far more than noise: check the point number");
    result.observations.push_back(std::move(mean));
  }
  return result;
}

}  // namespace plumbline::survey
