// A vector along the eigenvectors of a symmetric matrix, without the eigenvectors.
#pragma once

#include <Eigen/Core>

namespace plumbline::judgement {

struct SpectralCoordinates {
  Eigen::VectorXd eigenvalues;  ///< n, in no order
  Eigen::VectorXd along;        ///< n, of the vector along the eigenvector of each
};

/// `symmetric`: n × n, of which the lower triangle is read; `vector`: n. Householder's tridiagonal form and implicit QR
/// steps with Wilkinson's shift (Golub, Van Loan: Matrix Computations, 8.3), whose rotations turn the vector only: 4/3
/// n³ operations where eigenvectors cost another 6 n³ and more. Throws std::runtime_error if the steps do not converge
/// (numbers that are none).
SpectralCoordinates spectral_coordinates(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& vector);

}  // namespace plumbline::judgement
