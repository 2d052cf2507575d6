// What a survey that proves nothing ends with, wherever it is delivered.
#pragma once

#include "artifacts/survey_network.hpp"

namespace plumbline::survey {

/// True if no judgement may rest on this network: it contradicts itself, nothing controls it, known points contradict
/// it, or which of two readings is wrong nobody can tell. By the one law of trust (building/judgement/trust.hpp), so
/// that a survey alone ends as a judgement of it would. A network that fits less well than stated is no such.
bool proves_nothing(SurveyNetworkT& network);

}  // namespace plumbline::survey
