// The one block model: images of several cameras that see points, targets and marker plates, with what else is known of
// them (distances, coordinates, calibrations, printed sizes). Every reader and every front-end ends in a Problem and a
// State; every adjuster starts from them. Nothing here solves anything.
//
// Units: object space in m, rotations in rad, image coordinates in what the camera's lens model uses (px or mm).
// Frames: object space is a local frame: coordinates of a site with seven digits are to be shifted by whole metres
// first. A pose maps x_camera = R (X − C).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geometry/marker_plate.hpp"
#include "photo/bundle/lens.hpp"

namespace plumbline::bundle {

struct Camera {
  std::string name;
  Lens lens = Lens::brown;
  double balance_radius = 0;  ///< [mm], balanced model only
  std::vector<bool> free;     ///< which of the lens' values are unknown
  /// 1/Z0 [1/m] of a distortion that depends on the distance, see lens.hpp; 0: its coefficients are those at infinity.
  double inverse_reference = 0;
};

struct Image {
  std::string name;
  int camera = 0;
  bool fixed = false;       ///< the pose is known exactly
  bool shift_free = false;  ///< the image has a principal point of its own
  int mount = -1;           ///< its camera's place in a rig; −1: none, the pose is that of the camera
  int exposure = -1;        ///< the image that was taken at the same moment and whose pose is the rig's; −1: this one
};

/// The place of a camera in a rig: camera from rig, x_camera = R (x_rig − C).
struct Mount {
  std::string name;
  bool fixed = false;
};

/// A sheet that may be bent: two unknowns [m] that move its points along z.
struct Sheet {
  std::string name;
  bool bend_free = false;
};

struct Point {
  std::string name;
  bool fixed = false;                               ///< the coordinates are known exactly
  int sheet = -1;                                   ///< of a fixed point: the sheet it is on; −1: none
  Eigen::Vector2d bent_by = Eigen::Vector2d(0, 0);  ///< by how much of the sheet's two unknowns it is moved
};

/// What turns a square into the four corners of a printed tag, as shares of half its edge: stretch, shear, keystones
/// along x and y, twist out of its plane. Together with place and size these are all twelve coordinates of the corners.
constexpr int form_count = 5;
using Form = std::array<double, form_count>;

/// A plate is a body of six unknowns: its anchor and its rotation.
struct Plate {
  std::string name;
  MarkerPlate shape;
  int batch = 0;
  int form_begin = 0, form_end = 0;  ///< which values of its tag's form are unknown
};

/// Tags printed together share a relative size and an inset of their detected edges.
struct Batch {
  std::string name;
  bool scale_free = false, inset_free = false;
};

/// What an unknown belongs to.
enum class Kind { image, point, plate, camera, scale, inset, shift, form, mount, bend };
constexpr int kind_count = 10;
struct Ref {
  Kind kind;
  int index;
};

/// Whitening W of an observation with covariance Σ: WᵀW = Σ⁻¹.
struct ImagePoint {
  int image = 0, point = 0;
  Eigen::Vector2d observed = Eigen::Vector2d::Zero();
  Eigen::Matrix2d whitening = Eigen::Matrix2d::Identity();
  int group = 0;
  bool robust = false;
};

struct ImageTag {
  int image = 0, plate = 0;
  std::array<Eigen::Vector2d, 4> corners;  ///< libapriltag's order, see geometry/marker_plate.hpp
  std::array<Eigen::Matrix2d, 4> whitening;
  int group = 0;
  bool robust = false;
  int inset = -1;  ///< the batch whose inset the detector drew here; −1: that of the plate
};

/// A known distance between two bodies (points, or anchors of plates).
struct Distance {
  std::string name;
  Ref from{Kind::point, 0}, to{Kind::point, 0};
  double length = 0, sigma = 0;  ///< [m]
  int group = 0;
};

/// W (x − target) over coordinates of a few refs: three of a point, of a plate's anchor or of an image's projection
/// centre, all values of a camera or a form, one of a scale or an inset, two of an image's shift or of a sheet's bend.
/// Known coordinates with their full covariance, the calibration of a camera, a printed size.
struct Known {
  std::vector<Ref> refs;
  Eigen::VectorXd target;
  Eigen::MatrixXd whitening;
  int group = 0;
  /// Of a single plate: three more coordinates, the rotation vector in the object frame by which it is turned off this.
  /// They are weighed alike: then their derivative by the plate's rotation is the unit matrix as far as the minimum
  /// goes (the vector is its own image), and to the square of the vector as far as covariances do.
  std::optional<Eigen::Quaterniond> world_from_plate = {};
};

struct Group {
  std::string name;
  double sigma_factor = 1;  ///< multiplies all a priori standard deviations of the group
};

struct Problem {
  std::vector<Camera> cameras;
  std::vector<Image> images;
  std::vector<Point> points;
  std::vector<Plate> plates;
  std::vector<Batch> batches;
  std::vector<Mount> mounts = {};
  std::vector<Sheet> sheets = {};
  std::vector<ImagePoint> image_points;
  std::vector<ImageTag> image_tags;
  std::vector<Distance> distances;
  std::vector<Known> known;
  std::vector<Group> groups;

