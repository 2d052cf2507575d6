// Cholesky factor of a sparse symmetric positive definite matrix by supernodes, and all that is asked of its inverse.
//
//   Pattern pattern(sizes);                       // blocks of unknowns, in the caller's numbers
//   pattern.couple(a, b); ...                     // or couple(span) for all that meet in one observation
//   auto analysis = std::make_shared<const Analysis>(pattern);    // order and structure, once
//   analysis->bytes();                            // of a factor; announce it before it is made
//   SymmetricBlocks normal(pattern);
//   normal.add(a, b, JaᵀJb); ...                  // every iteration; a ≥ b or not
//   SparseCholesky factor(analysis);
//   if (!factor.factorise(normal)) ...            // factor.undetermined() names unknowns that are open
//   x = factor.solve(right);
//   SelectedInverse inverse(factor);              // selected_inverse.hpp: all entries on the factor's pattern
//   inverse.block(a, b);                          // cofactors of blocks that meet
//   factor.columns(unknowns), factor.cofactors(blocks), factor.covariance(functionals);   // anything else, by solves
//
// Everything is in the caller's numbers of blocks and unknowns (block after block). The same input gives the same bits.
// Sources: Ng & Peyton (1993), Block sparse Cholesky algorithms on advanced uniprocessor computers; Davis (2006),
// Direct Methods for Sparse Linear Systems.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "least_squares/sparse/analysis.hpp"

namespace plumbline::least_squares {

/// An unknown of which those that are eliminated before it leave next to nothing: it, or what it could be exchanged
/// with, is not determined.
struct Undetermined {
  int block = 0, component = 0;
  double pivot = 0;  ///< what is left of its diagonal element, relative to that
};

/// What is factorised in place of N: diag(scale) N diag(scale) + diag(added); empty vectors change nothing.
struct Scaling {
  Eigen::VectorXd scale, added;
};

class SparseCholesky {
 public:
  static constexpr double default_tolerance = 1e-12;

  explicit SparseCholesky(std::shared_ptr<const Analysis> analysis);

  /// False if a pivot is below `tolerance` times its diagonal element, or no number: undetermined() then has one entry
  /// for each of the matrix' rank defects, and the factor is that of the matrix with those unknowns held (solutions and
  /// inverse are zero there). `matrix` is one on the pattern of the analysis.
  bool factorise(const SymmetricBlocks& matrix, double tolerance = default_tolerance, const Scaling& scaling = {});
  const std::vector<Undetermined>& undetermined() const { return undetermined_; }
  bool is_regular() const { return undetermined_.empty(); }

  /// N⁻¹ right, n × d.
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& right) const;
  /// L⁻¹ P right: its rows are in the order of the elimination. rightᵀ N⁻¹ right is its Gram matrix.
  Eigen::MatrixXd half_solve(const Eigen::Ref<const Eigen::MatrixXd>& right) const;
  /// Columns of the inverse, n × unknowns.size().
  Eigen::MatrixXd columns(std::span<const int> unknowns) const;
  /// Joint cofactors of all unknowns of some blocks, in the order given.
  Eigen::MatrixXd cofactors(std::span<const int> blocks) const;
  /// Fᵀ N⁻¹ F of linear functionals F, n × k.
  Eigen::MatrixXd covariance(const Eigen::Ref<const Eigen::MatrixXd>& functionals) const;

  const Analysis& analysis() const { return *analysis_; }
  std::shared_ptr<const Analysis> shared_analysis() const { return analysis_; }
  /// Panels of the supernodes one behind the other: L, with anything above its diagonal.
  const std::vector<double>& values() const { return values_; }
  /// The same for who goes on in their memory.
  std::vector<double> release() && { return std::move(values_); }

 private:
  void scatter(const SymmetricBlocks& matrix, const Scaling& scaling);
  void add_updates(const Analysis::Supernode& target, std::vector<int>& place, std::vector<double>& work);
  void factor_panel(const Analysis::Supernode& s, double tolerance);
  void factor_holding(const Analysis::Supernode& s, int at, int width, double tolerance);
  Eigen::MatrixXd to_elimination_order(const Eigen::Ref<const Eigen::MatrixXd>& right) const;
  Eigen::MatrixXd to_given_order(const Eigen::Ref<const Eigen::MatrixXd>& solution) const;
  void solve_forward(Eigen::MatrixXd& x) const;
  void solve_backward(Eigen::MatrixXd& x) const;
  void solve_forward(Eigen::VectorXd& x) const;
  void solve_backward(Eigen::VectorXd& x) const;

  std::shared_ptr<const Analysis> analysis_;
  std::vector<double> values_, diagonal_;  ///< diagonal_: of the matrix, by position
  std::vector<Undetermined> undetermined_;
};

}  // namespace plumbline::least_squares
