#include "building/judgement/symmetric_matrix.hpp"

#include <algorithm>
#include <utility>

#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {
namespace {

std::size_t unsigned_of(Eigen::Index i) { return static_cast<std::size_t>(i); }

}  // namespace

SymmetricMatrix SymmetricMatrix::of_packed(std::span<const double> values, std::vector<Index> points) {
  SymmetricMatrix matrix;
  matrix.values_ = values, matrix.points_ = std::move(points);
  return matrix;
}

double SymmetricMatrix::packed(Index row, Index column) const {
  const Index a = 3 * points_[unsigned_of(row / 3)] + row % 3, b = 3 * points_[unsigned_of(column / 3)] + column % 3;
  const double value = factor_ * values_[packed_size(unsigned_of(std::max(a, b))) + unsigned_of(std::min(a, b))];
  return more_.empty() || row / 3 != column / 3 ? value : value + more_[unsigned_of(row / 3)](row % 3, column % 3);
}

double SymmetricMatrix::operator()(Index row, Index column) const {
  return is_full() ? full_(row, column) : packed(row, column);
}

Eigen::Matrix3d SymmetricMatrix::block(Index a, Index b) const {
  if (is_full()) return full_.block<3, 3>(3 * a, 3 * b);
  Eigen::Matrix3d found;
  for (Index r = 0; r < 3; ++r)
    for (Index c = 0; c < 3; ++c) found(r, c) = packed(3 * a + r, 3 * b + c);
  return found;
}

template <typename Visit>
void SymmetricMatrix::visit_rows(const Visit& visit) const {
  Eigen::VectorXd row(rows());
  for (Index r = 0; r < rows(); ++r) {
    if (is_full()) {
      visit(r, full_.col(r).head(r + 1));
      continue;
    }
    for (Index c = 0; c <= r; ++c) row[c] = packed(r, c);
    visit(r, row.head(r + 1));
  }
}

Eigen::VectorXd SymmetricMatrix::diagonal() const {
  if (is_full()) return full_.diagonal();
  Eigen::VectorXd all(rows());
  for (Index i = 0; i < rows(); ++i) all[i] = packed(i, i);
  return all;
}

double SymmetricMatrix::sum() const {
  if (is_full()) return full_.sum();
  double all = 0;
  visit_rows([&](Index r, const auto& row) { all += 2 * row.head(r).sum() + row[r]; });
  return all;
}

double SymmetricMatrix::squared_norm(const Eigen::MatrixXd& common) const {
  if (is_full() && common.size() == 0) return full_.squaredNorm();
  const Index step = std::max<Index>(common.rows(), 1);
  double all = 0;
  visit_rows([&](Index r, const auto& row) {
    for (Index c = 0; c <= r; ++c) {
      const double value = row[c] + (common.size() > 0 ? common(r % step, c % step) : 0);
      all += (c < r ? 2 : 1) * value * value;
    }
  });
  return all;
}

double SymmetricMatrix::row_sum_norm() const {
  if (is_full()) return full_.cwiseAbs().rowwise().sum().maxCoeff();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(rows());
  visit_rows([&](Index r, const auto& row) {
    sums[r] += row.cwiseAbs().sum();
    sums.head(r) += row.head(r).cwiseAbs();
  });
  return sums.maxCoeff();
}

bool SymmetricMatrix::all_finite() const {
  if (is_full()) return full_.allFinite();
  bool finite = true;
  visit_rows([&](Index, const auto& row) { finite = finite && row.allFinite(); });
  return finite;
}

Eigen::MatrixXd SymmetricMatrix::times(const Eigen::MatrixXd& right) const {
  if (is_full()) return full_ * right;
  const Eigen::MatrixXd across = right.transpose();
  Eigen::MatrixXd image = Eigen::MatrixXd::Zero(across.rows(), across.cols());
  visit_rows([&](Index r, const auto& row) {
    image.col(r) += across.leftCols(r + 1) * row;
    image.leftCols(r).noalias() += across.col(r) * row.head(r).transpose();
  });
  return image.transpose();
}

Eigen::MatrixXd SymmetricMatrix::full() const {
  if (is_full()) return full_;
  Eigen::MatrixXd all(rows(), rows());
  visit_rows([&](Index r, const auto& row) {
    all.col(r).head(r + 1) = row;
    all.row(r).head(r) = row.head(r).transpose();
  });
  return all;
}

Eigen::MatrixXd& SymmetricMatrix::made_full() {
  if (!is_full()) *this = SymmetricMatrix(full());
  return full_;
}

SymmetricMatrix SymmetricMatrix::of_items(const std::vector<Index>& items, Index step) const {
  if (is_full()) {
    const auto n = static_cast<Index>(items.size());
    Eigen::MatrixXd some(n * step, n * step);
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j)
        some.block(i * step, j * step, step, step) =
            full_.block(items[unsigned_of(i)] * step, items[unsigned_of(j)] * step, step, step);
    return SymmetricMatrix(std::move(some));
  }
  SymmetricMatrix some = of_packed(values_, {});
  some.factor_ = factor_;
  for (const Index point : items) {
    some.points_.push_back(points_[unsigned_of(point)]);
    if (!more_.empty()) some.more_.push_back(more_[unsigned_of(point)]);
  }
  return some;
}

SymmetricMatrix& SymmetricMatrix::operator*=(double factor) {
  full_ *= factor, factor_ *= factor;
  for (Eigen::Matrix3d& more : more_) more *= factor;
  return *this;
}

void SymmetricMatrix::add(Index point, const Eigen::Matrix3d& more) {
  if (is_full()) {
    full_.block<3, 3>(3 * point, 3 * point) += more;
    return;
  }
  if (more_.empty()) more_.assign(points_.size(), Eigen::Matrix3d::Zero());
  more_[unsigned_of(point)] += more;
}

}  // namespace plumbline::judgement
