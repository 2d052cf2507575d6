#include "building/ifc/design_relations.hpp"

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
