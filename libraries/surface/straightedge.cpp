#include "surface/straightedge.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plumbline::surface {

HeightGrid::HeightGrid(int columns, int rows, const Eigen::Vector2d& size)
    : columns_(columns), rows_(rows), size_(size), cells_(static_cast<size_t>(columns) * rows) {}

void HeightGrid::add(const Eigen::Vector2d& place, double height, double sigma, const Eigen::VectorXd& common) {
  const int column = static_cast<int>(std::floor((place.x() / size_.x() + 0.5) * columns_));
  const int row = static_cast<int>(std::floor((place.y() / size_.y() + 0.5) * rows_));
  if (column < 0 || column >= columns_ || row < 0 || row >= rows_) return;
  Cell& cell = cells_[static_cast<size_t>(row) * columns_ + column];
  const double weight = 1 / (sigma * sigma);
  if (cell.weight == 0) cell.common = Eigen::VectorXd::Zero(common.size());
  cell.weight += weight, cell.height += weight * height, cell.place += weight * place;
  cell.common += weight * common;
}

const HeightGrid::Cell* HeightGrid::filled(int column, int row) const {
  if (column < 0 || column >= columns_ || row < 0 || row >= rows_) return nullptr;
  const Cell& cell = cells_[static_cast<size_t>(row) * columns_ + column];
  return cell.weight > 0 ? &cell : nullptr;
}

double HeightGrid::coverage() const {
  const auto count = std::count_if(cells_.begin(), cells_.end(), [](const Cell& cell) { return cell.weight > 0; });
  return static_cast<double>(count) / static_cast<double>(cells_.size());
}

/// The straightedge from a cell on: its supports are the upper hull of the heights beneath it, and it rests on the pair of
/// the hull that stands around its middle; the gap is measured between them.
void HeightGrid::look_along(int column, int row, int by_column, int by_row, double length, Gap& worst) const {
  struct At {
    double along, height;
    const Cell* cell;
  };
  std::vector<At> under;
  const Cell* first = filled(column, row);
  if (!first) return;
  const Eigen::Vector2d origin = first->place / first->weight;
  for (int k = 0;; ++k) {
    const int c = column + k * by_column, r = row + k * by_row;
    if (c < 0 || c >= columns_ || r < 0 || r >= rows_) break;
    const Cell* cell = filled(c, r);
    if (!cell) continue;
    const double along = (cell->place / cell->weight - origin).norm();
    if (along > length) break;
    under.push_back({along, cell->height / cell->weight, cell});
  }
  // A line that ends before the straightedge does, at the panel's edge or in a hole, says nothing of that length.
  const double step = Eigen::Vector2d(by_column * size_.x() / columns_, by_row * size_.y() / rows_).norm();
  if (under.size() < 3 || under.back().along < length - 1.5 * step) return;
  ++worst.positions;
  std::vector<size_t> hull;
  for (size_t i = 0; i < under.size(); ++i) {
    while (hull.size() > 1) {
      const At &a = under[hull[hull.size() - 2]], &b = under[hull.back()];
      if ((b.height - a.height) * (under[i].along - a.along) > (under[i].height - a.height) * (b.along - a.along)) break;
      hull.pop_back();
    }
    hull.push_back(i);
  }
  for (size_t s = 0; s + 1 < hull.size(); ++s) {
    const At &a = under[hull[s]], &b = under[hull[s + 1]];
    for (size_t i = hull[s] + 1; i < hull[s + 1]; ++i) {
      const double t = (under[i].along - a.along) / (b.along - a.along);
      const double gap = (1 - t) * a.height + t * b.height - under[i].height;
      if (gap <= worst.gap) continue;
      const Cell &m = *under[i].cell, &p = *a.cell, &q = *b.cell;
      const Eigen::VectorXd common = (1 - t) * p.common / p.weight + t * q.common / q.weight - m.common / m.weight;
      worst.gap = gap;
      worst.sigma = std::sqrt(1 / m.weight + (1 - t) * (1 - t) / p.weight + t * t / q.weight + common.squaredNorm());
      worst.place = m.place / m.weight;
    }
  }
}

Gap HeightGrid::largest_gap(double length) const {
  Gap worst;
  worst.length = length;
  constexpr std::array<std::array<int, 2>, 4> directions{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  for (const auto& direction : directions)
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_; ++c) look_along(c, r, direction[0], direction[1], length, worst);
  return worst;
}

}  // namespace plumbline::surface
