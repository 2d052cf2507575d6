// The covariance of points that know of one another: a square, or the lower triangle of an artifact, read where it
// lies. Of 2400 points the triangle has 207 MB and a square beside it 415 MB more.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace plumbline::judgement {

class SymmetricMatrix {
 public:
  using Index = Eigen::Index;

  SymmetricMatrix() = default;
  SymmetricMatrix(Eigen::MatrixXd full) : full_(std::move(full)) {}  // NOLINT: a matrix is one
  /// Rows of some points, three each, of the packed lower triangle of many. `values` must outlive this.
  static SymmetricMatrix of_packed(std::span<const double> values, std::vector<Index> points);

  Index rows() const { return is_full() ? full_.rows() : 3 * static_cast<Index>(points_.size()); }
  bool is_full() const { return points_.empty(); }
  double operator()(Index row, Index column) const;
  /// Of two points.
  Eigen::Matrix3d block(Index a, Index b) const;
  Eigen::VectorXd diagonal() const;
  double sum() const;
  /// With `common`, 0 x 0 or that of each two items, added.
  double squared_norm(const Eigen::MatrixXd& common) const;
  /// Largest row sum of absolute values: no eigenvalue is larger.
  double row_sum_norm() const;
  bool all_finite() const;
  /// The product with some columns.
  Eigen::MatrixXd times(const Eigen::MatrixXd& right) const;
  /// As a square.
  Eigen::MatrixXd full() const;
  /// The square itself, to be worked on; made where it is none.
  Eigen::MatrixXd& made_full();
  /// Of some items of it, of `step` rows each; without a square where it is none.
  SymmetricMatrix of_items(const std::vector<Index>& items, Index step) const;

  SymmetricMatrix& operator*=(double factor);
  /// Adds to the covariance of a point with itself.
  void add(Index point, const Eigen::Matrix3d& more);

 private:
  double packed(Index row, Index column) const;
  /// Calls visit(row, its elements up to the diagonal) from the first row to the last.
  template <typename Visit>
  void visit_rows(const Visit& visit) const;

  Eigen::MatrixXd full_;
  std::span<const double> values_;
  std::vector<Index> points_;  ///< where they stand in the packed one; empty: it is full
  double factor_ = 1;
  std::vector<Eigen::Matrix3d> more_;  ///< what was added to each point; empty: nothing
};

}  // namespace plumbline::judgement
