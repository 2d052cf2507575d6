#include "photo/detect/chess_lattice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "geometry/median.hpp"

namespace plumbline::detect {
namespace {

double grey(const cv::Mat& view, const cv::Point2f& p) {
  const int x = std::clamp(cvRound(p.x), 0, view.cols - 1), y = std::clamp(cvRound(p.y), 0, view.rows - 1);
  return static_cast<double>(view.at<std::uint8_t>(y, x));
}

/// Where a point's two neighbours are, from it: to the next column and to the next row.
struct Axes {
  cv::Point2f right, down;
};

/// How much brighter the darker of the two quadrants before and behind is than the brighter of the other two; negative
/// where they do not meet crosswise that way round.
double crossing(const cv::Mat& view, const cv::Point2f& p, const Axes& axes) {
  std::array<double, 4> quadrant = {};  // right below, left below, left above, right above
  for (const float share : {0.15F, 0.22F, 0.3F}) {
    const cv::Point2f r = share * axes.right, d = share * axes.down;
    quadrant[0] += grey(view, p + r + d) / 3, quadrant[1] += grey(view, p - r + d) / 3;
    quadrant[2] += grey(view, p - r - d) / 3, quadrant[3] += grey(view, p + r - d) / 3;
  }
  return std::min(quadrant[0], quadrant[2]) - std::max(quadrant[1], quadrant[3]);
}

class Lattice {
 public:
  Lattice(const cv::Mat& view, const ChessLattice& lattice) : view_(view), lattice_(lattice) {
    std::vector<double> contrasts;
    for (int row = 0; row < lattice.rows; ++row)
      for (int column = 0; column < lattice.columns; ++column) contrasts.push_back(contrast(row, column));
    usual_ = upper_median(contrasts);
  }
  /// Of a point of the lattice or one outside of its rim; brighter to the right below where row + column is even.
  bool crosses(int row, int column) const {
    const cv::Point2f p = at(row, column);
    if (!(p.x >= 0 && p.y >= 0 && p.x <= static_cast<float>(view_.cols - 1) &&
          p.y <= static_cast<float>(view_.rows - 1)))
      return false;
    const double sign = (row + column) % 2 == 0 ? 1 : -1;
    return contrast_of(p, axes(row, column), sign * usual_) > 0.1 * std::abs(usual_);
  }
  /// Also one beyond the rim, where the lattice goes on as its last step.
  cv::Point2f at(int row, int column) const {
    const auto on = [&](int r, int c) { return lattice_.corners[r * lattice_.columns + c]; };
    const int r = std::clamp(row, 0, lattice_.rows - 1), c = std::clamp(column, 0, lattice_.columns - 1);
    cv::Point2f p = on(r, c);
    if (row != r) p += on(r, c) - on(r + (row < 0 ? 1 : -1), c);
    if (column != c) p += on(r, c) - on(r, c + (column < 0 ? 1 : -1));
    return p;
  }

 private:
  Axes axes(int row, int column) const {
    const int r = std::min(row, lattice_.rows - 1), c = std::min(column, lattice_.columns - 1);
    return {column < lattice_.columns - 1 ? at(row, column + 1) - at(row, column) : at(row, c) - at(row, c - 1),
            row < lattice_.rows - 1 ? at(row + 1, column) - at(row, column) : at(r, column) - at(r - 1, column)};
  }
  /// crossing() with its sign made that of the points where row + column is even.
  double contrast(int row, int column) const {
    const cv::Point2f p = at(row, column);
    const Axes a = axes(row, column);
    const double one = crossing(view_, p, a), other = crossing(view_, p, {-a.right, a.down});
    const double way = one > other ? one : -other;
    return (row + column) % 2 == 0 ? way : -way;
  }
  /// crossing() the way round that `wanted` has.
  double contrast_of(const cv::Point2f& p, const Axes& a, double wanted) const {
    return crossing(view_, p, {wanted > 0 ? a.right : -a.right, a.down});
  }

  const cv::Mat& view_;
  const ChessLattice& lattice_;
  double usual_ = 0;
};

bool row_crosses(const Lattice& lattice, int row, int columns) {
  for (int column = 0; column < columns; ++column)
    if (!lattice.crosses(row, column)) return false;
  return true;
}

bool column_crosses(const Lattice& lattice, int column, int rows) {
  for (int row = 0; row < rows; ++row)
    if (!lattice.crosses(row, column)) return false;
  return true;
}

/// The lattice from `row` and `column` (0 or -1) on.
ChessLattice part(const Lattice& lattice, int row, int column, int rows, int columns) {
  ChessLattice result{{}, columns, rows};
  for (int r = row; r < row + rows; ++r)
    for (int c = column; c < column + columns; ++c) result.corners.push_back(lattice.at(r, c));
  return result;
}

}  // namespace

bool is_chessboard(const cv::Mat& view, const ChessLattice& found) {
  if (found.columns < 2 || found.rows < 2) return false;
  const Lattice lattice(view, found);
  for (int row = 0; row < found.rows; ++row)
    if (!row_crosses(lattice, row, found.columns)) return false;
  return true;
}

bool grow(const cv::Mat& view, ChessLattice& found) {
  constexpr int kMost = 200;  // rows or columns
  bool grown = false;
  for (bool again = true; again && std::max(found.rows, found.columns) < kMost;) {
    const Lattice lattice(view, found);
    const int rows = found.rows, columns = found.columns;
    again = true;
    ChessLattice larger;
    if (row_crosses(lattice, -1, columns))
      larger = part(lattice, -1, 0, rows + 1, columns);
    else if (row_crosses(lattice, rows, columns))
      larger = part(lattice, 0, 0, rows + 1, columns);
    else if (column_crosses(lattice, -1, rows))
      larger = part(lattice, 0, -1, rows, columns + 1);
    else if (column_crosses(lattice, columns, rows))
      larger = part(lattice, 0, 0, rows, columns + 1);
    else
      again = false;
    if (again) found = larger, grown = true;
  }
  return grown;
}

}  // namespace plumbline::detect
