#include "build/loop/facade_input.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "base/text/bare_name.hpp"
#include "base/text/words.hpp"
#include "build/loop/panel_limits.hpp"
#include "build/loop/panel_order.hpp"
#include "building/ifc/rule_use.hpp"
#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/packed_symmetric.hpp"
#include "geometry/panel_fit.hpp"
#include "loop/state/plan_artifact.hpp"

namespace plumbline::loop {
namespace {

std::string trimmed(const std::string& text) {
  const auto from = text.find_first_not_of(" \t"), to = text.find_last_not_of(" \t");
  return from == std::string::npos ? std::string() : text.substr(from, to - from + 1);
}

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

/// Rules of brackets or hooks. Of one that holds nowhere nobody could see that another was planned with.
template <typename Rule>
class AppliedRules {
 public:
  explicit AppliedRules(const std::vector<Rule>& rules) : rules_(rules), use_(rules.size()) {}

  void apply(const ifc::ElementFacts& anchor) {
    const std::vector<std::size_t> rules = ifc::selecting(rules_, anchor);
    use_.select(rules, anchor.guid.empty() ? anchor.name : anchor.guid);
    use_.apply(rules, ifc::last_of(rules));
  }

  /// A place of a sill is no bracket: nothing is set there, and a rule for it alone does no harm.
  void let(const ifc::ElementFacts& sill) {
    for (const std::size_t i : ifc::selecting(rules_, sill)) of_sills_.insert(i);
  }

  /// Throws std::runtime_error with all of them.
  void refuse_idle(const std::string& parameter) const {
    const std::vector<std::string> texts = ifc::texts_of(rules_);
    std::string idle;
    const auto refuse = [&](const std::string& text) { idle += (idle.empty() ? "" : "\n") + text; };
    const std::string nothing = "it selects no bracket";
    for (std::size_t i = 0; i < rules_.size(); ++i)
      if (const std::string why = use_.not_applied(i, texts, "anchors", nothing);
          !why.empty() && !(why == nothing && of_sills_.contains(i)))
        refuse("'" + parameter + "': rule '" + texts[i] + "': " + why);
    if (!idle.empty()) throw std::runtime_error(idle);
  }

