#include "least_squares/sparse/selected_inverse.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "least_squares/sparse/dense_cholesky.hpp"
#include "least_squares/sparse/dense_kernels.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

[[noreturn]] void refuse(int a, int b) {
  throw std::out_of_range("the selected inverse has no cofactors of blocks " + std::to_string(a) + " and " +
                          std::to_string(b) + ", which never meet: ask the factor for them");
}

}  // namespace

struct SelectedInverse::Work {
  std::vector<int> places;                ///< of the rows below in another supernode
  Eigen::MatrixXd below, ratio, product;  ///< Z_RR; −L_RC L_CC⁻¹; −Z_RC
};

SelectedInverse::SelectedInverse(SparseCholesky factor)
    : analysis_(factor.shared_analysis()), values_(std::move(factor).release()) {
  Work work;
  const auto& supernodes = analysis_->supernodes();
  for (auto s = supernodes.rbegin(); s != supernodes.rend(); ++s) {
    stop_point();
    invert(*s, work);
  }
}

/// Z_RR, from the supernodes whose columns the rows are.
void SelectedInverse::gather(const Analysis::Supernode& s, Work& work) const {
  const int height = s.height(), count = height - s.width;
  work.below.resize(count, count);
  work.places.resize(count);
  const int* rows = s.rows.data() + s.width;
  for (int first = 0; first < count;) {
    const auto& other = analysis_->supernodes()[analysis_->supernode_at(rows[first])];
    auto place = other.rows.begin();
    for (int r = first; r < count; ++r) {
      place = std::lower_bound(place, other.rows.end(), rows[r]);
      work.places[r] = static_cast<int>(place - other.rows.begin());
    }
    int last = first;
    for (; last < count && rows[last] < other.first + other.width; ++last) {
      const double* column =
          values_.data() + other.begin + static_cast<std::size_t>(rows[last] - other.first) * other.height();
      for (int r = last; r < count; ++r) work.below(r, last) = work.below(last, r) = column[work.places[r]];
    }
    first = last;
  }
}

void SelectedInverse::invert(const Analysis::Supernode& s, Work& work) {
  const int height = s.height(), width = s.width, count = height - width;
  const std::ptrdiff_t stride = height;
  double* values = values_.data() + s.begin;
  const Eigen::MatrixXd inverse = inverse_of_lower(values, height, width);
  if (count > 0) {
    gather(s, work);
    work.ratio.setZero(count, width);
    subtract_product(work.ratio.data(), count, count, width, width,
                     {values + width, 1, height, inverse.data(), width, 1}, false);
    work.product.setZero(count, width);
    subtract_product(work.product.data(), count, count, width, count,
                     {work.below.data(), 1, count, work.ratio.data(), count, 1}, false);
  }
  for (int c = 0; c < width; ++c) std::fill_n(values + c * stride, width, 0.0);
  subtract_product(values, height, width, width, width, {inverse.data(), width, 1, inverse.data(), width, 1}, true);
  for (int c = 0; c < width; ++c) {
    double* column = values + c * stride;
    for (int r = c; r < width; ++r) column[r] = -column[r];
    for (int r = 0; r < count; ++r) column[width + r] = -work.product(r, c);
  }
  if (count > 0)
    subtract_product(values, height, width, width, count, {work.ratio.data(), count, 1, work.product.data(), count, 1},
                     true);
  for (int c = 0; c < width; ++c)
    for (int r = c + 1; r < width; ++r) values[c + r * stride] = values[r + c * stride];
}

/// The entry of the first unknowns of two blocks, the row's at or behind the column's; null outside of the pattern.
const double* SelectedInverse::find(int row, int column, std::ptrdiff_t& stride) const {
  const int position = analysis_->position(column);
  const auto& s = analysis_->supernodes()[analysis_->supernode_at(position)];
  const int at = s.row_of(analysis_->position(row));
  stride = s.height();
  return at < 0 ? nullptr : values_.data() + s.begin + at + (position - s.first) * stride;
}

bool SelectedInverse::has(int a, int b) const {
  if (analysis_->size(a) == 0 || analysis_->size(b) == 0) return true;
  std::ptrdiff_t stride = 0;
  return analysis_->position(a) >= analysis_->position(b) ? find(a, b, stride) : find(b, a, stride);
}

bool SelectedInverse::has_all(std::span<const int> blocks) const {
  for (std::size_t i = 0; i < blocks.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!has(blocks[i], blocks[j])) return false;
  return true;
}

Eigen::MatrixXd SelectedInverse::block(int a, int b) const {
  const int rows = analysis_->size(a), columns = analysis_->size(b);
  if (rows == 0 || columns == 0) return Eigen::MatrixXd(rows, columns);
  if (analysis_->position(a) < analysis_->position(b)) return block(b, a).transpose();
  std::ptrdiff_t stride = 0;
  const double* from = find(a, b, stride);
  if (!from) refuse(a, b);
  return Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>(from, rows, columns, Eigen::OuterStride<>(stride));
}

void SelectedInverse::joint(std::span<const int> blocks, Eigen::Ref<Eigen::MatrixXd> target) const {
  const std::ptrdiff_t across = target.outerStride();
  int row = 0;
  for (std::size_t i = 0; i < blocks.size(); row += analysis_->size(blocks[i]), ++i) {
    int column = 0;
    for (std::size_t j = 0; j <= i; column += analysis_->size(blocks[j]), ++j) {
      const bool is_below = analysis_->position(blocks[i]) >= analysis_->position(blocks[j]);
      const int rows = analysis_->size(blocks[i]), columns = analysis_->size(blocks[j]);
      if (rows == 0 || columns == 0) continue;
      std::ptrdiff_t stride = 0;
      const double* from = is_below ? find(blocks[i], blocks[j], stride) : find(blocks[j], blocks[i], stride);
      if (!from) refuse(blocks[i], blocks[j]);
      double *to = target.data() + row + column * across, *mirrored = target.data() + column + row * across;
      for (int c = 0; c < columns; ++c)
        for (int r = 0; r < rows; ++r)
          mirrored[c + r * across] = to[r + c * across] = is_below ? from[r + c * stride] : from[c + r * stride];
    }
  }
}

Eigen::MatrixXd SelectedInverse::joint(std::span<const int> blocks) const {
  int size = 0;
  for (int b : blocks) size += analysis_->size(b);
  Eigen::MatrixXd result(size, size);
  joint(blocks, result);
  return result;
}

Eigen::Map<const Eigen::MatrixXd> SelectedInverse::dense() const {
  if (!analysis_->is_dense()) throw std::logic_error("a sparse inverse has no dense matrix");
  return {values_.data(), analysis_->unknown_count(), analysis_->unknown_count()};
}

void SelectedInverse::scale(const Eigen::VectorXd& s) {
  std::vector<double> by_position(analysis_->unknown_count());
  for (int b = 0; b < analysis_->block_count(); ++b)
    for (int c = 0; c < analysis_->size(b); ++c) by_position[analysis_->position(b) + c] = s(analysis_->offset(b) + c);
  for (const auto& node : analysis_->supernodes()) {
    double* value = values_.data() + node.begin;
    for (int c = 0; c < node.width; ++c)
      for (int r = 0; r < node.height(); ++r) *value++ *= by_position[node.rows[r]] * by_position[node.first + c];
  }
}

Eigen::VectorXd SelectedInverse::diagonal() const {
  Eigen::VectorXd result(analysis_->unknown_count());
  for (int b = 0; b < analysis_->block_count(); ++b)
    result.segment(analysis_->offset(b), analysis_->size(b)) = block(b, b).diagonal();
  return result;
}

}  // namespace plumbline::least_squares
