// What a robot does to a bracket or a panel, with its errors and faults: one model for the simulated site of tests and
// benchmark and for the node simulate.robots.
#pragma once

#include <string>
#include <vector>

#include "geometry/random.hpp"
#include "loop/fit/facade.hpp"

namespace plumbline::loop {

/// Of robots; standard deviations [m] where nothing else is said. Panels' manufacture is no robot's (SiteOptions,
/// ErrorModel).
struct RobotModel {
  double repeatability = 0.0003;  ///< of the arm, each setting and axis
  double calibration = 0.0002;    ///< of the arm, each axis, the same all the time
  double station = 0.0003;        ///< of the base's place: common to one floor and round
  double tilt = 0;                ///< of the base, about each axis [rad]: common to one floor and round
  double drift = 0;               ///< of the base's place, each axis, at each item of a floor and round: they add up
  double wander = 0;              ///< of the tool along the facade: a bit that wanders before it bites
  double slip_share = 0.02;       ///< of brackets that slip on tightening
  double slip = 0.002;            ///< how far
};

/// Shares of items at which something goes wrong, without being reported.
struct Faults {
  double did_nothing = 0, off_8mm = 0, wrong_side = 0, wrong_item = 0, skipped = 0, twice = 0, old_revision = 0;
  double tag_bumped = 0;       ///< plates of brackets that were knocked by 5 mm, seen by every campaign from then on
  double control_knocked = 0;  ///< of floors whose control was knocked by 6 mm before a campaign
  double hidden = 0;           ///< of anchors in each campaign that are not measured
  double partial = 0;    ///< of floors in each campaign that are not measured again: the measurement before stands
  double other_job = 0;  ///< of brackets set by another job's numbers and reported with its name
  /// Each campaign looks at all anchors, so what happens between campaigns gets smaller shares.
  static Faults all(double share) {
    return {share, share, share, share, share, share, share, share / 50, share / 5, share / 5, share, share};
  }
};

/// The revision that an old job has where there is none before: that of another loop.
constexpr int kOtherLoop = 1000;

/// How far a plate is knocked, and in height a mark of control, in the frame [m].
inline const Eigen::Vector3d kPlateBump(0.004, 0, 0.003);
constexpr double kControlKnock = 0.006;

/// What a robot sets out to do with a bracket, before the errors of its hand.
struct BracketTask {
  std::string fault;                                ///< "8 mm off"; empty: what it was asked for
  Eigen::Vector3d asked = Eigen::Vector3d::Zero();  ///< along right, up, out [m]; 0: it does not touch it
  bool other_bracket = false;                       ///< on the one after it
  bool twice = false;
  bool skipped = false;  ///< and says so
  int revision = 0;      ///< that it reports
  bool other_job = false;
  /// What the fault leaves a hook off by, that nobody reports [m].
  Eigen::Vector3d left = Eigen::Vector3d::Zero();
};

/// `setting`: that it was asked for [m]; `revision`: of the item as it was released.
BracketTask task_of(const Faults& faults, const Eigen::Vector3d& setting, int revision, Random& luck);

/// What moves a bracket that is to be moved by `setting`: with the errors of the arm (`arm`: its calibration) and of
/// where the base stands (`base`), of the hand and, where it slips, of tightening. Along right, up, out [m].
Eigen::Vector3d moved_by(const RobotModel& model, const Eigen::Vector3d& setting, const Eigen::Vector3d& arm,
                         const Eigen::Vector3d& base, Random& own);

/// Where the base of a robot stands before the item of a floor that it works on first, along that item's right, up and
/// out [m].
inline const Eigen::Vector3d kBase(0, -2, 1.5);

/// What an item is off by for where the base stands, along its right, up, out [m]. `from_first`: where it is from the
/// first item of its floor and round, along the same; `items`: how many were worked on there, with this one. Each of
/// the three draws what is the same for the floor and round.
Eigen::Vector3d off_by_base(const RobotModel& model, const Eigen::Vector3d& from_first, int items, Random station,
                            Random drifts, Random tilts);

/// Its standard deviation along the axis where it is largest, at that item of a floor where it is largest [m];
/// `from_first`: of each item, in the order of work. sqrt(station² + items drift² + tilt² (|v|² - v_k²)), with v from
/// the base to the item: first order in the tilt.
double sigma_by_base(const RobotModel& model, const std::vector<Eigen::Vector3d>& from_first);

/// Where the centre of a panel's face is, in the frame [m]: on hooks whose true deviations from the design are
/// `truth`, by bracket; `face`: how far its face is out of its plane by manufacture [m].
Eigen::Vector3d centre_on(const Panel& panel, const std::vector<Bracket>& brackets,
                          const std::vector<Eigen::Vector3d>& truth, double face);

}  // namespace plumbline::loop
