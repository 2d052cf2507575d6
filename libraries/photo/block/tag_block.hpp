// Bundle adjustment of images of marker plates, equations (4) and (5): camera poses, plate poses, interior orientation,
// and as nuisance the size error of each print batch of tags and the detector's corner inset. Control is what a survey
// says of some anchors; without it the network is free.
//
// Units: m, rad, px. Frames: world is that of the approximate poses and of the control (z up); camera x right, y down,
// z forward; plate as in geometry/marker_plate.hpp, its origin is the anchor.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "geometry/marker_plate.hpp"
#include "photo/bundle/adjust.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::block {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
enum class RobustLoss { none, huber, cauchy, tukey };

/// A camera, and what is known of it beforehand.
struct TagCamera {
  std::string name = "camera";  ///< for messages
  BrownCamera interior;
  Eigen::MatrixXd covariance;  ///< 9 × 9 prior of the interior orientation; empty: none
  /// d1, d2 [m] and the distance Z0 [m] where the distortion is that of `interior`, held unless they are estimated; Z0
  /// of 0: the median distance.
  Eigen::Vector2d distance_terms = Eigen::Vector2d::Zero();
  double reference_distance = 0;
};

struct TagImage {
  std::string name;
  std::optional<RigidTransform>
      cam_from_world;  ///< approximate; images without one are oriented from plates they share
  Eigen::Vector2d principal_point = Eigen::Vector2d::Zero();  ///< minus the camera's [px]; held unless it is estimated
  int camera = 0;                                             ///< index into TagBlock::cameras
  /// Standard deviation of how far all its edges are drawn inwards together, as the detector states it [px]; 0: it
  /// does not.
  double inset_sigma = 0;
};

struct TagPlate {
  std::string anchor;
  MarkerPlate plate;
  Eigen::Quaterniond nominal_rotation = Eigen::Quaterniond::Identity();  ///< world_from_plate, true to some 20 degrees
  std::string batch;                                                     ///< print batch
};

/// One tag seen in one image, corners in libapriltag's order.
struct TagObservation {
  int image = 0;  ///< index into TagBlock::images
  int plate = 0;  ///< index into TagBlock::plates
  std::array<Eigen::Vector2d, 4> corners;
  std::array<Eigen::Matrix2d, 4> covariances;  ///< [px²]; ignored in lambda weighting
};

/// Survey coordinates of some anchors with their full covariance.
struct TagControl {
  std::vector<int> plates;     ///< indices into TagBlock::plates
  Eigen::VectorXd position;    ///< 3m [m]
  Eigen::MatrixXd covariance;  ///< 3m × 3m [m²], positive definite
};

struct TagBlock {
  std::vector<TagCamera> cameras;
  std::vector<TagImage> images;
  std::vector<TagPlate> plates;
  std::vector<TagObservation> observations;
  TagControl control;
};

