#include "building/ifc/design_relations.hpp"

#include <algorithm>

namespace plumbline::ifc {

Tree::Tree(const Model& model, Damage& damage) {
  const auto add = [&](std::unordered_map<std::uint64_t, std::uint64_t>& parents, const char* keyword,
                       const char* parent, const char* children) {
    for_all(model, keyword, damage, [&](const Entity& relation) {
      const std::uint64_t to = relation.reference(parent);
      const bool many = relation.value(children).kind == step::Kind::list;
      const auto ids = many ? relation.references(children) : std::vector<std::uint64_t>{relation.reference(children)};
      for (const std::uint64_t id : ids) parents.try_emplace(id, to);
    });
  };
  add(container, "IFCRELCONTAINEDINSPATIALSTRUCTURE", "RelatingStructure", "RelatedElements");
  add(whole, "IFCRELAGGREGATES", "RelatingObject", "RelatedObjects");
  add(whole, "IFCRELNESTS", "RelatingObject", "RelatedObjects");
  add(whole, "IFCRELVOIDSELEMENT", "RelatingBuildingElement", "RelatedOpeningElement");
  add(whole, "IFCRELPROJECTSELEMENT", "RelatingElement", "RelatedFeatureElement");
  add(whole, "IFCRELFILLSELEMENT", "RelatingOpeningElement", "RelatedBuildingElement");
  for_all(model, "IFCRELASSIGNSTOGROUP", damage, [&](const Entity& relation) {
    const std::uint64_t group = relation.reference("RelatingGroup");
    for (const std::uint64_t id : relation.references("RelatedObjects")) groups[id].push_back(group);
  });
}

std::vector<std::uint64_t> Tree::holders(std::uint64_t id) const {
  std::vector<std::uint64_t> all;
  const auto take = [&](std::uint64_t holder) {
    if (holder && std::find(all.begin(), all.end(), holder) == all.end()) all.push_back(holder);
  };
  const auto take_of = [&](std::uint64_t below) {
    take(parent(below));
    // A part of a whole may be contained as well.
    if (const auto found = whole.find(below); found != whole.end()) take(found->second);
    if (const auto found = groups.find(below); found != groups.end())
      for (const std::uint64_t group : found->second) take(group);
  };
  take_of(id);
  for (std::size_t i = 0; i < all.size(); ++i) take_of(all[i]);
  return all;
}

std::uint64_t Tree::parent(std::uint64_t id) const {
  if (const auto found = container.find(id); found != container.end()) return found->second;
  const auto found = whole.find(id);
  return found == whole.end() ? 0 : found->second;
}

std::uint64_t Tree::storey_above(const Model& model, std::uint64_t id) const {
  for (int depth = 0; id && depth < 100; ++depth) {
    id = parent(id);
    if (model.keyword(id) == "IFCBUILDINGSTOREY") return id;
  }
  return 0;
}

}  // namespace plumbline::ifc
