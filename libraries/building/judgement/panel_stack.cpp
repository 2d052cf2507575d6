#include "building/judgement/panel_stack.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <set>

#include "building/judgement/figures.hpp"

namespace plumbline::judgement {
namespace {

/// Of what is common to both edges, less is none [m].
constexpr double kLeastCommon = 0.05;
/// So far two panels may overlap in height [m].
constexpr double kOverlap = 0.02;

std::string name_of(const PanelCase& panel) { return panel.name.empty() ? panel.guid : panel.name; }

/// A panel that ends where another begins.
struct Below {
  const PanelCase* panel;
  double begin, end, height;  ///< of what is common, along right, and up to the middle of the joint [m]
};

/// Measured places of a sill along the edge of a panel.
struct SillPoint {
  std::size_t anchor, position;  ///< in the inputs, among the deviations
  double along;                  ///< [m]
};

class Stack {
 public:
  Stack(std::vector<JudgedPanel>& panels, const DeviationInputs& inputs, LengthBasis& basis)
      : panels_(panels), inputs_(inputs), basis_(basis), supports_(panels.size()), state_(panels.size(), State::open) {
    for (std::size_t i = 0; i < basis.deviations.size(); ++i) {
      const std::size_t anchor = basis.deviations.anchors[i];
      measured_.insert(anchor);
      if (inputs.anchors[anchor].is_sill) sills_.emplace_back(anchor, i);
    }
    for (std::size_t i = 0; i < panels.size(); ++i) judged_[&panels[i].panel()] = i;
    for (const auto* list : {&inputs.panels, &inputs.loose})
      for (const PanelCase& panel : *list)
        all_.push_back({&panel, panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high)),
                        0.5 * (panel.high - panel.low).norm()});
  }

  std::vector<Support> find() {
    for (std::size_t i = 0; i < panels_.size(); ++i) resolve(i);
    return std::move(supports_);
  }

 private:
  enum class State { open, asked, done };
  struct Place {
    const PanelCase* panel;
    Eigen::Vector3d centre;
    double reach;
  };

  void resolve(std::size_t i) {
    if (state_[i] != State::open) return;
    state_[i] = State::asked;
    JudgedPanel& panel = panels_[i];
    PanelSupportT& told = supports_[i].told;
    told.place.setConstant(nan);
    // What it cannot do without an anchor it cannot hand on either.
    supports_[i].doubt = doubt_of_anchors(panel.panel());
    if (panel.panel().held_below && panel.is_in_line()) hold(i, *panel.panel().held_below);
    state_[i] = State::done;
  }

  void hold(std::size_t i, const StackJoint& joint) {
    const JudgedPanel& panel = panels_[i];
    const std::vector<SillPoint> sill = sill_of(panel);
    const std::vector<Below> below = sill.empty() ? below_of(panel) : std::vector<Below>();
    PanelSupportT& told = supports_[i].told;
    told.by = "unknown";
    if (!sill.empty())
      stand_on_sill(i, joint, sill);
    else if (below.size() == 1)
      stand_on_panel(i, joint, below.front());
    else if (below.size() > 1)
      told.why = more_than_one(below);
    else if (const std::string missed = missed_sill(panel); !missed.empty())
      told.why =
          "the place " + missed +
          " of a sill was measured near its bottom edge and is not of it (further than 0.3 m away, or on another "
          "side of the building): nothing is assumed instead";
    else if (std::isfinite(joint.sill_sigma))
      assume_sill(i, joint);
    else
      told.why =
          "no sill was measured below: its bottom edge is held there; name places of it with 'sills', or give the rule "
          "of held_below a sill_sigma";
  }

  /// Those of which its edge is the end, in its own directions.
  std::vector<Below> below_of(const JudgedPanel& panel) const {
    std::vector<Below> found;
    for (const Place& place : all_) {
      if (place.panel == &panel.panel() ||
          (place.centre - panel.centre()).norm() > place.reach + panel.reach() + kWidestJoint)
        continue;
      const ifc::FacadeFrame& faces = place.panel->facade;
      const double turn = faces.known() ? faces.out.dot(panel.axes().out) : 1;
      if (turn < kOneFacade) continue;
      const auto [low, high] = judgement::box_in(*place.panel, panel.axes());
      const double gap = panel.low.y() - high.y();
      const double set_back = std::abs((low.z() + high.z()) - (panel.low.z() + panel.high.z()));
      if (gap < -kOverlap || gap > kWidestJoint || set_back > most_set_back(turn, panel.high.x() - panel.low.x()))
        continue;
      const double begin = std::max(low.x(), panel.low.x()), end = std::min(high.x(), panel.high.x());
      if (end - begin > kLeastCommon) found.push_back({place.panel, begin, end, panel.low.y() - 0.5 * gap});
    }
    return found;
  }

