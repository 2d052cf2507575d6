#include "loop/state/machine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "loop/fit/facade.hpp"
#include "loop/state/place_doubts.hpp"

namespace plumbline::loop {

const char* name_of(ItemStatus status) {
  static constexpr const char* kNames[] = {"PLANNED",  "RELEASED", "EXECUTING", "EXECUTED", "RELOCALISED",
                                           "VERIFIED", "REWORK",   "REJECTED",  "STALE"};
  const auto at = static_cast<std::size_t>(status);
  return at < std::size(kNames) ? kNames[at] : "?";
}

bool may_follow(ItemStatus from, ItemStatus to) {
  using S = ItemStatus;
  static const std::map<S, std::set<S>> next = {
      {S::planned, {S::released, S::verified, S::rejected}},
      {S::released, {S::executing, S::executed, S::stale, S::planned, S::rework}},
      {S::executing, {S::executed, S::planned, S::rework}},
      {S::executed, {S::relocalised}},
      {S::relocalised, {S::verified, S::rework}},
      {S::verified, {S::rework}},
      {S::rework, {S::planned, S::rejected}},
      {S::rejected, {S::planned}},
      {S::stale, {S::planned}}};
  return next.at(from).count(to) > 0;
}

namespace {

/// A bracket that is asked to move by less than this is left as it is [m].
constexpr double kDeadBand = 0.0003;
/// A report may come from a tool that stands on the plate, not on the anchor [m].
constexpr double kReach = 0.25;

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", 1e3 * metres);
  return text;
}

struct Because {
  std::string why, by, at;
  std::vector<std::string> rests_on;
};

void move(LoopStateT& state, LoopItemT& item, ItemStatus to, const Because& because) {
  if (!may_follow(item.status, to))
    throw std::logic_error(item.kind + " " + item.id + " cannot go from " + name_of(item.status) + " to " +
                           name_of(to));
  state.journal.push_back(journal_line({state.round, item.id, item.kind, name_of(item.status), name_of(to), because.by,
                                        because.at, because.why, because.rests_on},
                                       journal_head(state.journal)));
  item.status = to, item.why = because.why;
  if (!because.by.empty()) item.by = because.by;
  if (!because.at.empty()) item.at = because.at;
}

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
    if (measured_again_) {
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
    for (const auto& bracket : plan_.brackets) {
      LoopItemT& item = *this->item("bracket", bracket->id);
      if (moved_floors_.count(item.floor)) continue;
      const double off = (bracket->measured - last_place(item, *bracket)).cwiseAbs().maxCoeff();
      if (item.status == ItemStatus::executed && std::isfinite(off))
        judge_setting(item, off, doubt_of(*bracket));
      else if (off > doubt_of(*bracket))
        give_to_a_person(item, off);
      if (item.status != ItemStatus::released && item.status != ItemStatus::executing)
        item.expected = bracket->measured;
    }
  }

  /// What a difference between two measurements must exceed to mean something: the tolerance, or four of its standard
  /// deviations.
  double doubt_of(const BracketSettingT& bracket) const {
    return std::max(options_.setting_tolerance, 4 * std::sqrt(2.0) * bracket.sigma.maxCoeff());
  }

  void judge_setting(LoopItemT& item, double off, double most) {
    move(state_, item, ItemStatus::relocalised,
         {"measured " + millimetres(off) + " from where it was to be", {}, {}, rests_on_});
    if (off <= most)
      move(state_, item, ItemStatus::verified, {"within " + millimetres(most), {}, {}, rests_on_});
    else
      do_again(state_, item, options_,
               {"stands " + millimetres(off) + " from where it was to be set", {}, {}, rests_on_});
  }

  /// Where the anchor of a bracket should be measured now.
  static Eigen::Vector3d last_place(const LoopItemT& item, const BracketSettingT& bracket) {
    Eigen::Vector3d place = item.expected;
    for (int k = 0; k < 3 && item.status == ItemStatus::released; ++k)
      place -= item.pending[k] * bracket.axes[static_cast<std::size_t>(k)];
    return place;
  }

