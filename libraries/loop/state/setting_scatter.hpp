// How well brackets are set, found from where they are measured afterwards.
#pragma once

#include <string>
#include <vector>

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// What one robot or person set on one floor: all of it is off alike by what its station, or the control there, is.
struct StationShift {
  int floor = 0;
  std::string by;  ///< as its reports say; empty: they do not
  int brackets = 0;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of all of them: median in each of the frame's directions [m]
  /// Of what setting and the difference of two campaigns alone would make of it.
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
};

/// Of brackets that were reported as set and have been measured since: how far they stand from where they were to be,
/// each direction, as a standard deviation [m]. By medians, so that few that slipped or were set wrongly do not count.
struct SettingScatter {
  int brackets = 0;
  double seen = 0;  ///< setting and two campaigns together: 1.4826 median |d|, of each station about its own median
  double campaigns = 0;  ///< of it by what two campaigns differ, root mean square of what the plan states
  /// Stations of three brackets or more. None: the stations' errors are in `seen`, as brackets were too few to part
  /// them.
  std::vector<StationShift> stations;
  /// What is left to who sets: the square root of the difference of the squares, 0 where the campaigns explain it all.
  double setting() const;
  /// What stations are off by, each direction, beyond what setting makes of their medians; 0 without stations.
  double station() const;
};

/// `state` with all reports and not yet judged by `plan`; `measured_at` as of is_measured_anew().
SettingScatter setting_scatter(const LoopStateT& state, const InstallationPlanT& plan, const std::string& measured_at);

/// What to say where who sets does so by more than the plan takes (setting_sigma), or a station is off by more than
/// station_sigma allows, by a factor that chance does not explain; empty: nothing, also of fewer than six brackets.
std::vector<std::string> scatter_words(const SettingScatter& scatter, const InstallationPlanT& plan);

}  // namespace plumbline::loop
