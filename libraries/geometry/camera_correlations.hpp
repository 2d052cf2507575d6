// The covariance of an interior orientation as files state it: standard deviations, and the correlations below the
// diagonal.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/camera.hpp"

namespace plumbline {

/// Row k: the correlations of parameter k with those before it, k values, or none where it has no correlation with
/// them.
using CameraCorrelations = std::array<std::vector<double>, InteriorOrientation::parameter_count>;

/// 9 × 9; empty if all standard deviations are 0. Throws std::runtime_error that says which row has another number of
/// values or a correlation outside of −1 to 1, and where the whole is no covariance: not positive definite in the
/// parameters whose standard deviation is not 0.
inline Eigen::MatrixXd camera_covariance(LensModel lens,
                                         const std::array<double, InteriorOrientation::parameter_count>& sigmas,
                                         const CameraCorrelations& correlations) {
  constexpr int all = InteriorOrientation::parameter_count;
  const auto names = InteriorOrientation::names_of(lens);
  const int count = static_cast<int>(names.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(all, all);
  std::vector<int> free;
  for (int k = 0; k < count; ++k) {
    const auto row = static_cast<std::size_t>(k);
    const std::string name = names[row];
    if (sigmas[row] > 0) free.push_back(k);
    covariance(k, k) = sigmas[row] * sigmas[row];
    if (correlations[row].empty()) continue;
    if (correlations[row].size() != row)
      throw std::runtime_error("the correlations of " + name + " are " + std::to_string(correlations[row].size()) +
                               " numbers, expected " + std::to_string(k) + ": with each parameter before it");
    for (int j = 0; j < k; ++j) {
      const double value = correlations[row][j];
      if (!(std::abs(value) <= 1))
        throw std::runtime_error("the correlation of " + name + " with " + std::string(names[j]) +
                                 " is not between -1 and 1");
      covariance(k, j) = covariance(j, k) = value * sigmas[row] * sigmas[j];
    }
  }
  if (free.empty()) return {};
  Eigen::VectorXd scale = covariance.diagonal()(free).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * covariance(free, free) * scale.asDiagonal();
  if (Eigen::LLT<Eigen::MatrixXd>(scaled).info() != Eigen::Success)
    throw std::runtime_error(
        "the correlations are of no covariance (not positive definite): written with too few digits, or changed by "
        "hand");
  return covariance;
}

}  // namespace plumbline
