#include "geometry/linear_algebra/lower_factor.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

// Into the functions that may use wider vectors; what is not inlined is compiled for every processor.
#define ALWAYS [[gnu::always_inline]] inline

namespace plumbline::linear_algebra {
namespace {

using Index = std::ptrdiff_t;

constexpr Index kColumns = 128;  ///< of a block: what is left of it is updated with all before it at once
constexpr Index kNarrow = 16;    ///< within it, the same again
constexpr Index kDepth = 256;    ///< products that are summed while their factors lie in the cache

/// Rows and columns of a tile whose sums stay in registers.
template <Index kWide>
struct Tile {
  typedef double Vector __attribute__((vector_size(8 * kWide), aligned(8), may_alias));
  static constexpr Index vectors = kWide == 8 ? 3 : 2;
  static constexpr Index rows = kWide * vectors, columns = kWide == 8 ? 8 : 4;
};

/// `count` rows from `from` on and columns [begin, end) of the matrix, in strips of `high` rows, each column by column;
/// zeros where there is no row.
template <Index high>
ALWAYS void pack(const double* a, Index stride, Index from, Index count, Index begin, Index end, double* packed) {
  for (Index strip = 0; strip < count; strip += high) {
    const Index there = std::min(high, count - strip);
    for (Index k = begin; k < end; ++k, packed += high) {
      const double* column = a + k * stride + from + strip;
      if (there == high)
        for (Index i = 0; i < high; ++i) packed[i] = column[i];
      else
        for (Index i = 0; i < high; ++i) packed[i] = i < there ? column[i] : 0;
    }
  }
}

/// c -= left · rightᵀ of one tile; of `c`, columns `stride` apart.
template <Index kWide>
ALWAYS void multiply(const double* left, const double* right, Index depth, double* c, Index stride) {
  using T = Tile<kWide>;
  using Vector = typename T::Vector;
  Vector sum[T::columns][T::vectors];
#pragma GCC unroll 8
  for (Index j = 0; j < T::columns; ++j)
#pragma GCC unroll 4
    for (Index v = 0; v < T::vectors; ++v) sum[j][v] = *reinterpret_cast<const Vector*>(c + j * stride + v * kWide);
  for (Index k = 0; k < depth; ++k, left += T::rows, right += T::columns) {
    Vector l[T::vectors];
#pragma GCC unroll 4
    for (Index v = 0; v < T::vectors; ++v) l[v] = *reinterpret_cast<const Vector*>(left + v * kWide);
#pragma GCC unroll 8
    for (Index j = 0; j < T::columns; ++j)
#pragma GCC unroll 4
      for (Index v = 0; v < T::vectors; ++v) sum[j][v] -= l[v] * right[j];
  }
#pragma GCC unroll 8
  for (Index j = 0; j < T::columns; ++j)
#pragma GCC unroll 4
    for (Index v = 0; v < T::vectors; ++v) *reinterpret_cast<Vector*>(c + j * stride + v * kWide) = sum[j][v];
}

/// A tile that reaches above the diagonal or beyond the matrix: by way of one beside it.
template <Index kWide>
ALWAYS void multiply_part(const double* left, const double* right, Index depth, double* a, Index n, Index row,
                          Index column, Index last) {
  using T = Tile<kWide>;
  double beside[T::rows * T::columns] = {};
  const Index rows = std::min(T::rows, n - row), columns = std::min(T::columns, last - column);
  for (Index j = 0; j < columns; ++j)
    for (Index i = std::max<Index>(0, column + j - row); i < rows; ++i)
      beside[j * T::rows + i] = a[(column + j) * n + row + i];
  multiply<kWide>(left, right, depth, beside, T::rows);
  for (Index j = 0; j < columns; ++j)
    for (Index i = std::max<Index>(0, column + j - row); i < rows; ++i)
      a[(column + j) * n + row + i] = beside[j * T::rows + i];
}

/// Room for the packed factors.
struct Room {
  std::vector<double> left, right;
};

/// Columns [first, last) on and below the diagonal, less what columns [begin, end) of the factor contribute.
template <Index kWide>
ALWAYS void update(double* a, Index n, Index first, Index last, Index begin, Index end, Room& room) {
  using T = Tile<kWide>;
  constexpr Index high = 40 * T::rows;  // rows at once
  for (Index k = begin; k < end; k += kDepth) {
    const Index depth = std::min(kDepth, end - k);
    pack<T::columns>(a, n, first, last - first, k, k + depth, room.right.data());
    for (Index top = first; top < n; top += high) {
      const Index rows = std::min(high, n - top);
      pack<T::rows>(a, n, top, rows, k, k + depth, room.left.data());
      for (Index column = first; column < last; column += T::columns) {
        const double* right = room.right.data() + (column - first) * depth;
        for (Index row = top; row < top + rows; row += T::rows) {
          if (row + T::rows <= column) continue;
          const double* left = room.left.data() + (row - top) * depth;
          if (row >= column + T::columns - 1 && row + T::rows <= n && column + T::columns <= last)
            multiply<kWide>(left, right, depth, a + column * n + row, n);
          else
            multiply_part<kWide>(left, right, depth, a, n, row, column, last);
        }
      }
    }
  }
}

/// The factor of columns [first, last), from which all before them have been taken.
ALWAYS bool narrow_factor(double* a, Index n, Index first, Index last) {
  for (Index j = first; j < last; ++j) {
    double* column = a + j * n;
    for (Index k = first; k < j; ++k) {
      const double* other = a + k * n;
      const double factor = other[j];
      for (Index i = j; i < n; ++i) column[i] -= factor * other[i];
    }
    if (!(column[j] > 0)) return false;
    const double pivot = std::sqrt(column[j]);
    column[j] = pivot;
    for (Index i = j + 1; i < n; ++i) column[i] /= pivot;
  }
  return true;
}

template <Index kWide>
ALWAYS bool factor(double* a, Index n) {
  Room room;
  room.left.resize(40 * Tile<kWide>::rows * kDepth), room.right.resize((kColumns + 8) * kDepth);
  for (Index block = 0; block < n; block += kColumns) {
    const Index end = std::min(n, block + kColumns);
    update<kWide>(a, n, block, end, 0, block, room);
    for (Index first = block; first < end; first += kNarrow) {
      const Index last = std::min(end, first + kNarrow);
      update<kWide>(a, n, first, last, block, first, room);
      if (!narrow_factor(a, n, first, last)) return false;
    }
  }
  return true;
}

#if defined(__x86_64__)
[[gnu::target("avx512f,avx512vl,avx512dq")]] bool factor_by_eight(double* a, Index n) { return factor<8>(a, n); }
[[gnu::target("avx2")]] bool factor_by_four(double* a, Index n) { return factor<4>(a, n); }
#endif
bool factor_by_two(double* a, Index n) { return factor<2>(a, n); }

}  // namespace

Vectors widest_vectors() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
    return Vectors::of_eight;
  if (__builtin_cpu_supports("avx2")) return Vectors::of_four;
#endif
  return Vectors::of_two;
}

bool lower_factor(double* a, Index rows, Vectors vectors) {
#if defined(__x86_64__)
  if (vectors == Vectors::of_eight) return factor_by_eight(a, rows);
  if (vectors == Vectors::of_four) return factor_by_four(a, rows);
#endif
  return factor_by_two(a, rows);
}

}  // namespace plumbline::linear_algebra
