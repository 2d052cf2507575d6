// The factorisation is Eigen's simplicial L D L'. The triangular solves are ours: several right sides at a time,
// interleaved, so that each entry of L is read once for all of them and the inner loop is a fixed-length vector
// operation.
#include <tbb/parallel_for.h>

#include <Eigen/SparseCholesky>
#include <algorithm>

#include "least_squares/problem/normal_equations.hpp"
#include "plumbline/stop.hpp"

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__) || !defined(__x86_64__)
#define PLUMBLINE_CLONES
#else
#define PLUMBLINE_CLONES __attribute__((target_clones("avx2", "default")))
#endif

namespace plumbline::least_squares {

namespace {

constexpr int kWidth = 8;  // right sides solved together

/// x := (L D L')^-1 x for kWidth interleaved columns, n x kWidth; unit lower L in compressed columns without its
/// diagonal. Rows before `first` of x are zero on entry.
PLUMBLINE_CLONES
void solve_interleaved(int n, int first, const int* column_start, const int* row, const double* value,
                       const double* inverse_diagonal, double* x) {
  for (int j = first; j < n; ++j) {
    const double* xj = x + j * kWidth;
    for (int k = column_start[j]; k < column_start[j + 1]; ++k) {
      double* xi = x + row[k] * kWidth;
      for (int c = 0; c < kWidth; ++c) xi[c] -= value[k] * xj[c];
    }
  }
  for (int j = n - 1; j >= 0; --j) {
    double sum[kWidth];
    double* xj = x + j * kWidth;
    for (int c = 0; c < kWidth; ++c) sum[c] = xj[c] * inverse_diagonal[j];
    for (int k = column_start[j]; k < column_start[j + 1]; ++k) {
      const double* xi = x + row[k] * kWidth;
      for (int c = 0; c < kWidth; ++c) sum[c] -= value[k] * xi[c];
    }
    for (int c = 0; c < kWidth; ++c) xj[c] = sum[c];
  }
}

}  // namespace

struct SparseFactor::Implementation {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>> ldlt;
  std::vector<int> analysed_columns;   // pattern the ordering was made for
  std::vector<int> column_start, row;  // strictly lower part of L
  std::vector<double> value, inverse_diagonal;
  std::vector<int> order;  // order[k] = original index of permuted position k

  int size() const { return static_cast<int>(inverse_diagonal.size()); }

  void copy_factor() {
    const auto& lower = ldlt.matrixL().nestedExpression();
    const int n = static_cast<int>(lower.rows());
    column_start.assign(1, 0);
    row.clear();
    value.clear();
    for (int j = 0; j < n; ++j) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
        if (it.row() <= j) continue;
        row.push_back(static_cast<int>(it.row()));
        value.push_back(it.value());
      }
      column_start.push_back(static_cast<int>(row.size()));
    }
    inverse_diagonal.resize(n);
    for (int j = 0; j < n; ++j) inverse_diagonal[j] = 1.0 / ldlt.vectorD()[j];
    order.resize(n);
    const auto& position = ldlt.permutationP().indices();
    for (int i = 0; i < n; ++i) order[position[i]] = i;
  }

  void solve_in_place(int first, double* x) const {
    solve_interleaved(size(), first, column_start.data(), row.data(), value.data(), inverse_diagonal.data(), x);
  }
};

SparseFactor::SparseFactor() : implementation_(std::make_unique<Implementation>()) {}
SparseFactor::~SparseFactor() = default;
SparseFactor::SparseFactor(SparseFactor&&) noexcept = default;
SparseFactor& SparseFactor::operator=(SparseFactor&&) noexcept = default;

bool SparseFactor::factorise(const Eigen::SparseMatrix<double>& lower, double shift, const std::vector<int>& pinned) {
  const int n = static_cast<int>(lower.rows());
  Eigen::SparseMatrix<double> matrix = lower;
  std::vector<char> is_pinned(n, 0);
  for (int p : pinned) is_pinned[p] = 1;
  for (int j = 0; j < n; ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, j); it; ++it) {
      if (is_pinned[j] || is_pinned[it.row()]) it.valueRef() = it.row() == j ? 1.0 : 0.0;
      if (it.row() == j) it.valueRef() += shift;
    }
  Implementation& f = *implementation_;
  if (static_cast<int>(f.analysed_columns.size()) != static_cast<int>(lower.nonZeros())) {
    f.ldlt.analyzePattern(matrix);
    f.analysed_columns.assign(lower.innerIndexPtr(), lower.innerIndexPtr() + lower.nonZeros());
  }
  f.ldlt.factorize(matrix);
  // Scaled matrices have unit diagonal: a pivot this small is rounding noise of a singular matrix.
  if (f.ldlt.info() != Eigen::Success || !(f.ldlt.vectorD().minCoeff() > 1e-15)) return false;
  f.copy_factor();
  return true;
}

Eigen::MatrixXd SparseFactor::solve(const Eigen::MatrixXd& right_side) const {
  const Implementation& f = *implementation_;
  const int n = f.size();
  Eigen::MatrixXd result(n, right_side.cols());
  std::vector<double> x(static_cast<size_t>(n) * kWidth);
  for (int begin = 0; begin < right_side.cols(); begin += kWidth) {
    const int width = std::min<int>(kWidth, static_cast<int>(right_side.cols()) - begin);
    std::fill(x.begin(), x.end(), 0.0);
    for (int k = 0; k < n; ++k)
      for (int c = 0; c < width; ++c) x[k * kWidth + c] = right_side(f.order[k], begin + c);
    f.solve_in_place(0, x.data());
    for (int k = 0; k < n; ++k)
      for (int c = 0; c < width; ++c) result(f.order[k], begin + c) = x[k * kWidth + c];
  }
  return result;
}

Eigen::MatrixXd SparseFactor::inverse() const {
  const Implementation& f = *implementation_;
  const int n = f.size();
  Eigen::MatrixXd result(n, n);
  const int batches = (n + kWidth - 1) / kWidth;
  parallel_ranges(batches, 8, [&](int first_batch, int last_batch) {
    std::vector<double> x(static_cast<size_t>(n) * kWidth);
    for (int batch = first_batch; batch < last_batch; ++batch) {
      const int begin = batch * kWidth, width = std::min(kWidth, n - begin);
      std::fill(x.begin(), x.end(), 0.0);
      for (int c = 0; c < width; ++c) x[(begin + c) * kWidth + c] = 1.0;
      f.solve_in_place(begin, x.data());
      for (int c = 0; c < width; ++c) {
        double* column = result.data() + static_cast<size_t>(f.order[begin + c]) * static_cast<size_t>(n);
        for (int k = 0; k < n; ++k) column[f.order[k]] = x[k * kWidth + c];
      }
    }
  });
  return result;
}

void parallel_ranges(int count, int grain, const std::function<void(int, int)>& body) {
  tbb::parallel_for(tbb::blocked_range<int>(0, count, static_cast<size_t>(std::max(1, grain))),
                    [&](const tbb::blocked_range<int>& range) {
                      stop_point();  // heard by the thread that called, which takes its share of the ranges
                      body(range.begin(), range.end());
                    });
}

}  // namespace plumbline::least_squares
