// Two halves of the photographs beside each other: whether what a block says of its own accuracy is true.
#pragma once

#include <optional>
#include <string>

#include "markers/marker_block.hpp"

namespace plumbline::markers {

struct MarkerHalves {
  int tags = 0;         ///< that both halves place
  double rms = 0;       ///< of the differences of their centres, per coordinate, after a similarity [m]
  double variance = 0;  ///< dᵀ (Σ₁ + Σ₂)⁻¹ d per degree of freedom: 1 if the covariances are true
  int freedom = 0;
  /// The differences are more than the covariances allow (0.1 %), and by half as much again at least.
  bool contradict = false;
};

/// Adjusts every second photograph of each camera, and the others, and compares the tags' centres, free of position,
/// rotation and scale. What is wrong with the model of the camera (rows read one after another, a focus that moves, a
/// lens of another kind) differs between the halves, and no residual need be large. Nothing where a camera has fewer
/// than eight oriented photographs, or a half cannot be adjusted or has fewer than four tags in common with the other.
/// Takes about as long as the adjustment itself.
std::optional<MarkerHalves> compare_halves(const MarkerBlock& block, const MarkerOptions& options,
                                           const MarkerResult& result);

/// What to say where they contradict each other, and what to do.
std::string in_words(const MarkerHalves& halves);

}  // namespace plumbline::markers
