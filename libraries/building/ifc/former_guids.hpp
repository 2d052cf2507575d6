// What left a design in name only: the element goes on under another GlobalId.
#pragma once

#include <map>
#include <set>
#include <string>
#include <tuple>

#include "artifacts/as_built_changes.hpp"

namespace plumbline::ifc {

/// The changes that say so of a GlobalId that was: left out, while one other of the same kind, name and topic goes on.
/// One that is new is no continuation (an anchor of that name elsewhere), and of several nobody knows which.
inline std::set<const AsBuiltChangeT*> former_guids(const AsBuiltChangesT& changes) {
  using Key = std::tuple<std::string, std::string, std::string>;
  std::map<Key, int> going_on, added;
  for (const auto& change : changes.changes)
    if (change->change != ChangeKind::left_out)
      ++(change->change == ChangeKind::added ? added : going_on)[{change->kind, change->id, change->topic}];
  std::set<const AsBuiltChangeT*> former;
  for (const auto& change : changes.changes) {
    const Key key{change->kind, change->id, change->topic};
    const auto found = going_on.find(key);
    if (change->change == ChangeKind::left_out && found != going_on.end() && found->second == 1 && !added.contains(key))
      former.insert(change.get());
  }
  return former;
}

}  // namespace plumbline::ifc
