#include "building/ifc/design.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <unordered_map>
#include <unordered_set>

#include "building/ifc/design_map.hpp"
#include "building/ifc/design_properties.hpp"
#include "building/ifc/ifc_extent.hpp"
#include "building/ifc/ifc_model.hpp"
#include "building/ifc/ifc_placement.hpp"
#include "building/ifc/ifc_units.hpp"
#include "building/ifc/what_hangs.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::ifc {
namespace {

/// Slack of "the placement lies within the shape": bim practice puts origins on surfaces, and surfaces are rounded.
constexpr double kPlacementSlack = 0.005;
/// GlobalId, OwnerHistory, Name, Description, ObjectType, ObjectPlacement, Representation.
constexpr std::size_t kArgumentsOfProduct = 7;
/// So many of the elements that nothing is judged by have their shape read: enough to tell where the building stands.
constexpr std::size_t kOtherShapes = 100;

/// Its own kind, behind Tag in every schema; IFC2X3 has none for plates. Empty where it says nothing.
std::string own_kind(const Entity& entity) {
  constexpr std::size_t predefined_type = 8;
  if (entity.arguments().size() <= predefined_type) return "";
  const step::Value& value = entity.arguments()[predefined_type];
  return value.kind == step::Kind::enumeration && value.text != "NOTDEFINED" ? value.text : "";
}

bool clads(const std::string& ifc_class, const std::string& kind) {
  return ifc_class == "IfcCurtainWall" || (ifc_class == "IfcCovering" && kind == "CLADDING") ||
         (ifc_class.starts_with("IfcPlate") && kind == "CURTAIN_PANEL");
}

/// Walls too, where they hang before their anchors (wall_panels.cpp).
bool may_be_panel(const std::string& ifc_class, const std::string& kind) {
  const bool plate = ifc_class == "IfcPlate" || ifc_class == "IfcPlateStandardCase";
  return clads(ifc_class, kind) || (plate && !is_fixing_plate(kind));
}

class Reader {
 public:
  Reader(const step::File& file, const AnchorRule& rule)
      : model_(file),
        rule_(rule),
        names_(rule.names.begin(), rule.names.end()),
        guids_(rule.guids.begin(), rule.guids.end()),
        tree_(model_, damage_),
        properties_(model_, damage_),
        placements_(model_) {
    for (const std::string& text : rule.selections) selections_.emplace_back(text);
    for (const std::string& text : rule.panels)
      if (text != "none") panel_selections_.emplace_back(text);
    selecting_.resize(selections_.size()), selecting_panels_.resize(panel_selections_.size());
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
    place_aggregates();
    refuse_unplaced();
    if (rule_.panels.empty()) find_hanging();
    read_properties();
    read_site();
    read_map_conversion(model_, damage_, design_);
    design_.grid = read_grid(model_, placements_, units_.length, design_.warnings);
    read_north();
    tell_damage();
    tell_idle();
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
    std::regex pattern;
    try {
      pattern = std::regex(rule_.pattern);
    } catch (const std::regex_error& error) {
      throw step::Error("anchor pattern '" + rule_.pattern +
                        "' is no regular expression (ECMAScript): " + error.what());
    }
    std::vector<std::string_view> classes;  // by step::Instance::type
    for (const std::string& keyword : model_.file().type_names())
      classes.push_back(keyword == "IFCPROXY" ? "IfcProxy" : element_class_name(model_.schema(), keyword));
    const step::Instances instances = model_.file().instances();
    if (needs_properties()) {
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
        element.is_anchor = matches(element, pattern);
        // IfcProxy is no IfcElement, but old exporters write anchors as such.
        if (element.ifc_class == "IfcProxy" && !element.is_anchor) continue;
        const std::string kind = kind_of(entity, element.ifc_class);
        element.is_panel = is_panel(element, kind) && !element.is_anchor;
        element.is_cladding = element.is_panel && (!rule_.panels.empty() || clads(element.ifc_class, kind));
        if (!entity.optional_reference("ObjectPlacement")) unplaced_.insert(element.instance);
        design_.elements.push_back(std::move(element));
      } catch (const step::Error& error) {
        skip(instance, classes[instance.type], error.what());
      }
    }
  }

  bool needs_properties() const {
    const auto needs = [](const Selection& s) { return s.needs_properties(); };
    return std::any_of(selections_.begin(), selections_.end(), needs) ||
           std::any_of(panel_selections_.begin(), panel_selections_.end(), needs);
  }

  /// What it says of itself goes before what its type says.
  std::string kind_of(const Entity& entity, const std::string& ifc_class) const {
    if (!ifc_class.starts_with("IfcPlate") && ifc_class != "IfcCovering") return "";
    const std::string own = own_kind(entity);
    return own.empty() ? properties_.kind_of_type(entity.id()) : own;
  }

