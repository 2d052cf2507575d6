#include "survey/model/rounded_readings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "survey/model/reading_evidence.hpp"

namespace plumbline::survey {

namespace {

/// A backsight at zero is 399.99998 gon in the file with more digits.
double from_zero(const Observation& o) {
  constexpr double kFullCircle = 2 * std::numbers::pi, kNearZero = 1e-4;
  return o.kind == ObservationKind::direction && o.value > kFullCircle - kNearZero ? o.value - kFullCircle : o.value;
}

auto what(const Observation& o) { return std::tie(o.to, o.second_to, o.kind, o.face); }

}  // namespace

std::vector<const Observation*> in_order(const SurveyObservations& survey, int set_up) {
  std::vector<const Observation*> readings;
  for (const Observation& o : survey.observations)
    if (o.set_up == set_up) readings.push_back(&o);
  std::stable_sort(readings.begin(), readings.end(), [](const Observation* a, const Observation* b) {
    return what(*a) != what(*b) ? what(*a) < what(*b) : from_zero(*a) < from_zero(*b);
  });
  return readings;
}

Rounded same_when_rounded(const std::vector<const Observation*>& first, const std::vector<const Observation*>& second) {
  if (first.size() != second.size() || first.empty()) return Rounded::no;
  const Digits one = digits_of(first), other = digits_of(second);
  double chance = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    const Observation &a = *first[i], &b = *second[i];
    if (what(a) != what(b)) return Rounded::no;
    const bool angle = is_angle_reading(a);
    // Half a step of each: both may have been rounded from what the instrument kept.
    const double window = 0.5 * (angle ? one.angle + other.angle : one.length + other.length);
    if (!(std::abs(from_zero(a) - from_zero(b)) <= 1.001 * window + 1e-12)) return Rounded::no;
    if (a.value != 0 && b.value != 0) chance += log_chance(a, window);
  }
  if (chance > kNoCoincidence) return Rounded::no;
  const bool second_has_more = other.angle < one.angle || (other.angle == one.angle && other.length < one.length);
  return second_has_more ? Rounded::first_is_coarser : Rounded::second_is_coarser;
}

}  // namespace plumbline::survey
