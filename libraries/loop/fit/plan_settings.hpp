// Settings of brackets and poses of panels from anchors as they are: a convex quadratic program over the whole facade.
#pragma once

#include <string>
#include <vector>

#include "loop/fit/convex_program.hpp"
#include "loop/fit/facade.hpp"
#include "loop/fit/panel_pose.hpp"

namespace plumbline::loop {

/// Factors of the squares that are minimised [1]: mean movement of a panel's corners, change of gaps, steps, settings.
struct FitWeights {
  double pose = 1, gap = 1, step = 1, setting = 0.01;
};

/// A limit that cannot be kept.
struct Relaxation {
  int bracket = -1, direction = -1;  ///< of a bracket's range
  int value = -1;                    ///< else the judged value, as an index into Fit::values
  double needed = 0, limit = 0;      ///< [m] what it would have to be, what it may be (less the guard band)
  std::string words;                 ///< for who has to mend it
  std::string topic;                 ///< what it is about, the same whatever the figures are
};

struct FittedValue {
  double value = 0, u = 0;  ///< [m] expected when the settings are done; its standard uncertainty
  bool guarded = true;      ///< false: k u alone takes nine tenths of the tolerance or more
};

struct Fit {
  std::vector<PanelPose> poses;           ///< by panel
  std::vector<JudgedValue> judged;        ///< what is judged
  std::vector<FittedValue> values;        ///< likewise
  std::vector<Eigen::Vector3d> asked;     ///< by bracket: the optimum along right, up, out [m]; nan: not measured
  std::vector<Eigen::Vector3d> settings;  ///< within its range and in its steps: what is to be set
  std::vector<Eigen::Matrix<double, 6, 1>>
      twists;  ///< by panel, with `settings` done: translation [m], rotation * arm [m]
  std::vector<Relaxation> relaxations;
  std::vector<std::string> notes;  ///< what could not be told or planned
  double objective = 0;            ///< [m²]
  int solves = 0;                  ///< programs that were solved until no limit was broken
};

/// Precondition: faults_of(facade) is empty. Minimises, over the twists of the panels and the settings of the brackets,
/// the sum of squares of FitWeights so that every hook that holds a direction is where its panel is, settings are
/// within range and judged values plus k u within their limits. Where that cannot be, limits give way with a penalty on
/// the sum of their excess (an exact L1 penalty; Nocedal and Wright 2006, 17.2): few give way, not all a little; ranges
/// of brackets before tolerances. Limits that nobody reaches are not handed to the solver: they are added until none is
/// broken, which has the same optimum. Throws what minimise() throws.
Fit plan_settings(const Facade& facade, const FitWeights& weights = {});

/// The same of settings that were chosen in another way: `asked` by bracket along right, up, out [m], brought within
/// range and into steps; of what was not measured or is not set any more it is not looked at. Where a range does not
/// reach what is asked for, that is a relaxation; that limits are broken is left to the gate. Throws
/// std::invalid_argument for another number of settings than brackets.
Fit fit_of_settings(const Facade& facade, const std::vector<Eigen::Vector3d>& asked);

/// The values of the facade when the brackets are set by `settings`, for a planned or any other choice [m].
std::vector<double> values_of(const Facade& facade, const Fit& fit, const std::vector<Eigen::Vector3d>& settings);

/// Inside the range and on the steps of its type.
Eigen::Vector3d settable(const BracketType& type, const Eigen::Vector3d& setting);

}  // namespace plumbline::loop
