#include "building/ifc/check.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "building/ifc/ifc_guid.hpp"
#include "building/ifc/ifc_model.hpp"

namespace plumbline::ifc {
namespace {

using step::Instance;
using step::Kind;
using step::Value;

constexpr std::size_t kMostOfOneRule = 50;

class Checker {
 public:
  Checker(const step::File& file, std::uint64_t first) : file_(file), model_(file), first_(first) {}

  std::vector<Violation> check() {
    whole_file();
    roots_and_references();
    property_sets();
    properties();
    containment();
    placements();
    shapes();
    relations();
    return std::move(found_);
  }

 private:
  void tell(const std::string& rule, std::uint64_t instance, const std::string& words) {
    if (++told_[rule] <= kMostOfOneRule) found_.push_back({rule, instance, words});
  }
  bool counts(std::uint64_t id) const { return id >= first_; }

  /// Calls `use` with the arguments of every instance of a keyword; unreadable ones are violations themselves.
  void each(const char* keyword, const std::function<void(const Instance&, const std::vector<Value>&)>& use) {
    for (const std::uint32_t index : file_.of_type(keyword)) {
      const Instance instance = file_.instances()[index];
      try {
        use(instance, file_.arguments(instance));
      } catch (const step::Error& error) {
        if (counts(instance.id)) tell("Part 21 syntax", instance.id, error.what());
      }
    }
  }
  static std::vector<std::uint64_t> references(const Value& value) {
    std::vector<std::uint64_t> ids;
    if (value.kind == Kind::reference) ids.push_back(value.id);
    for (const Value& item : value.items)
      if (item.kind == Kind::reference) ids.push_back(item.id);
    return ids;
  }
  static const Value& at(const std::vector<Value>& arguments, std::size_t i) {
    static const Value none;
    return i < arguments.size() ? arguments[i] : none;
  }
  std::string label(std::uint64_t id) const { return "#" + std::to_string(id) + " " + std::string(model_.keyword(id)); }

  void whole_file() {
    if (file_.schemas().size() != 1)
      tell("HED001 one schema", 0, std::to_string(file_.schemas().size()) + " names in FILE_SCHEMA, expected one");
    const std::size_t projects = file_.of_type("IFCPROJECT").size();
    if (projects != 1) tell("PJS001 one project", 0, std::to_string(projects) + " IfcProject, expected one");
    std::map<std::string, std::uint64_t> names;
    each("IFCPROPERTYENUMERATION", [&](const Instance& instance, const std::vector<Value>& a) {
      const auto [other, added] = names.emplace(at(a, 0).text, instance.id);
      if (!added && counts(instance.id))
        tell("IfcPropertyEnumeration.UR1", instance.id,
             "the name '" + at(a, 0).text + "' is that of #" + std::to_string(other->second) +
                 " too, expected one of a name");
    });
    std::set<std::string> applications;
    each("IFCAPPLICATION", [&](const Instance& instance, const std::vector<Value>& a) {
      if (!applications.insert(at(a, 3).text).second && counts(instance.id))
        tell("IfcApplication.UR1", instance.id, "the identifier '" + at(a, 3).text + "' occurs twice");
    });
  }

  void visit_references(const Instance& instance, const Value& value) {
    if (value.kind == Kind::reference && !file_.find(value.id))
      tell("references", instance.id, "refers to #" + std::to_string(value.id) + ", which is not in the file");
    for (const Value& item : value.items) visit_references(instance, item);
  }

  /// GlobalIds of all roots, and everything that the checked instances refer to.
  void roots_and_references() {
    std::unordered_map<std::string, std::uint64_t> guids;
    for (const Instance& instance : file_.instances()) {
      const std::string& keyword = file_.type_name(instance);
      const auto layout = find_layout(model_.schema(), keyword);
      const bool root = (layout && layout->attributes.starts_with("GlobalId ")) || keyword.starts_with("IFCREL") ||
                        keyword == "IFCGROUP" || keyword == "IFCANNOTATION" || keyword == "IFCBUILDINGELEMENTPROXY";
      if (!root && !counts(instance.id)) continue;
      std::vector<Value> arguments;
      try {
        for (const auto& record : file_.records(instance))
          arguments.insert(arguments.end(), record.arguments.begin(), record.arguments.end());
      } catch (const step::Error& error) {
        if (counts(instance.id)) tell("Part 21 syntax", instance.id, error.what());
        continue;
      }
      if (root && at(arguments, 0).kind == Kind::text) {
        const std::string& guid = arguments[0].text;
        if (counts(instance.id) && !uuid_from_ifc_guid(guid))
          tell("PJS003 GlobalId", instance.id,
               "'" + guid + "' is no GlobalId: 22 characters of 0-9A-Za-z_$, the first 0 to 3");
        const auto [other, added] = guids.emplace(guid, instance.id);
        if (!added && counts(instance.id))
          tell("IfcRoot.UR1", instance.id, "has the GlobalId of #" + std::to_string(other->second) + ", " + guid);
      }
      if (!counts(instance.id)) continue;
      for (const Value& value : arguments) visit_references(instance, value);
    }
  }

