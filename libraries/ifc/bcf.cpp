#include "ifc/bcf.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "ifc/ifc_guid.hpp"
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
  Eigen::Vector3d centre;
  double reach;
};

Issue issue_of(const AnchorDeviationT& anchor) {
  Issue issue{
      anchor.guid,    "Anchor " + anchor.id, "", anchor.floor > 0 ? "Floor " + std::to_string(anchor.floor) : "",
      anchor.verdict, anchor.design,         0.3};
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
  return issue;
}

Issue issue_of(const PanelDeviationT& panel) {
  Issue issue{panel.guid,
              "Panel " + (panel.name.empty() ? panel.guid : panel.name) + ": " + panel.reason,
              "",
              panel.floor > 0 ? "Floor " + std::to_string(panel.floor) : "",
              panel.verdict,
              Eigen::Vector3d::Zero(),
              0.3};
  for (const auto& corner : panel.corners) issue.centre += corner->design / static_cast<double>(panel.corners.size());
  for (const auto& corner : panel.corners) issue.reach = std::max(issue.reach, (corner->design - issue.centre).norm());
  issue.description = "Verdict " + std::string(EnumNameToleranceVerdict(panel.verdict)) + ": " + panel.reason + ".";
  if (!panel.fixings.empty()) issue.description += " Shims per anchor, outward:";
  for (const auto& fixing : panel.fixings) issue.description += " " + fixing->anchor + " " + mm(fixing->shim) + " mm;";
  for (const std::string& missing : panel.missing) issue.description += " " + missing + " was not measured;";
  return issue;
}

std::string uuid_of(const std::string& project, const std::string& key) {
  const auto uuid = uuid_from_ifc_guid(derived_ifc_guid(project, key));
  return uuid_to_text(*uuid);
}

std::string markup(const Issue& issue, const BcfOptions& options, const std::string& topic, const std::string& view,
                   int index) {
  const bool fail = issue.verdict == ToleranceVerdict::fail;
  return kHead + "<Markup><Topic Guid=\"" + topic + "\" TopicType=\"Issue\" TopicStatus=\"Open\">" +
         element("Title", issue.title) + element("Priority", fail ? "High" : "Normal") +
         element("Index", std::to_string(index)) + element("Labels", issue.storey) +
         element("Labels", fail ? "FAIL" : "UNDECIDED") + element("Labels", options.epoch) +
         element("CreationDate", options.date) + element("CreationAuthor", options.author) +
         element("DueDate", options.due_date) + element("AssignedTo", options.assigned_to) +
         element("Description", issue.description) + "</Topic><Viewpoints Guid=\"" + view +
         "\"><Viewpoint>viewpoint.bcfv</Viewpoint><Snapshot>snapshot.png</Snapshot></Viewpoints></Markup>\n";
}

std::string viewpoint(const Issue& issue, const DeviationT& deviation, const std::string& view) {
  const Eigen::Vector3d normal =
      deviation.facade_normal.allFinite() ? deviation.facade_normal : -Eigen::Vector3d::UnitY();
  const double away = std::max(4.0, 4 * issue.reach);
  const std::string component = "<Component IfcGuid=\"" + xml_escaped(issue.guid) + "\"/>";
  const char* colour = issue.verdict == ToleranceVerdict::fail ? "FFD55E00" : "FFE69F00";
  return kHead + "<VisualizationInfo Guid=\"" + view + "\"><Components><Selection>" + component +
         "</Selection><Visibility DefaultVisibility=\"true\"/><Coloring><Color Color=\"" + colour + "\">" + component +
         "</Color></Coloring></Components><PerspectiveCamera>" +
         vector("CameraViewPoint", issue.centre + away * normal) + vector("CameraDirection", -normal) +
         vector("CameraUpVector", Eigen::Vector3d::UnitZ()) +
         "<FieldOfView>60</FieldOfView></PerspectiveCamera></VisualizationInfo>\n";
}

}  // namespace

std::string write_bcf(const DeviationT& deviation, const std::vector<const AnchorDeviationT*>& anchors,
                      const std::vector<const PanelDeviationT*>& panels, const BcfOptions& options) {
  std::vector<Issue> issues;
  for (const ToleranceVerdict wanted : {ToleranceVerdict::fail, ToleranceVerdict::undecided}) {
    for (const AnchorDeviationT* anchor : anchors)
      if (anchor->verdict == wanted && anchor->guid.size() == 22) issues.push_back(issue_of(*anchor));
    for (const PanelDeviationT* panel : panels)
      if (panel->verdict == wanted && panel->guid.size() == 22) issues.push_back(issue_of(*panel));
  }
  ZipWriter zip;
  zip.add("bcf.version", kHead + "<Version VersionId=\"2.1\"><DetailedVersion>2.1</DetailedVersion></Version>\n");
  int index = 0;
  for (const Issue& issue : issues) {
    const std::string topic = uuid_of(options.project_guid, "bcf/" + options.epoch + "/" + issue.guid);
    const std::string view = uuid_of(options.project_guid, "bcf view/" + options.epoch + "/" + issue.guid);
    zip.add(topic + "/markup.bcf", markup(issue, options, topic, view, index++));
    zip.add(topic + "/viewpoint.bcfv", viewpoint(issue, deviation, view));
    zip.add(topic + "/snapshot.png", snapshot_png(deviation, issue.centre, issue.reach));
  }
  return zip.finish();
}

}  // namespace plumbline::bim
