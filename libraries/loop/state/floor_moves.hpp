// How the anchors of each floor moved since they were measured last, and whether that is their control.
#pragma once

#include <map>
#include <vector>

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// What the anchors of one floor say about its control. Those that a mistake of a robot explains say nothing, unless so
/// many share the movement that the control explains them as well.
struct FloorMoves {
  std::vector<Eigen::Vector3d> moves, explained;    ///< against where they should be [m]
  Eigen::Vector3d doubt = Eigen::Vector3d::Zero();  ///< what a movement must exceed to mean something [m]
  bool moved() const;
};

/// Of the anchors that were measured anew, by floor.
std::map<int, FloorMoves> moves_of_floors(const LoopStateT& state, const InstallationPlanT& plan, double tolerance,
                                          const std::string& measured_at);

/// Items of the plan that the state does not know yet. Throws std::runtime_error for a name whose GlobalId changed.
void add_items(LoopStateT& state, const InstallationPlanT& plan);

}  // namespace plumbline::loop
