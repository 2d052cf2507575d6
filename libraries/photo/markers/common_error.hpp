// What an error that many image points have in common does to what is estimated from them.
//
// The detector states of a photograph of tags by how far it may draw all edges inwards together (transfer curve, halo,
// JPEG). No scatter of the corners shows that, so it is carried beside their covariance: as one quantity of standard
// deviation 1 whose effect is added to the covariance as its product with itself. Between two results that share it,
// only the difference of their effects counts.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "photo/bundle/problem.hpp"

namespace plumbline::markers {

/// How all unknowns (in the order of the layout) move, to first order, if the image points were measured `moved` [px]
/// further, one each. `state` is the minimum. Throws std::runtime_error if the normal equations cannot be solved there.
Eigen::VectorXd effect_of(const bundle::Problem& problem, const bundle::Layout& layout, const bundle::State& state,
                          const std::vector<Eigen::Vector2d>& moved);

}  // namespace plumbline::markers
