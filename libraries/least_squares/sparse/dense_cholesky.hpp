// Cholesky factor of a dense symmetric matrix and its inverse, by blocks on the kernels of this folder: twice as fast
// as a baseline build of Eigen's where the processor has AVX2, and with the same bits where it has not.
#pragma once

#include <Eigen/Core>

namespace plumbline::least_squares {

/// L⁻¹ of a lower triangle (column-major, `stride` from column to column); above its diagonal it is zero.
Eigen::MatrixXd inverse_of_lower(const double* lower, std::ptrdiff_t stride, int size);

class Cholesky {
 public:
  /// Takes the lower triangle. False if a pivot is not positive or no number.
  bool compute(Eigen::MatrixXd lower);
  Eigen::Index size() const { return factor_.rows(); }
  /// The smallest of the squared diagonal: what the unknowns before it do not tell of an unknown.
  double smallest_pivot() const { return factor_.diagonal().cwiseAbs2().minCoeff(); }
  void solve_in_place(Eigen::Ref<Eigen::MatrixXd> right) const;
  void solve_in_place(Eigen::VectorXd& right) const;
  void half_solve_in_place(Eigen::Ref<Eigen::MatrixXd> right) const;  ///< L⁻¹ right
  /// L⁻¹: the block of it that belongs to the unknowns from `first` on. Above its diagonal it is zero.
  Eigen::MatrixXd inverse_factor(Eigen::Index first = 0) const {
    const Eigen::Index n = factor_.rows() - first;
    return inverse_of_lower(n > 0 ? &factor_(first, first) : nullptr, factor_.rows(), static_cast<int>(n));
  }
  /// The symmetric inverse: the block of it that belongs to the unknowns from `first` on.
  Eigen::MatrixXd inverse(Eigen::Index first = 0) const { return inverse_of(inverse_factor(first)); }
  /// L⁻ᵀ L⁻¹ of a lower triangular L⁻¹.
  static Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& inverse_factor);

 private:
  Eigen::MatrixXd factor_;  ///< L in its lower triangle; above it anything
};

}  // namespace plumbline::least_squares
