#include "ellipsoid_artifact.hpp"

#include <algorithm>
#include <cmath>

#include "least_squares/problem/reliability.hpp"

namespace plumbline::survey {

std::unique_ptr<NetworkEllipsoidT> ellipsoid_artifact(const std::string& id, const Eigen::Matrix3d& given) {
  const Eigen::Matrix3d covariance = given.array().isNaN().select(0.0, given);
  const least_squares::ErrorEllipsoid ellipsoid = least_squares::error_ellipsoid(covariance);
  auto e = std::make_unique<NetworkEllipsoidT>();
  e->id = id;
  e->semi_axes = ellipsoid.semi_axes;
  e->first_axis = ellipsoid.axes.col(0);
  e->second_axis = ellipsoid.axes.col(1);
  const double mean = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double largest = mean + std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(0, 1));
  e->plan_semi_axis_95 = least_squares::confidence_factor(0.95, 2) * std::sqrt(std::max(0.0, largest));
  e->height_half_length_95 = least_squares::confidence_factor(0.95, 1) * std::sqrt(std::max(0.0, covariance(2, 2)));
  return e;
}

}  // namespace plumbline::survey
