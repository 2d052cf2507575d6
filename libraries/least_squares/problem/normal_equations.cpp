#include "least_squares/problem/normal_equations.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "least_squares/sparse/selected_inverse.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::least_squares {

NormalEquations::NormalEquations(const Linearisation& lin, const UnknownIndex& unknowns, const NormalEquations* like)
    : scale_(Eigen::VectorXd::Ones(unknowns.count())), gradient_(Eigen::VectorXd::Zero(unknowns.count())) {
  std::vector<int> sizes;
  for (int u = 0; u < unknowns.count(); ++u) {
    if (u == 0 || unknowns.block_of(u) != unknowns.block_of(u - 1)) sizes.push_back(0);
    ++sizes.back();
    block_of_.push_back(static_cast<int>(sizes.size()) - 1);
  }
  if (like && like->block_of_ == block_of_ && like->holds(lin, sizes)) {
    analysis_ = like->analysis_;
    blocks_ = like->blocks_;
    return;
  }
  Pattern pattern(sizes);
  std::vector<int> met;
  for (const auto& block : lin.blocks) {
    met.clear();
    for (const Part& part : parts_of(lin, block)) met.push_back(part.block);
    pattern.couple(met);
  }
  analysis_ = std::make_shared<const Analysis>(pattern);
  blocks_ = SymmetricBlocks(pattern);
}

std::vector<NormalEquations::Part> NormalEquations::parts_of(const Linearisation& lin,
                                                             const Linearisation::Block& block) const {
  std::vector<Part> parts;
  for (int k = 0; k < block.column_count; ++k) {
    const int of = block_of(lin.columns[block.column_begin + k]);
    if (parts.empty() || parts.back().block != of) parts.push_back({of, k, 0});
    ++parts.back().count;
  }
  return parts;
}

/// Whether blocks of these sizes, and each pair that meets, are in its pattern.
bool NormalEquations::holds(const Linearisation& lin, const std::vector<int>& sizes) const {
  if (blocks_.block_count() != static_cast<int>(sizes.size())) return false;
  for (std::size_t b = 0; b < sizes.size(); ++b)
    if (blocks_.size(static_cast<int>(b)) != sizes[b]) return false;
  return std::all_of(lin.blocks.begin(), lin.blocks.end(), [&](const Linearisation::Block& block) {
    const std::vector<Part> parts = parts_of(lin, block);
    for (std::size_t a = 0; a < parts.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        if (const auto& rows = blocks_.column(parts[b].block).rows;
            !std::binary_search(rows.begin(), rows.end(), parts[a].block))
          return false;
    return true;
  });
}

void NormalEquations::assemble(const Linearisation& lin) {
  blocks_.set_zero();
  gradient_.setZero();
  Eigen::MatrixXd product;
  for (const auto& block : lin.blocks) {
    const auto jacobian = lin.jacobian_of(block);
    const double* residual = lin.residuals.data() + block.row;
    for (int j = 0; j < block.column_count; ++j) {
      double sum = 0;
      for (int r = 0; r < block.rows; ++r) sum += jacobian(r, j) * residual[r];
      gradient_[lin.columns[block.column_begin + j]] += sum;
    }
    // A block of unknowns appears whole: its columns follow each other, ascending.
    const std::vector<Part> parts = parts_of(lin, block);
    for (std::size_t a = 0; a < parts.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        auto target = blocks_.at(parts[a].block, parts[b].block);
        for (int j = 0; j < parts[b].count; ++j)
          for (int i = a == b ? j : 0; i < parts[a].count; ++i) {
            double sum = 0;
            for (int r = 0; r < block.rows; ++r)
              sum += jacobian(r, parts[a].first + i) * jacobian(r, parts[b].first + j);
            target(i, j) += sum;
          }
      }
  }
  const Eigen::VectorXd diagonal = blocks_.diagonal();
  for (int j = 0; j < size(); ++j) scale_[j] = diagonal[j] > 0 ? std::sqrt(diagonal[j]) : 1.0;
}

Eigen::MatrixXd NormalEquations::multiply_scaled(const Eigen::Ref<const Eigen::MatrixXd>& x) const {
  const Eigen::VectorXd inverse = scale_.cwiseInverse();
  return inverse.asDiagonal() * blocks_.multiply(inverse.asDiagonal() * x);
}

bool SparseFactor::factorise(const NormalEquations& normal, double shift, const std::vector<int>& pinned) {
  Scaling scaling{normal.scale().cwiseInverse(), Eigen::VectorXd::Constant(normal.size(), shift)};
  for (const int p : pinned) scaling.scale[p] = 0, scaling.added[p] = 1 + shift;
  if (!factor_ || factor_->shared_analysis() != normal.analysis())
    factor_ = std::make_unique<SparseCholesky>(normal.analysis());
  // The diagonal is that of a unit matrix: a pivot this small is rounding noise of a singular matrix.
  return factor_->factorise(normal.blocks(), 1e-15, scaling);
}

Eigen::MatrixXd SparseFactor::inverse() const {
  const int n = factor_->analysis().unknown_count();
  if (factor_->analysis().is_dense())
    return Eigen::MatrixXd(SelectedInverse(*factor_).dense().selfadjointView<Eigen::Lower>());
  constexpr int kTogether = 64;  // right sides
  Eigen::MatrixXd result(n, n);
  parallel_ranges((n + kTogether - 1) / kTogether, 1, [&](int first, int last) {
    for (int batch = first; batch < last; ++batch) {
      std::vector<int> columns;
      for (int c = batch * kTogether; c < std::min(n, (batch + 1) * kTogether); ++c) columns.push_back(c);
      result.middleCols(columns.front(), static_cast<Eigen::Index>(columns.size())) = factor_->columns(columns);
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
