#include "ifc/as_built_ifc.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "geometry/statistics.hpp"
#include "ifc/ifc_appender.hpp"
#include "ifc/ifc_placement.hpp"
#include "ifc/ifc_units.hpp"
#include "ifc/step_writer.hpp"

namespace plumbline::bim {
namespace {

using step::list;
using step::null;
using step::reference;
using step::text;

constexpr double kSquareMillimetres = 1e6;  // in a square metre

class Writer {
 public:
  Writer(const step::File& file, const Design& design, const AsBuilt& as_built, const AsBuiltIfcOptions& options)
      : model_(file),
        design_(design),
        as_built_(as_built),
        options_(options),
        appender_(model_, design.project_guid, design.length_unit, options.timestamp) {}

  AsBuiltIfc write() {
    std::vector<std::string> unmatched;
    anchors_ = match_anchors(design_, as_built_, unmatched);
    for (const std::string& id : unmatched)
      result_.warnings.push_back("anchor '" + id +
                                 "' fits no element of the design by GlobalId, name or tag; it is left out");
    verdicts_ = enumeration("ASB_Verdict", {"PASS", "FAIL", "UNDECIDED", "NOTMEASURED"});
    roles_ = enumeration("ASB_Role", {"CONTROL", "CHECK", "NONE"});
    for (const AnchorDeviation& anchor : anchors_) write_anchor(anchor);
    write_provenance();
    find_floors();
    for (const FloorResult& floor : as_built_.floors) write_floor(floor);
    for (const TransferResult& transfer : as_built_.transfers) write_transfer(transfer);
    for (const ColumnResult& column : as_built_.columns) write_column(column);
    for (const PanelFit& fit : fit_panels(design_, anchors_, as_built_.panel_reach)) write_panel(fit);
    if (options_.survey_points) write_survey_points();
    result_.bytes = appender_.bytes();
    result_.instances_added = appender_.count();
    return std::move(result_);
  }

 private:
  std::string key(const std::string& what) const { return options_.epoch.empty() ? what : options_.epoch + "/" + what; }

  InstanceId enumeration(const std::string& name, const std::vector<const char*>& values) {
    std::vector<std::string> labels;
    for (const char* value : values) labels.push_back(step::typed("IFCLABEL", text(value)));
    return appender_.add("IFCPROPERTYENUMERATION", {text(name), list(labels), null});
  }

  void count(Verdict verdict) {
    ++(verdict == Verdict::pass        ? result_.passed
       : verdict == Verdict::fail      ? result_.failed
       : verdict == Verdict::undecided ? result_.undecided
                                       : result_.not_measured);
    result_.measured += verdict != Verdict::not_measured;
  }

  void write_anchor(const AnchorDeviation& anchor) {
    const Element& element = *anchor.element;
    const std::vector<InstanceId> object{element.instance};
    count(anchor.verdict);
    PropertySet deviation(appender_);
    deviation.choice("Verdict", label_of(anchor.verdict), verdicts_,
                     "Deviation against the tolerances, with guard band");
    deviation.length("DeviationX", anchor.deviation.x());
    deviation.length("DeviationY", anchor.deviation.y());
    deviation.length("DeviationZ", anchor.deviation.z(), "Upward positive");
    deviation.length("Deviation3D", anchor.deviation.norm());
    deviation.length("DeviationInPlane", anchor.in_plane, "Within the facade plane");
    deviation.length("DeviationOutOfPlane", anchor.out_of_plane, "Along the facade normal, outward positive");
    deviation.lengths("DesignPosition", {element.position.x(), element.position.y(), element.position.z()});
    if (anchor.measured)
      deviation.lengths("AsBuiltPosition",
                        {anchor.measured->position.x(), anchor.measured->position.y(), anchor.measured->position.z()});
    deviation.plus_minus("ToleranceXY", as_built_.tolerance_xy, "Of the horizontal deviation");
    deviation.plus_minus("ToleranceZ", as_built_.tolerance_z, "Of the vertical deviation");
    deviation.probability("PassProbability", anchor.pass_probability,
                          "That the true deviation is within both tolerances");
    deviation.label("Frame", "project", "Coordinate system of the object placements");
    deviation.label("ReferencePointRule", name_of(element.rule), "Where the design position was taken from");
    deviation.attach(key(element.guid), "ASB_AnchorDeviation", "As-built minus design", object);
    write_standard_sets(anchor, object);
    if (!anchor.measured) return;
    write_residual(*anchor.measured, element, object);
    write_uncertainty(*anchor.measured, element, object);
  }

