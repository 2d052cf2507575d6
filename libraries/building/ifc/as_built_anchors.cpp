#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "building/ifc/as_built_writer.hpp"
#include "building/ifc/tolerance_source.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::ifc {
namespace {

constexpr double kSquareMillimetres = 1e6;  // in a square metre

/// The tolerance of an axis as the standard's set can hold it: one number that the design or a rule asks for. A default
/// would be the design's own in the next epoch, and two sides would become one.
double standard_tolerance(const JudgedAxisT& axis) {
  const bool asked = !axis.source.empty() && !is_default_tolerance(axis.source);
  return asked && std::abs(axis.above - axis.below) < 1e-12 ? axis.above : std::nan("");
}

}  // namespace

void AsBuiltWriter::write_anchor(const AnchorDeviationT& anchor) {
  if (anchor.instance == 0) return;
  const std::vector<InstanceId> object{anchor.instance};
  PropertySet deviation(appender_);
  deviation.choice("Verdict", label_of(anchor.verdict), verdicts_,
                   "Whether it is within all its tolerances at once: conformance probability against the risk");
  deviation.label("DecidedBy", anchor.decided_by);
  deviation.length("DeviationX", anchor.deviation.x());
  deviation.length("DeviationY", anchor.deviation.y());
  deviation.length("DeviationZ", anchor.deviation.z(), "Upward positive");
  deviation.length("Deviation3D", anchor.deviation.norm());
  for (const auto& axis : anchor.axes) {
    if (axis->axis == "horizontal") deviation.length("DeviationHorizontal", axis->value);
    if (axis->axis == "in_plane") deviation.length("DeviationInPlane", axis->value, "Within the facade plane");
    if (axis->axis == "out_of_plane")
      deviation.length("DeviationOutOfPlane", axis->value,
                       anchor.facade && anchor.facade->confirmed
                           ? "Along the facade normal, outward positive"
                           : "Across the facade, without a sign: which way is outward is not confirmed");
  }
  if (anchor.facade) {
    deviation.label("Facade", anchor.facade->facade);
    deviation.label("OutwardFrom", anchor.facade->source, "What says which way it faces");
    deviation.boolean("OutwardConfirmed", anchor.facade->confirmed,
                      "False: no order to go outward or to the right is given");
  }
  deviation.lengths("DesignPosition", {anchor.design.x(), anchor.design.y(), anchor.design.z()},
                    "Of the surveyed point: reference point of the element and target offset");
  deviation.lengths("AsBuiltPosition", {anchor.as_built.x(), anchor.as_built.y(), anchor.as_built.z()});
  for (const auto& axis : anchor.axes) {
    static const std::map<std::string, const char*> names = {{"horizontal", "ToleranceXY"},
                                                             {"vertical", "ToleranceZ"},
                                                             {"in_plane", "ToleranceInPlane"},
                                                             {"out_of_plane", "ToleranceOutOfPlane"},
                                                             {"space", "Tolerance3D"}};
    if (axis->above > 0 || axis->below > 0)
      deviation.bounds(names.at(axis->axis), -axis->below, axis->above, axis->source);
  }
  deviation.probability("PassProbability", anchor.pass_probability, "That the true deviation is within all tolerances");
  deviation.label("Frame", "project", "Coordinate system of the object placements");
  deviation.label("ReferencePointRule", anchor.reference_point_rule, "Where the design position was taken from");
  if (anchor.target_offset.norm() > 0)
    deviation.lengths("TargetOffset", {anchor.target_offset.x(), anchor.target_offset.y(), anchor.target_offset.z()},
                      "From the reference point to the surveyed target, project axes");
  deviation.label("MatchedBy", anchor.found_by, "What led from the name in the survey to this element");
  deviation.label("SurveyName", anchor.id);
  deviation.label("Note", anchor.note);
  attach(deviation, anchor.guid, "ASB_AnchorDeviation", "As-built minus design", object);
  write_standard_sets(anchor, object);
  if (const auto residual = residuals_.find(anchor.id); residual != residuals_.end() && residual->second->survey)
    write_residual(*residual->second, anchor, object);
  write_uncertainty(anchor, object);
}

