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

namespace plumbline::evaluate {

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
  std::vector<BoundPlate> plates;
  std::vector<BoundTag> tags;
  int batches = 0;
  double batch_scale_sigma = 1e-3;     ///< prior of the relative tag size; 0: known
  std::vector<std::size_t> control;    ///< indices of plates
  Eigen::MatrixXd control_covariance;  ///< 3m × 3m [m²], positive definite
};

/// Covariance of all anchors, 3n × 3n in the order of the plates [m²]. Throws std::runtime_error that names what is not
/// determined: an image that shows too little, or the datum.
Eigen::MatrixXd tag_bound(const BoundProblem& problem);

}  // namespace plumbline::evaluate
