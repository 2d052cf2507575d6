// Verdicts of surfaces in words, the same for tables, IFC and BCF.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/surface_judgement.hpp"

namespace plumbline::ifc {

/// "flatness(1m)", "step".
inline std::string quantity_of(const SurfaceVerdictT& verdict) {
  if (!std::isfinite(verdict.length)) return verdict.quantity;
  return fmt::format("{}({:g}m)", verdict.quantity, verdict.length);
}

/// What of its element each verdict is about, as BCF topics and campaigns name it: "surface", "joint/P2". Neighbours of
/// one panel that share a name are told apart by a number.
inline std::vector<std::string> topics_of(const SurfaceJudgementT& judgement) {
  std::vector<std::string> topics;
  std::map<std::pair<std::string, std::string>, std::vector<int>> joints;  // numbers, by element and neighbour
  for (const auto& verdict : judgement.verdicts) {
    if (verdict->second.empty()) {
      topics.push_back("surface");
      continue;
    }
    std::vector<int>& same = joints[{verdict->guid.empty() ? verdict->panel : verdict->guid, verdict->second}];
    const auto at = std::find(same.begin(), same.end(), verdict->item) - same.begin();
    if (at == static_cast<std::ptrdiff_t>(same.size())) same.push_back(verdict->item);
    topics.push_back("joint/" + verdict->second + (at > 0 ? "/" + std::to_string(at) : ""));
  }
  return topics;
}

/// The worst of some: what could not be judged keeps a panel from passing, but does not outweigh what was.
inline ToleranceVerdict worst_of(const std::vector<const SurfaceVerdictT*>& verdicts) {
  for (const ToleranceVerdict wanted :
       {ToleranceVerdict::fail, ToleranceVerdict::undecided, ToleranceVerdict::not_measured})
    if (std::any_of(verdicts.begin(), verdicts.end(), [&](const SurfaceVerdictT* v) { return v->verdict == wanted; }))
      return wanted;
  return ToleranceVerdict::pass;
}

/// The limit that the value has passed, or the one it is nearer to [m].
inline double limit_of(const SurfaceVerdictT& verdict) {
  return verdict.upper - verdict.value <= verdict.value - verdict.lower ? verdict.upper : verdict.lower;
}

}  // namespace plumbline::ifc
