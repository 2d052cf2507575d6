// Left-looking: a supernode gathers what earlier ones take away from it, in their order, and then is a dense problem.
#include "least_squares/sparse/sparse_cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "least_squares/sparse/dense_kernels.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

constexpr int corner_width = 32;
/// Of an unknown that is held: what is divided by it is nothing.
constexpr double held = std::numeric_limits<double>::infinity();

}  // namespace

SparseCholesky::SparseCholesky(std::shared_ptr<const Analysis> analysis) : analysis_(std::move(analysis)) {}

bool SparseCholesky::factorise(const SymmetricBlocks& matrix, double tolerance, const Scaling& scaling) {
  if (matrix.unknown_count() != analysis_->unknown_count() || matrix.block_count() != analysis_->block_count())
    throw std::logic_error("a matrix of " + std::to_string(matrix.unknown_count()) + " unknowns for an analysis of " +
                           std::to_string(analysis_->unknown_count()));
  undetermined_.clear();
  scatter(matrix, scaling);
  std::vector<int> place(analysis_->unknown_count());
  std::vector<double> work;
  for (const auto& s : analysis_->supernodes()) {
    stop_point();
    add_updates(s, place, work);
    factor_panel(s, tolerance);
  }
  return is_regular();
}

/// The matrix into the panels.
void SparseCholesky::scatter(const SymmetricBlocks& matrix, const Scaling& scaling) {
  const Analysis& a = *analysis_;
  values_.assign(a.entries(), 0.0);
  diagonal_.assign(a.unknown_count(), 0.0);
  const std::vector<double> ones(a.unknown_count(), 1.0);
  const double* scale = scaling.scale.size() > 0 ? scaling.scale.data() : ones.data();
  for (int b = 0; b < matrix.block_count(); ++b) {
    const auto& column = matrix.column(b);
    for (std::size_t k = 0; k < column.rows.size() && a.size(b) > 0; ++k) {
      const int row = column.rows[k];
      if (a.size(row) == 0) continue;
      const bool is_below = a.position(row) >= a.position(b);
      const int first_row = a.position(is_below ? row : b), first_column = a.position(is_below ? b : row);
      const auto& s = a.supernodes()[a.supernode_at(first_column)];
      const std::ptrdiff_t at = s.row_of(first_row), height = s.height(), stride = column.height();
      if (at < 0) throw std::logic_error("the matrix is not one on the pattern of the analysis");
      double* to = values_.data() + s.begin + at + (first_column - s.first) * height;
      const double* from = matrix.values() + column.begin + column.starts[k];
      const double *of_row = scale + a.offset(row), *of_column = scale + a.offset(b);
      for (int c = 0; c < a.size(b); ++c)
        for (int r = row == b ? c : 0; r < a.size(row); ++r) {
          const double value = from[c * stride + r] * (of_row[r] * of_column[c]);
          (is_below ? to[r + c * height] : to[c + r * height]) = value;
        }
      if (row != b) continue;
      for (int c = 0; c < a.size(b); ++c) {
        double& value = to[c + c * height];
        if (scaling.added.size() > 0) value += scaling.added(a.offset(b) + c);
        diagonal_[first_column + c] = value;
      }
    }
  }
}

void SparseCholesky::add_updates(const Analysis::Supernode& target, std::vector<int>& place,
                                 std::vector<double>& work) {
  for (int r = 0; r < target.height(); ++r) place[target.rows[r]] = r;
  double* to = values_.data() + target.begin;
  const std::ptrdiff_t stride = target.height();
  for (const auto& update : target.updates) {
    stop_point();
    const auto& source = analysis_->supernodes()[update.from];
    const int rows = source.height() - update.row;
    const double* from = values_.data() + source.begin + update.row;
    work.assign(static_cast<std::size_t>(rows) * update.count, 0.0);
    subtract_product(work.data(), rows, rows, update.count, source.width,
                     {from, 1, source.height(), from, 1, source.height()}, true);
    const int* positions = source.rows.data() + update.row;
    for (int c = 0; c < update.count; ++c) {
      double* column = to + (positions[c] - target.first) * stride;
      const double* product = work.data() + static_cast<std::ptrdiff_t>(c) * rows;
      for (int r = c; r < rows; ++r) column[place[positions[r]]] += product[r];
    }
  }
}

