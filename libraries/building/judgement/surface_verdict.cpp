#include "building/judgement/surface_verdict.hpp"

#include <algorithm>

#include "building/judgement/conformance.hpp"
#include "building/judgement/tolerance.hpp"

namespace plumbline::judgement {
namespace {

/// Limits as a middle and how far a value may lie from it.
struct Shifted {
  double centre, half;
};
Shifted shifted(const SurfaceLimit& limit) {
  constexpr double far = 1e3;  // stands for no limit [m]
  const double upper = std::min(limit.upper, far), lower = std::max(limit.lower, -far);
  return {0.5 * (upper + lower), 0.5 * (upper - lower)};
}

}  // namespace

double limit_probability(double value, double sigma, const SurfaceLimit& limit) {
  const Shifted at = shifted(limit);
  return judgement::conformance_probability(value - at.centre, sigma, at.half);
}

void decide(SurfaceVerdictT& verdict, double kept, double at_worst, double fails_at, double risk) {
  verdict.verdict = ToleranceVerdict::undecided;
  if (verdict_of(kept, risk) == ToleranceVerdict::pass)
    verdict.verdict = ToleranceVerdict::pass;
  else if (at_worst <= fails_at)
    verdict.verdict = ToleranceVerdict::fail;
}

}  // namespace plumbline::judgement
