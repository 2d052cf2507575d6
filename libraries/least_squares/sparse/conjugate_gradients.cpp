#include "least_squares/sparse/conjugate_gradients.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

#include "plumbline/stop.hpp"

namespace plumbline::least_squares {

bool ConjugateGradients::prepare(const SymmetricBlocks& matrix) {
  matrix_ = &matrix;
  inverse_.clear();
  undetermined_ = -1;
  for (int b = 0; b < matrix.block_count(); ++b) {
    const Eigen::LLT<Eigen::MatrixXd> factor(matrix.at(b, b));
    // Without a pivot that is left of a diagonal of one: see SparseCholesky::default_tolerance.
    bool regular = factor.info() == Eigen::Success;
    for (int c = 0; c < matrix.size(b) && regular; ++c)
      regular = std::pow(factor.matrixLLT()(c, c), 2) > 1e-12 * matrix.at(b, b)(c, c);
    if (!regular) {
      undetermined_ = b;
      return false;
    }
    inverse_.push_back(factor.solve(Eigen::MatrixXd::Identity(matrix.size(b), matrix.size(b))));
  }
  return true;
}

Eigen::VectorXd ConjugateGradients::precondition(const Eigen::VectorXd& residual) const {
  Eigen::VectorXd result(residual.size());
  for (int b = 0; b < matrix_->block_count(); ++b)
    result.segment(matrix_->offset(b), matrix_->size(b)).noalias() =
        inverse_[b] * residual.segment(matrix_->offset(b), matrix_->size(b));
  return result;
}

ConjugateGradients::Solution ConjugateGradients::solve(const Eigen::VectorXd& right,
                                                       const GradientOptions& options) const {
  Solution found;
  found.x = Eigen::VectorXd::Zero(right.size());
  Eigen::VectorXd residual = right, direction = precondition(residual);
  double square = residual.dot(direction);
  const double enough = options.tolerance * options.tolerance * square;
  found.reached = !(square > 0);
  while (!found.reached && found.steps < options.max_steps) {
    stop_point();
    const Eigen::VectorXd product = matrix_->multiply(direction);
    const double curvature = direction.dot(product);
    if (!(curvature > 0)) break;  // rounding has used up what was left
    ++found.steps;
    const double length = square / curvature;
    found.x += length * direction;
    residual -= length * product;
    const Eigen::VectorXd next = precondition(residual);
    const double before = std::exchange(square, residual.dot(next));
    found.reached = !(square > enough);
    direction = next + square / before * direction;
  }
  return found;
}

}  // namespace plumbline::least_squares
