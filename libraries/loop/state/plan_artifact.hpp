// The plan as artifact, table and text, and what the state means for the next plan.
#pragma once

#include <map>
#include <string>

#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "loop/gate/gate.hpp"

namespace plumbline::loop {

/// GlobalIds, empty or one for each, and what else the reader must know.
struct PlanNames {
  std::vector<std::string> brackets, panels, notes;
};
InstallationPlanT plan_artifact(const Facade& facade, const Fit& fit, const std::vector<PanelGate>& gates,
                                const PlanNames& names = {});

/// A panel of the design of which nothing was measured: HOLD, without brackets, before the first one of a higher floor.
/// `why` says what to do; `place`: its reference point by design [m].
void add_unplanned(InstallationPlanT& plan, const std::string& id, const std::string& guid, int floor,
                   const Eigen::Vector3d& place, const std::string& why);

/// Marks what hangs, and the brackets that are planned as they stand: those that carry it, and those that were set,
/// verified or not yet (no plan may count on a second setting that nobody makes). Takes what was set
/// before off the ranges. Items are found by id.
void apply_state(Facade& facade, const LoopStateT& state);

/// Rows of all brackets that the plan wants set; of those in `asked` alone, by what is asked of them there (right, up,
/// out [m]).
std::string settings_csv(const InstallationPlanT& plan);
std::string settings_csv(const InstallationPlanT& plan, const std::map<std::string, Eigen::Vector3d>& asked);
std::string installation_words(const InstallationPlanT& plan);
FileT text_file(const std::string& name, const std::string& media_type, const std::string& text);

}  // namespace plumbline::loop
