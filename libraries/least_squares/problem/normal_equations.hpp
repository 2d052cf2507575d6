// Sparse normal equations N dx = -g with N = J'J, g = J'u, by the blocks of unknowns of a problem, and their
// factorisation. N is scaled to a unit diagonal before it is factorised, so that metres, radians and pixels can be
// mixed and rank decisions do not depend on units.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "least_squares/problem/problem.hpp"
#include "least_squares/sparse/sparse_cholesky.hpp"

namespace plumbline::least_squares {

class NormalEquations {
 public:
  /// Finds the pattern and the order of elimination once for all iterations. Where `like` has the same unknowns and all
  /// that meet here meet there (some observations fewer, other weights), its pattern and order are used.
  NormalEquations(const Linearisation& linearisation, const UnknownIndex& unknowns,
                  const NormalEquations* like = nullptr);
  void assemble(const Linearisation& linearisation);

  int size() const { return static_cast<int>(scale_.size()); }
  const SymmetricBlocks& blocks() const { return blocks_; }  ///< N, unscaled
  const std::shared_ptr<const Analysis>& analysis() const { return analysis_; }
  /// Block of an unknown, in the numbers of blocks() and of the analysis.
  int block_of(int unknown) const { return block_of_[unknown]; }
  /// S^-1 N S^-1 x with S = diag(scale()).
  Eigen::MatrixXd multiply_scaled(const Eigen::Ref<const Eigen::MatrixXd>& x) const;
  /// Square roots of the diagonal of N; 1 where no observation depends on the unknown.
  const Eigen::VectorXd& scale() const { return scale_; }
  const Eigen::VectorXd& gradient() const { return gradient_; }  ///< g = J'u, unscaled

 private:
  /// Unknowns of a residual block that are one block of the pattern: `first` among its columns.
  struct Part {
    int block, first, count;
  };
  std::vector<Part> parts_of(const Linearisation& linearisation, const Linearisation::Block& block) const;
  bool holds(const Linearisation& linearisation, const std::vector<int>& sizes) const;

  std::vector<int> block_of_;
  std::shared_ptr<const Analysis> analysis_;
  SymmetricBlocks blocks_;
  Eigen::VectorXd scale_, gradient_;
};

/// Cholesky factor of the scaled normal matrix.
class SparseFactor {
 public:
  /// Of S^-1 N S^-1 + shift I, with the rows and columns of `pinned` replaced by those of the identity, so that
  /// solutions with a zero right side there stay zero. False if a pivot is not safely positive.
  bool factorise(const NormalEquations& normal, double shift, const std::vector<int>& pinned);
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& right_side) const {
    return factor_->solve(right_side);
  }
  /// The full inverse, n x n. Work is split over oneTBB's threads; the result does not depend on their number.
  Eigen::MatrixXd inverse() const;
  const SparseCholesky& cholesky() const { return *factor_; }

 private:
  std::unique_ptr<SparseCholesky> factor_;
};

/// Runs body(first, last) on oneTBB's threads, as many as the program allows, over disjoint ranges that cover [0,
/// count). The body's result must not depend on the split. An exception of a body is thrown again here.
void parallel_ranges(int count, int grain, const std::function<void(int, int)>& body);

}  // namespace plumbline::least_squares
