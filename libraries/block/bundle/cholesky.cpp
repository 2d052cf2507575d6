#include "block/bundle/cholesky.hpp"

#include <Eigen/Cholesky>

#include "block/bundle/kernels.hpp"

namespace plumbline::bundle {
namespace {

constexpr Eigen::Index panel = 64;

}  // namespace

bool Cholesky::compute(Eigen::MatrixXd lower) {
  factor_ = std::move(lower);
  const Eigen::Index n = factor_.rows();
  for (Eigen::Index at = 0; at < n; at += panel) {
    const Eigen::Index width = std::min(panel, n - at), rest = n - at - width;
    auto corner = factor_.block(at, at, width, width);
    const Eigen::LLT<Eigen::MatrixXd> small(corner);
    if (small.info() != Eigen::Success || !small.matrixLLT().diagonal().allFinite()) return false;
    corner = small.matrixLLT();
    if (rest == 0) return true;
    auto below = factor_.block(at + width, at, rest, width);
    corner.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
    subtract_product(&factor_(at + width, at + width), n, static_cast<int>(rest), static_cast<int>(rest),
                     static_cast<int>(width), {below.data(), 1, n, below.data(), 1, n}, true);
  }
  return true;
}

void Cholesky::half_solve_in_place(Eigen::Ref<Eigen::MatrixXd> right) const {
  factor_.triangularView<Eigen::Lower>().solveInPlace(right);
}

void Cholesky::solve_in_place(Eigen::Ref<Eigen::MatrixXd> right) const {
  factor_.triangularView<Eigen::Lower>().solveInPlace(right);
  factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(right);
}

Eigen::MatrixXd Cholesky::inverse_factor(Eigen::Index first) const {
  const Eigen::Index n = factor_.rows() - first;
  const auto factor = factor_.bottomRightCorner(n, n);
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index at = 0; at < n; at += panel) {
    const Eigen::Index width = std::min(panel, n - at);
    auto rows = root.middleRows(at, width).leftCols(at + width);
    for (Eigen::Index column = 0; column < at; column += panel)  // −L L⁻¹; above its diagonal L⁻¹ is nothing
      subtract_product(&root(at, column), n, static_cast<int>(width), static_cast<int>(panel),
                       static_cast<int>(at - column),
                       {&factor_(first + at, first + column), 1, factor_.rows(), &root(column, column), n, 1}, false);
    rows.rightCols(width).setIdentity();
    const Eigen::MatrixXd solved =
        factor.block(at, at, width, width).triangularView<Eigen::Lower>().solve(Eigen::MatrixXd(rows));
    rows = solved;
  }
  return root;
}

Eigen::MatrixXd Cholesky::inverse(Eigen::Index first) const {
  const Eigen::MatrixXd root = inverse_factor(first);
  const Eigen::Index n = root.rows();
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);  // −L⁻ᵀ L⁻¹, its lower triangle
  for (Eigen::Index at = 0; at < n; at += panel) {
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

}  // namespace plumbline::bundle