 private:
  const std::vector<Rule>& rules_;
  ifc::RuleUse use_;
  std::set<std::size_t> of_sills_;
};

class Builder {
 public:
  Builder(const DeviationT& deviation, const DesignT& design, const LoopStateT* state, const FacadeRules& rules)
      : deviation_(deviation), state_(state), rules_(rules) {
    if (rules.normal.allFinite()) only_axes_ = facade_axes(rules.normal);
    for (const auto& element : design.elements) elements_[element->guid] = element.get();
    in_.facade.errors = rules.errors;
    for (const auto& panel : deviation.panels)
      if (panel->below) sills_.insert(panel->below->sills.begin(), panel->below->sills.end());
    // Also one that this campaign did not measure.
    if (state)
      for (const auto& item : state->items)
        if (!item->holds.empty()) sills_.insert(item->id);
    name_panels();
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

  void add_covariance(const PointsT& model, const std::vector<std::string>& control) {
    const std::size_t n = in_.facade.brackets.size();
    in_.facade.covariance = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(n), 3 * static_cast<Eigen::Index>(n));
    const Eigen::MatrixXd all = unpack_symmetric(model.covariance, 3 * model.points.size(), "the model");
    if (all.size() == 0 || !all.allFinite())
      throw std::runtime_error("the model has no covariance: without it nothing can be said of how a panel will hang");
    std::map<std::string, Eigen::Index> point;
    for (std::size_t i = 0; i < model.points.size(); ++i) point[model.points[i]->id] = static_cast<Eigen::Index>(i);
    std::vector<Eigen::Index> at(n, -1);
    for (std::size_t b = 0; b < n; ++b) {
      const auto found = point.find(in_.facade.brackets[b].id);
      if (found != point.end()) at[b] = found->second;
      if (in_.facade.brackets[b].measured() && at[b] < 0)
        throw std::runtime_error("anchor " + in_.facade.brackets[b].id +
                                 " was judged, but is no point of 'model'; connect the points that were judged");
    }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        if (at[i] >= 0 && at[j] >= 0)
          in_.facade.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j)) =
              all.block<3, 3>(3 * at[i], 3 * at[j]);
    add_own(all, point, at, control);
    // Where plates sit on their anchors is part of the judged covariance, and not of the model's.
    for (std::size_t b = 0; b < n; ++b)
      if (anchors_[b]->covariance.size() == 9)
        in_.facade.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(b), 3 * static_cast<Eigen::Index>(b)) =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(anchors_[b]->covariance.data());
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
    for (const auto& [guid, element] : elements_)
      if (element->is_panel && !id_of_.count(guid) && !wholes_.count(guid))
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
    wait_for_what_is_below();
    for (const auto& [panel, before] : rules_.after) add_dependence(panel, before);
  }

  void add_state() {
    if (state_) apply_state(in_.facade, *state_);
  }

  FacadeInput take() { return std::move(in_); }

 private:
  static void depend(Panel& panel, const std::string& before) {
    if (std::find(panel.depends_on.begin(), panel.depends_on.end(), before) == panel.depends_on.end())
      panel.depends_on.push_back(before);
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

  /// The covariance of the measured anchors if control were known: that of the readings alone. What is left is the same
  /// for all campaigns on that control, and a little more: control as it was adjusted with these readings.
  void add_own(const Eigen::MatrixXd& all, const std::map<std::string, Eigen::Index>& point,
               const std::vector<Eigen::Index>& at, const std::vector<std::string>& control) {
    std::vector<Eigen::Index> known, anchors;
    std::size_t found = 0;
    for (const std::string& id : control)
      if (const auto place = point.find(id); place != point.end()) {
        ++found, in_.control.push_back(id);
        for (Eigen::Index k = 0; k < 3; ++k) known.push_back(3 * place->second + k);
      }
    if (found == 0) return;
    for (const Eigen::Index place : at)
      for (Eigen::Index k = 0; k < 3; ++k) anchors.push_back(place < 0 ? 0 : 3 * place + k);
    const linear_algebra::SymmetricEigen of_control(all(known, known));
    const double largest = std::max(0.0, of_control.eigenvalues().maxCoeff());
    Eigen::MatrixXd across = all(anchors, known) * of_control.eigenvectors();
    for (std::size_t b = 0; b < at.size(); ++b)
      if (at[b] < 0) across.middleRows<3>(3 * static_cast<Eigen::Index>(b)).setZero();
    Eigen::MatrixXd own = in_.facade.covariance;
    for (Eigen::Index i = 0; i < across.cols(); ++i)
      if (const double value = of_control.eigenvalues()[i]; value > 1e-9 * largest && value > 0)
        own -= across.col(i) * across.col(i).transpose() / value;
    in_.facade.own = 0.5 * (own + own.transpose());
  }

  Eigen::Matrix3d axes_of(const FacadeFrameT* frame) const {
    return only_axes_.allFinite() ? only_axes_ : confirmed_axes(frame);
  }

  ifc::ElementFacts facts_of(const AnchorDeviationT& anchor) {
    ifc::ElementFacts facts;
    facts.ifc_class = anchor.class_, facts.guid = anchor.guid, facts.tag = anchor.tag;
    facts.name = anchor.name.empty() ? anchor.id : anchor.name;
    const auto element = elements_.find(anchor.guid);
    if (element == elements_.end()) return facts;
    facts.object_type = element->second->object_type, facts.type_name = element->second->type_name;
    facts.storey = element->second->storey;
    properties_.clear();
    for (const auto& p : element->second->properties)
      properties_.push_back({p->set, p->name, p->text, p->number, p->measure, p->lower, p->upper, p->holder});
    facts.properties = &properties_;
    return facts;
  }

  /// By its name where that is its own. Else as a round before named it, by its tag, or by its name and the anchor next
  /// to its lower left corner: a GlobalId tells nobody which panel to hang.
  void name_panels() {
    std::map<std::string, int> named, tagged;
    for (const auto& panel : deviation_.panels) {
      ++named[panel->name], ++tagged[tag_of(panel->guid)];
      judged_[panel->guid] = panel.get();
    }
    std::map<std::string, int> taken;
    for (const auto& panel : deviation_.panels) {
      std::string id = named[panel->name] == 1 ? panel->name : id_in_state(panel->guid);
      if (id.empty() && tagged[tag_of(panel->guid)] == 1) id = tag_of(panel->guid);
      if (id.empty()) id = name_by_anchor(*panel);
      ++taken[id_of_[panel->guid] = id];
    }
    for (auto& [guid, id] : id_of_)
      if (id.empty() || taken[id] > 1) id = guid;
    for (const auto& [guid, element] : elements_)
      if (element->is_panel) wholes_.insert(element->parent_guid);
  }

  std::string tag_of(const std::string& guid) const {
    const auto element = elements_.find(guid);
    return element == elements_.end() ? "" : element->second->tag;
  }

  /// Of a panel with this GlobalId in the state of the round before; empty: there is none.
  std::string id_in_state(const std::string& guid) const {
    if (state_)
      for (const auto& item : state_->items)
        if (item->kind == "panel" && item->guid == guid) return item->id;
    return {};
  }

  /// "Panel at F1-C1-R1"; empty where no anchor of it has a place.
  std::string name_by_anchor(const PanelDeviationT& panel) const {
    const auto corner = std::find_if(panel.corners.begin(), panel.corners.end(),
                                     [](const auto& one) { return one->name == "bottom_left"; });
    if (corner == panel.corners.end()) return {};
    std::string nearest;
    double least = std::numeric_limits<double>::infinity();
    const std::vector<std::string> own = anchors_of(panel);
    for (const auto& anchor : deviation_.anchors)
      if (const double off = (anchor->design - (*corner)->design).norm();
          off < least && std::find(own.begin(), own.end(), anchor->id) != own.end())
        least = off, nearest = anchor->id;
    if (nearest.empty()) return {};
    return (panel.name.empty() ? std::string("panel") : panel.name) + " at " + nearest;
  }

  static std::vector<std::string> anchors_of(const PanelDeviationT& judged) {
    std::vector<std::string> ids;
    for (const auto& fixing : judged.fixings) ids.push_back(fixing->anchor);
    ids.insert(ids.end(), judged.missing.begin(), judged.missing.end());
    return ids;
  }

  /// Brackets at a panel of the design that is not planned, because nobody measured an anchor of it or two are at one
  /// place: they are needed, though not by this plan.
  void find_unplanned() {
    std::vector<const DesignElementT*> left_out;
    for (const auto& [guid, element] : elements_)
      if (element->is_panel && !panel_at_.count(guid) && !wholes_.count(guid)) left_out.push_back(element);
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

  /// A panel waits for the next ones below, whatever is between; for those too of which no anchor was measured, and
  /// which are no panels of the facade.
  void wait_for_what_is_below() {
    std::vector<PanelPlace> places;
    for (const Panel& panel : in_.facade.panels)
      places.push_back({panel.id, {panel.corners.begin(), panel.corners.end()}});
    const std::size_t planned = places.size();
    check_standing();
    const std::vector<const DesignElementT*> unplanned = unplanned_panels();
    for (const DesignElementT* element : unplanned) places.push_back({id_of_unplanned(*element), box_of(*element)});
    std::vector<std::vector<std::string>> above(unplanned.size());
    for (Panel& panel : in_.facade.panels)
      for (const std::size_t below : next_below(panel, places)) {
        if (is_said_to_come_after(places[below].id, panel.id) ||
            (below >= planned && is_said_to_stand(*unplanned[below - planned])))
          continue;
        depend(panel, places[below].id);
        if (below >= planned) above[below - planned].push_back(panel.id);
      }
    for (std::size_t i = 0; i < unplanned.size(); ++i)
      if (!above[i].empty())
        in_.notes.push_back("panel " + places[planned + i].id + " is not planned and is below " +
                            text::join(above[i], 8) +
                            ": wait for it, unless a round before saw it hang or standing=['" + unplanned[i]->name +
                            "'] says that it does");
  }

  /// Who hangs from the top downward says so, and no joint contradicts it.
  bool is_said_to_come_after(const std::string& panel, const std::string& other) const {
    const auto rule = rules_.after.find(panel);
    return rule != rules_.after.end() &&
           std::find(rule->second.begin(), rule->second.end(), other) != rule->second.end();
  }

  void check_standing() const {
    for (const std::string& name : rules_.standing)
      if (name != "*" && std::none_of(elements_.begin(), elements_.end(), [&](const auto& element) {
            return element.second->is_panel && wholes_.count(element.first) == 0 && element.second->name == name;
          }))
        throw std::runtime_error("'standing' names '" + name + "', which is no panel of the design");
  }

  bool is_said_to_stand(const DesignElementT& panel) const {
    return std::any_of(rules_.standing.begin(), rules_.standing.end(),
                       [&](const std::string& name) { return name == "*" || name == panel.name; });
  }

  /// Panels of the design with a place that are not planned.
  std::vector<const DesignElementT*> unplanned_panels() const {
    std::vector<const DesignElementT*> out;
    for (const auto& [guid, element] : elements_)
      if (element->is_panel && wholes_.count(guid) == 0 && panel_at_.count(guid) == 0 && element->box_low.allFinite() &&
          element->box_high.allFinite())
        out.push_back(element);
    return out;
  }

  static std::vector<Eigen::Vector3d> box_of(const DesignElementT& element) {
    std::vector<Eigen::Vector3d> corners;
    for (int corner = 0; corner < 8; ++corner)
      corners.push_back(element.placement * Eigen::Vector3d((corner & 1 ? element.box_high : element.box_low).x(),
                                                            (corner & 2 ? element.box_high : element.box_low).y(),
                                                            (corner & 4 ? element.box_high : element.box_low).z()));
    return corners;
  }

  /// As a round before has named it.
  std::string id_of_unplanned(const DesignElementT& element) const {
    if (const std::string known = id_in_state(element.guid); !known.empty()) return known;
    const auto& planned = in_.facade.panels;
    const bool is_taken =
        std::any_of(planned.begin(), planned.end(), [&](const Panel& panel) { return panel.id == element.name; }) ||
        std::any_of(elements_.begin(), elements_.end(), [&](const auto& other) {
          return other.first != element.guid && other.second->is_panel && other.second->name == element.name &&
                 wholes_.count(other.first) == 0;
        });
    return element.name.empty() || is_taken ? element.guid : element.name;
  }

  void add_dependence(const std::string& panel, const std::vector<std::string>& before) {
    const auto find = [&](const std::string& id) {
      const auto at =
          std::find_if(in_.facade.panels.begin(), in_.facade.panels.end(), [&](const Panel& p) { return p.id == id; });
      if (at == in_.facade.panels.end())
        throw std::runtime_error("'after' names panel '" + id + "', which is none of the " +
                                 std::to_string(in_.facade.panels.size()) + " panels with measured anchors");
      return at;
    };
    for (const std::string& id : before) find(panel)->depends_on.push_back(find(id)->id);
  }

  const DeviationT& deviation_;
  const LoopStateT* state_;
  const FacadeRules& rules_;
  Eigen::Matrix3d only_axes_ = Eigen::Matrix3d::Constant(kUnknown);  ///< that the user said; nan: each has its own
  FacadeInput in_;
  std::vector<const AnchorDeviationT*> anchors_;  ///< by bracket
  std::map<std::string, const DesignElementT*> elements_;
  std::map<std::string, std::size_t> bracket_at_, panel_at_;  ///< by anchor id, by GlobalId
  std::map<std::string, const PanelDeviationT*> judged_;      ///< by GlobalId
  std::map<std::string, std::string> id_of_;
  std::set<std::string> wholes_, sills_;  ///< sills_: ids of anchors
  std::vector<ifc::Property> properties_;
};

}  // namespace

std::pair<std::string, std::vector<std::string>> parse_dependence(const std::string& text) {
  const auto word = text.find(" after ");
  std::pair<std::string, std::vector<std::string>> out;
  if (word != std::string::npos) {
    out.first = trimmed(text.substr(0, word));
    for (std::size_t from = word + 7; from <= text.size();) {
      const std::size_t comma = std::min(text.find(',', from), text.size());
      if (const std::string id = trimmed(text.substr(from, comma - from)); !id.empty()) out.second.push_back(id);
      from = comma + 1;
    }
  }
  if (out.first.empty() || out.second.empty())
    throw std::runtime_error("dependence '" + text + "': expected 'PANEL after PANEL, PANEL'");
  return out;
}

FacadeInput facade_of(const DeviationT& deviation, const PointsT& model, const DesignT& design, const LoopStateT* state,
                      const FacadeRules& rules, const std::vector<std::string>& control) {
  Builder builder(deviation, design, state, rules);
  builder.add_brackets();
  builder.add_covariance(model, control);
  builder.add_panels();
  builder.add_supports();
  builder.add_joints();
  builder.add_state();
  return builder.take();
}

}  // namespace plumbline::loop
