#include "photo/bundle/kernels.hpp"

#include <algorithm>

#include "geometry/vectors.hpp"

namespace plumbline::bundle {
namespace {

template <typename V>
PLUMBLINE_INLINE void outer_at(int rows, const Outer& job, int c) {
  double* to = job.target + c;
  if (rows == 2) {
    const V b0 = load<V>(job.b + c), b1 = load<V>(job.b + job.b_stride + c);
    for (int r = 0; r < job.a_size; ++r, to += job.target_stride)
      store<V>(to, load<V>(to) + (job.a[r] * b0 + job.a[job.a_stride + r] * b1));
    return;
  }
  if (rows == 8) {
    const double* b = job.b + c;
    const std::ptrdiff_t t = job.b_stride, s = job.a_stride;
    const V b0 = load<V>(b), b1 = load<V>(b + t), b2 = load<V>(b + 2 * t), b3 = load<V>(b + 3 * t),
            b4 = load<V>(b + 4 * t), b5 = load<V>(b + 5 * t), b6 = load<V>(b + 6 * t), b7 = load<V>(b + 7 * t);
    for (int r = 0; r < job.a_size; ++r, to += job.target_stride) {
      const double* a = job.a + r;
      store<V>(to,
               load<V>(to) +
                   (((((((a[0] * b0 + a[s] * b1) + a[2 * s] * b2) + a[3 * s] * b3) + a[4 * s] * b4) + a[5 * s] * b5) +
                     a[6 * s] * b6) +
                    a[7 * s] * b7));
    }
    return;
  }
  for (int r = 0; r < job.a_size; ++r, to += job.target_stride) {
    V sum = job.a[r] * load<V>(job.b + c);
    for (int k = 1; k < rows; ++k) sum += job.a[k * job.a_stride + r] * load<V>(job.b + k * job.b_stride + c);
    store<V>(to, load<V>(to) + sum);
  }
}

template <typename V>
PLUMBLINE_INLINE void strip_at(double* to, std::ptrdiff_t stride, int size, const double* own, const double* y,
                               int y_rows, int columns) {
  if (y_rows == 3) {
    const V y0 = load<V>(y), y1 = load<V>(y + columns), y2 = load<V>(y + 2 * columns);
    for (int c = 0; c < size; ++c, to += stride)
      store<V>(to, load<V>(to) - ((own[c] * y0 + own[columns + c] * y1) + own[2 * columns + c] * y2));
    return;
  }
  for (int c = 0; c < size; ++c, to += stride) {
    V sum = own[c] * load<V>(y);
    for (int k = 1; k < y_rows; ++k) sum += own[k * columns + c] * load<V>(y + k * columns);
    store<V>(to, load<V>(to) - sum);
  }
}

/// The same for eight rows, three rows of Y: what is read of the kept block serves both halves.
PLUMBLINE_INLINE void strip_of_eight(double* to, std::ptrdiff_t stride, int size, const double* own, const double* y,
                                     int columns) {
  const V4 y0 = load<V4>(y), y1 = load<V4>(y + columns), y2 = load<V4>(y + 2 * columns), z0 = load<V4>(y + 4),
           z1 = load<V4>(y + columns + 4), z2 = load<V4>(y + 2 * columns + 4);
  for (int c = 0; c < size; ++c, to += stride) {
    const double a = own[c], b = own[columns + c], d = own[2 * columns + c];
    store<V4>(to, load<V4>(to) - ((a * y0 + b * y1) + d * y2));
    store<V4>(to + 4, load<V4>(to + 4) - ((a * z0 + b * z1) + d * z2));
  }
}

template <typename V>
PLUMBLINE_INLINE void solve_at(int size, const double* factor, double* w, int columns) {
  for (int r = 0; r < size; ++r) {
    V sum = load<V>(w + r * columns);
    for (int k = 0; k < r; ++k) sum -= factor[6 * k + r] * load<V>(w + k * columns);
    store<V>(w + r * columns, sum * (1 / factor[7 * r]));
  }
}

/// sums[k] = Σ over the runs of Y_k · x for `Count` rows of Y.
template <int Count>
PLUMBLINE_INLINE void multiply_rows(const double* y, int columns, const Run* runs, int run_count, const double* x,
                                    double* sums) {
  const double *y1 = Count > 1 ? y + columns : y, *y2 = Count > 2 ? y + 2 * columns : y;
  V4 s0 = {}, s1 = {}, s2 = {};
  double r0 = 0, r1 = 0, r2 = 0;
  for (const Run* run = runs; run < runs + run_count; ++run) {
    const double* from = x + run->offset;
    int c = 0, at = run->local;
    for (; c + 4 <= run->length; c += 4, at += 4) {
      const V4 value = load<V4>(from + c);
      s0 += value * load<V4>(y + at);
      if (Count > 1) s1 += value * load<V4>(y1 + at);
      if (Count > 2) s2 += value * load<V4>(y2 + at);
    }
    for (; c < run->length; ++c, ++at) {
      r0 += from[c] * y[at];
      if (Count > 1) r1 += from[c] * y1[at];
      if (Count > 2) r2 += from[c] * y2[at];
    }
  }
  sums[0] = ((s0[0] + s0[1]) + (s0[2] + s0[3])) + r0;
  if (Count > 1) sums[1] = ((s1[0] + s1[1]) + (s1[2] + s1[3])) + r1;
  if (Count > 2) sums[2] = ((s2[0] + s2[1]) + (s2[2] + s2[3])) + r2;
}

}  // namespace

PLUMBLINE_CLONES
void add_outer(int rows, const Outer* jobs, int count) {
  for (const Outer* job = jobs; job < jobs + count; ++job) {
    int c = 0;
    for (; c + 4 <= job->b_size; c += 4) outer_at<V4>(rows, *job, c);
    if (c + 2 <= job->b_size) outer_at<V2>(rows, *job, c), c += 2;
    if (c < job->b_size) outer_at<double>(rows, *job, c);
  }
}

PLUMBLINE_CLONES
void solve_lower(int size, const double* factor, double* w, int columns) {
  int c = 0;
  for (; c + 4 <= columns; c += 4) solve_at<V4>(size, factor, w + c, columns);
  for (; c < columns; ++c) solve_at<double>(size, factor, w + c, columns);
}

PLUMBLINE_CLONES
void subtract_strip(double* panel, std::ptrdiff_t stride, int size, const int* rows, const Coupled* coupled,
                    std::size_t count, double* right) {
  for (const Coupled* block = coupled; block < coupled + count; ++block) {
    const double* own = block->y + block->first;
    const double* half = block->y + static_cast<std::ptrdiff_t>(block->rows) * block->columns;
    for (int c = 0; c < size; ++c) {
      double sum = own[c] * half[0];
      for (int k = 1; k < block->rows; ++k) sum += own[k * block->columns + c] * half[k];
      right[c] -= sum;
    }
    for (const Run* run = block->runs; run < block->runs + block->run_count; ++run) {
      const int end = run->local + run->length;
      if (end <= block->first) continue;
      int c = std::max(run->local, block->first);
      double* to = panel + rows[run->offset + c - run->local] - c;
      const double* y = block->y;
      for (; block->rows == 3 && c + 8 <= end; c += 8) strip_of_eight(to + c, stride, size, own, y + c, block->columns);
      for (; c + 4 <= end; c += 4) strip_at<V4>(to + c, stride, size, own, y + c, block->rows, block->columns);
      if (c + 2 <= end) strip_at<V2>(to + c, stride, size, own, y + c, block->rows, block->columns), c += 2;
      if (c < end) strip_at<double>(to + c, stride, size, own, y + c, block->rows, block->columns);
    }
  }
}

PLUMBLINE_CLONES
void multiply_runs(const double* y, int y_rows, int columns, const Run* runs, int run_count, const double* x,
                   double* sums) {
  for (; y_rows >= 3; y_rows -= 3, y += 3 * columns, sums += 3) multiply_rows<3>(y, columns, runs, run_count, x, sums);
  if (y_rows == 2) multiply_rows<2>(y, columns, runs, run_count, x, sums);
  if (y_rows == 1) multiply_rows<1>(y, columns, runs, run_count, x, sums);
}

PLUMBLINE_CLONES
void residual_cofactor(int rows, int columns, const double* j, int j_stride, const double* k, int k_stride, double* q) {
  constexpr int widest = 36;
  double product[widest];  // a row of J K
  for (int r = 0; r < rows; ++r) {
    const double* own = j + r * j_stride;
    for (int c = 0; c < columns; c += 4) {
      V4 sum = own[0] * load<V4>(k + c);
      for (int i = 1; i < columns; ++i) sum += own[i] * load<V4>(k + i * k_stride + c);
      store<V4>(product + c, sum);
    }
    for (int s = 0; s <= r; ++s) {
      const double* other = j + s * j_stride;
      V4 sum = {};
      int c = 0;
      for (; c + 4 <= columns; c += 4) sum += load<V4>(product + c) * load<V4>(other + c);
      double rest = 0;
      for (; c < columns; ++c) rest += product[c] * other[c];
      const double value = ((sum[0] + sum[1]) + (sum[2] + sum[3])) + rest;
      q[s * rows + r] = q[r * rows + s] = (r == s ? 1.0 : 0.0) - value;
    }
  }
}

}  // namespace plumbline::bundle
