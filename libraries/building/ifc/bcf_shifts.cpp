#include "building/ifc/bcf_shifts.hpp"

#include <algorithm>

#include "building/ifc/bcf_changes.hpp"
#include "building/ifc/shift_words.hpp"

namespace plumbline::ifc {
namespace {

using Anchors = std::vector<const AnchorDeviationT*>;

bool is_open(const AnchorDeviationT& anchor) {
  return anchor.verdict == ToleranceVerdict::fail || anchor.verdict == ToleranceVerdict::undecided;
}

bool belongs(const AnchorDeviationT& anchor, const GroupShiftT& group) {
  return (group.floor == 0 || anchor.floor == group.floor) && (group.column == 0 || anchor.column == group.column) &&
         (group.facade.empty() || (anchor.facade && anchor.facade->facade == group.facade));
}

/// A group whose anchors nobody can name from here; then words are all there is.
bool is_unknown(const GroupShiftT& group) { return group.kind == "axis" || group.kind == "batch"; }

Anchors measured_of(const DeviationT& deviation, const GroupShiftT* group) {
  Anchors found;
  for (const auto& anchor : deviation.anchors)
    if (anchor->deviation.allFinite() && (!group || belongs(*anchor, *group))) found.push_back(anchor.get());
  return found;
}

/// Looked at from before the facade of the first that is to be mended: what stands elsewhere is selected all the same.
void place(const Anchors& members, BcfIssue& issue) {
  const AnchorDeviationT& first = *members.front();
  const auto facade_of = [](const AnchorDeviationT& a) { return a.facade ? a.facade->facade : std::string(); };
  issue.frame = view_of(first.facade);
  double shown = 0;
  for (const AnchorDeviationT* anchor : members)
    if (facade_of(*anchor) == facade_of(first)) issue.centre += anchor->design, ++shown;
  issue.centre /= shown, issue.reach = 0.3;
  for (const AnchorDeviationT* anchor : members)
    if (facade_of(*anchor) == facade_of(first))
      issue.reach = std::max(issue.reach, (anchor->design - issue.centre).norm());
}

void add_issue(const std::string& key, const std::string& words, Anchors members, bool known,
               std::vector<BcfIssue>& issues) {
  if (std::none_of(members.begin(), members.end(), [](const auto* anchor) { return is_open(*anchor); })) return;
  std::stable_sort(members.begin(), members.end(), [](const auto* a, const auto* b) {
    return static_cast<int>(a->verdict) > static_cast<int>(b->verdict);
  });
  BcfIssue issue;
  issue.guid = key, issue.title = shift_in_short(words), issue.description = words;
  issue.verdict = members.front()->verdict;
  for (const AnchorDeviationT* anchor : members)
    if (known && anchor->guid.size() == 22) issue.members.push_back(anchor->guid);
  if (!issue.members.empty()) place(members, issue);
  issues.push_back(std::move(issue));
}

}  // namespace

std::vector<BcfIssue> shift_issues(const DeviationT& deviation) {
  std::vector<BcfIssue> issues;
  if (const auto& common = deviation.common_shift; common && common->significant)
    add_issue("shift of the building", common->words, measured_of(deviation, nullptr), true, issues);
  for (const auto& group : deviation.group_shifts)
    if (group->significant)
      add_issue("shift of " + group->name, group->words,
                measured_of(deviation, is_unknown(*group) ? nullptr : group.get()), !is_unknown(*group), issues);
  return issues;
}

std::string shared_by(const DeviationT& deviation, const AnchorDeviationT& anchor) {
  std::string text;
  const auto add = [&](const std::string& words) {
    text += " It has this in common with others: " + shift_in_short(words) +
            "; look for that one cause before this anchor is reset.";
  };
  if (!anchor.deviation.allFinite()) return text;
  if (const auto& common = deviation.common_shift; common && common->significant) add(common->words);
  for (const auto& group : deviation.group_shifts)
    if (group->significant && !is_unknown(*group) && belongs(anchor, *group)) add(group->words);
  return text;
}

}  // namespace plumbline::ifc
