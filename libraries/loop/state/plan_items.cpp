#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/text/words.hpp"
#include "loop/fit/facade.hpp"
#include "loop/state/floor_moves.hpp"
#include "loop/state/machine.hpp"

namespace plumbline::loop {
namespace {

/// A name that means another element in a revised design carries over nothing that was done to the first.
void take_guid(LoopItemT& item, const std::string& guid) {
  if (!item.guid.empty() && !guid.empty() && item.guid != guid)
    throw std::runtime_error(item.kind + " " + item.id + " is GlobalId " + guid + " in this plan and was " + item.guid +
                             " in the state: its name stands for another element now; give the element its old "
                             "name or GlobalId back, or begin with a new state");
  if (!guid.empty()) item.guid = guid;
}

using Items = std::map<std::string, LoopItemT*>;  ///< by kind and name

/// What was done to an element is known under its old name alone: under a new one it would be done again.
void refuse_new_names(const Items& known, const InstallationPlanT& plan) {
  std::map<std::string, const LoopItemT*> gone;  // by kind and GlobalId, of names that this plan does not have
  for (const auto& [name, item] : known)
    if (!item->guid.empty()) gone[item->kind + " " + item->guid] = item;
  const auto keep = [&](const std::string& kind, const std::string& id) {
    if (const auto found = known.find(kind + " " + id); found != known.end())
      gone.erase(kind + " " + found->second->guid);
  };
  for (const auto& bracket : plan.brackets) keep("bracket", bracket->id);
  for (const auto& panel : plan.panels) keep("panel", panel->id);
  std::vector<std::string> renamed;
  const auto look_at = [&](const std::string& kind, const std::string& id, const std::string& guid) {
    if (known.count(kind + " " + id) > 0) return;
    if (const auto old = gone.find(kind + " " + guid); old != gone.end())
      renamed.push_back(kind + " " + id + " was " + old->second->id + " (" + name_of(old->second->status) + ")");
  };
  for (const auto& bracket : plan.brackets) look_at("bracket", bracket->id, bracket->guid);
  for (const auto& panel : plan.panels) look_at("panel", panel->id, panel->guid);
  if (renamed.empty()) return;
  throw std::runtime_error(
      "elements have the GlobalIds that they had in the round before, and other names: " + text::join(renamed, 4) +
      "; what was set and hung is known by the old names. Give the design (and the plates) their old names back, or "
      "begin with a new state");
}

}  // namespace

void add_items(LoopStateT& state, const InstallationPlanT& plan) {
  Items known;
  for (const auto& item : state.items) known[item->kind + " " + item->id] = item.get();
  refuse_new_names(known, plan);
  const auto add = [&](const std::string& kind, const std::string& id, const std::string& guid, int floor) {
    if (const auto found = known.find(kind + " " + id); found != known.end()) {
      take_guid(*found->second, guid);
      return;
    }
    auto item = std::make_unique<LoopItemT>();
    item->id = id, item->kind = kind, item->floor = floor, item->guid = guid;
    item->setting.setZero(), item->pending.setZero(), item->expected.setConstant(kUnknown);
    known[kind + " " + id] = item.get();
    state.items.push_back(std::move(item));
  };
  for (const auto& bracket : plan.brackets) add("bracket", bracket->id, bracket->guid, bracket->floor);
  for (const auto& panel : plan.panels) add("panel", panel->id, panel->guid, panel->floor);
}

}  // namespace plumbline::loop
