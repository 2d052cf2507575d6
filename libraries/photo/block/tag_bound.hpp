// The Cramér-Rao bound of anchors in images of marker plates under survey control: what no estimator without bias can
// beat with this geometry and these observations, whatever its algorithm.
//
// Unknowns: pose of every image, pose of every plate, interior orientation with its prior, relative tag size of every
// print batch with its prior. Observations: tag corners and surveyed coordinates with their covariances. The bound is
// the inverse of the Fisher information of normally distributed observations (Rao 1945; for blocks of images Förstner
// and Wrobel 2016, section 15.3). Image poses are eliminated one by one, so that the rest is one dense system of
// plates, camera and batches, to which a full covariance of the control can be added.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::block {

struct BoundPlate {
  std::string anchor;
  Eigen::Vector3d position;  ///< of the anchor [m]
  Eigen::Quaterniond world_from_plate;
  std::array<Eigen::Vector3d, 4> corners_in_plate;  ///< [m]
  Eigen::Vector3d tag_centre_in_plate;              ///< [m]; a batch's tag size acts about it
  int batch = 0;
};

struct BoundTag {
  std::size_t image = 0, plate = 0;
  std::array<Eigen::Matrix2d, 4> covariances;  ///< of the corners [px²], positive definite
};

struct BoundProblem {
  BrownCamera camera;
  std::vector<int> free_parameters;  ///< of the camera, by their place in BrownCamera::parameters()
  Eigen::MatrixXd camera_prior;      ///< covariance of those; empty: none
  std::vector<RigidTransform> cam_from_world;
  std::vector<std::string> images;  ///< their names, for messages; may be empty
  std::vector<BoundPlate> plates;
  std::vector<BoundTag> tags;
  int batches = 0;
  double batch_scale_sigma = 1e-3;     ///< prior of the relative tag size; 0: known
  std::vector<std::size_t> control;    ///< indices of plates
  Eigen::MatrixXd control_covariance;  ///< 3m × 3m [m²], positive definite
};

/// What more observations say of some unknowns: their normal matrix.
struct BoundInformation {
  std::vector<Eigen::Index> unknowns;
  Eigen::MatrixXd matrix;
};

class TagBound {
 public:
  /// Throws std::runtime_error that names what is not determined: an image that shows too little, a motion of the
  /// block, or anchors.
  /// With Extent::anchors only anchors() may be asked for, at a third of the work.
  enum class Extent { everything, anchors };
  explicit TagBound(const BoundProblem& problem, Extent extent = Extent::everything);

  /// Covariance of all anchors, 3n × 3n in the order of the plates [m²]; infinite for those that no image shows.
  Eigen::MatrixXd anchors() const;

  /// What one more image would say; tags of plates that no image of the problem shows are left out.
  BoundInformation of_image(const RigidTransform& cam_from_world, const std::vector<BoundTag>& tags) const;

  /// What surveying the anchor of a plate would say, with independent coordinates of standard deviation `sigma` [m].
  BoundInformation of_survey(std::size_t plate, double sigma) const;

  /// Variances [m²] that the heights of `plates` would lose with `more`, from C' = C - C R (I + C R)^-1 C.
  Eigen::VectorXd height_gain(const BoundInformation& more, const std::vector<std::size_t>& plates) const;

 private:
  static constexpr int rest_stride = 16;  ///< plate 6, camera 9, batch 1
  using DerivativesByPose = Eigen::Matrix<double, 8, 6, Eigen::RowMajor>;
  using DerivativesByRest = Eigen::Matrix<double, 8, rest_stride, Eigen::RowMajor>;
  bool scales_batches() const { return problem_.batch_scale_sigma > 0; }
  void derivatives(const RigidTransform& pose, const BoundTag& tag, DerivativesByPose& by_pose,
                   DerivativesByRest& by_rest) const;
  void eliminate(const RigidTransform& pose, const std::vector<const BoundTag*>& tags, const std::string& image,
                 const std::vector<Eigen::Index>& place, Eigen::MatrixXd& matrix) const;
  void add_priors();
  void invert(Extent extent);
  Eigen::MatrixXd inverse_of_scaled(const Eigen::MatrixXd& scaled, const std::vector<Eigen::Index>& used,
                                    const Eigen::VectorXd& scale, Eigen::Index first) const;

  BoundProblem problem_;
  Eigen::Index camera_at_, batch_at_, size_;
  Eigen::MatrixXd information_;  ///< of plates (position, rotation), camera and batches
  Eigen::MatrixXd covariance_;   ///< its inverse, or that of anchors only; infinite variances where it says nothing
};

/// Covariance of all anchors: TagBound(problem).anchors(), and nothing else.
Eigen::MatrixXd tag_bound(const BoundProblem& problem);

}  // namespace plumbline::block
