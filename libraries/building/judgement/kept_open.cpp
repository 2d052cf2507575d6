#include "building/judgement/kept_open.hpp"

#include <fmt/core.h>

#include <map>

#include "building/ifc/findings.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/group_motions.hpp"

namespace plumbline::judgement {
namespace {

void keep_open(AsBuiltChangeT& change, const std::string& why) {
  change.change = ChangeKind::still_open;
  change.note += (change.note.empty() ? "" : "; ") + why;
}

bool was_open(ToleranceVerdict verdict) {
  return verdict == ToleranceVerdict::fail || verdict == ToleranceVerdict::undecided;
}

bool passes_now(const AsBuiltChangeT& change) {
  return was_open(change.before) && change.after == ToleranceVerdict::pass;
}

/// All of them moved alike: whether one that passes now was mended, or the frame moved under it, nobody can tell.
void keep_open_for_all(AsBuiltChangesT& out) {
  for (auto& change : out.changes)
    if (passes_now(*change))
      keep_open(*change,
                "it passes now, and nothing counts as mended while all anchors seem to have moved by the same");
}

/// The same of what moved with the anchors around it that were in order before: nobody resets those. A panel is as open
/// where all its anchors that were measured twice did so.
void keep_open_for_groups(const std::vector<MeasuredTwice>& pairs, const DeviationT& after, AsBuiltChangesT& out) {
  if (pairs.empty()) return;
  const GroupMotions motions = group_motions(pairs, out.critical);
  std::map<std::string, int> follows;  // by anchor
  for (std::size_t i = 0; i < pairs.size(); ++i) follows[pairs[i].change->id] = motions.follows[i];
  std::map<std::string, int> of_panel;  // by GlobalId: a group; -1: none
  for (const auto& panel : after.panels)
    for (const auto& fixing : panel->fixings) {
      const auto found = follows.find(fixing->anchor);
      if (found == follows.end()) continue;
      const auto at = of_panel.try_emplace(panel->guid, found->second).first;
      if (found->second < 0) at->second = -1;
    }
  std::set<int> told;
  for (auto& change : out.changes) {
    if (!passes_now(*change) || (change->kind != "anchor" && change->kind != "panel")) continue;
    const auto& groups = change->kind == "anchor" ? follows : of_panel;
    const auto found = groups.find(change->kind == "anchor" ? change->id : change->guid);
    if (found == groups.end() || found->second < 0) continue;
    const GroupMotion& group = motions.groups[static_cast<std::size_t>(found->second)];
    keep_open(*change, "it passes now, and has moved as the anchors of " + group.name +
                           " that were in order before: nothing counts as mended by that");
    told.insert(found->second);
  }
  for (const int g : told) {
    const GroupMotion& group = motions.groups[static_cast<std::size_t>(g)];
    out.warnings.push_back(fmt::format(
        "{} anchors of {} that were in order before have moved alike, on average by {:+.1f}, {:+.1f}, {:+.1f} mm (x, "
        "y, "
        "z): rather the control or the frame differs between the campaigns than the building; what passes for that "
        "alone stays open",
        group.witnesses, group.name, 1e3 * group.mean.x(), 1e3 * group.mean.y(), 1e3 * group.mean.z()));
  }
}

}  // namespace

void keep_open_for_the_frame(const std::vector<MeasuredTwice>& pairs, const DeviationT& after, AsBuiltChangesT& out) {
  if (out.together.isZero())
    keep_open_for_groups(pairs, after, out);
  else
    keep_open_for_all(out);
}

std::set<KeptItem> items_kept_open(const AsBuiltChangesT* changes) {
  std::set<KeptItem> kept;
  if (!changes) return kept;
  for (const auto& change : changes->changes)
    if (change->change == ChangeKind::still_open && change->after == ToleranceVerdict::pass)
      kept.insert({change->kind, change->id, change->guid, change->topic});
  return kept;
}

std::vector<std::string> leave_open(const AsBuiltChangesT& changes, DeviationT& judged) {
  constexpr std::size_t kNamed = 8;
  std::vector<std::string> unseen, by_joint, warnings;  // by_joint: measured, but for the neighbour at the open joint
  int panels = 0, panels_by_joint = 0;
  for (const auto& change : changes.changes) {
    if (!was_open(change->before) || change->change != ChangeKind::unseen || change->kind == "anchor") continue;
    const bool seen = change->after != ToleranceVerdict::not_measured;
    (seen ? by_joint : unseen).push_back(change->kind + " " + change->id);
    (seen ? panels_by_joint : panels) += change->kind == "panel";
  }
  const bool forbids = judged.verdict == ToleranceVerdict::pass;
  const auto tell = [&](const std::vector<std::string>& names, int count, const std::string& why, const char* by) {
    if (names.empty()) return;
    auto request = std::make_unique<JudgementRequestT>();
    request->asked = list_of(names, kNamed), request->by = by, request->panels = count;
    request->not_judged = "open" + (changes.before.empty() ? std::string() : " since " + changes.before) + why;
    warnings.push_back((forbids ? "Not judged: " : "Still open: ") + request->asked + ": " + request->not_judged + ".");
    if (!forbids) return;
    judged.requests.push_back(std::move(request));
    ++judged.not_judged, judged.verdict = ToleranceVerdict::undecided;
  };
  tell(unseen, panels, " and not measured again", ifc::kCampaignBefore);
  tell(by_joint, panels_by_joint, " at a joint whose other panel was not measured again", ifc::kCampaignBeforeJoint);
  return warnings;
}

}  // namespace plumbline::judgement
