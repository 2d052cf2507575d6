#include "geometry/panel_fit.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
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
  Eigen::Vector3d line = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const double value = eigen.eigenvalues()(i);
    const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
    if (value < kTurnArm * kTurnArm) {  // a turn about the line of the fixings
      line = axis;
      continue;
    }
    rotation += axis * (arms * axis).transpose() / value;
    ++fit.rotations;
  }
  fit.residual = Eigen::MatrixXd::Identity(3 * n, 3 * n) - arms * rotation;
  for (Eigen::Index i = 0; i < n; ++i) fit.residual.middleRows<3>(3 * i) -= average;
  fit.pose.resize(6, 3 * n);
  fit.pose.topRows<3>() = average - skew(centre - mean) * rotation;
  fit.pose.bottomRows<3>() = rotation;
  if (fit.rotations == 2) fit.open << line.cross(centre - mean), line;
  return fit;
}

namespace {

/// Movement of a place along a direction from the motion of the centre.
Eigen::Matrix<double, 1, 6> movement_of(const Eigen::Vector3d& place, const Eigen::Vector3d& centre,
                                        const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 1, 6> row;
  row << direction.transpose(), (place - centre).cross(direction).transpose();
  return row;
}

}  // namespace

std::optional<Eigen::Matrix<double, 6, 1>> lift_of(const Eigen::Matrix<double, 6, 1>& open, double turn,
                                                   const Eigen::Matrix<double, 1, 6>& held) {
  const double moved = held.dot(open);
  if (!(turn > 0) || std::abs(moved) <= kOpenArm * turn) return {};
  return open / moved;
}

std::optional<HeldMotion> hold_edge(const PanelMotion& hung, const Eigen::Vector3d& centre, const HeldEdge& edge) {
  if (hung.rotations != 2) return {};
  const Eigen::Index n = hung.pose.cols();
  const auto middle = movement_of(0.5 * (edge.left + edge.right), centre, edge.out);
  const auto lift = lift_of(hung.open, hung.open.tail<3>().norm(), middle);
  if (!lift) return {};
  HeldMotion held;
  held.lift = *lift;
  held.motion.rotations = 3;
  held.motion.pose.resize(6, n + 2);
  held.motion.pose.leftCols(n) = hung.pose - *lift * (middle * hung.pose);
  held.motion.pose.rightCols<2>().colwise() = 0.5 * *lift;
  // A turn about their line moves no fixing.
  held.motion.residual = Eigen::MatrixXd::Zero(n, n + 2);
  held.motion.residual.leftCols(n) = hung.residual;
  held.twist = movement_of(edge.left, centre, edge.out) * held.motion.pose;
  held.twist[n] -= 1;
  return held;
}

double handed_on(const HeldMotion& held, const Eigen::Vector3d& centre, const Eigen::Vector3d& place,
                 const Eigen::Vector3d& out) {
  return movement_of(place, centre, out).dot(held.lift);
}

double distance_from_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& point) {
  return (low - point).cwiseMax(point - high).cwiseMax(0.0).norm();
}

}  // namespace plumbline
