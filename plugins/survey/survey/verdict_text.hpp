// The result of an adjustment as a surveyor reads it at the instrument: the verdict, the worst readings, what to
// measure again before it is packed.
#pragma once

#include <string>

#include "artifacts/survey_network.hpp"

namespace plumbline::survey {

std::string verdict_text(const SurveyNetworkT& network);

}  // namespace plumbline::survey
