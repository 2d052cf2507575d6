// What a design says of the way its anchors and panels face, and what follows from it.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <unordered_map>

#include "building/ifc/design.hpp"
#include "building/ifc/facades.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::ifc {
namespace {

const double kAlike = std::cos(20 * std::numbers::pi / 180);
/// A box is a panel or a wall if its thinnest side is at most half of the next.
constexpr double kThin = 0.5;
/// Nearer to its panel's middle plane than this an anchor does not tell on which side the panel hangs [m].
constexpr double kBeside = 0.02;
/// An anchor within this of the face of a wall or slab is fixed to that face [m].
constexpr double kAtFace = 0.5;
/// Of elements that are alike: more than this are nearly all.
constexpr double kNearlyAll = 0.9;
/// Neighbours that show the line of a facade, in plan [m].
constexpr double kRow = 8;

/// A line across the facade, and which of its ends is outside, where that is known: then it points there.
struct Line {
  Eigen::Vector3d direction;
  bool outward = false;
};

bool alike(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::abs(a.dot(b)) > kAlike; }

Eigen::Matrix3d axes_of(const Element& element) { return element.project_from_element.rotation.toRotationMatrix(); }

/// Outward by the placement: −y of axes whose z points up.
std::optional<Eigen::Vector3d> own_direction(const Element& element) {
  const Eigen::Matrix3d axes = axes_of(element);
  if (axes(2, 2) < 0.7) return {};  // a bolt drawn along z and laid down, a panel drawn flat
  return Eigen::Vector3d(-axes.col(1));
}

/// The thin axis of a box, 0 to 2; nothing if it is not flat.
std::optional<int> thin_axis(const Element& element) {
  if (!element.has_box) return {};
  const Eigen::Vector3d size = element.box_high - element.box_low;
  int thin = 0;
  size.minCoeff(&thin);
  const double next = std::min(size[(thin + 1) % 3], size[(thin + 2) % 3]);
  if (!(size[thin] <= kThin * next)) return {};
  return thin;
}

Eigen::Vector3d middle_of(const Element& element) {
  return element.project_from_element * Eigen::Vector3d(0.5 * (element.box_low + element.box_high));
}

/// The side of a wall, or the edge of a slab, that an anchor sits at.
std::optional<Line> line_of_host(const Element& host, const Eigen::Vector3d& anchor) {
  if (!host.has_box) return {};
  const Eigen::Matrix3d axes = axes_of(host);
  const Eigen::Vector3d own = host.project_from_element.inverse() * anchor;
  std::optional<Line> best;
  double nearest = kAtFace, second = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(axes(2, axis)) > 0.7) continue;  // top and bottom
    for (const double sign : {-1.0, 1.0}) {
      const double distance = std::abs(own[axis] - (sign > 0 ? host.box_high : host.box_low)[axis]);
      if (distance < nearest)
        second = best ? nearest : second, nearest = distance, best = Line{sign * axes.col(axis), true};
      else
        second = std::min(second, distance);
    }
  }
  // At a corner, or in the middle of a thin wall, the nearest face says nothing.
  if (best && second < nearest + 0.05) best->outward = false;
  if (best && second < nearest + 0.05 && thin_axis(host) && std::abs(axes(2, *thin_axis(host))) < 0.7)
    best->direction = axes.col(*thin_axis(host));
  else if (best && second < nearest + 0.05)
    return {};
  return best;
}

/// All that is known of one element.
struct Evidence {
  std::optional<Eigen::Vector3d> own;
  std::optional<Line> panel, host;
  std::optional<Eigen::Vector3d> row;
  bool corner = false;  ///< panels that face differently hang at it, and nothing of its own says whose it is
};

