#include "least_squares/problem/reliability.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/statistics.hpp"

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__) || !defined(__x86_64__)
#define PLUMBLINE_CLONES
#else
#define PLUMBLINE_CLONES __attribute__((target_clones("avx2", "default")))
#endif

namespace plumbline::least_squares {

namespace {

/// y += factor x, both n long.
PLUMBLINE_CLONES
void add_scaled(int n, double factor, const double* x, double* y) {
  for (int i = 0; i < n; ++i) y[i] += factor * x[i];
}

/// Everything of one block that its rows need.
struct BlockMatrices {
  Eigen::MatrixXd whitening;    // W, weight factors included
  Eigen::MatrixXd unwhitening;  // W^-1
  Eigen::MatrixXd adjusted;     // A Q A' of the whitened rows
  Eigen::MatrixXd residual;     // Quu = I - A Q A'
  Eigen::MatrixXd local;        // Q of the block's unknowns
  Eigen::MatrixXd influence;    // A' W, columns: what a unit blunder of a row adds to the normal equations
};

BlockMatrices block_matrices(const ResidualBlock& residual, const Linearisation& lin, const Linearisation::Block& block,
                             const Cofactors& q) {
  BlockMatrices m;
  m.whitening = residual.whitening().triangularView<Eigen::Lower>();
  for (int r = 0; r < block.rows && !residual.weight_factors.empty(); ++r)
    m.whitening.row(r) *= std::sqrt(residual.weight_factors[r]);
  m.unwhitening = m.whitening.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(block.rows, block.rows));
  const Eigen::MatrixXd& local = m.local =
      q.joint({lin.columns.data() + block.column_begin, static_cast<size_t>(block.column_count)});
  const auto a = lin.jacobian_of(block);
  m.adjusted.noalias() = a * (local * a.transpose());
  m.residual = Eigen::MatrixXd::Identity(block.rows, block.rows) - m.adjusted;
  m.influence.noalias() = a.transpose() * m.whitening;
  return m;
}

/// The largest movement of a group of unknowns by a blunder of size mdb in one row.
class ExternalEffect {
 public:
  ExternalEffect(const Linearisation& lin, const Cofactors& q, const std::vector<std::vector<int>>& groups)
      : lin_(lin), q_(q), groups_(groups), movement_(static_cast<size_t>(q.size())) {
    if (q.is_whole()) return;
    group_of_.assign(static_cast<size_t>(q.size()), -1);
    for (size_t g = 0; g < groups.size(); ++g)
      for (int unknown : groups[g])
        if (unknown >= 0) group_of_[unknown] = static_cast<int>(g);
  }

  void add(const Linearisation::Block& block, const Eigen::MatrixXd& local, const Eigen::VectorXd& influence,
           RowStatistics& row) {
    const double largest = q_.is_whole() ? of_all(block, influence, row) : of_block(block, local * influence, row);
    row.external_effect = std::sqrt(largest) * row.mdb;
  }

 private:
  double of_all(const Linearisation::Block& block, const Eigen::VectorXd& influence, RowStatistics& row) {
    std::fill(movement_.begin(), movement_.end(), 0.0);
    for (int k = 0; k < block.column_count; ++k)
      if (influence[k] != 0)
        add_scaled(q_.size(), influence[k], q_.whole().col(lin_.columns[block.column_begin + k]).data(),
                   movement_.data());
    double largest = 0;
    for (size_t g = 0; g < groups_.size(); ++g) {
      double sum = 0;
      for (int unknown : groups_[g])
        if (unknown >= 0) sum += movement_[unknown] * movement_[unknown];
      if (sum > largest) {
        largest = sum;
        row.external_group = static_cast<int>(g);
      }
    }
    return largest;
  }

  double of_block(const Linearisation::Block& block, const Eigen::VectorXd& movement, RowStatistics& row) const {
    double largest = 0;
    for (int k = 0; k < block.column_count; ++k) {
      const int g = group_of_[lin_.columns[block.column_begin + k]];
      if (g < 0) continue;
      double sum = 0;
      for (int j = 0; j < block.column_count; ++j)
        if (group_of_[lin_.columns[block.column_begin + j]] == g) sum += movement[j] * movement[j];
      if (sum > largest) largest = sum, row.external_group = g;
    }
    return largest;
  }