  static std::string more_than_one(const std::vector<Below>& below) {
    std::vector<std::string> names;
    for (const Below& one : below) names.push_back(name_of(*one.panel));
    return "more than one panel is below, " + list_of(names, 4) + ": which of them holds its bottom edge is not known";
  }

  void stand_on_panel(std::size_t i, const StackJoint& joint, const Below& below) {
    PanelSupportT& told = supports_[i].told;
    const std::string name = name_of(*below.panel);
    told.panel = below.panel->guid, told.name = name;
    const double width = panels_[i].high.x() - panels_[i].low.x();
    if (below.end - below.begin < 0.5 * width) {
      told.why =
          fmt::format("panel {} is below {:.2f} m of its {:.2f} m alone: what else holds its bottom edge is not known",
                      name, below.end - below.begin, width);
      return;
    }
    told.why = "its bottom edge is held by panel " + name + ", and how far out the top edge of that is is not known";
    const auto carrying = judged_.find(below.panel);
    if (carrying == judged_.end()) return;
    resolve(carrying->second);
    if (state_[carrying->second] != State::done) return;  // each below the other
    const JudgedPanel& carrier = panels_[carrying->second];
    Seat seat{edge_of(panels_[i], below.begin, below.end, below.height), {}, {}};
    for (auto [end, place] : {std::pair{&seat.left, &seat.edge.left}, {&seat.right, &seat.edge.right}}) {
      const Eigen::RowVectorXd row = carrier.movement(*place, seat.edge.out);
      if (row.size() == 0) return;
      *end = carrier.in_full(row);
    }
    const std::string& doubt = supports_[carrying->second].doubt;
    if (!doubt.empty()) supports_[i].doubt = doubt;
    sit(i, "panel", joint.sigma, std::move(seat));
  }

  void stand_on_sill(std::size_t i, const StackJoint& joint, const std::vector<SillPoint>& points) {
    PanelSupportT& told = supports_[i].told;
    const JudgedPanel& panel = panels_[i];
    const double middle = 0.5 * (panel.low.x() + panel.high.x());
    double least = points.front().along, most = least, nearest = std::abs(least - middle), mean = 0;
    for (const SillPoint& point : points) {
      told.sills.push_back(inputs_.anchors[point.anchor].id);
      least = std::min(least, point.along), most = std::max(most, point.along);
      nearest = std::min(nearest, std::abs(point.along - middle));
      mean += point.along / static_cast<double>(points.size());
    }
    if (nearest > kPanelReach && (least > middle || most < middle)) {
      told.why = "its sill was measured on one side of its middle alone, at " + list_of(told.sills, 4) +
                 ": measure it on the other side, too";
      return;
    }
    double spread = 0;
    for (const SillPoint& point : points) spread += (point.along - mean) * (point.along - mean);
    Seat seat{edge_of(panel, panel.low.x(), panel.high.x(), panel.low.y()), {}, {}};
    seat.tells_turn = most - least > 0.5 * (panel.high.x() - panel.low.x());
    for (const SillPoint& point : points) {
      // The straight line through them; of places close together, their mean.
      const auto weight = [&](double at) {
        const double slope = spread > 0.01 ? (at - mean) * (point.along - mean) / spread : 0;
        return 1 / static_cast<double>(points.size()) + slope;
      };
      told.weights.push_back(weight(middle));
      seat.left.anchors[point.position] = weight(panel.low.x()) * seat.edge.out.transpose();
      seat.right.anchors[point.position] = weight(panel.high.x()) * seat.edge.out.transpose();
    }
    sit(i, "sill", joint.sigma, std::move(seat));
  }

  void assume_sill(std::size_t i, const StackJoint& joint) {
    const JudgedPanel& panel = panels_[i];
    Seat seat{edge_of(panel, panel.low.x(), panel.high.x(), panel.low.y()), {}, {}, false};
    sit(i, "assumed_sill", std::hypot(joint.sigma, joint.sill_sigma), std::move(seat));
    supports_[i].told.sill_sigma = joint.sill_sigma;
  }

  /// `sigma`: what the joint adds at both ends alike [m].
  void sit(std::size_t i, const char* by, double sigma, Seat seat) {
    JudgedPanel& panel = panels_[i];
    PanelSupportT& told = supports_[i].told;
    if (sigma > 0) {
      seat.left.unmeasured[basis_.variances.size()] = seat.right.unmeasured[basis_.variances.size()] = 1;
      basis_.variances.push_back(sigma * sigma);
    }
    const Eigen::Vector3d top = panel.at(0.5 * (panel.low.x() + panel.high.x()), panel.high.y(), panel.high.z());
    const std::optional<double> handed_on = panel.hold(seat, basis_, top);
    if (!handed_on) {
      told.why = "what holds its bottom edge is on the line of its anchors and does not tell how it is turned about it";
      return;
    }
    LinearLength middle;
    middle.add(seat.left, 0.5), middle.add(seat.right, 0.5);
    told.by = by, told.why.clear(), told.sigma = sigma, told.handed_on = *handed_on;
    told.place = 0.5 * (seat.edge.left + seat.edge.right);
    told.out_of_plane = basis_.value(middle);
    const double variance = basis_.covariance(middle, middle);
    told.u = std::isnan(variance) ? nan : std::sqrt(std::max(0.0, variance));
  }

