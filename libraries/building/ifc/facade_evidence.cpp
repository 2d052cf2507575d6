// What a design says of the way its anchors and panels face, and what follows from it.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <unordered_map>

#include "building/ifc/anchor_cells.hpp"
#include "building/ifc/design.hpp"
#include "building/ifc/facade_lines.hpp"
#include "building/ifc/facades.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::ifc {
namespace {

/// So far above or below the edge of a slab an anchor of that storey sits [m].
constexpr double kStorey = 3;
/// Of elements that are alike: more than this are nearly all.
constexpr double kNearlyAll = 0.9;
/// Neighbours that show the line of a facade, in plan [m].
constexpr double kRow = 8;

/// An anchor at the surface of its panel counts as outside of it [m].
constexpr double kAtSurface = 0.005;

/// All that is known of one element.
struct Evidence {
  std::optional<Eigen::Vector3d> own;
  std::optional<FacadeLine> panel, host;
  bool panel_clads = false;          ///< else it may lie behind its anchors: a base plate, a lining, the wall itself
  bool host_may_hang = false;        ///< a wall that it is tied to may be the panel before it
  std::vector<FacadeLine> at_edges;  ///< of what carries the building, where it sits though no relation says so
  std::optional<Eigen::Vector3d> row;
  bool corner = false;  ///< panels that face differently hang at it, and nothing of its own says whose it is
};

class Assigner {
 public:
  explicit Assigner(Design& design) : design_(design), cells_(design) {
    for (Element& element : design.elements) {
      if (!element.guid.empty()) by_guid_.try_emplace(element.guid, &element);
      if (element.is_anchor) anchors_.push_back(&element);
      if (element.is_panel) panels_.push_back(&element);
    }
    find_axes();
    find_building();
    find_fixings();
  }

  void assign(const std::vector<FacadeRule>& rules, bool all_select) {
    for (Element* anchor : anchors_) anchor->facade = decide(evidence_of_anchor(*anchor), *anchor);
    for (Element* panel : panels_) panel->facade = decide(evidence_of_panel(*panel), *panel);
    for (const FacadeRule& rule : rules)
      if (apply(rule) == 0 && all_select)
        throw std::runtime_error("facade rule '" + rule.text + "' selects no anchor and no panel of " +
                                 design_.file_name + "; look at their names and classes with read_design");
    std::vector<Facing> all;
    for (Element& element : design_.elements)
      if (element.is_anchor || element.is_panel)
        all.push_back({element.is_panel && element.has_box ? middle_of(element) : element.position, &element.facade,
                       element.is_panel});
    design_.facades = group_facades(all);
  }

 private:
  /// Axes that follow the facades were turned by somebody: several directions, none of them that of nearly all, and
  /// across the rows of the anchors. One element that is turned proves nothing for the others.
  void find_axes() {
    std::vector<std::pair<Eigen::Vector3d, int>> directions;
    int all = 0, most = 0, rows = 0, along = 0;
    for (const auto* list : {&anchors_, &panels_})
      for (const Element* element : *list)
        if (const auto own = own_direction(*element)) {
          auto like = std::find_if(directions.begin(), directions.end(), [&](const auto& known) {
            return known.first.dot(*own) > std::cos(3 * std::numbers::pi / 180);
          });
          if (like == directions.end()) like = directions.insert(like, {*own, 0});
          most = std::max(most, ++like->second), ++all;
        }
    if (directions.size() < 2 || most > kNearlyAll * all) return;
    const std::size_t step = std::max<std::size_t>(1, anchors_.size() / 300);
    for (std::size_t i = 0; i < anchors_.size(); i += step) {
      const auto own = own_direction(*anchors_[i]), row = own ? row_of(*anchors_[i]) : std::nullopt;
      if (row) ++rows, along += !alike(*own, *row);
    }
    turned_ = along <= (1 - kNearlyAll) * rows;
  }

  /// Where the building stands: its shapes; placements may stand anywhere, and panels hang before the anchors.
  void find_building() {
    double n = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Element& element : design_.elements)
      if (!element.is_anchor && !element.is_panel && element.has_box) sum += middle_of(element), ++n;
    if (n > 0) building_ = sum / n;
  }

