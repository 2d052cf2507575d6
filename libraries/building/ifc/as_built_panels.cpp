#include <algorithm>
#include <cmath>
#include <string_view>

#include "building/ifc/as_built_writer.hpp"
#include "building/ifc/ifc_units.hpp"
#include "building/step/step_writer.hpp"

namespace plumbline::ifc {
namespace {

const char* property_of(const std::string& part) {
  static const std::map<std::string, const char*> names = {{"out_of_plane", "OutOfPlane"},
                                                           {"sideways", "Sideways"},
                                                           {"vertical", "Vertical"},
                                                           {"in_plane", "InPlane"},
                                                           {"tilt", "Tilt"},
                                                           {"warp", "Warp"},
                                                           {"misfit", "Misfit"},
                                                           {"corner", "Corner"},
                                                           {"joint", "Joint"},
                                                           {"anchor", "Anchor"},
                                                           {"missing_anchor", "MissingAnchor"},
                                                           {"one_anchor", "OneAnchor"},
                                                           {"anchors_in_line", "AnchorsInLine"},
                                                           {"held_below", "HeldBelow"},
                                                           {"facade", "Facade"},
                                                           {"not_judged", "NotJudged"},
                                                           {"doubt", "Doubt"}};
  const auto found = names.find(part);
  return found == names.end() ? "" : found->second;
}

}  // namespace

void AsBuiltWriter::write_panel(const PanelDeviationT& panel) {
  std::vector<std::string> guids, corners, neighbours;
  std::vector<double> shims, sideways, upward, moved, narrowest, widest;
  for (const auto& fixing : panel.fixings) {
    guids.push_back(fixing->guid);
    shims.push_back(fixing->shim), sideways.push_back(fixing->sideways), upward.push_back(fixing->upward);
  }
  for (const auto& corner : panel.corners) {
    if (!corner->movement.allFinite()) continue;
    corners.push_back(corner->name);
    moved.insert(moved.end(), {corner->movement.x(), corner->movement.y(), corner->movement.z()});
  }
  for (const auto& joint : panel.joints) {
    neighbours.push_back(joint->panel);
    narrowest.push_back(joint->narrowest), widest.push_back(joint->widest);
  }
  std::vector<std::string> warnings;
  const double radian = read_units(model_, model_.all("IFCPROJECT").at(0), warnings).plane_angle;
  PropertySet set(appender_);
  set.choice("Verdict", label_of(panel.verdict), verdicts_, "The worst of its lengths, joints and anchors");
  set.label("DecidedBy", property_of(panel.decided_by));
  set.label("Reason", panel.reason);
  const std::pair<const char*, const JudgedLengthT*> lengths[] = {
      {"OutOfPlane", panel.out_of_plane.get()}, {"Sideways", panel.sideways.get()}, {"Vertical", panel.vertical.get()},
      {"InPlane", panel.in_plane.get()},        {"Tilt", panel.tilt.get()},         {"Warp", panel.warp.get()},
      {"Misfit", panel.misfit.get()},           {"Corner", panel.corner.get()}};
  for (const auto& [name, length] : lengths)
    if (length)
      set.length(name, length->value,
                 panel.facade && !panel.facade->confirmed && std::string_view(name) == "OutOfPlane"
                     ? "Without a sign: which way is outward is not confirmed"
                     : "");
  set.length("FitX", panel.shift.x(), "Shift of the panel's centre if it follows its anchors");
  set.length("FitY", panel.shift.y());
  set.length("FitZ", panel.shift.z());
  set.angle("FitRotationX", panel.rotation.x(), radian,
            "Turn about the panel's centre; 0 where the anchors cannot tell");
  set.angle("FitRotationY", panel.rotation.y(), radian);
  set.angle("FitRotationZ", panel.rotation.z(), radian);
  set.labels("AnchorGUIDs", guids);
  set.lengths("ShimPerAnchor", shims,
              "Outward correction that brings each anchor back to its design plane, in the order of AnchorGUIDs");
  set.lengths("SidewaysPerAnchor", sideways, "Correction to the right as seen from outside");
  set.lengths("UpwardPerAnchor", upward, "Correction upward");
  set.labels("MissingAnchors", panel.missing, "That hold the panel and were not measured");
  set.labels("Corners", corners, "As seen from outside");
  set.lengths("CornerMovement", moved, "x, y, z of each, in the order of Corners");
  set.labels("JointTo", neighbours, "GlobalIds of the neighbouring panels");
  set.lengths("JointNarrowest", narrowest, "As built, in the order of JointTo");
  set.lengths("JointWidest", widest, "As built, in the order of JointTo");
  attach(set, panel.guid, "ASB_PanelFit",
         "Best fit of the panel to the as-built minus design deviations of its anchors", {panel.instance});
}

}  // namespace plumbline::ifc
