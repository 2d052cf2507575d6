// What left a design in name only: the element goes on under another GlobalId.
#pragma once

#include <set>
#include <tuple>

#include "artifacts/as_built_changes.hpp"

namespace plumbline::ifc {

/// The changes that say so of a GlobalId that was: left out, while another of the same kind, name and topic is there.
inline std::set<const AsBuiltChangeT*> former_guids(const AsBuiltChangesT& changes) {
  std::set<std::tuple<std::string, std::string, std::string>> there;
  for (const auto& change : changes.changes)
    if (change->change != ChangeKind::left_out) there.emplace(change->kind, change->id, change->topic);
  std::set<const AsBuiltChangeT*> former;
  for (const auto& change : changes.changes)
    if (change->change == ChangeKind::left_out && there.contains({change->kind, change->id, change->topic}))
      former.insert(change.get());
  return former;
}

}  // namespace plumbline::ifc
