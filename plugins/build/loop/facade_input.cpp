#include "build/loop/facade_input.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "base/text/bare_name.hpp"
#include "base/text/words.hpp"
#include "build/loop/applied_rules.hpp"
#include "build/loop/bracket_covariance.hpp"
#include "build/loop/design_elements.hpp"
#include "build/loop/panel_limits.hpp"
#include "build/loop/panel_names.hpp"
#include "build/loop/panel_waits.hpp"
#include "geometry/panel_fit.hpp"
#include "loop/state/plan_artifact.hpp"

namespace plumbline::loop {
namespace {

/// Right, up, out of an anchor or panel; nan where nothing says which way it faces, or nothing that orders may rest on.
Eigen::Matrix3d confirmed_axes(const FacadeFrameT* frame) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Constant(kUnknown);
  if (frame && frame->confirmed) axes << frame->right, frame->up, frame->out;
  return axes;
}

/// Why the axes of none of them can be told.
std::string unconfirmed_words(const DeviationT& deviation) {
  std::string words = "which way the anchors face is not confirmed, so nobody can be told to move one to the right";
  for (const auto& facade : deviation.facades)
    if (!facade->confirmed) words += "; facade " + facade->name + ": " + facade->note;
  return words + "; say it with facade_normal, or in the rules of facades";
}

class Builder {
 public:
  Builder(const DeviationT& deviation, const DesignT& design, const LoopStateT* state, const FacadeRules& rules)
      : deviation_(deviation),
        design_(design),
        state_(state),
        rules_(rules),
        elements_(design),
        id_of_(names_of_panels(deviation, elements_, state)) {
    if (rules.normal.allFinite()) only_axes_ = facade_axes(rules.normal);
    refuse_other_direction();
    in_.facade.errors = rules.errors;
    for (const auto& panel : deviation.panels)
      if (panel->below) sills_.insert(panel->below->sills.begin(), panel->below->sills.end());
    // Also one that this campaign did not measure.
    if (state)
      for (const auto& item : state->items)
        if (!item->holds.empty()) sills_.insert(item->id);
    for (const auto& panel : deviation.panels) judged_[panel->guid] = panel.get();
  }

  void add_brackets() {
    std::vector<std::string> unknown;
    std::size_t facing = 0;
    AppliedRules of_brackets(rules_.brackets);
    AppliedRules of_hooks(rules_.hooks);
    for (const auto& anchor : deviation_.anchors) {
      if (!anchor->design.allFinite()) {
        in_.notes.push_back("anchor " + anchor->id + " has no place in the design: it is no bracket of any panel");
        continue;
      }
      Bracket bracket;
      bracket.id = anchor->id, bracket.floor = anchor->floor, bracket.axes = axes_of(anchor->facade.get());
      bracket.design = anchor->design, bracket.deviation = anchor->deviation;
      facing += bracket.axes.allFinite();
      if (!bracket.axes.allFinite()) {
        in_.notes.push_back("anchor " + anchor->id + ": which way it faces is not confirmed" +
                            (anchor->facade && !anchor->facade->note.empty() ? " (" + anchor->facade->note + ")" : "") +
                            "; no setting is planned for it, and its panels wait");
        bracket.axes.setIdentity(), bracket.deviation.setConstant(kUnknown);
      }
      bracket.is_sill = sills_.contains(anchor->id);
      const std::optional<BracketType> type =
          bracket.is_sill ? BracketType() : bracket_type_of(rules_.brackets, facts_of(*anchor));
      if (bracket.is_sill)
        of_brackets.let(facts_of(*anchor)), of_hooks.let(facts_of(*anchor));
      else
        of_brackets.apply(facts_of(*anchor)), of_hooks.apply(facts_of(*anchor));
      if (!type) unknown.push_back(anchor->id + " (" + anchor->class_ + ")");
      if (type) bracket.type = *type;
      bracket_at_[anchor->id] = in_.facade.brackets.size();
      anchors_.push_back(anchor.get());
      in_.guids.push_back(anchor->guid);
      in_.facade.brackets.push_back(std::move(bracket));
    }
    tell_names_alike();
    if (facing == 0) throw std::runtime_error(unconfirmed_words(deviation_));
    of_brackets.refuse_idle("brackets"), of_hooks.refuse_idle("hooks");
    if (!unknown.empty())
      throw std::runtime_error("no rule of 'brackets' selects " + text::join(unknown, 8) +
                               "; say what they can be set by, such as '*: right=20mm, up=15mm, out=25mm'");
  }