/// Names of the sets that objects of the design have already, of those that we might write too.
void AsBuiltWriter::find_standard_sets() {
  if (appender_.schema() != Schema::ifc4x3) return;
  for (const std::uint32_t index : model_.file().of_type("IFCRELDEFINESBYPROPERTIES")) {
    try {
      const Entity relation = model_.entity(model_.file().instances()[index]);
      const InstanceId set = relation.reference("RelatingPropertyDefinition");
      if (model_.keyword(set) != "IFCPROPERTYSET") continue;
      const std::string name = model_.entity(set).text("Name");
      if (name != "Pset_Tolerance" && name != "Pset_Uncertainty") continue;
      for (const InstanceId object : relation.references("RelatedObjects")) standard_sets_.insert({object, name});
    } catch (const step::Error&) {  // damage of the design is told by its reader
    }
  }
}

/// IFC4X3 has sets of its own for tolerance and uncertainty; before it their names are reserved for nothing. A set
/// that the design or an earlier epoch wrote stays the only one.
void AsBuiltWriter::write_standard_sets(const AnchorDeviationT& anchor, const std::vector<InstanceId>& object) {
  if (appender_.schema() != Schema::ifc4x3) return;
  PropertySet tolerance(appender_);
  if (!standard_sets_.contains({anchor.instance, "Pset_Tolerance"})) {
    for (const auto& axis : anchor.axes) {
      if (axis->axis == "horizontal") tolerance.positive_length("HorizontalTolerance", standard_tolerance(*axis));
      if (axis->axis == "vertical") tolerance.positive_length("VerticalTolerance", standard_tolerance(*axis));
    }
    if (!tolerance.empty()) tolerance.attach(key(anchor.guid), "Pset_Tolerance", "", object);
  }
  if (anchor.covariance.size() != 9 || standard_sets_.contains({anchor.instance, "Pset_Uncertainty"})) return;
  PropertySet uncertainty(appender_);
  uncertainty.positive_length("HorizontalUncertainty", std::sqrt(anchor.covariance[0] + anchor.covariance[4]));
  uncertainty.positive_length("VerticalUncertainty", std::sqrt(anchor.covariance[8]));
  if (!uncertainty.empty()) uncertainty.attach(key(anchor.guid), "Pset_Uncertainty", "", object);
}

void AsBuiltWriter::write_residual(const AnchorAccuracyT& measured, const AnchorDeviationT& anchor,
                                   const std::vector<InstanceId>& object) {
  const AnchorDifferenceT& residual = *measured.survey;
  PropertySet set(appender_);
  set.length("DeltaZ", residual.dz, "Vertical residual, upward positive");
  set.length("DeltaX", residual.dx);
  set.length("DeltaY", residual.dy);
  set.length("Distance3D", residual.distance);
  set.length("StdDeltaZ", residual.u_dz, "Standard uncertainty of DeltaZ");
  set.choice("Role", measured.use == AnchorUse::control ? "CONTROL" : "CHECK", roles_,
             "A control anchor took part in the adjustment: its residual is no evidence of accuracy");
  if (measured.column > 0) set.integer("Column", measured.column, "Vertical marker column");
  set.choice("Verdict", label_of(residual.verdict), verdicts_, "DeltaZ against the tolerance, with guard band");
  if (std::isfinite(accuracy_.tau)) set.plus_minus("Tolerance", accuracy_.tau);
  set.probability("ConformanceProbability", residual.conformance_probability);
  attach(set, anchor.guid, "ASB_ModelVsSurvey", "Photogrammetric model minus survey", object);
}

void AsBuiltWriter::write_uncertainty(const AnchorDeviationT& anchor, const std::vector<InstanceId>& object) {
  if (anchor.covariance.size() != 9) return;
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> s(anchor.covariance.data());
  if (!s.allFinite()) return;
  const Eigen::Matrix3d c = s * kSquareMillimetres;
  const Eigen::Vector3d std_deviation = s.diagonal().cwiseMax(0).cwiseSqrt();
  const double largest =
      std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(Eigen::Matrix3d(s)).eigenvalues()(2));
  PropertySet set(appender_);
  set.length("StdX", std_deviation.x(), "Standard uncertainty of the as-built position");
  set.length("StdY", std_deviation.y());
  set.length("StdZ", std_deviation.z());
  set.length("Coverage95", std::sqrt(largest * chi_squared_quantile(0.95, 3)),
             "Longest half axis of the 95 % ellipsoid");
  set.reals("CovarianceUpper_mm2", {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)},
            "xx, xy, xz, yy, yz, zz in mm2");
  set.label("UncertaintyBasis", "covariance of the adjustment");
  attach(set, anchor.guid, "ASB_Uncertainty", "Uncertainty of the as-built position", object);
}

}  // namespace plumbline::ifc
