#include "ifc/bcf_topic.hpp"

#include <cmath>
#include <cstdio>

#include "ifc/facade_artifact.hpp"
#include "ifc/ifc_guid.hpp"
#include "text/xml_text.hpp"

namespace plumbline::bim {

using formats::xml_escaped;

/// Where nothing says which way it faces it is looked at along y.
FacadeFrame view_of(const std::unique_ptr<FacadeFrameT>& facade) {
  const FacadeFrame frame = frame_or_none(facade);
  return frame.known() ? frame : frame_facing(-Eigen::Vector3d::UnitY(), FacadeSource::none, false);
}

namespace {

const std::string kHead = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

std::string element(const std::string& name, const std::string& text) {
  return text.empty() ? "" : "<" + name + ">" + xml_escaped(text) + "</" + name + ">";
}

std::string vector(const std::string& name, const Eigen::Vector3d& v) {
  char text[200];
  std::snprintf(text, sizeof text, "<X>%.6f</X><Y>%.6f</Y><Z>%.6f</Z>", v.x(), v.y(), v.z());
  return "<" + name + ">" + text + "</" + name + ">";
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
std::vector<std::string> panels_before(const BcfIssue& issue, const DeviationT& deviation) {
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

std::string comments(const BcfIssue& issue, const BcfOptions& options, const std::string& topic) {
  std::string text;
  for (std::size_t i = 0; i < issue.comments.size(); ++i) {
    const BcfComment& comment = issue.comments[i];
    text += "<Comment Guid=\"" + uuid_of(options.project_guid, "bcf comment/" + topic + "/" + std::to_string(i)) +
            "\">" + element("Date", comment.date) + element("Author", comment.author) +
            element("Comment", comment.text) + "</Comment>";
  }
  return text;
}

std::string markup(const BcfIssue& issue, const BcfOptions& options, const std::string& header,
                   const std::string& topic, const std::string& view, int index) {
  const bool fail = issue.verdict == ToleranceVerdict::fail;
  return kHead + "<Markup>" + header + "<Topic Guid=\"" + topic + "\" TopicType=\"Issue\" TopicStatus=\"" +
         (issue.closed ? "Closed" : "Open") + "\">" + element("Title", issue.title) +
         element("Priority", fail ? "High" : "Normal") + element("Index", std::to_string(index)) +
         element("Labels", issue.storey) +
         element("Labels", issue.closed ? "MENDED"
                           : fail       ? "FAIL"
                                        : "UNDECIDED") +
         element("Labels", options.epoch) + element("CreationDate", options.date) +
         element("CreationAuthor", options.author) + element("DueDate", options.due_date) +
         element("AssignedTo", options.assigned_to) + element("Description", issue.description) + "</Topic>" +
         comments(issue, options, topic) +
         (view.empty() ? ""
                       : "<Viewpoints Guid=\"" + view +
                             "\"><Viewpoint>viewpoint.bcfv</Viewpoint><Snapshot>snapshot.png</Snapshot></Viewpoints>") +
         "</Markup>\n";
}

std::string viewpoint(const BcfIssue& issue, const std::vector<std::string>& hidden, const std::string& view) {
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

BcfFile::BcfFile(const BcfOptions& options, const std::string& design_file)
    : options_(options), header_(header_of(options, design_file)) {
  zip_.add("bcf.version", kHead + "<Version VersionId=\"2.1\"><DetailedVersion>2.1</DetailedVersion></Version>\n");
}

void BcfFile::add(const BcfIssue& issue, const DeviationT& surroundings) {
  const std::string topic = uuid_of(options_.project_guid, "bcf/" + options_.epoch + "/" + issue.key());
  const bool seen = issue.reach > 0;
  const std::string view =
      seen ? uuid_of(options_.project_guid, "bcf view/" + options_.epoch + "/" + issue.key()) : std::string();
  zip_.add(topic + "/markup.bcf", markup(issue, options_, header_, topic, view, index_++));
  if (!seen) return;
  zip_.add(topic + "/viewpoint.bcfv", viewpoint(issue, panels_before(issue, surroundings), view));
  zip_.add(topic + "/snapshot.png", snapshot_png(surroundings, issue.centre, issue.reach, issue.frame));
}

}  // namespace plumbline::bim
