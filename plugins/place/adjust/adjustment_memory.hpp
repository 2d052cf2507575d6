// What the adjustment of a block takes at its largest, announced to the host: it waits until that much is free.
#pragma once

#include <cstdint>
#include <functional>

#include "plumbline/node.hpp"

namespace plumbline::block {

/// For the options of an adjustment, which tells what its normal equations, their factor and the selected inverse take.
/// Beside them stand `bytes` an observation, and covariances of `joint` bodies twelve times (computed in six
/// coordinates of each, turned, in the artifact, written: 12 were found with 572 anchors). Announced once, with
/// the first that is told. Must not outlive `context`.
inline std::function<void(std::size_t)> announcer(Context& context, std::size_t observations, double bytes,
                                                  std::size_t joint) {
  constexpr double worth_announcing = 64e6, number = sizeof(double);
  const double known = 3 * static_cast<double>(joint);
  constexpr double copies = 12;
  const double beside = bytes * static_cast<double>(observations) + copies * number * known * known;
  return [&context, beside, told = false](std::size_t normal_equations) mutable {
    const double all = static_cast<double>(normal_equations) + beside;
    if (all > worth_announcing && !told) context.reserve_memory(static_cast<std::uint64_t>(all));
    told = true;
  };
}

}  // namespace plumbline::block