  /// An anchor that is elsewhere and nobody reported why: the bracket was moved, or its plate was knocked. Measuring
  /// the plate again does not tell the two apart.
  void give_to_a_person(LoopItemT& item, double off) {
    const Because because{
        "moved by " + millimetres(off) +
            " without a report that was taken: look whether the bracket was moved or its plate was knocked",
        {},
        {},
        rests_on_};
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

  /// Floors whose anchors all moved together: their control did. Nothing of them is verified or released by this plan.
  void find_floors_that_moved() {
    std::map<int, std::array<std::vector<double>, 3>> moves;
    std::map<int, double> doubt;
    for (const auto& bracket : plan_.brackets) {
      const LoopItemT& item = *this->item("bracket", bracket->id);
      const Eigen::Vector3d move = bracket->measured - last_place(item, *bracket);
      if (item.status == ItemStatus::executed || !move.allFinite()) continue;
      doubt[item.floor] = std::max(doubt[item.floor], doubt_of(*bracket));
      for (std::size_t k = 0; k < 3; ++k) moves[item.floor][k].push_back(move[static_cast<Eigen::Index>(k)]);
    }
    for (auto& [floor, by_axis] : moves)
      for (auto& values : by_axis) {
        if (values.size() < 3) continue;
        std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
        if (std::abs(values[values.size() / 2]) > doubt.at(floor)) moved_floors_.insert(floor);
      }
    for (const int floor : moved_floors_) {
      const std::string name = "control of floor " + std::to_string(floor);
      if (std::find(state_.moved_control.begin(), state_.moved_control.end(), name) == state_.moved_control.end())
        state_.moved_control.push_back(name);
      for (auto& item : state_.items)
        if (item->floor == floor && item->status == ItemStatus::released) {
          const Because because{"the anchors of floor " + std::to_string(floor) +
                                    " moved together since they were measured last: check their control",
                                {},
                                {},
                                rests_on_};
          move(state_, *item, ItemStatus::stale, because);
          move(state_, *item, ItemStatus::planned, because);
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

  /// Where the plan wants the anchor of a bracket.
  static Eigen::Vector3d wanted(const BracketSettingT& bracket) {
    Eigen::Vector3d place = bracket.measured;
    for (int k = 0; k < 3; ++k) place += bracket.setting[k] * bracket.axes[static_cast<std::size_t>(k)];
    return place;
  }

  void find_stale() {
    for (const auto& bracket : plan_.brackets) {
      LoopItemT& item = *this->item("bracket", bracket->id);
      if (item.status != ItemStatus::released) continue;
      if (moved_floors_.count(item.floor)) continue;
      const double change = (wanted(*bracket) - item.expected).cwiseAbs().maxCoeff();
      if (change <= 0.1 * options_.setting_tolerance) continue;
      move(state_, item, ItemStatus::stale,
           {"the new measurement asks for " + millimetres(change) + " elsewhere", {}, {}, rests_on_});
      move(state_, item, ItemStatus::planned, {"stale", {}, {}, rests_on_});
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
      move(state_, item, ItemStatus::released, {panel->reason, {}, {}, rests_on_});
    }
  }

  template <typename Revision>
  bool bracket_is_ready(const std::string& id, const Revision& revision) {
    LoopItemT& item = *this->item("bracket", id);
    const BracketSettingT& bracket = *bracket_of_.at(id);
    if (item.status == ItemStatus::verified || bracket.fixed) return true;
    if (item.status != ItemStatus::planned) return false;
    item.expected = wanted(bracket);
    if (bracket.setting.cwiseAbs().maxCoeff() < kDeadBand) {
      move(state_, item, ItemStatus::verified, {"needs no setting", {}, {}, rests_on_});
      item.expected = bracket.measured;
      return true;
    }
    item.pending = bracket.setting, item.revision = revision();
    move(state_, item, ItemStatus::released, {"gate of its panels is GO", {}, {}, rests_on_});
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

/// Why a report is not taken; empty if it is.
std::string objection(const LoopItemT* item, const ActualT& actual) {
  if (!item) return "no bracket or panel of this name is known";
  if (actual.outcome != "done" && actual.outcome != "failed" && actual.outcome != "skipped")
    return "outcome '" + actual.outcome + "', expected done, failed or skipped";
  const bool over = item->status == ItemStatus::executed || item->status == ItemStatus::relocalised ||
                    item->status == ItemStatus::verified;
  if (over && actual.revision == item->revision) return "was reported before; nothing changes";
  if (item->revision == 0)
    return std::string("the item is ") + name_of(item->status) + ", not RELEASED: nobody asked for it; measure it";
  if (actual.revision != 0 && actual.revision != item->revision)
    return "is of revision " + std::to_string(actual.revision) + ", the item was released with " +
           std::to_string(item->revision) + ": a job that is no longer valid was executed; measure the item";
  if (item->status != ItemStatus::released && item->status != ItemStatus::executing)
    return std::string("the item is ") + name_of(item->status) + ", not RELEASED: nobody asked for it; measure it";
  if (!actual.at.empty() && !item->at.empty() && actual.at < item->at)
    return "is dated " + actual.at + ", before the item was released at " + item->at;
  if (actual.measured.allFinite() && item->expected.allFinite())
    return place_doubt(actual.measured, item->expected, kReach);
  return {};
}

}  // namespace

std::vector<std::string> apply_actuals(LoopStateT& state, const ActualsT& actuals) {
  std::vector<std::string> refused;
  for (const auto& actual : actuals.items) {
    LoopItemT* item = nullptr;
    for (auto& candidate : state.items)
      if (candidate->id == actual->item) item = candidate.get();
    const std::string why_not = objection(item, *actual);
    if (!why_not.empty()) {
      refused.push_back("report on " + actual->item + (actual->by.empty() ? "" : " by " + actual->by) + ": " + why_not);
      continue;
    }
    const Because because{
        actual->note.empty() ? "reported " + actual->outcome : actual->note, actual->by, actual->at, {}};
    if (actual->outcome == "done") {
      move(state, *item, ItemStatus::executed, because);
      item->setting += actual->setting.allFinite() ? actual->setting : item->pending;
    } else {
      move(state, *item, ItemStatus::planned, {actual->outcome + ": " + because.why, actual->by, actual->at, {}});
    }
    item->pending.setZero();
  }
  return refused;
}

void apply_plan(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options) {
  Round(state, plan, options).run();
}

void recall(LoopStateT& state, const std::vector<std::string>& moved_control, const std::string& why) {
  for (const std::string& id : moved_control)
    if (std::find(state.moved_control.begin(), state.moved_control.end(), id) == state.moved_control.end())
      state.moved_control.push_back(id);
  for (auto& item : state.items) {
    if (item->status != ItemStatus::released) continue;
    move(state, *item, ItemStatus::stale, {why, {}, {}, {}});
    move(state, *item, ItemStatus::planned, {"stale: " + why, {}, {}, {}});
    item->pending.setZero();
  }
}

bool accept_item(LoopStateT& state, const std::string& id) {
  bool found = false;
  for (auto& item : state.items) {
    if (item->id != id || item->status != ItemStatus::rejected) continue;
    move(state, *item, ItemStatus::planned, {"accepted by a person", {}, {}, {}});
    item->reworks = 0, item->expected.setConstant(kUnknown), found = true;
  }
  return found;
}

void close_round(LoopStateT& state) {
  state.verified = state.given_up = 0;
  bool open = false;
  for (const auto& item : state.items) {
    state.verified += item->status == ItemStatus::verified;
    state.given_up += item->status == ItemStatus::rejected;
    open = open || item->status == ItemStatus::released || item->status == ItemStatus::executing ||
           item->status == ItemStatus::executed || item->status == ItemStatus::relocalised;
  }
  ++state.round;
  state.done = !open;
}

}  // namespace plumbline::loop
