// The inner loops of a block adjustment. All run along rows in memory, four numbers at a time where the processor can;
// every sum has one order, whatever the processor, and nothing is fused: the same bits everywhere.
#pragma once

#include <cstddef>

namespace plumbline::bundle {

/// Neighbouring columns of an eliminated block's Y that are neighbours in the reduced system too.
struct Run {
  int local = 0;   ///< first column of Y
  int offset = 0;  ///< first row of the reduced system
  int length = 0;
};

/// target (a_size × b_size) += aᵀ b, for factors of the same few rows: Jacobians, or residuals and a Jacobian.
struct Outer {
  double* target;
  std::ptrdiff_t target_stride;  ///< from row to row
  const double* a;
  const double* b;
  int a_size, b_size;
  int a_stride, b_stride;
};
void add_outer(int rows, const Outer* jobs, int count);

/// W → L⁻¹ W in place, `size` rows of `columns` numbers; L stands in the top left corner of a column-major 6 × 6.
void solve_lower(int size, const double* factor, double* w, int columns);

/// What an eliminated block has to do with a kept one: its Y (`rows` × `columns`, row by row, L⁻¹ of its right side
/// behind) and the column where the kept block begins in it.
struct Coupled {
  const double* y = nullptr;
  const Run* runs = nullptr;
  int run_count = 0, rows = 0, columns = 0, first = 0;
};

/// The `size` columns of a kept block in the reduced system (a panel, column-major) −= Yᵀ Y of everything coupled with
/// it, from the row of the diagonal on, and its right side −= Yᵀ L⁻¹ right. `rows`: by the first row of a kept block in
/// the reduced system its first row in the panel, where neighbours are neighbours again.
void subtract_strip(double* panel, std::ptrdiff_t stride, int size, const int* rows, const Coupled* coupled,
                    std::size_t count, double* right);

/// sums[k] = Σ over the runs of Y_k · x.
void multiply_runs(const double* y, int y_rows, int columns, const Run* runs, int run_count, const double* x,
                   double* sums);

/// q (rows × rows, column-major) = I − J K Jᵀ. J row by row, at most 36 columns; K symmetric, row by row with
/// `k_stride` a multiple of 4: what stands between `columns` and the next such multiple is read and not used.
void residual_cofactor(int rows, int columns, const double* j, int j_stride, const double* k, int k_stride, double* q);

}  // namespace plumbline::bundle
