// A new plan on a new measurement: what was done is judged, what is in doubt is no longer verified, what is GO is
// released.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "loop/fit/facade.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/transitions.hpp"

namespace plumbline::loop {
namespace {

/// A bracket that is asked to move by less than this is left as it is [m].
constexpr double kDeadBand = 0.0003;

/// Back to planned with one more rework, or rejected after too many.
void do_again(LoopStateT& state, LoopItemT& item, const MachineOptions& options, const Because& because) {
  move(state, item, ItemStatus::rework, because);
  if (++item.reworks > options.most_reworks) {
    move(state, item, ItemStatus::rejected,
         {"after " + std::to_string(options.most_reworks) + " reworks: " + because.why, {}, {}, because.rests_on});
    return;
  }
  move(state, item, ItemStatus::planned, {"to be planned again: " + because.why, {}, {}, because.rests_on});
}

class Round {
 public:
  Round(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options)
      : state_(state), plan_(plan), options_(options), measured_again_(plan.basis != state.basis) {
    add_items();
    for (auto& item : state_.items) item_of_[item->kind + " " + item->id] = item.get();
    for (const auto& bracket : plan_.brackets) bracket_of_[bracket->id] = bracket.get();
    rests_on_ = {plan_.basis};
  }

  void run() {
    for (const int floor : floors_in_doubt()) moved_floors_.insert(floor);
    if (measured_again_) {
      moved_floors_.clear();
      verify_brackets();
      verify_panels();
      find_stale();
    }
    unset_what_does_not_do();
    release();
    state_.basis = plan_.basis;
  }

 private:
  LoopItemT* item(const std::string& kind, const std::string& id) const {
    const auto found = item_of_.find(kind + " " + id);
    return found == item_of_.end() ? nullptr : found->second;
  }

  /// Without a new measurement a floor that moved stays in doubt.
  std::set<int> floors_in_doubt() const {
    std::set<int> floors;
    for (const auto& item : state_.items)
      if (std::count(state_.moved_control.begin(), state_.moved_control.end(), control_of_floor(item->floor)) > 0)
        floors.insert(item->floor);
    return floors;
  }

  void add_items() {
    std::set<std::string> known;
    for (const auto& item : state_.items) known.insert(item->kind + " " + item->id);
    const auto add = [&](const std::string& kind, const std::string& id, int floor) {
      if (!known.insert(kind + " " + id).second) return;
      auto item = std::make_unique<LoopItemT>();
      item->id = id, item->kind = kind, item->floor = floor;
      item->setting.setZero(), item->pending.setZero(), item->expected.setConstant(kUnknown);
      state_.items.push_back(std::move(item));
    };
    for (const auto& bracket : plan_.brackets) add("bracket", bracket->id, bracket->floor);
    for (const auto& panel : plan_.panels) add("panel", panel->id, panel->floor);
  }

  void verify_brackets() {
    find_floors_that_moved();
    doubt_what_stands_on_moved_control();
    for (const auto& bracket : plan_.brackets) {
      LoopItemT& item = *this->item("bracket", bracket->id);
      if (moved_floors_.count(item.floor) || !bracket->measured.allFinite()) continue;
      const bool is_known = item.expected.allFinite(), was_planned = item.status == ItemStatus::planned;
      if (is_known)
        judge_bracket(item, *bracket);
      else
        look_again(item, *bracket);
      // What nobody touched keeps the place that it is judged by: small movements would add up unseen.
      if (item.status == ItemStatus::rejected || (item.status == ItemStatus::planned && !(is_known && was_planned)))
        item.expected = bracket->measured;
    }
  }

  void judge_bracket(LoopItemT& item, const BracketSettingT& bracket) {
    const Eigen::Vector3d shift = bracket.measured - place_of(item, bracket);
    const double off = shift.cwiseAbs().maxCoeff(), most = doubt_of(bracket).maxCoeff();
    const bool is_there = (shift.cwiseAbs().array() <= doubt_of(bracket).array()).all();
    if (item.status == ItemStatus::executed)
      judge_setting(item, bracket, off, is_there);
    else if (!is_there)
      give_to_a_person(item,
                       "moved by " + millimetres(off) +
                           " without a report that was taken: look whether the bracket was moved or its plate was "
                           "knocked");
    else if (item.status == ItemStatus::relocalised)
      verify(item, bracket, "within " + millimetres(most));
  }

  void verify(LoopItemT& item, const BracketSettingT& bracket, const std::string& why) {
    move(state_, item, ItemStatus::verified, {why, {}, {}, rests_on_});
    item.expected = bracket.measured, item.pending.setZero();
  }

