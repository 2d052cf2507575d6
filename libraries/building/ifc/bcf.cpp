#include "building/ifc/bcf.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "building/ifc/bcf_changes.hpp"
#include "building/ifc/bcf_shifts.hpp"
#include "building/ifc/bcf_topic.hpp"
#include "building/ifc/limit_words.hpp"
#include "building/ifc/surface_words.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::ifc {
namespace {

using Issue = BcfIssue;

std::string mm(double metres, int decimals = 1) { return fmt::format("{:.{}f}", 1e3 * metres, decimals); }

Issue issue_of(const AnchorDeviationT& anchor) {
  Issue issue = placed_issue(anchor);
  issue.title = "Anchor " + anchor.id;
  for (const auto& axis : anchor.axes) {
    if (axis->axis != anchor.decided_by) continue;
    std::string name = axis->axis;
    std::replace(name.begin(), name.end(), '_', ' ');
    const auto limits = [&](int decimals) {
      return limits_in_words(*axis, [&](double length) { return mm(length, decimals); });
    };
    issue.title += ": " + name + " " + mm(axis->value) + " mm (limit " + limits(1) + ")";
    issue.description = "Verdict " + std::string(EnumNameToleranceVerdict(anchor.verdict)) + ": " + name + " " +
                        mm(axis->value, 2) + " mm, standard uncertainty " + mm(axis->u, 2) + " mm, tolerance " +
                        limits(2) + " mm.";
  }
  const Eigen::Vector3d& d = anchor.deviation;
  issue.description +=
      " As-built minus design: " + mm(d.x(), 2) + ", " + mm(d.y(), 2) + ", " + mm(d.z(), 2) + " mm (x, y, z).";
  if (!anchor.note.empty()) issue.description += " " + anchor.note + ".";
  return issue;
}

Issue issue_of(const PanelDeviationT& panel) {
  Issue issue = placed_issue(panel);
  issue.title = "Panel " + (panel.name.empty() ? panel.guid : panel.name) + ": " + panel.reason;
  issue.description = "Verdict " + std::string(EnumNameToleranceVerdict(panel.verdict)) + ": " + panel.reason + ".";
  if (panel.facade && !panel.facade->confirmed)
    issue.description += " Which way it faces is not confirmed: no shims are given.";
  else if (!panel.fixings.empty())
    issue.description += " Shims per anchor, outward:";
  for (const auto& fixing : panel.fixings)
    if (std::isfinite(fixing->shim)) issue.description += " " + fixing->anchor + " " + mm(fixing->shim) + " mm;";
  for (const std::string& missing : panel.missing) issue.description += " " + missing + " was not measured;";
  return issue;
}

/// Lines of all verdicts but those that pass.
std::string words_of(const std::vector<const SurfaceVerdictT*>& verdicts) {
  std::string text;
  for (const SurfaceVerdictT* verdict : verdicts) {
    if (verdict->verdict == ToleranceVerdict::pass) continue;
    text += (text.empty() ? "" : " ") + quantity_of(*verdict) + ": ";
    if (!verdict->not_judged.empty()) {
      text += "not judged, " + verdict->not_judged + ".";
      continue;
    }
    const std::string probability = fmt::format("{:.3f}", verdict->probability);
    text += std::string(EnumNameToleranceVerdict(verdict->verdict)) + ", " + mm(verdict->value, 2) +
            " mm, standard uncertainty " + mm(verdict->sigma, 2) + " mm, limit " + mm(limit_of(*verdict), 2) +
            " mm, kept with a probability of " + probability + " (" + verdict->rule + ").";
  }
  return text;
}

/// The face of a panel as one sees it who stands before it.
Issue surface_issue(const SurfaceFaceT& face, const std::string& title,
                    const std::vector<const SurfaceVerdictT*>& verdicts) {
  Issue issue;
  issue.guid = face.guid, issue.verdict = worst_of(verdicts);
  const auto worst = std::find_if(verdicts.begin(), verdicts.end(),
                                  [&](const SurfaceVerdictT* v) { return v->verdict == issue.verdict; });
  issue.title =
      title + ": " + quantity_of(**worst) + " " + mm((*worst)->value) + " mm (limit " + mm(limit_of(**worst)) + ")";
  issue.description = words_of(verdicts);
  issue.centre = face.origin, issue.reach = 0.5 * std::hypot(face.width, face.height);
  issue.frame.right = face.right, issue.frame.up = face.up, issue.frame.out = face.out;
  return issue;
}

/// Failing and undecided surfaces of panels, then joints; a joint selects the panel at its left or below.
std::vector<Issue> surface_issues(const BcfOptions& options, ToleranceVerdict wanted) {
  std::vector<Issue> issues;
  if (!options.surfaces || !options.surface_judgement) return issues;
  std::map<std::pair<std::string, std::string>, std::vector<const SurfaceVerdictT*>>
      by_what;                                                   // GlobalId, or both names
  std::map<int, std::vector<const SurfaceVerdictT*>> by_number;  // of the joint: panels may share a name
  std::map<int, std::string> topics;
  const std::vector<std::string> all_topics = topics_of(*options.surface_judgement);
  for (size_t i = 0; i < all_topics.size(); ++i)
    if (const auto& verdict = options.surface_judgement->verdicts[i]; !verdict->second.empty() && verdict->item >= 0)
      by_number[verdict->item].push_back(verdict.get()), topics[verdict->item] = all_topics[i];
    else
      by_what[{verdict->second.empty() ? verdict->guid : verdict->panel, verdict->second}].push_back(verdict.get());
  std::map<std::string, const SurfaceFaceT*> faces;
  const auto& panels = options.surfaces->panels;
  for (const auto& panel : panels) {
    const auto found = by_what.find({panel->face->guid, ""});
    faces[panel->face->id] = panel->face.get();
    if (panel->face->guid.size() != 22 || found == by_what.end() || worst_of(found->second) != wanted) continue;
    issues.push_back(surface_issue(*panel->face, "Surface of panel " + panel->face->id, found->second));
    issues.back().about = "surface";
  }
  for (size_t j = 0; j < options.surfaces->joints.size(); ++j) {
    const auto& joint = options.surfaces->joints[j];
    const auto numbered = by_number.find(static_cast<int>(j));
    const auto found = by_what.find({joint->first, joint->second});
    const bool by_name = joint->first_panel < 0 || static_cast<size_t>(joint->first_panel) >= panels.size();
    const SurfaceFaceT* face = by_name ? faces[joint->first] : panels[joint->first_panel]->face.get();
    if (!face || face->guid.size() != 22 || (numbered == by_number.end() && found == by_what.end())) continue;
    const auto& verdicts = numbered != by_number.end() ? numbered->second : found->second;
    if (worst_of(verdicts) != wanted) continue;
    issues.push_back(surface_issue(*face, "Joint " + joint->first + " | " + joint->second, verdicts));
    issues.back().about = numbered != by_number.end() ? topics[static_cast<int>(j)] : "joint/" + joint->second;
    issues.back().centre = joint->origin, issues.back().reach = std::max(0.3, 0.5 * joint->length);
  }
  return issues;
}

}  // namespace

