// A plan in map coordinates with its state after the first release.
#pragma once

#include "loop/state/machine.hpp"
#include "loop/state/plan_artifact.hpp"
#include "random_facade.hpp"

namespace plumbline::test {

/// A plan with its state after the first release.
struct ReleasedFarOff {
  InstallationPlanT plan;
  LoopStateT state;
  ReleasedFarOff() {
    loop::Facade facade = random_facade({2, 2}, 4, 0.004, 0.0003, 0.0004);
    for (loop::Bracket& bracket : facade.brackets) bracket.design += Eigen::Vector3d(432100, 5812300, 30);
    for (loop::Panel& panel : facade.panels) {
      panel.centre += Eigen::Vector3d(432100, 5812300, 30);
      for (auto& corner : panel.corners) corner += Eigen::Vector3d(432100, 5812300, 30);
    }
    for (loop::Joint& joint : facade.joints)
      for (auto* places : {&joint.on_a, &joint.on_b})
        for (auto& place : *places) place += Eigen::Vector3d(432100, 5812300, 30);
    const loop::Fit fit = loop::plan_settings(facade);
    plan = loop::plan_artifact(facade, fit, loop::judge_plan(facade, fit));
    loop::apply_plan(state, plan, {});
  }
};

}  // namespace plumbline::test