struct TagBlockOptions {
  enum class Weighting { covariance, lambda } weighting = Weighting::covariance;
  /// λ of (5) [px²/m²]: Σ‖x − π‖² + λ Σ‖X − X^S‖² is minimised, corners unweighted. Equal to weights by covariance if
  /// corners have σ_px and control has σ_S = σ_px/√λ in each coordinate.
  double lambda = 1e4;
  /// Standard deviation of a corner coordinate in lambda weighting [px]: scales the covariances of the result, not the
  /// solution.
  double corner_sigma = 0.1;
  bool free_network = false;  ///< ignore control; datum by inner constraints over all anchors
  bool self_calibration = true;
  /// d1 and d2, which let k1 and k2 change with the distance (bundle/lens.hpp), only on request.
  std::vector<std::string> free_interior = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"};
  /// Standard deviation of each image's own principal point about the camera's [px]; 0: they share one.
  double image_principal_point_sigma = 0;
  bool fixed_aspect = false;  ///< hold fy/fx
  /// Prior standard deviation of a batch's relative tag size; 0 holds it at 1 (then tags carry scale), infinity leaves
  /// it free.
  double tag_scale_sigma = 1e-3;
  /// Prior standard deviation of a batch's corner inset [px]: how far the detector draws each edge inwards. Where
  /// TagImage::inset_sigma states one, that takes its place; 0 leaves the inset out.
  double corner_inset_sigma = 0;
  RobustLoss loss = RobustLoss::huber;
  double loss_scale = 2;  ///< of the root mean square of a tag's 8 residuals, in standard deviations
  double reject_above =
      5;  ///< tags whose root mean square is above are left out of the final least squares; 0 keeps all
  /// Control points that contradict the photographs and the other control (three coordinates together, level 0.001 over
  /// all points) are left out of the datum, the worst first and one at a time. What contradicts and cannot be left out
  /// stays, and TagBlockResult::control_doubts say why: other points would explain the same, the rest does not hold the
  /// block, more than a third would go, or it contradicts only as far as a prior is believed that fails its own test.
  /// Then the block fails, whatever the test over all of the control says. Weights by covariance only.
  bool robust_control = false;
  bool test_control = true;  ///< false: control is not tested point by point, and nothing of it left out or named
  /// Groups of control plates, indices into TagBlock::plates: what the adjustment without a group says of it is in
  /// TagBlockResult::withheld, one of a group. Nothing is adjusted again.
  std::vector<std::vector<int>> withhold = {};
  /// Scales the corner covariances so that the images' variance component becomes 1 (Förstner 1979): detectors rarely
  /// know theirs.
  bool estimate_image_variance = true;
  double weak_ratio = 30;  ///< see analyse_datum()
  /// Gives TagBlockResult::orientation_covariance.
  bool joint_orientations = false;
  int max_iterations = 100;
  int threads = 1;
  std::function<void(std::size_t)> announce;  ///< see bundle::AdjustOptions; may be told more than once
  bundle::Minimiser minimiser = bundle::minimise_schur;
  /// From the robust solution undamped steps are tried before the engine is asked; not where an engine is to show
  /// itself.
  bool refine_robust = true;
};

struct AdjustedTag {
  int observation = 0;            ///< index into TagBlock::observations
  double rms = 0;                 ///< of its 8 residuals [px]
  double largest_normalised = 0;  ///< |w|
  double smallest_redundancy = 0;
  double largest_detectable_error = 0;  ///< MDB [px]
};

struct AdjustedControl {
  int plate = 0;
  std::array<least_squares::RowStatistics, 3> coordinates;  ///< [m]; residual is adjusted minus survey
  /// Effect of an undetected error of the size of the MDB in each coordinate: largest change of any anchor's height
  /// [m].
  std::array<double, 3> effect_on_height{};
};

/// A control point that was left out: what the rest says of it, and how far that is from the survey.
struct RejectedControl {
  int plate = 0;
  Eigen::Vector3d off = Eigen::Vector3d::Zero();    ///< survey minus model without it [m]
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< of that difference, if nothing were wrong [m]
  double test = 0, limit = 0;                       ///< chi-squared, when it was left out
  int freedom = 3;                                  ///< of that
};

/// Control that contradicts the photographs and the other control and was kept all the same.
struct ControlDoubt {
  double test = 0, limit = 0;  ///< chi-squared of the point that contradicts most
  int freedom = 3;
  std::string words;  ///< which points, and why they were kept
};

/// Control points against what an adjustment without them says: survey minus model, minus what the survey's
/// correlations make the other control predict of it, and the covariance of that difference with everything in it
/// (images, the other control, the survey of the points themselves).
struct WithheldControl {
  std::vector<int> plates;
  Eigen::VectorXd off;         ///< 3n [m]
  Eigen::MatrixXd covariance;  ///< 3n × 3n [m²]
  std::string undetermined;    ///< why there is nothing: without these points the rest does not hold the block
};

/// A global test: the variance of a group of observations against what was assumed of it before the adjustment.
struct GroupTest {
  enum class Kind { observations, principal_points, distances };  ///< the last two: what the camera model leaves out
  std::string group;
  Kind kind = Kind::observations;
  double factor = 1;  ///< estimated over assumed variance
  double limit = 1;   ///< the test fails above it
  bool passed = true;
  std::string words;  ///< what a failure means
  /// Of principal points: rms of the step to those of single images [px], what image_principal_point_sigma has to be.
  double shift = std::numeric_limits<double>::quiet_NaN();
  /// By which the standard deviations of anchors are larger for it, the largest: their covariance has what it moves
  /// them by. nan: it has not.
  double points_factor = std::numeric_limits<double>::quiet_NaN();
};