  void add_covariances(const PointsT& model, const std::vector<std::string>& control) {
    add_covariance(model, anchors_, control, in_);
  }

  void add_panels() {
    for (const auto& judged : deviation_.panels) {
      Panel panel;
      panel.id = id_of_.at(judged->guid), panel.name = judged->name, panel.floor = judged->floor;
      panel.axes = axes_of(judged->facade.get());
      if (!panel.axes.allFinite()) {
        in_.notes.push_back("panel " + panel.id + ": which way it faces is not confirmed: it is not planned");
        for (const std::string& id : anchors_of(*judged))
          if (const auto at = bracket_at_.find(id); at != bracket_at_.end())
            in_.facade.brackets[at->second].holds_unplanned = true;
        continue;
      }
      for (const auto& corner : judged->corners) {
        const std::size_t k = corner->name == "bottom_left"    ? 0
                              : corner->name == "bottom_right" ? 1
                              : corner->name == "top_left"     ? 2
                                                               : 3;
        panel.corners[k] = corner->design;
      }
      panel.centre = 0.25 * (panel.corners[0] + panel.corners[1] + panel.corners[2] + panel.corners[3]);
      panel.limits = limits_of(*judged), panel.open = not_judged_of(deviation_, *judged);
      if (panel.open.empty()) panel.open = twisted_edge_of(*judged);
      add_hooks(*judged, panel);
      panel_at_[judged->guid] = in_.facade.panels.size();
      in_.panel_guids.push_back(judged->guid);
      in_.facade.panels.push_back(std::move(panel));
    }
    find_panels_without_plan();
    for (const auto& [guid, element] : elements_.by_guid)
      if (elements_.is_panel(*element) && !id_of_.count(guid) && !is_to_hang(guid))
        in_.notes.push_back("panel " + (element->name.empty() ? guid : element->name) +
                            " of the design hangs on no measured anchor: it is not planned");
    for (const auto& request : deviation_.requests)
      if (!request->not_judged.empty() && request->panels > 0)
        in_.notes.push_back("not judged: " + request->asked + ": " + request->not_judged);
    find_unplanned();
  }

  /// What holds bottom edges, as the judgement found it. Who stands on another hangs after it, on whichever of their
  /// joint is judged.
  void add_supports() {
    for (const auto& judged : deviation_.panels) {
      const auto at = panel_at_.find(judged->guid);
      if (!judged->below || at == panel_at_.end()) continue;
      const PanelSupportT& said = *judged->below;
      Panel& panel = in_.facade.panels[at->second];
      if (said.by == "unknown") {
        panel.below_unknown = said.why;
        continue;
      }
      // An older judgement does not say it.
      const double sill_sigma = said.sill_sigma >= 0 ? said.sill_sigma : said.sigma;
      Support support{-1, {}, said.place, said.sigma, sill_sigma};
      if (said.by == "panel") {
        const auto carrier = panel_at_.find(said.panel);
        if (carrier == panel_at_.end()) {
          panel.below_unknown = "its bottom edge is held by panel " + said.name + ", which is not planned";
          continue;
        }
        support.panel = static_cast<int>(carrier->second);
        depend(panel, in_.facade.panels[carrier->second].id);
      }
      for (std::size_t i = 0; i < said.sills.size() && i < said.weights.size(); ++i)
        support.sills.emplace_back(bracket_at_.at(said.sills[i]), said.weights[i]);
      panel.below = std::move(support);
    }
  }

  void add_joints() {
    for (const auto& judged : deviation_.panels)
      for (const auto& said : judged->joints) {
        const bool upward = said->side == "above";
        if (!panel_at_.count(judged->guid)) continue;
        if ((!upward && said->side != "right") || !panel_at_.count(said->panel)) continue;
        const std::size_t a = panel_at_.at(judged->guid), b = panel_at_.at(said->panel);
        if (upward) depend(in_.facade.panels[b], in_.facade.panels[a].id);
        const JointLimits limits = joint_limits(*judged, *said, judged_.at(said->panel));
        if (!(limits.wider + limits.narrower > 0)) continue;
        in_.facade.joints.push_back(joint_of(a, b, upward, said->design, limits));
      }
    wait_for_what_is_below(rules_, elements_, panel_at_, state_, in_);
    for (const auto& [panel, before] : rules_.after) add_dependence(panel, before, in_.facade.panels);
  }

  void add_state() {
    if (state_) apply_state(in_.facade, *state_);
  }

  FacadeInput take() { return std::move(in_); }

