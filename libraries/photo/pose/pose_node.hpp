// What every pose initialiser has in common: ports, parameters, and the way from artifacts to geometry/tag_pose.hpp. A
// node adds its `solver` parameter and the function behind it.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "geometry/tag_pose.hpp"
#include "plumbline/node.hpp"

namespace plumbline::pose {

/// Settings of the role, from a node's parameters.
struct PoseSettings {
  TagPoseOptions robust;
  double point_sigma = 0.02;  ///< [m]
  double pixel_sigma = 0.2;   ///< [px]
  int min_markers = 3;
  bool skip_poor_images = false;
  bool look_for_causes = true;
  int raw_tags = 0;  ///< 0: the robust frame; else what the solver alone makes of so many tags
};

/// Poses of the images in their order; of several cameras (`others` of `camera`), each image has that of its name.
/// `warn` is told of images that are left out. Throws std::runtime_error that names the image, what was found in it and
/// what to do.
PosesT initial_poses(const std::vector<ImageTagsT>& images, const CameraT& camera, const PlatesT& plates,
                     const PointsT& points, const TagPoseSolver& solver, const PoseSettings& settings,
                     const std::function<void(const std::string&)>& warn);

struct PoseNode : Node {
  List<ImageTags> observations{"observations", "tags of each image"};
  In<Camera> camera{"camera", "interior orientation of the images; of several cameras, each image names its own"};
  In<Plates> plates{"plates", frame("frame=?F"),
                    "which tag stands for which anchor, and how its plate is mounted by design"};
  In<Points> points{"points", frame("frame=?F"),
                    "approximate anchors, such as those of the design; control and check alike"};
  Out<Poses> poses{"poses", frame("frame=?F"), "exterior orientation of each image with its covariance"};
  Param<double> point_sigma{"point_sigma", 0.02, "m", between(1e-5, 10),
                            "how far an approximate anchor may be off, where it carries no sigma of its own"};
  Param<double> plate_rotation_sigma{"plate_rotation_sigma", 0.035, "rad", between(1e-5, 1),
                                     "how far a plate may be turned against its nominal rotation, about each axis"};
  Param<double> tag_shape_sigma{"tag_shape_sigma", 0.001, "1", between(0, 0.1),
                                "how far a corner may be off the plane square that a tag should be, each axis, "
                                "relative to the tag's size: plates are bent"};
  Param<double> pixel_sigma{"pixel_sigma", 0.2, "px", between(0.001, 100),
                            "sigma of a corner, where the detector gives none"};
  Param<double> inlier_probability{"inlier_probability", 0.999, between(0.5, 0.999999),
                                   "probability that a right tag passes the test against the pose"};
  Param<int64_t> max_samples{"max_samples", 200, between(1, 1e6), "samples of three tags that are tried in each image"};
  Param<int64_t> min_markers{
      "min_markers", 3, between(3, 1000),
      "markers an image must show that are in the plate table, and that must agree with its pose"};
  Param<std::string> on_too_few{"on_too_few", "error", one_of("error", "skip"),
                                "what to do with an image that shows fewer: stop, or leave it out with a warning"};
  Param<int64_t> raw_tags{
      "raw_tags", 0, between(0, 1000),
      "0: search, test of every tag and refinement, the same for all solvers. n: what the solver alone makes of the n "
      "largest tags of an image, without covariance; to compare solvers, not for an adjustment"};
  Param<bool> look_for_causes{
      "look_for_causes", true,
      "where tags do not agree, try what would explain it (size, family, calibration, azimuths, "
      "numbers), which takes many times as long as the poses"};

 protected:
  PoseSettings settings_of(const Context& context) const;
  std::vector<ImageTagsT> images() const;
  void run_with(const Context& context, const TagPoseSolver& solver);
};

}  // namespace plumbline::pose
