// As-built minus design (14), judged once: anchors, panels, floors and what they have in common. Whoever shows or
// writes a verdict reads the artifact that comes out of here (schemas/artifacts/deviation.fbs).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "building/ifc/facades.hpp"
#include "building/judgement/accuracy.hpp"
#include "building/judgement/held_below.hpp"
#include "building/judgement/tolerance_rules.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::judgement {

/// An anchor of the plate table or of the design. Positions in the building frame [m].
struct AnchorCase {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::string id;             ///< also of its point in the model
  ifc::ElementFacts element;  ///< empty guid: no element fits
  std::uint64_t instance = 0;
  std::string storey_guid, found_by, reference_point_rule, use, note;
  bool listed = false;  ///< in the plate table
  int floor = 0, column = 0;
  std::string axis;  ///< of the grid, that crosses its facade nearest to it; empty: none
  Eigen::Vector3d design = Eigen::Vector3d::Constant(nan);  ///< of the surveyed point; nan without element
  Eigen::Vector3d target_offset = Eigen::Vector3d::Zero();
  ifc::FacadeFrame facade;  ///< which way it faces: in_plane, out_of_plane and orders are told in it
  Tolerances tolerances;
  std::vector<ifc::NotApplied> refused;  ///< what was asked for it and cannot be judged: then it does not pass
  bool is_sill = false;  ///< a place of a sill that holds the panel above it at its edge: none hangs on it
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
  ifc::FacadeFrame facade = {};
  std::vector<ifc::NotApplied> refused = {};
  std::optional<StackJoint> held_below = {};  ///< its bottom edge is held by what is there
  /// Its outer side along its own axes [m], where that is narrower than the box; empty: as wide.
  Eigen::AlignedBox3d outer = {};
};

/// Something that was asked for: a rule, a property of the design, panels. What cannot be judged says why; then nothing
/// is ready to install.
struct Request {
  std::string asked, by;  ///< by: "rule", "design", …
  int anchors = 0, panels = 0;
  std::string not_judged;  ///< the reason; empty: it was judged
};

struct DeviationInputs {
  std::vector<AnchorCase> anchors;
  std::vector<PanelCase> panels;
  std::vector<PanelCase> loose;      ///< those that no anchor holds: not judged, though another may stand on them
  std::vector<ifc::Facade> facades;  ///< that the frames of anchors and panels name
  judgement::PointSet model;         ///< as built, by anchor id
  /// What the errors of its points have in common is in the covariance of each and is not known by itself. Then as much
  /// is taken to be common as the points are uncertain by, besides their own: no mean of them is better known than one.
  bool common_unknown = false;
  std::string design_file;
  std::vector<Request> requests;      ///< beside what anchors and panels hold in `refused`
  std::vector<std::string> warnings;  ///< of what was put in
  std::string mounting;               ///< what the anchors' `mounting` is, in words
  /// Why the measurement is not to be trusted: then nothing is decided, and no order given.
  std::vector<MeasurementDoubtT> doubts;
  /// What the measurement's model does not hold; the model's covariance is multiplied with `misfit_factor` already,
  /// which the residuals say.
  std::vector<MeasurementDoubtT> misfits;
  double misfit_factor = 1;
};

struct DeviationOptions {
  double tau = 0.005;  ///< [m] default tolerance, for the headline
  double risk = 0.05;  ///< pass if P >= 1 - risk, fail if P <= risk (conformance.hpp)
  /// The building grows from campaign to campaign: a panel of which no anchor was measured is not built yet, and no
  /// question without an answer (DeviationT::not_judged).
  bool grows = false;
};

/// Throws std::runtime_error if ids repeat, a covariance has the wrong size, or the median deviation is above a metre:
/// then the points are not in the frame of the design. Anchors without element or measurement are listed with the
/// reason.
DeviationT judge_deviations(DeviationInputs inputs, const DeviationOptions& options);

/// One anchor's axes, verdict and probability: pass if all that is judged is within its tolerances at once with a
/// probability of 1 - risk. `covariance` is 3 x 3 or 0 x 0 [m²]. Where a tolerance in or out of plane is asked for and
/// nothing, or only a guess, says which way the anchor faces, that axis is undecided and `note` says why.
void judge_anchor(const Eigen::Vector3d& deviation, const Eigen::MatrixXd& covariance, const ifc::FacadeFrame& facade,
                  const Tolerances& tolerances, const DeviationOptions& options, AnchorDeviationT& out);

}  // namespace plumbline::judgement
