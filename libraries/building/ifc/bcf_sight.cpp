#include "building/ifc/bcf_sight.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

namespace plumbline::ifc {
namespace {

constexpr double kTouching = 1e-3;  ///< [m] an anchor sits on the wall it is fixed to
/// [m] The solid of the as-built file lies around what it stands for, where that was built.
constexpr double kSolid = 0.03;

/// Whether the way from `from` to `to` goes through the box of the element, smaller by `touching` [m] on each side.
bool goes_through(const Element& element, double touching, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const RigidTransform own = element.project_from_element.inverse();
  const Eigen::Vector3d begin = own * from, way = own * to - begin;
  double enters = 0, leaves = 1;
  for (int k = 0; k < 3; ++k) {
    const double slack = std::min(touching, 0.25 * (element.box_high - element.box_low)[k]);
    const double low = element.box_low[k] + slack - begin[k], high = element.box_high[k] - slack - begin[k];
    if (std::abs(way[k]) < 1e-12) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    enters = std::max(enters, std::min(low / way[k], high / way[k]));
    leaves = std::min(leaves, std::max(low / way[k], high / way[k]));
  }
  return enters < leaves;
}

struct Direction {
  FacadeFrame frame;
  const char* words;
};

FacadeFrame turned(const FacadeFrame& frame, double degrees, const Eigen::Vector3d& about) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(degrees * std::numbers::pi / 180, about).toRotationMatrix();
  FacadeFrame to = frame;
  to.right = turn * frame.right, to.up = turn * frame.up, to.out = turn * frame.out;
  return to;
}

/// The best first.
std::vector<Direction> directions_of(const FacadeFrame& front) {
  return {{front, ""},
          {turned(front, 40, front.up), "from the right"},
          {turned(front, -40, front.up), "from the left"},
          {turned(front, -40, front.right), "from above"},
          {turned(front, 40, front.right), "from below"},
          {turned(front, 65, front.up), "from the right"},
          {turned(front, -65, front.up), "from the left"},
          {turned(front, 180, front.up), "from behind"}};
}

/// What stands in the way stands there by its box; its shape may leave the view free.
BcfView by_boxes(BcfView view) {
  if (!view.words.empty()) view.words += " Only the boxes around shapes were looked at.";
  return view;
}

std::string names_of(const std::vector<const Element*>& elements) {
  constexpr std::size_t most = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, elements.size()); ++i)
    text += (i ? ", " : "") + elements[i]->ifc_class + " '" + elements[i]->name + "'";
  return text + (elements.size() > most ? " and " + std::to_string(elements.size() - most) + " more" : "");
}

/// Who is meant, its parts, and what it is a part of.
bool is_of_issue(const Element& element, const std::string& guid, const std::string& parent) {
  return element.guid == guid || element.parent_guid == guid || (!parent.empty() && element.guid == parent);
}

}  // namespace

double clipped_beyond(const BcfIssue& issue) { return std::max(1.0, issue.reach); }

BcfIssue with_its_shape(const BcfIssue& issue, const BcfSurroundings& surroundings) {
  BcfIssue whole = issue;
  for (const Element* element : surroundings.around(issue.centre, clipped_beyond(issue)).shapes) {
    const Eigen::Vector3d middle = 0.5 * (element->box_low + element->box_high);
    const double reach = (element->box_high - middle).norm();
    if (element->guid != issue.guid || !issue.about.empty() || reach <= std::max(1.0, issue.reach)) continue;
    whole.centre = element->project_from_element * middle, whole.reach = reach;
  }
  return whole;
}

BcfView free_view(const BcfIssue& issue, const BcfSurroundings& surroundings) {
  const auto near = surroundings.around(issue.centre, clipped_beyond(issue));
  const auto& around = near.shapes;
  std::set<std::string> judged;  // they have solids, and are hidden like panels
  for (const AnchorDeviationT* anchor : near.anchors) judged.insert(anchor->guid);
  for (const PanelDeviationT* panel : near.panels) judged.insert(panel->guid);
  std::vector<Eigen::Vector3d> targets = {issue.centre};
  std::string parent;
  for (const Element* element : around) {
    if (element->guid != issue.guid) continue;
    parent = element->parent_guid;  // and the middle of its shape is to be seen too
    targets.push_back(element->project_from_element * Eigen::Vector3d(0.5 * (element->box_low + element->box_high)));
  }
  BcfView best;
  std::vector<const Element*> before, least;  // in the way, panels apart
  for (const Direction& direction : directions_of(issue.frame)) {
    const Eigen::Vector3d camera = issue.centre + issue.away() * direction.frame.out;
    const Eigen::Vector3d plane = issue.centre + clipped_beyond(issue) * direction.frame.out;
    std::vector<const Element*> in_the_way, panels;
    for (const Element* element : around) {
      if (is_of_issue(*element, issue.guid, parent)) continue;
      const bool has_solid = judged.contains(element->guid), is_hidden = has_solid || element->is_panel;
      const bool blocks = std::any_of(targets.begin(), targets.end(), [&](const Eigen::Vector3d& target) {
        const double whole = direction.frame.out.dot(camera - target), shown = direction.frame.out.dot(plane - target);
        if (!(whole > 0 && shown > 0)) return false;  // cut away itself
        return goes_through(*element, has_solid ? -kSolid : kTouching, target,
                            target + std::min(1.0, shown / whole) * (camera - target));
      });
      if (blocks) (is_hidden ? panels : in_the_way).push_back(element);
    }
    const bool front = *direction.words == 0;
    if (front) before = in_the_way;
    if (!front && in_the_way.size() >= least.size()) continue;
    least = in_the_way;
    best.frame = direction.frame, best.hidden = std::move(panels);
    best.words = front ? ""
                       : std::string("Seen ") + direction.words + ": before it " +
                             (before.size() == 1 ? "stands " : "stand ") + names_of(before) + ".";
    if (least.empty()) break;
  }
  if (least.empty()) return by_boxes(std::move(best));
  best.hidden.insert(best.hidden.end(), least.begin(), least.end());
  best.words += (best.words.empty() ? "" : " ") + std::string("No view of it is free: this one leaves out ") +
                names_of(least) + ".";
  return by_boxes(std::move(best));
}

}  // namespace plumbline::ifc
