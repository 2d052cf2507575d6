// The blurred step of edge_fit.hpp over many samples: residuals, derivatives and their sums of products.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "photo/detect/edge_samples.hpp"

namespace plumbline::detect {

/// a, b, c, log s, low at the middle, its slope, high at the middle, its slope.
using EdgeParameters = Eigen::Matrix<double, 8, 1>;
using EdgeNormal = Eigen::Matrix<double, 8, 8>;

/// What one evaluation of the model leaves for each sample: residual, and derivatives by position, log blur and the two
/// plateaus [grey values].
struct EdgeColumns {
  std::vector<float> residual, position, blur, low, high;
};

/// J^T r and r^T r.
struct EdgeGradient {
  EdgeParameters right = EdgeParameters::Zero();
  double sum = 0;
};

/// Fills `columns` at `p`. `box`: width of the pixel's box across the edge [px].
EdgeGradient evaluate(const EdgeSamples& samples, const EdgeParameters& p, double box, EdgeColumns& columns);

/// J^T J of the last evaluation.
EdgeNormal normal_matrix(const EdgeSamples& samples, const EdgeColumns& columns);

}  // namespace plumbline::detect
