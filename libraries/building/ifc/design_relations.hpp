// What holds the elements of a design together: relations, read one at a time so that a damaged one costs itself only.
#pragma once

#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "building/ifc/ifc_model.hpp"

namespace plumbline::ifc {

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
  std::unordered_map<std::uint64_t, std::uint64_t> container, whole;
  std::unordered_map<std::uint64_t, std::vector<std::uint64_t>> groups;  ///< IfcRelAssignsToGroup

  Tree(const Model& model, Damage& damage);

  std::uint64_t parent(std::uint64_t id) const;
  /// Whatever has an object below it, the nearest first: wholes, assemblies, storey, building, site and project, and
  /// the groups that any of these or itself is in.
  std::vector<std::uint64_t> holders(std::uint64_t id) const;
  /// The nearest storey above; 0 if there is none. Longer chains than 100 are cycles.
  std::uint64_t storey_above(const Model& model, std::uint64_t id) const;
};

}  // namespace plumbline::ifc