  /// Which anchors each panel is fixed by, and at the edges of which slabs and walls they sit.
  void find_fixings() {
    for (Element* panel : panels_) {
      for (const std::string& guid : panel->anchor_guids)
        if (const auto anchor = by_guid_.find(guid); anchor != by_guid_.end()) fix(*panel, *anchor->second);
      if (panel->anchor_guids.empty() && panel->has_box)
        cells_.for_anchors_at(*panel, kPanelReach, [&](const Element& anchor, const Eigen::Vector3d& off) {
          if (off.norm() <= kPanelReach) fix(*panel, anchor);
        });
    }
    for (const Element& element : design_.elements)
      if (carries(element))
        cells_.for_anchors_at(element, kStorey, [&](const Element& anchor, const Eigen::Vector3d& off) {
          if (anchor.host_guid == element.guid || off.head<2>().norm() > kAtFace || std::abs(off.z()) > kStorey) return;
          auto line = line_of_host(element, anchor.position);
          if (!line || !line->outward) return;
          line->may_hang = element.ifc_class.starts_with("IfcWall");
          edges_[&anchor].push_back(*line);
        });
  }

  void fix(const Element& panel, const Element& anchor) {
    fixed_by_[&panel].push_back(&anchor);
    holds_[&anchor].push_back(&panel);
  }

  /// A panel's plane, and on which side of its anchors it hangs.
  std::optional<FacadeLine> line_of_panel(const Element& panel) const {
    const auto thin = thin_axis(panel);
    if (!thin) return {};
    FacadeLine line{axes_of(panel).col(*thin), false};
    const auto fixings = fixed_by_.find(&panel);
    if (fixings == fixed_by_.end()) return line;
    double nearest = 1e300, farthest = -1e300;
    for (const Element* anchor : fixings->second) {
      const double before = line.direction.dot(middle_of(panel) - anchor->position);
      nearest = std::min(nearest, before), farthest = std::max(farthest, before);
    }
    // An anchor within the thickness of its panel (a hook inside a unitised one) does not tell its sides apart.
    const double thickness = (panel.box_high - panel.box_low)[*thin];
    const double beside = std::max(kBeside, 0.5 * thickness - kAtSurface);
    line.outward = nearest > beside || farthest < -beside;
    if (farthest < -beside) line.direction = -line.direction;
    return line;
  }

  Evidence evidence_of_anchor(const Element& anchor) const {
    Evidence evidence;
    bool opposite = false;
    evidence.own = own_direction(anchor);
    if (const auto host = by_guid_.find(anchor.host_guid); !anchor.host_guid.empty() && host != by_guid_.end())
      evidence.host = line_of_host(*host->second, anchor.position),
      evidence.host_may_hang = host->second->ifc_class.starts_with("IfcWall");
    if (const auto edges = edges_.find(&anchor); edges != edges_.end()) evidence.at_edges = edges->second;
    if (const auto held = holds_.find(&anchor); held != holds_.end()) {
      // What clads goes before other plates: a base plate behind it says nothing against it.
      const auto is_cladding = [](const Element* panel) { return panel->is_cladding && thin_axis(*panel); };
      evidence.panel_clads = std::any_of(held->second.begin(), held->second.end(), is_cladding);
      for (const Element* panel : held->second) {
        if (evidence.panel_clads && !panel->is_cladding) continue;
        const auto line = line_of_panel(*panel);
        if (!line) continue;
        const bool own_fits = evidence.own && alike(*evidence.own, line->direction);
        if (!evidence.panel) {
          evidence.panel = line;
        } else if (!alike(evidence.panel->direction, line->direction)) {
          evidence.corner = true;
          if (own_fits && !alike(*evidence.own, evidence.panel->direction)) evidence.panel = line;
        } else if (!evidence.panel->outward) {
          evidence.panel = line;
        } else if (line->outward && line->direction.dot(evidence.panel->direction) < 0) {
          opposite = true;  // before and behind it hang panels
        }
      }
    }
    if (opposite) evidence.panel->outward = false;
    // Axes that were turned to one of them say whose it is.
    if (evidence.corner && turned_ && evidence.own && alike(*evidence.own, evidence.panel->direction))
      evidence.corner = false;
    if (!evidence.panel && !evidence.host && !(evidence.own && turned_)) evidence.row = row_of(anchor);
    return evidence;
  }