  /// IFC4X3 has sets of its own for tolerance and uncertainty; before it their names are reserved for nothing.
  void write_standard_sets(const AnchorDeviation& anchor, const std::vector<InstanceId>& object) {
    if (appender_.schema() != Schema::ifc4x3) return;
    PropertySet tolerance(appender_);
    tolerance.positive_length("HorizontalTolerance", as_built_.tolerance_xy);
    tolerance.positive_length("VerticalTolerance", as_built_.tolerance_z);
    if (!tolerance.empty()) tolerance.attach(key(anchor.element->guid), "Pset_Tolerance", "", object);
    if (!anchor.measured || !anchor.measured->covariance.allFinite()) return;
    const Eigen::Vector3d variances = anchor.measured->covariance.diagonal().cwiseMax(0);
    PropertySet uncertainty(appender_);
    uncertainty.positive_length("HorizontalUncertainty", std::sqrt(variances.x() + variances.y()));
    uncertainty.positive_length("VerticalUncertainty", std::sqrt(variances.z()));
    if (!uncertainty.empty()) uncertainty.attach(key(anchor.element->guid), "Pset_Uncertainty", "", object);
  }

  void write_residual(const AsBuiltAnchor& measured, const Element& element, const std::vector<InstanceId>& object) {
    if (!measured.survey) return;
    const SurveyResidual& residual = *measured.survey;
    PropertySet set(appender_);
    set.length("DeltaZ", residual.difference.z(), "Vertical residual, upward positive");
    set.length("DeltaX", residual.difference.x());
    set.length("DeltaY", residual.difference.y());
    set.length("Distance3D", residual.difference.norm());
    set.length("StdDeltaZ", residual.u_dz, "Standard uncertainty of DeltaZ");
    set.choice("Role",
               measured.role == "control" ? "CONTROL"
               : measured.role == "check" ? "CHECK"
                                          : "NONE",
               roles_, "A control anchor took part in the adjustment: its residual is no evidence of accuracy");
    if (measured.column > 0) set.integer("Column", measured.column, "Vertical marker column");
    set.choice("Verdict", label_of(residual.verdict), verdicts_, "DeltaZ against the tolerance, with guard band");
    set.plus_minus("Tolerance", as_built_.headline_tolerance);
    set.probability("ConformanceProbability", residual.probability);
    set.attach(key(element.guid), "ASB_ModelVsSurvey", "Photogrammetric model minus survey", object);
  }

  void write_uncertainty(const AsBuiltAnchor& measured, const Element& element, const std::vector<InstanceId>& object) {
    if (!measured.covariance.allFinite()) return;
    const Eigen::Matrix3d c = measured.covariance * kSquareMillimetres;
    const Eigen::Vector3d std_deviation = measured.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    const double largest =
        std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(measured.covariance).eigenvalues()(2));
    PropertySet set(appender_);
    set.length("StdX", std_deviation.x(), "Standard uncertainty of the as-built position");
    set.length("StdY", std_deviation.y());
    set.length("StdZ", std_deviation.z());
    set.length("Coverage95", std::sqrt(largest * chi_squared_quantile(0.95, 3)),
               "Longest half axis of the 95 % ellipsoid");
    set.reals("CovarianceUpper_mm2", {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)},
              "xx, xy, xz, yy, yz, zz in mm2");
    set.label("UncertaintyBasis", "covariance of the adjustment");
    set.attach(key(element.guid), "ASB_Uncertainty", "Uncertainty of the as-built position", object);
  }

  void write_provenance() {
    std::vector<InstanceId> objects;
    for (const AnchorDeviation& anchor : anchors_)
      if (anchor.measured) objects.push_back(anchor.element->instance);
    PropertySet set(appender_);
    for (const auto& [name, value] : as_built_.provenance) set.label(name, value);
    if (!objects.empty() && !set.empty())
      set.attach(key("anchors"), "ASB_Provenance", "How the as-built values came about", objects);
  }

