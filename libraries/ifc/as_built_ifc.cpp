#include "ifc/as_built_ifc.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "geometry/statistics.hpp"
#include "ifc/as_built_solids.hpp"
#include "ifc/ifc_appender.hpp"
#include "ifc/ifc_units.hpp"
#include "ifc/step_writer.hpp"

namespace plumbline::bim {
namespace {

using step::list;
using step::null;
using step::reference;
using step::text;

constexpr double kSquareMillimetres = 1e6;  // in a square metre

const char* property_of(const std::string& part) {
  static const std::map<std::string, const char*> names = {{"out_of_plane", "OutOfPlane"},
                                                           {"sideways", "Sideways"},
                                                           {"vertical", "Vertical"},
                                                           {"tilt", "Tilt"},
                                                           {"warp", "Warp"},
                                                           {"misfit", "Misfit"},
                                                           {"corner", "Corner"},
                                                           {"joint", "Joint"},
                                                           {"anchor", "Anchor"},
                                                           {"missing_anchor", "MissingAnchor"}};
  const auto found = names.find(part);
  return found == names.end() ? "" : found->second;
}

/// The comparison with the survey that is evidence: on check anchors; on control anchors if there are no others.
const AccuracyComparisonT* survey_comparison(const AccuracyT& accuracy) {
  const AccuracyComparisonT* found = nullptr;
  for (const auto& comparison : accuracy.comparisons) {
    if (comparison->reference != AccuracyReference::survey || comparison->anchors == 0) continue;
    if (!found || comparison->use == AnchorUse::check) found = comparison.get();
  }
  return found;
}

std::string use_word(const AccuracyComparisonT& comparison) {
  return comparison.use == AnchorUse::check ? "check" : "control";
}

class Writer {
 public:
  Writer(const step::File& file, const Design& design, const DeviationT& deviation, const AccuracyT& accuracy,
         const AsBuiltIfcOptions& options)
      : model_(file),
        design_(design),
        deviation_(deviation),
        accuracy_(accuracy),
        options_(options),
        appender_(model_, design.project_guid, design.length_unit, options.timestamp),
        products_(appender_, design, options.epoch.empty() ? "" : options.epoch + "/") {
    for (const auto& anchor : accuracy.anchors) residuals_[anchor->id] = anchor.get();
    for (const Storey& storey : design.storeys) storeys_[storey.guid] = &storey;
    for (const auto& floor : deviation.floors)
      if (const auto storey = storeys_.find(floor->storey_guid); storey != storeys_.end())
        floors_[floor->floor] = storey->second;
  }

  AsBuiltIfc write() {
    verdicts_ = appender_.enumeration("ASB_Verdict", {"PASS", "FAIL", "UNDECIDED", "NOTMEASURED"});
    roles_ = appender_.enumeration("ASB_Role", {"CONTROL", "CHECK", "NONE"});
    find_standard_sets();
    for (const auto& anchor : deviation_.anchors) write_anchor(*anchor);
    write_provenance();
    if (const AccuracyComparisonT* comparison = survey_comparison(accuracy_)) {
      for (const auto& floor : comparison->floors) write_floor(*floor, *comparison);
      for (const auto& transfer : comparison->transfers)
        if (transfer->column == 0 && std::isfinite(transfer->error)) write_transfer(*transfer, *comparison);
      for (const auto& column : comparison->columns) write_column(*column, use_word(*comparison));
    }
    for (const auto& panel : deviation_.panels) write_panel(*panel);
    write_products();
    result_.additions = appender_.take_lines();
    result_.instances_added = appender_.count();
    return std::move(result_);
  }

 private:
  std::string key(const std::string& what) const { return options_.epoch.empty() ? what : options_.epoch + "/" + what; }
  /// Names of sets are unique on an object, so every epoch has its own.
  std::string set_name(const std::string& name) const {
    return options_.epoch.empty() ? name : name + "_" + options_.epoch;
  }
  void attach(PropertySet& set, const std::string& what, const std::string& name, const std::string& description,
              const std::vector<InstanceId>& objects) {
    set.label("Epoch", options_.epoch);
    set.attach(key(what), set_name(name), description, objects);
  }