  void property_sets() {
    const std::set<std::string> standard = {"Pset_Tolerance", "Pset_Uncertainty"};
    std::set<std::pair<std::uint64_t, std::string>> sets;
    each("IFCRELDEFINESBYPROPERTIES", [&](const Instance& instance, const std::vector<Value>& a) {
      const auto objects = references(at(a, 4));
      if (objects.empty() && counts(instance.id))
        tell("IfcRelDefines.RelatedObjects", instance.id, "relates no object, expected at least one");
      for (const std::uint64_t set : references(at(a, 5))) {
        if (model_.keyword(set) != "IFCPROPERTYSET") continue;
        const std::string name = model_.entity(set).text("Name");
        for (const std::uint64_t object : objects) {
          const bool is_new = sets.insert({object, name}).second;
          if (!is_new && (counts(instance.id) || counts(set)))
            tell("UniquePropertySetNames", object, label(object) + " has two property sets '" + name + "'");
          if (model_.keyword(object).starts_with("IFCREL"))
            tell("PSE002 property sets on objects", set, "stands on a relation, expected an object");
        }
      }
    });
    each("IFCPROPERTYSET", [&](const Instance& instance, const std::vector<Value>& a) {
      if (!counts(instance.id)) return;
      const std::string& name = at(a, 2).text;
      if (name.empty()) tell("IfcPropertySet.ExistsName", instance.id, "has no name");
      const bool reserved = name.size() >= 4 && (name[0] == 'P' || name[0] == 'p') && name.substr(1, 3) == "set";
      if (reserved && !(model_.schema() == Schema::ifc4x3 && standard.contains(name)))
        tell("PSE001 reserved names", instance.id, "is called '" + name + "'; names with Pset are the standard's");
      std::set<std::string> names;
      const auto ids = references(at(a, 4));
      if (ids.empty()) tell("IfcPropertySet.HasProperties", instance.id, "has no property, expected at least one");
      for (const std::uint64_t id : ids)
        if (const auto property = file_.find(id))
          if (!names.insert(at(file_.arguments(*property), 0).text).second)
            tell("UniquePropertyNames", instance.id,
                 "has two properties '" + at(file_.arguments(*property), 0).text + "'");
    });
  }

  void properties() {
    each("IFCPROPERTYLISTVALUE", [&](const Instance& instance, const std::vector<Value>& a) {
      if (!counts(instance.id)) return;
      for (const Value& value : at(a, 2).items)
        if (value.text != at(a, 2).items[0].text)
          tell("IfcPropertyListValue.WR31", instance.id, "mixes " + at(a, 2).items[0].text + " and " + value.text);
    });
    each("IFCPROPERTYENUMERATEDVALUE", [&](const Instance& instance, const std::vector<Value>& a) {
      const auto enumeration = at(a, 3).kind == Kind::reference ? file_.find(at(a, 3).id) : std::nullopt;
      if (!counts(instance.id) || !enumeration) return;
      std::set<std::string> allowed;
      const std::vector<Value> defined = file_.arguments(*enumeration);
      for (const Value& value : at(defined, 1).items)
        if (!value.items.empty()) allowed.insert(value.items[0].text);
      for (const Value& value : at(a, 2).items)
        if (!value.items.empty() && !allowed.contains(value.items[0].text))
          tell("IfcPropertyEnumeratedValue.WR21", instance.id,
               "'" + value.items[0].text + "' is not in its enumeration");
    });
    each("IFCPROPERTYTABLEVALUE", [&](const Instance& instance, const std::vector<Value>& a) {
      if (counts(instance.id) && at(a, 2).items.size() != at(a, 3).items.size())
        tell("IfcPropertyTableValue.WR21", instance.id,
             "defines " + std::to_string(at(a, 2).items.size()) + " and " + std::to_string(at(a, 3).items.size()) +
                 " values, expected as many");
    });
    each("IFCPROPERTYBOUNDEDVALUE", [&](const Instance& instance, const std::vector<Value>& a) {
      if (!counts(instance.id)) return;
      const auto number = [&](std::size_t i) {
        return at(a, i).items.empty() ? std::nan("") : at(a, i).items[0].number;
      };
      if (number(2) < number(3))
        tell("IfcPropertyBoundedValue", instance.id, "its upper bound is below its lower bound");
      if (at(a, 2).text != at(a, 3).text)
        tell("IfcPropertyBoundedValue.WR21", instance.id, "mixes " + at(a, 2).text + " and " + at(a, 3).text);
    });
    each("IFCOWNERHISTORY", [&](const Instance& instance, const std::vector<Value>& a) {
      const std::string& action = at(a, 3).text;
      if (counts(instance.id) && !action.empty() && action != "NOCHANGE" && action != "NOTDEFINED" &&
          !at(a, 4).is_number())
        tell("IfcOwnerHistory.CorrectChangeAction", instance.id, action + " without a date of modification");
    });
    each("IFCPERSON", [&](const Instance& instance, const std::vector<Value>& a) {
      if (counts(instance.id) && at(a, 0).text.empty() && at(a, 1).text.empty() && at(a, 2).text.empty())
        tell("IfcPerson.IdentifiablePerson", instance.id, "has neither identification nor name");
    });
  }

