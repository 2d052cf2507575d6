// The linearised bundle block: what a block adjustment looks like once the non-linear part is done.
//
// Unknowns fall into two classes. Camera poses (6 each) never meet another camera in an observation, so their part of
// the normal matrix is block-diagonal and they are eliminated. What is kept (object points, plate orientations,
// interior orientation, tag scales) may be coupled in any way: control with a full covariance matrix, scale bars, inner
// constraints. Because the reduced normal matrix is that of the kept unknowns with the cameras eliminated, its inverse
// is their *marginal* cofactor matrix. Source: Förstner & Wrobel (2016), Photogrammetric Computer Vision, 15.3
// (elimination) and 4.5 (free adjustment).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plumbline::adjust {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Some rows of the design matrix that share their unknowns, whitened: multiplied from the left by W with WᵀW = Σ⁻¹.
struct ObservationRows {
  int group = 0;               ///< index of the observation group (images, control, ...) in LinearBlock::groups
  int label = 0;               ///< the caller's number of this observation, handed through
  int camera = -1;             ///< index of the camera, or -1 for rows without one
  std::vector<int> columns;    ///< kept unknowns the rows depend on, each once
  Eigen::MatrixXd kept;        ///< rows × columns.size(), derivative of the whitened computed value
  Eigen::MatrixXd pose;        ///< rows × 6, or empty without a camera
  Eigen::VectorXd misclosure;  ///< whitened observed minus computed
};

/// A block at one linearisation point.
struct LinearBlock {
  int kept_count = 0;
  int camera_count = 0;
  std::vector<std::string> groups;
  std::vector<ObservationRows> observations;
  /// Null space of the images and everything else that is observed (kept_count × defect), and the same with zeros in
  /// all rows but those of the datum points: inner constraints datumᵀ x = 0. Both empty if control fixes the datum.
  Eigen::MatrixXd null_space;
  Eigen::MatrixXd datum;

  int row_count() const;
  int unknown_count() const { return kept_count + 6 * camera_count; }
  /// Rows − unknowns + datum constraints.
  int redundancy() const { return row_count() - unknown_count() + static_cast<int>(datum.cols()); }
};

/// What remains of one camera after its elimination.
struct EliminatedCamera {
  std::vector<int> columns;           ///< kept unknowns the camera's observations depend on, ascending
  Eigen::MatrixXd coupling;           ///< 6 × columns.size(): normal matrix between pose and kept unknowns
  Matrix6 inverse = Matrix6::Zero();  ///< inverse of the pose's own normal matrix; zero if it is singular
  Vector6 right = Vector6::Zero();
  double weakest_eigenvalue = 0;  ///< smallest eigenvalue of the pose's normal matrix after Jacobi scaling
};

/// Normal equations of the kept unknowns with the cameras eliminated.
struct ReducedSystem {
  Eigen::MatrixXd normal;  ///< kept × kept
  Eigen::VectorXd right;   ///< kept
  Eigen::VectorXd
      diagonal;  ///< of the kept unknowns' normal matrix *before* the elimination: the scale rank decisions refer to
  std::vector<EliminatedCamera> cameras;
};

/// Sums up the normal equations and eliminates the cameras. A camera whose own 6 × 6 normal matrix is singular (its
/// smallest scaled eigenvalue is below 1e-12) contributes nothing; the caller finds it by `weakest_eigenvalue` and
/// reports it.
ReducedSystem reduce(const LinearBlock& block);

/// Corrections and cofactors (covariances for σ0 = 1) of one linearised block.
struct LinearSolution {
  Eigen::VectorXd kept;                ///< corrections of the kept unknowns
  std::vector<Vector6> poses;          ///< corrections of the cameras
  Eigen::MatrixXd kept_cofactor;       ///< kept × kept, marginal
  std::vector<Matrix6> pose_cofactor;  ///< 6 × 6 each, marginal
};

/// Solves without cofactors; false if the reduced matrix, with the inner constraints added, has no Cholesky factor.
bool solve_corrections(const LinearBlock& block, const ReducedSystem& reduced, LinearSolution& solution);

/// Adds the cofactors to a solution. Precondition: solve_corrections() succeeded on the same system.
void add_cofactors(const LinearBlock& block, const ReducedSystem& reduced, LinearSolution& solution);

/// Cofactors between one pose and all kept unknowns, 6 × kept_count.
Eigen::MatrixXd pose_kept_cofactor(const EliminatedCamera& camera, const Eigen::MatrixXd& kept_cofactor);

/// Smallest eigenvalue of the scaled system below, by inverse iteration (an upper bound, within a few per cent after 12
/// steps); 0 if the matrix has no Cholesky factor. Cheap: the full spectrum is needed only to say *what* is
/// undetermined.
double smallest_scaled_eigenvalue(const LinearBlock& block, const ReducedSystem& reduced);

/// Eigenvalues, ascending, and vectors of the reduced normal matrix (inner constraints added), scaled by
/// `diagonal`^(-1/2). The vectors are scaled back to unknowns and have the length 1 in units of the scale.
struct ScaledSpectrum {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
ScaledSpectrum scaled_spectrum(const LinearBlock& block, const ReducedSystem& reduced);

}  // namespace plumbline::adjust
