#include "building/ifc/bcf_topic.hpp"

#include <fmt/core.h>

#include <cmath>
#include <regex>
#include <type_traits>
#include <utility>

#include "base/text/xml_text.hpp"
#include "building/ifc/as_built_solids.hpp"
#include "building/ifc/bcf_sight.hpp"
#include "building/ifc/facade_artifact.hpp"
#include "building/ifc/ifc_guid.hpp"

namespace plumbline::ifc {

using text::xml_escaped;

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
  return "<" + name + ">" + fmt::format("<X>{:.6f}</X><Y>{:.6f}</Y><Z>{:.6f}</Z>", v.x(), v.y(), v.z()) + "</" + name +
         ">";
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
      files += "<File IfcProject=\"" + xml_escaped(options.project_guid) + "\" " +
               (options.version_3 ? "IsExternal" : "isExternal") + "=\"true\">" + element("Filename", name) + "</File>";
  if (files.empty()) return "";
  return options.version_3 ? "<Header><Files>" + files + "</Files></Header>" : "<Header>" + files + "</Header>";
}

std::string component(const std::string& guid) { return "<Component IfcGuid=\"" + xml_escaped(guid) + "\"/>"; }

/// The element and, where it was measured, the solid that stands for it as built: it lies over the element in the file
/// that the header names first.
template <class Element>
std::string components_of(const Element& element, const BcfOptions& options) {
  bool solid = element.instance != 0;
  if constexpr (std::is_same_v<Element, AnchorDeviationT>)
    solid = solid && element.deviation.allFinite();
  else
    solid = solid && element.shift.allFinite();
  return component(element.guid) +
         (solid ? component(as_built_solid_guid(options.project_guid, options.epoch, element.guid)) : "");
}

/// Of what has this GlobalId.
std::string components_of(const std::string& guid, const BcfSurroundings::Around& around, const BcfOptions& options) {
  for (const AnchorDeviationT* anchor : around.anchors)
    if (anchor->guid == guid) return components_of(*anchor, options);
  for (const PanelDeviationT* panel : around.panels)
    if (panel->guid == guid) return components_of(*panel, options);
  return component(guid);
}

/// The panels that hang between the camera and the issue, and their solids: they are hidden, or nobody would see it.
std::string panels_before(const BcfIssue& issue, const BcfSurroundings& surroundings, const BcfOptions& options) {
  constexpr double margin = 0.3;  // [m] what is seen beside it
  std::string hidden;
  for (const PanelDeviationT* panel :
       surroundings.around(issue.centre, 2 * (margin + issue.reach) + issue.away()).panels) {
    if (panel->guid == issue.guid) continue;
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
    for (const auto& corner : panel->corners) {
      const Eigen::Vector3d d = corner->design - issue.centre;
      const Eigen::Vector3d seen(issue.frame.right.dot(d), issue.frame.up.dot(d), issue.frame.out.dot(d));
      low = low.cwiseMin(seen), high = high.cwiseMax(seen);
    }
    const double reach = margin + issue.reach;
    if (low.x() < reach && high.x() > -reach && low.y() < reach && high.y() > -reach && high.z() > -0.05 &&
        low.z() < issue.away())
      hidden += components_of(*panel, options);
  }
  return hidden;
}

std::string comments(const BcfIssue& issue, const BcfOptions& options, const std::string& topic) {
  std::string text;
  for (std::size_t i = 0; i < issue.comments.size(); ++i) {
    const BcfComment& comment = issue.comments[i];
    const std::string key = comment.key.empty() ? std::to_string(i) : comment.key;
    text += "<Comment Guid=\"" + uuid_of(options.project_guid, "bcf comment/" + topic + "/" + key) + "\">" +
            element("Date", comment.date) + element("Author", comment.author) + element("Comment", comment.text) +
            "</Comment>";
  }
  return text;
}

std::vector<std::string> labels_of(const BcfIssue& issue, const BcfOptions& options) {
  const char* state = issue.closed ? "MENDED" : issue.verdict == ToleranceVerdict::fail ? "FAIL" : "UNDECIDED";
  std::vector<std::string> labels;
  for (const std::string& label :
       {issue.storey, issue.facade, issue.state.empty() ? std::string(state) : issue.state, options.epoch})
    if (!label.empty()) labels.push_back(label);
  return labels;
}

/// In 3.0 comments and viewpoints are parts of the topic, and lists have an element around them.
std::string markup(const BcfIssue& issue, const BcfOptions& options, const std::string& header,
                   const std::string& topic, const std::string& view, bool snapshot, int index) {
  const bool newer = options.version_3;
  std::string labels, views, said = comments(issue, options, topic);
  for (const std::string& label : labels_of(issue, options)) labels += element(newer ? "Label" : "Labels", label);
  if (newer && !labels.empty()) labels = "<Labels>" + labels + "</Labels>";
  if (newer && !said.empty()) said = "<Comments>" + said + "</Comments>";
  if (!view.empty()) {
    const std::string files =
        std::string("<Viewpoint>viewpoint.bcfv</Viewpoint>") + (snapshot ? "<Snapshot>snapshot.png</Snapshot>" : "");
    views = newer ? "<Viewpoints><ViewPoint Guid=\"" + view + "\">" + files + "</ViewPoint></Viewpoints>"
                  : "<Viewpoints Guid=\"" + view + "\">" + files + "</Viewpoints>";
  }
  return kHead + "<Markup>" + header + "<Topic Guid=\"" + topic + "\" TopicType=\"Issue\" TopicStatus=\"" +
         (issue.closed ? "Closed" : "Open") + "\">" + element("Title", issue.title) +
         element("Priority", issue.verdict == ToleranceVerdict::fail ? "High" : "Normal") +
         element("Index", std::to_string(index)) + labels + element("CreationDate", options.date) +
         element("CreationAuthor", options.author) + element("DueDate", options.due_date) +
         element("AssignedTo", options.assigned_to) + element("Description", issue.description) +
         (newer ? said + views + "</Topic>" : "</Topic>" + said + views) + "</Markup>\n";
}

