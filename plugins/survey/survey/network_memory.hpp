// What the adjustment of a network takes at its largest, announced to the host: it waits until that much is free.
#pragma once

#include <algorithm>
#include <cstdint>

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

/// Said where it is worth waiting for.
inline void announce_network(Context& context, const SurveyObservations& survey, int largest_whole) {
  constexpr std::uint64_t kWorthAnnouncing = 64'000'000;
  if (const std::uint64_t bytes = network_memory(survey, largest_whole); bytes > kWorthAnnouncing)
    context.reserve_memory(bytes);
}

}  // namespace plumbline::survey
