#include "ifc/design.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <unordered_map>

#include "ifc/ifc_extent.hpp"
#include "ifc/ifc_model.hpp"
#include "ifc/ifc_placement.hpp"
#include "ifc/ifc_units.hpp"

namespace plumbline::bim {
namespace {

/// Slack of "the placement lies within the shape": bim practice puts origins on surfaces, and surfaces are rounded.
constexpr double kPlacementSlack = 0.005;

using Parents = std::unordered_map<std::uint64_t, std::uint64_t>;

/// Upward links of the spatial tree: containment first, then aggregation, nesting, and features to their host.
struct Tree {
  Parents container, whole;

  explicit Tree(const Model& model) {
    const auto add = [&](Parents& parents, const char* keyword, const char* parent, const char* children) {
      for (const Entity& relation : model.all(keyword)) {
        const std::uint64_t to = relation.reference(parent);
        const bool many = relation.value(children).kind == step::Kind::list;
        const auto ids =
            many ? relation.references(children) : std::vector<std::uint64_t>{relation.reference(children)};
        for (const std::uint64_t id : ids) parents.try_emplace(id, to);
      }
    };
    add(container, "IFCRELCONTAINEDINSPATIALSTRUCTURE", "RelatingStructure", "RelatedElements");
    add(whole, "IFCRELAGGREGATES", "RelatingObject", "RelatedObjects");
    add(whole, "IFCRELNESTS", "RelatingObject", "RelatedObjects");
    add(whole, "IFCRELVOIDSELEMENT", "RelatingBuildingElement", "RelatedOpeningElement");
    add(whole, "IFCRELPROJECTSELEMENT", "RelatingElement", "RelatedFeatureElement");
    add(whole, "IFCRELFILLSELEMENT", "RelatingOpeningElement", "RelatedBuildingElement");
  }

  std::uint64_t parent(std::uint64_t id) const {
    if (const auto found = container.find(id); found != container.end()) return found->second;
    const auto found = whole.find(id);
    return found == whole.end() ? 0 : found->second;
  }

  /// The nearest storey above; 0 if there is none. Longer chains than 100 are cycles.
  std::uint64_t storey_above(const Model& model, std::uint64_t id) const {
    for (int depth = 0; id && depth < 100; ++depth) {
      id = parent(id);
      if (model.keyword(id) == "IFCBUILDINGSTOREY") return id;
    }
    return 0;
  }
};

class Reader {
 public:
  Reader(const step::File& file, const AnchorRule& rule)
      : model_(file), rule_(rule), tree_(model_), placements_(model_) {
    design_.file_name = file.name();
    design_.schema = schema_name(model_.schema());
  }

  Design read() {
    const auto projects = model_.all("IFCPROJECT");
    if (projects.empty())
      throw step::Error(design_.file_name + ": found no IfcProject, expected a building model with one");
    design_.project_guid = projects[0].text("GlobalId");
    design_.project_name = projects[0].text("Name");
    units_ = read_units(model_, projects[0], design_.warnings);
    design_.length_unit = units_.length;
    design_.length_unit_name = units_.length_name;
    read_storeys();
    read_type_names();
    read_elements();
    place_aggregates();
    read_fixings();
    read_map_conversion();
    return std::move(design_);
  }

 private:
  RigidTransform placement_of(const Entity& product) {
    const auto id = product.optional_reference("ObjectPlacement");
    if (!id) return {};
    RigidTransform placement = placements_.project_from_placement(*id, product.id());
    placement.translation *= units_.length;
    return placement;
  }

