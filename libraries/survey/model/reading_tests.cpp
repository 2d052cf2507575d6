#include "survey/model/reading_tests.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/median.hpp"

namespace plumbline::survey {

namespace {

constexpr double kMadToSigma = 1.4826;     // of a normal distribution
constexpr double kCritical = 5;            // standard deviations of one reading
constexpr double kLeastAngle = 1.5e-5;     // [rad], 1 mgon
constexpr double kLeastDistance = 4e-4;    // [m]
constexpr double kAcross = 5e-4;           // [m] of pointing and target, across the sight
constexpr double kUntestedError = 7.9e-4;  // [rad], 50 mgon: collimation and index that no pair tells more of
constexpr int kPairsEnough = 3;
constexpr size_t kNeighbours = 20;  // readings before it that one is compared with: linear in a group of any size

double sigma_by_mad(std::vector<double> values, double centre) {
  for (double& v : values) v = std::abs(v - centre);
  return kMadToSigma * median(std::move(values));
}

bool is_two_faced(ObservationKind kind) {
  return kind == ObservationKind::direction || kind == ObservationKind::zenith_angle;
}

bool is_angle(ObservationKind kind) {
  return is_two_faced(kind) || kind == ObservationKind::angle || kind == ObservationKind::azimuth;
}

/// Effect on a reading in face 1 of an instrument error of 1.
double effect(const ReadingGroup& group) {
  return group.kind == ObservationKind::direction ? 1 / std::max(group.sin_zenith, 0.05) : 1;
}

/// The error that the k-th readings in both faces show, for each k.
std::vector<double> pair_errors(const ReadingGroup& group) {
  std::array<std::vector<double>, 3> by_face;
  for (const Reading& r : group.readings) by_face[r.face].push_back(r.value);
  std::vector<double> errors;
  for (size_t k = 0; k < std::min(by_face[1].size(), by_face[2].size()); ++k)
    errors.push_back(0.5 * (by_face[1][k] - by_face[2][k]) / effect(group));
  return errors;
}

struct Estimate {
  double value = 0, sigma = 0;
  int pairs = 0;
};

Estimate estimate(const std::vector<double>& values) {
  if (values.empty()) return {};
  Estimate e;
  e.value = median(values);
  e.pairs = static_cast<int>(values.size());
  // 1.2533: standard deviation of a median by that of a mean.
  e.sigma = 1.2533 * sigma_by_mad(values, e.value) / std::sqrt(static_cast<double>(values.size()));
  return e;
}

size_t kind_index(ObservationKind kind) { return static_cast<size_t>(kind); }
constexpr size_t kKinds = static_cast<size_t>(ObservationKind::azimuth) + 1;

/// Limit of what one reading may differ by, without the part that depends on the sight.
double limit_of(const ReadingGroup& group, double sigma) {
  const double across = is_angle(group.kind) && group.length > 0 ? kAcross / group.length : 0;
  return kCritical * std::hypot(sigma, across) * (group.kind == ObservationKind::direction ? effect(group) : 1);
}

std::vector<double> corrected(const ReadingGroup& group, const std::vector<InstrumentErrors>& errors) {
  std::vector<double> values;
  for (const Reading& r : group.readings)
    values.push_back(group.set_up < 0 ? r.value : without_instrument_error(group, r, errors[group.set_up]));
  return values;
}

/// Standard deviation of one reading by kind: of the median difference between two readings of one group. Deviations
/// from a group's own median are far from normal in small groups: of four readings two lie half their gap from it, and
/// the sigma of their MAD is a third too small.
std::array<double, kKinds> reading_sigmas(const std::vector<ReadingGroup>& groups,
                                          const std::vector<InstrumentErrors>& errors) {
  std::array<std::vector<double>, kKinds> differences;
  for (const ReadingGroup& g : groups) {
    if (g.alone || g.readings.size() < 2) continue;
    const std::vector<double> values = corrected(g, errors);
    for (size_t i = 1; i < values.size(); ++i)
      for (size_t j = i - std::min<size_t>(i, kNeighbours); j < i; ++j)
        differences[kind_index(g.kind)].push_back(std::abs(values[i] - values[j]));
  }
  std::array<double, kKinds> sigmas{};
  for (size_t k = 0; k < kKinds; ++k) {
    const double least = is_angle(static_cast<ObservationKind>(k)) ? kLeastAngle : kLeastDistance;
    sigmas[k] = differences[k].empty() ? least : std::max(least, kMadToSigma * median(differences[k]) / std::sqrt(2.0));
  }
  return sigmas;
}

/// Two readings of different faces where the survey tells nothing of the instrument: only the absurd is refused.
bool faces_untested(const ReadingGroup& group, const std::vector<InstrumentErrors>& errors) {
  if (!is_two_faced(group.kind) || group.set_up < 0 || group.readings.size() != 2 ||
      group.readings[0].face == group.readings[1].face)
    return false;
  const InstrumentErrors& e = errors[group.set_up];
  return (group.kind == ObservationKind::direction ? e.direction_pairs : e.zenith_pairs) == 0;
}

GroupVerdict judge(const ReadingGroup& group, const std::vector<InstrumentErrors>& errors, double sigma) {
  GroupVerdict verdict;
  verdict.removed.assign(group.readings.size(), 0);
  verdict.differences.assign(group.readings.size(), 0);
  if (group.alone || group.readings.size() < 2) return verdict;
  const std::vector<double> values = corrected(group, errors);
  const double centre = median(values);
  double limit = limit_of(group, sigma);
  if (faces_untested(group, errors)) limit = std::max(limit, kUntestedError * effect(group));
  size_t outliers = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    verdict.differences[i] = values[i] - centre;
    verdict.removed[i] = std::abs(values[i] - centre) > limit;
    outliers += static_cast<size_t>(verdict.removed[i]);
  }
  // The half difference of two readings is 0.7 of one reading's scatter; no majority says which one is wrong.
  if (values.size() == 2 ? std::abs(values[0] - values[1]) > std::sqrt(2.0) * limit : 2 * outliers >= values.size()) {
    verdict.separate = true;
  }
  if (values.size() == 2 || verdict.separate) verdict.removed.assign(values.size(), 0);
  return verdict;
}

}  // namespace

