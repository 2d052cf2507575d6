// The limits of a judged length in words, the same in BCF, JUnit, summary and page.
#pragma once

#include <cmath>
#include <string>

#include "artifacts/deviation.hpp"

namespace plumbline::ifc {

/// "5.0", or both sides where they differ, "+5.0/-0.0": the nearer one alone would look kept or broken by itself.
/// `in_words` writes a length [m].
template <typename Words>
std::string limits_in_words(const JudgedAxisT& axis, const Words& in_words) {
  constexpr double kEqual = 1e-9;  // [m]
  if (!(std::abs(axis.above - axis.below) > kEqual)) return in_words(axis.tolerance);
  return "+" + in_words(axis.above) + "/-" + in_words(axis.below);
}

/// Share of what is allowed that a length uses, from the middle of its limits; 0 where it or they are not known.
inline double share_of_limits(const JudgedAxisT& axis) {
  const bool sided = std::isfinite(axis.above) && std::isfinite(axis.below);
  const double middle = sided ? 0.5 * (axis.above - axis.below) : 0,
               half = sided ? 0.5 * (axis.above + axis.below) : axis.tolerance;
  const double share = std::abs(axis.value - middle) / half;
  return half > 0 && std::isfinite(share) ? share : 0;
}

}  // namespace plumbline::ifc