  bool spatial(std::uint64_t id) const {
    const std::string_view keyword = model_.keyword(id);
    for (const char* known :
         {"IFCSITE", "IFCBUILDING", "IFCBUILDINGSTOREY", "IFCSPACE", "IFCFACILITY", "IFCFACILITYPART", "IFCBRIDGE",
          "IFCBRIDGEPART", "IFCROAD", "IFCRAILWAY", "IFCEXTERNALSPATIALELEMENT", "IFCSPATIALZONE"})
      if (keyword == known) return true;
    return keyword.starts_with("IFCMARINE") || keyword.ends_with("PART");
  }

  void containment() {
    std::unordered_map<std::uint64_t, std::uint64_t> container, whole;
    each("IFCRELCONTAINEDINSPATIALSTRUCTURE", [&](const Instance& instance, const std::vector<Value>& a) {
      if (counts(instance.id) && !spatial(at(a, 5).id))
        tell("SPS001 containment", instance.id, "contains in " + label(at(a, 5).id) + ", expected a spatial element");
      for (const std::uint64_t id : references(at(a, 4))) {
        const auto [other, added] = container.emplace(id, at(a, 5).id);
        if (!added && counts(instance.id))
          tell("IfcElement.ContainedInStructure", id,
               label(id) + " is contained in #" + std::to_string(other->second) + " and in #" +
                   std::to_string(at(a, 5).id) + ", expected one");
      }
    });
    each("IFCRELAGGREGATES", [&](const Instance& instance, const std::vector<Value>& a) {
      for (const std::uint64_t id : references(at(a, 5))) {
        whole.emplace(id, at(a, 4).id);
        if (const auto in = container.find(id); in != container.end() && (counts(id) || counts(instance.id)))
          tell("SPS007 parts are not contained", id,
               label(id) + " is part of " + label(at(a, 4).id) + " and contained as well");
        if (id == at(a, 4).id) tell("IfcRelAggregates.NoSelfReference", instance.id, "relates an object to itself");
      }
    });
    for (const char* keyword : {"IFCANNOTATION", "IFCBUILDINGELEMENTPROXY", "IFCGRID"})
      each(keyword, [&](const Instance& instance, const std::vector<Value>& a) {
        if (!counts(instance.id)) return;
        if (!container.contains(instance.id) && !whole.contains(instance.id))
          tell("SPS002 products are contained", instance.id, "is in no spatial element");
        relative_placement(instance, at(a, 5), container);
      });
  }

  /// OJP001: what is contained is placed relative to what contains it, or to nothing.
  void relative_placement(const Instance& instance, const Value& placement,
                          const std::unordered_map<std::uint64_t, std::uint64_t>& container) {
    const auto in = container.find(instance.id);
    if (in == container.end() || placement.kind != Kind::reference) return;
    const auto placed = file_.find(placement.id), container_instance = file_.find(in->second);
    if (!placed || !container_instance) return;  // told as a dangling reference
    const Value own = at(file_.arguments(*placed), 0), of_container = at(file_.arguments(*container_instance), 5);
    if (own.kind == Kind::reference && of_container.kind == Kind::reference && own.id != of_container.id)
      tell("OJP001 relative placement", instance.id,
           "is placed relative to #" + std::to_string(own.id) + ", its container to #" +
               std::to_string(of_container.id));
  }

