#include "least_squares/problem/cofactors.hpp"

#include <algorithm>
#include <stdexcept>

#include "least_squares/sparse/inverse_entries.hpp"
#include "least_squares/sparse/selected_inverse.hpp"

namespace plumbline::least_squares {

/// In the datum of the pinned unknowns Q_p = S^-1 Z S^-1, zero for those; in that of the solution Q_p - G H - (G H)'.
struct Cofactors::Sparse {
  std::shared_ptr<const SparseFactor> of;  ///< of the scaled matrix
  const SparseFactor& factor;
  SelectedInverse inverse;
  std::vector<int> block_of;      ///< of each unknown
  Eigen::VectorXd inverse_scale;  ///< zero for pinned unknowns
  Eigen::MatrixXd g, h;           ///< n x d and d x n; no columns without a defect

  Sparse(const Solution& solution, std::shared_ptr<const SparseFactor> its)
      : of(std::move(its)), factor(*of), inverse(factor.cholesky()) {
    const NormalEquations& normal = solution.normal;
    for (int u = 0; u < normal.size(); ++u) block_of.push_back(normal.block_of(u));
    inverse_scale = normal.scale().cwiseInverse();
    for (const int p : solution.datum.pinned()) inverse_scale[p] = 0;
    g.resize(normal.size(), 0), h.resize(0, normal.size());
    if (solution.datum.defect() == 0) return;
    InnerConstraints datum = solution.datum;
    datum.update(normal, factor);
    g = datum.null_space();
    h = datum.half_change_of(in_pinned_datum(datum.constraints()));
  }

  /// Q_p x.
  Eigen::MatrixXd in_pinned_datum(const Eigen::MatrixXd& x) const {
    return inverse_scale.asDiagonal() * factor.solve(inverse_scale.asDiagonal() * x);
  }
};

namespace {

std::shared_ptr<const SparseFactor> factor_of(const Solution& solution) {
  if (solution.factor) return solution.factor;
  auto factor = std::make_shared<SparseFactor>();
  if (!factor->factorise(solution.normal, 0, solution.datum.pinned()))
    throw RankDefect("the normal matrix is singular at the solution", Eigen::MatrixXd(solution.unknowns.count(), 0));
  return factor;
}

Eigen::MatrixXd whole_of(const Solution& solution, const SparseFactor& factor) {
  Eigen::MatrixXd q = factor.inverse();
  for (int p : solution.datum.pinned()) {
    q.row(p).setZero();
    q.col(p).setZero();
  }
  const Eigen::VectorXd inverse_scale = solution.normal.scale().cwiseInverse();
  const int n = static_cast<int>(q.rows());
  for (int j = 0; j < n; ++j) q.col(j).array() *= inverse_scale.array() * inverse_scale[j];
  InnerConstraints datum = solution.datum;
  datum.update(solution.normal, factor);
  datum.transform(q);
  for (int j = 0; j < n; ++j)
    for (int i = j + 1; i < n; ++i) q(i, j) = q(j, i) = 0.5 * (q(i, j) + q(j, i));
  return q;
}

}  // namespace

Eigen::MatrixXd cofactor_matrix(const Solution& solution) { return whole_of(solution, *factor_of(solution)); }

Cofactors::Cofactors(Eigen::MatrixXd whole) : size_(static_cast<int>(whole.rows())), whole_(std::move(whole)) {}

Cofactors::Cofactors(const Solution& solution, int largest_whole) : size_(solution.unknowns.count()) {
  std::shared_ptr<const SparseFactor> factor = factor_of(solution);
  if (size_ <= largest_whole)
    whole_ = whole_of(solution, *factor);
  else
    sparse_ = std::make_shared<const Sparse>(solution, std::move(factor));
}

const Eigen::MatrixXd& Cofactors::whole() const {
  if (sparse_)
    throw std::logic_error("the cofactors of " + std::to_string(size_) + " unknowns are not at hand as one matrix");
  return whole_;
}

std::vector<int> Cofactors::blocks_of(std::span<const int> unknowns) const {
  std::vector<int> blocks;
  for (const int u : unknowns) {
    const int b = sparse_->block_of[u];
    if (std::find(blocks.begin(), blocks.end(), b) == blocks.end()) blocks.push_back(b);
  }
  return blocks;
}

bool Cofactors::has(std::span<const int> unknowns) const {
  return !sparse_ || sparse_->inverse.has_all(blocks_of(unknowns));
}

Eigen::MatrixXd Cofactors::without_datum(std::span<const int> unknowns) const {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  const SparseCholesky& factor = sparse_->factor.cholesky();
  Eigen::VectorXd scale(n);
  for (Eigen::Index k = 0; k < n; ++k) scale[k] = sparse_->inverse_scale[unknowns[k]];
  const std::vector<int> blocks = blocks_of(unknowns);
  if (std::optional<Eigen::MatrixXd> all = joint_blocks(blocks)) {
    std::vector<Eigen::Index> at;
    for (const int u : unknowns) {
      const int own = sparse_->block_of[u];
      Eigen::Index row = u - factor.analysis().offset(own);
      for (auto b = blocks.begin(); *b != own; ++b) row += factor.analysis().size(*b);
      at.push_back(row);
    }
    return scale.asDiagonal() * (*all)(at, at) * scale.asDiagonal();
  }
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(size_, n);
  for (Eigen::Index k = 0; k < n; ++k) unit(unknowns[k], k) = scale[k];
  return factor.covariance(unit);
}

/// Of whole blocks and the scaled matrix; nullopt where solves are cheaper.
std::optional<Eigen::MatrixXd> Cofactors::joint_blocks(const std::vector<int>& blocks) const {
  constexpr std::size_t kFew = 16;  // pairs of more are not looked for one by one
  if (sparse_->inverse.has_all(blocks)) return sparse_->inverse.joint(blocks);
  if (blocks.size() > kFew) return std::nullopt;
  const Analysis& analysis = sparse_->factor.cholesky().analysis();
  InverseEntries entries(sparse_->factor.cholesky(), sparse_->inverse);
  Eigen::Index size = 0;
  for (const int b : blocks) size += analysis.size(b);
  Eigen::MatrixXd result(size, size);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < blocks.size(); row += analysis.size(blocks[i]), ++i) {
    Eigen::Index column = 0;
    for (std::size_t j = 0; j <= i; column += analysis.size(blocks[j]), ++j) {
      const auto found = entries.block(blocks[i], blocks[j]);
      if (!found) return std::nullopt;
      result.block(row, column, found->rows(), found->cols()) = *found;
      result.block(column, row, found->cols(), found->rows()) = found->transpose();
    }
  }
  // Of a diagonal block the lower triangle counts.
  return Eigen::MatrixXd(result.selfadjointView<Eigen::Lower>());
}

