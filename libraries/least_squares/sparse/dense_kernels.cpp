#include "least_squares/sparse/dense_kernels.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include "geometry/vectors.hpp"

namespace plumbline::least_squares {
namespace {

constexpr int tile_rows = 8, tile_columns = 4, inner_step = 256, column_step = 256, row_step = 128;

/// Strips of `width` rows of a matrix, one after the other, each column by column; short strips are filled with zeros.
/// Many strips of a block of images are empty: bodies that no image sees together.
class Packed {
 public:
  std::unique_ptr<double[]> numbers;
  std::vector<char> empty;  ///< by strip

  /// Room for so many rows of so many numbers.
  Packed(int rows, int inner, int width)
      : numbers(std::make_unique_for_overwrite<double[]>(static_cast<size_t>((rows + width - 1) / width * width) *
                                                         static_cast<size_t>(inner))),
        empty(static_cast<size_t>((rows + width - 1) / width)) {}

  void pack(const double* from, std::ptrdiff_t row, std::ptrdiff_t column, int rows, int inner, int width) {
    const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(width) * inner;
    double* next = numbers.get();
    for (int i = 0; i < rows; i += width, next += size, from += width * row) {
      const int count = std::min(width, rows - i);
      if (count == width && width == tile_rows && row == 1)
        for (int k = 0; k < inner; ++k)
          __builtin_memcpy(next + k * tile_rows, from + k * column, tile_rows * sizeof(double));
      else if (count == width && width == tile_columns && row == 1)
        for (int k = 0; k < inner; ++k)
          __builtin_memcpy(next + k * tile_columns, from + k * column, tile_columns * sizeof(double));
      else
        copy(from, row, column, count, inner, width, next);
      empty[i / width] = std::all_of(next, next + size, [](double x) { return x == 0; });
    }
  }

 private:
  static void copy(const double* from, std::ptrdiff_t row, std::ptrdiff_t column, int count, int inner, int width,
                   double* to) {
    for (int r = 0; r < count; ++r, from += row)
      for (int k = 0; k < inner; ++k) to[k * width + r] = from[k * column];
    for (int r = count; r < width; ++r)
      for (int k = 0; k < inner; ++k) to[k * width + r] = 0;
  }
};

/// tile (8 × 4, column-major) = A Bᵀ of packed strips. Sums by name: those of an array would live in memory.
PLUMBLINE_CLONES
void multiply_tile(const double* a, const double* b, int inner, double* tile) {
  V4 s0 = {}, s1 = {}, s2 = {}, s3 = {}, t0 = {}, t1 = {}, t2 = {}, t3 = {};
  for (int k = 0; k < inner; ++k, a += tile_rows, b += tile_columns) {
    const V4 upper = load<V4>(a), lower = load<V4>(a + 4);
    s0 += b[0] * upper, t0 += b[0] * lower;
    s1 += b[1] * upper, t1 += b[1] * lower;
    s2 += b[2] * upper, t2 += b[2] * lower;
    s3 += b[3] * upper, t3 += b[3] * lower;
  }
  store<V4>(tile, s0), store<V4>(tile + 4, t0);
  store<V4>(tile + 8, s1), store<V4>(tile + 12, t1);
  store<V4>(tile + 16, s2), store<V4>(tile + 20, t2);
  store<V4>(tile + 24, s3), store<V4>(tile + 28, t3);
}

}  // namespace

void subtract_product(double* c, std::ptrdiff_t stride, int rows, int columns, int inner, const Factors& f,
                      bool lower) {
  Packed a(std::min(rows, row_step), std::min(inner, inner_step), tile_rows);
  Packed b(std::min(columns, column_step), std::min(inner, inner_step), tile_columns);
  double tile[tile_rows * tile_columns];
  for (int k = 0; k < inner; k += inner_step) {
    const int depth = std::min(inner_step, inner - k);
    for (int j = 0; j < columns; j += column_step) {
      const int width = std::min(column_step, columns - j);
      b.pack(f.b + j * f.b_row + k * f.b_column, f.b_row, f.b_column, width, depth, tile_columns);
      for (int i = lower ? j / row_step * row_step : 0; i < rows; i += row_step) {
        const int height = std::min(row_step, rows - i);
        a.pack(f.a + i * f.a_row + k * f.a_column, f.a_row, f.a_column, height, depth, tile_rows);
        for (int jj = 0; jj < width; jj += tile_columns) {
          if (b.empty[jj / tile_columns]) continue;
          for (int ii = 0; ii < height; ii += tile_rows) {
            if (a.empty[ii / tile_rows] || (lower && i + ii + tile_rows <= j + jj)) continue;
            multiply_tile(a.numbers.get() + static_cast<std::ptrdiff_t>(ii) * depth,
                          b.numbers.get() + static_cast<std::ptrdiff_t>(jj) * depth, depth, tile);
            for (int cc = 0; cc < std::min(tile_columns, width - jj); ++cc) {
              double* to = c + (j + jj + cc) * stride + i + ii;
              if (height - ii >= tile_rows)
                for (int r = 0; r < tile_rows; ++r) to[r] -= tile[cc * tile_rows + r];
              else
                for (int r = 0; r < height - ii; ++r) to[r] -= tile[cc * tile_rows + r];
            }
          }
        }
      }
    }
  }
}

}  // namespace plumbline::least_squares
