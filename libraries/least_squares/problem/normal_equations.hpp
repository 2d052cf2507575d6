// Sparse normal equations N dx = -g with N = J'J, g = J'u, and their factorisation. N is scaled to a unit diagonal
// before it is factorised, so that metres, radians and pixels can be mixed and rank decisions do not depend on units.
#pragma once

#include <Eigen/SparseCore>
#include <functional>
#include <memory>
#include <vector>

#include "least_squares/problem/problem.hpp"

namespace plumbline::least_squares {

class NormalEquations {
 public:
  /// Builds the sparsity pattern once for all iterations.
  NormalEquations(const Linearisation& linearisation, int unknowns);
  void assemble(const Linearisation& linearisation);

  int size() const { return static_cast<int>(scale_.size()); }
  /// Lower triangle of S^-1 N S^-1 with S = diag(scale()).
  const Eigen::SparseMatrix<double>& scaled() const { return scaled_; }
  /// Square roots of the diagonal of N; 1 where no observation depends on the unknown.
  const Eigen::VectorXd& scale() const { return scale_; }
  const Eigen::VectorXd& gradient() const { return gradient_; }  ///< g = J'u, unscaled

 private:
  Eigen::SparseMatrix<double> scaled_;
  std::vector<int> positions_;  // of each product of a block, into the values of scaled_
  Eigen::VectorXd scale_, gradient_;
};

/// L D L' of a symmetric sparse matrix with fill-reducing order, and what is computed from it.
class SparseFactor {
 public:
  SparseFactor();
  ~SparseFactor();
  SparseFactor(SparseFactor&&) noexcept;
  SparseFactor& operator=(SparseFactor&&) noexcept;

  /// Factorises `lower` + shift I, with the rows and columns of `pinned` replaced by those of the identity, so that
  /// solutions with a zero right side there stay zero. False if a pivot is not safely positive.
  bool factorise(const Eigen::SparseMatrix<double>& lower, double shift, const std::vector<int>& pinned);
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_side) const;
  /// The full inverse, n x n. Work is split over oneTBB's threads; the result does not depend on their number.
  Eigen::MatrixXd inverse() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Runs body(first, last) on oneTBB's threads, as many as the program allows, over disjoint ranges that cover [0,
/// count). The body's result must not depend on the split. An exception of a body is thrown again here.
void parallel_ranges(int count, int grain, const std::function<void(int, int)>& body);

}  // namespace plumbline::least_squares
