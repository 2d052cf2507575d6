// GO, HOLD or NO_GO for each panel: the probability that it hangs within all its limits when the settings are done.
#pragma once

#include "loop/fit/plan_settings.hpp"

namespace plumbline::loop {

enum class GateVerdict { go, hold, no_go };
const char* name_of(GateVerdict verdict);  ///< "GO", "HOLD", "NO_GO"

struct GateOptions {
  double go = 0.95;                   ///< least p_in of GO
  double no_go = 0.95;                ///< least probability of a value outside for NO_GO
  double measurement_sigma = 0.0005;  ///< of one more measurement of a bracket, each direction [m]
};

/// One more measurement, and what it would do if the estimate stays where it is.
struct Advice {
  int bracket = -1;                       ///< -1: none helps
  double p_in = kUnknown;                 ///< afterwards
  double u = kUnknown, u_now = kUnknown;  ///< of the value that decides [m]
};

/// Why a panel cannot be more than HOLD, whatever its probability.
enum class Obstacle {
  none,
  no_bracket,    ///< it hangs on none
  not_measured,  ///< one of its brackets
  one_bracket,   ///< how it turns is open
  not_told,      ///< its hooks do not tell how far its corners move
  not_judged,    ///< something was asked of it that nobody could judge (Panel::open)
  assumed_sill,  ///< it is GO only if a sill that nobody measured is in place
};

struct PanelGate {
  GateVerdict verdict = GateVerdict::hold;
  double p_in = kUnknown;  ///< nan: cannot be told
  int decided_by = -1;     ///< the judged value that is most likely outside, as an index into Fit::judged
  Advice measure;          ///< of HOLD
  /// Of HOLD: standard deviation of a setting with which it would be GO [m]; 0: not even a perfect robot; nan: not the
  /// robot's.
  double robot_sigma = kUnknown;
  /// Of HOLD: p_in after many more campaigns on the same control, if the estimate stays; nan: not told.
  double p_repeated = kUnknown;
  Obstacle obstacle = Obstacle::none;
  double slips = 1;  ///< factor of p_in by brackets that slip on tightening, and by knocked plates and control
  std::vector<std::size_t> relaxed;  ///< of Fit::relaxations: of its brackets, or of a length of its own
  std::string reason;
};

/// One entry for every panel. A panel that hangs already is judged like the others, by what was measured of it. p_in
/// holds its corners and all joints to panels that are planned or hang; correlations are those of Fit. A panel with a
/// bracket that was not measured, with values that its hooks do not tell, or without hooks is HOLD, whatever p_in.
std::vector<PanelGate> judge_plan(const Facade& facade, const Fit& fit, const GateOptions& options = {});

}  // namespace plumbline::loop