double without_instrument_error(const ReadingGroup& group, const Reading& reading, const InstrumentErrors& errors) {
  if (!is_two_faced(group.kind) || reading.face == 0) return reading.value;
  const double error = group.kind == ObservationKind::direction ? errors.collimation : errors.index;
  return reading.value - (reading.face == 1 ? 1 : -1) * error * effect(group);
}

std::vector<InstrumentErrors> estimate_instrument_errors(const std::vector<ReadingGroup>& groups, int set_ups) {
  std::vector<InstrumentErrors> errors(static_cast<size_t>(set_ups));
  std::vector<std::vector<double>> collimations(errors.size()), indices(errors.size());
  std::vector<double> all_collimations, all_indices;
  for (const ReadingGroup& g : groups) {
    if (g.alone || g.set_up < 0 || !is_two_faced(g.kind)) continue;
    const bool direction = g.kind == ObservationKind::direction;
    for (const double e : pair_errors(g)) {
      (direction ? collimations : indices)[g.set_up].push_back(e);
      (direction ? all_collimations : all_indices).push_back(e);
    }
  }
  const auto or_survey = [](const std::vector<double>& own, const std::vector<double>& all) {
    if (own.size() >= kPairsEnough) return estimate(own);
    Estimate e = all.size() >= kPairsEnough ? estimate(all) : Estimate{};
    e.pairs = all.size() >= kPairsEnough ? static_cast<int>(own.size()) : 0;
    return e;
  };
  for (size_t i = 0; i < errors.size(); ++i) {
    const Estimate c = or_survey(collimations[i], all_collimations), v = or_survey(indices[i], all_indices);
    errors[i] = {static_cast<int>(i), c.value, v.value, c.sigma, v.sigma, c.pairs, v.pairs};
  }
  return errors;
}

std::vector<GroupVerdict> test_readings(const std::vector<ReadingGroup>& groups,
                                        const std::vector<InstrumentErrors>& errors) {
  const auto sigmas = reading_sigmas(groups, errors);
  std::vector<GroupVerdict> verdicts;
  for (const ReadingGroup& g : groups) verdicts.push_back(judge(g, errors, sigmas[kind_index(g.kind)]));
  return verdicts;
}

}  // namespace plumbline::survey
