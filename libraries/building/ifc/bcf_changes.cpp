#include "building/ifc/bcf_changes.hpp"

#include <algorithm>
#include <map>

#include "artifacts/as_built_changes.hpp"
#include "building/ifc/bcf_shifts.hpp"
#include "building/ifc/former_guids.hpp"

namespace plumbline::ifc {
namespace {

/// Surfaces and joints are named with what was measured of them.
std::string capital(const AsBuiltChangeT& change) {
  static const std::map<std::string, const char*> words = {
      {"anchor", "Anchor "}, {"panel", "Panel "}, {"surface", "Surface of panel "}, {"joint", "Joint "}};
  const auto word = words.find(change.kind);
  return (word != words.end() ? word->second : "") + change.id;
}

bool was_open(const AsBuiltChangeT& change) {
  return change.before == ToleranceVerdict::fail || change.before == ToleranceVerdict::undecided;
}

bool is_open(const AsBuiltChangeT& change) {
  return change.after == ToleranceVerdict::fail || change.after == ToleranceVerdict::undecided;
}

/// "2026-05: fail; 2026-06: pass, mended."
std::string history(const AsBuiltChangeT& change, const AsBuiltChangesT& all) {
  const auto name = [](const std::string& epoch, const char* otherwise) { return epoch.empty() ? otherwise : epoch; };
  // What passes and is left open by something else has a note of that.
  const bool unseen = change.change == ChangeKind::unseen && change.note.empty();
  const std::string now = change.change == ChangeKind::left_out ? "no longer in the design or the plate table"
                          : unseen                              ? "not measured again"
                                                                : EnumNameToleranceVerdict(change.after);
  return name(all.before, "campaign before") + std::string(": ") + EnumNameToleranceVerdict(change.before) + "; " +
         name(all.after, "this campaign") + ": " + now + (change.moved ? "; it was moved" : "") +
         (change.note.empty() ? "" : "; " + change.note) + ".";
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
    case ChangeKind::still_open:
    case ChangeKind::opened:
    case ChangeKind::opened_again:
      return capital(change) + ": open";
    default:
      return capital(change) + (change.note.empty() ? ": was open, and was not measured again"
                                                    : ": was open, and not all of it was measured again");
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

namespace {

/// What the campaigns say of one topic: of an anchor or panel one change, of a surface or joint one for each quantity.
using Said = std::vector<const AsBuiltChangeT*>;

std::string key_of(const AsBuiltChangeT& change) {
  return change.topic.empty() ? change.guid : change.guid + "/" + change.topic;
}

bool is_closed_by(const AsBuiltChangeT& change) {
  return change.change == ChangeKind::mended || change.change == ChangeKind::settled;
}

/// The history of all of it that is or was open; empty: nothing to tell.
BcfComment comment_on(const Said& said, const BcfOptions& options) {
  BcfComment comment{options.date, options.author, ""};
  for (const AsBuiltChangeT* change : said) {
    if (!was_open(*change) && change->change != ChangeKind::opened_again) continue;
    comment.text += (comment.text.empty() ? "" : " ") + (change->topic.empty() ? "" : capital(*change) + ": ") +
                    history(*change, *options.changes);
  }
  comment.key = comment.date + "/" + comment.text;  // every campaign says something of its own of the same topic
  return comment;
}

/// Of a topic that was open and of which this file has no issue of its own: closed by what was measured again, else as
/// it was.
BcfIssue earlier_issue(const Said& said, BcfIssue issue, const BcfComment& comment,
                       const std::set<const AsBuiltChangeT*>& former) {
  const auto keeps_open = [&](const AsBuiltChangeT& change) {
    return is_open(change) || (was_open(change) && !is_closed_by(change) && !former.contains(&change));
  };
  const AsBuiltChangeT* speaks = nullptr;  // what keeps it open, else the first that was open
  for (const AsBuiltChangeT* change : said)
    if (keeps_open(*change) ? !speaks || !keeps_open(*speaks) : was_open(*change) && !speaks) speaks = change;
  issue.guid = speaks->guid, issue.about = speaks->topic;
  issue.title = former.contains(speaks) ? capital(*speaks) + ": goes on under another GlobalId" : title_of(*speaks);
  issue.description = comment.text, issue.closed = !keeps_open(*speaks);
  if (!issue.closed) issue.verdict = is_open(*speaks) ? speaks->after : speaks->before;
  issue.comments.push_back(comment);
  return issue;
}

/// Where anchors and panels are, by GlobalId.
std::map<std::string, BcfIssue> places_of(const DeviationT& deviation) {
  std::map<std::string, BcfIssue> places;
  for (const auto& anchor : deviation.anchors)
    if (anchor->design.allFinite()) places.try_emplace(anchor->guid, placed_issue(*anchor));
  for (const auto& panel : deviation.panels) places.try_emplace(panel->guid, placed_issue(*panel));
  return places;
}

std::string gone_words(const FindingChangeT& change) {
  return change.note.empty() ? "not found any more" : change.note;
}

/// "2026-05: found; 2026-06: not found any more."
BcfComment comment_on(const FindingChangeT& change, const BcfOptions& options) {
  const AsBuiltChangesT& all = *options.changes;
  const auto name = [](const std::string& epoch, const char* otherwise) { return epoch.empty() ? otherwise : epoch; };
  const bool again = change.change == ChangeKind::opened_again;
  const std::string now = change.change == ChangeKind::settled  ? gone_words(change)
                          : change.change == ChangeKind::unseen ? "nothing says that it is gone (" + change.note + ")"
                                                                : "found";
  BcfComment comment{options.date, options.author, ""};
  comment.text = name(all.before, "campaign before") + std::string(again ? ": not found any more; " : ": found; ") +
                 name(all.after, "this campaign") + ": " + now + ".";
  comment.key = comment.date + "/" + comment.text;
  return comment;
}

/// Of a finding that this campaign has not: where the anchors are that shared it.
BcfIssue earlier_issue(const FindingChangeT& change, const DeviationT& deviation, const BcfComment& comment) {
  Finding finding{change.kind, change.topic, change.title, comment.text, change.floor, change.facade};
  const std::set<std::string> shared(change.anchors.begin(), change.anchors.end());
  for (const auto& anchor : deviation.anchors)
    if (shared.contains(anchor->guid)) finding.anchors.push_back(anchor.get());
  BcfIssue issue = issue_of(finding);
  issue.closed = change.change == ChangeKind::settled, issue.verdict = ToleranceVerdict::undecided;
  issue.title += issue.closed ? ": " + gone_words(change) : ": was found, and nothing says that it is gone";
  if (issue.closed) issue.state.clear();
  issue.comments.push_back(comment);
  return issue;
}

/// The same of findings, which are no element's.
void add_findings(const DeviationT& deviation, const BcfOptions& options,
                  const std::map<std::string, std::size_t>& open, std::vector<BcfIssue>& issues) {
  for (const auto& change : options.changes->findings) {
    if (change->change == ChangeKind::opened) continue;
    const BcfComment comment = comment_on(*change, options);
    if (const auto known = open.find(change->topic); known != open.end())
      issues[known->second].comments.push_back(comment);
    else
      issues.push_back(earlier_issue(*change, deviation, comment));
  }
}

}  // namespace

void add_changes(const DeviationT& deviation, const BcfOptions& options, std::vector<BcfIssue>& issues) {
  std::map<std::string, std::size_t> open;
  for (std::size_t i = 0; i < issues.size(); ++i) open.try_emplace(issues[i].key(), i);
  add_findings(deviation, options, open, issues);
  const std::map<std::string, BcfIssue> places = places_of(deviation);
  std::vector<std::string> keys;  // in the order of the changes
  std::map<std::string, Said> topics;
  const auto former = former_guids(*options.changes);
  for (const auto& change : options.changes->changes) {
    if (change->guid.size() != 22) continue;  // it never had a topic
    Said& said = topics[key_of(*change)];
    if (said.empty()) keys.push_back(key_of(*change));
    said.push_back(change.get());
  }
  for (const std::string& key : keys) {
    const Said& said = topics[key];
    const BcfComment comment = comment_on(said, options);
    if (comment.text.empty()) continue;
    if (const auto known = open.find(key); known != open.end()) {
      issues[known->second].comments.push_back(comment);
    } else if (std::any_of(said.begin(), said.end(), [](const AsBuiltChangeT* c) { return was_open(*c); })) {
      const auto place = places.find(said.front()->guid);
      issues.push_back(earlier_issue(said, place != places.end() ? place->second : BcfIssue(), comment, former));
    }
  }
}

}  // namespace plumbline::ifc
