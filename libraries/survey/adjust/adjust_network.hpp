// Adjustment of a survey network: from readings to coordinates with full covariance, tests, and words about what is
// wrong.
#pragma once

#include <memory>

#include "survey/model/network_result.hpp"
#include "survey/model/station_reduction.hpp"

namespace plumbline::survey {

/// Throws NetworkError: no observations, undetermined coordinates, rank defect (named), no convergence.
NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control = {});

class KeptNetwork;  // kept_network.hpp
/// The same, and the adjusted network itself, for who goes on from there.
NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control, std::unique_ptr<KeptNetwork>& kept);

}  // namespace plumbline::survey
