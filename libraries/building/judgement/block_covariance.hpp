// The covariance of many points, of which most may know nothing of one another: kept in dense blocks of those that do.
// Ten thousand anchors that were measured one by one need 0.7 MB so, and 7.2 GB as one matrix.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <span>
#include <string>
#include <vector>

#include "building/judgement/symmetric_matrix.hpp"

namespace plumbline::judgement {

class BlockCovariance {
 public:
  using Index = Eigen::Index;
  /// Items that are correlated, directly or by way of others, ascending, and their covariance.
  struct Cluster {
    std::vector<Index> items;
    SymmetricMatrix matrix;
  };

  /// Not known.
  BlockCovariance() = default;
  /// Of items with `step` coordinates each, 3 of points; zeros between items keep them apart. 0 x 0: not known.
  BlockCovariance(const Eigen::MatrixXd& full, Index step = 3);  // NOLINT: a matrix is one
  template <typename Derived>
  BlockCovariance(const Eigen::MatrixBase<Derived>& full, Index step = 3)  // NOLINT: and so is what makes one
      : BlockCovariance(Eigen::MatrixXd(full), step) {}
  /// Of items without correlation between them, 3 x 3 [m²] each.
  static BlockCovariance independent(const std::vector<Eigen::Matrix3d>& blocks);
  /// Of n points, from the lower triangle row by row as artifacts have it. `values` must outlive it: a large part is
  /// read where it lies. Throws std::runtime_error that says what is wrong with the covariance `of` something.
  static BlockCovariance from_packed(std::span<const double> values, std::size_t points, const std::string& of);
  /// The same with an error that all of them have in common besides.
  void set_common(const Eigen::MatrixXd& covariance) { common_ = covariance; }
  const Eigen::MatrixXd& common() const { return common_; }  ///< 0 x 0: none; it is in no cluster
  /// Of clusters that hold each of n items once.
  BlockCovariance(std::vector<Cluster> clusters, Index items, Index step);

  Index size() const { return items() * step_; }  ///< rows; 0: not known
  Index step() const { return step_; }            ///< coordinates of an item
  Index items() const { return static_cast<Index>(where_.size()); }
  const std::vector<Cluster>& clusters() const { return clusters_; }
  std::vector<Cluster>& clusters() { return clusters_; }  ///< to work on their matrices
  std::size_t cluster_of(Index item) const { return where_[item].cluster; }

  double operator()(Index row, Index column) const;
  /// Of two points.
  Eigen::Matrix3d block(Index a, Index b) const;
  Eigen::VectorXd diagonal() const;
  double trace() const { return diagonal().sum(); }
  double sum() const;
  double squaredNorm() const;
  bool allFinite() const;
  /// wᵀ S w.
  double quadratic(const Eigen::SparseVector<double>& weights) const;
  /// As one matrix, of all or of some items.
  Eigen::MatrixXd dense() const;
  Eigen::MatrixXd dense(const std::vector<std::size_t>& items) const;
  /// Of some items, each once, in their order.
  BlockCovariance subset(const std::vector<std::size_t>& items) const&;
  /// The same without a copy of what is taken whole.
  BlockCovariance subset(const std::vector<std::size_t>& items) &&;
  /// Of the third coordinates of points.
  BlockCovariance heights() const;

  BlockCovariance& operator*=(double factor);
  /// Adds to the covariance of a point with itself.
  void add(Index point, const Eigen::Matrix3d& more);

 private:
  struct Place {
    std::size_t cluster;
    Index at;
  };
  void index();
  template <typename Self>
  static BlockCovariance part_of(Self& self, const std::vector<std::size_t>& items);

  Index step_ = 3;
  std::vector<Cluster> clusters_;
  std::vector<Place> where_;  // of each item
  Eigen::MatrixXd common_;    // of every item with every item, step x step
};

/// Items that are joined by any pair, as ascending lists, the one with the lowest item first.
class Partition {
 public:
  explicit Partition(std::size_t items);
  bool join(std::size_t a, std::size_t b);  ///< false: they were
  std::vector<std::vector<std::size_t>> parts();

 private:
  std::size_t find(std::size_t item);
  std::vector<std::size_t> parent_;
};

}  // namespace plumbline::judgement
