// Approximate values of a block of tags from which its adjustment begins: several are tried, each minimised robustly.
#pragma once

#include <limits>
#include <vector>

#include "photo/markers/marker_model.hpp"

namespace plumbline::markers {

/// A start that was minimised robustly, and how well it fits.
struct MarkerTrial {
  MarkerStart start;
  std::vector<bool> use;                                   ///< by view: whether it takes part
  double score = std::numeric_limits<double>::infinity();  ///< mean bounded misfit of all views
  double median_pixels = std::numeric_limits<double>::infinity();
};

/// The best of what cameras without a calibration may be (principal distances from wide to tele), tags as squares.
/// Throws std::runtime_error where no photograph could be connected to another.
MarkerTrial best_start(const MarkerBlock& block, MarkerOptions options);

/// Takes views that do not fit (options.reject_above) out of `trial`, whose start is minimised once more, and names all
/// that take no part in result.rejected.
void find_blunders(const MarkerBlock& block, const MarkerOptions& options, MarkerTrial& trial, MarkerResult& result);

/// The values of `model` as a start; what the model does not have is as in `before`, or has no place.
MarkerStart start_of(const MarkerBlock& block, const MarkerModel& model, const MarkerStart& before);

/// Camera `c` of the block with the model's values.
BrownCamera camera_of(const MarkerBlock& block, const MarkerModel& model, std::size_t c);

/// World to camera, of a place in the world [m].
RigidTransform cam_from_world(const bundle::Placement& image);

}  // namespace plumbline::markers
