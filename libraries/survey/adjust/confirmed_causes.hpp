// Hypotheses of what is wrong with a whole network, each with its counter-test: the network adjusted without it.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "survey/model/adjust_options.hpp"
#include "survey/model/network_result.hpp"

namespace plumbline::survey {

class KeptNetwork;

/// The network without any hypothesis (adjust_network.cpp).
NetworkResult adjust_as_it_is(const SurveyObservations& survey, const AdjustOptions& options,
                              const ControlPoints& control, std::unique_ptr<KeptNetwork>* kept);

/// The causes that the network itself confirms: adjusted without them, it is sound or nearly so. Worded with what came
/// of it; `now` is the sigma0 as it is, NaN: it could not be adjusted. Of causes why points were left out, those with
/// which fewer are.
std::vector<Finding> confirmed_causes(const SurveyObservations& survey, const AdjustOptions& options,
                                      const ControlPoints& control, double now,
                                      size_t fewer_left_out_than = std::numeric_limits<size_t>::max());

/// What is left of a network whose other points were left out may be sound: not if one mistake explains why they were,
/// and not if set-ups went with them, whose readings nothing has tested.
void explain_left_out(const SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control,
                      NetworkResult& result);

/// On a map all distances have one scale beside it: coordinates of a plane or of another map, or a geoid that nobody
/// gave. Those of these that take it away are named first.
void explain_scale(const SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control,
                   NetworkResult& result);

}  // namespace plumbline::survey
