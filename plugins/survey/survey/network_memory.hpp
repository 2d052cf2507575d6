// What the adjustment of a network takes at its largest, announced to the host: it waits until that much is free.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "plumbline/node.hpp"
#include "survey/model/adjust_options.hpp"

namespace plumbline::survey {

/// Bytes: 5 kB a reading (the readings three times, equations, factor, tests, the artifact), and a joint covariance of
/// up to `largest_whole` unknowns three times (computed, of all points, packed). Measured: benchmarks/survey/README.md.
inline std::uint64_t network_memory(const SurveyObservations& survey, int largest_whole) {
  constexpr double kReading = 5000, kNumber = sizeof(double);
  const auto readings = static_cast<double>(survey.observations.size());
  const auto unknowns = static_cast<double>(3 * survey.points.size() + 3 * survey.set_ups.size());
  const double joint = unknowns <= largest_whole ? unknowns : 0;
  return static_cast<std::uint64_t>(kReading * readings + 3 * kNumber * joint * joint);
}

/// Bytes of a series of epochs: the largest network's, the covariance of all points of each epoch twice (as it was
/// adjusted, and laid on the stable points) and four more of one while it is laid on them.
inline std::uint64_t series_memory(const std::vector<SurveyObservations>& epochs) {
  std::uint64_t largest = 0;
  double covariances = 0, one = 0;
  for (const SurveyObservations& survey : epochs) {
    largest = std::max(largest, network_memory(survey, std::numeric_limits<int>::max()));
    const auto coordinates = static_cast<double>(3 * survey.points.size());
    const double bytes = sizeof(double) * coordinates * coordinates;
    covariances += 2 * bytes, one = std::max(one, bytes);
  }
  return static_cast<std::uint64_t>(covariances) + std::max(largest, static_cast<std::uint64_t>(4 * one));
}

/// Said where it is worth waiting for.
inline void announce_memory(Context& context, std::uint64_t bytes) {
  constexpr std::uint64_t kWorthAnnouncing = 64'000'000;
  if (bytes > kWorthAnnouncing) context.reserve_memory(bytes);
}
inline void announce_network(Context& context, const SurveyObservations& survey, int largest_whole) {
  announce_memory(context, network_memory(survey, largest_whole));
}

}  // namespace plumbline::survey
