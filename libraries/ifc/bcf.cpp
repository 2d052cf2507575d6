#include "ifc/bcf.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <vector>

#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "ifc/facade_artifact.hpp"
#include "ifc/ifc_guid.hpp"
#include "ifc/surface_words.hpp"
#include "ifc/zip_writer.hpp"
#include "text/xml_text.hpp"

namespace plumbline::bim {
namespace {

const std::string kHead = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

using formats::xml_escaped;

std::string element(const std::string& name, const std::string& text) {
  return text.empty() ? "" : "<" + name + ">" + xml_escaped(text) + "</" + name + ">";
}

std::string vector(const std::string& name, const Eigen::Vector3d& v) {
  char text[200];
  std::snprintf(text, sizeof text, "<X>%.6f</X><Y>%.6f</Y><Z>%.6f</Z>", v.x(), v.y(), v.z());
  return "<" + name + ">" + text + "</" + name + ">";
}

std::string mm(double metres, int decimals = 1) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", decimals, 1e3 * metres);
  return text;
}

/// One anchor or panel to be mended.
struct Issue {
  std::string guid, title, description, storey;
  ToleranceVerdict verdict;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double reach = 0;
  FacadeFrame frame;                                        ///< of one who stands before it
  std::string about = {};                                   ///< what of the element; empty: the whole
  std::string key() const { return about.empty() ? guid : guid + "/" + about; }
  double away() const { return std::max(4.0, 4 * reach); }  ///< from it to the camera [m]
};

/// Where nothing says which way it faces it is looked at along y.
FacadeFrame view_of(const std::unique_ptr<FacadeFrameT>& facade) {
  const FacadeFrame frame = frame_or_none(facade);
  return frame.known() ? frame : frame_facing(-Eigen::Vector3d::UnitY(), FacadeSource::none, false);
}

Issue issue_of(const AnchorDeviationT& anchor) {
  Issue issue{
      anchor.guid,    "Anchor " + anchor.id, "",  anchor.floor > 0 ? "Floor " + std::to_string(anchor.floor) : "",
      anchor.verdict, anchor.design,         0.3, view_of(anchor.facade)};
  for (const auto& axis : anchor.axes) {
    if (axis->axis != anchor.decided_by) continue;
    std::string name = axis->axis;
    std::replace(name.begin(), name.end(), '_', ' ');
    issue.title += ": " + name + " " + mm(axis->value) + " mm (limit " + mm(axis->tolerance) + ")";
    issue.description = "Verdict " + std::string(EnumNameToleranceVerdict(anchor.verdict)) + ": " + name + " " +
                        mm(axis->value, 2) + " mm, standard uncertainty " + mm(axis->u, 2) + " mm, tolerance " +
                        mm(axis->tolerance, 2) + " mm.";
  }
  const Eigen::Vector3d& d = anchor.deviation;
  issue.description +=
      " As-built minus design: " + mm(d.x(), 2) + ", " + mm(d.y(), 2) + ", " + mm(d.z(), 2) + " mm (x, y, z).";
  if (!anchor.note.empty()) issue.description += " " + anchor.note + ".";
  return issue;
}

Issue issue_of(const PanelDeviationT& panel) {
  Issue issue{panel.guid,
              "Panel " + (panel.name.empty() ? panel.guid : panel.name) + ": " + panel.reason,
              "",
              panel.floor > 0 ? "Floor " + std::to_string(panel.floor) : "",
              panel.verdict,
              Eigen::Vector3d::Zero(),
              0.3,
              view_of(panel.facade)};
  for (const auto& corner : panel.corners) issue.centre += corner->design / static_cast<double>(panel.corners.size());
  for (const auto& corner : panel.corners) issue.reach = std::max(issue.reach, (corner->design - issue.centre).norm());
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
    char probability[40];
    std::snprintf(probability, sizeof probability, "%.3f", verdict->probability);
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
      by_what;  // GlobalId, or both names
  std::map<int, std::vector<const SurfaceVerdictT*>> by_number;  // of the joint: panels may share a name
  for (const auto& verdict : options.surface_judgement->verdicts)
    if (!verdict->second.empty() && verdict->item >= 0)
      by_number[verdict->item].push_back(verdict.get());
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
  std::map<std::string, int> of_that_key;
  for (size_t j = 0; j < options.surfaces->joints.size(); ++j) {
    const auto& joint = options.surfaces->joints[j];
    const auto numbered = by_number.find(static_cast<int>(j));
    const auto found = by_what.find({joint->first, joint->second});
    const bool by_name = joint->first_panel < 0 || static_cast<size_t>(joint->first_panel) >= panels.size();
    const SurfaceFaceT* face = by_name ? faces[joint->first] : panels[static_cast<size_t>(joint->first_panel)]->face.get();
    if (!face || face->guid.size() != 22 || (numbered == by_number.end() && found == by_what.end())) continue;
    const auto& verdicts = numbered != by_number.end() ? numbered->second : found->second;
    // Two neighbours of one panel may share a name: their topics are two.
    const int same = of_that_key[face->guid + joint->second]++;
    if (worst_of(verdicts) != wanted) continue;
    issues.push_back(surface_issue(*face, "Joint " + joint->first + " | " + joint->second, verdicts));
    issues.back().about = "joint/" + joint->second + (same > 0 ? "/" + std::to_string(same) : "");
    issues.back().centre = joint->origin, issues.back().reach = std::max(0.3, 0.5 * joint->length);
  }
  return issues;
}

/// What was asked for and not judged: an issue of the whole, without a component.
Issue issue_of(const JudgementRequestT& request) {
  Issue issue;
  issue.guid = "not judged: " + request.asked;
  issue.title = "Not judged: " + request.asked;
  issue.description = "Asked for and not judged: " + request.asked + ": " + request.not_judged +
                      ". Nothing is ready to install before it is.";
  issue.verdict = ToleranceVerdict::undecided;
  return issue;
}

/// Why the measurement proves nothing: an issue of the whole, before all others.
Issue issue_of_doubt(const std::string& doubt) {
  Issue issue;
  issue.guid = "doubt: " + doubt;
  issue.title = "Measurement not to be trusted: " + doubt.substr(0, doubt.find(": "));
  issue.description = "Not to be trusted, " + doubt + ". Nothing is decided, and no order is given, before it is mended.";
  issue.verdict = ToleranceVerdict::undecided;
  return issue;
}

std::string uuid_of(const std::string& project, const std::string& key) {
  const auto uuid = uuid_from_ifc_guid(derived_ifc_guid(project, key));
  return uuid_to_text(*uuid);
}

/// Which models the topic is about: without it a viewer does not know what to load.
std::string header_of(const BcfOptions& options, const std::string& design_file) {
  std::string files;
  for (const std::string& name : {options.model_file, design_file})
    if (!name.empty())
      files += "<File IfcProject=\"" + xml_escaped(options.project_guid) + "\" isExternal=\"true\">" +
               element("Filename", name) + "</File>";
  return files.empty() ? "" : "<Header>" + files + "</Header>";
}

/// GlobalIds of the panels that hang between the camera and the issue: they are hidden, or nobody would see it.
std::vector<std::string> panels_before(const Issue& issue, const DeviationT& deviation) {
  constexpr double margin = 0.3;  // [m] what is seen beside it
  std::vector<std::string> hidden;
  for (const auto& panel : deviation.panels) {
    if (panel->guid == issue.guid || panel->corners.empty()) continue;
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
    for (const auto& corner : panel->corners) {
      const Eigen::Vector3d d = corner->design - issue.centre;
      const Eigen::Vector3d seen(issue.frame.right.dot(d), issue.frame.up.dot(d), issue.frame.out.dot(d));
      low = low.cwiseMin(seen), high = high.cwiseMax(seen);
    }
    const double reach = margin + issue.reach;
    if (low.x() < reach && high.x() > -reach && low.y() < reach && high.y() > -reach && high.z() > -0.05 &&
        low.z() < issue.away())
      hidden.push_back(panel->guid);
  }
  return hidden;
}

std::string markup(const Issue& issue, const BcfOptions& options, const std::string& header, const std::string& topic,
                   const std::string& view, int index) {
  const bool fail = issue.verdict == ToleranceVerdict::fail;
  return kHead + "<Markup>" + header + "<Topic Guid=\"" + topic + "\" TopicType=\"Issue\" TopicStatus=\"Open\">" +
         element("Title", issue.title) + element("Priority", fail ? "High" : "Normal") +
         element("Index", std::to_string(index)) + element("Labels", issue.storey) +
         element("Labels", fail ? "FAIL" : "UNDECIDED") + element("Labels", options.epoch) +
         element("CreationDate", options.date) + element("CreationAuthor", options.author) +
         element("DueDate", options.due_date) + element("AssignedTo", options.assigned_to) +
         element("Description", issue.description) + "</Topic>" +
         (view.empty() ? ""
                       : "<Viewpoints Guid=\"" + view +
                             "\"><Viewpoint>viewpoint.bcfv</Viewpoint><Snapshot>snapshot.png</Snapshot></Viewpoints>") +
         "</Markup>\n";
}

std::string viewpoint(const Issue& issue, const std::vector<std::string>& hidden, const std::string& view) {
  const Eigen::Vector3d& normal = issue.frame.out;
  std::string exceptions;
  for (const std::string& guid : hidden) exceptions += "<Component IfcGuid=\"" + xml_escaped(guid) + "\"/>";
  if (!exceptions.empty()) exceptions = "<Exceptions>" + exceptions + "</Exceptions>";
  const std::string component = "<Component IfcGuid=\"" + xml_escaped(issue.guid) + "\"/>";
  const char* colour = issue.verdict == ToleranceVerdict::fail ? "FFD55E00" : "FFE69F00";
  return kHead + "<VisualizationInfo Guid=\"" + view + "\"><Components><Selection>" + component +
         "</Selection><Visibility DefaultVisibility=\"true\">" + exceptions + "</Visibility><Coloring><Color Color=\"" +
         colour + "\">" + component + "</Color></Coloring></Components><PerspectiveCamera>" +
         vector("CameraViewPoint", issue.centre + issue.away() * normal) + vector("CameraDirection", -normal) +
         vector("CameraUpVector", issue.frame.up) +
         "<FieldOfView>60</FieldOfView></PerspectiveCamera></VisualizationInfo>\n";
}

}  // namespace

