// Coordinates of a map that nobody named: lengths are then taken as true in their plane, and where no two known points
// say otherwise everything fits.
#include <algorithm>
#include <cmath>

#include "survey/doctor/network_doctor.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// National maps put their false origins so that no site has small coordinates; those of a site of its own are
/// thousands, or a round 100 000.
bool looks_like_a_map(const Eigen::Vector3d& p) {
  constexpr double kSmallest = 5e4, kSmallestSum = 2.5e5, kLargest = 1e7;  // [m]; zone numbers before E reach 6e7
  const double e = std::fmod(std::abs(p.x()), 1e6) + (std::abs(p.x()) >= 1e6 ? 1e6 : 0), n = std::abs(p.y());
  return std::min(e, n) > kSmallest && e + n > kSmallestSum && n < kLargest;
}

}  // namespace

bool tell_missing_map(const NetworkModel& m, const AdjustOptions& options, const CommonEstimate& scale,
                      NetworkResult& r) {
  constexpr double kTold = 2e-5;                  // a scale that is known this well is tested, and named if it is not 1
  constexpr double kOfUtm = 4e-4, kLeast = 2e-4;  // [1], [m]
  if (!options.map.empty() || (scale.sigma > 0 && scale.sigma < kTold)) return false;
  // Without known coordinates the network's own begin at zero.
  const auto first = std::find_if(r.points.begin(), r.points.end(),
                                  [](const ResultPoint& p) { return p.position.head<2>().allFinite(); });
  const bool lengths = std::any_of(r.rows.begin(), r.rows.end(), [](const ResultRow& row) {
    return row.kind == "slope_distance" || row.kind == "horizontal_distance" || row.kind == "local_coordinate";
  });
  if (first == r.points.end() || !lengths || !looks_like_a_map(first->position)) return false;
  double extent = 0;
  for (const ResultPoint& p : r.points)
    if (p.position.head<2>().allFinite()) extent = std::max(extent, (p.position - first->position).head<2>().norm());
  if (extent * kOfUtm < kLeast) return false;
  const bool free = m.datum == DatumMode::inner;
  r.findings.insert(
      r.findings.begin() + r.compares_known_points(),
      {free ? Finding::Severity::note : Finding::Severity::warning,
       "the coordinates look like those of a map (E " + fixed_digits(first->position.x(), 0) + ", N " +
           fixed_digits(first->position.y(), 0) +
           "), and no map was given: lengths are taken as true in their plane. Maps change them (UTM by up to 400 ppm, "
           "and each 100 m of height by 16 ppm), over the " +
           fixed_digits(extent, 0) + " m of this network by up to " + fixed_digits(1e3 * extent * kOfUtm, 0) +
           " mm, which no reading here can tell: say map=EPSG:CODE, or map=plane if lengths are true in them",
       {}});
  return !free;
}

}  // namespace plumbline::survey