/// What topics of 3.0 may say, which is what these do.
std::string extensions(const std::set<std::string>& labels, const BcfOptions& options) {
  std::set<std::string> users = {options.author};
  if (!options.assigned_to.empty()) users.insert(options.assigned_to);
  const auto list = [](const std::string& all, const char* one, const std::set<std::string>& values) {
    std::string text;
    for (const std::string& value : values) text += element(one, value);
    return "<" + all + ">" + text + "</" + all + ">";
  };
  return kHead + "<Extensions>" + list("TopicTypes", "TopicType", {"Issue"}) +
         list("TopicStatuses", "TopicStatus", {"Open", "Closed"}) + list("Priorities", "Priority", {"High", "Normal"}) +
         list("TopicLabels", "TopicLabel", labels) + list("Users", "User", users) + "</Extensions>\n";
}

std::string clipping_plane(const BcfIssue& issue) {
  const Eigen::Vector3d& out = issue.frame.out;  // points into the half-space that is clipped
  return "<ClippingPlanes><ClippingPlane>" + vector("Location", issue.centre + clipped_beyond(issue) * out) +
         vector("Direction", out) + "</ClippingPlane></ClippingPlanes>";
}

/// `hidden`: what else the view leaves out.
std::string viewpoint(const BcfIssue& issue, const std::vector<const Element*>& hidden,
                      const BcfSurroundings& surroundings, const std::string& view, const BcfOptions& options) {
  const Eigen::Vector3d& normal = issue.frame.out;
  const auto around = surroundings.around(issue.centre, 1 + issue.reach);
  std::string exceptions = panels_before(issue, surroundings, options);
  for (const Element* element : hidden)
    if (element->guid.size() == 22 && exceptions.find(component(element->guid)) == std::string::npos)
      exceptions += components_of(element->guid, around, options);
  if (!exceptions.empty()) exceptions = "<Exceptions>" + exceptions + "</Exceptions>";
  std::string own = issue.members.empty() ? components_of(issue.guid, around, options) : std::string();
  for (const std::string& member : issue.members) own += components_of(member, around, options);
  const char* colour = issue.verdict == ToleranceVerdict::fail ? "FFD55E00" : "FFE69F00";
  return kHead + "<VisualizationInfo Guid=\"" + view + "\"><Components><Selection>" + own +
         "</Selection><Visibility DefaultVisibility=\"true\">" + exceptions + "</Visibility><Coloring><Color Color=\"" +
         colour + "\">" + (options.version_3 ? "<Components>" + own + "</Components>" : own) +
         "</Color></Coloring></Components><PerspectiveCamera>" +
         vector("CameraViewPoint", issue.centre + issue.away() * normal) + vector("CameraDirection", -normal) +
         vector("CameraUpVector", issue.frame.up) + "<FieldOfView>60</FieldOfView>" +
         (options.version_3 ? "<AspectRatio>1.333333</AspectRatio>" : "") + "</PerspectiveCamera>" +
         clipping_plane(issue) + "</VisualizationInfo>\n";
}

}  // namespace

BcfFile::BcfFile(const BcfOptions& options, const std::string& design_file, std::size_t topics)
    : options_(options),
      header_(header_of(options, design_file)),
      snapshots_(3 * topics + 2 <= step::ZipWriter::kMostEntries) {
  zip_.add(
      "bcf.version",
      kHead + (options.version_3 ? "<Version VersionId=\"3.0\"/>\n"
                                 : "<Version VersionId=\"2.1\"><DetailedVersion>2.1</DetailedVersion></Version>\n"));
}

std::string without_figures(const std::string& words) {
  static const std::regex figure(R"(\d+\.\d+)");
  return std::regex_replace(words, figure, "#");
}

void BcfFile::add(const BcfIssue& issue, const BcfSurroundings& surroundings) {
  const std::string topic = uuid_of(options_.project_guid, "bcf//" + issue.key());
  const bool seen = issue.reach > 0;
  const std::string view = seen ? uuid_of(options_.project_guid, "bcf view//" + issue.key()) : std::string();
  for (const std::string& label : labels_of(issue, options_)) labels_.insert(label);
  const bool one = seen && issue.members.empty();
  BcfIssue shown = one ? with_its_shape(issue, surroundings) : issue;
  std::vector<const Element*> hidden;
  if (one) {
    BcfView from = free_view(shown, surroundings);
    shown.frame = from.frame, hidden = std::move(from.hidden);
    if (!from.words.empty()) shown.description += (shown.description.empty() ? "" : " ") + from.words;
  }
  zip_.add(topic + "/markup.bcf", markup(shown, options_, header_, topic, view, snapshots_, index_++));
  if (!seen) return;
  zip_.add(topic + "/viewpoint.bcfv", viewpoint(shown, hidden, surroundings, view, options_));
  if (snapshots_) zip_.add(topic + "/snapshot.png", snapshot_png(surroundings, issue.centre, issue.reach, issue.frame));
}

std::string BcfFile::finish() {
  if (options_.version_3) zip_.add("extensions.xml", extensions(labels_, options_));
  return zip_.finish();
}

}  // namespace plumbline::ifc
