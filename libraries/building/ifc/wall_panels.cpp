// Precast panels are walls: those that hang before the anchors of a facade.
#include <algorithm>
#include <set>

#include "building/ifc/design.hpp"
#include "building/ifc/what_hangs.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::ifc {
namespace {

/// Farther than this before its anchors, a wall is beside them by more than rounding [m].
constexpr double kBefore = 0.02;

struct Candidate {
  Element* wall;
  std::vector<const Element*> anchors;  ///< within reach, and not fixed to it

  /// Whether it hangs before all of them; false where it is not known which way they face.
  bool hangs() const {
    const Eigen::Vector3d middle = wall->project_from_element * Eigen::Vector3d(0.5 * (wall->box_low + wall->box_high));
    return std::all_of(anchors.begin(), anchors.end(), [&](const Element* anchor) {
      const FacadeFrame& frame = anchor->facade;
      return frame.known() && frame.confirmed && frame.out.dot(middle - anchor->position) > kBefore;
    });
  }
  bool open() const {
    return std::any_of(anchors.begin(), anchors.end(), [](const Element* a) { return !a->facade.confirmed; });
  }
};

std::vector<Candidate> candidates_of(Design& design, const std::set<const Element*>& bare) {
  std::vector<Candidate> found;
  for (Element& wall : design.elements) {
    if (!is_wall(wall) || !wall.has_box) continue;
    Candidate candidate{&wall, {}};
    const RigidTransform own = wall.project_from_element.inverse();
    for (const Element* anchor : bare)
      if (anchor->host_guid != wall.guid &&
          distance_from_box(wall.box_low, wall.box_high, own * anchor->position) <= kPanelReach)
        candidate.anchors.push_back(anchor);
    if (!candidate.anchors.empty()) found.push_back(std::move(candidate));
  }
  return found;
}

/// Which of them are panels; where it is not known, that is told.
void choose_panels(Design& design, const std::vector<FacadeRule>& rules, std::vector<Candidate>& walls) {
  assign_facades(design, rules, false);
  const bool sides_open = std::any_of(walls.begin(), walls.end(), [](const Candidate& c) { return c.open(); });
  // Where nothing else tells the sides, the walls may: as panels, on one side of their anchors.
  for (const Candidate& candidate : walls) candidate.wall->is_panel = sides_open || candidate.hangs();
  if (!sides_open) return;
  assign_facades(design, rules, false);
  std::vector<std::string> open;
  std::vector<bool> hangs;
  for (const Candidate& candidate : walls) hangs.push_back(candidate.hangs());
  for (std::size_t i = 0; i < walls.size(); ++i) {
    walls[i].wall->is_panel = hangs[i];
    if (walls[i].open()) open.push_back(walls[i].wall->name.empty() ? walls[i].wall->guid : walls[i].wall->name);
  }
  if (open.empty()) return;
  design.not_applied.push_back(
      {"walls at anchors (" + open.front() +
           (open.size() > 1 ? " and " + std::to_string(open.size() - 1) + " more" : "") + ")",
       "design",
       "whether they are panels depends on which way the anchors face, which is not confirmed; say what are panels "
       "with "
       "\"design.with.panel_selection=['class=IfcWall & name~^FT']\", or which way the facade faces with "
       "design.with.facades"});
}

}  // namespace

bool is_wall(const Element& element) {
  return !element.is_anchor && !element.is_panel &&
         (element.ifc_class == "IfcWall" || element.ifc_class == "IfcWallStandardCase" ||
          element.ifc_class == "IfcCovering");
}

void hang_walls(Design& design, const std::vector<FacadeRule>& rules, const std::set<const Element*>& bare) {
  std::vector<Candidate> walls = candidates_of(design, bare);
  if (walls.empty()) return;
  // What may be a part of the fixing says nothing of the facade here, and is a panel again behind.
  std::vector<Element*> plates;
  const std::set<const Element*> fixings = may_be_fixings(design);
  for (Element& element : design.elements)
    if (fixings.contains(&element)) plates.push_back(&element);
  for (Element* plate : plates) plate->is_panel = false;
  choose_panels(design, rules, walls);
  for (Element* plate : plates) plate->is_panel = true;
}

}  // namespace plumbline::ifc