std::string write_bcf(const DeviationT& deviation, const std::vector<const AnchorDeviationT*>& anchors,
                      const std::vector<const PanelDeviationT*>& panels, const BcfOptions& options) {
  std::vector<Issue> issues;
  for (const std::string& doubt : deviation.doubts) issues.push_back(issue_of_doubt(doubt));
  for (const ToleranceVerdict wanted : {ToleranceVerdict::fail, ToleranceVerdict::undecided}) {
    for (const AnchorDeviationT* anchor : anchors)
      if (anchor->verdict == wanted && anchor->guid.size() == 22) issues.push_back(issue_of(*anchor));
    for (const PanelDeviationT* panel : panels)
      if (panel->verdict == wanted && panel->guid.size() == 22) issues.push_back(issue_of(*panel));
    for (Issue& issue : surface_issues(options, wanted)) issues.push_back(std::move(issue));
  }
  for (const auto& request : deviation.requests)
    if (!request->not_judged.empty()) issues.push_back(issue_of(*request));
  ZipWriter zip;
  zip.add("bcf.version", kHead + "<Version VersionId=\"2.1\"><DetailedVersion>2.1</DetailedVersion></Version>\n");
  const std::string header = header_of(options, deviation.design_file);
  int index = 0;
  for (const Issue& issue : issues) {
    const std::string topic = uuid_of(options.project_guid, "bcf/" + options.epoch + "/" + issue.key());
    const bool seen = issue.reach > 0;
    const std::string view =
        seen ? uuid_of(options.project_guid, "bcf view/" + options.epoch + "/" + issue.key()) : std::string();
    zip.add(topic + "/markup.bcf", markup(issue, options, header, topic, view, index++));
    if (!seen) continue;
    zip.add(topic + "/viewpoint.bcfv", viewpoint(issue, panels_before(issue, deviation), view));
    zip.add(topic + "/snapshot.png", snapshot_png(deviation, issue.centre, issue.reach, issue.frame));
  }
  return zip.finish();
}

}  // namespace plumbline::bim
