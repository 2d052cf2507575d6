// plan.@name@: how brackets are to be set; stands in for plan.installation (plan.use=plan.@name@).
//
// Write your way to the settings into asked_for(). What is judged, uncertainties, the gate, campaigns as one estimate,
// words and tables are those of every planner.
#include "build/loop/planner_node.hpp"

using namespace plumbline;

namespace {

/// By bracket, along right, up, out of its facade [m]; brought within range and into steps by whoever calls. Here: each
/// back to its place by design.
std::vector<Eigen::Vector3d> asked_for(const loop::Facade& facade) {
  std::vector<Eigen::Vector3d> asked;
  for (const loop::Bracket& bracket : facade.brackets) asked.push_back(-(bracket.axes.transpose() * bracket.deviation));
  return asked;
}

struct Planner : loop::PlannerNode {
  static constexpr Info info{"plan.@name@", "planner", 1, "Settings of brackets, each for itself"};

 protected:
  loop::Fit settings(const loop::Facade& facade) override { return loop::fit_of_settings(facade, asked_for(facade)); }
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", Planner)
