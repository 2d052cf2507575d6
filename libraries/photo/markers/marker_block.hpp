// Blocks of photographs of square tags without a campaign: where the tags are is unknown or known approximately, the
// cameras calibrate themselves. Every tag is a square with a pose, a size and a slight bend of its own, so nothing is
// assumed of a board: not that it is flat, not how its tags are arranged.
//
// Units: m, rad, px. Frames: world; camera x right, y down, z forward; tag as in geometry/marker_plate.hpp (origin at
// its centre, x right, y up, z out of it). Corners in the order bottom left, bottom right, top right, top left.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "least_squares/problem/reliability.hpp"
#include "photo/markers/camera_changes.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

/// A camera as it is known beforehand.
struct MarkerCamera {
  std::string id;
  BrownCamera camera;          ///< its lens, and a start; fx = fy = 0 if the principal distance is unknown
  std::string source;          ///< where the start comes from, in words
  Eigen::MatrixXd covariance;  ///< 9 × 9 prior; empty: none. Parameters of variance 0 are held
  bool held = false;           ///< the interior orientation is taken as exact
  bool any_lens = false;       ///< the prior is of what EXIF says, not of a calibration: the lens may be another
  double pixel_pitch = std::numeric_limits<double>::quiet_NaN();  ///< edge of a pixel on the sensor [m]; nan: unknown
};

struct MarkerImage {
  std::string path;
  int camera = 0;  ///< index into MarkerBlock::cameras
  /// Standard deviation of how far all its edges are drawn inwards together, as the detector states it [px]; 0: it
  /// does not.
  double inset_sigma = 0;
};

struct Marker {
  std::string family;
  int id = 0;
  double size = 0;                               ///< nominal edge [m]
  std::optional<RigidTransform> world_from_tag;  ///< approximate place, from a layout
  std::string name() const { return std::to_string(id); }
};

/// A tag in an image.
struct MarkerView {
  int image = 0;   ///< index into MarkerBlock::images
  int marker = 0;  ///< index into MarkerBlock::markers
  std::array<Eigen::Vector2d, 4> corners;
  std::array<Eigen::Matrix2d, 4> covariances;  ///< [px²], positive definite
  bool refined = true;                         ///< false: a variance component of its own
};

struct MarkerBlock {
  std::vector<MarkerCamera> cameras;
  std::vector<MarkerImage> images;
  std::vector<Marker> markers;
  std::vector<MarkerView> views;
};

/// A measured distance between the centres of two tags: the scale of a free network.
struct MarkerDistance {
  int from = 0, to = 0;          ///< indices into MarkerBlock::markers
  double length = 0, sigma = 0;  ///< [m]
};

/// What turns a square into the four corners of a printed tag, as shares of half its edge: stretch, shear, keystones
/// along x and y, twist out of its plane. Together with pose and size these are all twelve coordinates of the corners.
constexpr int shape_count = 5;
using TagShape = std::array<double, shape_count>;

/// Corners in the tag's frame [m]; `half` is half of the edge.
std::array<Eigen::Vector3d, 4> shaped_corners(double half, const TagShape& shape);

struct MarkerOptions {
  double size_sigma = 1e-3;  ///< prior of each tag's size relative to nominal
  /// Priors of TagShape. Paper is wavy, so that tags are no plane squares: twist; 0 holds them plane. Print in the
  /// plane is taken as square, unless shape_sigma says how far it is off.
  double twist_sigma = 1e-2, shape_sigma = 0;
  /// What is not known of the printed size of all tags together [m]: ink that spreads, a printer's scale, a ruler. It
  /// is no unknown, because a free network does not see it: it comes into MarkerResult::scale_sigma.
  double print_sigma = 1e-4;
  /// Prior of how far the detector draws edges inwards [px], where MarkerImage::inset_sigma states none; 0 leaves it
  /// out.
  double inset_sigma = 0.3;
  double layout_position_sigma = 0.02;  ///< of a tag's place in the layout, each axis [m]
  double layout_rotation_sigma = 0.02;  ///< of its rotation, about each axis [rad]
  double reject_above = 5;  ///< tags whose rms residual is this many times the median are left out; 0 keeps all
  std::optional<MarkerDistance> distance;
  int max_iterations = 100;
};