  int row_count() const;
  /// The image whose pose is this one's, or this one's rig's.
  int pose_of(int image) const {
    const int exposure = images[image].exposure;
    return exposure < 0 ? image : exposure;
  }
  /// Throws std::runtime_error for an index out of its range or a whitening of the wrong size.
  void require_consistent() const;
};

/// Rotation and position: cam_from_world and projection centre of an image, world_from_plate and anchor of a plate.
struct Placement {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  ///< of `rotation`; kept by set()
  void set(const Eigen::Quaterniond& q, const Eigen::Vector3d& p) {
    rotation = q.normalized();
    position = p;
    matrix = rotation.toRotationMatrix();
  }
};

using Interior = std::array<double, max_interior>;

/// The values of all unknowns.
struct State {
  std::vector<Placement> images;  ///< cam_from_world, projection centre
  std::vector<Eigen::Vector3d> points;
  std::vector<Placement> plates;  ///< world_from_plate, anchor
  std::vector<Interior> interiors;
  std::vector<double> scales, insets;  ///< one a batch: size over nominal, inset [px]
  /// One an image, or none at all: principal point minus that of its camera, in the image's unit.
  std::vector<Eigen::Vector2d> shifts = {};
  Eigen::Vector2d shift(int image) const { return shifts.empty() ? Eigen::Vector2d(0, 0) : shifts[image]; }
  std::vector<Form> forms = {};  ///< one a plate, or none at all: squares
  std::vector<Placement> mounts = {};
  std::vector<Eigen::Vector2d> bends = {};  ///< one a sheet
};

/// Blocks of unknowns and their numbers. A block is what belongs to one Ref: six of an image (position, then a rotation
/// vector in the camera frame on top of the rotation), three of a point, six of a plate (anchor, rotation vector in the
/// object frame), the free values of a camera, one of a scale or an inset, two of the shift of an image's principal
/// point, the free values of a plate's form, six of a mount as of an image, two of a sheet. What is held has a block of
/// size 0.
class Layout {
 public:
  explicit Layout(const Problem& problem);
  int block_count() const { return static_cast<int>(sizes_.size()); }
  int unknown_count() const { return offsets_.back(); }
  int block(Ref ref) const { return first_[static_cast<size_t>(ref.kind)] + ref.index; }
  Ref ref(int block) const;
  int size(int block) const { return sizes_[block]; }
  int offset(int block) const { return offsets_[block]; }
  /// Values of the camera that are unknowns, in their order.
  const std::vector<int>& free_values(int camera) const { return free_values_[camera]; }

 private:
  std::array<int, kind_count + 1> first_{};
  std::vector<int> sizes_, offsets_;
  std::vector<std::vector<int>> free_values_;
};

/// Rotation vector of to · from⁻¹, at most half a turn long.
Eigen::Vector3d turn_between(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to);

/// Adds a step in all unknowns (see Layout) to the state.
void apply_step(const Problem& problem, const Layout& layout, const Eigen::VectorXd& step, State& state);

/// "x of point 12", "rotation of image 3", "k1 of camera c" — for messages.
std::string name_of_unknown(const Problem& problem, const Layout& layout, int unknown);

}  // namespace plumbline::bundle
