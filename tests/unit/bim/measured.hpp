// Deviations of a design's anchors, judged, for tests of what is written from them.
#pragma once

#include <map>
#include <string>

#include "building/ifc/design.hpp"
#include "building/judgement/deviation.hpp"
#include "doubt.hpp"
#include "facing.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::test {

/// Every anchor of the design under its GlobalId, as-built minus design as given (those that are not in `deviations`
/// were not measured), floors from the storeys, sigma of each coordinate [m].
inline DeviationT judged(const ifc::Design& design, const std::map<std::string, Eigen::Vector3d>& deviations,
                         const Eigen::Vector3d& sigma, const Eigen::Vector3d& normal,
                         const judgement::ToleranceTable& tolerances = {},
                         const std::vector<MeasurementDoubtT>& doubts = {}) {
  judgement::DeviationInputs inputs;
  inputs.design_file = design.file_name, inputs.doubts = doubts;
  for (const ifc::Element& element : design.elements) {
    if (!element.is_anchor) continue;
    judgement::AnchorCase anchor;
    anchor.id = element.guid, anchor.element = ifc::facts_of(element), anchor.instance = element.instance;
    anchor.tolerances = judgement::tolerances_of(tolerances, anchor.element);
    anchor.element.properties = nullptr;
    anchor.storey_guid = element.storey_guid, anchor.design = element.position;
    anchor.reference_point_rule = ifc::name_of(element.rule);
    for (std::size_t i = 0; i < design.storeys.size(); ++i)
      if (design.storeys[i].guid == element.storey_guid) anchor.floor = static_cast<int>(i) + 1;
    if (const auto measured = deviations.find(element.guid); measured != deviations.end()) {
      anchor.use = "check", anchor.column = 1;
      inputs.model.ids.push_back(anchor.id);
      inputs.model.positions.push_back(element.position + measured->second);
    }
    inputs.anchors.push_back(anchor);
  }
  const auto n = static_cast<Eigen::Index>(3 * inputs.model.ids.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) covariance(i, i) = sigma[i % 3] * sigma[i % 3];
  inputs.model.covariance = covariance;
  for (const ifc::Element& element : design.elements) {
    if (element.ifc_class != "IfcPlate" || !element.has_box) continue;
    judgement::PanelCase panel{element.guid,
                               element.name,
                               element.storey_guid,
                               element.instance,
                               {},
                               element.project_from_element,
                               element.box_low,
                               element.box_high,
                               judgement::tolerances_of(tolerances, ifc::facts_of(element))};
    for (std::size_t i = 0; i < inputs.anchors.size(); ++i)
      if (distance_from_box(element.box_low, element.box_high,
                            element.project_from_element.inverse() * inputs.anchors[i].design) < 0.3)
        panel.anchors.push_back(i);
    if (!panel.anchors.empty() && !element.is_anchor) inputs.panels.push_back(panel);
  }
  face(inputs, normal);
  return judgement::judge_deviations(inputs, {0.005, 0.0228});
}

/// Residuals against the survey for the measured anchors, with floors, a transfer and a column.
inline AccuracyT residuals(const DeviationT& deviation, double dz) {
  AccuracyT accuracy;
  accuracy.tau = 0.005, accuracy.guard_factor = 2;
  auto comparison = std::make_unique<AccuracyComparisonT>();
  comparison->use = AnchorUse::check, comparison->reference = AccuracyReference::survey, comparison->evidence = true;
  for (const auto& anchor : deviation.anchors) {
    if (!anchor->deviation.allFinite()) continue;
    auto row = std::make_unique<AnchorAccuracyT>();
    row->id = anchor->id, row->floor = anchor->floor, row->column = 1;
    row->use = comparison->anchors == 0 ? AnchorUse::control : AnchorUse::check;
    row->survey = std::make_unique<AnchorDifferenceT>();
    row->survey->dx = 0.0001, row->survey->dy = 0.0002, row->survey->dz = dz, row->survey->u_dz = 0.0004;
    row->survey->distance = Eigen::Vector3d(0.0001, 0.0002, dz).norm();
    row->survey->verdict = ToleranceVerdict::pass, row->survey->conformance_probability = 0.999;
    accuracy.anchors.push_back(std::move(row));
    ++comparison->anchors;
  }
  for (const auto& built : deviation.floors) {
    if (built->floor == 0) continue;
    auto floor = std::make_unique<FloorAccuracyT>();
    floor->floor = built->floor, floor->anchors = 1, floor->mean_dz = dz, floor->drift = dz * built->floor;
    floor->drift_verdict = ToleranceVerdict::pass, floor->rmse_z = floor->max_abs_dz = std::abs(dz);
    for (const double tolerance : {0.002, 0.0025}) {
      floor->pass_rates.push_back(std::make_unique<PassRateT>());
      floor->pass_rates.back()->tolerance = tolerance, floor->pass_rates.back()->rate = 1;
    }
    comparison->floors.push_back(std::move(floor));
  }
  for (const int column : {0, 1}) {
    auto transfer = std::make_unique<HeightTransferT>();
    transfer->lower_floor = 1, transfer->upper_floor = 2, transfer->column = column, transfer->anchors = 2;
    transfer->error = 0.0004, transfer->difference = -0.0004, transfer->u = 0.0006,
    transfer->verdict = ToleranceVerdict::pass;
    comparison->transfers.push_back(std::move(transfer));
  }
  auto drift = std::make_unique<ColumnDriftT>();
  drift->column = 1, drift->lowest_floor = 1, drift->highest_floor = 2, drift->drift = -0.002,
  drift->relative_drift = 0.001;
  comparison->columns.push_back(std::move(drift));
  accuracy.comparisons.push_back(std::move(comparison));
  return accuracy;
}

}  // namespace plumbline::test
