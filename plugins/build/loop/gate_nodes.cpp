#include "build/loop/gate_nodes.hpp"

#include "loop/gate/plan_gates.hpp"
#include "loop/state/plan_artifact.hpp"

namespace plumbline::loop {

void GateNode::run(Context& context) {
  InstallationPlanT result = plan.unpack();
  decide(result);
  context.metric("panels_go", result.go, "1");
  context.metric("panels_hold", result.hold, "1");
  context.metric("panels_no_go", result.no_go, "1");
  words.commit(text_file("installation.txt", "text/plain", installation_words(result)));
  gated.commit(result);
}

void GateJoint::decide(InstallationPlanT& decided) {
  gate_by_probability(decided, *go_probability, *no_go_probability);
}

void GateGuardBand::decide(InstallationPlanT& decided) { gate_by_guard_band(decided, *guard_factor); }

}  // namespace plumbline::loop
