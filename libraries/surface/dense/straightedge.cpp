#include "surface/dense/straightedge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "geometry/median.hpp"

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

void HeightGrid::leave_out_unsure(double times) {
  std::vector<double> weights;
  for (const Cell& cell : cells_)
    if (cell.weight > 0) weights.push_back(cell.weight);
  if (weights.empty()) return;
  const double least = upper_median(weights) / (times * times);
  for (Cell& cell : cells_)
    if (cell.weight < least) cell = Cell();
}

double HeightGrid::coverage() const {
  const auto count = std::count_if(cells_.begin(), cells_.end(), [](const Cell& cell) { return cell.weight > 0; });
  return static_cast<double>(count) / static_cast<double>(cells_.size());
}

/// Cells beneath a straightedge: how far along it, which, and how high.
struct HeightGrid::Under {
  std::vector<double> along, height;
  std::vector<size_t> cell;
  std::vector<size_t> hull;  // kept for its memory
};

struct HeightGrid::Supports {
  double gap = 0;
  size_t left = 0, lowest = 0, right = 0;  ///< numbers beneath the straightedge

  /// Its supports are the upper hull of the heights beneath it, and it rests on the pair of the hull that stands around
  /// its middle; the gap is measured between them.
  void look(Under& under) {
    const std::vector<double>&h = under.height, &at = under.along;
    std::vector<size_t>& hull = under.hull;
    hull.clear();
    for (size_t i = 0; i < h.size(); ++i) {
      while (hull.size() > 1) {
        const size_t a = hull[hull.size() - 2], b = hull.back();
        if ((h[b] - h[a]) * (at[i] - at[a]) > (h[i] - h[a]) * (at[b] - at[a])) break;
        hull.pop_back();
      }
      hull.push_back(i);
    }
    for (size_t s = 0; s + 1 < hull.size(); ++s) {
      const size_t a = hull[s], b = hull[s + 1];
      const double slope = (h[b] - h[a]) / (at[b] - at[a]);
      for (size_t i = a + 1; i < b; ++i) {
        const double depth = h[a] + slope * (at[i] - at[a]) - h[i];
        if (depth > gap) gap = depth, left = a, lowest = i, right = b;
      }
    }
  }
};

/// Cells from one on in a direction; false if there is no straightedge of that length.
bool HeightGrid::lay(int column, int row, int by_column, int by_row, double length, Under& under) const {
  under.along.clear(), under.cell.clear(), under.height.clear();
  const Cell* first = filled(column, row);
  if (!first) return false;
  const Eigen::Vector2d origin = first->place / first->weight;
  for (int c = column, r = row; c >= 0 && c < columns_ && r >= 0 && r < rows_; c += by_column, r += by_row) {
    const Cell* cell = filled(c, r);
    if (!cell) continue;
    const double along = (cell->place / cell->weight - origin).norm();
    if (along > length) break;
    under.along.push_back(along), under.height.push_back(cell->height / cell->weight);
    under.cell.push_back(static_cast<size_t>(cell - cells_.data()));
  }
  // A line that ends before the straightedge does, at the panel's edge or in a hole, says nothing of that length.
  const double step = Eigen::Vector2d(by_column * size_.x() / columns_, by_row * size_.y() / rows_).norm();
  return under.along.size() >= 3 && under.along.back() >= length - 1.5 * step;
}

void HeightGrid::state(const Under& under, const Supports& at, Gap& gap) const {
  const double t = (under.along[at.lowest] - under.along[at.left]) / (under.along[at.right] - under.along[at.left]);
  const Cell &m = cells_[under.cell[at.lowest]], &p = cells_[under.cell[at.left]], &q = cells_[under.cell[at.right]];
  const Eigen::VectorXd common = (1 - t) * p.common / p.weight + t * q.common / q.weight - m.common / m.weight;
  gap.gap = at.gap;
  gap.sigma = std::sqrt(1 / m.weight + (1 - t) * (1 - t) / p.weight + t * t / q.weight + common.squaredNorm());
  gap.noise_sigma = common.norm();
  gap.place = m.place / m.weight;
}

/// Errors of all cells as their sigmas allow them, several times; the same each time that they are asked for.
std::vector<std::vector<float>> HeightGrid::drawn_errors() const {
  const size_t draws = cells_.size() < 100000 ? 32 : 8;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, 1);
  std::vector<std::vector<float>> errors(draws, std::vector<float>(cells_.size()));
  for (auto& draw : errors)
    for (size_t c = 0; c < cells_.size(); ++c)
      if (cells_[c].weight > 0) draw[c] = static_cast<float>(normal(random) / std::sqrt(cells_[c].weight));
  return errors;
}

Gap HeightGrid::largest_gap(double length) const {
  Gap worst;
  worst.length = length;
  const auto errors = drawn_errors();
  std::vector<double> of_noise(errors.size());  // the largest gap of each draw
  Under under;
  constexpr std::array<std::array<int, 2>, 4> directions{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  for (const auto& direction : directions)
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_; ++c) {
        if (!lay(c, r, direction[0], direction[1], length, under)) continue;
        ++worst.positions;
        Supports found{worst.gap};
        found.look(under);
        if (found.gap > worst.gap) state(under, found, worst);
        for (size_t d = 0; d < errors.size(); ++d) {
          for (size_t i = 0; i < under.cell.size(); ++i)
            under.height[i] = static_cast<double>(errors[d][under.cell[i]]);
          Supports noise{of_noise[d]};
          noise.look(under);
          of_noise[d] = noise.gap;
        }
      }
  const double count = static_cast<double>(of_noise.size());
  double squares = 0;
  for (double gap : of_noise) worst.noise_mean += gap / count;
  for (double gap : of_noise) squares += (gap - worst.noise_mean) * (gap - worst.noise_mean) / (count - 1);
  // No gap at all is one that is smaller than what noise makes, and not one that is known to be none.
  if (worst.positions > 0 && !(worst.gap > 0)) worst.sigma = std::hypot(worst.noise_mean, std::sqrt(squares));
  worst.noise_sigma = std::sqrt(squares + worst.noise_sigma * worst.noise_sigma);
  return worst;
}

}  // namespace plumbline::surface