  void read_storeys() {
    for (const Entity& entity : model_.all("IFCBUILDINGSTOREY")) {
      Storey storey;
      storey.guid = entity.text("GlobalId");
      storey.name = entity.text("Name");
      storey.instance = entity.id();
      storey.placement_height = placement_of(entity).translation.z();
      const auto elevation = entity.optional_number("Elevation");
      storey.elevation = elevation ? *elevation * units_.length : storey.placement_height;
      design_.storeys.push_back(std::move(storey));
    }
    if (design_.storeys.empty())
      throw step::Error(design_.file_name +
                        ": found no IfcBuildingStorey, expected at least one; export the model with its "
                        "storeys (the deviations are reported floor by floor)");
    // A constant difference is a height datum; one that varies is a storey whose two heights disagree.
    const double offset = design_.storeys[0].placement_height - design_.storeys[0].elevation;
    for (const Storey& storey : design_.storeys)
      if (std::abs(storey.placement_height - storey.elevation - offset) > kPlacementSlack)
        design_.warnings.push_back("storey '" + storey.name + "' has Elevation " + std::to_string(storey.elevation) +
                                   " m, but its placement is at " + std::to_string(storey.placement_height) + " m");
    std::stable_sort(design_.storeys.begin(), design_.storeys.end(),
                     [](const Storey& a, const Storey& b) { return a.elevation < b.elevation; });
    for (std::size_t i = 0; i < design_.storeys.size(); ++i) storey_index_[design_.storeys[i].instance] = i;
  }

  void read_type_names() {
    for (const Entity& relation : model_.all("IFCRELDEFINESBYTYPE")) {
      const step::Instance* type = model_.file().find(relation.reference("RelatingType"));
      if (!type || model_.file().type_name(*type).empty()) continue;
      const auto arguments = model_.file().arguments(*type);  // every IfcTypeObject: GlobalId, OwnerHistory, Name
      if (arguments.size() < 3 || arguments[2].kind != step::Kind::text) continue;
      for (const std::uint64_t id : relation.references("RelatedObjects"))
        type_names_.try_emplace(id, arguments[2].text);
    }
  }

  void read_elements() {
    std::regex pattern;
    try {
      pattern = std::regex(rule_.pattern);
    } catch (const std::regex_error& error) {
      throw step::Error("anchor pattern '" + rule_.pattern +
                        "' is no regular expression (ECMAScript): " + error.what());
    }
    Extents extents(model_, units_.plane_angle);
    std::vector<std::string_view> classes;  // by step::Instance::type
    for (const std::string& keyword : model_.file().type_names())
      classes.push_back(keyword == "IFCPROXY" ? "IfcProxy" : element_class_name(model_.schema(), keyword));
    for (const step::Instance& instance : model_.file().instances()) {
      if (classes[instance.type].empty()) continue;
      const Entity entity = model_.entity(instance);
      Element element = read_element(entity, classes[instance.type]);
      element.is_anchor = matches(element, pattern);
      // IfcProxy is no IfcElement, but old exporters write anchors as such.
      if (element.ifc_class == "IfcProxy" && !element.is_anchor) continue;
      element.is_panel =
          !element.is_anchor && (element.ifc_class == "IfcPlate" || element.ifc_class == "IfcPlateStandardCase" ||
                                 element.ifc_class == "IfcCurtainWall");
      read_shape(entity, extents, element);
      design_.elements.push_back(std::move(element));
    }
    for (const auto& [kind, count] : unread_)
      design_.warnings.push_back(std::to_string(count) +
                                 " elements keep the origin of their placement as reference point: " + kind);
  }

  Element read_element(const Entity& entity, std::string_view ifc_class) {
    Element element;
    element.instance = entity.id();
    element.ifc_class = ifc_class;
    element.guid = entity.text("GlobalId");
    element.name = entity.text("Name");
    element.object_type = entity.text("ObjectType");
    if (ifc_class != "IfcProxy") element.tag = entity.text("Tag");
    if (const auto type = type_names_.find(entity.id()); type != type_names_.end()) element.type_name = type->second;
    if (const std::uint64_t storey = tree_.storey_above(model_, entity.id())) {
      element.storey = design_.storeys[storey_index_.at(storey)].name;
      element.storey_guid = design_.storeys[storey_index_.at(storey)].guid;
    }
    element.project_from_element = placement_of(entity);
    element.position = element.project_from_element.translation;
    return element;
  }

  bool matches(const Element& element, const std::regex& pattern) const {
    const auto listed = [](const std::vector<std::string>& list, const std::string& text) {
      return !text.empty() && std::find(list.begin(), list.end(), text) != list.end();
    };
    if (listed(rule_.classes, element.ifc_class) || listed(rule_.guids, element.guid)) return true;
    if (listed(rule_.names, element.name) || listed(rule_.names, element.tag)) return true;
    if (rule_.pattern.empty()) return false;
    // Bounded, because std::regex recurses once a character.
    const auto found = [&](const std::string& text) { return std::regex_search(text.substr(0, 1000), pattern); };
    return found(element.name) || found(element.object_type) || found(element.type_name) || found(element.tag);
  }

