#include "building/ifc/design.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include "building/ifc/design_map.hpp"
#include "building/ifc/design_properties.hpp"
#include "building/ifc/element_choice.hpp"
#include "building/ifc/element_shapes.hpp"
#include "building/ifc/ifc_model.hpp"
#include "building/ifc/ifc_placement.hpp"
#include "building/ifc/ifc_units.hpp"
#include "building/ifc/inherited_tolerances.hpp"
#include "building/ifc/outer_sides.hpp"
#include "building/ifc/what_hangs.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::ifc {
namespace {

/// GlobalId, OwnerHistory, Name, Description, ObjectType, ObjectPlacement, Representation.
constexpr std::size_t kArgumentsOfProduct = 7;
/// So many of the elements that nothing is judged by have their shape read: enough to tell where the building stands
/// and what stands before it.
constexpr std::size_t kOtherShapes = 1000;

class Reader {
 public:
  Reader(const step::File& file, const AnchorRule& rule)
      : model_(file),
        rule_(rule),
        choice_(rule),
        tree_(model_, damage_),
        properties_(model_, damage_),
        placements_(model_) {
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
    properties_.length_unit = units_.length;
    read_storeys();
    read_elements();
    read_fixings();
    read_shapes();
    place_aggregates(tree_, design_);
    refuse_unplaced();
    if (rule_.panels.empty()) find_hanging();
    read_sides();
    read_properties();
    read_site();
    read_map_conversion(model_, damage_, design_);
    design_.grid = read_grid(model_, placements_, units_.length, design_.warnings);
    read_north();
    tell_damage();
    choice_.tell_idle(design_);
    assign_facades(design_, rule_.facades);
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

  void read_elements() {
    std::vector<std::string_view> classes;  // by step::Instance::type
    for (const std::string& keyword : model_.file().type_names())
      classes.push_back(keyword == "IFCPROXY" ? "IfcProxy" : element_class_name(model_.schema(), keyword));
    const step::Instances instances = model_.file().instances();
    if (choice_.needs_properties()) {
      std::unordered_set<std::uint64_t> all;
      for (std::size_t i = 0; i < instances.size(); ++i)
        if (!classes[instances.type(i)].empty()) all.insert(instances[i].id);
      properties_.find_sets(all);
    }
    for (std::size_t i = 0; i < instances.size(); ++i) {
      if (classes[instances.type(i)].empty()) continue;
      stop_point();
      const step::Instance instance = instances[i];
      try {
        const Entity entity = model_.entity(instance);
        Element element = read_element(entity, classes[instance.type]);
        element.is_anchor = choice_.is_anchor(element);
        // IfcProxy is no IfcElement, but old exporters write anchors as such.
        if (element.ifc_class == "IfcProxy" && !element.is_anchor) continue;
        const std::string kind = kind_of(entity, element.ifc_class);
        element.is_panel = choice_.is_panel(element, kind) && !element.is_anchor;
        element.is_cladding = element.is_panel && choice_.is_cladding(element, kind);
        if (!entity.optional_reference("ObjectPlacement")) unplaced_.insert(element.instance);
        design_.elements.push_back(std::move(element));
      } catch (const step::Error& error) {
        skip(instance, classes[instance.type], error.what());
      }
    }
  }

  /// What it says of itself goes before what its type says.
  std::string kind_of(const Entity& entity, const std::string& ifc_class) const {
    if (!ifc_class.starts_with("IfcPlate") && ifc_class != "IfcCovering") return "";
    const std::string own = own_kind(entity);
    return own.empty() ? properties_.kind_of_type(entity.id()) : own;
  }

  /// Where something clads, walls are looked at only if there are anchors without it: there may be thousands, and most
  /// are none.
  bool walls_may_hang() const {
    const auto any = [&](auto is) { return std::any_of(design_.elements.begin(), design_.elements.end(), is); };
    return rule_.panels.empty() && any([](const Element& e) { return e.is_anchor; }) &&
           !any([](const Element& e) { return e.is_cladding; });
  }

  /// Shapes of what is judged and of its parts, which show where it is; of the others every so many.
  void read_shapes() {
    std::unordered_set<std::uint64_t> judged;
    for (const Element& element : design_.elements)
      if (element.is_anchor || element.is_panel) judged.insert(element.instance);
    judged.insert(hosts_.begin(), hosts_.end());
    const bool walls_too = walls_may_hang();
    // Slabs, at whose edges anchors sit, tell which way these face.
    for (const Element& element : design_.elements)
      if (element.ifc_class.starts_with("IfcSlab") || (walls_too && is_wall(element))) judged.insert(element.instance);
    const auto counts = [&](std::uint64_t id) {
      for (int depth = 0; depth < 100; ++depth) {
        if (judged.contains(id)) return true;
        const auto up = tree_.whole.find(id);
        if (up == tree_.whole.end()) return false;
        id = up->second;
      }
      return false;
    };
    const std::size_t stride = rule_.all_shapes ? 1 : 1 + design_.elements.size() / kOtherShapes;
    ElementShapes shapes(model_, units_.length, units_.plane_angle, damage_);
    for (std::size_t i = 0; i < design_.elements.size(); ++i) {
      Element& element = design_.elements[i];
      if (i % stride == 0 || counts(element.instance)) shapes.read(model_.entity(element.instance), element);
    }
    shapes.tell_unread(design_);
  }

  /// What hangs at anchors and is called no panel.
  void find_hanging() {
    std::unordered_set<std::uint64_t> fillings;
    for_all(model_, "IFCRELFILLSELEMENT", damage_,
            [&](const Entity& relation) { fillings.insert(relation.reference("RelatedBuildingElement")); });
    ElementShapes shapes(model_, units_.length, units_.plane_angle, damage_);
    const auto read = [&](Element& element) { shapes.read(model_.entity(element.instance), element); };
    if (const std::set<const Element*> bare = bare_anchors(design_); !bare.empty()) {
      for (Element& element : design_.elements)
        if (is_wall(element) && !element.has_box) read(element);
      hang_walls(design_, rule_.facades, bare);
    }
    leave_out_fixing_plates(design_);
    tell_what_hangs(design_, read, [&](std::uint64_t id) { return fillings.contains(id); });
  }

  /// Whether the sides of panels are planes and rectangles, of those that have a shape of their own.
  void read_sides() {
    OuterSides sides(model_, units_.length, units_.plane_angle);
    for (Element& element : design_.elements) {
      if (!element.is_panel || !element.has_box) continue;
      SidesOfShape of_shape = sides.of(model_.entity(element.instance));
      element.sag = std::move(of_shape.sag), element.filled = std::move(of_shape.filled);
      element.rectangles = std::move(of_shape.rectangles);
    }
  }

  /// What has neither placement nor shape is nowhere; a part of something else may get by without, an anchor cannot.
  void refuse_unplaced() {
    std::erase_if(design_.elements, [&](const Element& element) {
      if (!element.is_anchor || element.has_box || !unplaced_.contains(element.instance)) return false;
      design_.skipped.push_back(element.ifc_class + " '" + element.name + "' (#" + std::to_string(element.instance) +
                                "): it has neither a placement nor a shape that can be read, so its place is unknown");
      return true;
    });
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
    element.type_name = properties_.type_name(entity.id());
    const auto storey = storey_index_.find(tree_.storey_above(model_, entity.id()));
    if (storey != storey_index_.end()) {
      element.storey = design_.storeys[storey->second].name;
      element.storey_guid = design_.storeys[storey->second].guid;
    }
    element.project_from_element = placement_of(entity);
    element.position = element.project_from_element.translation;
    if (choice_.needs_properties()) element.properties = properties_.of(element.instance);
    return element;
  }

  /// Which anchors the file itself ties to a panel, and to a wall or slab.
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
      for (const char* side : {"RelatingElement", "RelatedElement"})
        for (const std::uint64_t id : relation.references("RealizingElements"))
          tie(elements, id, relation.reference(side));
    });
    for_all(model_, "IFCRELCONNECTSELEMENTS", damage_, [&](const Entity& relation) {
      tie(elements, relation.reference("RelatingElement"), relation.reference("RelatedElement"));
      tie(elements, relation.reference("RelatedElement"), relation.reference("RelatingElement"));
    });
    for (Element& element : design_.elements)
      if (const auto whole = tree_.whole.find(element.instance); whole != tree_.whole.end())
        tie(elements, element.instance, whole->second);
  }

  /// The first that an anchor is tied to and that is neither panel nor anchor is its host.
  void tie(const std::unordered_map<std::uint64_t, Element*>& elements, std::uint64_t anchor, std::uint64_t host) {
    const auto one = elements.find(anchor), other = elements.find(host);
    if (one == elements.end() || other == elements.end() || !one->second->is_anchor || !one->second->host_guid.empty())
      return;
    if (other->second->is_anchor || other->second->is_panel) return;
    one->second->host_guid = other->second->guid;
    hosts_.insert(host);
  }

  void read_properties() {
    if (!choice_.needs_properties()) {
      std::unordered_set<std::uint64_t> judged;
      for (const Element& element : design_.elements)
        if (element.is_anchor || element.is_panel) judged.insert(element.instance);
      properties_.find_sets(judged);
      for (Element& element : design_.elements)
        if (element.is_anchor || element.is_panel) element.properties = properties_.of(element.instance);
    }
    inherit_tolerances(model_, tree_, units_.length, damage_, design_);
  }

  void read_site() {
    for_all(model_, "IFCSITE", damage_, [&](const Entity& site) {
      if (!design_.site_origin.allFinite()) design_.site_origin = placement_of(site).translation;
    });
  }

  void read_north() {
    for_all(model_, "IFCGEOMETRICREPRESENTATIONCONTEXT", damage_, [&](const Entity& context) {
      const auto north = context.optional_reference("TrueNorth");
      if (!north || std::isfinite(design_.true_north)) return;
      const Eigen::Vector3d direction = read_direction(model_, *north, context.id());
      if (direction.head<2>().norm() > 1e-6) design_.true_north = std::atan2(direction.x(), direction.y());
    });
  }

  Model model_;
  const AnchorRule& rule_;
  ElementChoice choice_;
  Damage damage_;
  Tree tree_;
  Properties properties_;
  Placements placements_;
  Units units_;
  Design design_;
  std::unordered_map<std::uint64_t, std::size_t> storey_index_;
  std::unordered_set<std::uint64_t> unplaced_;  // elements without ObjectPlacement
  std::unordered_set<std::uint64_t> hosts_;     // walls and slabs that anchors are fixed to
};

}  // namespace

ElementFacts facts_of(const Element& element) {
  return {element.ifc_class,   element.guid,      element.name,   element.tag,
          element.object_type, element.type_name, element.storey, &element.properties};
}

Design read_design(const step::File& file, const AnchorRule& rule) { return Reader(file, rule).read(); }

}  // namespace plumbline::ifc
