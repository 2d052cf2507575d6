// The parts of a tag block adjustment: approximate values, cost functions, similarity motions in the space of its
// unknowns.
#pragma once

#include <deque>

#include "block/defects.hpp"
#include "block/tag_block.hpp"

namespace plumbline::adjust {

/// Values of all unknowns, in a local frame: world minus `origin`, because coordinates of a site may have seven digits.
struct TagState {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::vector<int> images;  ///< of the block, those that take part
  std::vector<int> plates;
  std::vector<int> observations;
  std::vector<std::array<double, 6>>
      poses;  ///< projection centre, rotation vector in the camera frame on top of `cam_from_local`
  std::vector<Eigen::Quaterniond> cam_from_local;
  std::vector<Eigen::Matrix3d> camera_matrices;  ///< the same, where the cost functions read them
  std::vector<Eigen::Vector3d> anchors;
  std::vector<Eigen::Vector3d> turns;  ///< rotation vector in the local frame on top of `local_from_plate`
  std::vector<Eigen::Quaterniond> local_from_plate;
  std::vector<Eigen::Matrix3d> plate_matrices;
  std::vector<Eigen::Vector3d> start;  ///< tag centres as first placed: the datum of a free network
  std::array<double, BrownCamera::parameter_count> interior{};
  std::vector<std::string> batch_names;
  std::vector<int> batch_of_plate;
  std::vector<double> scales, insets;
  double image_sigma_factor = 1;  ///< multiplies the standard deviations of all corners

  void fold();
  Eigen::Vector3d tag_centre(const TagBlock& block, size_t plate) const;
};

/// Places plates from the images that see them and images from the plates they see, until nothing is added. `left_out`
/// tells what could not be placed; `use` tells which of block.observations may be used. Throws if fewer than two images
/// are left.
TagState start_tag_block(const TagBlock& block, const std::vector<bool>& use, std::vector<std::string>& left_out);

/// The model over a state; both must outlive it. Groups: see the enumeration. Labels: index into state.observations for
/// images.
enum TagGroup { group_images, group_control, group_interior, group_scale, group_inset, group_aspect };
struct TagModel {
  BlockModel model;
  std::vector<int> anchor_columns;  ///< first column of each anchor; the plate's rotation follows
  std::vector<int> interior_columns;
  std::vector<int> scale_columns, inset_columns;  ///< −1 if held
  Eigen::MatrixXd control_root;                   ///< L of the control's covariance
  std::vector<int> control_plates;                ///< indices into state.plates, in the order of the control rows
};
TagModel build_tag_model(const TagBlock& block, const TagBlockOptions& options, TagState& state);

/// Similarity motions of the block as vectors of its kept unknowns, kept × 7.
Eigen::MatrixXd kept_motions(const TagBlock& block, const TagState& state, const TagModel& model);

/// L of the covariance of a tag's 8 coordinates.
Eigen::Matrix<double, 8, 8> corner_root(const TagObservation& observation, const TagBlockOptions& options);

}  // namespace plumbline::adjust
