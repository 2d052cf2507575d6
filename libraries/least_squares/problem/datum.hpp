// Rank and datum. A free network or block has directions in the space of unknowns that no observation sees
// (translations, rotations, scale, or a point that is not determined). They are found numerically, so nothing has to be
// told about the kind of problem; a datum then says which of the equivalent solutions is meant.
#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <string>
#include <vector>

#include "least_squares/problem/normal_equations.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::least_squares {

/// Orthonormal basis, n x d in scaled unknowns (S x), of the null space of the scaled normal matrix: eigenvalues <
/// tolerance, by shifted inverse subspace iteration with Rayleigh-Ritz (Parlett 1998, ch. 14). d = 0: regular.
Eigen::MatrixXd find_null_space(const NormalEquations& normal, double tolerance = 1e-9);

/// The system is rank deficient and the datum does not mend it. `directions` (n x k) are unit tangent steps (unscaled
/// unknowns, largest component 1) that change no observation and that the datum does not hold.
class RankDefect : public BadInput {
 public:
  RankDefect(const std::string& message, Eigen::MatrixXd unseen_directions)
      : BadInput(message), directions(std::move(unseen_directions)) {}
  Eigen::MatrixXd directions;
};

/// Inner constraints: of all solutions, the one with the smallest sum of squared changes of the `datum` unknowns
/// relative to their initial values, G' E (x - x0) = 0. Solved without losing sparsity: d unknowns are pinned, which
/// gives one of the solutions, and an S-transformation (Baarda 1973) leads to the wanted one.
class InnerConstraints {
 public:
  InnerConstraints() = default;
  /// Throws RankDefect if the null space (n x d, scaled) is not held by these unknowns.
  InnerConstraints(const NormalEquations& normal, const Eigen::MatrixXd& scaled_null_space,
                   const std::vector<int>& datum_unknowns);

  int defect() const { return static_cast<int>(pinned_.size()); }
  const std::vector<int>& pinned() const { return pinned_; }

  /// Null space at the current linearisation (n x d, unscaled), from the factor of the pinned scaled matrix.
  void update(const NormalEquations& normal, const SparseFactor& factor);
  const Eigen::MatrixXd& null_space() const { return null_space_; }

  /// The step along the null space that brings C'(x - x0) = 0 for the change x - x0 given; zero without defect.
  Eigen::VectorXd shift_for(const Eigen::VectorXd& change) const;
  /// Q := S Q S' with S = I - G (C'G)^-1 C'.
  void transform(Eigen::MatrixXd& cofactors) const;
  /// The same without Q itself: H, d x n, of S Q S' = Q - G H - (G H)', from Q C (n x d).
  const Eigen::MatrixXd& constraints() const { return constraints_; }  ///< C, n x d
  Eigen::MatrixXd half_change_of(const Eigen::MatrixXd& q_constraints) const;

 private:
  std::vector<int> pinned_;
  Eigen::MatrixXd constraints_;  // C, n x d: null space at the initial values, zero outside the datum
  Eigen::MatrixXd null_space_;   // G, n x d
};

/// Cofactors in another datum: Q2 = S Q S', S = I - G (G'EG)^-1 G'E with E selecting `datum_unknowns`. Throws
/// RankDefect if these do not hold the null space.
Eigen::MatrixXd s_transform(const Eigen::MatrixXd& cofactors, const Eigen::MatrixXd& null_space,
                            const std::vector<int>& datum_unknowns);

}  // namespace plumbline::least_squares
