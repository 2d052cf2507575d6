#include "building/ifc/bcf_changes.hpp"

#include <map>

#include "artifacts/as_built_changes.hpp"

namespace plumbline::ifc {
namespace {

std::string capital(const AsBuiltChangeT& change) {
  return (change.kind == "anchor" ? "Anchor " : "Panel ") + change.id;
}

bool was_open(const AsBuiltChangeT& change) {
  return change.before == ToleranceVerdict::fail || change.before == ToleranceVerdict::undecided;
}

/// "2026-05: fail; 2026-06: pass, mended."
std::string history(const AsBuiltChangeT& change, const AsBuiltChangesT& all) {
  const auto name = [](const std::string& epoch, const char* otherwise) { return epoch.empty() ? otherwise : epoch; };
  const std::string now = change.change == ChangeKind::left_out ? "no longer in the design or the plate table"
                          : change.change == ChangeKind::unseen ? "not measured again"
                                                                : EnumNameToleranceVerdict(change.after);
  return name(all.before, "campaign before") + std::string(": ") + EnumNameToleranceVerdict(change.before) + "; " +
         name(all.after, "this campaign") + ": " + now + (change.moved ? "; it was moved" : "") + ".";
}

/// What the campaign says of a change, and whether it closes the topic.
std::string title_of(const AsBuiltChangeT& change) {
  switch (change.change) {
    case ChangeKind::mended:
      return capital(change) + ": mended";
    case ChangeKind::settled:
      return capital(change) + ": in order, was undecided";
    case ChangeKind::left_out:
      return capital(change) + ": was open, and is no longer in the design or the plate table";
    default:
      return capital(change) + ": was open, and was not measured again";
  }
}

}  // namespace

BcfIssue placed_issue(const AnchorDeviationT& anchor) {
  BcfIssue issue;
  issue.guid = anchor.guid, issue.verdict = anchor.verdict;
  issue.storey = anchor.floor > 0 ? "Floor " + std::to_string(anchor.floor) : "";
  issue.centre = anchor.design, issue.reach = 0.3, issue.frame = view_of(anchor.facade);
  return issue;
}

BcfIssue placed_issue(const PanelDeviationT& panel) {
  BcfIssue issue;
  issue.guid = panel.guid, issue.verdict = panel.verdict;
  issue.storey = panel.floor > 0 ? "Floor " + std::to_string(panel.floor) : "";
  issue.reach = 0.3, issue.frame = view_of(panel.facade);
  for (const auto& corner : panel.corners) issue.centre += corner->design / static_cast<double>(panel.corners.size());
  for (const auto& corner : panel.corners) issue.reach = std::max(issue.reach, (corner->design - issue.centre).norm());
  return issue;
}

void add_changes(const DeviationT& deviation, const BcfOptions& options, std::vector<BcfIssue>& issues) {
  std::map<std::string, std::size_t> open;  // by key; surfaces have keys of their own
  for (std::size_t i = 0; i < issues.size(); ++i) open.try_emplace(issues[i].key(), i);
  std::map<std::string, BcfIssue> places;
  for (const auto& anchor : deviation.anchors)
    if (anchor->design.allFinite()) places.try_emplace(anchor->guid, placed_issue(*anchor));
  for (const auto& panel : deviation.panels) places.try_emplace(panel->guid, placed_issue(*panel));
  for (const auto& change : options.changes->changes) {
    if (change->guid.size() != 22) continue;  // it never had a topic
    BcfComment comment{options.date, options.author, history(*change, *options.changes)};
    comment.key = comment.date + "/" + comment.text;  // every campaign says something of its own of the same topic
    if (const auto known = open.find(change->guid); known != open.end()) {
      if (was_open(*change) || change->change == ChangeKind::opened_again)
        issues[known->second].comments.push_back(comment);
      continue;
    }
    if (!was_open(*change)) continue;
    BcfIssue issue;
    const auto place = places.find(change->guid);
    if (place != places.end()) issue = place->second;
    issue.guid = change->guid, issue.title = title_of(*change), issue.description = comment.text;
    issue.closed = change->change == ChangeKind::mended || change->change == ChangeKind::settled;
    if (!issue.closed) issue.verdict = change->before;
    issue.comments.push_back(comment);
    issues.push_back(std::move(issue));
  }
}

}  // namespace plumbline::ifc
