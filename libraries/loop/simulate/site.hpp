// A site with robots, simulated: where hooks really are, what a campaign measures of them, what robots do to them. Only
// this knows the truth; planner, gate and state see measurements and reports.
#pragma once

#include <map>
#include <set>

#include "artifacts/actuals.hpp"
#include "artifacts/loop_state.hpp"
#include "loop/fit/panel_pose.hpp"
#include "loop/simulate/robot.hpp"
#include "loop/simulate/tower.hpp"

namespace plumbline::loop {

/// Of one campaign [m].
struct SurveyErrors {
  double single = 0.0003;        ///< each coordinate of each anchor
  double set_up = 0.0004;        ///< common to the anchors of a floor, each axis, new in each campaign
  double control_walk = 0.0002;  ///< height of a floor's control against the floor below, the same in all campaigns
};

struct SiteOptions {
  TowerOptions tower;
  double as_built = 0.004;      ///< of anchors against the design, each axis [m]
  double shortening = 0.00001;  ///< a floor g that hangs whole lowers floor f by this times min(f, g) [m]
  SurveyErrors survey;
  RobotModel robot;
  Faults faults;
  double edge = 0.0005, face = 0.0005;  ///< of manufacture [m]
  double seen = 0.001;                  ///< of a panel's place as who hangs it measures it, each axis [m]
};

/// A fault that was planted, and what it did.
struct PlantedFault {
  std::string kind, item;
  int round = 0;
  double size = 0;  ///< displacement of a hook that nobody reported [m]; 0: none
};

class SimulatedSite {
 public:
  SimulatedSite(const SiteOptions& options, std::uint64_t seed);

  /// The design, with nothing measured.
  const Facade& design() const { return design_; }
  /// A campaign: deviations and their covariance as the survey states it.
  Facade measure(int round);
  /// Robots do what is released; what they report.
  ActualsT execute(const LoopStateT& state, int round);
  /// Open loop: brackets are set to their design coordinates by robots that carry their height from floor to floor.
  void set_to_design();
  /// Sets a bracket by hand of a robot, with its errors, within its range.
  void set(std::size_t bracket, const Eigen::Vector3d& setting, int round);
  /// Panels of a floor hang: what it carries now lowers all floors.
  void hang(int floor, double share = 1);
  /// A person has looked at a bracket: a plate that was knocked is put back.
  void mend_plate(const std::string& bracket);
  /// Whether a panel hangs; a person who looks hangs it if it does not.
  bool hangs(const std::string& panel) const { return not_hung_.count(panel) == 0; }
  void hang_what_does_not(const std::string& panel) { not_hung_.erase(panel); }

  /// By how much the control of a floor is too high, the same in all campaigns [m]: no number of them tells it.
  double control_height(int floor) const { return walk_[floor - 1]; }

  /// Judged values as they really are, in the order of `judged`.
  std::vector<double> true_values(const std::vector<JudgedValue>& judged, const std::vector<PanelPose>& poses) const;
  const std::vector<Eigen::Vector3d>& true_deviations() const { return truth_; }
  const std::vector<PlantedFault>& planted() const { return planted_; }
  ErrorModel stated_errors() const;

 private:
  /// What a bracket that is set now is off by for where the robot's base stands, along right, up, out.
  Eigen::Vector3d off_by_base_at(std::size_t bracket, int round);
  void execute_bracket(const LoopItemT& item, int round, ActualsT& actuals);
  static void take_down(const LoopItemT& panel, ActualsT& actuals);
  void see_panel(const std::string& id, Random& luck, ActualT& actual) const;
  void plant(const std::string& kind, std::size_t bracket, int round, const Eigen::Vector3d& displacement);
  std::size_t bracket(const std::string& id) const { return bracket_at_.at(id); }

  SiteOptions options_;
  Facade design_;
  std::uint64_t seed_;
  std::vector<Eigen::Vector3d> truth_;      ///< of hooks against the design, in the frame
  std::vector<Eigen::Vector3d> plate_off_;  ///< of bumped plates against their hooks
  std::vector<Eigen::Vector3d> set_;        ///< by what brackets were set, along right, up, out
  std::vector<double> made_;                ///< manufacture, 5 for each panel
  std::vector<double> walk_;                ///< height of control, by floor
  std::vector<Eigen::Vector3d> seen_;       ///< deviations as they were measured last; nan: never
  std::map<std::string, std::size_t> bracket_at_;
  Eigen::Vector3d arm_;
  /// Brackets that were set, by floor and round: the first one, and how many.
  std::map<std::uint64_t, std::pair<std::size_t, int>> worked_on_;
  std::vector<PlantedFault> planted_;
  std::set<std::string> loads_;     ///< panels that the building carries
  std::set<std::string> not_hung_;  ///< panels that were reported as hung and are not
};

}  // namespace plumbline::loop