  /// Floors are numbers in the evaluation and objects in the file: each anchor that has both votes.
  void find_floors() {
    std::map<int, std::map<std::string, int>> votes;
    for (const AnchorDeviation& anchor : anchors_)
      if (anchor.measured && anchor.measured->floor > 0 && !anchor.element->storey_guid.empty())
        ++votes[anchor.measured->floor][anchor.element->storey_guid];
    std::map<std::string, int> taken;
    for (const auto& [floor, storeys] : votes) {
      const auto winner = std::max_element(storeys.begin(), storeys.end(),
                                           [](const auto& a, const auto& b) { return a.second < b.second; });
      if (storeys.size() > 1)
        result_.warnings.push_back("the anchors of floor " + std::to_string(floor) + " stand in " +
                                   std::to_string(storeys.size()) +
                                   " storeys of the design; its statistics go to the one with most of them");
      const auto [other, added] = taken.emplace(winner->first, floor);
      if (!added)
        throw std::runtime_error("floors " + std::to_string(other->second) + " and " + std::to_string(floor) +
                                 " have their anchors in the same storey of " + design_.file_name +
                                 ", expected one storey for each floor");
      const auto storey = std::find_if(design_.storeys.begin(), design_.storeys.end(),
                                       [&](const Storey& s) { return s.guid == winner->first; });
      if (storey != design_.storeys.end()) floors_[floor] = &*storey;
    }
  }

  const Storey* storey_of(int floor) {
    const auto found = floors_.find(floor);
    if (found != floors_.end()) return found->second;
    result_.warnings.push_back("floor " + std::to_string(floor) +
                               " has no anchor in a storey of the design; its statistics are not written");
    return nullptr;
  }

  void write_floor(const FloorResult& floor) {
    const Storey* storey = storey_of(floor.floor);
    if (!storey) return;
    PropertySet set(appender_);
    set.integer("N", floor.anchors, "Anchors evaluated");
    set.label("AnchorsUsed", floor.anchors_used);
    set.boolean("Evidence", floor.evidence,
                "False where the anchors were control of the adjustment: the sums then vanish by construction");
    set.length("MeanDeltaZ", floor.mean_dz, "r_f: mean of model minus survey");
    set.length("Drift", floor.drift, "D(F): sum of the means up to this floor");
    set.choice("DriftVerdict", label_of(floor.drift_verdict), verdicts_);
    set.length("RMSE_Z", floor.rmse_z);
    set.length("MaxAbsDeltaZ", floor.max_abs_dz);
    set.table("PassRate", floor.pass_rates, "Share of the anchors within a tolerance");
    set.attach(key(storey->guid + "/" + floor.anchors_used), "ASB_FloorStatistics",
               "Vertical residuals of the floor, model minus survey", {storey->instance});
  }

  void write_transfer(const TransferResult& transfer) {
    const Storey *lower = storey_of(transfer.lower_floor), *upper = storey_of(transfer.upper_floor);
    if (!lower || !upper) return;
    // Property sets cannot stand on a relation, and storeys cannot be connected: a group of the two carries them.
    const std::string pair = key(lower->guid + "/" + upper->guid), name = lower->name + " to " + upper->name;
    const InstanceId group = appender_.add_root("IFCGROUP", pair, name, "Height transfer between adjacent floors",
                                                {text("InterFloorTransfer")});
    appender_.add_root("IFCRELASSIGNSTOGROUP", pair, "", "",
                       {list({reference(lower->instance), reference(upper->instance)}), null, reference(group)});
    PropertySet set(appender_);
    set.label("LowerStorey", lower->name);
    set.label("UpperStorey", upper->name);
    set.length("E_transfer", transfer.error, "|height difference of the model - that of the survey|");
    set.length("Difference", transfer.difference, "The same with its sign");
    const auto [design_height, measured_height] = heights_between(transfer.lower_floor, transfer.upper_floor);
    set.length("DesignHeight", design_height,
               "Mean height of the measured anchors above those of the lower floor, by design");
    set.length("MeasuredHeight", measured_height, "The same as built");
    set.length("Sigma", transfer.u, "Standard uncertainty of Difference");
    set.integer("SharedMarkers", transfer.anchors, "Anchors that took part");
    set.choice("Verdict", label_of(transfer.verdict), verdicts_);
    std::vector<std::string> columns;
    std::vector<double> differences;
    for (const auto& [column, difference] : transfer.columns) {
      columns.push_back(std::to_string(column));
      differences.push_back(difference);
    }
    set.labels("Columns", columns, "Vertical marker columns that reach over both floors");
    set.lengths("DifferencePerColumn", differences, "Difference along each of them, in their order");
    set.attach(pair, "ASB_InterFloor", "Inter-floor transfer error, model against survey", {group});
  }

