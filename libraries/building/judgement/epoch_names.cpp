// What a campaign before knew, under the names that the design of this one has for it.
#include <map>
#include <set>
#include <utility>

#include "building/judgement/epochs.hpp"

namespace plumbline::judgement {
namespace {

/// An anchor that is designed further away is another one of its name [m].
constexpr double kSamePlace = 0.05;

using Name = std::pair<std::string, std::string>;  // kind and id

/// Anchors and panels whose name occurs once; null: more than once.
std::map<Name, const EpochItem*> by_name(const std::vector<EpochItem>& items) {
  std::map<Name, const EpochItem*> named;
  for (const EpochItem& item : items) {
    if ((item.kind != "anchor" && item.kind != "panel") || item.id == item.guid) continue;
    const auto [at, first] = named.try_emplace({item.kind, item.id}, &item);
    if (!first) at->second = nullptr;
  }
  return named;
}

bool same_place(const EpochItem& before, const EpochItem& now) {
  if (before.kind == "anchor") return (before.design - now.design).norm() <= kSamePlace;
  return before.floor == now.floor && before.facade == now.facade;
}

/// The neighbour of a joint that has no name is named by its GlobalId.
void rename_topic(const std::map<std::string, std::string>& renamed, std::string& topic) {
  const auto slash = topic.find('/');
  if (slash == std::string::npos) return;
  if (const auto found = renamed.find(topic.substr(slash + 1)); found != renamed.end())
    topic.replace(slash + 1, std::string::npos, found->second);
}

}  // namespace

void find_again(const DeviationT& after, EpochRecord& before, const DesignElements* design) {
  const std::vector<EpochItem> items = record_of(after, "").items;
  std::set<std::string> in_use = design ? design->guids : std::set<std::string>();
  for (const EpochItem& item : items) in_use.insert(item.guid);
  std::set<std::string> taken;
  for (const EpochItem& item : before.items) taken.insert(item.guid);
  const auto now = by_name(items), then = by_name(before.items);
  std::map<std::string, std::string> renamed;
  for (const auto& [name, item] : then) {
    const auto found = now.find(name);
    if (!item || item->guid.empty() || in_use.contains(item->guid) || found == now.end() || !found->second) continue;
    const EpochItem& same = *found->second;
    if (!same.guid.empty() && !taken.contains(same.guid) && same_place(*item, same))
      renamed.try_emplace(item->guid, same.guid);
  }
  for (EpochItem& item : before.items) {
    if (const auto found = renamed.find(item.guid); found != renamed.end())
      item.guid_before = std::exchange(item.guid, found->second);
    rename_topic(renamed, item.topic);
    std::map<std::string, ToleranceVerdict> joints;
    for (const auto& [panel, verdict] : item.open_joints) {
      const auto found = renamed.find(panel);
      joints[found != renamed.end() ? found->second : panel] = verdict;
    }
    item.open_joints = std::move(joints);
  }
  for (EpochFinding& finding : before.findings)
    for (std::string& anchor : finding.anchors)
      if (const auto found = renamed.find(anchor); found != renamed.end()) anchor = found->second;
}

}  // namespace plumbline::judgement
