#include "geometry/relative_points.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace plumbline {

ConfidenceEllipse confidence_ellipse(const Eigen::Matrix2d& c, double factor) {
  const double mean = 0.5 * (c(0, 0) + c(1, 1)), half = 0.5 * (c(0, 0) - c(1, 1));
  const double radius = std::hypot(half, c(0, 1));
  ConfidenceEllipse e;
  e.major = factor * std::sqrt(mean + radius);
  e.minor = factor * std::sqrt(std::max(0.0, mean - radius));
  e.azimuth = 0.5 * std::atan2(2 * c(0, 1), c(1, 1) - c(0, 0));
  if (e.azimuth < 0) e.azimuth += std::numbers::pi;
  return e;
}

Eigen::Matrix3d relative_covariance(const Eigen::MatrixXd& covariance, Eigen::Index a, Eigen::Index b) {
  const Eigen::Matrix3d ab = covariance.block<3, 3>(3 * a, 3 * b);
  return covariance.block<3, 3>(3 * a, 3 * a) + covariance.block<3, 3>(3 * b, 3 * b) - ab - ab.transpose();
}

std::vector<std::pair<int, int>> neighbours(const std::vector<Eigen::Vector3d>& positions, int count) {
  std::set<std::pair<int, int>> pairs;
  const int n = static_cast<int>(positions.size());
  for (int i = 0; i < n; ++i) {
    std::vector<std::pair<double, int>> distances;
    for (int j = 0; j < n; ++j) {
      const double d = (positions[i] - positions[j]).norm();
      if (j != i && std::isfinite(d)) distances.emplace_back(d, j);
    }
    const auto most = std::min(distances.size(), static_cast<std::size_t>(std::max(0, count)));
    std::partial_sort(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(most), distances.end());
    for (std::size_t k = 0; k < most; ++k)
      pairs.emplace(std::min(i, distances[k].second), std::max(i, distances[k].second));
  }
  return {pairs.begin(), pairs.end()};
}

}  // namespace plumbline
