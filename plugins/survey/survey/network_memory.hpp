// What the adjustment of a network takes at its largest, announced to the host: it waits until that much is free.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
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

/// Bytes that this process may have: of the machine, or less where somebody has set a limit.
inline double memory_there() {
  double there = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    there = std::min(there, static_cast<double>(limit.rlim_cur));
  return there;
}

/// A joint covariance that cannot be had is refused before anything is computed: it would end without a word.
inline void refuse_too_large(const SurveyObservations& survey, int largest_whole) {
  constexpr double kGigabyte = 1e9;
  const double needed = static_cast<double>(network_memory(survey, largest_whole)), there = memory_there();
  if (needed <= there) return;
  throw std::runtime_error("the joint covariance of " + std::to_string(survey.points.size()) + " points takes " +
                           std::to_string(std::lround(needed / kGigabyte)) + " GB of memory, and there are " +
                           std::to_string(std::lround(there / kGigabyte)) +
                           "; with covariance=automatic (network.with.covariance=automatic) that of each point and of "
                           "neighbouring markers is made, or adjust the facades one by one");
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