Eigen::MatrixXd Cofactors::joint(std::span<const int> unknowns) const {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd result(n, n);
  if (!sparse_) {
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index i = 0; i < n; ++i) result(i, j) = whole_(unknowns[i], unknowns[j]);
    return result;
  }
  result = without_datum(unknowns);
  if (sparse_->g.cols() > 0) {
    const Eigen::MatrixXd g = sparse_->g(std::vector<int>(unknowns.begin(), unknowns.end()), Eigen::all),
                          h = sparse_->h(Eigen::all, std::vector<int>(unknowns.begin(), unknowns.end()));
    const Eigen::MatrixXd change = g * h;
    result -= change + change.transpose();
  }
  return factor_ * result;
}

double Cofactors::operator()(int a, int b) const {
  if (!sparse_) return whole_(a, b);
  const int both[] = {a, b};
  return a == b ? joint(std::span(both, 1))(0, 0) : joint(both)(0, 1);
}

Eigen::VectorXd Cofactors::times(const Eigen::VectorXd& x) const {
  if (!sparse_) return whole_ * x;
  Eigen::VectorXd result = sparse_->in_pinned_datum(x);
  result -= sparse_->g * (sparse_->h * x) + sparse_->h.transpose() * (sparse_->g.transpose() * x);
  return factor_ * result;
}

Eigen::VectorXd Cofactors::variances(const std::vector<Functional>& functionals) const {
  constexpr std::size_t kTogether = 64;  // right sides
  Eigen::VectorXd result(static_cast<Eigen::Index>(functionals.size()));
  if (!sparse_) {
    for (std::size_t k = 0; k < functionals.size(); ++k) {
      double sum = 0;
      for (const auto& [j, right] : functionals[k])
        for (const auto& [i, left] : functionals[k]) sum += left * whole_(i, j) * right;
      result[static_cast<Eigen::Index>(k)] = sum;
    }
    return result;
  }
  const int batches = static_cast<int>((functionals.size() + kTogether - 1) / kTogether);
  parallel_ranges(batches, 1, [&](int first, int last) {
    for (int batch = first; batch < last; ++batch) {
      const std::size_t begin = static_cast<std::size_t>(batch) * kTogether,
                        end = std::min(functionals.size(), begin + kTogether);
      Eigen::MatrixXd scaled = Eigen::MatrixXd::Zero(size_, static_cast<Eigen::Index>(end - begin));
      for (std::size_t k = begin; k < end; ++k)
        for (const auto& [u, coefficient] : functionals[k])
          scaled(u, static_cast<Eigen::Index>(k - begin)) += coefficient * sparse_->inverse_scale[u];
      const Eigen::MatrixXd half = sparse_->factor.cholesky().half_solve(scaled);
      for (std::size_t k = begin; k < end; ++k) {
        double variance = half.col(static_cast<Eigen::Index>(k - begin)).squaredNorm();
        Eigen::VectorXd g = Eigen::VectorXd::Zero(sparse_->g.cols()), h = g;
        for (const auto& [u, coefficient] : functionals[k])
          g += coefficient * sparse_->g.row(u).transpose(), h += coefficient * sparse_->h.col(u);
        result[static_cast<Eigen::Index>(k)] = factor_ * (variance - 2 * g.dot(h));
      }
    }
  });
  return result;
}

void Cofactors::multiply(double factor) {
  if (sparse_)
    factor_ *= factor;
  else
    whole_ *= factor;
}

}  // namespace plumbline::least_squares
