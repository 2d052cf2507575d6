// Verdicts of surfaces in words, the same for tables, IFC and BCF.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "artifacts/surface_judgement.hpp"

namespace plumbline::ifc {

/// "flatness(1m)", "step".
inline std::string quantity_of(const SurfaceVerdictT& verdict) {
  if (!std::isfinite(verdict.length)) return verdict.quantity;
  return fmt::format("{}({:g}m)", verdict.quantity, verdict.length);
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
