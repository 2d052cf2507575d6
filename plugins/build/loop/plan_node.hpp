// plan.installation and plan.centred: settings of brackets, poses of panels, GO or HOLD.
#pragma once

#include "build/loop/planner_node.hpp"

namespace plumbline::loop {

struct PlanInstallation : PlannerNode {
  static constexpr Info info{
      "plan.installation", "planner", 9,
      "How brackets are to be set so that panels hang right although the anchors are off, and with what probability"};
  Param<double> pose_weight{"pose_weight", 1.0, "1", between(0, 1e6), "of the corners' mean square movement"};
  Param<double> gap_weight{"gap_weight", 1.0, "1", between(0, 1e6), "of the squares of changes of gaps"};
  Param<double> step_weight{"step_weight", 1.0, "1", between(0, 1e6), "of the squares of steps between panels"};
  Param<double> setting_weight{"setting_weight", 0.01, "1", between(1e-9, 1e6), "of the squares of settings"};

 protected:
  Fit settings(const Facade& facade) override {
    return plan_settings(facade, {*pose_weight, *gap_weight, *step_weight, *setting_weight});
  }
};

/// What a layout tool does: no panel is thought of.
struct PlanCentred : PlannerNode {
  static constexpr Info info{
      "plan.centred", "planner", 7,
      "Sets each bracket back to its place by design as far as its range goes, whatever its panel needs; what layout "
      "tools do, to be held against plan.installation"};

 protected:
  Fit settings(const Facade& facade) override {
    std::vector<Eigen::Vector3d> asked;
    for (const Bracket& bracket : facade.brackets) asked.push_back(-(bracket.axes.transpose() * bracket.deviation));
    return fit_of_settings(facade, asked);
  }
};

}  // namespace plumbline::loop
