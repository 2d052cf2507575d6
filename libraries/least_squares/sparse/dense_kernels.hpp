// Products and triangles of dense matrices, column-major, in tiles that stay near the processor: what the factors of
// this folder are made of. Every sum has one order, whatever the processor, and nothing is fused: the same bits
// everywhere.
#pragma once

#include <cstddef>

namespace plumbline::least_squares {

/// C (rows × columns, column-major) −= A Bᵀ, where A(i, k) is at a[i·a_row + k·a_column] and B(j, k) at b[j·b_row +
/// k·b_column]. With `lower`, what lies above the diagonal of C is left undefined.
struct Factors {
  const double* a;
  std::ptrdiff_t a_row, a_column;
  const double* b;
  std::ptrdiff_t b_row, b_column;
};
void subtract_product(double* c, std::ptrdiff_t stride, int rows, int columns, int inner, const Factors& factors,
                      bool lower);

/// Small triangles of a Cholesky factor (column-major, at most 64 rows), in place. L of a symmetric matrix, of which
/// the lower triangle is read; returns the column whose pivot is not positive or no number, or `size`.
int factor_lower(int size, double* matrix, std::ptrdiff_t stride);
/// X (rows × size, column-major) → X L⁻ᵀ.
void solve_right(int size, const double* lower, std::ptrdiff_t stride, int rows, double* x, std::ptrdiff_t x_stride);
/// X (size × columns, column-major) → L⁻¹ X.
void solve_left(int size, const double* lower, std::ptrdiff_t stride, int columns, double* x, std::ptrdiff_t x_stride);

}  // namespace plumbline::least_squares
