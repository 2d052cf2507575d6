#include "ifc/design.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
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
/// GlobalId, OwnerHistory, Name, Description, ObjectType, ObjectPlacement, Representation.
constexpr std::size_t kArgumentsOfProduct = 7;

using Parents = std::unordered_map<std::uint64_t, std::uint64_t>;

/// Relations that cannot be read: counted by keyword, with the first reason.
using Damage = std::map<std::string, std::pair<int, std::string>>;

/// Calls `use` with every instance of a keyword, one at a time; what is damaged is counted, not fatal.
template <typename Use>
void for_all(const Model& model, const char* keyword, Damage& damage, Use use) {
  for (const std::uint32_t index : model.file().of_type(keyword)) {
    try {
      use(model.entity(model.file().instances()[index]));
    } catch (const step::Error& error) {
      auto& [count, reason] = damage[keyword];
      if (++count == 1) reason = error.what();
    }
  }
}

/// Upward links of the spatial tree: containment first, then aggregation, nesting, and features to their host.
struct Tree {
  Parents container, whole;

  Tree(const Model& model, Damage& damage) {
    const auto add = [&](Parents& parents, const char* keyword, const char* parent, const char* children) {
      for_all(model, keyword, damage, [&](const Entity& relation) {
        const std::uint64_t to = relation.reference(parent);
        const bool many = relation.value(children).kind == step::Kind::list;
        const auto ids =
            many ? relation.references(children) : std::vector<std::uint64_t>{relation.reference(children)};
        for (const std::uint64_t id : ids) parents.try_emplace(id, to);
      });
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
      : model_(file), rule_(rule), tree_(model_, damage_), placements_(model_) {
    for (const std::string& text : rule.selections) selections_.emplace_back(text);
    design_.file_name = file.name();
    design_.schema = schema_name(model_.schema());
  }

  Design read() {
    const auto projects = model_.all("IFCPROJECT");
    if (projects.empty()) {
      design_.warnings.push_back(
          "the file has no IfcProject, which says what its units are; lengths are taken as metres");
    } else {
      design_.project_guid = projects[0].text("GlobalId");
      design_.project_name = projects[0].text("Name");
      units_ = read_units(model_, projects[0], design_.warnings);
    }
    if (projects.size() > 1)
      design_.warnings.push_back("the file has " + std::to_string(projects.size()) +
                                 " projects; units and georeference are those of the first");
    design_.length_unit = units_.length;
    design_.length_unit_name = units_.length_name;
    read_storeys();
    read_type_names();
    read_elements();
    place_aggregates();
    read_fixings();
    read_properties();
    read_site();
    read_map_conversion();
    tell_damage();
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
    for_all(model_, "IFCBUILDINGSTOREY", damage_, [&](const Entity& entity) {
      Storey storey;
      storey.guid = entity.text("GlobalId");
      storey.name = entity.text("Name");
      storey.instance = entity.id();
      const auto elevation = entity.optional_number("Elevation");
      try {
        storey.placement_height = placement_of(entity).translation.z();
      } catch (const step::Error& error) {
        storey.placement_height = elevation.value_or(0) * units_.length;
        design_.warnings.push_back("storey '" + storey.name + "' cannot be placed: " + error.what());
      }
      storey.elevation = elevation ? *elevation * units_.length : storey.placement_height;
      design_.storeys.push_back(std::move(storey));
    });
    if (design_.storeys.empty()) {
      design_.warnings.push_back(
          "the file has no IfcBuildingStorey: statistics by floor cannot be written into it; export the model with its "
          "storeys");
      return;
    }
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
    for_all(model_, "IFCRELDEFINESBYTYPE", damage_, [&](const Entity& relation) {
      const step::Instance* type = model_.file().find(relation.reference("RelatingType"));
      if (!type || model_.file().type_name(*type).empty()) return;
      const auto arguments = model_.file().arguments(*type);  // every IfcTypeObject: GlobalId, OwnerHistory, Name
      if (arguments.size() < 3 || arguments[2].kind != step::Kind::text) return;
      for (const std::uint64_t id : relation.references("RelatedObjects")) {
        type_names_.try_emplace(id, arguments[2].text);
        types_.try_emplace(id, type->id);
      }
    });
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
      try {
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
      } catch (const step::Error& error) {
        skip(instance, classes[instance.type], error.what());
      }
    }
    for (const auto& [kind, count] : unread_)
      design_.warnings.push_back(std::to_string(count) +
                                 " elements keep the origin of their placement as reference point: " + kind);
  }

  /// Names an element that cannot be placed. A shape that cannot be read skips only the shape; this is for the rest.
  void skip(const step::Instance& instance, std::string_view ifc_class, const std::string& reason) {
    std::string name;
    try {
      const auto arguments = model_.file().arguments(instance);
      if (arguments.size() > 2 && arguments[2].kind == step::Kind::text) name = arguments[2].text;
    } catch (const step::Error&) {  // then it has no name
    }
    design_.skipped.push_back(std::string(ifc_class) + " '" + name + "' (#" + std::to_string(instance.id) +
                              "): " + reason);
  }

  void tell_damage() {
    for (const auto& [keyword, entry] : damage_)
      design_.warnings.push_back(std::to_string(entry.first) + " instances of " + keyword +
                                 " cannot be read and were passed over; the first: " + entry.second);
    if (design_.skipped.empty()) return;
    std::string text = std::to_string(design_.skipped.size()) + " elements cannot be placed and were left out: ";
    for (std::size_t i = 0; i < std::min<std::size_t>(design_.skipped.size(), 3); ++i)
      text += (i ? "; " : "") + design_.skipped[i];
    design_.warnings.push_back(text + (design_.skipped.size() > 3 ? "; …" : ""));
  }

  Element read_element(const Entity& entity, std::string_view ifc_class) {
    // An argument that is missing reads like $, and an anchor without placement would stand at the origin.
    if (entity.arguments().size() < kArgumentsOfProduct)
      throw step::Error(model_.file().where(model_.file().find(entity.id())->begin) + ": #" +
                        std::to_string(entity.id()) + " " + entity.keyword() + ": found " +
                        std::to_string(entity.arguments().size()) + " arguments, expected at least " +
                        std::to_string(kArgumentsOfProduct) + " (up to Representation)");
    Element element;
    element.instance = entity.id();
    element.ifc_class = ifc_class;
    element.guid = entity.text("GlobalId");
    element.name = entity.text("Name");
    element.object_type = entity.text("ObjectType");
    if (ifc_class != "IfcProxy") element.tag = entity.text("Tag");
    if (const auto type = type_names_.find(entity.id()); type != type_names_.end()) element.type_name = type->second;
    const auto storey = storey_index_.find(tree_.storey_above(model_, entity.id()));
    if (storey != storey_index_.end()) {
      element.storey = design_.storeys[storey->second].name;
      element.storey_guid = design_.storeys[storey->second].guid;
    }
    element.project_from_element = placement_of(entity);
    element.position = element.project_from_element.translation;
    if (std::any_of(selections_.begin(), selections_.end(), [](const Selection& s) { return s.needs_properties(); }))
      element.properties = properties_of(element.instance);
    return element;
  }

  bool matches(const Element& element, const std::regex& pattern) const {
    const auto listed = [](const std::vector<std::string>& list, const std::string& text) {
      return !text.empty() && std::find(list.begin(), list.end(), text) != list.end();
    };
    if (listed(rule_.guids, element.guid)) return true;
    // What an earlier campaign put beside an anchor bears its name and is none.
    if ((element.object_type == "AsBuiltAnchor" || element.object_type == "AsBuiltPanel") &&
        element.ifc_class == "IfcBuildingElementProxy")
      return false;
    if (listed(rule_.classes, element.ifc_class)) return true;
    if (listed(rule_.names, element.name) || listed(rule_.names, element.tag)) return true;
    if (std::any_of(selections_.begin(), selections_.end(),
                    [&](const Selection& selection) { return selection.matches(facts_of(element)); }))
      return true;
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
    } catch (const step::Error& error) {  // a dangling reference, an argument of another kind
      auto& [count, first] = damage_["shapes; their elements keep the origin of their placement"];
      if (++count == 1) first = error.what();
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
    for_all(model_, "IFCRELCONNECTSWITHREALIZINGELEMENTS", damage_, [&](const Entity& relation) {
      for (const char* side : {"RelatingElement", "RelatedElement"}) {
        const auto panel = elements.find(relation.reference(side));
        if (panel == elements.end() || !panel->second->is_panel) continue;
        for (const std::uint64_t id : relation.references("RealizingElements"))
          if (const auto anchor = elements.find(id); anchor != elements.end() && anchor->second->is_anchor)
            panel->second->anchor_guids.push_back(anchor->second->guid);
      }
    });
  }

  /// Which property sets every object has; read when first asked for, because most files are never asked.
  void find_property_sets() {
    if (property_sets_known_) return;
    property_sets_known_ = true;
    for_all(model_, "IFCRELDEFINESBYPROPERTIES", damage_, [&](const Entity& relation) {
      if (relation.value("RelatingPropertyDefinition").kind != step::Kind::reference) return;
      const std::uint64_t set = relation.reference("RelatingPropertyDefinition");
      if (model_.keyword(set) != "IFCPROPERTYSET") return;
      for (const std::uint64_t id : relation.references("RelatedObjects")) property_sets_[id].push_back(set);
    });
  }

  void add_properties(std::uint64_t set_id, std::vector<Property>& to) {
    const Entity set = model_.entity(set_id);
    const std::string set_name = set.text("Name");
    for (const std::uint64_t id : set.references("HasProperties")) {
      if (model_.keyword(id) != "IFCPROPERTYSINGLEVALUE") continue;
      const Entity entity = model_.entity(id, set_id);
      Property property{set_name, entity.text("Name"), "", std::numeric_limits<double>::quiet_NaN()};
      const bool known = std::any_of(to.begin(), to.end(), [&](const Property& other) {
        return other.set == property.set && other.name == property.name;
      });
      const step::Value& value = entity.value("NominalValue");
      if (known || value.kind != step::Kind::typed || value.items.empty()) continue;
      const step::Value& item = value.items[0];
      property.text = item.text;
      if (item.is_number()) {
        const bool length = value.text.ends_with("LENGTHMEASURE");
        property.number = item.number * (length ? units_.length : 1);
        char text[40];
        const auto end = std::to_chars(text, text + sizeof text, item.number);
        property.text.assign(text, end.ptr);
      }
      to.push_back(std::move(property));
    }
  }

  std::vector<Property> properties_of(std::uint64_t element) {
    find_property_sets();
    std::vector<Property> properties;
    const auto add = [&](std::uint64_t set) {
      try {
        add_properties(set, properties);
      } catch (const step::Error& error) {
        auto& [count, reason] = damage_["IFCPROPERTYSET"];
        if (++count == 1) reason = error.what();
      }
    };
    if (const auto sets = property_sets_.find(element); sets != property_sets_.end())
      for (const std::uint64_t set : sets->second) add(set);
    if (const auto type = types_.find(element); type != types_.end()) {
      const auto arguments = model_.file().arguments(*model_.file().find(type->second));
      // every IfcTypeObject: GlobalId, OwnerHistory, Name, Description, ApplicableOccurrence, HasPropertySets
      if (arguments.size() > 5)
        for (const step::Value& set : arguments[5].items)
          if (set.kind == step::Kind::reference && model_.keyword(set.id) == "IFCPROPERTYSET") add(set.id);
    }
    return properties;
  }

  void read_properties() {
    for (Element& element : design_.elements)
      if ((element.is_anchor || element.is_panel) && element.properties.empty())
        element.properties = properties_of(element.instance);
  }

  void read_site() {
    for_all(model_, "IFCSITE", damage_, [&](const Entity& site) {
      if (!design_.site_origin.allFinite()) design_.site_origin = placement_of(site).translation;
    });
  }

  void read_map_conversion() {
    int found = 0;
    for (const char* keyword : {"IFCMAPCONVERSION", "IFCMAPCONVERSIONSCALED", "IFCRIGIDOPERATION"})
      for_all(model_, keyword, damage_, [&](const Entity& entity) {
        const MapConversion map = read_conversion(entity);
        if (++found == 1)
          design_.map_conversion = map;
        else if (!(map == *design_.map_conversion))
          design_.warnings.push_back("the file has another georeference (#" + std::to_string(entity.id()) + ", " +
                                     describe(map) + ") beside the first (" + describe(*design_.map_conversion) +
                                     "); the first is handed on");
      });
    if (found == 0) read_map_property_set();
    if (!design_.map_conversion) return;
    if (design_.site_origin.allFinite() && design_.site_origin.head<2>().norm() > 1e4)
      design_.warnings.push_back(
          "the file is georeferenced twice: its site stands far from the origin and it has a map conversion; check "
          "both "
          "against surveyed points before use");
  }

  MapConversion read_conversion(const Entity& entity) {
    MapConversion map;
    if (entity.keyword() == "IFCRIGIDOPERATION") {
      map.eastings = entity.number("FirstCoordinate");
      map.northings = entity.number("SecondCoordinate");
      map.orthogonal_height = entity.optional_number("Height").value_or(0);
    } else {
      map.eastings = entity.number("Eastings");
      map.northings = entity.number("Northings");
      map.orthogonal_height = entity.number("OrthogonalHeight");
      map.x_axis_abscissa = entity.optional_number("XAxisAbscissa").value_or(1);
      map.x_axis_ordinate = entity.optional_number("XAxisOrdinate").value_or(0);
      map.scale_given = entity.optional_number("Scale").has_value();
      map.scale = entity.optional_number("Scale").value_or(1);
    }
    const std::uint64_t target = entity.reference("TargetCRS");
    if (model_.keyword(target) == "IFCPROJECTEDCRS") {
      const Entity crs = model_.entity(target, entity.id());
      map.crs_name = crs.text("Name");
      if (const auto unit = crs.optional_reference("MapUnit")) map.map_unit = unit_factor(model_, *unit);
    }
    check_scale(map, std::isnan(map.map_unit) ? 1 : map.map_unit);
    return map;
  }

  static std::string describe(const MapConversion& map) {
    return "E " + std::to_string(map.eastings) + ", N " + std::to_string(map.northings) + ", H " +
           std::to_string(map.orthogonal_height);
  }

  /// IFC2X3 has no IfcMapConversion; the usual stand-in is a property set.
  void read_map_property_set() {
    for (const std::uint32_t index : model_.file().of_type("IFCPROPERTYSET")) {
      const step::Instance& instance = model_.file().instances()[index];
      // A look at the bytes first: most files have thousands of sets.
      if (!model_.file().contains(instance, "et_MapConversion")) continue;
      const Entity set = model_.entity(instance);
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
  std::vector<Selection> selections_;
  Damage damage_;
  Tree tree_;
  Placements placements_;
  Units units_;
  Design design_;
  std::unordered_map<std::uint64_t, std::size_t> storey_index_;
  std::unordered_map<std::uint64_t, std::string> type_names_;
  std::unordered_map<std::uint64_t, std::uint64_t> types_;
  std::unordered_map<std::uint64_t, std::vector<std::uint64_t>> property_sets_;
  bool property_sets_known_ = false;
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

std::optional<Eigen::Vector3d> estimate_facade_normal(const Design& design) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero(), rest = Eigen::Vector2d::Zero();
  double anchors = 0, others = 0;
  for (const Element& element : design.elements) {
    if (element.is_anchor)
      centre += element.position.head<2>(), ++anchors;
    else
      rest += element.position.head<2>(), ++others;
  }
  if (anchors < 2) return {};
  centre /= anchors;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Element& element : design.elements) {
    if (!element.is_anchor) continue;
    const Eigen::Vector2d d = element.position.head<2>() - centre;
    scatter += d * d.transpose() / anchors;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
  const double across = std::sqrt(std::max(0.0, eigen.eigenvalues()(0))), along = std::sqrt(eigen.eigenvalues()(1));
  // 0.1 m: anchors of one column scatter by their tolerance only, which is no facade line.
  if (along < 0.1 || across > 0.05 * along) return {};
  Eigen::Vector2d normal = eigen.eigenvectors().col(0);
  const double outward = others > 0 ? normal.dot(centre - rest / others) : 0;
  // Without a building behind the anchors: towards the negative y axis, or the positive x axis if it is square to that.
  const bool undecided = std::abs(outward) < 0.01;
  const double sense = !undecided ? outward : std::abs(normal.y()) > 1e-6 ? -normal.y() : normal.x();
  if (sense < 0) normal = -normal;
  return Eigen::Vector3d(normal.x(), normal.y(), 0);
}

ElementFacts facts_of(const Element& element) {
  return {element.ifc_class,   element.guid,      element.name,   element.tag,
          element.object_type, element.type_name, element.storey, &element.properties};
}

Design read_design(const step::File& file, const AnchorRule& rule) { return Reader(file, rule).read(); }

}  // namespace plumbline::bim
