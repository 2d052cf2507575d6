#include <map>
#include <stdexcept>
#include <string>

#include "loop/fit/facade.hpp"
#include "loop/state/floor_moves.hpp"

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

}  // namespace

void add_items(LoopStateT& state, const InstallationPlanT& plan) {
  std::map<std::string, LoopItemT*> known;
  for (const auto& item : state.items) known[item->kind + " " + item->id] = item.get();
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