  void write_anchor(const AnchorDeviationT& anchor) {
    if (anchor.instance == 0) return;
    const std::vector<InstanceId> object{anchor.instance};
    PropertySet deviation(appender_);
    deviation.choice("Verdict", label_of(anchor.verdict), verdicts_,
                     "Deviation against the tolerances, with guard band");
    deviation.label("DecidedBy", anchor.decided_by);
    deviation.length("DeviationX", anchor.deviation.x());
    deviation.length("DeviationY", anchor.deviation.y());
    deviation.length("DeviationZ", anchor.deviation.z(), "Upward positive");
    deviation.length("Deviation3D", anchor.deviation.norm());
    for (const auto& axis : anchor.axes) {
      if (axis->axis == "horizontal") deviation.length("DeviationHorizontal", axis->value);
      if (axis->axis == "in_plane") deviation.length("DeviationInPlane", axis->value, "Within the facade plane");
      if (axis->axis == "out_of_plane")
        deviation.length("DeviationOutOfPlane", axis->value, "Along the facade normal, outward positive");
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
      if (axis->tolerance > 0) deviation.plus_minus(names.at(axis->axis), axis->tolerance, axis->source);
    }
    deviation.probability("PassProbability", anchor.pass_probability,
                          "That the true deviation is within all tolerances");
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
  void find_standard_sets() {
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
  void write_standard_sets(const AnchorDeviationT& anchor, const std::vector<InstanceId>& object) {
    if (appender_.schema() != Schema::ifc4x3) return;
    PropertySet tolerance(appender_);
    if (!standard_sets_.contains({anchor.instance, "Pset_Tolerance"})) {
      for (const auto& axis : anchor.axes) {
        if (axis->axis == "horizontal") tolerance.positive_length("HorizontalTolerance", axis->tolerance);
        if (axis->axis == "vertical") tolerance.positive_length("VerticalTolerance", axis->tolerance);
      }
      if (!tolerance.empty()) tolerance.attach(key(anchor.guid), "Pset_Tolerance", "", object);
    }
    if (anchor.covariance.size() != 9 || standard_sets_.contains({anchor.instance, "Pset_Uncertainty"})) return;
    PropertySet uncertainty(appender_);
    uncertainty.positive_length("HorizontalUncertainty", std::sqrt(anchor.covariance[0] + anchor.covariance[4]));
    uncertainty.positive_length("VerticalUncertainty", std::sqrt(anchor.covariance[8]));
    if (!uncertainty.empty()) uncertainty.attach(key(anchor.guid), "Pset_Uncertainty", "", object);
  }

  void write_residual(const AnchorAccuracyT& measured, const AnchorDeviationT& anchor,
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
    set.plus_minus("Tolerance", accuracy_.tau);
    set.probability("ConformanceProbability", residual.conformance_probability);
    attach(set, anchor.guid, "ASB_ModelVsSurvey", "Photogrammetric model minus survey", object);
  }

  void write_uncertainty(const AnchorDeviationT& anchor, const std::vector<InstanceId>& object) {
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

  void write_provenance() {
    std::vector<InstanceId> objects;
    for (const auto& anchor : deviation_.anchors)
      if (anchor->instance != 0 && anchor->deviation.allFinite()) objects.push_back(anchor->instance);
    PropertySet set(appender_);
    for (const auto& [name, value] : options_.provenance) {
      if (name == "ObservationTime")
        set.date_time(name, value);
      else
        set.label(name, value);
    }
    set.labels("InputSha256", options_.input_hashes, "Files the run started from, with their SHA-256");
    if (!objects.empty() && !set.empty())
      attach(set, "anchors", "ASB_Provenance", "How the as-built values came about", objects);
  }

  const Storey* storey_of(int floor) {
    const auto found = floors_.find(floor);
    if (found != floors_.end()) return found->second;
    if (missing_floors_.insert(floor).second)
      result_.warnings.push_back("floor " + std::to_string(floor) +
                                 " has no storey of its own in the design; its statistics are in the report only");
    return nullptr;
  }

  void write_floor(const FloorAccuracyT& floor, const AccuracyComparisonT& comparison) {
    const Storey* storey = storey_of(floor.floor);
    if (!storey) return;
    PropertySet set(appender_);
    set.integer("N", floor.anchors, "Anchors evaluated");
    set.label("AnchorsUsed", use_word(comparison));
    set.boolean("Evidence", comparison.evidence,
                "False where the anchors were control of the adjustment: the sums then vanish by construction");
    set.length("MeanDeltaZ", floor.mean_dz, "r_f: mean of model minus survey");
    set.length("Drift", floor.drift, "D(F): sum of the means up to this floor");
    set.choice("DriftVerdict", label_of(floor.drift_verdict), verdicts_);
    set.length("RMSE_Z", floor.rmse_z);
    set.length("MaxAbsDeltaZ", floor.max_abs_dz);
    std::vector<std::pair<double, double>> rates;
    for (const auto& rate : floor.pass_rates)
      if (std::isfinite(rate->rate)) rates.emplace_back(rate->tolerance, rate->rate);
    set.table("PassRate", rates, "Share of the anchors within a tolerance");
    for (const auto& built : deviation_.floors) {
      if (built->floor != floor.floor) continue;
      set.integer("AnchorsPassed", built->passed, "Deviation from the design");
      set.integer("AnchorsUndecided", built->undecided);
      set.integer("AnchorsFailed", built->failed);
      set.integer("AnchorsNotMeasured", built->not_measured);
      set.integer("PanelsPassed", built->panels_passed);
      set.integer("PanelsUndecided", built->panels_undecided);
      set.integer("PanelsFailed", built->panels_failed);
      set.choice("Verdict", label_of(built->verdict), verdicts_, "The worst of its anchors and panels");
    }
    attach(set, storey->guid + "/" + use_word(comparison), "ASB_FloorStatistics",
           "Vertical residuals of the floor, model minus survey, and deviations from the design", {storey->instance});
  }

  void write_transfer(const HeightTransferT& transfer, const AccuracyComparisonT& comparison) {
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
    for (const auto& column : comparison.transfers) {
      if (column->column == 0 || column->lower_floor != transfer.lower_floor) continue;
      columns.push_back(std::to_string(column->column));
      differences.push_back(column->difference);
    }
    set.labels("Columns", columns, "Vertical marker columns that reach over both floors");
    set.lengths("DifferencePerColumn", differences, "Difference along each of them, in their order");
    set.label("Epoch", options_.epoch);
    set.attach(pair, set_name("ASB_InterFloor"), "Inter-floor transfer error, model against survey", {group});
  }

  /// A marker column is a group of its anchors; the group carries what is known of it as a whole.
  void write_column(const ColumnDriftT& column, const std::string& use) {
    std::vector<std::string> members;
    for (const auto& anchor : deviation_.anchors)
      if (anchor->instance != 0 && anchor->as_built.allFinite() && anchor->column == column.column &&
          anchor->use == use)
        members.push_back(reference(anchor->instance));
    if (members.empty()) return;
    const std::string number = std::to_string(column.column);
    const std::string id = key("column/" + number + "/" + use);
    const InstanceId group = appender_.add_root("IFCGROUP", id, "Marker column " + number,
                                                "Anchors in one vertical line", {text("MarkerColumn")});
    appender_.add_root("IFCRELASSIGNSTOGROUP", id, "", "", {list(members), null, reference(group)});
    PropertySet set(appender_);
    set.integer("Column", column.column, "As in the table of marker plates");
    set.label("AnchorsUsed", use);
    set.integer("LowestFloor", column.lowest_floor);
    set.integer("HighestFloor", column.highest_floor);
    set.length("Drift", column.drift, "Sum of the column's residuals over all floors");
    set.length("StdDrift", column.u_drift, "Standard uncertainty of Drift");
    set.choice("DriftVerdict", label_of(column.drift_verdict), verdicts_);
    set.length("RelativeDrift", column.relative_drift, "Residual at the highest floor minus that at the lowest");
    set.length("StdRelativeDrift", column.u_relative_drift, "Standard uncertainty of RelativeDrift");
    set.choice("RelativeVerdict", label_of(column.relative_verdict), verdicts_);
    set.label("Epoch", options_.epoch);
    set.attach(id, set_name("ASB_ColumnDrift"), "Vertical residuals along one marker column, model minus survey",
               {group});
  }

  /// Mean heights of the upper floor's measured anchors above those of the lower: by design, as built.
  std::pair<double, double> heights_between(int lower, int upper) const {
    Eigen::Vector2d sums[2] = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
    double counts[2] = {0, 0};
    for (const auto& anchor : deviation_.anchors) {
      if (!anchor->deviation.allFinite() || (anchor->floor != lower && anchor->floor != upper)) continue;
      const int i = anchor->floor == upper;
      sums[i] += Eigen::Vector2d(anchor->design.z(), anchor->as_built.z());
      ++counts[i];
    }
    const Eigen::Vector2d heights = sums[1] / counts[1] - sums[0] / counts[0];  // nan without anchors
    return {heights(0), heights(1)};
  }

  void write_panel(const PanelDeviationT& panel) {
    std::vector<std::string> guids, corners, neighbours;
    std::vector<double> shims, sideways, upward, moved, narrowest, widest;
    for (const auto& fixing : panel.fixings) {
      guids.push_back(fixing->guid);
      shims.push_back(fixing->shim), sideways.push_back(fixing->sideways), upward.push_back(fixing->upward);
    }
    for (const auto& corner : panel.corners) {
      if (!corner->movement.allFinite()) continue;
      corners.push_back(corner->name);
      moved.insert(moved.end(), {corner->movement.x(), corner->movement.y(), corner->movement.z()});
    }
    for (const auto& joint : panel.joints) {
      neighbours.push_back(joint->panel);
      narrowest.push_back(joint->narrowest), widest.push_back(joint->widest);
    }
    std::vector<std::string> warnings;
    const double radian = read_units(model_, model_.all("IFCPROJECT").at(0), warnings).plane_angle;
    PropertySet set(appender_);
    set.choice("Verdict", label_of(panel.verdict), verdicts_, "The worst of its lengths, joints and anchors");
    set.label("DecidedBy", property_of(panel.decided_by));
    set.label("Reason", panel.reason);
    const std::pair<const char*, const JudgedLengthT*> lengths[] = {{"OutOfPlane", panel.out_of_plane.get()},
                                                                    {"Sideways", panel.sideways.get()},
                                                                    {"Vertical", panel.vertical.get()},
                                                                    {"Tilt", panel.tilt.get()},
                                                                    {"Warp", panel.warp.get()},
                                                                    {"Misfit", panel.misfit.get()},
                                                                    {"Corner", panel.corner.get()}};
    for (const auto& [name, length] : lengths)
      if (length) set.length(name, length->value);
    set.length("FitX", panel.shift.x(), "Shift of the panel's centre if it follows its anchors");
    set.length("FitY", panel.shift.y());
    set.length("FitZ", panel.shift.z());
    set.angle("FitRotationX", panel.rotation.x(), radian,
              "Turn about the panel's centre; 0 where the anchors cannot tell");
    set.angle("FitRotationY", panel.rotation.y(), radian);
    set.angle("FitRotationZ", panel.rotation.z(), radian);
    set.labels("AnchorGUIDs", guids);
    set.lengths("ShimPerAnchor", shims,
                "Outward correction that brings each anchor back to its design plane, in the order of AnchorGUIDs");
    set.lengths("SidewaysPerAnchor", sideways, "Correction to the right as seen from outside");
    set.lengths("UpwardPerAnchor", upward, "Correction upward");
    set.labels("MissingAnchors", panel.missing, "That hold the panel and were not measured");
    set.labels("Corners", corners, "As seen from outside");
    set.lengths("CornerMovement", moved, "x, y, z of each, in the order of Corners");
    set.labels("JointTo", neighbours, "GlobalIds of the neighbouring panels");
    set.lengths("JointNarrowest", narrowest, "As built, in the order of JointTo");
    set.lengths("JointWidest", widest, "As built, in the order of JointTo");
    attach(set, panel.guid, "ASB_PanelFit",
           "Best fit of the panel to the as-built minus design deviations of its anchors", {panel.instance});
  }

  void write_products() {
    if (!options_.survey_points && !options_.solids) return;
    if (!products_.possible()) {
      result_.warnings.push_back(
          "the design has no three-dimensional representation context, or no storey, building or site to contain "
          "anything; survey points and solids are not written");
      return;
    }
    std::map<std::uint64_t, const Element*> elements;
    for (const Element& element : design_.elements) elements[element.instance] = &element;
    const std::string when = options_.epoch.empty() ? "" : " " + options_.epoch;
    for (const auto& anchor : deviation_.anchors) {
      if (anchor->instance == 0 || !anchor->deviation.allFinite()) continue;
      if (options_.survey_points) products_.add_survey_point(*anchor, "As-built " + anchor->id + when);
      if (options_.solids) products_.add_marker(*anchor, "As-built " + anchor->id + when);
    }
    for (const auto& panel : deviation_.panels)
      if (const auto element = elements.find(panel->instance);
          options_.solids && element != elements.end() && element->second->has_box)
        products_.add_panel(*panel, *element->second);
    products_.finish();
  }

  Model model_;
  const Design& design_;
  const DeviationT& deviation_;
  const AccuracyT& accuracy_;
  const AsBuiltIfcOptions& options_;
  Appender appender_;
  ProductWriter products_;
  AsBuiltIfc result_;
  InstanceId verdicts_ = 0, roles_ = 0;
  std::map<std::string, const AnchorAccuracyT*> residuals_;
  std::map<std::string, const Storey*> storeys_;
  std::map<int, const Storey*> floors_;
  std::set<int> missing_floors_;
  std::set<std::pair<InstanceId, std::string>> standard_sets_;
};

void require_same_file(const step::File& file, const DeviationT& deviation) {
  const auto check = [&](std::uint64_t number, const std::string& guid) {
    const auto instance = file.find(number);
    if (number == 0 || (instance && file.contains(*instance, guid))) return;
    throw std::runtime_error("the deviations were judged against " + deviation.design_file + ", in which #" +
                             std::to_string(number) + " is " + guid + "; in " + file.name() +
                             " it is not: connect all to the same design file");
  };
  for (const auto& anchor : deviation.anchors) check(anchor->instance, anchor->guid);
  for (const auto& panel : deviation.panels) check(panel->instance, panel->guid);
}

}  // namespace

const char* label_of(ToleranceVerdict verdict) {
  switch (verdict) {
    case ToleranceVerdict::pass:
      return "PASS";
    case ToleranceVerdict::undecided:
      return "UNDECIDED";
    case ToleranceVerdict::fail:
      return "FAIL";
    case ToleranceVerdict::not_measured:
      break;
  }
  return "NOTMEASURED";
}

AsBuiltIfc write_as_built(const step::File& file, const Design& design, const DeviationT& deviation,
                          const AccuracyT& accuracy, const AsBuiltIfcOptions& options) {
  if (design.project_guid.empty())
    throw std::runtime_error(file.name() +
                             ": found no IfcProject, expected one: as-built values need its units and its GlobalId");
  require_same_file(file, deviation);
  return Writer(file, design, deviation, accuracy, options).write();
}

void copy_enriched(const step::File& file, const AsBuiltIfc& as_built, char* to) {
  const std::string_view design = file.bytes();
  to = std::copy_n(design.begin(), file.data_end(), to);
  to = std::copy(as_built.additions.begin(), as_built.additions.end(), to);
  std::copy(design.begin() + static_cast<std::ptrdiff_t>(file.data_end()), design.end(), to);
}

std::string enriched(const step::File& file, const AsBuiltIfc& as_built) {
  std::string all(file.bytes().size() + as_built.additions.size(), '\0');
  copy_enriched(file, as_built, all.data());
  return all;
}

}  // namespace plumbline::bim
