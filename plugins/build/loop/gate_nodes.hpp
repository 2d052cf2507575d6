// gate.joint and gate.guard_band: GO, HOLD or NO_GO of a plan, by another rule than that of its planner.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

/// What all gates have in common. A gate decides of panels, and changes nothing else of the plan; it makes nothing GO
/// that the planner holds because something of it is open (not measured, in doubt).
struct GateNode : Node {
  In<InstallationPlan> plan{"plan", frame("frame=?F"), "a plan with what its planner says of each panel"};
  Out<InstallationPlan> gated{"plan", frame("frame=?F"), "the plan with the decisions of this gate"};
  Out<File> words{"words", "installation.txt: what may be hung by them"};
  void run(Context& context) override;

 protected:
  virtual void decide(InstallationPlanT& decided) = 0;
};

struct GateJoint : GateNode {
  static constexpr Info info{"gate.joint", "gate", 1,
                             "GO by the probability that all lengths of a panel are within their limits at once"};
  Param<double> go_probability{"go_probability", 0.0, "1", between(0, 0.9999),
                               "least probability of GO; 0: that of the planner"};
  Param<double> no_go_probability{"no_go_probability", 0.0, "1", between(0, 0.9999),
                                  "least probability of a length outside for NO_GO; 0: that of the planner"};

 protected:
  void decide(InstallationPlanT& decided) override;
};

struct GateGuardBand : GateNode {
  static constexpr Info info{"gate.guard_band", "gate", 1,
                             "GO if each length by itself keeps k u from its limits, as acceptance protocols have it "
                             "(JCGM 106); to be held against gate.joint"};
  Param<double> guard_factor{"guard_factor", 1.645, "1", between(0, 10), "k"};

 protected:
  void decide(InstallationPlanT& decided) override;
};

}  // namespace plumbline::loop