void SparseCholesky::factor_panel(const Analysis::Supernode& s, double tolerance) {
  const std::ptrdiff_t stride = s.height();
  double* values = values_.data() + s.begin;
  double before[corner_width * corner_width];
  for (int first = 0; first < s.width; first += corner_width) {
    stop_point();
    const int width = std::min(corner_width, s.width - first), below = s.height() - first - width;
    double* corner = values + first + first * stride;
    for (int c = 0; c < width; ++c) std::copy_n(corner + c * stride, width, before + c * corner_width);
    bool sound = factor_lower(width, corner, stride) == width;
    for (int c = 0; c < width && sound; ++c) {
      const double root = corner[c + c * stride];
      sound = root * root > tolerance * diagonal_[s.first + first + c];
    }
    if (!sound) {
      for (int c = 0; c < width; ++c) std::copy_n(before + c * corner_width, width, corner + c * stride);
      factor_holding(s, first, width, tolerance);
    }
    if (below == 0) continue;
    solve_right(width, corner, stride, below, corner + width, stride);
    if (first + width < s.width)
      subtract_product(corner + width + width * stride, stride, below, s.width - first - width, width,
                       {corner + width, 1, stride, corner + width, 1, stride}, true);
  }
}

/// A corner that is not positive definite: what is open in it is held.
void SparseCholesky::factor_holding(const Analysis::Supernode& s, int first, int width, double tolerance) {
  const std::ptrdiff_t stride = s.height();
  double* corner = values_.data() + s.begin + first + first * stride;
  for (int c = 0; c < width; ++c) {
    double* own = corner + c * stride;
    for (int k = 0; k < c; ++k)
      for (int r = c; r < width; ++r) own[r] -= corner[c + k * stride] * corner[r + k * stride];
    const int position = s.first + first + c;
    const double whole = diagonal_[position];
    if (own[c] > tolerance * whole && std::isfinite(own[c])) {
      own[c] = std::sqrt(own[c]);
      for (int r = c + 1; r < width; ++r) own[r] /= own[c];
      continue;
    }
    const int block = analysis_->block_at(position);
    undetermined_.push_back({block, position - analysis_->position(block), whole > 0 ? own[c] / whole : 0.0});
    own[c] = held;
    for (int r = c + 1; r < width; ++r) own[r] = 0;
  }
}

Eigen::MatrixXd SparseCholesky::to_elimination_order(const Eigen::Ref<const Eigen::MatrixXd>& right) const {
  if (right.rows() != analysis_->unknown_count())
    throw std::logic_error("a right side of " + std::to_string(right.rows()) + " rows for " +
                           std::to_string(analysis_->unknown_count()) + " unknowns");
  Eigen::MatrixXd result(right.rows(), right.cols());
  for (int b = 0; b < analysis_->block_count(); ++b)
    result.middleRows(analysis_->position(b), analysis_->size(b)) =
        right.middleRows(analysis_->offset(b), analysis_->size(b));
  return result;
}

Eigen::MatrixXd SparseCholesky::to_given_order(const Eigen::Ref<const Eigen::MatrixXd>& solution) const {
  Eigen::MatrixXd result(solution.rows(), solution.cols());
  for (int b = 0; b < analysis_->block_count(); ++b)
    result.middleRows(analysis_->offset(b), analysis_->size(b)) =
        solution.middleRows(analysis_->position(b), analysis_->size(b));
  return result;
}

void SparseCholesky::solve_forward(Eigen::MatrixXd& x) const {
  const int d = static_cast<int>(x.cols());
  Eigen::MatrixXd product;
  for (const auto& s : analysis_->supernodes()) {
    stop_point();
    if (x.middleRows(s.first, s.width).isZero(0)) continue;  // a unit vector meets its ancestors only
    const double* values = values_.data() + s.begin;
    const std::ptrdiff_t stride = s.height(), rows = x.rows();
    for (int first = 0; first < s.width; first += corner_width) {
      const int width = std::min(corner_width, s.width - first), rest = s.width - first - width;
      double* own = x.data() + s.first + first;
      const double* corner = values + first + first * stride;
      solve_left(width, corner, stride, d, own, rows);
      if (rest > 0)
        subtract_product(own + width, rows, rest, d, width, {corner + width, 1, stride, own, rows, 1}, false);
    }
    const int below = s.height() - s.width;
    if (below == 0) continue;
    product.setZero(below, d);
    subtract_product(product.data(), below, below, d, s.width,
                     {values + s.width, 1, stride, x.data() + s.first, rows, 1}, false);
    for (int c = 0; c < d; ++c)
      for (int r = 0; r < below; ++r) x(s.rows[s.width + r], c) += product(r, c);
  }
}

