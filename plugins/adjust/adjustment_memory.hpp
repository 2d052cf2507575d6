// What the adjustment of a block takes at its largest, announced to the host: it waits until that much is free.
#pragma once

#include <algorithm>
#include <cstdint>

#include "plumbline/node.hpp"

namespace plumbline::adjust {

/// Of `images` with six unknowns each and `bodies` (plates, targets) with `unknowns` each: the class with fewer unknowns
/// is kept, and its normal matrix stands four times (itself, its factor, that one's inverse, the cofactors). Beside them
/// `bytes` an observation, and covariances of `joint` bodies three times (computed, in the artifact, written).
/// Measured on 1 500 images × 30 000 targets, 180 000 observations: 2.78 GB, announced 2.9 GB.
inline void announce_memory(Context& context, std::size_t images, std::size_t bodies, std::size_t unknowns,
                            std::size_t observations, double bytes, std::size_t joint) {
  constexpr double worth_announcing = 64e6, number = sizeof(double);
  const double kept = static_cast<double>(std::min(6 * images, unknowns * bodies));
  const double known = 3 * static_cast<double>(joint);
  const double all = 4.2 * number * kept * kept + bytes * static_cast<double>(observations) + 3 * number * known * known;
  if (all > worth_announcing) context.reserve_memory(static_cast<std::uint64_t>(all));
}

}  // namespace plumbline::adjust
