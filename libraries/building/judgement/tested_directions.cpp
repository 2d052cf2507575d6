#include "building/judgement/tested_directions.hpp"

#include <Eigen/QR>
#include <cstdint>
#include <utility>

#include "building/judgement/factor_in_place.hpp"
#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/random.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::judgement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kMany = 300;  ///< rows, below which a second factor, or eigenvalues, cost nothing

/// A symmetric matrix in the upper triangle of a square, and in the lower one the factor of another that is near it.
class Halves {
 public:
  explicit Halves(MatrixXd& symmetric) : both_(symmetric), diagonal_(both_.diagonal()) {}
  Halves(const Halves&) = delete;
  Halves& operator=(const Halves&) = delete;
  ~Halves() { restore_lower(diagonal_, both_); }
  const VectorXd& diagonal() const { return diagonal_; }
  /// Whether C + shift I + raise · V Vᵀ has a factor, which then is the one to solve with.
  bool factor(double shift, double raise, const MatrixXd& along) {
    restore_lower(diagonal_, both_);
    both_.diagonal().array() += shift;
    if (along.cols() > 0) both_.selfadjointView<Eigen::Lower>().rankUpdate(along, raise);
    return factor_in_place(both_);
  }
  /// C · right, of a vector or some.
  template <typename Columns>
  Columns times(const Columns& right) const {
    const auto above = read().triangularView<Eigen::StrictlyUpper>();
    Columns image = above * right;
    image += above.transpose() * right;
    image += diagonal_.asDiagonal() * right;
    return image;
  }
  template <typename Columns>
  Columns solved(Columns right) const {
    read().triangularView<Eigen::Lower>().solveInPlace(right);
    read().triangularView<Eigen::Lower>().transpose().solveInPlace(right);
    return right;
  }
  VectorXd half_solved(const VectorXd& right) const { return read().triangularView<Eigen::Lower>().solve(right); }

 private:
  const MatrixXd& read() const { return both_; }

  MatrixXd& both_;
  VectorXd diagonal_;
};

/// d' (C + raise · V Vᵀ)⁻¹ d by conjugate gradients with the factor of that less limit I: those two are the same but
/// where eigenvalues come near the limit, so a few steps do. Nothing where many would be needed.
std::optional<double> by_gradients(const VectorXd& difference, const Halves& halves, double raise,
                                   const MatrixXd& along) {
  constexpr int most = 40;
  constexpr double enough = 1e-13;  // of the statistic
  VectorXd residual = difference, z = halves.solved(residual), direction = z;
  double size = residual.dot(z), statistic = 0;  // size: not less than what is missing of the statistic
  for (int step = 0; step < most; ++step) {
    if (!(size > enough * statistic)) return statistic;
    VectorXd image = halves.times(direction);
    if (along.cols() > 0) image += raise * (along * (along.transpose() * direction));
    const double length = size / direction.dot(image);
    statistic += length * size;  // what this step adds to d' C⁻¹ d
    residual -= length * image;
    z = halves.solved(residual);
    const double next = residual.dot(z);
    direction = z + next / size * direction;
    size = next;
  }
  return std::nullopt;
}

/// `columns` with more of them, drawn, and all orthonormal.
MatrixXd widened(const MatrixXd& columns, Index rows, Index width) {
  Random random(1, "directions", static_cast<std::uint64_t>(width));
  MatrixXd all(rows, width);
  all.leftCols(columns.cols()) = columns;
  for (Index column = columns.cols(); column < width; ++column)
    for (Index row = 0; row < rows; ++row) all(row, column) = random.uniform() - 0.5;
  return all;
}

MatrixXd orthonormal(const MatrixXd& columns) {
  const Eigen::HouseholderQR<MatrixXd> qr(columns);
  return qr.householderQ() * MatrixXd::Identity(columns.rows(), columns.cols());
}

/// Eigenvectors of the eigenvalues at or below the limit, n x k, with the factor of C + limit I in `halves`; 0 columns
/// where they are too many, or not to be told from the others.
MatrixXd smallest(const Halves& halves, double limit) {
  constexpr Index first = 32,
                  most = 128;  // a few more than the shifts, turns and bends that photographs may have in common
  constexpr int steps = 40;
  constexpr double enough = 1e-8;  // about the angle between what is found and what it stands for: next to nothing of d
  const Index n = halves.diagonal().size();
  MatrixXd basis = widened(MatrixXd(n, 0), n, first);
  for (int step = 0; step < steps; ++step) {
    stop_point();
    basis = orthonormal(halves.solved(std::move(basis)));
    MatrixXd image = halves.times(basis);
    const linear_algebra::SymmetricEigen ritz(MatrixXd(basis.transpose() * image));
    basis = (basis * ritz.eigenvectors()).eval(), image = (image * ritz.eigenvectors()).eval();
    const VectorXd& values = ritz.eigenvalues();  // ascending
    const Index few = (values.array() <= limit).count();
    if (few == 0 && step > 5) break;
    if (few + 4 > basis.cols()) {
      if (2 * basis.cols() > most || !values.allFinite()) break;
      basis = widened(basis, n, 2 * basis.cols());
      continue;
    }
    const double gap = values[few] - limit;
    const MatrixXd residual = image.leftCols(few) - basis.leftCols(few) * values.head(few).asDiagonal();
    if (few > 0 && residual.colwise().norm().maxCoeff() <= enough * gap) return basis.leftCols(few);
  }
  return {n, 0};
}

}  // namespace

std::optional<TestedDirections> tested_directions(const VectorXd& difference, MatrixXd& covariance, double limit,
                                                  bool some_may_be_left_out) {
  const Index n = covariance.rows();
  Halves halves(covariance);
  const MatrixXd none(n, 0);
  if (halves.factor(-limit, 0, none)) {
    if (n > kMany)
      if (const auto statistic = by_gradients(difference, halves, 0, none)) return TestedDirections{*statistic, n};
    if (!halves.factor(0, 0, none)) return std::nullopt;
    return TestedDirections{halves.half_solved(difference).squaredNorm(), n};
  }
  if (!some_may_be_left_out || n <= kMany || !halves.factor(limit, 0, none)) return std::nullopt;
  const MatrixXd left_out = smallest(halves, limit);
  if (left_out.cols() == 0) return std::nullopt;
  const double raise = halves.diagonal().maxCoeff();
  // Only k eigenvalues are changed by a matrix of rank k, so with a factor here no more than these are at the limit or
  // below; and no less, because none is above its Ritz value.
  if (!halves.factor(-limit, raise, left_out)) return std::nullopt;
  VectorXd rest = difference - left_out * (left_out.transpose() * difference);
  rest -= left_out * (left_out.transpose() * rest);
  const auto statistic = by_gradients(rest, halves, raise, left_out);
  if (!statistic) return std::nullopt;
  return TestedDirections{*statistic, n - left_out.cols()};
}

}  // namespace plumbline::judgement
