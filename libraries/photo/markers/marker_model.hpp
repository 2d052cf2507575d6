// The parts of a marker block's adjustment: approximate values, the model, its datum.
#pragma once

#include "photo/bundle/datum.hpp"
#include "photo/markers/marker_block.hpp"
#include "photo/markers/planar_pose.hpp"

namespace plumbline::markers {

/// Approximate values of everything that could be placed.
struct MarkerStart {
  std::vector<BrownCamera> cameras;
  std::vector<std::optional<RigidTransform>> cam_from_world;  ///< by image
  std::vector<std::optional<RigidTransform>> world_from_tag;  ///< by marker
  double cost = 0;                                            ///< robust mean over all views; lower is better
  int placed = 0;                                             ///< views between placed images and tags
};

/// Places images and tags with the cameras as given (fx > 0), starting from the layout or from the best connected
/// image. Both poses of every tag are candidates until several images decide.
MarkerStart start_marker_block(const MarkerBlock& block, const std::vector<BrownCamera>& cameras,
                               const std::vector<bool>& use);

/// The same from values that are nearly right: places what is missing and turns over what fits better turned.
MarkerStart improve_start(const MarkerBlock& block, const MarkerStart& from, const std::vector<bool>& use);

/// Both poses of a view with a camera, better first.
std::vector<FittedPose> poses_of_view(const MarkerBlock& block, const MarkerView& view, const BrownCamera& camera);

/// Principal distance from the shapes of the tags (Zhang 2000, with square pixels and a centred principal point) [px];
/// nan if they don't tell.
double focal_length_from_tags(const MarkerBlock& block, int camera);

enum MarkerGroup {
  group_refined,
  group_unrefined,
  group_layout,
  group_size,
  group_shape,
  group_interior,
  group_inset,
  group_count
};

/// The block as one of plates without an anchor: each tag has a size (a batch) and a form of its own, and each camera
/// an inset (a batch behind those of the tags).
struct MarkerModel {
  std::vector<int> images, markers, views;  ///< those that take part
  bundle::Problem problem;                  ///< images, plates and tags in the order of these
  bundle::State state;
  int inset_batch(std::size_t camera) const { return static_cast<int>(markers.size() + camera); }
};

/// Of images, tags and views that are in `start` and in `use`.
MarkerModel build_model(const MarkerBlock& block, const MarkerOptions& options, const MarkerStart& start,
                        const std::vector<bool>& use);

/// Inner constraints of a free network: over the centres of all tags, and where these lie in one line (one tag, two
/// tags, a row) over their rotations, too: centres alone leave the turn about the line open.
bundle::Datum datum_of(const MarkerBlock& block, const MarkerModel& model, const bundle::Layout& layout);

/// Whether the tags' centres lie in one line, to a tenth of a tag.
bool in_one_line(const MarkerBlock& block, const MarkerModel& model);

/// Whether a tag has a place in a layout.
bool has_layout(const MarkerBlock& block);

}  // namespace plumbline::markers