  void placements() {
    each("IFCLOCALPLACEMENT", [&](const Instance& instance, const std::vector<Value>& a) {
      if (!counts(instance.id)) return;
      std::unordered_set<std::uint64_t> seen{instance.id};
      for (Value up = at(a, 0); up.kind == Kind::reference;) {
        if (!seen.insert(up.id).second) {
          tell("IfcLocalPlacement", instance.id, "its chain of placements is a cycle");
          break;
        }
        const auto parent = file_.find(up.id);
        up = parent ? at(file_.arguments(*parent), 0) : Value();
      }
    });
    each("IFCDIRECTION", [&](const Instance& instance, const std::vector<Value>& a) {
      if (!counts(instance.id)) return;
      double squares = 0;
      for (const Value& value : at(a, 0).items) squares += value.number * value.number;
      if (!(squares > 0)) tell("IfcDirection.MagnitudeGreaterZero", instance.id, "has no length");
    });
    each("IFCAXIS2PLACEMENT3D", [&](const Instance& instance, const std::vector<Value>& a) {
      if (!counts(instance.id)) return;
      if ((at(a, 1).kind == Kind::reference) != (at(a, 2).kind == Kind::reference))
        tell("IfcAxis2Placement3D.AxisAndRefDirProvision", instance.id,
             "has one of Axis and RefDirection, expected both or none");
    });
  }

  void shapes() {
    each("IFCSHAPEREPRESENTATION", [&](const Instance& instance, const std::vector<Value>& a) {
      if (!counts(instance.id)) return;
      const std::string &identifier = at(a, 1).text, &type = at(a, 2).text;
      if (references(at(a, 3)).empty())
        tell("IfcRepresentation.Items", instance.id, "has no item, expected at least one");
      if (identifier.empty() || type.empty())
        tell("IfcShapeRepresentation.HasRepresentationType", instance.id, "has no identifier or no type");
      for (const std::uint64_t id : references(at(a, 3))) {
        const std::string_view keyword = model_.keyword(id);
        const bool fits = type == "SweptSolid"     ? keyword.find("SOLID") != std::string_view::npos
                          : type == "GeometricSet" ? keyword.starts_with("IFCGEOMETRIC")
                                                   : true;
        if (!fits)
          tell("IfcShapeRepresentation.CorrectItemsForType", instance.id,
               "is a '" + type + "' and has a " + std::string(keyword));
      }
    });
    each("IFCEXTRUDEDAREASOLID", [&](const Instance& instance, const std::vector<Value>& a) {
      if (counts(instance.id) && !(at(a, 3).number > 0))
        tell("IfcPositiveLengthMeasure.WR1", instance.id,
             "has a depth of " + std::to_string(at(a, 3).number) + ", expected above 0");
    });
    std::unordered_map<std::uint64_t, std::uint64_t> styled;
    each("IFCSTYLEDITEM", [&](const Instance& instance, const std::vector<Value>& a) {
      if (at(a, 0).kind != Kind::reference) return;
      if (!styled.emplace(at(a, 0).id, instance.id).second && counts(instance.id))
        tell("IfcRepresentationItem.StyledByItem", instance.id, label(at(a, 0).id) + " is styled twice");
    });
  }

  void relations() {
    for (const char* keyword : {"IFCRELASSIGNSTOPRODUCT", "IFCRELASSIGNSTOGROUP"})
      each(keyword, [&](const Instance& instance, const std::vector<Value>& a) {
        if (!counts(instance.id)) return;
        for (const std::uint64_t id : references(at(a, 4)))
          if (id == at(a, 6).id) tell("IfcRelAssigns.NoSelfReference", instance.id, "assigns an object to itself");
        if (references(at(a, 4)).empty()) tell("IfcRelAssigns.RelatedObjects", instance.id, "relates no object");
      });
  }

  const step::File& file_;
  Model model_;
  std::uint64_t first_;
  std::vector<Violation> found_;
  std::map<std::string, std::size_t> told_;
};

}  // namespace

std::vector<Violation> check_ifc(const step::File& file, std::uint64_t first) { return Checker(file, first).check(); }

}  // namespace plumbline::ifc