  const Linearisation& lin_;
  const Cofactors& q_;
  const std::vector<std::vector<int>>& groups_;
  std::vector<double> movement_;
  std::vector<int> group_of_;  ///< of each unknown; empty where q is whole
};

/// From W, W⁻¹, A Q A' and Quu. A `Matrix` with a largest size needs no memory of its own.
template <typename Matrix, typename Vector>
void fill_statistics(const Matrix& whitening, const Matrix& unwhitening, const Matrix& adjusted, const Matrix& residual,
                     const Vector& whitened, double delta0, RowStatistics* list) {
  const bool uncorrelated = whitening.isDiagonal(0);
  const Matrix by_residual = uncorrelated ? Matrix(residual * whitening.diagonal().asDiagonal())
                                          : Matrix(residual * whitening.template triangularView<Eigen::Lower>());
  const Matrix from_adjusted = uncorrelated ? Matrix(unwhitening.diagonal().asDiagonal() * adjusted)
                                            : Matrix(unwhitening.template triangularView<Eigen::Lower>() * adjusted);
  for (Eigen::Index i = 0; i < whitened.size(); ++i) {
    RowStatistics& row = list[i];
    row = {};
    row.residual = unwhitening.row(i).dot(whitened);
    row.sigma = unwhitening.row(i).norm();
    row.sigma_adjusted = std::sqrt(std::max(0.0, from_adjusted.row(i).dot(unwhitening.row(i))));
    row.redundancy_number = 1 - from_adjusted.row(i).dot(whitening.col(i));
    const double weighted = whitening.col(i).dot(whitened);            // (P v)_i
    const double cofactor = whitening.col(i).dot(by_residual.col(i));  // (P Qvv P)_ii
    row.controlled = std::clamp(cofactor / whitening.col(i).squaredNorm(), 0.0, 1.0);
    // Correlated rows may have a redundancy number below zero and be well controlled: the test decides by its own
    // variance.
    if (!(row.controlled >= kUncontrolled)) {
      row.estimated_blunder = std::numeric_limits<double>::quiet_NaN();
      row.mdb = row.bias_to_noise = row.external_effect = std::numeric_limits<double>::infinity();
      continue;
    }
    row.w = weighted / std::sqrt(cofactor);
    row.estimated_blunder = -weighted / cofactor;
    row.mdb = delta0 / std::sqrt(cofactor);
    row.bias_to_noise = delta0 * std::sqrt((1 - row.controlled) / row.controlled);
  }
}

BlockTest block_test(const BlockMatrices& m, const Eigen::VectorXd& whitened) {
  if (whitened.size() == 1) {
    if (m.residual(0, 0) < kUncontrolled) return {};
    return {whitened[0] * whitened[0] / m.residual(0, 0), 1};
  }
  const linear_algebra::SymmetricEigen eigen(m.residual);
  BlockTest test;
  for (int k = 0; k < whitened.size(); ++k) {
    if (eigen.eigenvalues()[k] < kUncontrolled) continue;
    const double projected = eigen.eigenvectors().col(k).dot(whitened);
    test.statistic += projected * projected / eigen.eigenvalues()[k];
    ++test.rank;
  }
  return test;
}

}  // namespace

namespace {

template <typename Matrix>
std::vector<RowStatistics> statistics_of(const Eigen::Ref<const Eigen::MatrixXd>& given,
                                         const Eigen::Ref<const Eigen::VectorXd>& whitened,
                                         const Eigen::Ref<const Eigen::MatrixXd>& residual_cofactors, double delta0) {
  const Eigen::Index rows = whitened.size();
  const Matrix whitening = given.template triangularView<Eigen::Lower>(), residual = residual_cofactors;
  Matrix unwhitening = Matrix::Identity(rows, rows);
  if (whitening.isDiagonal(0))
    unwhitening.diagonal() = whitening.diagonal().cwiseInverse();
  else
    whitening.template triangularView<Eigen::Lower>().solveInPlace(unwhitening);
  std::vector<RowStatistics> result(static_cast<size_t>(rows));
  const Matrix adjusted = Matrix::Identity(rows, rows) - residual;
  fill_statistics(whitening, unwhitening, adjusted, residual, whitened, delta0, result.data());
  return result;
}

}  // namespace

