#include "least_squares/sparse/dense_cholesky.hpp"

#include <Eigen/Core>

#include "least_squares/sparse/dense_kernels.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

constexpr Eigen::Index panel = 32;

}  // namespace

bool Cholesky::compute(Eigen::MatrixXd lower) {
  factor_ = std::move(lower);
  const Eigen::Index n = factor_.rows();
  for (Eigen::Index at = 0; at < n; at += panel) {
    stop_point();
    const Eigen::Index width = std::min(panel, n - at), rest = n - at - width;
    double* corner = &factor_(at, at);
    if (factor_lower(static_cast<int>(width), corner, n) < width) return false;
    if (rest == 0) return true;
    const double* below = corner + width;
    solve_right(static_cast<int>(width), corner, n, static_cast<int>(rest), corner + width, n);
    subtract_product(&factor_(at + width, at + width), n, static_cast<int>(rest), static_cast<int>(rest),
                     static_cast<int>(width), {below, 1, n, below, 1, n}, true);
  }
  return true;
}

void Cholesky::half_solve_in_place(Eigen::Ref<Eigen::MatrixXd> right) const {
  const Eigen::Index n = factor_.rows();
  const int columns = static_cast<int>(right.cols());
  for (Eigen::Index at = 0; at < n; at += panel) {
    stop_point();
    const Eigen::Index width = std::min(panel, n - at), rest = n - at - width;
    solve_left(static_cast<int>(width), &factor_(at, at), n, columns, &right(at, 0), right.outerStride());
    if (rest > 0)
      subtract_product(&right(at + width, 0), right.outerStride(), static_cast<int>(rest), columns,
                       static_cast<int>(width), {&factor_(at + width, at), 1, n, &right(at, 0), right.outerStride(), 1},
                       false);
  }
}

void Cholesky::solve_in_place(Eigen::Ref<Eigen::MatrixXd> right) const {
  factor_.triangularView<Eigen::Lower>().solveInPlace(right);
  factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(right);
}

void Cholesky::solve_in_place(Eigen::VectorXd& right) const {
  factor_.triangularView<Eigen::Lower>().solveInPlace(right);
  factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(right);
}

Eigen::MatrixXd inverse_of_lower(const double* lower, std::ptrdiff_t stride, int size) {
  const Eigen::Index n = size;
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index at = 0; at < n; at += panel) {
    stop_point();
    const Eigen::Index width = std::min(panel, n - at);
    for (Eigen::Index column = 0; column < at; column += panel) {  // −L L⁻¹; above its diagonal L⁻¹ is nothing
      stop_point();
      subtract_product(&root(at, column), n, static_cast<int>(width), static_cast<int>(panel),
                       static_cast<int>(at - column),
                       {lower + at + column * stride, 1, stride, &root(column, column), n, 1}, false);
    }
    root.block(at, at, width, width).setIdentity();
    solve_left(static_cast<int>(width), lower + at + at * stride, stride, static_cast<int>(at + width), &root(at, 0),
               n);
  }
  return root;
}

Eigen::MatrixXd Cholesky::inverse_of(const Eigen::MatrixXd& root) {
  const Eigen::Index n = root.rows();
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);  // −L⁻ᵀ L⁻¹, its lower triangle
  for (Eigen::Index at = 0; at < n; at += panel) {
    stop_point();
    const Eigen::Index width = std::min(panel, n - at);
    subtract_product(&result(at, 0), n, static_cast<int>(width), static_cast<int>(at + width), static_cast<int>(n - at),
                     {&root(at, at), n, 1, &root(at, 0), n, 1}, false);
  }
  for (Eigen::Index c = 0; c < n; ++c) {
    result.col(c).tail(n - c) *= -1;
    result.row(c).tail(n - c - 1) = result.col(c).tail(n - c - 1).transpose();
  }
  return result;
}

}  // namespace plumbline::least_squares