  Evidence evidence_of_panel(const Element& panel) const {
    Evidence evidence;
    evidence.own = own_direction(panel);
    evidence.panel = line_of_panel(panel), evidence.panel_clads = panel.is_cladding;
    const auto fixings = fixed_by_.find(&panel);
    if (fixings == fixed_by_.end()) return evidence;
    // What its anchors were found to face counts like the wall behind it.
    for (const Element* anchor : fixings->second) {
      const FacadeFrame& frame = anchor->facade;
      if (!frame.known() || !frame.confirmed || (evidence.panel && !alike(frame.out, evidence.panel->direction)))
        continue;
      if (!evidence.host)
        evidence.host = FacadeLine{frame.out, true};
      else if (!same_way(evidence.host->direction, frame.out))
        evidence.host->outward = false;
    }
    return evidence;
  }

  /// Across the line that the anchor forms with its neighbours in plan.
  std::optional<Eigen::Vector3d> row_of(const Element& anchor) const {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    std::vector<Eigen::Vector2d> row;
    for (const Element* other : anchors_)
      if ((other->position - anchor.position).head<2>().norm() <= kRow) row.push_back(other->position.head<2>());
    for (const auto& p : row) centre += p / static_cast<double>(row.size());
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const auto& p : row) scatter += (p - centre) * (p - centre).transpose() / static_cast<double>(row.size());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
    const double across = std::sqrt(std::max(0.0, eigen.eigenvalues()(0))), along = std::sqrt(eigen.eigenvalues()(1));
    // 0.1 m: anchors of one column scatter by their tolerance only, which is no facade line.
    if (!(along > 0.1) || across > 0.05 * along) return {};
    const Eigen::Vector2d normal = eigen.eigenvectors().col(0);
    return Eigen::Vector3d(normal.x(), normal.y(), 0);
  }

  FacadeFrame decide(const Evidence& evidence, const Element& element) const {
    if (evidence.corner) {
      FacadeFrame nobodys;
      nobodys.note = "panels that face differently hang at it";
      return nobodys;
    }
    const auto fits = [&](const std::optional<FacadeLine>& line) {
      return line && alike(*evidence.own, line->direction);
    };
    const bool own_says =
        evidence.own && (!evidence.panel || fits(evidence.panel)) &&
        (!evidence.host || fits(evidence.host) || fits(evidence.panel)) &&
        (turned_ || evidence.panel || evidence.host || !evidence.row || alike(*evidence.own, *evidence.row));
    std::optional<Eigen::Vector3d> line;
    if (own_says)
      line = evidence.own;
    else if (evidence.panel)
      line = evidence.panel->direction;
    else if (evidence.host)
      line = evidence.host->direction;
    else
      line = evidence.row;
    if (!line) return FacadeFrame{};
    // Which sides are said to be outside: by whom, +1 or −1 along the line.
    std::vector<std::pair<FacadeSource, int>> strong;
    const auto side = [&](const Eigen::Vector3d& out) { return out.dot(*line) < 0 ? -1 : 1; };
    if (own_says && turned_) strong.emplace_back(FacadeSource::own_axes, side(*evidence.own));
    if (evidence.panel && evidence.panel->outward && alike(evidence.panel->direction, *line))
      strong.emplace_back(FacadeSource::panel, side(evidence.panel->direction));
    if (evidence.host && evidence.host->outward && alike(evidence.host->direction, *line))
      strong.emplace_back(FacadeSource::wall, side(evidence.host->direction));
    // The place of a plate that nobody calls cladding, and a wall, are no proof alone: either may lie on either side of
    // its anchors. The edge of what carries the building, where they sit, must say the same.
    const int edge = side_of_edges(evidence.at_edges, *line);
    const bool alone = strong.size() == 1 && strong.front().first != FacadeSource::own_axes;
    const bool said_by_panel = alone && strong.front().first == FacadeSource::panel;
    if (alone && edge != 0 && (said_by_panel || evidence.host_may_hang)) strong.emplace_back(FacadeSource::wall, edge);
    const bool open = strong.size() == 1 && (said_by_panel ? !evidence.panel_clads : alone && evidence.host_may_hang);
    const int weak = own_says && !turned_ ? side(*evidence.own) : 0;
    const int behind = side_of_building(element.position, *line);
    FacadeFrame frame = frame_of(*line, strong, weak, behind, axes_of(element).col(1));
    if (open && frame.confirmed)
      frame.confirmed = false,
      frame.note = said_by_panel ? "only the place of a plate or wall beside its anchors says it, which is not called "
                                   "cladding: it may lie behind them (a base plate, a lining, what they are fixed to)"
                                 : "only the wall that it is tied to says it, which may hang before it (a precast "
                                   "panel) as well as stand behind it";
    // Of a panel the place of the wall is that of its anchors, which were decided before.
    if (element.is_anchor && strong.size() == 1 && strong.front().first == FacadeSource::wall &&
        behind == -strong.front().second && frame.confirmed)
      frame.confirmed = false,
      frame.note = "the wall or slab behind it has it look to where the rest of the building stands";
    return frame;
  }

  /// Away from the rest of the building: +1 or −1 along the line, 0 if that stands nowhere in particular.
  int side_of_building(const Eigen::Vector3d& position, const Eigen::Vector3d& line) const {
    if (!building_) return 0;
    const double away = line.dot(position - *building_);
    return std::abs(away) < 0.01 ? 0 : away > 0 ? 1 : -1;
  }

  static FacadeFrame frame_of(const Eigen::Vector3d& line, const std::vector<std::pair<FacadeSource, int>>& strong,
                              int weak, int behind, const Eigen::Vector3d& up) {
    const auto make = [&](int side, FacadeSource source, bool confirmed, const std::string& note) {
      FacadeFrame frame = frame_facing(side * line, source, confirmed, up);
      frame.note = note;
      return frame;
    };
    for (const auto& [source, side] : strong)
      if (side != strong.front().second)
        return make(strong.front().second, strong.front().first, false,
                    std::string("its ") + words_of(strong.front().first) + " and its " + words_of(source) +
                        " say the opposite of each other");
    if (!strong.empty()) {
      const int side = strong.front().second;
      if (weak == -side && behind != side)
        return make(side, strong.front().first, false,
                    std::string("its ") + words_of(strong.front().first) +
                        " and its axes (the same for all elements) "
                        "say the opposite of each other");
      return make(side, weak == side ? FacadeSource::own_axes : strong.front().first, true, "");
    }
    // Axes that nobody turned point the same way on every side of a building, and on one side of every courtyard that
    // is away from the middle of it: that both agree proves nothing.
    if (weak != 0)
      return make(weak, FacadeSource::guess, false,
                  behind == weak
                      ? "only the axes of its elements, the same for all of them, and where the other shapes "
                        "of the design stand say it, which are no proof (courtyard, podium)"
                  : behind == 0 ? "only the axes of its elements say it, which are the same for all of them"
                                : "the axes of its elements, the same for all of them, point to where the rest of the "
                                  "building stands");
    if (behind != 0)
      return make(behind, FacadeSource::guess, false,
                  "it was guessed from where the other shapes of the design stand, which are no proof (courtyard, "
                  "podium, a model of one trade)");
    Eigen::Vector3d towards = -Eigen::Vector3d::UnitY();
    if (std::abs(line.y()) < 1e-6) towards = Eigen::Vector3d::UnitX();
    return make(line.dot(towards) < 0 ? -1 : 1, FacadeSource::guess, false,
                "nothing in the design says on which side of its anchors the outside is");
  }

  static const char* words_of(FacadeSource source) {
    return source == FacadeSource::own_axes ? "elements' own axes"
           : source == FacadeSource::panel  ? "panels' places before or behind their anchors"
                                            : "walls or slabs";
  }

  /// How many it selects.
  int apply(const FacadeRule& rule) {
    int selected = 0;
    for (const auto* list : {&anchors_, &panels_})
      for (Element* element : *list) {
        if (!rule.selection.matches(facts_of(*element))) continue;
        ++selected;
        if (rule.out) {
          FacadeFrame given = frame_facing(*rule.out, FacadeSource::rule, true, axes_of(*element).col(1));
          given.facade = element->facade.facade, given.named = element->facade.named;
          element->facade = std::move(given);
        } else if (rule.confirmed && element->facade.known()) {
          element->facade.confirmed = true, element->facade.source = FacadeSource::rule, element->facade.note.clear();
        }
        if (!rule.name.empty()) element->facade.facade = rule.name, element->facade.named = true;
      }
    return selected;
  }

  Design& design_;
  AnchorCells cells_;
  std::vector<Element*> anchors_, panels_;
  std::unordered_map<std::string, Element*> by_guid_;
  std::unordered_map<const Element*, std::vector<const Element*>> fixed_by_, holds_;
  std::unordered_map<const Element*, std::vector<FacadeLine>> edges_;
  std::optional<Eigen::Vector3d> building_;
  bool turned_ = false;
};

}  // namespace

void assign_facades(Design& design, const std::vector<FacadeRule>& rules, bool all_select) {
  Assigner(design).assign(rules, all_select);
}

}  // namespace plumbline::ifc
