#include "least_squares/problem/normal_equations.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumbline::least_squares {

NormalEquations::NormalEquations(const Linearisation& lin, int unknowns)
    : scaled_(unknowns, unknowns), scale_(Eigen::VectorXd::Ones(unknowns)), gradient_(Eigen::VectorXd::Zero(unknowns)) {
  // Key = column * n + row of the lower triangle; sorting the keys gives the compressed columns.
  const auto n = static_cast<std::int64_t>(unknowns);
  std::vector<std::int64_t> keys;
  for (std::int64_t i = 0; i < n; ++i) keys.push_back(i * n + i);
  for (const auto& block : lin.blocks)
    for (int j = 0; j < block.column_count; ++j)
      for (int i = j; i < block.column_count; ++i)
        keys.push_back(lin.columns[block.column_begin + j] * n + lin.columns[block.column_begin + i]);
  const std::vector<std::int64_t> products(keys.begin() + n, keys.end());
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  scaled_.resizeNonZeros(static_cast<Eigen::Index>(keys.size()));
  std::vector<int> column_start(unknowns + 1, 0);
  for (size_t k = 0; k < keys.size(); ++k) {
    scaled_.innerIndexPtr()[k] = static_cast<int>(keys[k] % n);
    ++column_start[keys[k] / n + 1];
  }
  for (int j = 0; j < unknowns; ++j) column_start[j + 1] += column_start[j];
  std::copy(column_start.begin(), column_start.end(), scaled_.outerIndexPtr());
  positions_.reserve(products.size());
  for (std::int64_t key : products) {
    const int* begin = scaled_.innerIndexPtr() + column_start[key / n];
    const int* end = scaled_.innerIndexPtr() + column_start[key / n + 1];
    positions_.push_back(
        static_cast<int>(std::lower_bound(begin, end, static_cast<int>(key % n)) - scaled_.innerIndexPtr()));
  }
}

void NormalEquations::assemble(const Linearisation& lin) {
  double* values = scaled_.valuePtr();
  std::fill_n(values, scaled_.nonZeros(), 0.0);
  gradient_.setZero();
  size_t product = 0;
  for (const auto& block : lin.blocks) {
    const double* jacobian = lin.jacobian.data() + block.jacobian_begin;
    const double* residual = lin.residuals.data() + block.row;
    const int count = block.column_count;
    for (int j = 0; j < count; ++j) {
      double gradient = 0;
      for (int r = 0; r < block.rows; ++r) gradient += jacobian[r * count + j] * residual[r];
      gradient_[lin.columns[block.column_begin + j]] += gradient;
      for (int i = j; i < count; ++i) {
        double sum = 0;
        for (int r = 0; r < block.rows; ++r) sum += jacobian[r * count + i] * jacobian[r * count + j];
        values[positions_[product++]] += sum;
      }
    }
  }
  // The diagonal is the first entry of each column of a lower triangle.
  for (int j = 0; j < size(); ++j) {
    const double diagonal = values[scaled_.outerIndexPtr()[j]];
    scale_[j] = diagonal > 0 ? std::sqrt(diagonal) : 1.0;
  }
  for (int j = 0; j < size(); ++j)
    for (int k = scaled_.outerIndexPtr()[j]; k < scaled_.outerIndexPtr()[j + 1]; ++k)
      values[k] /= scale_[j] * scale_[scaled_.innerIndexPtr()[k]];
}

}  // namespace plumbline::least_squares
