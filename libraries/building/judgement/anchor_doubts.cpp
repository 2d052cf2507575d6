#include "building/judgement/anchor_doubts.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>

#include "building/judgement/figures.hpp"
#include "geometry/median.hpp"

namespace plumbline::judgement {

namespace {

using judgement::list_of;

constexpr double least_storey = 2;  ///< [m], the least height of one

}  // namespace

std::vector<std::string> floor_doubts(const AccuracyT& accuracy) {
  std::map<int, std::vector<double>> heights;
  std::vector<std::string> nowhere, doubts;
  for (const auto& anchor : accuracy.anchors) {
    if (anchor->floor < 1)
      nowhere.push_back(anchor->id);
    else if (std::isfinite(anchor->z))
      heights[anchor->floor].push_back(anchor->z);
  }
  if (!nowhere.empty() && !heights.empty())
    doubts.push_back(std::to_string(nowhere.size()) +
                     " anchors have a floor below 1 and are in no floor's statistics: " + list_of(nowhere, 4) +
                     ". Floors count from 1.");
  for (auto upper = heights.begin(); upper != heights.end(); ++upper) {
    if (upper == heights.begin()) continue;
    const auto lower = std::prev(upper);
    const double below = upper_median(lower->second), above = upper_median(upper->second);
    if (above > below - least_storey / 4) continue;
    doubts.push_back(
        fmt::format("Floor {} lies below floor {} (median heights of their anchors {:.3f} m and {:.3f} m): are the "
                    "floors of the anchor table exchanged? Drift and transfers go by them.",
                    upper->first, lower->first, above, below));
  }
  return doubts;
}

std::vector<std::string> space_doubts(const AccuracyT& accuracy) {
  std::vector<std::string> off, doubts;
  for (const auto& anchor : accuracy.anchors) {
    if (anchor->use != AnchorUse::check || !anchor->survey) continue;
    const AnchorDifferenceT& d = *anchor->survey;
    if (d.verdict == ToleranceVerdict::fail || d.verdict_distance != ToleranceVerdict::fail) continue;
    off.push_back(anchor->id + fmt::format(" ({:.1f} mm in space, {:.1f} mm in height)", 1e3 * d.distance, 1e3 * d.dz));
  }
  if (!off.empty())
    doubts.push_back("Check anchors that agree with the survey in height and not in place: " + list_of(off, 4) +
                     ". Heights alone do not show it; is a plate mounted beside its anchor, or its offset wrong?");
  return doubts;
}

}  // namespace plumbline::judgement
