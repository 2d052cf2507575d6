// Known points that somebody left out of an adjustment, held against what came of it: leaving out is no proof.
#pragma once

#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

/// Of every known point that `exclude` takes out of the control of `survey` and that the network has determined without
/// it: adjusted minus known, against the covariance of both. In the order of the exclusions; a point that nothing
/// measured has rank 0.
std::vector<KnownPoint> compare_with_left_out(const SurveyObservations& survey, const ControlPoints& control,
                                              const AdjustOptions& options, const NetworkResult& adjusted);

}  // namespace plumbline::survey
