#include "photo/detect/sampling_grid.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace plumbline::detect {
namespace {

constexpr int kSmallestPeriod = 2;

int class_of(double at, int origin, int classes) {
  const int index = (static_cast<int>(std::lround(at)) + origin) % classes;
  return index < 0 ? index + classes : index;
}

/// Sums by class modulo `period`.
template <class Rows>
Eigen::MatrixXd folded(const Rows& rows, int period) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(period, rows.cols());
  for (Eigen::Index k = 0; k < rows.rows(); ++k) result.row(k % period) += rows.row(k);
  return result;
}

/// Offsets of the columns of a camera that makes `period` pixels of every m by taking the nearest, for all starts. Of
/// the sensor's pixels number floor((m k + start) / period) is taken for column k.
using Pattern = std::array<double, SamplingGrid::kLargestPeriod>;
std::vector<Pattern> nearest_pixel_patterns(int period, int m) {
  std::vector<Pattern> patterns;
  for (int start = 0; start < period; ++start) {
    Pattern& offsets = patterns.emplace_back();
    for (int k = 0; k < period; ++k) offsets[k] = (0.5 * (period - 1) - (m * k + start) % period) / m;
  }
  return patterns;
}

}  // namespace

void SamplingGridEstimate::add(const EdgeSamples& samples, const EdgeColumns& columns, const EdgeFrame& frame,
                               const EdgeNormal& normal, double noise, const Eigen::Vector2i& origin) {
  // Products of the derivative by the edge's position with those by its eight parameters and the residual.
  Eigen::Matrix<double, kClasses, 9> by_column = Eigen::Matrix<double, kClasses, 9>::Zero(), by_row = by_column;
  constexpr double kFlat = 0.5;  // grey values a pixel: samples of the plateaus say nothing
  const double weight = 1 / (noise * noise);
  // A pixel that lies further along x is further across by the normal's x: as if the edge were nearer.
  const double nx = -frame.across.x(), ny = -frame.across.y();
  for (std::size_t i = 0; i < samples.count; ++i) {
    const double t = samples.t[i], d = samples.d[i], p = columns.position[i];
    if (std::abs(p) < kFlat) continue;
    const Eigen::Vector2d at = frame.centre + frame.half_length * t * frame.along + d * frame.across;
    const int x = class_of(at.x(), origin.x(), kClasses), y = class_of(at.y(), origin.y(), kClasses);
    Eigen::Matrix<double, 1, 9> row;
    const double low = columns.low[i], high = columns.high[i];
    row << p, p * t, p * t * t, columns.blur[i], low, low * t, high, high * t, columns.residual[i];
    row *= p;
    by_column.row(x) += row, by_row.row(y) += row;
    column_squares_[x] += weight * nx * nx * p * p, row_squares_[y] += weight * ny * ny * p * p;
    products_(x, y) += weight * nx * ny * p * p;
  }
  by_column *= weight * nx, by_row *= weight * ny;
  column_right_ += by_column.col(8), row_right_ += by_row.col(8);
  const Eigen::LDLT<EdgeNormal> own(normal);
  for (int period = kSmallestPeriod; period <= SamplingGrid::kLargestPeriod; ++period) {
    Eigen::MatrixXd mixed(2 * period, 8);
    mixed << folded(by_column.leftCols<8>(), period), folded(by_row.leftCols<8>(), period);
    Eigen::MatrixXd& taken = taken_[period];
    if (taken.size() == 0) taken = Eigen::MatrixXd::Zero(2 * period, 2 * period);
    taken += mixed * own.solve(mixed.transpose());
  }
  ++edges_;
  samples_ += static_cast<double>(samples.count);
  log_variance_ += static_cast<double>(samples.count) * std::log(noise * noise);
}

SamplingGridEstimate::Equations SamplingGridEstimate::equations(int period) const {
  const Eigen::Index n = period;
  Equations e{-taken_[period], Eigen::VectorXd(2 * n)};
  e.normal.topLeftCorner(n, n).diagonal() += folded(column_squares_, period);
  e.normal.bottomRightCorner(n, n).diagonal() += folded(row_squares_, period);
  const Eigen::MatrixXd rows = folded(products_, period);
  const Eigen::MatrixXd both = folded(Eigen::MatrixXd(rows.transpose()), period).transpose();
  e.normal.topRightCorner(n, n) += both;
  e.normal.bottomLeftCorner(n, n) += both.transpose();
  e.right << folded(column_right_, period), folded(row_right_, period);
  return e;
}

std::vector<SamplingGrid> SamplingGridEstimate::better() const {
  constexpr int kFewestEdges = 40, kLargestReduction = 3;
  constexpr std::size_t kMost = 6;
  constexpr double kShare = 0.05;  // of the residuals' squares that an uneven grid has to explain
  struct Candidate {
    double gain;
    SamplingGrid grid;
  };
  std::vector<Candidate> candidates;
  if (edges_ < kFewestEdges) return {};
  for (int period = kSmallestPeriod; period <= SamplingGrid::kLargestPeriod; ++period) {
    if (used_.period > 1 && used_.period != period) continue;
    const Equations e = equations(period);
    for (int m = period + 1; m < kLargestReduction * period; ++m) {
      if (std::gcd(m, period) > 1) continue;
      Candidate best{used_.period > 1 ? 0 : kShare * samples_, used_};
      std::vector<Pattern> patterns = nearest_pixel_patterns(period, m);
      patterns.push_back(Pattern{});  // a picture may be made smaller in one direction only
      for (const Pattern& columns : patterns)
        for (const Pattern& rows : patterns) {
          const SamplingGrid grid{period, columns, rows};
          Eigen::VectorXd change(2 * period);
          for (int k = 0; k < period; ++k)
            change[k] = grid.column(k) - used_.column(k), change[period + k] = grid.row(k) - used_.row(k);
          const double gain = change.dot(2 * e.right - e.normal * change);
          if (gain > best.gain) best = {gain, grid};
        }
      if (best.grid.period > used_.period || (best.gain > 0 && used_.period > 1)) candidates.push_back(best);
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.gain > b.gain; });
  std::vector<SamplingGrid> grids;
  for (std::size_t k = 0; k < std::min(kMost, candidates.size()); ++k) grids.push_back(candidates[k].grid);
  return grids;
}

}  // namespace plumbline::detect