  static HeldEdge edge_of(const JudgedPanel& panel, double begin, double end, double height) {
    const double face = 0.5 * (panel.low.z() + panel.high.z());
    return {panel.at(begin, height, face), panel.at(end, height, face), panel.axes().out};
  }

  double distance_from_edge(const JudgedPanel& panel, const AnchorCase& anchor, double& along) const {
    const Eigen::Vector3d low = panel.low, high(panel.high.x(), panel.low.y(), panel.high.z());
    const ifc::FacadeFrame& axes = panel.axes();
    const Eigen::Vector3d at = anchor.design - anchor.target_offset;
    const Eigen::Vector3d seen(axes.right.dot(at), axes.up.dot(at), axes.out.dot(at));
    along = seen.x();
    return distance_from_box(low, high, seen);
  }

  /// Measured places of a sill within reach of its bottom edge.
  std::vector<SillPoint> sill_of(const JudgedPanel& panel) const {
    std::vector<SillPoint> points;
    for (const auto& [a, position] : sills_) {
      const AnchorCase& anchor = inputs_.anchors[a];
      if (anchor.facade.known() && anchor.facade.out.dot(panel.axes().out) < kOneFacade) continue;
      double along = 0;
      if (distance_from_edge(panel, anchor, along) <= kPanelReach) points.push_back({a, position, along});
    }
    return points;
  }

  /// One that somebody may have meant for it: within twice the reach, whichever way it faces.
  std::string missed_sill(const JudgedPanel& panel) const {
    double along = 0;
    for (const auto& [a, position] : sills_)
      if (distance_from_edge(panel, inputs_.anchors[a], along) <= 2 * kPanelReach) return inputs_.anchors[a].id;
    return {};
  }

  std::string doubt_of_anchors(const PanelCase& panel) const {
    for (const std::size_t anchor : panel.anchors)
      if (!measured_.contains(anchor))
        return "its bottom edge is held by way of panel " + name_of(panel) + ", of which anchor " +
               inputs_.anchors[anchor].id + " was not measured";
    return {};
  }

  std::vector<JudgedPanel>& panels_;
  const DeviationInputs& inputs_;
  LengthBasis& basis_;
  std::vector<Support> supports_;
  std::vector<State> state_;
  std::vector<Place> all_;
  std::set<std::size_t> measured_;                          // anchors
  std::vector<std::pair<std::size_t, std::size_t>> sills_;  // anchors, and where they are among the deviations
  std::map<const PanelCase*, std::size_t> judged_;          // of a panel among those that are judged
};

}  // namespace

std::vector<Support> hold_panels(std::vector<JudgedPanel>& panels, const DeviationInputs& inputs, LengthBasis& basis) {
  return Stack(panels, inputs, basis).find();
}

std::vector<std::string> support_warnings(const std::vector<std::unique_ptr<PanelDeviationT>>& panels) {
  std::vector<std::string> assumed, growing, warnings;
  std::map<std::string, const PanelDeviationT*> by_guid;
  double sigma = 0, most = 0;
  for (const auto& panel : panels) by_guid[panel->guid] = panel.get();
  for (const auto& panel : panels) {
    if (!panel->below) continue;
    if (panel->below->by == "assumed_sill")
      assumed.push_back(panel->name.empty() ? panel->guid : panel->name), sigma = std::max(sigma, panel->below->sigma);
    // Of a panel that carries another alone.
    const auto carrier = panel->below->by == "panel" ? by_guid.find(panel->below->panel) : by_guid.end();
    if (carrier == by_guid.end() || !carrier->second->below) continue;
    const double handed_on = std::abs(carrier->second->below->handed_on);
    if (!(handed_on >= 1)) continue;
    growing.push_back(carrier->second->name.empty() ? carrier->second->guid : carrier->second->name);
    most = std::max(most, handed_on);
  }
  if (!assumed.empty())
    warnings.push_back(
        fmt::format("The sill below {} was not measured: it is taken to be in place to {:.1f} mm "
                    "(standard deviation, with that of the joint), which nothing here measures.",
                    list_of(assumed, 4), 1e3 * sigma));
  if (!growing.empty())
    warnings.push_back(
        fmt::format("The brackets of {} are not above their mid-height: what a bottom edge is off by its "
                    "top edge is off by up to {:.1f} times, so that errors grow from floor to floor.",
                    list_of(growing, 4), most));
  return warnings;
}

}  // namespace plumbline::judgement
