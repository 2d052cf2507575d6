// Points that an adjustment holds without error, each tested as one hypothesis: that it lies elsewhere.
#pragma once

#include <vector>

#include "survey/network/network_model.hpp"

namespace plumbline::survey {

/// Variance of coordinates that are written in whole millimetres, off by half of one at most, evenly [m^2]; 0 where one
/// of them has more digits.
double rounding_variance(const std::vector<double>& coordinates);

/// Points of which a coordinate is held, without their critical values; `cofactors` a priori. Rank 0: nothing says
/// where such a point lies but itself.
std::vector<KnownPoint> test_held_points(const NetworkModel& model, const NetworkProblem& problem,
                                         const least_squares::Solution& solution,
                                         const least_squares::Cofactors& cofactors);

}  // namespace plumbline::survey
