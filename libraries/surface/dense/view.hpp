// An oriented photograph, and what its projection is at one place of a facade.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "photo/images/grey_image.hpp"
#include "plumbline/rigid_transform.hpp"
#include "surface/dense/facade_plane.hpp"

namespace plumbline::surface {

/// A photograph with its orientation.
struct View {
  std::string name;
  BrownCamera camera;  ///< with the image's own principal point, if it has one
  RigidTransform cam_from_world;
  int orientation = -1;  ///< which of the images of OrientationCovariance it is
  int camera_number = 0;
};

/// Joint covariance of all exterior and interior orientations. What errs in them errs in thousands of points alike, so
/// no number of points averages it out.
struct OrientationCovariance {
  int images = 0, cameras = 0;
  static constexpr int per_image = 8, per_camera = 9;
  /// (8 · images + 9 · cameras)², of each image the rotation vector in the camera frame [rad], the translation [m] and
  /// its own principal point [px], of each camera fx, fy, cx, cy, k1, k2, k3, p1, p2; zero for what is held.
  Eigen::MatrixXd matrix;
  Eigen::Index size() const { return of_camera(cameras); }
  Eigen::Index of_image(int image) const { return per_image * Eigen::Index{image}; }
  Eigen::Index of_camera(int camera) const { return of_image(images) + per_camera * Eigen::Index{camera}; }
};

/// The projection of a place (u, v, h) of the facade, linear around it.
struct LocalMap {
  Eigen::Vector2d pixel;                  ///< [px]
  Eigen::Matrix<double, 2, 3> by_place;   ///< [px/m] by u, v, h
  Eigen::Matrix<double, 2, 8> by_image;   ///< [px/rad, px/m, 1] in the order of OrientationCovariance
  Eigen::Matrix<double, 2, 9> by_camera;  ///< by the nine parameters
  /// How far the place seems to move on the facade's plane, per metre of height: the ray's slope.
  Eigen::Vector2d parallax() const { return by_place.leftCols<2>().inverse() * by_place.col(2); }
  /// Edge of a pixel on the facade, the geometric mean of both directions [m].
  double ground_pixel() const { return 1 / std::sqrt(std::abs(by_place.leftCols<2>().determinant())); }
};

/// Nothing where the place lies behind the camera, outside of the image (by `margin` [px]) or is seen from behind.
std::optional<LocalMap> map_at(const View& view, const FacadePlane& plane, const Eigen::Vector3d& place, double margin);

/// Photographs whose rays to a place differ by less (half a degree, as a slope) are taken from one place: copies of
/// one, a burst, exposures from a tripod. The second says nothing of depth that the first does not, and agrees with it
/// whatever both show, so that it is no witness.
constexpr double kOnePlace = 0.0087;

/// Numbers of those that look at a place (u, v) from places of their own; of several from one the first.
std::vector<size_t> from_own_places(const FacadePlane& plane, const Eigen::Vector2d& place,
                                    const std::vector<View>& views);

/// A photograph in three resolutions: each is the mean of 2 × 2 pixels of the one before.
struct Pyramid {
  static constexpr int levels = 3;
  GreyImage level[levels];
};
Pyramid pyramid_of(GreyImage image);

}  // namespace plumbline::surface