 private:
  /// facade_normal is for facades of which nobody knows; where the judgement does, another direction sends people and
  /// robots the wrong way.
  void refuse_other_direction() const {
    if (!only_axes_.allFinite()) return;
    constexpr double kCosine = 0.7071;  // 45 degrees: beyond, right is nearer to out than to right
    std::vector<std::string> against;
    const FacadeFrameT* known = nullptr;
    const auto look = [&](const FacadeFrameT* frame, const std::string& name) {
      if (!frame || !frame->confirmed || frame->out.dot(only_axes_.col(2)) >= kCosine) return;
      against.push_back(name), known = known ? known : frame;
    };
    for (const auto& anchor : deviation_.anchors) look(anchor->facade.get(), anchor->id);
    for (const auto& panel : deviation_.panels) look(panel->facade.get(), panel->name);
    if (against.empty()) return;
    const auto words = [](const Eigen::Vector3d& v) {
      return fmt::format("({:.2f}, {:.2f}, {:.2f})", v.x(), v.y(), v.z());
    };
    throw std::runtime_error("facade_normal says that all of it faces " + words(only_axes_.col(2)) + ", and " +
                             text::join(against, 4) + " " + (against.size() > 1 ? "face " : "faces ") +
                             words(known->out) + " (facade " + known->facade +
                             ", confirmed): they would be set the wrong way; leave facade_normal out, or mend the "
                             "design or the rules of facades");
  }

  /// Reports tell them apart; a person, or a tool that makes no difference between F and f, may not.
  void tell_names_alike() {
    std::map<std::string, std::string> known;
    for (const Bracket& bracket : in_.facade.brackets)
      if (const auto [at, is_new] = known.try_emplace(text::bare_name(bracket.id), bracket.id); !is_new)
        in_.notes.push_back("brackets " + at->second + " and " + bracket.id +
                            " have one name but for case, separators or leading zeros: who sets them may take one for "
                            "the other; give one of them another name");
  }

  Eigen::Matrix3d axes_of(const FacadeFrameT* frame) const {
    return only_axes_.allFinite() ? only_axes_ : confirmed_axes(frame);
  }

  ifc::ElementFacts facts_of(const AnchorDeviationT& anchor) {
    ifc::ElementFacts facts;
    facts.ifc_class = anchor.class_, facts.guid = anchor.guid, facts.tag = anchor.tag;
    facts.name = anchor.name.empty() ? anchor.id : anchor.name;
    const DesignElementT* element = elements_.find(anchor.guid);
    if (!element) return facts;
    facts.object_type = element->object_type, facts.type_name = element->type_name;
    facts.storey = element->storey;
    properties_.clear();
    for (const auto& p : element->properties)
      properties_.push_back({p->set, p->name, p->text, p->number, p->measure, p->lower, p->upper, p->holder});
    facts.properties = &properties_;
    return facts;
  }

  /// Work that this plan does not have: told, counted and waited for, until it hangs.
  void find_panels_without_plan() {
    const UnmeasuredDesign unmeasured(design_, in_.facade.brackets, in_.guids);
    for (const auto& [guid, element] : elements_.by_guid) {
      if (!elements_.is_panel(*element) || panel_at_.count(guid)) continue;
      const std::string& name = element->name;
      const bool is_said_to_stand = std::any_of(rules_.standing.begin(), rules_.standing.end(),
                                                [&](const std::string& one) { return one == "*" || one == name; });
      if (is_said_to_stand || is_known_otherwise(guid)) continue;
      const auto judged = id_of_.find(guid);
      const bool is_judged = judged != id_of_.end();
      in_.unplanned.push_back(
          {is_judged ? judged->second : name_of_unplanned(*element, elements_, state_, in_.facade.panels), guid,
           unmeasured.floor_of(*element), element->position,
           is_judged ? "which way it faces is not confirmed: say it with plan.with.facade_normal, or in the rules of "
                       "facades"
                     : unmeasured.why_not_planned(*element)});
    }
    std::sort(in_.unplanned.begin(), in_.unplanned.end(),
              [](const UnplannedPanel& a, const UnplannedPanel& b) { return a.id < b.id; });
  }

  bool is_to_hang(const std::string& guid) const {
    return std::any_of(in_.unplanned.begin(), in_.unplanned.end(),
                       [&](const UnplannedPanel& panel) { return panel.guid == guid; });
  }

  /// A campaign that did not measure it says nothing of a panel that hangs or waits by a round before.
  bool is_known_otherwise(const std::string& guid) const {
    if (state_)
      for (const auto& item : state_->items)
        if (item->kind == "panel" && item->guid == guid)
          return item->hangs || item->status != ItemStatus::planned || item->reason != ItemReason::not_planned;
    return false;
  }