/// A principal point of an image's own: its difference from the camera's.
struct ImagePrincipalPoint {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();       ///< [px]
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< [px²]
};

/// Tags printed together. How far edges are drawn inwards is the camera's as well: with several cameras the first has
/// the inset of the batch, each further one an entry of its own, "BATCH in CAMERA", whose scale is held at 1.
struct TagBatch {
  std::string name;
  double scale = 1, scale_sigma = 0;  ///< estimated tag size over nominal
  double inset = 0, inset_sigma = 0;  ///< [px]
  std::string batch = {};             ///< its name without the camera
  int camera = 0;
};

struct AdjustedTagCamera {
  BrownCamera interior;
  Eigen::MatrixXd covariance;  ///< 9 × 9, zero for parameters held fixed
  /// d1, d2 [m], and the distance Z0 [m] at which the distortion is that of `interior`; zero if there are none.
  Eigen::Vector2d distance_terms = Eigen::Vector2d::Zero();
  double reference_distance = 0;
};

struct TagBlockResult {
  std::vector<AdjustedTagCamera> cameras;  ///< in the order of TagBlock::cameras
  /// 11n × 11n: of each camera's nine values and d1, d2, zero for what is held; empty: not known.
  Eigen::MatrixXd interior_covariance;
  std::vector<ImagePrincipalPoint> principal_points;          ///< one an image, if images have their own
  std::vector<std::optional<RigidTransform>> cam_from_world;  ///< one an image; nothing if left out
  std::vector<Matrix6> pose_covariance;  ///< rotation vector in the camera frame, translation; empty: not known
  /// Of all oriented images in their order rotation vector, translation and own principal point (8), then of each
  /// camera its nine parameters; zero for what is held; empty unless asked for.
  Eigen::MatrixXd orientation_covariance;
  std::vector<int> plates;            ///< adjusted plates, indices into TagBlock::plates
  Eigen::VectorXd anchors;            ///< 3n, in the order of `plates` [m]
  Eigen::MatrixXd anchor_covariance;  ///< 3n × 3n [m²]; empty: not known
  std::vector<Eigen::Quaterniond> world_from_plate;
  std::vector<int> images_per_plate;
  std::vector<TagBatch> batches;

  int observations = 0, unknowns = 0, datum_defect = 0, degrees_of_freedom = 0, iterations = 0;
  double weighted_sum_of_squares = 0, sigma0 = 0;
  double image_variance_factor = 1;  ///< by which the given corner covariances were multiplied
  std::vector<least_squares::VarianceComponent> groups;
  /// Images against the detector's own covariances (before image_variance_factor), within what detectors are wrong by;
  /// control, interior and tag scale priors by the chi-squared test. Where single control points contradict and stay,
  /// "control points" is a test that fails.
  std::vector<GroupTest> tests;
  /// Whether the images ask for more than the camera model that was used: image-variant principal point, distortion
  /// that changes with the distance. A test that fails names what to set, and makes no block invalid.
  std::vector<GroupTest> models;
  std::vector<double> plate_w;  ///< largest |w| of the control coordinates and of the median tag at each plate
  std::vector<AdjustedTag> tags;
  std::vector<AdjustedControl> control;
  std::vector<int> rejected;  ///< observations left out as blunders
  std::vector<RejectedControl> rejected_control;
  std::vector<ControlDoubt> control_doubts;
  std::vector<WithheldControl> withheld;  ///< one of each TagBlockOptions::withhold
  std::vector<std::string> weak_datum;    ///< motions of the block that control holds only weakly
  double weakest_datum_sigma = 0;         ///< [m], see DatumAnalysis
  std::vector<std::string> left_out;      ///< images and plates that could not be placed, with the reason
  std::vector<std::string> warnings;      ///< what people should know although the block could be adjusted
};

/// The adjustment. Covariances are with σ0 = 1 a priori (corner covariances scaled by image_variance_factor).
/// Throws std::runtime_error that names the cause: too few images or tags, control that leaves the datum undetermined
/// (the motions by name) or contradicts the images (another unit, exchanged plates), any other rank defect (the
/// unknowns by name), no convergence (its cause).
TagBlockResult adjust_tag_block(const TagBlock& block, const TagBlockOptions& options);

}  // namespace plumbline::block
