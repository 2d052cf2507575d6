#include "surface/edge_profile.hpp"

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
    const double slope = (rising ? 1 : -1) * (2 * samples[s + 2] + samples[s + 1] - samples[s - 1] - 2 * samples[s - 2]);
    if (slope > best) best = slope, place = i;
  }
  return place;
}

std::optional<Edge> fit_edge(const std::vector<double>& samples, double start, double window) {
  const int first = std::max(0, static_cast<int>(std::ceil(start - window)));
  const int last = std::min(static_cast<int>(samples.size()) - 1, static_cast<int>(std::floor(start + window)));
  const int count = last - first + 1;
  if (count < 7) return std::nullopt;
  const auto at = [&](int i) { return samples[static_cast<size_t>(i)]; };
  Eigen::Vector4d x(0.5 * (at(first) + at(first + 1)), 0, start, 2.0);  // level, rise, place, blur
  x(1) = 0.5 * (at(last) + at(last - 1)) - x(0);
  Eigen::Matrix4d normal;
  double squares = 0;
  for (int step = 0; step < 30; ++step) {
    normal.setZero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    squares = 0;
    for (int i = first; i <= last; ++i) {
      const double t = (i - x(2)) / x(3);
      const double step_value = 0.5 * std::erfc(-t / std::sqrt(2.0)), density = std::exp(-0.5 * t * t) / std::sqrt(2 * M_PI);
      const Eigen::Vector4d row(1, step_value, -x(1) * density / x(3), -x(1) * density * t / x(3));
      const double residual = at(i) - x(0) - x(1) * step_value;
      normal += row * row.transpose();
      right += row * residual;
      squares += residual * residual;
    }
    Eigen::Matrix4d damped = normal;
    damped.diagonal() *= 1 + 1e-6;
    Eigen::Vector4d change = damped.ldlt().solve(right);
    if (!change.allFinite()) return std::nullopt;
    change(2) = std::clamp(change(2), -2.0, 2.0);
    x += change;
    x(3) = std::clamp(x(3), 0.6, 0.5 * window);
    if (std::abs(x(2) - start) > 0.7 * window) return std::nullopt;
    if (step > 2 && std::abs(change(2)) < 1e-4) break;
  }
  const double variance = squares / std::max(count - 4, 1);
  const Eigen::Matrix4d inverse = normal.ldlt().solve(Eigen::Matrix4d::Identity());
  if (!(std::abs(x(1)) > 4 * std::sqrt(variance)) || !(inverse(2, 2) > 0)) return std::nullopt;
  return Edge{x(2), std::sqrt(variance * inverse(2, 2)), x(1)};
}

}  // namespace plumbline::surface