  /// Measured for the first time, or for the first time since its control was found to be in order again: what carries
  /// a panel is where it is now, what was being set is planned anew.
  void look_again(LoopItemT& item, const BracketSettingT& bracket) {
    if (item.status == ItemStatus::executed)
      move(state_, item, ItemStatus::relocalised, {"measured on control that was looked at", {}, {}, rests_on_});
    if (item.status != ItemStatus::relocalised) return;
    if (carries(item.id)) {
      verify(item, bracket, "carries a panel, which is judged by where this bracket is now");
      return;
    }
    const Because because{"to be planned on control that was looked at", {}, {}, rests_on_};
    item.pending.setZero();
    move(state_, item, ItemStatus::rework, because), move(state_, item, ItemStatus::planned, because);
  }

  /// What a difference between two measurements must exceed to mean something: the tolerance, or four of its standard
  /// deviations. Each axis of the frame [m].
  Eigen::Vector3d doubt_of(const BracketSettingT& bracket) const {
    return (4 * std::sqrt(2.0) * bracket.sigma).cwiseMax(options_.setting_tolerance);
  }

  /// Along right, up, out [m].
  static Eigen::Vector3d along_axes(const BracketSettingT& bracket, const Eigen::Vector3d& v) {
    return {bracket.axes[0].dot(v), bracket.axes[1].dot(v), bracket.axes[2].dot(v)};
  }
  static Eigen::Vector3d from_axes(const BracketSettingT& bracket, const Eigen::Vector3d& v) {
    return v.x() * bracket.axes[0] + v.y() * bracket.axes[1] + v.z() * bracket.axes[2];
  }

  /// How a robot comes to move a bracket as it did, from where it stood when it was asked; empty if nothing explains
  /// it.
  static std::string explanation(const LoopItemT& item, const BracketSettingT& bracket, double most) {
    const Eigen::Vector3d moved = along_axes(bracket, bracket.measured - item.expected);
    const auto is = [&](double times) { return (moved - times * item.pending).cwiseAbs().maxCoeff() <= most; };
    return is(0) ? "it was not moved" : is(-1) ? "it was set the other way" : is(2) ? "it was set twice" : "";
  }

  /// A measurement of the plate does not tell a bracket that was set elsewhere from a plate that was knocked: only what
  /// a known mistake explains is done again without a person.
  void judge_setting(LoopItemT& item, const BracketSettingT& bracket, double off, bool is_there) {
    const double most = doubt_of(bracket).maxCoeff();
    move(state_, item, ItemStatus::relocalised,
         {"measured " + millimetres(off) + " from where it was to be", {}, {}, rests_on_});
    const std::string how = is_there ? "" : explanation(item, bracket, most);
    if (!is_there && how.empty()) {
      give_to_a_person(item,
                       "stands " + millimetres(off) +
                           " from where it was to be set, and no mistake of a robot explains it: look whether the "
                           "bracket slipped or its plate was knocked");
      return;
    }
    if (is_there) {
      verify(item, bracket, "within " + millimetres(most));
      return;
    }
    // What was reported is not what was done.
    item.setting += along_axes(bracket, bracket.measured - place_of(item, bracket));
    item.pending.setZero();
    do_again(state_, item, options_,
             {"stands " + millimetres(off) + " from where it was to be set: " + how, {}, {}, rests_on_});
  }

  /// Where the anchor of a bracket should be measured now: that a robot was asked does not move it, that it says so
  /// does.
  static Eigen::Vector3d place_of(const LoopItemT& item, const BracketSettingT& bracket) {
    const bool asked = item.status == ItemStatus::executed || item.status == ItemStatus::relocalised;
    return asked ? Eigen::Vector3d(item.expected + from_axes(bracket, item.pending)) : item.expected;
  }

  void give_to_a_person(LoopItemT& item, const std::string& why) {
    const Because because{why, {}, {}, rests_on_};
    reject(item, because);
    for (const auto& panel : plan_.panels)
      if (std::find(panel->brackets.begin(), panel->brackets.end(), item.id) != panel->brackets.end())
        if (LoopItemT& hung = *this->item("panel", panel->id); hung.status != ItemStatus::planned)
          reject(hung, {"its bracket " + item.id + " " + because.why, {}, {}, rests_on_});
  }

