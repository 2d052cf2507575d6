#include "photo/detect/edge_lines.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumbline::detect {

std::optional<std::array<Eigen::Vector2d, 4>> on_edges(const PixelRows& image,
                                                       const std::array<Eigen::Vector2d, 4>& corners, double reach,
                                                       bool bright_inside) {
  struct Line {
    Eigen::Vector2d centre, along;
  };
  std::array<Line, 4> lines;
  for (std::size_t side = 0; side < 4; ++side) {
    const Eigen::Vector2d a = corners[side], b = corners[(side + 1) % 4];
    const Eigen::Vector2d along = (b - a).normalized(), outwards(along.y(), -along.x());
    const double length = (b - a).norm(), step = reach > 4 ? 1.0 : 0.5;
    const int count = std::clamp(static_cast<int>(length / 2), 8, 48);
    const auto apart = static_cast<std::size_t>(2 / step);
    std::vector<float> profile(static_cast<std::size_t>(2 * reach / step) + 1 + apart);
    std::vector<Eigen::Vector2d> points;
    points.reserve(count);
    for (int k = 0; k < count; ++k) {
      const Eigen::Vector2d base = a + (b - a) * (0.1 + 0.8 * (k + 0.5) / count);
      const Eigen::Vector2d tip = outwards * (reach + 1);
      const Eigen::Vector2d outer = base + tip, inner = base - tip;
      if (!image.holds(outer.x(), outer.y()) || !image.holds(inner.x(), inner.y())) continue;
      // Across the edge, a pixel further on both sides than the differences reach that are taken over two pixels.
      for (std::size_t m = 0; m < profile.size(); ++m) {
        const Eigen::Vector2d at = inner + outwards * (step * static_cast<double>(m));
        profile[m] = image.at(at.x(), at.y());
      }
      double weight = 0, moment = 0;
      for (std::size_t m = 0; m + apart < profile.size(); ++m) {
        double rise = static_cast<double>(profile[m + apart] - profile[m]);
        if (bright_inside) rise = -rise;
        if (rise <= 0) continue;
        weight += rise * rise, moment += rise * rise * (step * static_cast<double>(m) - reach);
      }
      if (weight > 0) points.push_back(base + outwards * (moment / weight));
    }
    if (points.size() < 4) return std::nullopt;
    // Twice: without the points that are farther off than the others.
    for (int pass = 0; pass < 2; ++pass) {
      Eigen::Vector2d mean(0, 0);
      for (const auto& p : points) mean += p;
      mean /= static_cast<double>(points.size());
      double xx = 0, xy = 0, yy = 0;
      for (const auto& p : points) {
        const Eigen::Vector2d d = p - mean;
        xx += d.x() * d.x(), xy += d.x() * d.y(), yy += d.y() * d.y();
      }
      const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
      lines[side] = {mean, {std::cos(angle), std::sin(angle)}};
      if (pass > 0) break;
      const double smaller = 0.5 * (xx + yy - std::hypot(xx - yy, 2 * xy)) / static_cast<double>(points.size());
      const double limit = 4 * smaller + 0.01;
      std::vector<Eigen::Vector2d> kept;
      for (const auto& p : points) {
        const Eigen::Vector2d d = p - mean;
        const double off = d.x() * lines[side].along.y() - d.y() * lines[side].along.x();
        if (off * off <= limit) kept.push_back(p);
      }
      if (kept.size() >= 4) points = std::move(kept);
    }
  }
  std::array<Eigen::Vector2d, 4> result;
  for (std::size_t i = 0; i < 4; ++i) {
    const Line &p = lines[(i + 3) % 4], &q = lines[i];
    const double sine = p.along.x() * q.along.y() - p.along.y() * q.along.x();
    if (std::abs(sine) < 0.1) return std::nullopt;
    const Eigen::Vector2d between = q.centre - p.centre;
    result[i] = p.centre + p.along * ((between.x() * q.along.y() - between.y() * q.along.x()) / sine);
    if ((result[i] - corners[i]).norm() > 2.5 * reach + 1) return std::nullopt;
  }
  return result;
}

}  // namespace plumbline::detect