std::vector<RowStatistics> row_statistics(const Eigen::Ref<const Eigen::MatrixXd>& whitening,
                                          const Eigen::Ref<const Eigen::VectorXd>& whitened,
                                          const Eigen::Ref<const Eigen::MatrixXd>& residual_cofactors, double delta0) {
  constexpr int few = 8;  // a tag's: no memory of their own
  if (whitened.size() == few)
    return statistics_of<Eigen::Matrix<double, few, few>>(whitening, whitened, residual_cofactors, delta0);
  if (whitened.size() > few) return statistics_of<Eigen::MatrixXd>(whitening, whitened, residual_cofactors, delta0);
  return statistics_of<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, few, few>>(whitening, whitened,
                                                                                           residual_cofactors, delta0);
}

Reliability compute_reliability(const Problem& problem, const Solution& solution, const Cofactors& q,
                                const ReliabilityOptions& options) {
  const Linearisation& lin = solution.linearisation;
  const double delta0 = non_centrality(options.alpha0, options.power);
  Reliability result;
  result.rows.resize(lin.rows);
  result.blocks.resize(lin.blocks.size());
  parallel_ranges(static_cast<int>(lin.blocks.size()), 64, [&](int first, int last) {
    ExternalEffect external(lin, q, options.groups);
    for (int b = first; b < last; ++b) {
      const Linearisation::Block& block = lin.blocks[b];
      const BlockMatrices m = block_matrices(*problem.residuals[b], lin, block, q);
      const Eigen::VectorXd whitened = lin.residuals.segment(block.row, block.rows);
      fill_statistics(m.whitening, m.unwhitening, m.adjusted, m.residual, whitened, delta0, &result.rows[block.row]);
      for (int i = 0; i < block.rows; ++i) {
        RowStatistics& row = result.rows[block.row + i];
        if (!options.groups.empty() && std::isfinite(row.mdb)) external.add(block, m.local, m.influence.col(i), row);
      }
      result.blocks[b] = block_test(m, whitened);
    }
  });
  for (const auto& row : result.rows) result.sum_of_redundancy_numbers += row.redundancy_number;
  return result;
}

double non_centrality(double alpha0, double power) {
  return normal_quantile(1 - 0.5 * alpha0) + normal_quantile(power);
}

double tau_critical(double alpha0, double f) {
  if (!(f > 1)) return std::numeric_limits<double>::infinity();
  const double t = student_t_quantile(1 - 0.5 * alpha0, f - 1);
  return std::sqrt(f) * t / std::sqrt(f - 1 + t * t);
}

GlobalTest global_test(double sum_of_squares, int f, double alpha) {
  GlobalTest test;
  test.statistic = sum_of_squares;
  if (f <= 0) return test;
  test.lower = chi_squared_quantile(0.5 * alpha, f);
  test.upper = chi_squared_quantile(1 - 0.5 * alpha, f);
  if (sum_of_squares < test.lower) test.verdict = GlobalTest::Verdict::low;
  if (sum_of_squares > test.upper) test.verdict = GlobalTest::Verdict::high;
  return test;
}

std::vector<VarianceComponent> variance_components(const Problem& problem, const Solution& solution,
                                                   const Reliability& reliability) {
  std::vector<VarianceComponent> components;
  for (size_t b = 0; b < problem.residuals.size(); ++b) {
    const ResidualBlock& residual = *problem.residuals[b];
    const Linearisation::Block& block = solution.linearisation.blocks[b];
    const Eigen::VectorXd weighted =
        residual.whitening().transpose() * solution.linearisation.residuals.segment(block.row, block.rows);
    for (int i = 0; i < block.rows; ++i) {
      const size_t group = residual.groups.empty() ? 0 : static_cast<size_t>(residual.groups[i]);
      if (group >= components.size()) components.resize(group + 1);
      const RowStatistics& row = reliability.rows[block.row + i];
      components[group].sum_of_squares += row.residual * weighted[i];
      components[group].redundancy += row.redundancy_number;
      ++components[group].rows;
    }
  }
  for (auto& c : components)
    if (c.redundancy > kUncontrolled) c.factor = c.sum_of_squares / c.redundancy;
  return components;
}

ErrorEllipsoid error_ellipsoid(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  ErrorEllipsoid ellipsoid;
  for (int k = 0; k < 3; ++k) {
    ellipsoid.semi_axes[k] = std::sqrt(std::max(0.0, eigen.eigenvalues()[2 - k]));
    ellipsoid.axes.col(k) = eigen.eigenvectors().col(2 - k);
  }
  return ellipsoid;
}

double confidence_factor(double confidence, int dimensions) {
  return std::sqrt(chi_squared_quantile(confidence, dimensions));
}

}  // namespace plumbline::least_squares
