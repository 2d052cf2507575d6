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
};

/// Splits all photographs in every way that has a name and asks whether the parts differ in their camera by more than
/// photographs that change places do: by the order of the names (every cut, a drift, every second to fourth one) and
/// by how the camera was held; and whether the principal distances of single photographs fall into two groups. The
/// scatter of the photographs is the yardstick, so what all of them have of rolling shutter or of a lens that is not
/// quite the model does not count. `cam_from_object`: poses in the order of the evidence.
/// Nothing with fewer than eight photographs. A permutation test (Good 2005, 3.4) of the best split's F, seeded.
std::optional<CameraChange> find_change(const CameraEvidence& evidence, const BrownCamera& camera,
                                        const std::vector<RigidTransform>& cam_from_object);

/// "from IMG_0021.JPG on the principal distance is 2.0 % longer (focus or zoom)", and what to do.
std::string in_words(const CameraChange& change, const CameraEvidence& evidence);

/// Whether the parts are two cameras that can be adjusted apart: no drift.
bool divides(const CameraChange& change);

/// All that the photographs say of whether they are of one camera.
struct CameraTruth {
  CameraEvidence evidence;
  EmpiricalCovariance empirical;
  Scatter scatter;
  std::optional<CameraChange> change;
};

CameraTruth judge_camera(CameraEvidence evidence, const BrownCamera& camera,
                         const std::vector<RigidTransform>& cam_from_object);

/// The change, and the scatter where that is larger than the corners allow: sentences to warn with, without a full
/// stop.
std::vector<std::string> warnings_of(const CameraTruth& truth);

}  // namespace plumbline::markers
