// Solutions with a symmetric positive definite block matrix that has no room for a factor: conjugate gradients, with
// the inverses of the diagonal blocks as preconditioner. It takes a few vectors beside the matrix, and no more: no
// entry of the inverse, so no standard deviation, and no rank.
//
// Source: Hestenes & Stiefel (1952), Methods of Conjugate Gradients for Solving Linear Systems.
#pragma once

#include <Eigen/Core>

#include "least_squares/sparse/pattern.hpp"

namespace plumbline::least_squares {

struct GradientOptions {
  /// Ends when the residual, measured by the preconditioner (r' M⁻¹ r)^½, is this part of that of x = 0.
  double tolerance = 1e-3;
  int max_steps = 1000;  ///< then the solution is what there is: still a direction that lowers x' A x / 2 − b' x
};

class ConjugateGradients {
 public:
  /// False if a diagonal block is not positive definite; undetermined() says which. The matrix must outlive this.
  bool prepare(const SymmetricBlocks& matrix);
  int undetermined() const { return undetermined_; }

  struct Solution {
    Eigen::VectorXd x;  ///< x' (b − A x) = 0 but for rounding, whenever it ends
    int steps = 0;
    bool reached = false;  ///< the tolerance
  };
  /// From x = 0. The same input gives the same bits. Takes part in stop_point().
  Solution solve(const Eigen::VectorXd& right, const GradientOptions& options = {}) const;

 private:
  Eigen::VectorXd precondition(const Eigen::VectorXd& residual) const;

  const SymmetricBlocks* matrix_ = nullptr;
  std::vector<Eigen::MatrixXd> inverse_;  ///< of the diagonal blocks
  int undetermined_ = -1;
};

}  // namespace plumbline::least_squares