  /// The rule of the reference point: the placement if it lies within the element's own shape, else a point of the
  /// shape.
  void read_shape(const Entity& entity, Extents& extents, Element& element) {
    std::vector<ItemExtent> items;
    try {
      if (const auto shape = entity.optional_reference("Representation")) items = extents.of_shape(*shape, entity.id());
    } catch (const UnsupportedGeometry& reason) {
      ++unread_[reason.what()];
      return;
    }
    Eigen::AlignedBox3d box;
    for (const ItemExtent& item : items)
      for (const Eigen::Vector3d& point : item.points) box.extend(Eigen::Vector3d(point * units_.length));
    if (box.isEmpty() || !box.min().allFinite() || !box.max().allFinite()) return;
    element.has_box = true;
    element.box_low = box.min();
    element.box_high = box.max();
    const Eigen::Vector3d slack = Eigen::Vector3d::Constant(kPlacementSlack);
    Eigen::Vector3d local = Eigen::Vector3d::Zero();
    if (!Eigen::AlignedBox3d(box.min() - slack, box.max() + slack).contains(local)) {
      const bool axis = items.size() == 1 && items[0].axis_middle;
      element.rule = axis ? ReferencePointRule::axis_middle : ReferencePointRule::bounding_box_centre;
      local = axis ? Eigen::Vector3d(*items[0].axis_middle * units_.length) : box.center();
    }
    element.position = element.project_from_element * local;
    if (!element.is_anchor || items.size() < 2) return;
    for (const ItemExtent& item : items) {
      Eigen::AlignedBox3d own;
      for (const Eigen::Vector3d& point : item.points) own.extend(Eigen::Vector3d(point * units_.length));
      element.item_positions.push_back(element.project_from_element * own.center());
    }
  }

  /// Aggregates without a shape of their own (curtain walls, assemblies) lie where their parts are.
  void place_aggregates() {
    std::unordered_map<std::uint64_t, std::size_t> index;
    for (std::size_t i = 0; i < design_.elements.size(); ++i) index[design_.elements[i].instance] = i;
    std::map<std::size_t, Eigen::AlignedBox3d> boxes;  // in the axes of the aggregate
    for (const Element& part : design_.elements) {
      std::uint64_t above = part.instance;
      for (int depth = 0; depth < 100; ++depth) {
        const auto up = tree_.whole.find(above);
        if (up == tree_.whole.end() || !index.contains(up->second)) break;
        above = up->second;
        Element& whole = design_.elements[index[above]];
        if (depth == 0) design_.elements[index[part.instance]].parent_guid = whole.guid;
        if (whole.has_box || !part.has_box) continue;
        const RigidTransform whole_from_part = whole.project_from_element.inverse() * part.project_from_element;
        for (int corner = 0; corner < 8; ++corner) {
          const Eigen::Vector3d point(corner & 1 ? part.box_high.x() : part.box_low.x(),
                                      corner & 2 ? part.box_high.y() : part.box_low.y(),
                                      corner & 4 ? part.box_high.z() : part.box_low.z());
          boxes[index[above]].extend(Eigen::Vector3d(whole_from_part * point));
        }
      }
    }
    for (const auto& [i, box] : boxes) {
      Element& whole = design_.elements[i];
      whole.has_box = true;
      whole.box_low = box.min();
      whole.box_high = box.max();
      const Eigen::Vector3d slack = Eigen::Vector3d::Constant(kPlacementSlack);
      if (Eigen::AlignedBox3d(box.min() - slack, box.max() + slack).contains(Eigen::Vector3d::Zero().eval())) continue;
      whole.rule = ReferencePointRule::parts_centre;
      whole.position = whole.project_from_element * Eigen::Vector3d(box.center());
    }
  }