class Assigner {
 public:
  explicit Assigner(Design& design) : design_(design) {
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

  void find_fixings() {
    std::map<std::array<int, 3>, std::vector<Element*>> cells;
    const auto cell = [](const Eigen::Vector3d& p, int k) { return static_cast<int>(std::floor(p[k] / 4)); };
    for (Element* anchor : anchors_)
      cells[{cell(anchor->position, 0), cell(anchor->position, 1), cell(anchor->position, 2)}].push_back(anchor);
    for (Element* panel : panels_) {
      for (const std::string& guid : panel->anchor_guids)
        if (const auto anchor = by_guid_.find(guid); anchor != by_guid_.end()) fix(*panel, *anchor->second);
      if (!panel->anchor_guids.empty() || !panel->has_box) continue;
      const Eigen::Vector3d middle = middle_of(*panel);
      const double reach = 0.5 * (panel->box_high - panel->box_low).norm() + kPanelReach;
      const RigidTransform own = panel->project_from_element.inverse();
      const Eigen::Vector3d low = middle.array() - reach, high = middle.array() + reach;
      if (reach > 100) continue;  // a whole facade as one element
      for (int x = cell(low, 0); x <= cell(high, 0); ++x)
        for (int y = cell(low, 1); y <= cell(high, 1); ++y)
          for (int z = cell(low, 2); z <= cell(high, 2); ++z)
            if (const auto found = cells.find({x, y, z}); found != cells.end())
              for (Element* anchor : found->second)
                if (distance_from_box(panel->box_low, panel->box_high, own * anchor->position) <= kPanelReach)
                  fix(*panel, *anchor);
    }
  }

  void fix(const Element& panel, const Element& anchor) {
    fixed_by_[&panel].push_back(&anchor);
    holds_[&anchor].push_back(&panel);
  }

  /// A panel's plane, and on which side of its anchors it hangs.
  std::optional<Line> line_of_panel(const Element& panel) const {
    const auto thin = thin_axis(panel);
    if (!thin) return {};
    Line line{axes_of(panel).col(*thin), false};
    const auto fixings = fixed_by_.find(&panel);
    if (fixings == fixed_by_.end()) return line;
    double nearest = 1e300, farthest = -1e300;
    for (const Element* anchor : fixings->second) {
      const double beside = line.direction.dot(middle_of(panel) - anchor->position);
      nearest = std::min(nearest, beside), farthest = std::max(farthest, beside);
    }
    line.outward = nearest > kBeside || farthest < -kBeside;
    if (farthest < -kBeside) line.direction = -line.direction;
    return line;
  }

  Evidence evidence_of_anchor(const Element& anchor) const {
    Evidence evidence;
    bool opposite = false;
    evidence.own = own_direction(anchor);
    if (const auto host = by_guid_.find(anchor.host_guid); !anchor.host_guid.empty() && host != by_guid_.end())
      evidence.host = line_of_host(*host->second, anchor.position);
    if (const auto held = holds_.find(&anchor); held != holds_.end())
      for (const Element* panel : held->second) {
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
    evidence.panel = line_of_panel(panel);
    const auto fixings = fixed_by_.find(&panel);
    if (fixings == fixed_by_.end()) return evidence;
    // What its anchors were found to face counts like the wall behind it.
    for (const Element* anchor : fixings->second) {
      const FacadeFrame& frame = anchor->facade;
      if (!frame.known() || !frame.confirmed || (evidence.panel && !alike(frame.out, evidence.panel->direction)))
        continue;
      if (!evidence.host)
        evidence.host = Line{frame.out, true};
      else if (evidence.host->direction.dot(frame.out) < kAlike)
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
    const auto fits = [&](const std::optional<Line>& line) { return line && alike(*evidence.own, line->direction); };
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
    const int weak = own_says && !turned_ ? side(*evidence.own) : 0;
    const int behind = side_of_building(element.position, *line);
    FacadeFrame frame = frame_of(*line, strong, weak, behind, axes_of(element).col(1));
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
  std::vector<Element*> anchors_, panels_;
  std::unordered_map<std::string, Element*> by_guid_;
  std::unordered_map<const Element*, std::vector<const Element*>> fixed_by_, holds_;
  std::optional<Eigen::Vector3d> building_;
  bool turned_ = false;
};

}  // namespace

void assign_facades(Design& design, const std::vector<FacadeRule>& rules, bool all_select) {
  Assigner(design).assign(rules, all_select);
}

}  // namespace plumbline::ifc
