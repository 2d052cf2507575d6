// Whether all photographs are of one camera: parts of them, split by the order of their names, each against the other.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "markers/camera_evidence.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

struct CameraChange {
  enum class Split { from_on, drift, every, some, upside_down };
  enum class What { focus, aspect, principal_point, distortion };
  Split split = Split::from_on;
  What what = What::focus;
  /// Photographs of the second part, indices into CameraEvidence::paths; of a drift those of its second half.
  std::vector<int> second;
  int period = 0;  ///< of Split::every: each second, third or fourth
  /// How the second part differs from the first (of a drift: the last photograph from the first): of the principal
  /// distance and the aspect relative; of the principal point [px], x and y; of the distortion k1.
  Eigen::Vector2d by = Eigen::Vector2d::Zero();
  double level = 1;  ///< part of the permutations of the photographs that split as well
  /// Standard deviations of `by` where two adjustments gave it (TwoCameras); zero: a guess from the one, which may be off
  /// by several times, and in its sign.
  Eigen::Vector2d by_sigma = Eigen::Vector2d::Zero();
  /// A division by where the photographs were taken, or how the camera was held, explains as much.
  bool or_place = false;
};

/// Fewer photographs than this are not compared with each other: too few orders of them are distinct, and where they
/// were taken explains too much.
constexpr int fewest_to_compare = 12;

/// Splits all photographs in every way that has a name and asks whether the parts differ in their camera by more than
/// photographs that change places do: by the order of the names (every cut, a drift, every second to fourth one) and
/// by how the camera was held; and whether single photographs fall into two groups by their principal distance and
/// point, in no order. The scatter of the photographs is the yardstick, so what all of them have of rolling shutter or
/// of a lens that is not quite the model does not count. What goes with the place of a photograph (tilt, roll, distance)
/// is taken out first, and what is left changes places (Freedman and Lane 1983): photographs are taken walking, and a
/// board that is not quite the model looks the same from neighbouring places. `cam_from_object`: poses in the order of
/// the evidence. `causes`: of the scatter.
/// Nothing with fewer than fewest_to_compare photographs. A permutation test (Good 2005, 3.4) of the best split, seeded.
std::optional<CameraChange> find_change(const CameraEvidence& evidence, const BrownCamera& camera,
                                        const std::vector<RigidTransform>& cam_from_object,
                                        const std::vector<Scatter>& causes);

/// "from IMG_0021.JPG on the principal distance is 2.01 ± 0.05 % longer: focus or zoom"; "is another" where there is but
/// one adjustment, which does not say by how much.
std::string in_words(const CameraChange& change, const CameraEvidence& evidence);

/// Whether the parts are two cameras that can be adjusted apart: no drift.
bool divides(const CameraChange& change);

/// All that the photographs say of whether they are of one camera.
struct CameraTruth {
  CameraEvidence evidence;
  EmpiricalCovariance empirical;
  std::vector<Scatter> scatter;  ///< its causes
  std::optional<CameraChange> change;
};

CameraTruth judge_camera(CameraEvidence evidence, const BrownCamera& camera,
                         const std::vector<RigidTransform>& cam_from_object);

/// The change, or that the photographs are too few to see one; and the scatter where that is larger than the corners
/// allow: sentences to warn with, without a full stop.
std::vector<std::string> warnings_of(const CameraTruth& truth);

/// The photographs of a change adjusted as two cameras, on the observations of the adjustment as one.
struct TwoCameras {
  BrownCamera first, second;
  Eigen::MatrixXd first_covariance, second_covariance;  ///< 9 × 9
  double rms_as_one = 0, rms_as_two = 0;                ///< [px]
  int more_unknowns = 0;                                ///< that two have
  int redundancy = 0;                                   ///< of two
};

/// Whether two fit better than one by more than their unknowns make (F-test, 0.1 %).
bool fits_better(const TwoCameras& two);

/// Puts the difference of the two into the change, or takes the change back where two fit no better. What to say of it:
/// "as two cameras, fx 811.9 ± 0.6 and 852.5 ± 0.7 px, they fit to 0.24 px rms, as one to 0.31 px", the principal
/// distances only where they differ by two standard deviations.
std::string settle_change(CameraTruth& truth, const TwoCameras& two);

}  // namespace plumbline::markers
