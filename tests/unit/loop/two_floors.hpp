// Two panels, one above the other, and what happens to them, for tests of the state machine.
#pragma once

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "loop/state/machine.hpp"

namespace plumbline::test {

using namespace plumbline::loop;

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Two panels, one above the other, on two brackets each; all anchors 4 mm low.
inline InstallationPlanT make_plan(const std::string& basis) {
  InstallationPlanT plan;
  plan.basis = basis;
  for (int i = 0; i < 4; ++i) {
    auto bracket = std::make_unique<BracketSettingT>();
    bracket->id = "b" + std::to_string(i), bracket->floor = 1 + i / 2, bracket->basis = "<" + basis + ">";
    bracket->design = {2.0 * (i % 2), 0, 4.0 * (i / 2)};
    bracket->measured = bracket->design - Eigen::Vector3d(0, 0, 0.004);
    bracket->axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitY()};
    bracket->asked = bracket->setting = {0, 0.004, 0};
    bracket->sigma.setConstant(0.0004), bracket->difference_sigma.setZero();
    bracket->low.setConstant(-0.02), bracket->high.setConstant(0.02);
    plan.brackets.push_back(std::move(bracket));
  }
  for (int j = 0; j < 2; ++j) {
    auto panel = std::make_unique<PlannedPanelT>();
    panel->id = "p" + std::to_string(j), panel->floor = j + 1;
    panel->brackets = {"b" + std::to_string(2 * j), "b" + std::to_string(2 * j + 1)};
    if (j == 1) panel->depends_on = {"p0"};
    panel->centre.setZero(), panel->shift.setZero(), panel->rotation.setZero();
    panel->gate = GateDecision::go, panel->p_in = 0.99, panel->reason = "p 0.990";
    plan.panels.push_back(std::move(panel));
  }
  return plan;
}

inline LoopItemT& item(LoopStateT& state, const std::string& id) {
  for (auto& i : state.items)
    if (i->id == id) return *i;
  throw std::runtime_error("no " + id);
}

inline ItemStatus item_status(LoopStateT& state, const std::string& id) {
  return state.items.empty() ? ItemStatus::planned : item(state, id).status;
}

inline ActualsT done(const std::vector<std::string>& ids, int revision) {
  ActualsT actuals;
  for (const std::string& id : ids) {
    auto actual = std::make_unique<ActualT>();
    actual->item = id, actual->revision = revision, actual->by = "robot-1", actual->outcome = "done";
    actual->measured.setConstant(nan), actual->sigma.setConstant(nan), actual->setting.setConstant(nan);
    // Robots see a panel that they have hung; its centre is to hang at the origin.
    if (id[0] == 'p') actual->measured = {0.0011, -0.0004, 0.0007};
    actuals.items.push_back(std::move(actual));
  }
  return actuals;
}

/// What plan.installation takes from the state: brackets that were set, or that carry a panel, are planned as they
/// stand.
inline void take_state(const LoopStateT& state, InstallationPlanT& plan) {
  const auto known = [&](const std::string& id) -> const LoopItemT* {
    for (const auto& i : state.items)
      if (i->id == id) return i.get();
    return nullptr;
  };
  const auto done = [&](const std::string& id) {
    const LoopItemT* i = known(id);
    return i && (i->hangs || i->status == ItemStatus::executed || i->status == ItemStatus::relocalised ||
                 i->status == ItemStatus::verified);
  };
  for (auto& bracket : plan.brackets) bracket->fixed = done(bracket->id);
  for (auto& panel : plan.panels) {
    panel->installed = done(panel->id);
    for (auto& bracket : plan.brackets)
      if (panel->installed && std::count(panel->brackets.begin(), panel->brackets.end(), bracket->id) > 0)
        bracket->fixed = true;
  }
  for (auto& bracket : plan.brackets)
    if (bracket->fixed) bracket->setting.setZero();
}

/// Planned with this state, then released.
inline void next_plan(LoopStateT& state, InstallationPlanT plan, const MachineOptions& options = {}) {
  take_state(state, plan);
  apply_plan(state, plan, options);
}

/// The plan after brackets 0 and 1 were set, off by `off` in height.
inline InstallationPlanT plan_after_setting(double off, const std::string& basis = "second") {
  InstallationPlanT plan = make_plan(basis);
  for (int i = 0; i < 2; ++i) {
    plan.brackets[i]->measured.z() += 0.004 + off;
    plan.brackets[i]->setting.setZero();
  }
  return plan;
}

}  // namespace plumbline::test
