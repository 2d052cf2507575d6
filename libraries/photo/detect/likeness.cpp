#include "photo/detect/likeness.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace plumbline::detect {
namespace {

constexpr int kSamples = 5;       // along a cell
constexpr double kAround = 0.6;   // cells outside of the square
constexpr double kBlur = 0.85;    // [px]
constexpr double kFewest = 0.75;  // of the samples must lie in the image

/// The drawing with one cell of surroundings: 0 dark, 1 bright.
class Drawing {
 public:
  Drawing(const SquareFamily& family, std::uint64_t code, double blur) : side_(family.modules + 2), blur_(blur) {
    const bool bright = family.bright_inside;
    cells_.assign(static_cast<std::size_t>(side_ * side_), bright ? 0.0 : 1.0);
    for (int row = 0; row < family.modules; ++row)
      for (int column = 0; column < family.modules; ++column) cell(column, row) = bright ? 1.0 : 0.0;
    for (std::size_t i = 0; i < family.cells.size(); ++i) {
      const auto& [column, row] = family.cells[i];
      if (std::min(column, row) < -1 || std::max(column, row) > family.modules) continue;
      cell(column, row) = static_cast<double>(code >> (family.cells.size() - 1 - i) & 1);
    }
  }
  double at(double u, double v) const {
    double sum = 0;
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        sum += (i == 0 ? 0.5 : 0.25) * (j == 0 ? 0.5 : 0.25) * sharp(u + i * blur_, v + j * blur_);
    return sum;
  }

 private:
  double& cell(int column, int row) { return cells_[(row + 1) * side_ + column + 1]; }
  double sharp(double u, double v) const {
    const int column = std::clamp(static_cast<int>(std::floor(u)) + 1, 0, side_ - 1);
    const int row = std::clamp(static_cast<int>(std::floor(v)) + 1, 0, side_ - 1);
    return cells_[row * side_ + column];
  }
  int side_;
  double blur_;
  std::vector<double> cells_;
};

struct Sample {
  double u, v, grey, drawn;
};

double area(const std::array<Eigen::Vector2d, 4>& c) {
  const Eigen::Vector2d p = c[2] - c[0], q = c[3] - c[1];
  return 0.5 * std::abs(p.x() * q.y() - p.y() * q.x());
}

}  // namespace

Likeness likeness(const PixelRows& image, const std::array<Eigen::Vector2d, 4>& corners, const SquareFamily& family,
                  std::size_t index) {
  const int n = family.modules;
  const Eigen::Matrix3d to_image = image_from_cells({corners[3], corners[2], corners[1], corners[0]}, n);
  const double cell = std::sqrt(area(corners)) / n;
  if (!to_image.allFinite() || !(cell > 0)) return {};
  const Drawing drawing(family, family.codes[index], std::min(0.45, kBlur / cell));
  const int count = static_cast<int>(std::lround((n + 2 * kAround) * kSamples));

  std::vector<Sample> samples;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (int j = 0; j < count; ++j)
    for (int i = 0; i < count; ++i) {
      const double u = (i + 0.5) / kSamples - kAround, v = (j + 0.5) / kSamples - kAround;
      const Eigen::Vector3d p = to_image * Eigen::Vector3d(u, v, 1);
      const double x = p.x() / p.z(), y = p.y() / p.z();
      if (!(p.z() > 0) || !image.holds(x, y)) continue;
      samples.push_back({u, v, static_cast<double>(image.at(x, y)), drawing.at(u, v)});
      const Eigen::Vector3d plane(1, u - 0.5 * n, v - 0.5 * n);
      normal += plane * plane.transpose();
      right += plane * Eigen::RowVector2d(samples.back().grey, samples.back().drawn);
    }
  if (static_cast<double>(samples.size()) < kFewest * count * count) return {};
  const Eigen::Matrix<double, 3, 2> planes = normal.ldlt().solve(right);

  double grey = 0, drawn = 0, both = 0;
  for (Sample& s : samples) {
    const Eigen::RowVector3d plane(1, s.u - 0.5 * n, s.v - 0.5 * n);
    s.grey -= plane * planes.col(0), s.drawn -= plane * planes.col(1);
    grey += s.grey * s.grey, drawn += s.drawn * s.drawn, both += s.grey * s.drawn;
  }
  Likeness result;
  result.correlation = both / std::sqrt(grey * drawn + 1e-9);
  const double contrast = both / drawn;
  if (!(contrast > 0)) return result;
  std::vector<double> sum(static_cast<std::size_t>(n * n)), number(sum.size());
  for (const Sample& s : samples) {
    if (s.u < 0 || s.v < 0 || s.u >= n || s.v >= n) continue;
    const auto at = static_cast<std::size_t>(static_cast<int>(s.v) * n + static_cast<int>(s.u));
    sum[at] += std::pow(s.grey / contrast - s.drawn, 2), number[at] += 1;
  }
  result.worst_cell = 0;
  for (std::size_t k = 0; k < sum.size(); ++k)
    if (number[k] > 0) result.worst_cell = std::max(result.worst_cell, sum[k] / number[k]);
  return result;
}

LikenessLimit likeness_limit(double chance) {
  if (chance >= kWeakChance) return {0.85, 0.2};
  if (chance >= 1e-4) return {0.7, 1e300};
  return {};
}

}  // namespace plumbline::detect
