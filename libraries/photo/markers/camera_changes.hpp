// Whether all photographs are of one camera: every change that has a name against none, in one likelihood.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "photo/markers/camera_evidence.hpp"
#include "photo/markers/photograph_effects.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

struct CameraChange {
  /// `stretches`: there and back, once or more often; `some`: in no order.
  enum class Split { from_on, drift, every, some, upside_down, stretches };
  /// `undistorted`: a program took the distortion away; `turned`: a program turned the pictures by 180 degrees;
  /// `several`: principal distance, principal point and distortion together, as of another camera.
  enum class What { focus, aspect, principal_point, distortion, undistorted, turned, several };
  Split split = Split::from_on;
  What what = What::focus;
  /// Photographs of the second part, indices into CameraEvidence::paths; of a drift those of its second half.
  std::vector<int> second;
  int period = 0;  ///< of Split::every: each second, third or fourth
  /// How the second part differs from the first (of a drift: the last photograph from the first), and its standard
  /// deviation: focus and aspect relative; the principal point [px], x and y; the distortion k1, k2; of several the
  /// principal distance, the principal point, k1, k2; undistorted: of the mean distortion; turned: as principal_point.
  Eigen::VectorXd by, sigma;
  /// Logarithm of the odds of all changes together against photographs that are alike in what differs.
  double log_odds = 0;
  /// Whether the photographs tell this split from all others and from photographs that differ in no order, and this
  /// cause from all others (9 of 10). What is not told apart is not named.
  bool split_is_clear = false, what_is_clear = false;
  /// The photographs were taken place after place in the order of the split, so that what goes with the places (a board
  /// that is not as the model has it) may be what differs.
  bool or_place = false;
  /// Of a principal point: that of the one part is the other's with left and right exchanged, as a mirrored picture of
  /// a board without marks that are read has it.
  bool or_mirrored = false;
  bool or_turned = false;  ///< the same of one that is the other's turned about the middle of the image
  std::vector<std::pair<What, double>> causes;  ///< with their probabilities, the likeliest first
};

/// Compares the likelihood of the photographs' scores (photograph_effects.hpp) with and without a change: at every cut
/// in the order of their names, bit by bit, in every second to fourth one, in stretches between which it goes there and
/// back, in the photographs that fall into two groups by themselves (of the principal distance also as two_groups.hpp
/// tells them), in those that are held upside down; in the
/// principal distance, the aspect, the principal point, the distortion, or all of them. Each may be of any plausible
/// size, which is integrated over, so that a change that could be any must explain more (marginal likelihood; MacKay
/// 2003, 28). What scatters from photograph to photograph and what goes with the places they were taken from is
/// estimated beside every change. `cam_from_object`: poses in the order of the evidence. Nothing with fewer than eight
/// photographs, and up to odds of 150 to 1 (3000 to 1 where the order of the names is that of the places).
std::optional<CameraChange> find_change(const CameraEvidence& evidence, const BrownCamera& camera,
                                        const std::vector<RigidTransform>& cam_from_object);

/// "from IMG_0021.JPG on the principal distance is 2.01 ± 0.05 % longer: focus or zoom".
std::string in_words(const CameraChange& change, const CameraEvidence& evidence);

/// Whether the parts are two cameras that can be adjusted apart: no drift.
bool divides(const CameraChange& change);

/// One cause of the scatter of the photographs beside the noise of their corners.
struct Scatter {
  Strengths::Kind kind = Strengths::focus;  ///< focus, principal_point, rows or place
  double rms = 0;                           ///< of focus: relative; principal point and rows [px]; place: no unit
  bool or_point = false;                    ///< of rows: a principal point that moves would do as well
};

/// The effects without which the photographs are less likely by a factor of exp(5), however strong the others may be
/// in their place; none where several would do.
std::vector<Scatter> causes_of_scatter(const CameraEvidence& evidence, const BrownCamera& camera,
                                       const std::vector<RigidTransform>& cam_from_object);

/// All that the photographs say of whether they are of one camera.
struct CameraTruth {
  CameraEvidence evidence;
  EmpiricalCovariance empirical;
  std::vector<Scatter> scatter;  ///< causes, where there is no change
  std::optional<CameraChange> change;
  double focal_length = 0;  ///< fx [px]
  /// Roots of the covariance of what each photograph's camera has beside the common one, rows as the scores in
  /// `evidence`: by itself, and in columns that all share; empty with fewer than eight photographs.
  std::vector<Eigen::MatrixXd> own_effects, common_effects;
  double corner_factor = 1;  ///< variance factor of the corners beside them, at least 1
};

/// Relative change of the principal distance from one half of the photographs to the other below which find_change()
/// could hardly tell it from their scatter; 0 where fewer photographs than fewest_to_scatter say nothing of that.
double hidden_focus_change(const CameraTruth& truth);

CameraTruth judge_camera(CameraEvidence evidence, const BrownCamera& camera,
                         const std::vector<RigidTransform>& cam_from_object);

/// What to say of a camera whose photographs scatter by more than its corners allow; empty if they do not.
std::string in_words(const EmpiricalCovariance& empirical, const std::vector<Scatter>& causes);

/// The change, or the scatter where that is larger than the corners allow: sentences to warn with, without a full
/// stop.
std::vector<std::string> warnings_of(const CameraTruth& truth);

}  // namespace plumbline::markers
