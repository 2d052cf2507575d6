#include "base/statistics/error_modes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "base/statistics/not_a_number.hpp"
#include "geometry/linear_algebra/decompositions.hpp"

namespace plumbline::statistics {

namespace {

constexpr double kFlat = 1e-6;  ///< of the extent: points that are this flat show no motion

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// `part` of the unknowns that `estimate` takes from the errors moves the points by `motion` times the part.
StatedError stated(const MatrixXd& motion, const MatrixXd& estimate, double points, const VectorXd& errors,
                   const MatrixXd& covariance) {
  const VectorXd part = estimate * errors;
  StatedError result{std::sqrt((motion * part).squaredNorm() / points), kNan, kNan, kNan};
  if (covariance.size() == 0) return result;
  const MatrixXd of_part = estimate * covariance * estimate.transpose();
  result.predicted = std::sqrt((motion.transpose() * motion * of_part).trace() / points);
  result.freedom = static_cast<double>(part.size());
  const Eigen::LLT<MatrixXd> factor(of_part);
  if (factor.info() == Eigen::Success) result.nees = part.dot(factor.solve(part));
  return result;
}

}  // namespace

std::vector<ErrorMode> error_modes(const VectorXd& positions, const VectorXd& errors, const MatrixXd& covariance) {
  const Index n = positions.size() / 3;
  std::vector<ErrorMode> modes;
  if (n == 0) return modes;
  Vector3d centre = Vector3d::Zero();
  for (Index i = 0; i < n; ++i) centre += positions.segment<3>(3 * i) / static_cast<double>(n);
  const MatrixXd unit = MatrixXd::Identity(3 * n, 3 * n);
  MatrixXd motions(3 * n, 7);
  std::vector<Index> heights, plan;
  for (Index i = 0; i < n; ++i) {
    const Vector3d from_centre = positions.segment<3>(3 * i) - centre;
    heights.push_back(3 * i + 2);
    plan.insert(plan.end(), {3 * i, 3 * i + 1});
    motions.block<3, 3>(3 * i, 0).setIdentity();
    motions.block<3, 1>(3 * i, 3) = Vector3d::UnitZ().cross(from_centre);
    motions.block<3, 1>(3 * i, 4) = Vector3d::UnitX().cross(from_centre);
    motions.block<3, 1>(3 * i, 5) = Vector3d::UnitY().cross(from_centre);
    motions.block<3, 1>(3 * i, 6) = from_centre;
  }
  // The unknowns of a similarity, estimated together as a Helmert transformation does.
  const double extent = motions.col(6).norm();
  std::vector<Index> shown;
  for (Index k = 0; k < 7; ++k)
    if (k < 3 || motions.col(k).norm() > kFlat * extent) shown.push_back(k);
  if (!(extent > 0)) shown.resize(3);
  const MatrixXd estimate = linear_algebra::pseudo_inverse(motions(Eigen::all, shown));
  const auto points = static_cast<double>(n);
  modes.push_back(
      {"heights", stated(unit(Eigen::all, heights), unit(heights, Eigen::all), points, errors, covariance)});
  modes.push_back({"plan", stated(unit(Eigen::all, plan), unit(plan, Eigen::all), points, errors, covariance)});
  const auto add = [&](const char* name, Index first, Index last) {
    std::vector<Index> columns, rows;
    for (std::size_t row = 0; row < shown.size(); ++row)
      if (shown[row] >= first && shown[row] <= last)
        columns.push_back(shown[row]), rows.push_back(static_cast<Index>(row));
    if (columns.empty()) return;
    modes.push_back(
        {name, stated(motions(Eigen::all, columns), estimate(rows, Eigen::all), points, errors, covariance)});
  };
  add("shift", 0, 2);
  add("turn", 3, 3);
  add("tilt", 4, 5);
  add("scale", 6, 6);
  return modes;
}

}  // namespace plumbline::statistics
