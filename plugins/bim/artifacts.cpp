#include "artifacts.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <tuple>

namespace plumbline::bim {
namespace {

Verdict verdict_from(ToleranceVerdict verdict) {
  switch (verdict) {
    case ToleranceVerdict::pass:
      return Verdict::pass;
    case ToleranceVerdict::undecided:
      return Verdict::undecided;
    case ToleranceVerdict::fail:
      return Verdict::fail;
    default:
      return Verdict::not_measured;
  }
}

DesignElementT to_artifact(const Element& element) {
  DesignElementT to;
  to.guid = element.guid;
  to.class_ = element.ifc_class;
  to.name = element.name;
  to.tag = element.tag;
  to.object_type = element.object_type;
  to.type_name = element.type_name;
  to.storey = element.storey;
  to.storey_guid = element.storey_guid;
  to.parent_guid = element.parent_guid;
  to.position = element.position;
  to.reference_point_rule = name_of(element.rule);
  to.is_anchor = element.is_anchor;
  to.is_panel = element.is_panel;
  to.placement = element.project_from_element;
  to.box_low = element.has_box ? element.box_low : Eigen::Vector3d::Constant(kUnknown);
  to.box_high = element.has_box ? element.box_high : Eigen::Vector3d::Constant(kUnknown);
  to.item_positions = element.item_positions;
  to.anchor_guids = element.anchor_guids;
  to.instance = element.instance;
  return to;
}

Element from_artifact(const DesignElementT& element) {
  Element to;
  to.guid = element.guid;
  to.ifc_class = element.class_;
  to.name = element.name;
  to.tag = element.tag;
  to.object_type = element.object_type;
  to.type_name = element.type_name;
  to.storey = element.storey;
  to.storey_guid = element.storey_guid;
  to.parent_guid = element.parent_guid;
  to.position = element.position;
  for (const auto rule :
       {ReferencePointRule::axis_middle, ReferencePointRule::bounding_box_centre, ReferencePointRule::parts_centre})
    if (element.reference_point_rule == name_of(rule)) to.rule = rule;
  to.is_anchor = element.is_anchor;
  to.is_panel = element.is_panel;
  to.project_from_element = element.placement;
  to.has_box = element.box_low.allFinite() && element.box_high.allFinite();
  if (to.has_box) to.box_low = element.box_low, to.box_high = element.box_high;
  to.item_positions = element.item_positions;
  to.anchor_guids = element.anchor_guids;
  to.instance = element.instance;
  return to;
}

/// 3 × 3 block of a point out of the packed lower triangle; from the standard deviations if that is empty.
Eigen::Matrix3d covariance_of(const PointsT& points, std::size_t index) {
  if (points.covariance.empty()) return points.points[index]->sigma.cwiseAbs2().asDiagonal();
  Eigen::Matrix3d block;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      const std::size_t row = 3 * index + i;
      block(static_cast<int>(i), static_cast<int>(j)) = block(static_cast<int>(j), static_cast<int>(i)) =
          points.covariance[row * (row + 1) / 2 + 3 * index + j];
    }
  return block;
}

SurveyResidual residual_from(const AnchorDifferenceT& difference) {
  return {{difference.dx, difference.dy, difference.dz},
          difference.u_dz,
          verdict_from(difference.verdict),
          difference.conformance_probability};
}

FloorResult floor_from(const FloorAccuracyT& floor, const AccuracyComparisonT& comparison, const AccuracyT& accuracy) {
  FloorResult result;
  result.floor = floor.floor;
  result.anchors_used = comparison.use == AnchorUse::check ? "check" : "control";
  result.evidence = comparison.evidence;
  result.anchors = floor.anchors;
  result.mean_dz = floor.mean_dz;
  result.drift = floor.drift;
  result.drift_verdict = verdict_from(floor.drift_verdict);
  result.rmse_z = floor.rmse_z;
  result.max_abs_dz = floor.max_abs_dz;
  if (floor.anchors == 0) return result;
  for (const auto& pass_rate : comparison.pass_rates) {
    double evaluated = 0, passed = 0;
    for (const auto& anchor : accuracy.anchors) {
      if (anchor->floor != floor.floor || anchor->use != comparison.use || !anchor->survey ||
          std::isnan(anchor->survey->dz))
        continue;
      ++evaluated;
      passed += std::abs(anchor->survey->dz) <= pass_rate->tolerance;
    }
    if (evaluated > 0) result.pass_rates.emplace_back(pass_rate->tolerance, passed / evaluated);
  }
  return result;
}

/// Those of the floor means, each with what the columns say between the same floors.
std::vector<TransferResult> transfers_from(const AccuracyComparisonT& comparison) {
  std::vector<TransferResult> transfers;
  for (const auto& transfer : comparison.transfers) {
    if (transfer->column != 0 || !std::isfinite(transfer->error)) continue;
    TransferResult result{transfer->lower_floor,
                          transfer->upper_floor,
                          transfer->error,
                          transfer->difference,
                          transfer->u,
                          transfer->anchors,
                          verdict_from(transfer->verdict),
                          {}};
    for (const auto& column : comparison.transfers)
      if (column->column > 0 && column->lower_floor == transfer->lower_floor)
        result.columns.emplace_back(column->column, column->difference);
    transfers.push_back(std::move(result));
  }
  return transfers;
}

ColumnResult column_from(const ColumnDriftT& column, const AccuracyComparisonT& comparison) {
  ColumnResult result;
  result.column = column.column;
  result.anchors_used = comparison.use == AnchorUse::check ? "check" : "control";
  result.lowest_floor = column.lowest_floor, result.highest_floor = column.highest_floor;
  result.drift = column.drift, result.u_drift = column.u_drift;
  result.drift_verdict = verdict_from(column.drift_verdict);
  result.relative_drift = column.relative_drift, result.u_relative_drift = column.u_relative_drift;
  result.relative_verdict = verdict_from(column.relative_verdict);
  return result;
}

PanelResult panel_from(const PanelAccuracyT& panel) {
  const std::tuple<const char*, const char*, const JudgedLengthT*> lengths[] = {
      {"out_of_plane", "OutOfPlane", panel.out_of_plane.get()},
      {"sideways", "Sideways", panel.sideways.get()},
      {"vertical", "Vertical", panel.vertical.get()},
      {"tilt", "Tilt", panel.tilt.get()},
      {"warp", "Warp", panel.warp.get()},
      {"misfit", "Misfit", panel.misfit.get()}};
  PanelResult result;
  result.guid = panel.guid;
  result.verdict = verdict_from(panel.verdict);
  for (const auto& [name, property, length] : lengths) {
    if (length) result.lengths.emplace_back(property, length->value);
    if (panel.decided_by == name) result.decided_by = property;
  }
  return result;
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

}  // namespace

DesignT to_artifact(const Design& design) {
  DesignT to;
  to.file_name = design.file_name;
  to.schema = design.schema;
  to.project_guid = design.project_guid;
  to.project_name = design.project_name;
  to.length_unit = design.length_unit;
  to.length_unit_name = design.length_unit_name;
  for (const Storey& storey : design.storeys) {
    auto item = std::make_unique<DesignStoreyT>();
    item->guid = storey.guid;
    item->name = storey.name;
    item->elevation = storey.elevation;
    item->placement_height = storey.placement_height;
    item->floor = static_cast<int>(to.storeys.size()) + 1;
    item->instance = storey.instance;
    to.storeys.push_back(std::move(item));
  }
  for (const Element& element : design.elements)
    to.elements.push_back(std::make_unique<DesignElementT>(to_artifact(element)));
  to.facade_normal = estimate_facade_normal(design).value_or(Eigen::Vector3d::Constant(kUnknown));
  if (design.map_conversion) {
    const MapConversion& map = *design.map_conversion;
    to.map_conversion = std::make_unique<DesignMapConversionT>();
    to.map_conversion->eastings = map.eastings;
    to.map_conversion->northings = map.northings;
    to.map_conversion->orthogonal_height = map.orthogonal_height;
    to.map_conversion->x_axis_abscissa = map.x_axis_abscissa;
    to.map_conversion->x_axis_ordinate = map.x_axis_ordinate;
    to.map_conversion->scale = map.scale;
    to.map_conversion->scale_given = map.scale_given;
    to.map_conversion->crs_name = map.crs_name;
  }
  to.warnings = design.warnings;
  return to;
}

Design from_artifact(const DesignT& artifact) {
  Design to;
  to.file_name = artifact.file_name;
  to.schema = artifact.schema;
  to.project_guid = artifact.project_guid;
  to.project_name = artifact.project_name;
  to.length_unit = artifact.length_unit;
  to.length_unit_name = artifact.length_unit_name;
  for (const auto& storey : artifact.storeys)
    to.storeys.push_back({storey->guid, storey->name, storey->elevation, storey->placement_height, storey->instance});
  for (const auto& element : artifact.elements) to.elements.push_back(from_artifact(*element));
  if (const auto& map = artifact.map_conversion)
    to.map_conversion =
        MapConversion{map->eastings,        map->northings, map->orthogonal_height, map->x_axis_abscissa,
                      map->x_axis_ordinate, map->scale,     map->scale_given,       map->crs_name};
  to.warnings = artifact.warnings;
  return to;
}

PointsT anchor_points(const Design& design) {
  std::map<std::string, int> names;
  for (const Element& element : design.elements)
    if (element.is_anchor) ++names[element.name];
  PointsT points;
  for (const Element& element : design.elements) {
    if (!element.is_anchor) continue;
    auto point = std::make_unique<PointT>();
    point->id = element.name.empty() || names[element.name] > 1 ? element.guid : element.name;
    point->position = element.position;
    point->sigma.setConstant(kUnknown);
    points.points.push_back(std::move(point));
  }
  return points;
}

AsBuilt as_built_from(const PointsT& model, const AccuracyT& accuracy) {
  const std::size_t n = 3 * model.points.size();
  if (!model.covariance.empty() && model.covariance.size() != n * (n + 1) / 2)
    throw std::runtime_error("input 'model': the covariance has " + std::to_string(model.covariance.size()) +
                             " values, expected " + std::to_string(n * (n + 1) / 2) + " for the lower triangle of " +
                             std::to_string(model.points.size()) + " points");
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < model.points.size(); ++i) index[model.points[i]->id] = i;
  AsBuilt as_built;
  as_built.headline_tolerance = as_built.tolerance_xy = as_built.tolerance_z = accuracy.tau;
  as_built.guard_factor = accuracy.guard_factor;
  for (const auto& anchor : accuracy.anchors) {
    AsBuiltAnchor to;
    to.id = anchor->id;
    to.floor = anchor->floor;
    to.column = anchor->column;
    to.role = anchor->use == AnchorUse::control ? "control" : "check";
    if (const auto found = index.find(anchor->id); found != index.end()) {
      to.position = model.points[found->second]->position;
      to.covariance = covariance_of(model, found->second);
    }
    if (anchor->survey) to.survey = residual_from(*anchor->survey);
    as_built.anchors.push_back(std::move(to));
  }
  for (const auto& panel : accuracy.panels) as_built.panels.push_back(panel_from(*panel));
  const AccuracyComparisonT* comparison = survey_comparison(accuracy);
  if (!comparison) return as_built;
  for (const auto& floor : comparison->floors) as_built.floors.push_back(floor_from(*floor, *comparison, accuracy));
  as_built.transfers = transfers_from(*comparison);
  for (const auto& column : comparison->columns) as_built.columns.push_back(column_from(*column, *comparison));
  return as_built;
}

}  // namespace plumbline::bim