std::string write_bcf(const DeviationT& deviation, const std::vector<const AnchorDeviationT*>& anchors,
                      const std::vector<const PanelDeviationT*>& panels, const BcfOptions& options) {
  std::vector<Issue> issues;
  const std::vector<Finding> findings = findings_of(deviation);
  for (const Finding& finding : findings)
    if (finding.kind != "request") issues.push_back(issue_of(finding));
  const bool facades = deviation.facades.size() > 1;
  const auto add = [&](Issue issue, const std::unique_ptr<FacadeFrameT>& frame) {
    if (facades && frame && !frame->facade.empty()) issue.facade = "Facade " + frame->facade;
    issues.push_back(std::move(issue));
  };
  for (const ToleranceVerdict wanted : {ToleranceVerdict::fail, ToleranceVerdict::undecided}) {
    for (const AnchorDeviationT* anchor : anchors)
      if (anchor->verdict == wanted && anchor->guid.size() == 22) {
        add(issue_of(*anchor), anchor->facade);
        issues.back().description += shared_by(findings, *anchor);
      }
    for (const PanelDeviationT* panel : panels)
      if (panel->verdict == wanted && panel->guid.size() == 22) add(issue_of(*panel), panel->facade);
    for (Issue& issue : surface_issues(options, wanted)) issues.push_back(std::move(issue));
  }
  for (const Finding& finding : findings)
    if (finding.kind == "request") issues.push_back(issue_of(finding));
  if (options.changes) add_changes(deviation, options, issues);
  BcfFile file(options, deviation.design_file, issues.size());
  const BcfSurroundings surroundings(deviation, options.elements);
  for (const Issue& issue : issues) {
    stop_point();
    file.add(issue, surroundings);
  }
  return file.finish();
}

}  // namespace plumbline::ifc
