#include "building/ifc/bcf_shifts.hpp"

#include <algorithm>

#include "building/ifc/bcf_changes.hpp"

namespace plumbline::ifc {

void show_together(const std::vector<const AnchorDeviationT*>& anchors, BcfIssue& issue) {
  std::vector<const AnchorDeviationT*> shown;
  for (const AnchorDeviationT* anchor : anchors) {
    if (anchor->guid.size() != 22) continue;
    issue.members.push_back(anchor->guid);
    if (anchor->design.allFinite()) shown.push_back(anchor);
  }
  if (shown.empty()) return;
  const auto facade_of = [](const AnchorDeviationT& a) { return a.facade ? a.facade->facade : std::string(); };
  const std::string facade = facade_of(*shown.front());
  issue.frame = view_of(shown.front()->facade);
  // What stands elsewhere is selected all the same.
  std::erase_if(shown, [&](const AnchorDeviationT* anchor) { return facade_of(*anchor) != facade; });
  for (const AnchorDeviationT* anchor : shown) issue.centre += anchor->design / static_cast<double>(shown.size());
  issue.reach = 0.3;
  for (const AnchorDeviationT* anchor : shown)
    issue.reach = std::max(issue.reach, (anchor->design - issue.centre).norm());
}

BcfIssue issue_of(const Finding& finding) {
  BcfIssue issue;
  issue.guid = finding.topic, issue.title = finding.title, issue.description = finding.words;
  issue.storey = finding.floor > 0 ? "Floor " + std::to_string(finding.floor) : "";
  issue.facade = finding.facade.empty() ? "" : "Facade " + finding.facade;
  issue.verdict = finding.anchors.empty() ? ToleranceVerdict::undecided : finding.anchors.front()->verdict;
  if (finding.kind == "misfit") issue.state = "LESS CERTAIN";
  show_together(finding.anchors, issue);
  return issue;
}

std::string shared_by(const std::vector<Finding>& findings, const AnchorDeviationT& anchor) {
  std::string text;
  for (const Finding& finding : findings)
    if (std::find(finding.anchors.begin(), finding.anchors.end(), &anchor) != finding.anchors.end())
      text += " It has this in common with others: " + finding.title +
              "; look for that one cause before this anchor is reset.";
  return text;
}

}  // namespace plumbline::ifc
