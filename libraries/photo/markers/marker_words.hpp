// What the result of a marker block has to be told in words: why a photograph has no pose, what is weak, what the
// observations contradict.
#pragma once

#include <map>
#include <set>

#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {

/// Corners that are much worse than the detector states are a finding about the photographs.
void warn_about_variance(MarkerResult& result);
/// Where the photographs have a tag that the layout has elsewhere, or turned otherwise.
struct TagOffLayout {
  Eigen::Vector3d place;
  double distance = 0;        ///< [m]
  double angle = 0;           ///< [rad]
  bool about_normal = false;  ///< turned in its plane, else tilted
  double excess = 0;          ///< the larger of distance and angle, in what is allowed
  double contradiction = 0;   ///< normalised residual of the layout's rotation, in what is allowed
  bool moved = false, turned = false;
};
/// By marker: those that are off by five standard deviations of the layout's places and half their size, or by five of
/// its rotations, and by more than the photographs are uncertain, or whose rotation in the layout has a normalised
/// residual above five.
std::map<int, TagOffLayout> tags_off_layout(const MarkerBlock& block, const MarkerOptions& options,
                                            const MarkerResult& result);
/// Names them, and which were exchanged. `left_out`: markers whose place in the layout took no part. Throws
/// std::runtime_error if the layout turns most tags otherwise: then its rotations are of another convention.
void warn_about_layout(const MarkerBlock& block, const MarkerOptions& options, const std::set<int>& left_out,
                       MarkerResult& result);
/// Why an image is not oriented, and which tags could not be placed.
void explain_images(const MarkerBlock& block, MarkerResult& result);
/// The second pose of photographs with one tag.
void explain_single_tags(const MarkerBlock& block, MarkerResult& result);
/// What an adjustment makes of parameters that come with a covariance, all together: their change d against that of a
/// sound prior, d' (Σ₀ − Σ₁)⁻¹ d, over the directions in which the observations control the prior by a fifth and more.
struct CalibrationTest {
  double statistic = 0;  ///< chi-squared with `freedom` if the calibration is right
  int freedom = 0;
};
CalibrationTest test_calibration(const Eigen::VectorXd& change, const Eigen::MatrixXd& prior,
                                 const Eigen::MatrixXd& adjusted);
/// Calibrations that were given with a covariance and come out beyond it.
void warn_about_calibrations(const MarkerBlock& block, MarkerResult& result);
/// Poses, cameras and tags that hang on little.
void warn_about_weak(const MarkerBlock& block, MarkerResult& result);

}  // namespace plumbline::markers
