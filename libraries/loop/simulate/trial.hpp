// One tower from first survey to last panel: with the coordinates of the design, measured once, in a closed loop, and
// in a closed loop in which no person looks at anything.
#pragma once

#include <map>

#include "loop/gate/gate.hpp"
#include "loop/simulate/site.hpp"
#include "loop/state/machine.hpp"

namespace plumbline::loop {

/// `unattended`: closed, and nobody looks at what the state asks a person to look at.
enum class Strategy { open, measured_once, unattended, closed };
const char* name_of(Strategy strategy);

/// A statement of a plan and what came of it.
struct Stated {
  double p_in = kUnknown;
  bool inside = false;
};

struct TrialResult {
  int panels = 0, panels_inside = 0;  ///< in truth, all corners and joints of the panel
  int joints = 0, joints_inside = 0;  ///< ends of joints: width and step
  std::vector<int> inside_by_floor;   ///< panels
  int reworks = 0, settings = 0, rounds = 0;
  int looks = 0;      ///< of a person, at a bracket or at the control of a floor, because the state asked for it
  int by_person = 0;  ///< of the verified: a person looked at the panel or at one of its brackets
  int verified = 0, verified_wrong = 0;  ///< panels called VERIFIED; those of them that are outside in truth
  double verified_worst = 0;             ///< farthest that a length of a verified panel is outside its limit [m]
  int infeasible = 0;                    ///< panels that no setting could bring within their limits
  double top_height = 0;                 ///< mean height of the top floor's panels against the design [m]
  std::vector<Stated> stated;            ///< measured once: gates before anything was set
  double joint_nees = 0, joint_nees_diagonal = 0;  ///< mean of (true - stated)² / u² over joints, measured once
  int joint_values = 0;
  std::vector<std::string> journal;       ///< of the closed loop
  int planted = 0, planted_verified = 0;  ///< faults that left a hook off; brackets VERIFIED although still off by one
  std::map<std::string, int> planted_by_kind;
  std::vector<std::string> missed;  ///< of the latter: what was planted there, and their lines of the journal
  std::vector<std::string> left;    ///< of the closed loop: panels that are not VERIFIED at its end, and why
  std::vector<std::string> wrong;   ///< panels VERIFIED and outside in truth, and what was planted at their brackets
};

TrialResult run_trial(const SiteOptions& options, Strategy strategy, std::uint64_t seed);

}  // namespace plumbline::loop