  /// Those of the user alone, if he names any.
  bool is_panel(const Element& element, const std::string& kind) {
    if (rule_.panels.empty()) return may_be_panel(element.ifc_class, kind);
    bool selected = false;
    for (std::size_t i = 0; i < panel_selections_.size(); ++i)
      if (panel_selections_[i].matches(facts_of(element))) selected = selecting_panels_[i] = true;
    return selected;
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
    Extents extents(model_, units_.plane_angle);
    for (std::size_t i = 0; i < design_.elements.size(); ++i) {
      Element& element = design_.elements[i];
      if (i % stride == 0 || counts(element.instance)) read_shape(model_.entity(element.instance), extents, element);
    }
    for (const auto& [kind, unread] : unread_) {
      const auto& [count, first] = unread;
      design_.warnings.push_back((count == 1 ? first + " keeps the origin of its placement"
                                             : std::to_string(count) + " elements, such as " + first +
                                                   ", keep the origin of their placement") +
                                 " as reference point: " + kind);
    }
  }

  /// What hangs at anchors and is called no panel.
  void find_hanging() {
    std::unordered_set<std::uint64_t> fillings;
    for_all(model_, "IFCRELFILLSELEMENT", damage_,
            [&](const Entity& relation) { fillings.insert(relation.reference("RelatedBuildingElement")); });
    Extents extents(model_, units_.plane_angle);
    const auto read = [&](Element& element) { read_shape(model_.entity(element.instance), extents, element); };
    if (const std::set<const Element*> bare = bare_anchors(design_); !bare.empty()) {
      for (Element& element : design_.elements)
        if (is_wall(element) && !element.has_box) read(element);
      hang_walls(design_, rule_.facades, bare);
    }
    leave_out_fixing_plates(design_);
    tell_what_hangs(design_, read, [&](std::uint64_t id) { return fillings.contains(id); });
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

  /// What was named as an anchor or a panel and is nothing.
  void tell_idle() {
    const auto idle = [&](const std::string& asked, const char* by) {
      design_.not_applied.push_back({asked, by, "it selects nothing in " + design_.file_name});
    };
    for (std::size_t i = 0; i < selections_.size(); ++i)
      if (!selecting_[i]) idle(selections_[i].text(), "anchor_selection");
    for (std::size_t i = 0; i < panel_selections_.size(); ++i)
      if (!selecting_panels_[i]) idle(panel_selections_[i].text(), "panel_selection");
    std::unordered_set<std::string> guids;
    for (const Element& element : design_.elements) guids.insert(element.guid);
    for (const std::string& guid : rule_.guids)
      if (!guids.contains(guid)) idle(guid, "anchor_guids");
    for (const NotApplied& request : design_.not_applied)
      design_.warnings.push_back(request.by + " '" + request.asked + "': " + request.reason);
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
    if (needs_properties()) element.properties = properties_.of(element.instance);
    return element;
  }

  bool matches(const Element& element, const std::regex& pattern) const {
    if (guids_.contains(element.guid)) return true;
    // What an earlier campaign put beside an anchor bears its name and is none.
    if ((element.object_type == "AsBuiltAnchor" || element.object_type == "AsBuiltPanel") &&
        element.ifc_class == "IfcBuildingElementProxy")
      return false;
    bool selected = false;  // each is asked, to know those that select nothing
    for (std::size_t i = 0; i < selections_.size(); ++i)
      if (selections_[i].matches(facts_of(element))) selected = selecting_[i] = true;
    if (selected) return true;
    if (std::find(rule_.classes.begin(), rule_.classes.end(), element.ifc_class) != rule_.classes.end()) return true;
    for (const std::string* text : {&element.name, &element.tag, &element.guid})
      if (!text->empty() && names_.contains(*text)) return true;
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
      auto& [count, first] = unread_[reason.what()];
      if (++count == 1)
        first = element.ifc_class + " '" + element.name + "' (#" + std::to_string(element.instance) + ")";
      return;
    } catch (const step::Error& error) {  // a dangling reference, an argument of another kind
      auto& [count, first] = damage_["IFCPRODUCTDEFINITIONSHAPE, whose elements keep the origin of their placement,"];
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
    if (needs_properties()) return;
    std::unordered_set<std::uint64_t> judged;
    for (const Element& element : design_.elements)
      if (element.is_anchor || element.is_panel) judged.insert(element.instance);
    properties_.find_sets(judged);
    for (Element& element : design_.elements)
      if (element.is_anchor || element.is_panel) element.properties = properties_.of(element.instance);
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
  std::unordered_set<std::string> names_, guids_;
  std::vector<Selection> selections_, panel_selections_;
  mutable std::vector<bool> selecting_, selecting_panels_;  // those of them that select something
  Damage damage_;
  Tree tree_;
  Properties properties_;
  Placements placements_;
  Units units_;
  Design design_;
  std::unordered_map<std::uint64_t, std::size_t> storey_index_;
  std::unordered_set<std::uint64_t> unplaced_;  // elements without ObjectPlacement
  std::unordered_set<std::uint64_t> hosts_;     // walls and slabs that anchors are fixed to
  std::map<std::string, std::pair<int, std::string>> unread_;
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

ElementFacts facts_of(const Element& element) {
  return {element.ifc_class,   element.guid,      element.name,   element.tag,
          element.object_type, element.type_name, element.storey, &element.properties};
}

Design read_design(const step::File& file, const AnchorRule& rule) { return Reader(file, rule).read(); }

}  // namespace plumbline::ifc
