// A new plan on a new measurement: what was done is judged, what is in doubt is no longer verified, what is GO is
// released.
#include "loop/state/round.hpp"

#include <algorithm>
#include <stdexcept>

#include "base/text/words.hpp"
#include "loop/fit/facade.hpp"
#include "loop/state/control_change.hpp"
#include "loop/state/date.hpp"
#include "loop/state/floor_moves.hpp"
#include "loop/state/next_words.hpp"
#include "loop/state/recalled_orders.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::loop {
namespace {

/// Of the tolerance of a setting: control that moved by less changes no job that is out.
constexpr double kOtherResult = 0.1;

}  // namespace

Round::Round(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options)
    : state_(state), plan_(plan), options_(options) {
  add_items(state, plan);
  for (auto& item : state_.items) item_of_[item->kind + " " + item->id] = item.get();
  for (const auto& bracket : plan_.brackets) bracket_of_[bracket->id] = bracket.get();
  rests_on_ = {plan_.basis};
}

void Round::run() {
  note_sills();
  note_gone();
  moved_floors_ = floors_in_doubt();
  state_.to_plan = state_.to_measure = false, state_.doubts = plan_.doubts;
  if (const std::string why = doubt_of_everything(); !why.empty()) {
    hold_everything(why);
  } else {
    // What campaigns say together is of no use while one of them is in doubt.
    state_.estimate = plan_.estimate ? std::make_unique<AnchorEstimateT>(*plan_.estimate) : nullptr;
    take_control();
    take_readings();
    answer_recalled_orders(state_, plan_, options_);
    verify_brackets();
    verify_panels();
    find_stale_brackets();
    find_stale_panels();
    unset_what_does_not_do();
    find_stale_panels();
    release();
    for (const auto& bracket : plan_.brackets)
      if (bracket->fixed && item("bracket", bracket->id)->status == ItemStatus::planned && !carries(bracket->id))
        state_.to_plan = true;
    // What was reported is judged by measurements that no plan has seen before.
    for (auto& item : state_.items)
      if (item->status != ItemStatus::executed) note_basis(*item);
  }
  tell_unused();
  note_control(state_);
  state_.basis = plan_.basis;
}

void Round::note_sills() {
  for (const auto& bracket : plan_.brackets) {
    stop_point();
    LoopItemT& sill = *item("bracket", bracket->id);
    std::set<std::string> holds;
    if (sill.status == ItemStatus::rejected || !bracket->measured.allFinite())
      holds.insert(sill.holds.begin(), sill.holds.end());
    for (const auto& panel : plan_.panels)
      if (std::count(panel->sills.begin(), panel->sills.end(), bracket->id) > 0) holds.insert(panel->id);
    sill.holds.assign(holds.begin(), holds.end());
  }
}

void Round::note_gone() {
  for (auto& item : state_.items) {
    item->gone = !item->guid.empty() && std::count(plan_.gone.begin(), plan_.gone.end(), item->guid) > 0;
    if (item->gone && item->status == ItemStatus::released)
      recall_item(*item, "stale: the design does not have it any more");
  }
}

void Round::tell_unused() {
  for (const auto& bracket : plan_.brackets) {
    LoopItemT& item = *this->item("bracket", bracket->id);
    if (item.status != ItemStatus::planned) continue;
    using R = ItemReason;
    if (item.reason == R::holds_nothing || item.reason == R::not_planned || item.reason == R::holds_edge)
      stay(item, "");
    if (!item.holds.empty())
      stay(item, "holds the bottom edge of " + text::join(item.holds, 8) + ": nothing is to be set", R::holds_edge);
    if (bracket->use == BracketUse::nothing && item.holds.empty())
      stay(item, "no panel hangs on it: nothing is to be set", R::holds_nothing);
    if (bracket->use == BracketUse::not_planned)
      stay(item, "the panel on it is not planned: installation.txt says why", R::not_planned);
  }
}

LoopItemT* Round::item(const std::string& kind, const std::string& id) const {
  const auto found = item_of_.find(kind + " " + id);
  return found == item_of_.end() ? nullptr : found->second;
}

Because Round::by_plan(std::string why, ItemReason reason) const {
  return {std::move(why), {}, {}, rests_on_, reason, kProgram, options_.at};
}

std::string Round::doubt_of_everything() const {
  if (const std::string name = control_without_floor(state_); !name.empty())
    return name + " moved, and nobody knows what hangs on it: look at it, then accept it";
  return plan_.doubts.empty() ? std::string() : "the measurement is in doubt: " + plan_.doubts.front();
}

