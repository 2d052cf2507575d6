#include "photo/bundle/weakest.hpp"

#include <Eigen/Core>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::bundle {
namespace {

void take_away(const Eigen::MatrixXd& motions, Eigen::Ref<Eigen::MatrixXd> vectors) {
  if (motions.cols() > 0) vectors -= motions * (motions.transpose() * vectors).eval();
}

/// S scaled to its diagonal.
least_squares::SymmetricBlocks scaled(const Elimination& elimination) {
  least_squares::SymmetricBlocks matrix = elimination.reduced();
  matrix.scale(elimination.scale());
  return matrix;
}

Spectrum all_eigenvalues(const Elimination& elimination, const Eigen::MatrixXd& motions) {
  const Eigen::Index n = elimination.kept_count();
  Eigen::MatrixXd matrix = scaled(elimination).multiply(Eigen::MatrixXd::Identity(n, n));
  if (motions.cols() > 0) matrix += motions * motions.transpose();
  const linear_algebra::SymmetricEigen spectrum(matrix);
  return {spectrum.eigenvalues(), spectrum.eigenvectors()};
}

}  // namespace

double smallest_eigenvalue(const least_squares::SparseCholesky& factor, const Eigen::MatrixXd& motions,
                           Eigen::VectorXd& vector, double enough) {
  const Eigen::Index n = factor.analysis().unknown_count();
  vector.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) vector(i) = 1 + 0.3 * std::sin(1.7 * static_cast<double>(i + 1));
  double value = 1;
  for (int step = 0; step < 12; ++step) {
    take_away(motions, vector);
    vector.normalize();
    vector = factor.solve(vector);
    take_away(motions, vector);
    value = 1 / vector.norm();
    if (step == 3 && value > enough) break;
  }
  vector.normalize();
  return value;
}

/// Subspace iteration (Rutishauser 1970) with the inverse of S + shift I: a value below the shift is seen apart from
/// one that is a hundred times the shift after a few steps.
Spectrum smallest_eigenvalues(const Elimination& elimination, const Eigen::MatrixXd& motions, double limit) {
  constexpr Eigen::Index all_of_them = 500;
  constexpr double shift = 1e-11;
  const Eigen::Index n = elimination.kept_count();
  if (n <= all_of_them) return all_eigenvalues(elimination, motions);
  const least_squares::SymmetricBlocks matrix = scaled(elimination);
  least_squares::SparseCholesky factor(elimination.factor().shared_analysis());
  // Motions that complete the rank are taken away at every step: the shift alone keeps the factor regular.
  factor.factorise(matrix, 0, {{}, Eigen::VectorXd::Constant(n, shift)});
  for (Eigen::Index count = 12;; count = std::min(n, 2 * count)) {
    Eigen::MatrixXd basis(n, count);
    for (Eigen::Index c = 0; c < count; ++c)
      for (Eigen::Index i = 0; i < n; ++i)
        basis(i, c) =
            std::sin(1.7 * static_cast<double>(i + 1) * static_cast<double>(c + 1)) + (i % count == c ? 1 : 0);
    Spectrum found;
    for (int step = 0; step < 8; ++step) {
      stop_point();
      take_away(motions, basis);
      basis = linear_algebra::orthonormal_columns(basis);
      if (step < 7) basis = factor.solve(basis);
    }
    take_away(motions, basis);
    const linear_algebra::SymmetricEigen small(basis.transpose() * matrix.multiply(basis));
    found = {small.eigenvalues(), basis * small.eigenvectors()};
    if (found.values(count - 1) >= limit || count == n) return found;
  }
}

}  // namespace plumbline::bundle
