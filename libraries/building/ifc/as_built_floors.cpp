#include <algorithm>
#include <cmath>

#include "building/ifc/as_built_writer.hpp"
#include "building/step/step_writer.hpp"

namespace plumbline::ifc {

using step::list;
using step::null;
using step::reference;
using step::text;

std::string use_word(const AccuracyComparisonT& comparison) {
  return comparison.use == AnchorUse::check ? "check" : "control";
}

const Storey* AsBuiltWriter::storey_of(int floor) {
  const auto found = floors_.find(floor);
  if (found != floors_.end()) return found->second;
  if (missing_floors_.insert(floor).second)
    result_.warnings.push_back("floor " + std::to_string(floor) +
                               " has no storey of its own in the design; its statistics are in the report only");
  return nullptr;
}

void AsBuiltWriter::write_floor(const FloorAccuracyT& floor, const AccuracyComparisonT& comparison) {
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
    set.choice("Verdict", label_of(built->verdict), verdicts_, "The worst of its anchors and panels, each by itself");
    set.probability("PassTogether", built->pass_together,
                    "That all its anchors and panels are within tolerance at once is no less probable than this");
  }
  attach(set, storey->guid + "/" + use_word(comparison), "ASB_FloorStatistics",
         "Vertical residuals of the floor, model minus survey, and deviations from the design", {storey->instance});
}

void AsBuiltWriter::write_transfer(const HeightTransferT& transfer, const AccuracyComparisonT& comparison) {
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
void AsBuiltWriter::write_column(const ColumnDriftT& column, const std::string& use) {
  std::vector<std::string> members;
  for (const auto& anchor : deviation_.anchors)
    if (anchor->instance != 0 && anchor->as_built.allFinite() && anchor->column == column.column && anchor->use == use)
      members.push_back(reference(anchor->instance));
  if (members.empty()) return;
  const std::string number = std::to_string(column.column);
  const std::string id = key("column/" + number + "/" + use);
  const InstanceId group = appender_.add_root("IFCGROUP", id, "Marker column " + number, "Anchors in one vertical line",
                                              {text("MarkerColumn")});
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
std::pair<double, double> AsBuiltWriter::heights_between(int lower, int upper) const {
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

}  // namespace plumbline::ifc
