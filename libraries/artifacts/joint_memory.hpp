// What a node takes that unpacks the joint covariance of points, announced to the host: it waits until that much is
// free.
#pragma once

#include <cstdint>
#include <type_traits>

namespace plumbline {

/// Of points whose joint covariance has `packed` values (a triangle), which the node holds `copies` times: as it came,
/// unpacked, moved, in what it writes. A square one counts as two. Measured with 572 and 1188 points. Said where it is
/// worth waiting for; once a run of a node.
template <class Context>  // of a node; a library has none
void announce_joint(Context& context, std::uint64_t packed, std::uint64_t copies) {
  constexpr std::uint64_t worth_announcing = 64'000'000;
  const std::uint64_t bytes = copies * packed * sizeof(double);
  if (bytes > worth_announcing) context.reserve_memory(bytes);
}

/// Values of the joint covariance of an input with points; 0 without.
template <class Input>
std::uint64_t joint_size(const Input& points) {
  if constexpr (std::is_constructible_v<bool, const Input&>)
    if (!points) return 0;
  const auto* covariance = points->covariance();
  return covariance ? covariance->size() : 0;
}

}  // namespace plumbline
