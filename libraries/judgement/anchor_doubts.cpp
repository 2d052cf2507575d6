#include "judgement/anchor_doubts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace plumbline::evaluate {

namespace {

constexpr double storey = 2;  ///< [m], the least height of one

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// "a, b, c and 4 more"
std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(names.size(), 4); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > 4 ? text + " and " + std::to_string(names.size() - 4) + " more" : text;
}

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
                     " anchors have a floor below 1 and are in no floor's statistics: " + list_of(nowhere) +
                     ". Floors count from 1.");
  for (auto upper = heights.begin(); upper != heights.end(); ++upper) {
    if (upper == heights.begin()) continue;
    const auto lower = std::prev(upper);
    const double below = median(lower->second), above = median(upper->second);
    if (above > below - storey / 4) continue;
    char text[300];
    std::snprintf(text, sizeof text,
                  "Floor %d lies below floor %d (median heights of their anchors %.3f m and %.3f m): are the floors of "
                  "the anchor table exchanged? Drift and transfers go by them.",
                  upper->first, lower->first, above, below);
    doubts.push_back(text);
  }
  return doubts;
}

std::vector<std::string> space_doubts(const AccuracyT& accuracy) {
  std::vector<std::string> off, doubts;
  for (const auto& anchor : accuracy.anchors) {
    if (anchor->use != AnchorUse::check || !anchor->survey) continue;
    const AnchorDifferenceT& d = *anchor->survey;
    if (d.verdict == ToleranceVerdict::fail || d.verdict_distance != ToleranceVerdict::fail) continue;
    char text[200];
    std::snprintf(text, sizeof text, " (%.1f mm in space, %.1f mm in height)", 1e3 * d.distance, 1e3 * d.dz);
    off.push_back(anchor->id + text);
  }
  if (!off.empty())
    doubts.push_back("Check anchors that agree with the survey in height and not in place: " + list_of(off) +
                     ". Heights alone do not show it; is a plate mounted beside its anchor, or its offset wrong?");
  return doubts;
}

}  // namespace plumbline::evaluate
