#include "building/ifc/design_properties.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "building/ifc/ifc_units.hpp"
#include "building/ifc/tolerance_source.hpp"

namespace plumbline::ifc {
namespace {

bool same_name(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

/// The instances in a value: one, a list, or an IFCPROPERTYSETDEFINITIONSET of them.
void collect(const step::Value& value, std::vector<std::uint64_t>& to) {
  if (value.kind == step::Kind::reference) to.push_back(value.id);
  for (const step::Value& item : value.items) collect(item, to);
}

}  // namespace

void Properties::read_types() {
  for_all(model_, "IFCRELDEFINESBYTYPE", damage_, [&](const Entity& relation) {
    const auto type = model_.file().find(relation.reference("RelatingType"));
    if (!type || model_.file().type_name(*type).empty()) return;
    const auto arguments = model_.file().arguments(*type);  // every IfcTypeObject: GlobalId, OwnerHistory, Name
    if (arguments.size() < 3 || arguments[2].kind != step::Kind::text) return;
    type_names_.try_emplace(type->id, arguments[2].text);
    for (const std::uint64_t id : relation.references("RelatedObjects")) types_.try_emplace(id, type->id);
  });
}

const std::string& Properties::type_name(std::uint64_t object) const {
  static const std::string none;
  const auto type = types_.find(object);
  return type == types_.end() ? none : type_names_.at(type->second);
}

std::string Properties::kind_of_type(std::uint64_t object) const {
  const auto type = types_.find(object);
  const auto instance = type == types_.end() ? std::nullopt : model_.file().find(type->second);
  if (!instance) return "";
  // Of all types of elements: behind ElementType, the ninth argument.
  constexpr std::size_t predefined_type = 9;
  const auto arguments = model_.file().arguments(*instance);
  if (arguments.size() <= predefined_type || arguments[predefined_type].kind != step::Kind::enumeration ||
      arguments[predefined_type].text == "NOTDEFINED")
    return "";
  return arguments[predefined_type].text;
}

void Properties::find_sets(const std::unordered_set<std::uint64_t>& objects) {
  for_all(model_, "IFCRELDEFINESBYPROPERTIES", damage_, [&](const Entity& relation) {
    std::vector<std::uint64_t> sets;
    collect(relation.value("RelatingPropertyDefinition"), sets);
    std::erase_if(sets, [&](std::uint64_t set) {
      return model_.keyword(set) != "IFCPROPERTYSET" && model_.keyword(set) != "IFCELEMENTQUANTITY";
    });
    for (const std::uint64_t id : relation.references("RelatedObjects"))
      if (objects.contains(id)) sets_[id].insert(sets_[id].end(), sets.begin(), sets.end());
  });
}

/// Quantities are no properties, and a tolerance among them is not read: it is listed by its name, so that it is told.
void Properties::add_quantities(const Entity& set, std::vector<Property>& to) const {
  const std::string set_name = set.text("Name");
  if (!is_like_tolerance_set(set_name)) return;
  for (const std::uint64_t id : set.references("Quantities")) {
    const auto arguments = model_.entity(id, set.id()).arguments();  // every IfcPhysicalQuantity begins with its name
    if (!arguments.empty())
      to.push_back({set_name, arguments[0].text, "", Property::nan, std::string(model_.keyword(id))});
  }
}

/// `before`: how many of `to` go before what this object itself says. Of two sets of one object that give a tolerance
/// differently both are listed: nobody knows which is meant.
void Properties::add(std::uint64_t set_id, std::size_t before, std::vector<Property>& to) {
  const Entity set = model_.entity(set_id);
  if (set.keyword() == "IFCELEMENTQUANTITY") return add_quantities(set, to);
  const std::string set_name = set.text("Name");
  const bool of_tolerances = is_like_tolerance_set(set_name);
  for (const std::uint64_t id : set.references("HasProperties")) {
    const std::string keyword(model_.keyword(id));
    if (!keyword.starts_with("IFCPROPERTY") && keyword != "IFCCOMPLEXPROPERTY") continue;
    const Entity entity = model_.entity(id, set_id);
    if (entity.arguments().empty()) continue;  // every IfcProperty begins with its name
    Property property{set_name, entity.arguments()[0].text, "", Property::nan, keyword};
    const auto same = [&](const Property& other) {
      return of_tolerances && is_like_tolerance_set(other.set)
                 ? bare_name(other.set) == bare_name(property.set) && same_name(other.name, property.name)
                 : same_name(other.set, property.set) && same_name(other.name, property.name);
    };
    const auto first_own = to.begin() + static_cast<std::ptrdiff_t>(before);
    if (std::any_of(to.begin(), of_tolerances ? first_own : to.end(), same)) continue;
    const bool valued = keyword == "IFCPROPERTYSINGLEVALUE" || keyword == "IFCPROPERTYBOUNDEDVALUE";
    const step::Value unit = valued ? entity.value("Unit") : step::Value{};
    own_unit_ = unit.kind == step::Kind::reference ? unit.id : 0;
    if (keyword == "IFCPROPERTYSINGLEVALUE") {
      if (!read_single(entity.value("NominalValue"), property)) continue;
    } else if (keyword == "IFCPROPERTYBOUNDEDVALUE") {
      Property bound;
      const auto length = [&] { return bound.measure.ends_with("LENGTHMEASURE") ? bound.number : Property::nan; };
      if (read_single(entity.value("UpperBoundValue"), bound)) property.upper = length(), property.text = bound.text;
      if (read_single(entity.value("LowerBoundValue"), bound)) {
        property.lower = length();
        property.text = bound.text + (property.text.empty() ? "" : " to " + property.text);
        // What has no length below has no tolerance at all.
        if (std::isnan(property.lower)) property.upper = Property::nan;
      }
      // IFC4 on; it is where the value is meant to be, and not the zero that the bounds are about.
      constexpr std::size_t set_point = 5;
      if (entity.arguments().size() > set_point && read_single(entity.arguments()[set_point], bound) &&
          !(std::abs(bound.number) < 1e-12))
        property.measure += " with a set point", property.text += " about " + bound.text;
    }
    const auto alike = std::find_if(to.begin() + static_cast<std::ptrdiff_t>(before), to.end(), same);
    if (alike != to.end() && alike->text == property.text && alike->measure == property.measure) continue;
    to.push_back(std::move(property));
  }
}

/// Text, number and type of a value; false if there is none.
bool Properties::read_single(const step::Value& value, Property& property) const {
  if (value.kind != step::Kind::typed || value.items.empty()) return false;
  const step::Value& item = value.items[0];
  property.measure = value.text, property.text = item.text;
  property.number = Property::nan;
  if (item.is_number()) {
    const bool length = value.text.ends_with("LENGTHMEASURE");
    property.number = item.number * (!length ? 1 : own_unit_ != 0 ? unit_factor(model_, own_unit_) : length_unit);
    char text[40];
    const auto end = std::to_chars(text, text + sizeof text, item.number);
    property.text.assign(text, end.ptr);
  }
  return true;
}

std::vector<Property> Properties::of(std::uint64_t element) {
  std::vector<Property> properties;
  std::size_t before = 0;
  const auto try_add = [&](std::uint64_t set) {
    try {
      add(set, before, properties);
    } catch (const step::Error& error) {
      auto& [count, reason] = damage_["IFCPROPERTYSET"];
      if (++count == 1) reason = error.what();
    }
  };
  if (const auto sets = sets_.find(element); sets != sets_.end())
    for (const std::uint64_t set : sets->second) try_add(set);
  before = properties.size();
  if (const auto type = types_.find(element); type != types_.end()) {
    const auto arguments = model_.file().arguments(*model_.file().find(type->second));
    // every IfcTypeObject: GlobalId, OwnerHistory, Name, Description, ApplicableOccurrence, HasPropertySets
    if (arguments.size() > 5)
      for (const step::Value& set : arguments[5].items)
        if (set.kind == step::Kind::reference && model_.keyword(set.id) == "IFCPROPERTYSET") try_add(set.id);
  }
  return properties;
}

}  // namespace plumbline::ifc
