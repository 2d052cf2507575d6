#include "building/ifc/inherited_tolerances.hpp"

#include <map>
#include <unordered_map>
#include <unordered_set>

#include "building/ifc/design_properties.hpp"
#include "building/ifc/tolerance_source.hpp"

namespace plumbline::ifc {
namespace {

/// "IfcBuildingStorey 'Floor 2'"
std::string name_of_holder(const Model& model, std::uint64_t id) {
  static const std::map<std::string, std::string, std::less<>> others = {{"IFCBUILDINGSTOREY", "IfcBuildingStorey"},
                                                                         {"IFCBUILDING", "IfcBuilding"},
                                                                         {"IFCSITE", "IfcSite"},
                                                                         {"IFCPROJECT", "IfcProject"},
                                                                         {"IFCGROUP", "IfcGroup"},
                                                                         {"IFCZONE", "IfcZone"},
                                                                         {"IFCSYSTEM", "IfcSystem"},
                                                                         {"IFCSPACE", "IfcSpace"}};
  const std::string keyword(model.keyword(id));
  const auto other = others.find(keyword);
  std::string name(other != others.end() ? other->second : element_class_name(model.schema(), keyword));
  if (name.empty()) name = keyword;
  const auto arguments = model.file().arguments(*model.file().find(id));  // IfcRoot: GlobalId, OwnerHistory, Name
  if (arguments.size() > 2 && arguments[2].kind == step::Kind::text && !arguments[2].text.empty())
    name += " '" + arguments[2].text + "'";
  return name;
}

bool is_judged(const Element& element) { return element.is_anchor || element.is_panel; }

}  // namespace

void inherit_tolerances(const Model& model, const Tree& tree, double length_unit, Damage& damage, Design& design) {
  std::unordered_set<std::uint64_t> holders;
  for (const Element& element : design.elements)
    if (is_judged(element))
      for (const std::uint64_t holder : tree.holders(element.instance)) holders.insert(holder);
  Properties properties(model, damage);
  properties.length_unit = length_unit;
  properties.find_sets(holders);
  std::unordered_map<std::uint64_t, std::vector<Property>> asked;
  for (const std::uint64_t holder : holders) {
    if (model.keyword(holder).empty()) continue;
    std::vector<Property> own = properties.of(holder);
    std::erase_if(own, [](const Property& property) { return !is_like_tolerance_set(property.set); });
    if (own.empty()) continue;
    for (Property& property : own) property.holder = name_of_holder(model, holder);
    asked.emplace(holder, std::move(own));
  }
  if (asked.empty()) return;
  for (Element& element : design.elements) {
    if (!is_judged(element)) continue;
    for (const std::uint64_t holder : tree.holders(element.instance))
      if (const auto found = asked.find(holder); found != asked.end())
        element.properties.insert(element.properties.end(), found->second.begin(), found->second.end());
  }
}

}  // namespace plumbline::ifc