void Round::hold_everything(const std::string& why) {
  for (auto& item : state_.items) {
    if (item->status == ItemStatus::released) recall_item(*item, why);
    const bool has_its_own = item->status == ItemStatus::verified || item->status == ItemStatus::rejected ||
                             item->status == ItemStatus::rework;
    if (!has_its_own) stay(*item, why);
  }
}

void Round::take_control() {
  const ControlChange last = control_change(state_.control, plan_.control);
  const std::vector<ControlChange> since = changes_since(state_, plan_.control);
  if (!plan_.control.empty()) state_.control = kept_control(state_.control, plan_.control);
  const double least = kOtherResult * options_.setting_tolerance;
  for (auto& item : state_.items) {
    const ControlChange* steps = item->control > 0 ? &since.at(item->control - 1) : nullptr;
    if (last.largest <= least && !(steps && steps->largest > least)) continue;
    const std::string why = last.largest > least ? words_of(last) : words_since(*steps);
    item->control = 0;
    if (item->status == ItemStatus::released)
      recall_item(*item, "stale: " + why);
    else if (item->kind == "bracket" && item->status == ItemStatus::verified)
      move(state_, *item, ItemStatus::relocalised, by_plan(why));
    if (item->kind == "bracket") item->expected.setConstant(kUnknown), item->unset.clear();
  }
}

void Round::take_readings() {
  std::set<std::string> all(state_.readings.begin(), state_.readings.end());
  all.insert(plan_.readings.begin(), plan_.readings.end());
  state_.readings.assign(all.begin(), all.end());
}

void Round::recall_item(LoopItemT& item, const std::string& why) {
  const Because because = by_plan(why);
  move(state_, item, ItemStatus::stale, because), move(state_, item, ItemStatus::planned, because);
  item.pending.setZero();
}

void Round::note_basis(LoopItemT& item) const {
  if (item.kind == "bracket") {
    const auto bracket = bracket_of_.find(item.id);
    if (bracket != bracket_of_.end() && !bracket->second->basis.empty()) item.basis = bracket->second->basis;
    return;
  }
  for (const auto& panel : plan_.panels) {
    if (panel->id != item.id) continue;
    item.basis.clear();
    for (const std::string& id : panel->brackets) item.basis += this->item("bracket", id)->basis + " ";
  }
}

std::set<int> Round::floors_in_doubt() const {
  std::set<int> floors;
  for (const auto& item : state_.items)
    if (std::count(state_.moved_control.begin(), state_.moved_control.end(), control_of_floor(item->floor)) > 0)
      floors.insert(item->floor);
  return floors;
}

void Round::find_floors_that_moved() {
  for (const auto& [number, floor] : moves_of_floors(state_, plan_, options_.setting_tolerance, options_.measured_at)) {
    const bool moved = floor.moved();
    if (!moved && floor.moves.size() < 3) continue;
    auto& names = state_.moved_control;
    names.erase(std::remove(names.begin(), names.end(), control_of_floor(number)), names.end());
    if (moved) names.push_back(control_of_floor(number));
  }
  moved_floors_ = floors_in_doubt();
}

void Round::doubt_what_stands_on_moved_control() {
  for (auto& item : state_.items) {
    if (!moved_floors_.count(item->floor)) continue;
    const Because because = by_plan("the anchors of floor " + std::to_string(item->floor) +
                                    " moved together since they were measured last: check their control");
    if (item->status == ItemStatus::released)
      recall_item(*item, because.why);
    else if (item->status == ItemStatus::verified)
      move(state_, *item, ItemStatus::relocalised, because);
  }
}

bool Round::touches_moved_floor(const PlannedPanelT& panel) const {
  return moved_floors_.count(panel.floor) + moved_floors_.count(panel.floor - 1) +
             moved_floors_.count(panel.floor + 1) >
         0;
}

bool Round::hangs(const LoopItemT& panel) {
  return panel.hangs || panel.status == ItemStatus::executed || panel.status == ItemStatus::relocalised ||
         panel.status == ItemStatus::verified;
}

bool Round::carries(const std::string& bracket) const {
  stop_point();
  for (const auto& panel : plan_.panels) {
    if (!hangs(*item("panel", panel->id))) continue;
    if (std::find(panel->brackets.begin(), panel->brackets.end(), bracket) != panel->brackets.end()) return true;
  }
  return false;
}

void apply_plan(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options) {
  const std::optional<double> measured = seconds_of(options.measured_at), now = seconds_of(options.at);
  if (measured && now && *measured > *now)
    throw std::runtime_error("the measurement began at " + options.measured_at + ", after the plan that rests on it (" +
                             options.at + "): are the two exchanged, or in another zone?");
  Round(state, plan, options).run();
}

}  // namespace plumbline::loop
