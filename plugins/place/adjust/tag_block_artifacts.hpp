// Between the artifacts of a pipeline and the plain structs of tag_block.hpp.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/block.hpp"
#include "artifacts/camera_artifact.hpp"
#include "artifacts/fitted_datum.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "least_squares/problem/defects.hpp"
#include "photo/block/tag_block.hpp"

namespace plumbline::block {

/// Collects a tag block from artifacts and turns its result back into artifacts. All functions throw std::runtime_error
/// on contradictory input: a camera with too few parameters, two cameras with one name, an image of none of them, two
/// plates with one tag, a covariance of the wrong length.
class TagBlockBuilder {
 public:
  /// A camera with others takes the images whose ImageTags.camera has its name; one without takes all.
  TagBlockBuilder(CameraT camera, PlatesT plates, PosesT poses);

  /// Whether the camera's covariance is the prior of a self-calibration; a camera without one is then taken as exact.
  void set_prior(bool use_prior);

  /// Tags of known plates, with the detector's covariance or, lacking that, `corner_sigma` [px]. A tag that occurs
  /// twice in an image is left out both times.
  void add_image(const ImageTagsT& image, double corner_sigma);

  /// The frame of what is given was fitted to the design, or that of the points was: adjusted points say so.
  void set_fitted(const std::string& origin, double datum_sigma) { mark_fitted(datum_, origin, datum_sigma); }
  void set_fitted(const PointsT& control) { take_datum(control, datum_); }

  /// Control are the points that have a plate, coordinates and a standard deviation, and are "check" neither here nor
  /// there.
  void set_control(const PointsT& points);

  const TagBlock& block() const { return block_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  PointsT points(const TagBlockResult& result) const;
  CameraT camera(const TagBlockResult& result) const;
  PosesT poses(const TagBlockResult& result) const;
  BlockT describe(const TagBlockResult& result, const TagBlockOptions& options) const;

 private:
  std::unique_ptr<StatisticsT> statistics(const TagBlockResult& result) const;
  void describe_batches(const TagBlockResult& result, BlockT& artifact) const;
  void describe_control(const TagBlockResult& result, BlockT& artifact) const;
  void describe_images(const TagBlockResult& result, BlockT& artifact) const;
  void describe_plates(const TagBlockResult& result, BlockT& artifact) const;
  void describe_interior(const TagBlockResult& result, BlockT& artifact) const;
  void describe_lambda(const TagBlockResult& result, const TagBlockOptions& options, BlockT& artifact) const;
  CameraT adjusted_camera(const TagBlockResult& result, size_t index) const;
  int camera_of_image(const ImageTagsT& image) const;

  std::vector<CameraT> cameras_;
  std::vector<CompleteCamera> lenses_;
  PlatesT plates_;
  PosesT poses_;
  TagBlock block_;
  PointsT datum_;  ///< no points, only how the frame of all came about
  std::map<std::pair<std::string, int>, int> plate_of_tag_;
  std::map<std::string, const PoseT*> pose_of_image_;
  std::vector<std::string> warnings_;
};

}  // namespace plumbline::block
