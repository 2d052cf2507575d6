#include "surface/dense/edge_profile.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace plumbline::surface {

double steepest(const std::vector<double>& samples, double middle, double reach, bool rising) {
  const int first = std::max(2, static_cast<int>(std::ceil(middle - reach)));
  const int last = std::min(static_cast<int>(samples.size()) - 3, static_cast<int>(std::floor(middle + reach)));
  double best = 0, place = -1;
  for (int i = first; i <= last; ++i) {
    const size_t s = static_cast<size_t>(i);
    const double slope =
        (rising ? 1 : -1) * (2 * samples[s + 2] + samples[s + 1] - samples[s - 1] - 2 * samples[s - 2]);
    if (slope > best) best = slope, place = i;
  }
  return place;
}

std::optional<GapEdges> fit_gap(const std::vector<double>& samples, double first, double second, double window,
                                bool dark) {
  const int from = std::max(0, static_cast<int>(std::ceil(first - window)));
  const int to = std::min(static_cast<int>(samples.size()) - 1, static_cast<int>(std::floor(second + window)));
  const int count = to - from + 1;
  if (count < 12 || !(second > first)) return std::nullopt;
  const auto at = [&](int i) { return samples[i]; };
  using Unknowns = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  // Levels of the left, the middle and the right, both places, blur.
  const int middle = static_cast<int>(std::lround(0.5 * (first + second)));
  Unknowns x;
  x << 0.5 * (at(from) + at(from + 1)), at(middle), 0.5 * (at(to) + at(to - 1)), first, second, 2.0;
  Matrix6 normal;
  double squares = 0;
  const auto phi = [](double t) { return 0.5 * std::erfc(-t / std::sqrt(2.0)); };
  const auto density = [](double t) { return std::exp(-0.5 * t * t) / std::sqrt(2 * M_PI); };
  for (int step = 0; step < 40; ++step) {
    normal.setZero();
    Unknowns right = Unknowns::Zero();
    squares = 0;
    for (int i = from; i <= to; ++i) {
      const double s = (i - x(3)) / x(5), t = (i - x(4)) / x(5);
      const double a = phi(s), b = phi(t), da = density(s), db = density(t);
      Unknowns row;
      row << 1 - a, a - b, b, -(x(1) - x(0)) * da / x(5), -(x(2) - x(1)) * db / x(5),
          -((x(1) - x(0)) * da * s + (x(2) - x(1)) * db * t) / x(5);
      const double residual = at(i) - x(0) * (1 - a) - x(1) * (a - b) - x(2) * b;
      normal += row * row.transpose();
      right += row * residual;
      squares += residual * residual;
    }
    Matrix6 damped = normal;
    damped.diagonal() *= 1 + 1e-6;
    Unknowns change = damped.ldlt().solve(right);
    if (!change.allFinite()) return std::nullopt;
    change.segment<2>(3) = change.segment<2>(3).cwiseMax(-1.5).cwiseMin(1.5);
    x += change;
    x(5) = std::clamp(x(5), 0.6, 0.5 * window);
    if (std::abs(x(3) - first) > 0.7 * window || std::abs(x(4) - second) > 0.7 * window || x(4) < x(3))
      return std::nullopt;
    if (step > 2 && change.segment<2>(3).cwiseAbs().maxCoeff() < 1e-4) break;
  }
  const double variance = squares / std::max(count - 6, 1), noise = 4 * std::sqrt(variance);
  const double falls = x(0) - x(1), rises = x(2) - x(1);
  if (dark ? !(falls > noise && rises > noise) : !(falls < -noise && rises < -noise)) return std::nullopt;
  const Matrix6 inverse = normal.ldlt().solve(Matrix6::Identity());
  if (!(inverse(3, 3) > 0 && inverse(4, 4) > 0)) return std::nullopt;
  return GapEdges{{x(3), x(4)}, {std::sqrt(variance * inverse(3, 3)), std::sqrt(variance * inverse(4, 4))}};
}

}  // namespace plumbline::surface
