#include "building/judgement/epoch_findings.hpp"

#include <algorithm>
#include <set>

#include "building/ifc/findings.hpp"

namespace plumbline::judgement {
namespace {

const std::string& name_of(const AnchorDeviationT& anchor) { return anchor.guid.empty() ? anchor.id : anchor.guid; }

EpochFinding finding_of(const ifc::Finding& found) {
  EpochFinding finding{found.topic, found.title, found.kind, found.facade, found.floor};
  for (const AnchorDeviationT* anchor : found.anchors) finding.anchors.push_back(name_of(*anchor));
  return finding;
}

std::unique_ptr<FindingChangeT> change_of(const EpochFinding& finding, ChangeKind kind) {
  auto change = std::make_unique<FindingChangeT>();
  change->topic = finding.topic, change->title = finding.title, change->kind = finding.kind;
  change->floor = finding.floor, change->facade = finding.facade, change->anchors = finding.anchors;
  change->change = kind;
  return change;
}

std::set<std::string> measured_in(const DeviationT& deviation) {
  std::set<std::string> names;
  for (const auto& anchor : deviation.anchors)
    if (anchor->deviation.allFinite()) names.insert(name_of(*anchor));
  return names;
}

/// Why a shift that is not found any more may be there all the same; empty: it is gone.
std::string why_unseen(const EpochFinding& finding, const DeviationT& after, const AsBuiltChangesT& changes,
                       const std::set<std::string>& measured) {
  constexpr std::ptrdiff_t kFewest = 4;  // as of a group whose shift is looked for
  if (finding.kind != "shift") return "";
  if (!after.doubts.empty()) return "this campaign's measurement is not to be trusted";
  if (!changes.together.isZero()) return "all anchors seem to have moved by the same";
  for (const auto& change : changes.changes) {
    const std::string& anchor = change->guid.empty() ? change->id : change->guid;
    if (change->kind == "anchor" && change->change == ChangeKind::still_open &&
        change->after == ToleranceVerdict::pass &&
        std::find(finding.anchors.begin(), finding.anchors.end(), anchor) != finding.anchors.end())
      return "its anchors pass, and what they pass by does not count as mended";
  }
  const auto again = std::count_if(finding.anchors.begin(), finding.anchors.end(),
                                   [&](const std::string& anchor) { return measured.contains(anchor); });
  if (again >= kFewest && 2 * again >= static_cast<std::ptrdiff_t>(finding.anchors.size())) return "";
  return std::to_string(again) + " of its " + std::to_string(finding.anchors.size()) + " anchors measured again";
}

}  // namespace

void compare_findings(const EpochRecord& before, const DeviationT& after, AsBuiltChangesT& changes) {
  const auto earlier_of = [&](const std::string& topic) {
    return std::find_if(before.findings.begin(), before.findings.end(),
                        [&](const EpochFinding& finding) { return finding.topic == topic; });
  };
  std::set<std::string> here;
  for (const ifc::Finding& found : ifc::findings_of(after)) {
    const auto earlier = earlier_of(found.topic);
    here.insert(found.topic);
    changes.findings.push_back(change_of(finding_of(found), earlier == before.findings.end() ? ChangeKind::opened
                                                            : earlier->open                  ? ChangeKind::still_open
                                                                            : ChangeKind::opened_again));
  }
  const std::set<std::string> measured = measured_in(after);
  for (const EpochFinding& finding : before.findings) {
    if (!finding.open || here.contains(finding.topic)) continue;
    const std::string why = why_unseen(finding, after, changes, measured);
    changes.findings.push_back(change_of(finding, why.empty() ? ChangeKind::settled : ChangeKind::unseen));
    // It may be another shift than the one that was mended: which one is there is said.
    const std::string there =
        why.empty() && finding.kind == "shift" ? ifc::shift_title(after, finding.topic) : std::string();
    changes.findings.back()->note = there.empty() ? why : "now: " + there + "; none of its anchors is out by it";
  }
}

std::vector<EpochFinding> findings_kept(const DeviationT& deviation, const EpochRecord* before,
                                        const AsBuiltChangesT* changes) {
  std::vector<EpochFinding> kept;
  std::set<std::string> known;
  for (const ifc::Finding& found : ifc::findings_of(deviation))
    if (known.insert(found.topic).second) kept.push_back(finding_of(found));
  if (!before) return kept;
  for (EpochFinding finding : before->findings) {
    if (known.contains(finding.topic)) continue;
    if (changes)
      for (const auto& change : changes->findings)
        if (change->topic == finding.topic && change->change == ChangeKind::settled) finding.open = false;
    // What was asked for is named in words, which come back seldom.
    if (finding.open || finding.kind != "request") kept.push_back(std::move(finding));
  }
  return kept;
}

}  // namespace plumbline::judgement