  /// A marker column is a group of its anchors; the group carries what is known of it as a whole.
  void write_column(const ColumnResult& column) {
    std::vector<std::string> members;
    for (const AnchorDeviation& anchor : anchors_)
      if (anchor.measured && anchor.measured->column == column.column && anchor.measured->role == column.anchors_used)
        members.push_back(reference(anchor.element->instance));
    if (members.empty()) return;
    const std::string number = std::to_string(column.column);
    const std::string id = key("column/" + number + "/" + column.anchors_used);
    const InstanceId group = appender_.add_root("IFCGROUP", id, "Marker column " + number,
                                                "Anchors in one vertical line", {text("MarkerColumn")});
    appender_.add_root("IFCRELASSIGNSTOGROUP", id, "", "", {list(members), null, reference(group)});
    PropertySet set(appender_);
    set.integer("Column", column.column, "As in the table of marker plates");
    set.label("AnchorsUsed", column.anchors_used);
    set.integer("LowestFloor", column.lowest_floor);
    set.integer("HighestFloor", column.highest_floor);
    set.length("Drift", column.drift, "Sum of the column's residuals over all floors");
    set.length("StdDrift", column.u_drift, "Standard uncertainty of Drift");
    set.choice("DriftVerdict", label_of(column.drift_verdict), verdicts_);
    set.length("RelativeDrift", column.relative_drift, "Residual at the highest floor minus that at the lowest");
    set.length("StdRelativeDrift", column.u_relative_drift, "Standard uncertainty of RelativeDrift");
    set.choice("RelativeVerdict", label_of(column.relative_verdict), verdicts_);
    set.attach(id, "ASB_ColumnDrift", "Vertical residuals along one marker column, model minus survey", {group});
  }

  /// Mean heights of the upper floor's measured anchors above those of the lower: by design, as built.
  std::pair<double, double> heights_between(int lower, int upper) const {
    Eigen::Vector2d sums[2] = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
    double counts[2] = {0, 0};
    for (const AnchorDeviation& anchor : anchors_) {
      if (!anchor.deviation.allFinite() || (anchor.measured->floor != lower && anchor.measured->floor != upper))
        continue;
      const int i = anchor.measured->floor == upper;
      sums[i] += Eigen::Vector2d(anchor.element->position.z(), anchor.measured->position.z());
      ++counts[i];
    }
    const Eigen::Vector2d heights = sums[1] / counts[1] - sums[0] / counts[0];  // nan without anchors
    return {heights(0), heights(1)};
  }

  void write_panel(const PanelFit& fit) {
    ++result_.panels;
    std::vector<std::string> guids;
    std::vector<double> shims;
    for (const AnchorDeviation* anchor : fit.anchors) {
      guids.push_back(anchor->element->guid);
      shims.push_back(-anchor->out_of_plane);
    }
    std::vector<std::string> warnings;
    const double radian = read_units(model_, model_.all("IFCPROJECT").at(0), warnings).plane_angle;
    const auto judged = std::find_if(as_built_.panels.begin(), as_built_.panels.end(),
                                     [&](const PanelResult& panel) { return panel.guid == fit.panel->guid; });
    const bool known = judged != as_built_.panels.end();
    PropertySet set(appender_);
    set.choice("Verdict", label_of(known ? judged->verdict : fit.verdict), verdicts_,
               known ? "The worst of its shifts, tilt, warp and misfit" : "The worst of its anchors");
    if (known) {
      set.label("DecidedBy", judged->decided_by);
      for (const auto& [name, value] : judged->lengths) set.length(name, value);
    }
    set.length("FitX", fit.translation.x(), "Shift of the panel's centre if it follows its anchors");
    set.length("FitY", fit.translation.y());
    set.length("FitZ", fit.translation.z());
    set.angle("FitRotationX", fit.rotation.x(), radian,
              "Turn about the panel's centre; 0 where the anchors cannot tell");
    set.angle("FitRotationY", fit.rotation.y(), radian);
    set.angle("FitRotationZ", fit.rotation.z(), radian);
    set.length("MaxAnchorDeviation", fit.max_deviation);
    set.labels("AnchorGUIDs", guids);
    set.lengths("ShimPerAnchor", shims,
                "Outward correction that brings each anchor back to its design plane, in the order of AnchorGUIDs");
    set.attach(key(fit.panel->guid), "ASB_PanelFit",
               "Best fit of the panel to the as-built minus design deviations of its anchors", {fit.panel->instance});
  }

