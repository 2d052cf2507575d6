// Part of find_causes.cpp: mistakes in coordinates that were known before.
#pragma once

#include <string>
#include <vector>

#include "survey/model/adjust_options.hpp"
#include "survey/start/set_up_chain.hpp"

namespace plumbline::survey {

struct ControlCause {
  std::string text;
  std::vector<std::string> points;
  SurveyObservations survey;  ///< with the coordinates as they would be
  ControlPoints control;
  bool of_all_distances = false;  ///< the mistake is in each distance, such as another unit
};

/// Known points beside where the chain of set-ups sees them, in any levelled position: of all of them, or of those that
/// do not fit the most.
std::vector<ControlCause> control_causes(const SurveyObservations& survey, const ControlPoints& control,
                                         const SetUpChain& chain);

}  // namespace plumbline::survey
