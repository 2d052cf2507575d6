#include "evaluate/point_input.hpp"

#include <cmath>

#include "geometry/packed_symmetric.hpp"

namespace plumbline::evaluate {

namespace {

Eigen::MatrixXd covariance_of(const PointsT& points, const std::string& what) {
  const auto n = static_cast<Eigen::Index>(3 * points.points.size());
  if (points.covariance.empty()) {
    Eigen::MatrixXd s = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      s(i, i) = std::pow(points.points[static_cast<std::size_t>(i / 3)]->sigma[i % 3], 2);
    return s.allFinite() ? s : Eigen::MatrixXd();
  }
  return unpack_symmetric(points.covariance, static_cast<std::size_t>(n), "input '" + what + "'");
}

}  // namespace

PointSet point_set(const PointsT& points, const std::string& what) {
  PointSet set;
  for (const auto& point : points.points) {
    set.ids.push_back(point->id);
    set.positions.push_back(point->position);
  }
  set.covariance = covariance_of(points, what);
  return set;
}

}  // namespace plumbline::evaluate
