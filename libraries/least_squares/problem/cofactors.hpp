// Qxx of a solution. Of a problem with few unknowns the whole matrix; of one with many the entries where the factor has
// its own (selected inverse), and everything else by solves with it: exact either way, in the memory of two factors
// where the whole would take n^2.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "least_squares/problem/solver.hpp"

namespace plumbline::least_squares {

/// A linear function of the unknowns, sparse: unknown and coefficient.
using Functional = std::vector<std::pair<int, double>>;

class Cofactors {
 public:
  /// With more unknowns the whole matrix is not made: 128 MB.
  static constexpr int kLargestWhole = 4000;

  Cofactors() = default;
  /// Symmetric, n x n.
  explicit Cofactors(Eigen::MatrixXd whole);
  /// Of a solution, in its datum, a-priori variance of unit weight 1. Throws RankDefect as cofactor_matrix() does.
  explicit Cofactors(const Solution& solution, int largest_whole = kLargestWhole);

  int size() const { return size_; }
  bool is_whole() const { return !sparse_; }
  /// All of it, symmetric to the bit. Throws std::logic_error where it is not at hand.
  const Eigen::MatrixXd& whole() const;

  double operator()(int a, int b) const;
  /// In the order given; entries that the factor has at the cost of looking them up, others by a solve for each
  /// unknown.
  Eigen::MatrixXd joint(std::span<const int> unknowns) const;
  /// True if joint() of them needs no solve.
  bool has(std::span<const int> unknowns) const;
  /// Q x.
  Eigen::VectorXd times(const Eigen::VectorXd& x) const;
  /// f'Qf of each.
  Eigen::VectorXd variances(const std::vector<Functional>& functionals) const;

  /// Q := factor Q, as a variance of unit weight does.
  void multiply(double factor);

 private:
  struct Sparse;
  Eigen::MatrixXd without_datum(std::span<const int> unknowns) const;
  std::optional<Eigen::MatrixXd> joint_blocks(const std::vector<int>& blocks) const;
  std::vector<int> blocks_of(std::span<const int> unknowns) const;

  int size_ = 0;
  Eigen::MatrixXd whole_;
  std::shared_ptr<const Sparse> sparse_;
  double factor_ = 1;  ///< of what sparse_ has
};

}  // namespace plumbline::least_squares
