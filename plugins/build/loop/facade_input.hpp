// The facade of the planner from what the judgement says of anchors and panels.
#pragma once

#include <map>

#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/loop_state.hpp"
#include "artifacts/points.hpp"
#include "build/loop/unplanned_panels.hpp"
#include "loop/fit/bracket_rules.hpp"

namespace plumbline::loop {

struct FacadeRules {
  std::vector<BracketRule> brackets;
  std::vector<HookRule> hooks;
  std::map<std::string, std::vector<std::string>> after;  ///< by panel: those that hang before it
  /// Panels that hang though no round knows of them: names as in the design; "*": all that are not planned.
  std::vector<std::string> standing;
  ErrorModel errors;
  double step_tolerance = 0;                                     ///< across a joint [m]; 0: that of the joint's width
  Eigen::Vector3d normal = Eigen::Vector3d::Constant(kUnknown);  ///< out of all of it; nan: each as the judgement says
};

/// "F02-P01 after F01-P01, F01-P02". Throws std::runtime_error that quotes it.
std::pair<std::string, std::vector<std::string>> parse_dependence(const std::string& text);

struct FacadeInput {
  Facade facade;
  std::vector<std::string> guids;        ///< of the brackets
  std::vector<std::string> panel_guids;  ///< of the panels
  std::vector<std::string> notes;        ///< panels of the design that are not planned
  std::vector<UnplannedPanel>
      unplanned;  ///< by name; those that a round before knows otherwise, or that are said to stand, are none
  std::vector<std::string> control;  ///< points of `control` that are in the model
};

/// Brackets: all anchors with a place in the design, whether they were measured or not; covariance of the model, plus
/// what the judgement added to it for where plates sit. Panels and joints: those of the judgement; corners must keep
/// its tolerances out of plane, sideways and vertical, joints that of their change. A panel above waits for the one
/// below, also where that one is not planned (none of its anchors was measured) and not said to be standing: it then
/// depends on a panel that the facade does not have. Directions are those of each anchor and panel, of as many facades
/// as there are; where one is not confirmed, what it concerns is noted and not planned. `state`: what hangs already is
/// not set any more, what was set before is no range any more. Throws std::runtime_error that says what is missing: no
/// direction of any anchor, no covariance, an anchor that no bracket rule selects, a dependence on an unknown panel, a
/// name in `standing` that is none. `control`: points of the model that all campaigns rest on; what the anchors'
/// covariance owes to them is no part of Facade::own. Where none of them is in the model, what campaigns share is not
/// known, and Facade::own stays empty.
FacadeInput facade_of(const DeviationT& deviation, const PointsT& model, const DesignT& design, const LoopStateT* state,
                      const FacadeRules& rules, const std::vector<std::string>& control = {});

}  // namespace plumbline::loop