  void reject(LoopItemT& item, const Because& because) {
    using S = ItemStatus;
    if (item.status == S::released) move(state_, item, S::stale, because), move(state_, item, S::planned, because);
    if (item.status == S::executed) move(state_, item, S::relocalised, because);
    if (item.status == S::relocalised || item.status == S::verified) move(state_, item, S::rework, because);
    if (item.status == S::planned || item.status == S::rework) move(state_, item, S::rejected, because);
    item.pending.setZero();
  }

  /// Floors whose anchors all moved together: their control did, now or when they were measured last. Nothing of them
  /// is verified or released by this plan.
  void find_floors_that_moved() {
    std::map<int, std::array<std::vector<double>, 3>> moves;
    std::map<int, Eigen::Vector3d> doubt;
    for (const auto& bracket : plan_.brackets) {
      const LoopItemT& item = *this->item("bracket", bracket->id);
      const Eigen::Vector3d shift = bracket->measured - place_of(item, *bracket);
      if (!shift.allFinite()) continue;
      const Eigen::Vector3d most = doubt_of(*bracket);
      if (item.status == ItemStatus::executed && (shift.cwiseAbs().array() > most.array()).any() &&
          !explanation(item, *bracket, most.maxCoeff()).empty())
        continue;
      Eigen::Vector3d& of_floor = doubt.try_emplace(item.floor, Eigen::Vector3d::Zero()).first->second;
      of_floor = of_floor.cwiseMax(most);
      for (std::size_t k = 0; k < 3; ++k) moves[item.floor][k].push_back(shift[static_cast<Eigen::Index>(k)]);
    }
    for (auto& [floor, by_axis] : moves) {
      if (by_axis[0].size() < 3) continue;
      auto& names = state_.moved_control;
      names.erase(std::remove(names.begin(), names.end(), control_of_floor(floor)), names.end());
      for (std::size_t k = 0; k < 3; ++k) {
        auto& values = by_axis[k];
        std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
        if (std::abs(values[values.size() / 2]) > doubt.at(floor)[static_cast<Eigen::Index>(k)])
          moved_floors_.insert(floor);
      }
      if (moved_floors_.count(floor)) names.push_back(control_of_floor(floor));
    }
  }

  /// What was released is recalled, and what was verified is measured at most: it was verified by one of two
  /// measurements that contradict each other.
  void doubt_what_stands_on_moved_control() {
    for (auto& item : state_.items) {
      if (!moved_floors_.count(item->floor)) continue;
      const Because because{"the anchors of floor " + std::to_string(item->floor) +
                                " moved together since they were measured last: check their control",
                            {},
                            {},
                            rests_on_};
      if (item->status == ItemStatus::released) {
        move(state_, *item, ItemStatus::stale, because);
        move(state_, *item, ItemStatus::planned, because);
        item->pending.setZero();
      } else if (item->status == ItemStatus::verified) {
        move(state_, *item, ItemStatus::relocalised, because);
      }
    }
  }

  /// Whether a panel hangs on it.
  bool carries(const std::string& bracket) const {
    for (const auto& panel : plan_.panels) {
      const ItemStatus status = item("panel", panel->id)->status;
      if (status != ItemStatus::executed && status != ItemStatus::relocalised && status != ItemStatus::verified)
        continue;
      if (std::find(panel->brackets.begin(), panel->brackets.end(), bracket) != panel->brackets.end()) return true;
    }
    return false;
  }

  void verify_panels() {
    for (const auto& panel : plan_.panels) {
      LoopItemT& item = *this->item("panel", panel->id);
      if (!panel->installed || !(panel->p_in >= 0) || touches_moved_floor(*panel)) continue;
      if (item.status == ItemStatus::executed)
        move(state_, item, ItemStatus::relocalised, {panel->reason, {}, {}, rests_on_});
      if (item.status == ItemStatus::relocalised && panel->p_in >= options_.verified)
        move(state_, item, ItemStatus::verified, {panel->reason, {}, {}, rests_on_});
      else if ((item.status == ItemStatus::relocalised || item.status == ItemStatus::verified) &&
               1 - panel->p_in >= options_.verified)
        take_down(*panel, item);
    }
  }

  /// Its own floor or that of a neighbour above or below, whose control moved.
  bool touches_moved_floor(const PlannedPanelT& panel) const {
    return moved_floors_.count(panel.floor) + moved_floors_.count(panel.floor - 1) +
               moved_floors_.count(panel.floor + 1) >
           0;
  }