struct AdjustedMarker {
  int marker = 0;  ///< index into MarkerBlock::markers
  RigidTransform world_from_tag;
  double scale = 1, scale_sigma = 0;  ///< size over nominal
  TagShape shape{};
  std::array<Eigen::Vector3d, 4> corners;
  Eigen::Matrix3d centre_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();  ///< of a rotation vector in the world frame [rad²]
  int images = 0;
};

struct AdjustedMarkerImage {
  int image = 0;
  bool oriented = false;
  std::string reason;  ///< why it is not oriented, or why its orientation is weak; empty for a sound one
  RigidTransform cam_from_world;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  /// Centre [m], then rotation vector in the camera frame [rad].
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Of the centre by the noise of the corners alone, root of the sum of the three variances [m]: what its geometry
  /// leaves open. `covariance` also holds what its camera differs by from the common one.
  double geometry_sigma = 0;
  int tags = 0;
  double rms = 0;  ///< of a corner coordinate [px]
  /// Of a photograph with one tag: the second pose that fits, with its residual over that of the first.
  std::optional<Eigen::Vector3d> other_centre;
  double ambiguity = 0;
};

struct AdjustedMarkerView {
  int view = 0;                              ///< index into MarkerBlock::views
  std::array<Eigen::Vector2d, 4> residuals;  ///< measured minus computed [px]
  double rms = 0;                            ///< of the 8 coordinates [px]
  double largest_w = 0, smallest_redundancy = 1;
};

struct AdjustedMarkerCamera {
  BrownCamera camera;
  /// 9 × 9, zero for held parameters: the larger of what the residuals and what the scatter of the photographs say.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd formal_covariance;  ///< 9 × 9, by the residuals alone
  CameraTruth truth;                  ///< whether its photographs are of one camera, and how they scatter
  double inset = 0, inset_sigma = 0;
  int images = 0, views = 0;
  double rms = 0;  ///< of a corner coordinate [px]
};

struct MarkerResult {
  std::vector<AdjustedMarkerCamera> cameras;             ///< as MarkerBlock::cameras
  std::vector<AdjustedMarker> markers;                   ///< those that could be placed
  std::vector<AdjustedMarkerImage> images;               ///< as MarkerBlock::images
  std::vector<AdjustedMarkerView> views;                 ///< those that took part
  Eigen::MatrixXd centre_covariance;                     ///< 3n × 3n of all centres, inner constraints or layout [m²]
  std::vector<least_squares::VarianceComponent> groups;  ///< before their factors were applied: estimated over stated
  int observations = 0, unknowns = 0, datum_defect = 0, degrees_of_freedom = 0;
  double weighted_sum_of_squares = 0, sigma0 = 0;
  double rms = 0;                     ///< of all corner coordinates [px]
  std::vector<int> rejected;          ///< views left out as blunders
  std::vector<std::string> left_out;  ///< what could not take part, and why
  std::vector<std::string> warnings;
  std::string datum;  ///< in words
  /// Relative standard deviation of all lengths together, which the covariances above leave out: of the tags' printed
  /// size and of what their inset differs by from tag to tag, or of the given distance. 0 with a layout.
  double scale_sigma = 0;
};

/// Adjusts the block. Free network with inner constraints over all tags' centres if no tag has a place in a layout; the
/// frame is then that of the tag with the lowest id. Throws std::runtime_error that names the cause: no tag in two
/// images, fewer than two images of one object, a rank defect (by its unknowns), no convergence.
MarkerResult adjust_marker_block(const MarkerBlock& block, const MarkerOptions& options);

/// The same, and where cameras that calibrate themselves see tags more than 35° off the axis and the fisheye's model
/// leaves less than 0.85 of the residuals of Brown's, which has a parameter more: with fisheyes, which `block` and a
/// warning then say.
MarkerResult adjust_lens_and_block(MarkerBlock& block, const MarkerOptions& options);

}  // namespace plumbline::markers
