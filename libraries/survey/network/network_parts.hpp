// How the points of a network hang together.
#pragma once

#include <set>
#include <vector>

#include "survey/network/network_model.hpp"

namespace plumbline::survey {

/// Connected parts of the network: for each parameter block the number of a block that stands for its part. Unknowns
/// common to all observations (scale, refraction) connect nothing.
std::vector<int> parts_of(const NetworkProblem& problem);

/// Points that share an observation, per point.
std::vector<std::set<int>> neighbours_of(const NetworkProblem& problem);

/// Groups of points that are connected with each other through `hinge` only, the smallest first; one group if it is
/// no hinge.
std::vector<std::vector<int>> groups_behind(int hinge, const std::vector<std::set<int>>& neighbours);

}  // namespace plumbline::survey
