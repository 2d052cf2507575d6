#include "geometry/panel_fit.hpp"

#include <Eigen/Eigenvalues>
#include <stdexcept>

#include "plumbline/rigid_transform.hpp"

namespace plumbline {

PanelMotion fit_panel(const std::vector<Eigen::Vector3d>& fixings, const Eigen::Vector3d& centre) {
  if (fixings.empty()) throw std::logic_error("fit_panel needs a fixing");
  const auto n = static_cast<Eigen::Index>(fixings.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : fixings) mean += p / static_cast<double>(n);
  // About the mean of the fixings translation and rotation separate, and the pseudo-inverse leaves what is not known at
  // zero.
  Eigen::MatrixXd arms(3 * n, 3), average(3, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    arms.middleRows<3>(3 * i) = -skew(fixings[i] - mean);
    average.middleCols<3>(3 * i) = Eigen::Matrix3d::Identity() / static_cast<double>(n);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(arms.transpose() * arms);
  PanelMotion fit;
  Eigen::MatrixXd rotation = Eigen::MatrixXd::Zero(3, 3 * n);
  for (int i = 0; i < 3; ++i) {
    const double value = eigen.eigenvalues()(i);
    if (value < 1e-4) continue;  // arms below a centimetre: a turn about the line of the fixings
    const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
    rotation += axis * (arms * axis).transpose() / value;
    ++fit.rotations;
  }
  fit.residual = Eigen::MatrixXd::Identity(3 * n, 3 * n) - arms * rotation;
  for (Eigen::Index i = 0; i < n; ++i) fit.residual.middleRows<3>(3 * i) -= average;
  fit.pose.resize(6, 3 * n);
  fit.pose.topRows<3>() = average - skew(centre - mean) * rotation;
  fit.pose.bottomRows<3>() = rotation;
  return fit;
}

double distance_from_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& point) {
  return (low - point).cwiseMax(point - high).cwiseMax(0.0).norm();
}

}  // namespace plumbline
