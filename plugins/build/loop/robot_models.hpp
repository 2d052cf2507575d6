// simulate.robots and simulate.fitters: who does a job, simulated.
#pragma once

#include "artifacts/poses.hpp"
#include "build/loop/robot_node.hpp"
#include "loop/simulate/robot.hpp"

namespace plumbline::loop {

struct SimulateRobots : RobotNode {
  static constexpr Info info{"simulate.robots", "robot", 6,
                             "Robots that do a job with their errors and faults, on a site whose truth only they move"};
  Optional<Poses> believed{
      "believed", frame("frame=?F"),
      "where robots believe to stand by what their cameras see: the nearest one works on an item, and what it sets is "
      "off by where it really stands. Without, the base's error is drawn: station_sigma"};
  Optional<Poses> standing{"standing", frame("frame=?F"), "where they really stand, by the same names"};
  Param<double> repeatability{"repeatability", 0.0003, "m", between(0, 0.1), "of the arm, each setting and direction"};
  Param<double> station_sigma{
      "station_sigma", 0.0003, "m", between(0, 0.1),
      "of the base's place, drawn: common to one floor and round; with 'believed' it is not looked at"};
  Param<double> calibration{"calibration", 0.0001, "m", between(0, 0.1),
                            "of a robot's arm, each direction: the same in all rounds"};
  Param<int64_t> robot_seed{"robot_seed", 1, between(0, 1000000), "what is the same in all rounds is drawn by it"};
  Param<double> tilt{"tilt", 0.0, "rad", between(0, 0.1),
                     "of the base, about each axis: what is above it is off by it; drawn like station_sigma"};
  Param<double> drift{"drift", 0.0, "m", between(0, 0.1),
                      "of the base's place at each item of a floor, each direction: the drifts add up"};
  Param<double> bit_wander{"bit_wander", 0.0, "m", between(0, 0.1), "of the tool, along the facade"};
  Param<double> slip_share{"slip_share", 0.02, "1", between(0, 1), "of brackets that slip on tightening"};
  Param<double> slip_sigma{"slip_sigma", 0.002, "m", between(0, 0.1), "how far"};
  Param<double> face_sigma{"face_sigma", 0.0005, "m", between(0, 0.1), "of panels' faces out of plane, by manufacture"};
  Param<double> seen_sigma{"seen_sigma", 0.001, "m", between(1e-5, 0.1),
                           "of the place of a panel as who hangs it measures and reports it, each direction"};
  Param<double> did_nothing{"did_nothing", 0.0, "1", between(0, 1),
                            "share of items reported done that were not touched"};
  Param<double> off_8mm{"off_8mm", 0.0, "1", between(0, 1), "share of items set or hung 8 mm aside"};
  Param<double> wrong_side{"wrong_side", 0.0, "1", between(0, 1), "share of brackets set the other way"};
  Param<double> wrong_item{"wrong_item", 0.0, "1", between(0, 1), "share of items where another one is worked on"};
  Param<double> skipped{"skipped", 0.0, "1", between(0, 1), "share of items that are skipped, and reported so"};
  Param<double> twice{"twice", 0.0, "1", between(0, 1), "share of brackets that are set twice"};
  Param<double> old_revision{"old_revision", 0.0, "1", between(0, 1), "share of reports that name the revision before"};
  Param<double> other_job{"other_job", 0.0, "1", between(0, 1),
                          "share of brackets set by another job's numbers, and reported with its name"};

 protected:
  void run(Context& context) override;
  Deed work(const Job& todo, std::size_t item, std::uint64_t seed) override;
  RobotErrors errors(const Job& todo) const override;

 private:
  RobotModel model() const;
  /// By where the base stands, along the item's right, up and out [m].
  Eigen::Vector3d off_by_place(const Job& todo, std::size_t item, std::uint64_t seed) const;
  Deed set_bracket(const Job& todo, std::size_t item, std::uint64_t seed);
  Deed hang_panel(const Job& todo, std::size_t item, std::uint64_t seed);
  PosesT believed_, standing_;
};

struct SimulateFitters : RobotNode {
  static constexpr Info info{"simulate.fitters", "robot", 2,
                             "Fitters who set brackets by hand to the marks of a rule, and see what they hang"};
  Param<double> division{"division", 0.001, "m", between(0, 0.1), "of the rule: settings are rounded to it; 0: not"};
  Param<double> hand_sigma{"hand_sigma", 0.0005, "m", between(0, 0.1), "of each setting and direction"};

 protected:
  Deed work(const Job& todo, std::size_t item, std::uint64_t seed) override;
  RobotErrors errors(const Job& todo) const override;
};

}  // namespace plumbline::loop
