// The parts of a marker block's adjustment: approximate values, unknowns, cost functions, motions of the datum.
#pragma once

#include <map>

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

/// Unknowns with the model over them; not to be copied, since the model points into it.
struct MarkerState {
  std::vector<int> images, markers, views;   ///< those that take part
  std::vector<std::array<double, 6>> poses;  ///< projection centre, rotation vector in the camera frame
  std::vector<Eigen::Quaterniond> cam_from_world;
  std::vector<Eigen::Matrix3d> camera_matrices;
  std::vector<std::array<double, 3>> centres, turns;  ///< of the tags; turn in the world frame
  std::vector<Eigen::Quaterniond> world_from_tag;
  std::vector<Eigen::Matrix3d> tag_matrices;
  std::vector<double> scales;
  std::vector<std::array<double, shape_count>> shapes;
  std::vector<std::array<double, BrownCamera::parameter_count>> interiors;  ///< by camera
  std::vector<double> insets;
  std::array<double, 2> sigma_factors{1, 1};  ///< on refined and unrefined corners

  void fold();
};

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

struct MarkerModel {
  block::BlockModel model;
  std::vector<int> centre_columns, turn_columns, scale_columns;  ///< first column by state.markers; -1: held
  std::vector<std::vector<int>> interior_columns;                ///< by camera
  std::vector<int> inset_columns;
};

/// Fills `state` from approximate values: images, tags and views that are in `start` and in `use`.
void fill_state(const MarkerBlock& block, const MarkerStart& start, const std::vector<bool>& use, MarkerState& state);

void build_model(const MarkerBlock& block, const MarkerOptions& options, MarkerState& state, MarkerModel& result);

/// Motions of a free network in the space of the kept unknowns: translations, rotations, and scale if tags have no
/// size.
Eigen::MatrixXd free_motions(const MarkerState& state, const MarkerModel& model);

/// Unknowns over which the inner constraints of a free network are taken: the centres of all tags, and where these lie
/// in one line (one tag, two tags, a row) their rotations, too: centres alone leave the turn about the line open.
std::vector<int> datum_columns(const MarkerBlock& block, const MarkerState& state, const MarkerModel& model);

/// Whether the tags' centres lie in one line, to a tenth of a tag.
bool in_one_line(const MarkerBlock& block, const MarkerState& state);

/// Whether a tag has a place in a layout.
bool has_layout(const MarkerBlock& block);

/// Square root L of the covariance of a view's 8 coordinates, without the state's factors.
Eigen::Matrix<double, 8, 8> view_root(const MarkerView& view);

}  // namespace plumbline::markers
