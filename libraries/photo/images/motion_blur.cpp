#include "photo/images/motion_blur.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace plumbline {
namespace {

constexpr int kCell = 8, kDirections = 4;
constexpr std::size_t kFewest = 20;  // edges of a direction

/// Mean grey values of squares of kCell.
struct Cells {
  int columns = 0, rows = 0;
  std::vector<double> mean;
  double at(int column, int row) const { return mean[static_cast<std::size_t>(row) * columns + column]; }
};

int grey(const GreyImage& image, int x, int y) { return image.pixels[static_cast<std::size_t>(y) * image.width + x]; }

Cells cells_of(const GreyImage& image) {
  Cells cells{image.width / kCell, image.height / kCell, {}};
  for (int row = 0; row < cells.rows; ++row)
    for (int column = 0; column < cells.columns; ++column) {
      int sum = 0;
      for (int y = row * kCell; y < (row + 1) * kCell; ++y)
        for (int x = column * kCell; x < (column + 1) * kCell; ++x) sum += grey(image, x, y);
      cells.mean.push_back(static_cast<double>(sum) / (kCell * kCell));
    }
  return cells;
}

/// Width of the edge in the cell and its neighbours, across the unit vector (nx, ny).
double width_at(const GreyImage& image, int column, int row, double nx, double ny) {
  int darkest = 255, brightest = 0;
  double slope = 0;
  for (int y = (row - 1) * kCell; y < (row + 2) * kCell; ++y)
    for (int x = (column - 1) * kCell; x < (column + 2) * kCell; ++x) {
      const int value = grey(image, x, y);
      darkest = std::min(darkest, value), brightest = std::max(brightest, value);
      slope = std::max(slope, std::abs(nx * (grey(image, x + 1, y) - grey(image, x - 1, y)) +
                                       ny * (grey(image, x, y + 1) - grey(image, x, y - 1))));
    }
  return (brightest - darkest) / (std::max(0.5 * slope, 1e-3) * std::sqrt(2 * std::numbers::pi));
}

std::string name_of(double direction) {
  const std::array<const char*, kDirections> names = {"from left to right", "from the top left to the bottom right",
                                                      "up and down", "from the bottom left to the top right"};
  return names[static_cast<std::size_t>(std::lround(direction * kDirections / std::numbers::pi)) % kDirections];
}

}  // namespace

MotionBlur motion_blur(const GreyImage& image) {
  const Cells cells = cells_of(image);
  const auto [darkest, brightest] = std::minmax_element(cells.mean.begin(), cells.mean.end());
  if (cells.columns < 5 || cells.rows < 5) return {};
  const double least_step = 0.25 * (*brightest - *darkest);
  std::array<std::vector<double>, kDirections> widths;
  for (int row = 2; row + 2 < cells.rows; ++row)
    for (int column = 2; column + 2 < cells.columns; ++column) {
      const double dx = cells.at(column + 1, row) - cells.at(column - 1, row),
                   dy = cells.at(column, row + 1) - cells.at(column, row - 1), step = std::hypot(dx, dy);
      if (!(step > least_step) || !(step > 0)) continue;
      const double turns = std::atan2(dy, dx) / std::numbers::pi * kDirections;
      const auto direction = static_cast<std::size_t>((std::lround(turns) + kDirections) % kDirections);
      widths[direction].push_back(width_at(image, column, row, dx / step, dy / step));
    }
  MotionBlur blur;
  int directions = 0;
  for (std::size_t k = 0; k < kDirections; ++k) {
    std::vector<double>& all = widths[k];
    if (all.size() < kFewest) continue;
    const auto tenth = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 10);
    std::nth_element(all.begin(), tenth, all.end());
    if (directions == 0 || *tenth < blur.least) blur.least = *tenth;
    if (directions == 0 || *tenth > blur.most)
      blur.most = *tenth, blur.direction = static_cast<double>(k) * std::numbers::pi / kDirections;
    ++directions;
  }
  return directions < 2 ? MotionBlur{} : blur;
}

std::string in_words(const MotionBlur& blur) {
  if (!blur.found()) return "";
  return fmt::format(
      "it is blurred {}, {:.1f} times as much as in the sharpest direction: the camera or what it looks "
      "at moved while it was taken",
      name_of(blur.direction), blur.most / blur.least);
}

}  // namespace plumbline
