#include "building/judgement/spectral_coordinates.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Jacobi>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "plumbline/stop.hpp"

namespace plumbline::judgement {
namespace {

using Eigen::Index;

/// A symmetric tridiagonal matrix on its way to a diagonal one.
struct Tridiagonal {
  Eigen::VectorXd diagonal, beside, along;

  bool is_zero(Index k) const {
    return std::abs(beside[k]) <=
           std::numeric_limits<double>::epsilon() * (std::abs(diagonal[k]) + std::abs(diagonal[k + 1]));
  }

  /// The eigenvalue of the last two rows that is nearer to the last diagonal element.
  double shift(Index last) const {
    const double half = 0.5 * (diagonal[last - 1] - diagonal[last]), b = beside[last - 1];
    const double root = std::hypot(half, b);
    return diagonal[last] - b * (b / (half + (half < 0 ? -root : root)));
  }

  /// One implicit QR step of rows first to last, none of whose elements beside the diagonal is zero.
  void step(Index first, Index last) {
    double x = diagonal[first] - shift(last), bulge = beside[first];
    for (Index k = first; k < last; ++k) {
      Eigen::JacobiRotation<double> rotation;
      rotation.makeGivens(x, bulge);
      const double c = rotation.c(), s = rotation.s();
      const double lower = s * diagonal[k] + c * beside[k], corner = s * beside[k] + c * diagonal[k + 1];
      diagonal[k] = c * (c * diagonal[k] - s * beside[k]) - s * (c * beside[k] - s * diagonal[k + 1]);
      diagonal[k + 1] = s * lower + c * corner;
      beside[k] = c * lower - s * corner;
      if (k > first) beside[k - 1] = c * beside[k - 1] - s * bulge;
      x = beside[k];
      if (k + 1 < last) bulge = -s * beside[k + 1], beside[k + 1] *= c;
      const double turned = c * along[k] - s * along[k + 1];
      along[k + 1] = s * along[k] + c * along[k + 1];
      along[k] = turned;
    }
  }
};

}  // namespace

SpectralCoordinates spectral_coordinates(const Eigen::MatrixXd& symmetric, const Eigen::VectorXd& vector) {
  if (symmetric.rows() < 2) return {symmetric.diagonal(), vector};
  const Eigen::Tridiagonalization<Eigen::MatrixXd> form(symmetric);
  Tridiagonal t{form.diagonal(), form.subDiagonal(), form.matrixQ().adjoint() * vector};
  const Index most = 30 * symmetric.rows();
  Index steps = 0;
  for (Index last = symmetric.rows() - 1; last > 0;) {
    stop_point();
    for (Index k = 0; k < last; ++k)
      if (t.is_zero(k)) t.beside[k] = 0;
    if (t.beside[last - 1] == 0) {
      --last;
      continue;
    }
    if (++steps > most) throw std::runtime_error("the eigenvalues of a covariance do not converge");
    Index first = last - 1;
    while (first > 0 && t.beside[first - 1] != 0) --first;
    t.step(first, last);
  }
  return {t.diagonal, t.along};
}

}  // namespace plumbline::judgement