void SparseCholesky::solve_backward(Eigen::MatrixXd& x) const {
  const int d = static_cast<int>(x.cols());
  Eigen::MatrixXd gathered;
  for (auto s = analysis_->supernodes().rbegin(); s != analysis_->supernodes().rend(); ++s) {
    stop_point();
    const double* values = values_.data() + s->begin;
    const std::ptrdiff_t stride = s->height(), rows = x.rows();
    double* own = x.data() + s->first;
    const int below = s->height() - s->width;
    gathered.resize(below, d);
    for (int c = 0; c < d; ++c)
      for (int r = 0; r < below; ++r) gathered(r, c) = x(s->rows[s->width + r], c);
    subtract_product(own, rows, s->width, d, below, {values + s->width, stride, 1, gathered.data(), below, 1}, false);
    for (int first = (s->width - 1) / corner_width * corner_width; first >= 0; first -= corner_width) {
      const int width = std::min(corner_width, s->width - first), rest = s->width - first - width;
      const double* corner = values + first + first * stride;
      if (rest > 0)
        subtract_product(own + first, rows, width, d, rest, {corner + width, stride, 1, own + first + width, rows, 1},
                         false);
      for (int c = 0; c < d; ++c) {
        double* solution = own + first + c * rows;
        for (int r = width - 1; r >= 0; --r) {
          double sum = solution[r];
          for (int k = r + 1; k < width; ++k) sum -= corner[k + r * stride] * solution[k];
          solution[r] = sum / corner[r + r * stride];
        }
      }
    }
  }
}

// A single right side: each number of the factor is read once and used once, so that nothing is gained by tiles.
void SparseCholesky::solve_forward(Eigen::VectorXd& x) const {
  Eigen::VectorXd product;
  for (const auto& s : analysis_->supernodes()) {
    stop_point();
    const Eigen::Map<const Eigen::MatrixXd> values(values_.data() + s.begin, s.height(), s.width);
    auto own = x.segment(s.first, s.width);
    values.topRows(s.width).triangularView<Eigen::Lower>().solveInPlace(own);
    product.noalias() = values.bottomRows(s.height() - s.width) * own;
    for (int r = s.width; r < s.height(); ++r) x(s.rows[r]) -= product(r - s.width);
  }
}

void SparseCholesky::solve_backward(Eigen::VectorXd& x) const {
  Eigen::VectorXd gathered;
  for (auto s = analysis_->supernodes().rbegin(); s != analysis_->supernodes().rend(); ++s) {
    stop_point();
    const Eigen::Map<const Eigen::MatrixXd> values(values_.data() + s->begin, s->height(), s->width);
    auto own = x.segment(s->first, s->width);
    gathered.resize(s->height() - s->width);
    for (int r = s->width; r < s->height(); ++r) gathered(r - s->width) = x(s->rows[r]);
    own.noalias() -= values.bottomRows(s->height() - s->width).transpose() * gathered;
    values.topRows(s->width).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  }
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::Ref<const Eigen::MatrixXd>& right) const {
  Eigen::MatrixXd x = to_elimination_order(right);
  if (x.cols() == 1) {
    Eigen::VectorXd single = x.col(0);
    solve_forward(single);
    solve_backward(single);
    return to_given_order(single);
  }
  solve_forward(x);
  solve_backward(x);
  return to_given_order(x);
}

Eigen::MatrixXd SparseCholesky::half_solve(const Eigen::Ref<const Eigen::MatrixXd>& right) const {
  Eigen::MatrixXd x = to_elimination_order(right);
  solve_forward(x);
  return x;
}

Eigen::MatrixXd SparseCholesky::columns(std::span<const int> unknowns) const {
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(analysis_->unknown_count(), static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t k = 0; k < unknowns.size(); ++k) unit(unknowns[k], static_cast<Eigen::Index>(k)) = 1;
  return solve(unit);
}

Eigen::MatrixXd SparseCholesky::cofactors(std::span<const int> blocks) const {
  std::vector<int> unknowns;
  for (int b : blocks)
    for (int c = 0; c < analysis_->size(b); ++c) unknowns.push_back(analysis_->offset(b) + c);
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(analysis_->unknown_count(), static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t k = 0; k < unknowns.size(); ++k) unit(unknowns[k], static_cast<Eigen::Index>(k)) = 1;
  return covariance(unit);
}

Eigen::MatrixXd SparseCholesky::covariance(const Eigen::Ref<const Eigen::MatrixXd>& functionals) const {
  const Eigen::MatrixXd half = half_solve(functionals);
  const int d = static_cast<int>(half.cols()), n = static_cast<int>(half.rows());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(d, d);  // −, its lower triangle
  subtract_product(result.data(), d, d, d, n, {half.data(), n, 1, half.data(), n, 1}, true);
  for (int c = 0; c < d; ++c) {
    result.col(c).tail(d - c) *= -1;
    result.row(c).tail(d - c - 1) = result.col(c).tail(d - c - 1).transpose();
  }
  return result;
}

}  // namespace plumbline::least_squares
