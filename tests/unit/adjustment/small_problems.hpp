// Small problems whose answers are known by other means.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "least_squares/problem/problem.hpp"

namespace plumbline::least_squares::small {

/// v = A x - l for one scalar block of parameters.
class LinearResidual : public ResidualBlock {
 public:
  LinearResidual(Eigen::MatrixXd a, Eigen::VectorXd l) : a_(std::move(a)), l_(std::move(l)) {}
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    const Eigen::Map<const Eigen::VectorXd> x(values[0], a_.cols());
    Eigen::Map<Eigen::VectorXd>(residuals, a_.rows()) = a_ * x - l_;
    if (jacobians[0])
      Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(jacobians[0], a_.rows(), a_.cols()) = a_;
    return true;
  }

 private:
  Eigen::MatrixXd a_;
  Eigen::VectorXd l_;
};

/// Distance between two plane points.
class DistanceResidual : public ResidualBlock {
 public:
  explicit DistanceResidual(double distance) : distance_(distance) {}
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    const Eigen::Vector2d d = Eigen::Vector2d(values[1]) - Eigen::Vector2d(values[0]);
    const double s = d.norm();
    if (s < 1e-9) return false;
    residuals[0] = s - distance_;
    for (int k = 0; k < 2; ++k) {
      if (jacobians[0]) jacobians[0][k] = -d[k] / s;
      if (jacobians[1]) jacobians[1][k] = d[k] / s;
    }
    return true;
  }

 private:
  double distance_;
};

/// v = exp(k t) - l: Gauss-Newton overshoots from a poor start.
class ExponentialResidual : public ResidualBlock {
 public:
  ExponentialResidual(double t, double l) : t_(t), l_(l) {}
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    residuals[0] = std::exp(values[0][0] * t_) - l_;
    if (jacobians[0]) jacobians[0][0] = t_ * std::exp(values[0][0] * t_);
    return true;
  }

 private:
  double t_, l_;
};

/// v = A x - l of several scalars, each a block of parameters.
class ChainResidual : public ResidualBlock {
 public:
  ChainResidual(Eigen::MatrixXd a, Eigen::VectorXd l) : a_(std::move(a)), l_(std::move(l)) {}
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    for (Eigen::Index r = 0; r < a_.rows(); ++r) {
      residuals[r] = -l_[r];
      for (Eigen::Index k = 0; k < a_.cols(); ++k) {
        residuals[r] += a_(r, k) * values[k][0];
        if (jacobians[k]) jacobians[k][r] = a_(r, k);
      }
    }
    return true;
  }

 private:
  Eigen::MatrixXd a_;
  Eigen::VectorXd l_;
};

inline Problem linear_problem(const Eigen::MatrixXd& a, const Eigen::VectorXd& l, const Eigen::MatrixXd& covariance) {
  Problem problem;
  problem.parameters.push_back({"x", std::vector<double>(a.cols(), 0.0), {}});
  auto block = std::make_unique<LinearResidual>(a, l);
  block->set_covariance(covariance);
  block->parameters = {0};
  problem.residuals.push_back(std::move(block));
  return problem;
}

/// Four points of a plane trilateration network, all six distances, a small misfit in one; defect 3.
inline Problem trilateration(double misfit = 0.004) {
  Problem problem;
  const double points[4][2] = {{0, 0}, {100, 0}, {100, 80}, {0, 80}};
  for (const auto& p : points)
    problem.parameters.push_back({"P" + std::to_string(problem.parameters.size()), {p[0] + 0.01 * p[1], p[1]}, {}});
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const double exact = std::hypot(points[j][0] - points[i][0], points[j][1] - points[i][1]);
      auto block = std::make_unique<DistanceResidual>(exact + (i == 1 && j == 3 ? misfit : 0.0));
      block->set_sigmas(Eigen::VectorXd::Constant(1, 0.002));
      block->parameters = {i, j};
      problem.residuals.push_back(std::move(block));
    }
  return problem;
}

inline std::vector<int> all_unknowns(int count) {
  std::vector<int> result(count);
  for (int i = 0; i < count; ++i) result[i] = i;
  return result;
}

/// A chain of `n` unknowns, each a block of its own; as many as make a sparse system.
inline Problem chain(int n) {
  Problem problem;
  for (int i = 0; i < n; ++i) problem.parameters.push_back({"x" + std::to_string(i), {0.0}, {}});
  for (int i = 0; i + 2 < n; ++i) {
    Eigen::MatrixXd a(2, 3);
    a << -1, 1, 0, -1, 0, 1.5;
    auto block = std::make_unique<ChainResidual>(a, Eigen::Vector2d(1, 2));
    block->set_sigmas(Eigen::Vector2d(0.1 + 0.01 * i, 0.2));
    block->parameters = {i, i + 1, i + 2};
    problem.residuals.push_back(std::move(block));
  }
  return problem;
}

}  // namespace plumbline::least_squares::small
