// The triangles on the diagonal of a Cholesky factor by blocks.
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/vectors.hpp"
#include "least_squares/sparse/dense_kernels.hpp"

namespace plumbline::least_squares {
namespace {

constexpr int widest = 64;

/// Rows at work, side by side for every column of X: sums of the compiler's own vectors stay in registers.
template <typename V, int Count>
PLUMBLINE_INLINE void solve_rows(int size, const double* lower, const double* inverse, double* x,
                                 std::ptrdiff_t x_stride) {
  constexpr int numbers = sizeof(V) / sizeof(double);
  for (int c = 0; c < size; ++c) {
    double* to = x + c * x_stride;
    V sum[Count];
    for (int i = 0; i < Count; ++i) sum[i] = load<V>(to + i * numbers);
    const double* row = lower + c * widest;
    for (int k = 0; k < c; ++k)
      for (int i = 0; i < Count; ++i) sum[i] -= row[k] * load<V>(x + k * x_stride + i * numbers);
    for (int i = 0; i < Count; ++i) store<V>(to + i * numbers, sum[i] * inverse[c]);
  }
}

/// to −= factor · from.
template <typename V>
PLUMBLINE_INLINE void subtract_at(double* to, const double* from, double factor) {
  store<V>(to, load<V>(to) - factor * load<V>(from));
}

}  // namespace

PLUMBLINE_CLONES
int factor_lower(int size, double* matrix, std::ptrdiff_t stride) {
  for (int c = 0; c < size; ++c) {
    double* own = matrix + c * stride;
    for (int k = 0; k < c; ++k) {
      const double* other = matrix + k * stride;
      const double factor = other[c];
      int r = c;
      for (; r + 4 <= size; r += 4) subtract_at<V4>(own + r, other + r, factor);
      for (; r < size; ++r) own[r] -= factor * other[r];
    }
    if (!(own[c] > 0) || !std::isfinite(own[c])) return c;
    own[c] = std::sqrt(own[c]);
    const double inverse = 1 / own[c];
    for (int r = c + 1; r < size; ++r) own[r] *= inverse;
  }
  return size;
}

PLUMBLINE_CLONES
void solve_right(int size, const double* lower, std::ptrdiff_t stride, int rows, double* x, std::ptrdiff_t x_stride) {
  std::array<double, widest * widest> by_row;
  std::array<double, widest> inverse;
  for (int c = 0; c < size; ++c) {
    inverse[c] = 1 / lower[c * stride + c];
    for (int k = 0; k < c; ++k) by_row[c * widest + k] = lower[k * stride + c];
  }
  int r = 0;
  for (; r + 16 <= rows; r += 16) solve_rows<V4, 4>(size, by_row.data(), inverse.data(), x + r, x_stride);
  for (; r + 4 <= rows; r += 4) solve_rows<V4, 1>(size, by_row.data(), inverse.data(), x + r, x_stride);
  for (; r < rows; ++r) solve_rows<double, 1>(size, by_row.data(), inverse.data(), x + r, x_stride);
}

PLUMBLINE_CLONES
void solve_left(int size, const double* lower, std::ptrdiff_t stride, int columns, double* x, std::ptrdiff_t x_stride) {
  for (int c = 0; c < columns; ++c) {
    double* own = x + c * x_stride;
    for (int k = 0; k < size; ++k) {
      const double* from = lower + k * stride;
      const double value = own[k] = own[k] / from[k];
      if (value == 0) continue;  // above the diagonal of an inverse
      int r = k + 1;
      for (; r + 4 <= size; r += 4) subtract_at<V4>(own + r, from + r, value);
      for (; r < size; ++r) own[r] -= value * from[r];
    }
  }
}

}  // namespace plumbline::least_squares
