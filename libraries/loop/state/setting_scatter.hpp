// How well brackets are set, found from where they are measured afterwards.
#pragma once

#include <string>

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// Of brackets that were reported as set and have been measured since: how far they stand from where they were to be,
/// each direction, as a standard deviation [m]. By the median, so that few that slipped or were set wrongly do not
/// count.
struct SettingScatter {
  int brackets = 0;
  double seen = 0;       ///< setting, the robot's place and two campaigns together: 1.4826 median |d|
  double campaigns = 0;  ///< of it by what two campaigns differ, root mean square of what the plan states
  /// What is left to who sets: the square root of the difference of the squares, 0 where the campaigns explain it all.
  double setting() const;
};

/// `state` with all reports and not yet judged by `plan`; `measured_at` as of is_measured_anew().
SettingScatter setting_scatter(const LoopStateT& state, const InstallationPlanT& plan, const std::string& measured_at);

/// What to say where who sets does so by more than the plan takes (setting_sigma and station_sigma), by a factor that
/// chance does not explain; empty: nothing, also of fewer than six brackets.
std::string scatter_words(const SettingScatter& scatter, const InstallationPlanT& plan);

}  // namespace plumbline::loop