  void write_survey_points();
  InstanceId body_context() const;

  Model model_;
  const Design& design_;
  const AsBuilt& as_built_;
  const AsBuiltIfcOptions& options_;
  Appender appender_;
  AsBuiltIfc result_;
  std::vector<AnchorDeviation> anchors_;
  InstanceId verdicts_ = 0, roles_ = 0;
  std::map<int, const Storey*> floors_;
};

/// The three-dimensional context of the project; 0 if it has none.
InstanceId Writer::body_context() const {
  for (const InstanceId id : model_.all("IFCPROJECT").at(0).references("RepresentationContexts")) {
    if (model_.keyword(id) != "IFCGEOMETRICREPRESENTATIONCONTEXT") continue;
    const auto arguments =
        model_.entity(id).arguments();  // ContextIdentifier, ContextType, CoordinateSpaceDimension, …
    if (arguments.size() > 2 && arguments[2].number == 3) return id;
  }
  return 0;
}

/// One annotation a point, contained in the storey of its anchor: property sets can then name it alone.
void Writer::write_survey_points() {
  const InstanceId context = body_context();
  if (!context)
    return result_.warnings.push_back(
        "the project has no three-dimensional representation context; survey points are not written");
  Placements placements(model_);
  std::map<std::string, std::vector<std::string>> by_storey;
  InstanceId origin = 0;
  for (const AnchorDeviation& anchor : anchors_) {
    const Element& element = *anchor.element;
    if (!anchor.deviation.allFinite() || element.storey_guid.empty()) continue;
    const auto storey = std::find_if(design_.storeys.begin(), design_.storeys.end(),
                                     [&](const Storey& s) { return s.guid == element.storey_guid; });
    const auto parent = model_.entity(storey->instance).optional_reference("ObjectPlacement");
    Eigen::Vector3d local = anchor.measured->position;
    if (parent) {
      RigidTransform project_from_storey = placements.project_from_placement(*parent, storey->instance);
      project_from_storey.translation *= design_.length_unit;
      local = project_from_storey.inverse() * local;
    }
    const InstanceId placement = appender_.add_placement(parent.value_or(0), local);
    if (!origin) origin = appender_.add("IFCCARTESIANPOINT", {list({"0.", "0.", "0."})});
    const InstanceId points = appender_.add("IFCGEOMETRICSET", {list({reference(origin)})});
    const InstanceId shape = appender_.add("IFCSHAPEREPRESENTATION", {reference(context), text("Annotation"),
                                                                      text("GeometricSet"), list({reference(points)})});
    const InstanceId definition = appender_.add("IFCPRODUCTDEFINITIONSHAPE", {null, null, list({reference(shape)})});
    std::vector<std::string> rest{text("SurveyPoint"), reference(placement), reference(definition)};
    if (appender_.schema() == Schema::ifc4x3) rest.push_back(step::enumeration("SURVEY"));
    const InstanceId point = appender_.add_root("IFCANNOTATION", key(element.guid), "As-built " + anchor.measured->id,
                                                "Measured position of the anchor", rest);
    appender_.add_root("IFCRELASSIGNSTOPRODUCT", key(element.guid), "", "",
                       {list({reference(point)}), null, reference(element.instance)});
    by_storey[element.storey_guid].push_back(reference(point));
  }
  for (const Storey& storey : design_.storeys)
    if (const auto found = by_storey.find(storey.guid); found != by_storey.end())
      appender_.add_root("IFCRELCONTAINEDINSPATIALSTRUCTURE", key(storey.guid), "", "",
                         {list(found->second), reference(storey.instance)});
}

}  // namespace

AsBuiltIfc write_as_built(const step::File& file, const Design& design, const AsBuilt& as_built,
                          const AsBuiltIfcOptions& options) {
  return Writer(file, design, as_built, options).write();
}

}  // namespace plumbline::bim
