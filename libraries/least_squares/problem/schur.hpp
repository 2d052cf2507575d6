// Normal equations with one class of unknowns eliminated, for problems in which a group of unknowns (the six of a
// camera pose) never meets another such group in an observation: that part of the normal matrix is block-diagonal and
// is eliminated group by group. What is kept (points, calibrations, scales) may be coupled in any way. The reduced
// normal matrix is that of the kept unknowns with the others eliminated, so its inverse is their *marginal* cofactor
// matrix. The sparse solver of this folder (solver.hpp) needs no such structure; with hundreds of images over the same
// points its factor would fill up. Source: Förstner & Wrobel (2016), Photogrammetric Computer Vision, 15.3
// (elimination) and 4.5 (free adjustment).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "least_squares/problem/reliability.hpp"

namespace plumbline::least_squares {

/// Some rows of the design matrix that share their unknowns, whitened: multiplied from the left by W with W'W = Σ⁻¹.
struct ObservationRows {
  int group = 0;               ///< variance component, index into PartitionedSystem::groups
  int label = 0;               ///< the caller's number of this observation, handed through
  int eliminated = -1;         ///< index of the eliminated block, or -1 for rows without one
  std::vector<int> columns;    ///< kept unknowns the rows depend on, each once
  Eigen::MatrixXd kept;        ///< rows × columns.size(), derivative of the whitened computed value
  Eigen::MatrixXd own;         ///< rows × eliminated_size, or empty without an eliminated block
  Eigen::VectorXd misclosure;  ///< whitened observed minus computed
};

/// A problem at one linearisation point.
struct PartitionedSystem {
  int kept_count = 0;
  int eliminated_count = 0;  ///< blocks
  int eliminated_size = 6;   ///< unknowns of each
  std::vector<std::string> groups;
  std::vector<ObservationRows> observations;
  /// Null space of all that is observed (kept_count × defect) and the kept unknowns that hold the datum: inner
  /// constraints, see datum.hpp. Both empty if the observations fix the datum.
  Eigen::MatrixXd null_space;
  std::vector<int> datum_unknowns;

  int row_count() const;
  int unknown_count() const { return kept_count + eliminated_size * eliminated_count; }
  int defect() const { return static_cast<int>(null_space.cols()); }
  /// Rows − unknowns + datum constraints.
  int redundancy() const { return row_count() - unknown_count() + defect(); }
};

/// What remains of one block after its elimination.
struct EliminatedBlock {
  std::vector<int> columns;  ///< kept unknowns the block's observations depend on, ascending
  Eigen::MatrixXd coupling;  ///< eliminated_size × columns.size(): normal matrix between the two classes
  Eigen::MatrixXd inverse;   ///< of the block's own normal matrix; zero if that is singular
  Eigen::VectorXd right;
  double weakest_eigenvalue = 0;  ///< smallest eigenvalue of the block's own normal matrix after Jacobi scaling
};

/// Normal equations of the kept unknowns with the others eliminated.
struct ReducedSystem {
  Eigen::MatrixXd normal;    ///< kept × kept
  Eigen::VectorXd right;     ///< kept
  Eigen::VectorXd diagonal;  ///< of the kept unknowns' normal matrix *before* the elimination: the scale rank decisions
                             ///< refer to
  std::vector<EliminatedBlock> eliminated;
};

/// Sums up the normal equations and eliminates. A block whose own normal matrix is singular (its smallest scaled
/// eigenvalue is below 1e-12) contributes nothing; the caller finds it by `weakest_eigenvalue` and reports it.
ReducedSystem reduce(const PartitionedSystem& system);

/// Corrections and cofactors (covariances for σ0 = 1) at one linearisation point.
struct PartitionedSolution {
  Eigen::VectorXd kept;                              ///< corrections
  std::vector<Eigen::VectorXd> eliminated;           ///< corrections of each block
  Eigen::MatrixXd kept_cofactor;                     ///< kept × kept, marginal
  std::vector<Eigen::MatrixXd> eliminated_cofactor;  ///< of each block, marginal
};

/// Solves without cofactors; false if the reduced matrix, with the inner constraints added, has no Cholesky factor.
bool solve_corrections(const PartitionedSystem& system, const ReducedSystem& reduced, PartitionedSolution& solution);

/// Adds the cofactors to a solution. Precondition: solve_corrections() succeeded on the same system.
void add_cofactors(const PartitionedSystem& system, const ReducedSystem& reduced, PartitionedSolution& solution);

/// Cofactors between an eliminated block and all kept unknowns, eliminated_size × kept_count.
Eigen::MatrixXd cross_cofactor(const EliminatedBlock& block, const Eigen::MatrixXd& kept_cofactor);

/// Cofactor matrices of the residuals, one for each of system.observations, in whitened rows: Q_vv = I − A Q A'; what
/// row_statistics() takes. Precondition: `solution` has its cofactors.
std::vector<Eigen::MatrixXd> residual_cofactors(const PartitionedSystem& system, const ReducedSystem& reduced,
                                                const PartitionedSolution& solution);

/// One entry for each of system.groups. Precondition: misclosures are those after the adjustment.
std::vector<VarianceComponent> variance_components(const PartitionedSystem& system,
                                                   const std::vector<Eigen::MatrixXd>& cofactors);

/// Smallest eigenvalue of the scaled system below, by inverse iteration (an upper bound, within a few per cent after 12
/// steps); 0 if the matrix has no Cholesky factor. Cheap: the full spectrum is needed only to say *what* is
/// undetermined.
double smallest_scaled_eigenvalue(const PartitionedSystem& system, const ReducedSystem& reduced);

/// Eigenvalues, ascending, and vectors of the reduced normal matrix (inner constraints added), scaled by
/// `diagonal`^(-1/2). The vectors are scaled back to unknowns and have the length 1 in units of the scale.
struct ScaledSpectrum {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
ScaledSpectrum scaled_spectrum(const PartitionedSystem& system, const ReducedSystem& reduced);

}  // namespace plumbline::least_squares
