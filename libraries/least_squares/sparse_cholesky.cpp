// Left-looking: a supernode gathers what earlier ones take away from it, in their order, and then is a dense problem.
#include "least_squares/sparse_cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "least_squares/dense_kernels.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

constexpr int corner_width = 32;
/// Of an unknown that is held: what is divided by it is nothing.
constexpr double held = std::numeric_limits<double>::infinity();

}  // namespace

SparseCholesky::SparseCholesky(std::shared_ptr<const Analysis> analysis) : analysis_(std::move(analysis)) {}

bool SparseCholesky::factorise(const SymmetricBlocks& matrix, double tolerance) {
  if (matrix.unknown_count() != analysis_->unknown_count() || matrix.block_count() != analysis_->block_count())
    throw std::logic_error("a matrix of " + std::to_string(matrix.unknown_count()) + " unknowns for an analysis of " +
                           std::to_string(analysis_->unknown_count()));
  undetermined_.clear();
  scatter(matrix);
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
void SparseCholesky::scatter(const SymmetricBlocks& matrix) {
  const Analysis& a = *analysis_;
  values_.assign(a.entries(), 0.0);
  diagonal_.assign(a.unknown_count(), 0.0);
  for (int b = 0; b < matrix.block_count(); ++b) {
    const auto& column = matrix.column(b);
    const double* from = matrix.values() + column.begin;
    for (std::size_t k = 0; k < column.rows.size() && a.size(b) > 0; ++k) {
      const int row = column.rows[k];
      if (a.size(row) == 0) continue;
      const bool is_own = row == b, is_below = a.position(row) >= a.position(b);
      const int first_column = is_below ? a.position(b) : a.position(row);
      const int first_row = is_below ? a.position(row) : a.position(b);
      const auto& s = a.supernodes()[a.supernode_at(first_column)];
      const auto found = std::lower_bound(s.rows.begin(), s.rows.end(), first_row);
      if (found == s.rows.end() || *found != first_row)
        throw std::logic_error("the matrix is not one on the pattern of the analysis");
      double* to = values_.data() + s.begin + (found - s.rows.begin());
      const std::ptrdiff_t height = s.height(), stride = column.height();
      for (int c = 0; c < a.size(b); ++c)
        for (int r = is_own ? c : 0; r < a.size(row); ++r) {
          const double value = from[c * stride + column.starts[k] + r];
          if (is_below)
            to[r + (c + first_column - s.first) * height] = value;
          else
            to[c + (r + first_column - s.first) * height] = value;
          if (is_own && r == c) diagonal_[first_column + c] = value;
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

Eigen::MatrixXd SparseCholesky::solve(const Eigen::Ref<const Eigen::MatrixXd>& right) const {
  Eigen::MatrixXd x = to_elimination_order(right);
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