  void take_down(const PlannedPanelT& panel, LoopItemT& item) {
    do_again(state_, item, options_, {"hangs outside its limits: " + panel.reason, {}, {}, rests_on_});
    for (const std::string& id : panel.brackets) {
      LoopItemT* bracket = this->item("bracket", id);
      if (bracket && bracket->status == ItemStatus::verified && !carries(id))
        do_again(state_, *bracket, options_, {"panel " + panel.id + " is taken down", {}, {}, rests_on_});
    }
  }

  void find_stale() {
    for (const auto& bracket : plan_.brackets) {
      LoopItemT& item = *this->item("bracket", bracket->id);
      if (item.status != ItemStatus::released) continue;
      if (moved_floors_.count(item.floor)) continue;
      const Eigen::Vector3d moved = along_axes(*bracket, bracket->measured - item.expected);
      const double change = (moved + bracket->setting - item.pending).cwiseAbs().maxCoeff();
      if (change <= 0.1 * options_.setting_tolerance) continue;
      move(state_, item, ItemStatus::stale,
           {"the new measurement asks for " + millimetres(change) + " elsewhere", {}, {}, rests_on_});
      move(state_, item, ItemStatus::planned, {"stale", {}, {}, rests_on_});
      item.pending.setZero(), item.expected = bracket->measured;
    }
  }

  /// Brackets that stand where they were to be, under a panel that is not GO with them: set again, if the plan could
  /// tell how.
  void unset_what_does_not_do() {
    for (const auto& panel : plan_.panels) {
      const LoopItemT& hung = *item("panel", panel->id);
      if (hung.status != ItemStatus::planned || panel->gate == GateDecision::go || touches_moved_floor(*panel))
        continue;
      if (panel->gate == GateDecision::hold && !panel->measure.empty() && !measured_again_) continue;
      for (const std::string& id : panel->brackets) {
        LoopItemT* bracket = item("bracket", id);
        if (bracket && bracket->status == ItemStatus::verified && !carries(id))
          do_again(state_, *bracket, options_,
                   {"panel " + panel->id + " would not hang right on it: " + panel->reason, {}, {}, rests_on_});
      }
    }
  }

  bool turn_of(const PlannedPanelT& panel) const {
    return std::all_of(panel.depends_on.begin(), panel.depends_on.end(), [&](const std::string& id) {
      const LoopItemT* before = item("panel", id);
      return !before || before->status == ItemStatus::verified || before->status == ItemStatus::rejected;
    });
  }

  void release() {
    bool raised = false;
    const auto revision = [&] {
      if (!raised) ++state_.revision, raised = true;
      return state_.revision;
    };
    for (const auto& panel : plan_.panels) {
      LoopItemT& item = *this->item("panel", panel->id);
      if (item.status != ItemStatus::planned || panel->gate != GateDecision::go || !turn_of(*panel) ||
          touches_moved_floor(*panel)) {
        if (item.status == ItemStatus::planned)
          item.why = panel->gate == GateDecision::go ? "waits for panels before it" : panel->reason;
        continue;
      }
      bool ready = true;
      for (const std::string& id : panel->brackets) ready = bracket_is_ready(id, revision) && ready;
      if (!ready) {
        item.why = "waits for its brackets";
        continue;
      }
      item.revision = revision();
      move(state_, item, ItemStatus::released, {panel->reason, {}, options_.at, rests_on_});
    }
  }

  template <typename Revision>
  bool bracket_is_ready(const std::string& id, const Revision& revision) {
    LoopItemT& item = *this->item("bracket", id);
    const BracketSettingT& bracket = *bracket_of_.at(id);
    if (item.status == ItemStatus::verified || bracket.fixed) return true;
    if (item.status != ItemStatus::planned) return false;
    item.expected = bracket.measured;
    if (bracket.setting.cwiseAbs().maxCoeff() < kDeadBand) {
      move(state_, item, ItemStatus::verified, {"needs no setting", {}, {}, rests_on_});
      return true;
    }
    item.pending = bracket.setting, item.revision = revision();
    move(state_, item, ItemStatus::released, {"gate of its panels is GO", {}, options_.at, rests_on_});
    return false;
  }

  LoopStateT& state_;
  const InstallationPlanT& plan_;
  const MachineOptions& options_;
  bool measured_again_;
  std::map<std::string, LoopItemT*> item_of_;
  std::map<std::string, const BracketSettingT*> bracket_of_;
  std::vector<std::string> rests_on_;
  std::set<int> moved_floors_;
};

}  // namespace

void apply_plan(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options) {
  Round(state, plan, options).run();
}

}  // namespace plumbline::loop