  /// Brackets at a panel of the design that is not planned, because nobody measured an anchor of it or two are at one
  /// place: they are needed, though not by this plan.
  void find_unplanned() {
    std::vector<const DesignElementT*> left_out;
    for (const auto& [guid, element] : elements_.by_guid)
      if (elements_.is_panel(*element) && !panel_at_.count(guid)) left_out.push_back(element);
    for (Bracket& bracket : in_.facade.brackets)
      for (const DesignElementT* panel : left_out) {
        const bool has_box = panel->box_low.allFinite() && panel->box_high.allFinite();
        const Eigen::Vector3d place = panel->placement.inverse() * bracket.design;
        if (!has_box || distance_from_box(panel->box_low, panel->box_high, place) <= kPanelReach)
          bracket.holds_unplanned = true;
      }
  }

  void add_hooks(const PanelDeviationT& judged, Panel& panel) {
    std::vector<Eigen::Vector3d> places;
    for (const std::string& id : anchors_of(judged))
      if (const auto at = bracket_at_.find(id); at != bracket_at_.end()) {
        panel.hooks.push_back({at->second, {}});
        places.push_back(in_.facade.brackets[at->second].design);
      }
    for (std::size_t i = 0; i < panel.hooks.size(); ++i) {
      panel.hooks[i].holds = usual_hook(places, i, panel.axes);
      for (const HookRule& rule : rules_.hooks)
        if (rule.selection.matches(facts_of(*anchors_[panel.hooks[i].bracket]))) panel.hooks[i].holds = rule.holds;
    }
  }

  Joint joint_of(std::size_t a, std::size_t b, bool upward, double width, const JointLimits& limits) const {
    const Panel &of_a = in_.facade.panels[a], &of_b = in_.facade.panels[b];
    Joint joint;
    joint.a = a, joint.b = b;
    joint.side_of_a = upward ? Side::top : Side::right, joint.side_of_b = upward ? Side::bottom : Side::left;
    const int across = upward ? 1 : 0, along = 1 - across;
    const Eigen::Matrix3d& axes = of_a.axes;
    joint.across = axes.col(across);
    const auto place = [&](const Eigen::Vector3d& p, int k) { return axes.col(k).dot(p); };
    const double begin = std::max(place(of_a.corners[0], along), place(of_b.corners[0], along));
    const double end = std::min(place(of_a.corners[3], along), place(of_b.corners[3], along));
    for (int which = 0; which < 2; ++which) {
      const double at = which == 0 ? begin : end;
      const auto edge = [&](const Eigen::Vector3d& corner) -> Eigen::Vector3d {
        return corner + (at - place(corner, along)) * axes.col(along);
      };
      joint.on_a[which] = edge(of_a.corners[3]);
      joint.on_b[which] = edge(of_b.corners[0]);
    }
    joint.nominal = width, joint.least = width - limits.narrower, joint.most = width + limits.wider;
    joint.step_most = rules_.step_tolerance > 0 ? rules_.step_tolerance : 0.5 * (limits.wider + limits.narrower);
    return joint;
  }

  const DeviationT& deviation_;
  const DesignT& design_;
  const LoopStateT* state_;
  const FacadeRules& rules_;
  DesignElements elements_;
  std::map<std::string, std::string> id_of_;                         ///< by GlobalId
  Eigen::Matrix3d only_axes_ = Eigen::Matrix3d::Constant(kUnknown);  ///< that the user said; nan: each has its own
  FacadeInput in_;
  std::vector<const AnchorDeviationT*> anchors_;              ///< by bracket
  std::map<std::string, std::size_t> bracket_at_, panel_at_;  ///< by anchor id, by GlobalId
  std::map<std::string, const PanelDeviationT*> judged_;      ///< by GlobalId
  std::set<std::string> sills_;                               ///< ids of anchors
  std::vector<ifc::Property> properties_;
};

}  // namespace

FacadeInput facade_of(const DeviationT& deviation, const PointsT& model, const DesignT& design, const LoopStateT* state,
                      const FacadeRules& rules, const std::vector<std::string>& control) {
  Builder builder(deviation, design, state, rules);
  builder.add_brackets();
  builder.add_covariances(model, control);
  builder.add_panels();
  builder.add_supports();
  builder.add_joints();
  builder.add_state();
  return builder.take();
}

}  // namespace plumbline::loop
