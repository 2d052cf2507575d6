#include "artifacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "artifacts/fitted_datum.hpp"
#include "building/ifc/facade_artifact.hpp"

namespace plumbline::ifc {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

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
  to.box_low = element.has_box ? element.box_low : Eigen::Vector3d::Constant(unknown);
  to.box_high = element.has_box ? element.box_high : Eigen::Vector3d::Constant(unknown);
  to.item_positions = element.item_positions;
  to.sag = element.sag, to.filled = element.filled, to.rectangles = element.rectangles;
  to.anchor_guids = element.anchor_guids;
  to.instance = element.instance;
  to.host_guid = element.host_guid;
  if (element.is_anchor || element.is_panel) to.facade = to_artifact(element.facade);
  for (const Property& property : element.properties) {
    auto item = std::make_unique<DesignPropertyT>();
    item->set = property.set, item->name = property.name, item->text = property.text, item->number = property.number;
    item->measure = property.measure, item->lower = property.lower, item->upper = property.upper;
    item->holder = property.holder;
    to.properties.push_back(std::move(item));
  }
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
  to.sag = element.sag, to.filled = element.filled, to.rectangles = element.rectangles;
  to.anchor_guids = element.anchor_guids;
  to.instance = element.instance;
  to.host_guid = element.host_guid;
  if (element.facade) to.facade = ifc::from_artifact(*element.facade);
  for (const auto& property : element.properties)
    to.properties.push_back({property->set, property->name, property->text, property->number, property->measure,
                             property->lower, property->upper, property->holder});
  return to;
}

}  // namespace

std::unique_ptr<JudgementRequestT> to_artifact(const NotApplied& request) {
  auto to = std::make_unique<JudgementRequestT>();
  to->asked = request.asked, to->by = request.by, to->not_judged = request.reason;
  return to;
}

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
  for (const Facade& facade : design.facades) to.facades.push_back(to_artifact(facade));
  const bool one = design.facades.size() == 1 && design.facades[0].bend < 1e-3;
  to.facade_normal = one ? design.facades[0].out : Eigen::Vector3d::Constant(unknown);
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
    to.map_conversion->map_unit = map.map_unit;
  }
  to.site_origin = design.site_origin;
  for (const GridAxis& axis : design.grid) {
    auto item = std::make_unique<DesignGridAxisT>();
    item->tag = axis.tag, item->family = axis.family, item->point = axis.point, item->direction = axis.direction;
    if (std::isfinite(axis.begin) && std::isfinite(axis.end)) item->begin = axis.begin, item->end = axis.end;
    to.grid_axes.push_back(std::move(item));
  }
  to.true_north = design.true_north;
  to.skipped = design.skipped;
  to.warnings = design.warnings;
  for (const NotApplied& request : design.not_applied) to.not_applied.push_back(to_artifact(request));
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
  for (const auto& facade : artifact.facades) to.facades.push_back(from_artifact(*facade));
  if (const auto& map = artifact.map_conversion)
    to.map_conversion = MapConversion{map->eastings,        map->northings,       map->orthogonal_height,
                                      map->x_axis_abscissa, map->x_axis_ordinate, map->scale,
                                      map->scale_given,     map->crs_name,        map->map_unit};
  to.site_origin = artifact.site_origin;
  to.grid = grid_of(artifact), to.true_north = artifact.true_north;
  to.skipped = artifact.skipped;
  to.warnings = artifact.warnings;
  for (const auto& request : artifact.not_applied)
    to.not_applied.push_back({request->asked, request->by, request->not_judged});
  return to;
}

PointsT anchor_points(const Design& design) {
  std::map<std::string, int> names;
  for (const Element& element : design.elements)
    if (element.is_anchor) ++names[element.name];
  PointsT points;
  mark_designed(points);
  for (const Element& element : design.elements) {
    if (!element.is_anchor) continue;
    auto point = std::make_unique<PointT>();
    point->id = element.name.empty() || names[element.name] > 1 ? element.guid : element.name;
    point->position = element.position;
    point->sigma.setConstant(unknown);
    points.points.push_back(std::move(point));
  }
  return points;
}

}  // namespace plumbline::ifc
