#include "least_squares/problem/datum.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/random.hpp"

namespace plumbline::least_squares {

namespace {

/// Reproducible numbers in (-1, 1).
Eigen::MatrixXd start_vectors(int rows, int columns) {
  Eigen::MatrixXd result(rows, columns);
  Random random(0x9E3779B97F4A7C15ULL);
  for (int j = 0; j < columns; ++j)
    for (int i = 0; i < rows; ++i) result(i, j) = random.uniform(-1, 1);
  return result;
}

struct Ritz {
  Eigen::VectorXd values;   // ascending
  Eigen::MatrixXd vectors;  // n x k
};

Ritz smallest_eigenpairs(const NormalEquations& normal, const SparseFactor& factor, int count) {
  const int n = normal.size();
  Eigen::MatrixXd v = linear_algebra::orthonormal_columns(start_vectors(n, count));
  Ritz ritz;
  for (int iteration = 0; iteration < 5; ++iteration) {
    v = linear_algebra::orthonormal_columns(factor.solve(v));
    const Eigen::MatrixXd nv = normal.multiply_scaled(v);
    const linear_algebra::SymmetricEigen eigen(v.transpose() * nv);
    v = v * eigen.eigenvectors();
    ritz = {eigen.eigenvalues(), v};
  }
  return ritz;
}

std::vector<int> pin_unknowns(const Eigen::MatrixXd& scaled_null_space) {
  const Eigen::VectorXi best = linear_algebra::best_conditioned_rows(scaled_null_space);
  std::vector<int> pinned(best.begin(), best.end());
  std::sort(pinned.begin(), pinned.end());
  return pinned;
}

/// Columns unscaled and normed to a largest component of 1.
Eigen::MatrixXd tangent_directions(const Eigen::MatrixXd& scaled, const Eigen::VectorXd& scale) {
  Eigen::MatrixXd result = scale.cwiseInverse().asDiagonal() * scaled;
  for (auto column : result.colwise()) column /= column.cwiseAbs().maxCoeff();
  return result;
}

/// Throws unless the rows `datum_unknowns` of the (orthonormal) null space have full column rank.
void require_held(const Eigen::MatrixXd& scaled_null_space, const Eigen::VectorXd& scale,
                  const std::vector<int>& datum_unknowns) {
  const int defect = static_cast<int>(scaled_null_space.cols());
  const Eigen::MatrixXd held = scaled_null_space(datum_unknowns, Eigen::all);
  const linear_algebra::SingularValues svd(
      held.rows() < defect ? Eigen::MatrixXd(Eigen::MatrixXd::Zero(defect, defect)) : held, Eigen::ComputeThinV);
  const Eigen::VectorXd& singular = svd.singularValues();
  const double threshold = 1e-6;
  const int missing = static_cast<int>((singular.array() < threshold).count());
  if (held.rows() >= defect && missing == 0) return;
  const Eigen::MatrixXd open =
      held.rows() < defect ? scaled_null_space : Eigen::MatrixXd(scaled_null_space * svd.matrixV().rightCols(missing));
  throw RankDefect("the observations leave " + std::to_string(defect) +
                       " direction(s) of the unknowns open, and the datum (" + std::to_string(datum_unknowns.size()) +
                       " unknowns) holds " + std::to_string(defect - open.cols()) + " of them",
                   tangent_directions(open, scale));
}

/// H of S Q S' = Q - G H - (G H)' with S = I - G (C'G)^-1 C', from Q C:
/// S Q S' = Q - G B - (G B)' + G (B C T) G' with T = (C'G)^-T and B = (C'G)^-1 C'Q.
Eigen::MatrixXd half_change(const Eigen::MatrixXd& qc, const Eigen::MatrixXd& g, const Eigen::MatrixXd& c) {
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(c.transpose() * g).inverse();
  const Eigen::MatrixXd b = inverse * qc.transpose();
  return b - 0.5 * (b * c * inverse.transpose()) * g.transpose();
}

void change_datum(Eigen::MatrixXd& q, const Eigen::MatrixXd& g, const Eigen::MatrixXd& c) {
  const Eigen::MatrixXd half = half_change(q * c, g, c);
  q.noalias() -= g * half;
  q.noalias() -= half.transpose() * g.transpose();
}

}  // namespace

Eigen::MatrixXd find_null_space(const NormalEquations& normal, double tolerance) {
  const int n = normal.size();
  if (n == 0) return Eigen::MatrixXd(0, 0);
  SparseFactor factor;
  // The shift makes the singular matrix factorisable; it must stand clear of rounding (1e-16 n) and below the
  // tolerance.
  for (double shift = 1e-11; !factor.factorise(normal, shift, {}); shift *= 10)
    if (shift > 1e-7)
      throw std::runtime_error("normal matrix is not positive semidefinite: not finite residuals or Jacobians");
  for (int count = std::min(n, 8);; count = std::min(n, 2 * count)) {
    const Ritz ritz = smallest_eigenpairs(normal, factor, count);
    const int defect = static_cast<int>((ritz.values.array() < tolerance).count());
    if (defect < count || count == n) return ritz.vectors.leftCols(defect);
  }
}

InnerConstraints::InnerConstraints(const NormalEquations& normal, const Eigen::MatrixXd& scaled_null_space,
                                   const std::vector<int>& datum_unknowns) {
  if (scaled_null_space.cols() == 0) return;
  require_held(scaled_null_space, normal.scale(), datum_unknowns);
  pinned_ = pin_unknowns(scaled_null_space);
  null_space_ = normal.scale().cwiseInverse().asDiagonal() * scaled_null_space;
  constraints_ = Eigen::MatrixXd::Zero(null_space_.rows(), null_space_.cols());
  for (int u : datum_unknowns) constraints_.row(u) = null_space_.row(u);
}

void InnerConstraints::update(const NormalEquations& normal, const SparseFactor& factor) {
  if (pinned_.empty()) return;
  // Unit movement of each pinned unknown, the others following: N_ff z_f = -N_fp.
  const int n = normal.size();
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(n, defect());
  for (int k = 0; k < defect(); ++k) unit(pinned_[k], k) = 1.0;
  Eigen::MatrixXd right_side = -normal.multiply_scaled(unit);
  for (int p : pinned_) right_side.row(p).setZero();
  null_space_ = normal.scale().cwiseInverse().asDiagonal() * (factor.solve(right_side) + unit);
}

Eigen::VectorXd InnerConstraints::shift_for(const Eigen::VectorXd& change) const {
  if (pinned_.empty()) return Eigen::VectorXd::Zero(change.size());
  const Eigen::MatrixXd small = constraints_.transpose() * null_space_;
  const Eigen::VectorXd misclosure = constraints_.transpose() * change;
  return -null_space_ * small.fullPivLu().solve(misclosure);
}

Eigen::MatrixXd InnerConstraints::half_change_of(const Eigen::MatrixXd& q_constraints) const {
  return half_change(q_constraints, null_space_, constraints_);
}

void InnerConstraints::transform(Eigen::MatrixXd& q) const {
  if (!pinned_.empty()) change_datum(q, null_space_, constraints_);
}

Eigen::MatrixXd s_transform(const Eigen::MatrixXd& cofactors, const Eigen::MatrixXd& null_space,
                            const std::vector<int>& datum_unknowns) {
  Eigen::MatrixXd constraints = Eigen::MatrixXd::Zero(null_space.rows(), null_space.cols());
  for (int u : datum_unknowns) constraints.row(u) = null_space.row(u);
  if (Eigen::FullPivLU<Eigen::MatrixXd>(constraints.transpose() * null_space).rank() < null_space.cols())
    throw RankDefect("the new datum does not hold the null space of the system", null_space);
  Eigen::MatrixXd q = cofactors;
  change_datum(q, null_space, constraints);
  return q;
}

}  // namespace plumbline::least_squares
