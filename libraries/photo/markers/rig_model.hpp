// Cameras that took photographs together, as a block: who takes part, and the model of it.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "photo/bundle/adjust.hpp"
#include "photo/markers/rig_adjustment.hpp"

namespace plumbline::markers {

/// What is estimated besides the poses: everything, less of the lens, nothing.
enum class RigFreedom { all, principal, none };

/// One photograph that takes part.
struct RigShot {
  int camera = 0;  ///< index into the rig's members
  int view = 0;    ///< index into the calibration's views
  int exposure = 0;
};

/// Who takes part, with the values of all unknowns.
struct Rig {
  std::vector<int> members;  ///< indices into the given cameras, the reference first
  std::vector<std::string> exposure_names;
  std::vector<RigShot> shots;
  std::vector<bundle::Placement> exposures, cameras;  ///< reference from board, camera from reference
  std::vector<bundle::Interior> interiors;
  Eigen::Vector2d bend = Eigen::Vector2d::Zero();
};

/// Exposures without a photograph go; the others keep their order.
void drop_empty_exposures(Rig& rig);

/// The same as a block: an image for each exposure, which nobody took, and behind these one for each shot.
struct RigModel {
  bundle::Problem problem;
  bundle::State state;
  std::vector<std::pair<int, int>> labels;  ///< shot and point of each image point

  /// Computed minus measured [px]. Throws std::runtime_error where the board lies behind a camera.
  Eigen::Vector2d residual_of(const bundle::Layout& layout, std::size_t label) const;
};

/// Makes them from calibrated cameras and the moments of their photographs, which it refers to.
class RigModels {
 public:
  RigModels(const std::vector<RigCamera>& cameras, const std::vector<std::vector<std::string>>& moments,
            const CalibrationOptions& options);

  /// `start`: each member from the first. `part` 0: all exposures; 1 and 2: every other one.
  Rig rig_of(const std::vector<int>& members, const std::vector<RigidTransform>& start, int part) const;

  RigModel build(const Rig& p, RigFreedom freedom) const;

  /// Root mean square residual of every photograph [px], after a robust minimisation over the poses alone, which
  /// become those of `p`.
  std::vector<double> fit(Rig& p) const;

  const CalibrationView& given(const Rig& p, const RigShot& s) const;

 private:
  const CalibratedView& calibrated(const Rig& p, const RigShot& s) const;
  void add_cameras(const Rig& p, RigFreedom freedom, bundle::Problem& problem) const;

  const std::vector<RigCamera>& cameras_;
  const std::vector<std::vector<std::string>>& moments_;
  const CalibrationOptions& options_;
  Eigen::Vector2d middle_, half_;  ///< of the board's points [m]
};

}  // namespace plumbline::markers
