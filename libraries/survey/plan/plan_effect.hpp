// What a sight or a set-up more would do to the precision of heights, from the covariance of the plan alone: an update
// instead of another adjustment.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "survey/plan/plan_layout.hpp"

namespace plumbline::survey {

using Sight = std::pair<size_t, size_t>;  ///< set-up, marker

/// Sights that are possible but not planned, of any set-up, onto markers that `wanted` takes.
std::vector<Sight> spare_sights(const PlanLayout& layout, const std::function<bool(size_t)>& wanted);

/// Sights that bring the step between two floors to the wanted sigma [m], each the one that helps most after those
/// before it; empty if `most` do not suffice.
std::vector<Sight> sights_for_transfer(const PlanLayout& layout, const PlanPrediction& prediction,
                                       const PlanOptions& options, int lower, int upper, double wanted, size_t most);

/// Standard deviation [m] of a linear function of heights with the last set-up of `trial` added to `layout`. Its place
/// and orientation are eliminated from its readings by their null space; what is left updates the covariance of the
/// markers.
double height_sigma_with(const PlanLayout& layout, const PlanPrediction& prediction, const PlanOptions& options,
                         const PlanLayout& trial, const HeightWeights& weights);

}  // namespace plumbline::survey
