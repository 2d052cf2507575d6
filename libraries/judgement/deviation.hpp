// As-built minus design (14), judged once: anchors, panels, floors and what they have in common. Whoever shows or
// writes a verdict reads the artifact that comes out of here (schemas/artifacts/deviation.fbs).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "judgement/accuracy.hpp"
#include "judgement/tolerance_rules.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::judgement {

/// An anchor of the plate table or of the design. Positions in the building frame [m].
struct AnchorCase {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::string id;             ///< also of its point in the model
  bim::ElementFacts element;  ///< empty guid: no element fits
  std::uint64_t instance = 0;
  std::string storey_guid, found_by, reference_point_rule, use, note;
  int floor = 0, column = 0;
  Eigen::Vector3d design = Eigen::Vector3d::Constant(nan);  ///< of the surveyed point; nan without element
  Eigen::Vector3d target_offset = Eigen::Vector3d::Zero();
  Tolerances tolerances;
  /// Of the anchor against the plate that was measured [m²]; see mounting.hpp.
  Eigen::Matrix3d mounting = Eigen::Matrix3d::Zero();
};

/// A facade panel of the design: a box in its own axes.
struct PanelCase {
  std::string guid, name, storey_guid;
  std::uint64_t instance = 0;
  std::vector<std::size_t> anchors;  ///< that hold it, as indices into the anchors
  RigidTransform frame_from_panel;
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();  ///< [m]
  Tolerances tolerances;
};

struct DeviationInputs {
  std::vector<AnchorCase> anchors;
  std::vector<PanelCase> panels;
  evaluate::PointSet model;                                                    ///< as built, by anchor id
  Eigen::Vector3d facade_normal = Eigen::Vector3d::Constant(AnchorCase::nan);  ///< horizontal, outward; nan: none
  std::string design_file;
  std::string mounting;             ///< what the anchors' `mounting` is, in words
  std::vector<std::string> doubts;  ///< why the measurement is not to be trusted: then nothing passes
};

struct DeviationOptions {
  double tau = 0.005;           ///< [m] default tolerance, for the headline
  double guard_factor = 1.645;  ///< k of the guard band
};

/// Throws std::runtime_error if ids repeat, a covariance has the wrong size, or the median deviation is above a metre:
/// then the points are not in the frame of the design. Anchors without element or measurement are listed with the
/// reason.
DeviationT judge_deviations(const DeviationInputs& inputs, const DeviationOptions& options);

/// One anchor's axes and verdict. `covariance` is 3 x 3 or 0 x 0 [m²], `normal` the facade's or nan. The pass
/// probability, which costs as much as all the rest, only if `with_probability`.
void judge_anchor(const Eigen::Vector3d& deviation, const Eigen::MatrixXd& covariance, const Eigen::Vector3d& normal,
                  const Tolerances& tolerances, double guard_factor, AnchorDeviationT& out,
                  bool with_probability = true);

}  // namespace plumbline::judgement
