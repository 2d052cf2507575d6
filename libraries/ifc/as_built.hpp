// What was measured of a building, set against its design: input of the as-built IFC, and the numbers that go into it.
//
// Two quantities that must not be mixed: the deviation Δp = as-built − design (14) says how well the building was
// built; the residual Δz = model − survey (9) says how well the model was measured. They go into different property
// sets.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/panel_fit.hpp"
#include "ifc/design.hpp"

namespace plumbline::bim {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// With a guard band (JCGM 106): pass if |d| + k·u ≤ τ, fail if |d| − k·u > τ, else undecided.
enum class Verdict { not_measured, pass, undecided, fail };
const char* label_of(Verdict verdict);  ///< "PASS", "FAIL", "UNDECIDED", "NOTMEASURED"

/// Model minus survey of one anchor [m]; nan where unknown.
struct SurveyResidual {
  Eigen::Vector3d difference = Eigen::Vector3d::Constant(kUnknown);
  double u_dz = kUnknown;                   ///< standard uncertainty of its z
  Verdict verdict = Verdict::not_measured;  ///< of its z against the headline tolerance
  double probability = kUnknown;            ///< that the true |Δz| is within the tolerance
};

struct AsBuiltAnchor {
  std::string id;                                                    ///< GUID, name or tag of the design element
  std::string role;                                                  ///< "control", "check" or empty
  int floor = 0;                                                     ///< from 1 at the bottom; 0 if unknown
  int column = 0;                                                    ///< vertical marker column; 0 if it is in none
  Eigen::Vector3d position = Eigen::Vector3d::Constant(kUnknown);    ///< project frame [m]; nan if it was not measured
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Constant(kUnknown);  ///< [m²]; nan if unknown
  std::optional<SurveyResidual> survey;
};

struct FloorResult {
  int floor = 0;
  std::string anchors_used;  ///< "check" or "control"
  bool evidence = true;      ///< false on control anchors, where the sums vanish by construction
  int anchors = 0;
  double mean_dz = kUnknown;                          ///< r_f (1) [m]
  double drift = kUnknown;                            ///< D(F) (2) [m]
  Verdict drift_verdict = Verdict::not_measured;      ///< (3)
  double rmse_z = kUnknown, max_abs_dz = kUnknown;    ///< (11) [m]
  std::vector<std::pair<double, double>> pass_rates;  ///< (10) on this floor: tolerance [m], rate
};

struct TransferResult {
  int lower_floor = 0, upper_floor = 0;
  double error = kUnknown;       ///< E_transfer (13) [m]
  double difference = kUnknown;  ///< the same with its sign: model minus survey [m]
  double u = kUnknown;           ///< its standard uncertainty [m]
  int anchors = 0;
  Verdict verdict = Verdict::not_measured;
  std::vector<std::pair<int, double>> columns;  ///< number of a marker column, its difference with sign [m]
};

/// Vertical residuals along one marker column.
struct ColumnResult {
  int column = 0;
  std::string anchors_used;  ///< "check" or "control"
  int lowest_floor = 0, highest_floor = 0;
  double drift = kUnknown, u_drift = kUnknown;                    ///< (2) of the column alone [m]
  Verdict drift_verdict = Verdict::not_measured;                  ///< (3) of the column alone
  double relative_drift = kUnknown, u_relative_drift = kUnknown;  ///< highest minus lowest floor [m]
  Verdict relative_verdict = Verdict::not_measured;
};

/// How a panel sits by the evaluation, with the covariance of its anchors.
struct PanelResult {
  std::string guid;
  std::vector<std::pair<std::string, double>> lengths;  ///< property name, value [m]; nan where the anchors cannot tell
  Verdict verdict = Verdict::not_measured;              ///< the worst of them
  std::string decided_by;                               ///< property name
};

struct AsBuilt {
  std::vector<AsBuiltAnchor> anchors;
  std::vector<FloorResult> floors;
  std::vector<TransferResult> transfers;
  std::vector<ColumnResult> columns;
  std::vector<PanelResult> panels;
  double tolerance_xy = 0.005, tolerance_z = 0.005;  ///< of the deviation from the design [m]
  double headline_tolerance = 0.005;                 ///< of the residual against the survey [m]
  double guard_factor = 2;                           ///< k
  std::optional<Eigen::Vector3d> facade_normal;      ///< outward, project frame; else estimated from the anchors
  double panel_reach = kPanelReach;                  ///< how far from a panel's box its anchors may be [m]
  std::vector<std::pair<std::string, std::string>> provenance;  ///< property name and text
};

/// Deviation of one anchor from its design.
struct AnchorDeviation {
  const Element* element = nullptr;
  const AsBuiltAnchor* measured = nullptr;                          ///< null if nobody measured it
  Eigen::Vector3d deviation = Eigen::Vector3d::Constant(kUnknown);  ///< as-built − design (14), project frame [m]
  double out_of_plane = kUnknown;                                   ///< along the facade normal, outward positive [m]
  double in_plane = kUnknown;                                       ///< length of what is left [m]
  Verdict verdict = Verdict::not_measured;
  double pass_probability = kUnknown;
};

/// How a panel would sit if it followed its anchors.
struct PanelFit {
  const Element* panel = nullptr;
  std::vector<const AnchorDeviation*> anchors;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< of the panel's centre, project frame [m]
  Eigen::Vector3d rotation =
      Eigen::Vector3d::Zero();  ///< rotation vector about that centre [rad]; 0 where the anchors cannot tell
  double max_deviation = 0;     ///< largest 3D deviation of its anchors [m]
  Verdict verdict = Verdict::not_measured;  ///< the worst of its anchors
};

/// Verdict on a length whose standard uncertainty is u; undecided if u is unknown and the length is within the
/// tolerance.
Verdict verdict_of(double deviation, double u, double tolerance, double guard_factor);
/// P(|true value| ≤ tolerance) for a normal distribution about `deviation`; 0 or 1 without uncertainty; nan if u is
/// unknown.
double conformance_probability(double deviation, double u, double tolerance);

/// Horizontal outward normal of the facade that the anchors lie in: across the line they form in plan, away from the
/// rest of the building. Nothing if they form no line (a single column of anchors, several facades).
std::optional<Eigen::Vector3d> estimate_facade_normal(const Design& design);

/// One entry for each design anchor and for each element that was measured, in the order of the design. Measured ids
/// that fit no element go to `unmatched`. Throws std::runtime_error if none fits, if one fits several elements, if two
/// measurements are of the same element, or if the measurements lie so far from the design that the frames cannot be
/// the same.
std::vector<AnchorDeviation> match_anchors(const Design& design, const AsBuilt& as_built,
                                           std::vector<std::string>& unmatched);

/// Panels with at least one measured anchor: those the design fixes them by, else those within `reach` [m] of their
/// box.
std::vector<PanelFit> fit_panels(const Design& design, const std::vector<AnchorDeviation>& anchors, double reach);

}  // namespace plumbline::bim