  /// Which anchors the file itself ties to a panel.
  void read_fixings() {
    std::unordered_map<std::uint64_t, Element*> elements;
    for (Element& element : design_.elements) elements[element.instance] = &element;
    for (const Entity& relation : model_.all("IFCRELCONNECTSWITHREALIZINGELEMENTS"))
      for (const char* side : {"RelatingElement", "RelatedElement"}) {
        const auto panel = elements.find(relation.reference(side));
        if (panel == elements.end() || !panel->second->is_panel) continue;
        for (const std::uint64_t id : relation.references("RealizingElements"))
          if (const auto anchor = elements.find(id); anchor != elements.end() && anchor->second->is_anchor)
            panel->second->anchor_guids.push_back(anchor->second->guid);
      }
  }

  void read_map_conversion() {
    for (const char* keyword : {"IFCMAPCONVERSION", "IFCMAPCONVERSIONSCALED"})
      for (const Entity& entity : model_.all(keyword)) {
        MapConversion map;
        map.eastings = entity.number("Eastings");
        map.northings = entity.number("Northings");
        map.orthogonal_height = entity.number("OrthogonalHeight");
        map.x_axis_abscissa = entity.optional_number("XAxisAbscissa").value_or(1);
        map.x_axis_ordinate = entity.optional_number("XAxisOrdinate").value_or(0);
        map.scale_given = entity.optional_number("Scale").has_value();
        map.scale = entity.optional_number("Scale").value_or(1);
        double map_unit = 1;
        const Entity crs = model_.entity(entity.reference("TargetCRS"), entity.id());
        if (crs.keyword() == "IFCPROJECTEDCRS") {
          map.crs_name = crs.text("Name");
          if (const auto unit = crs.optional_reference("MapUnit")) map_unit = unit_factor(model_, *unit);
        }
        check_scale(map, map_unit);
        design_.map_conversion = map;
        return;
      }
    read_map_property_set();
  }

  /// IFC2X3 has no IfcMapConversion; the usual stand-in is a property set.
  void read_map_property_set() {
    for (const Entity& set : model_.all("IFCPROPERTYSET")) {
      if (set.text("Name") != "ePset_MapConversion" && set.text("Name") != "ePSet_MapConversion") continue;
      MapConversion map;
      for (const std::uint64_t id : set.references("HasProperties")) {
        if (model_.keyword(id) != "IFCPROPERTYSINGLEVALUE") continue;
        const Entity property = model_.entity(id, set.id());
        const std::string name = property.text("Name");
        const step::Value& value = property.value("NominalValue");
        if (value.kind != step::Kind::typed || value.items.empty() || !value.items[0].is_number()) continue;
        const double number = value.items[0].number;
        if (name == "Eastings") map.eastings = number;
        if (name == "Northings") map.northings = number;
        if (name == "OrthogonalHeight") map.orthogonal_height = number;
        if (name == "XAxisAbscissa") map.x_axis_abscissa = number;
        if (name == "XAxisOrdinate") map.x_axis_ordinate = number;
        if (name == "Scale") map.scale = number, map.scale_given = true;
      }
      check_scale(map, 1);
      design_.map_conversion = map;
      return;
    }
  }

  /// The standard's scale is project unit over map unit, times a grid scale near 1; exporters have written its inverse
  /// and left it out.
  void check_scale(const MapConversion& map, double map_unit) {
    const double expected = units_.length / map_unit;
    if (std::abs(map.scale / expected - 1) < 0.01) return;
    design_.warnings.push_back("the map conversion has scale " + std::to_string(map.scale) +
                               (map.scale_given ? "" : " (not given)") + ", expected about " +
                               std::to_string(expected) +
                               " for these units: check it against surveyed points before use");
  }

  Model model_;
  const AnchorRule& rule_;
  Tree tree_;
  Placements placements_;
  Units units_;
  Design design_;
  std::unordered_map<std::uint64_t, std::size_t> storey_index_;
  std::unordered_map<std::uint64_t, std::string> type_names_;
  std::map<std::string, int> unread_;
};

}  // namespace

const char* name_of(ReferencePointRule rule) {
  switch (rule) {
    case ReferencePointRule::placement:
      return "placement";
    case ReferencePointRule::axis_middle:
      return "axis_middle";
    case ReferencePointRule::bounding_box_centre:
      return "bounding_box_centre";
    case ReferencePointRule::parts_centre:
      return "parts_centre";
  }
  return "";
}

Design read_design(const step::File& file, const AnchorRule& rule) { return Reader(file, rule).read(); }

}  // namespace plumbline::bim
