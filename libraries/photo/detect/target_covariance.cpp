#include "photo/detect/target_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace plumbline::detect {
namespace {

constexpr int kLags = kTargetLags;

/// Residuals on the grid, nan outside the disc.
struct Grid {
  Eigen::Vector2i corner;
  Eigen::ArrayXXd value;
  Grid(const TargetPixels& pixels, const Eigen::VectorXd& values) {
    Eigen::Vector2i low = pixels.at.front(), high = low;
    for (const auto& p : pixels.at) low = low.cwiseMin(p), high = high.cwiseMax(p);
    corner = low;
    value = Eigen::ArrayXXd::Constant(high.x() - low.x() + 1, high.y() - low.y() + 1, std::nan(""));
    for (std::size_t i = 0; i < pixels.at.size(); ++i)
      value(pixels.at[i].x() - low.x(), pixels.at[i].y() - low.y()) = values[static_cast<Eigen::Index>(i)];
  }
  double operator()(int x, int y) const {
    x -= corner.x(), y -= corner.y();
    return x < 0 || y < 0 || x >= value.rows() || y >= value.cols() ? std::nan("") : value(x, y);
  }
};

constexpr int kWindow = 2 * kLags + 1;
using Lags = Eigen::Array<double, kWindow, kWindow>;  // by the lag in x and in y, the middle is none

/// Autocovariance of the noise from the odd part of the residuals: r(c + d) − r(c − d), where the second is
/// interpolated between four pixels. White noise n gives C_d = C + C * k with the autocorrelation k of those four
/// weights, and is unfolded from it.
Lags autocovariance(const TargetFit& fit) {
  const Grid grid(fit.pixels, fit.residuals);
  const Eigen::Vector2d twice = 2 * fit.p.head<2>();
  const Eigen::Vector2d fraction = twice.array() - twice.array().floor();
  Eigen::VectorXd difference = Eigen::VectorXd::Constant(fit.residuals.size(), std::nan(""));
  for (Eigen::Index i = 0; i < difference.size(); ++i) {
    const auto& at = fit.pixels.at[i];
    const int x = static_cast<int>(std::floor(twice.x())) - at.x(),
              y = static_cast<int>(std::floor(twice.y())) - at.y();
    const double u = fraction.x(), v = fraction.y();
    difference[i] = fit.residuals[i] - ((1 - v) * ((1 - u) * grid(x, y) + u * grid(x + 1, y)) +
                                        v * ((1 - u) * grid(x, y + 1) + u * grid(x + 1, y + 1)));
  }
  const Grid odd(fit.pixels, difference);
  const Grid weight(fit.pixels, fit.jacobian.leftCols<2>().rowwise().norm());
  Lags measured;
  for (int h = -kLags; h <= kLags; ++h)
    for (int k = -kLags; k <= kLags; ++k) {
      double sum = 0, weights = 0;
      for (const auto& p : fit.pixels.at) {
        const double product = odd(p.x(), p.y()) * odd(p.x() + h, p.y() + k);
        if (std::isnan(product)) continue;
        const double w = weight(p.x(), p.y()) * weight(p.x() + h, p.y() + k);
        sum += w * product, weights += w;
      }
      measured(h + kLags, k + kLags) = weights > 0 ? sum / weights : 0;
    }
  const auto interpolation = [](double f, int lag) {
    return lag == 0 ? (1 - f) * (1 - f) + f * f : std::abs(lag) == 1 ? f * (1 - f) : 0.0;
  };
  Lags c = 0.6 * measured;
  for (int iteration = 0; iteration < 40; ++iteration) {
    Lags folded = c;
    for (int h = -kLags; h <= kLags; ++h)
      for (int k = -kLags; k <= kLags; ++k)
        for (int a = -1; a <= 1; ++a)
          for (int b = -1; b <= 1; ++b)
            if (std::abs(h - a) <= kLags && std::abs(k - b) <= kLags)
              folded(h + kLags, k + kLags) +=
                  interpolation(fraction.x(), a) * interpolation(fraction.y(), b) * c(h - a + kLags, k - b + kLags);
    c += 0.6 * (measured - folded);
  }
  c(kLags, kLags) = std::max(c(kLags, kLags), 1.0 / 12);  // of rounding
  return c;
}

}  // namespace

Eigen::Matrix2d centre_covariance(const TargetFit& fit) {
  const Lags c = autocovariance(fit);
  const TargetNormal inverse = fit.normal.ldlt().solve(TargetNormal::Identity());
  const Eigen::MatrixXd influence = fit.jacobian * inverse.leftCols<2>();  // of a pixel on the centre
  const Grid by_x(fit.pixels, influence.col(0)), by_y(fit.pixels, influence.col(1));
  Eigen::Matrix2d white = c(kLags, kLags) * influence.transpose() * influence, correlated = Eigen::Matrix2d::Zero();
  for (Eigen::Index i = 0; i < influence.rows(); ++i) {
    const auto& at = fit.pixels.at[i];
    for (int h = -kLags; h <= kLags; ++h)
      for (int k = -kLags; k <= kLags; ++k) {
        const Eigen::RowVector2d other(by_x(at.x() + h, at.y() + k), by_y(at.x() + h, at.y() + k));
        if (!std::isnan(other.x())) correlated += c(h + kLags, k + kLags) * influence.row(i).transpose() * other;
      }
  }
  const Eigen::Matrix2d root = white.llt().matrixL(), inverse_root = root.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> ratio(
      inverse_root * 0.5 * (correlated + correlated.transpose()) * inverse_root.transpose());
  return root * ratio.eigenvectors() * ratio.eigenvalues().cwiseMax(1).asDiagonal() * ratio.eigenvectors().transpose() *
         root.transpose();
}

}  // namespace plumbline::detect
