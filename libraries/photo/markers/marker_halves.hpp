// Two halves of the photographs beside each other: whether what a block says of its own accuracy is true.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {

/// How the photographs of each camera are divided.
enum class HalvesBy {
  turns,  ///< every second one by name, and the others
  time,   ///< the first half by name, and the second
  place   ///< those from either side
};

struct MarkerHalves {
  HalvesBy by = HalvesBy::turns;
  int tags = 0;         ///< that both halves place
  double rms = 0;       ///< of the differences of their centres, per coordinate, after a similarity [m]
  double variance = 0;  ///< dᵀ (Σ₁ + Σ₂)⁻¹ d per degree of freedom: 1 if the covariances are true
  int freedom = 0;
  /// The same of the interior orientations that both estimate.
  double camera_variance = 0;
  int camera_freedom = 0;
  /// The differences of the tags, or of the cameras, are more than the covariances allow (0.1 %), and by half as much
  /// again (cameras: by twice as much) at least.
  bool tags_contradict = false, cameras_contradict = false;
  bool contradict() const { return tags_contradict || cameras_contradict; }
  double worst() const { return std::max(variance, camera_variance); }
};

/// Adjusts two halves of the photographs and compares the tags' centres, free of position, rotation and scale, and the
/// cameras. What is wrong with the model of the camera (rows read one after another, a focus that moves, a lens of
/// another kind) differs between the halves, and no residual need be large. Nothing where a camera has fewer than eight
/// oriented photographs, or a half cannot be adjusted or has fewer than four tags in common with the other. Takes about
/// as long as the adjustment itself.
std::optional<MarkerHalves> compare_halves(const MarkerBlock& block, const MarkerOptions& options,
                                           const MarkerResult& result, HalvesBy by = HalvesBy::turns);

/// What to say where they contradict each other. `only_by_place`: all other halves agree.
std::string in_words(const MarkerHalves& halves, bool only_by_place = false);

}  // namespace plumbline::markers
