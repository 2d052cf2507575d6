#include "photo/detect/charuco_layout.hpp"

#include <algorithm>

#include "geometry/median.hpp"
#include "photo/detect/board_geometry.hpp"

namespace plumbline::detect {
namespace {

struct Centres {
  std::vector<cv::Point2f> on_board;  // squares
  std::vector<Eigen::Vector2d> seen;
};

Centres centres_of(const Board& board, const std::vector<DetectedTag>& tags, bool legacy) {
  const auto places = charuco_markers(board, legacy);
  Centres centres;
  for (const DetectedTag& tag : tags)
    if (const auto at = places.find(tag.id); at != places.end()) {
      centres.on_board.push_back(point(at->second / board.square));
      centres.seen.emplace_back(0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]));
    }
  return centres;
}

CharucoLayout fitted(const Centres& centres, bool legacy, const DivisionLens& lens, double bound) {
  CharucoLayout layout;
  if (centres.seen.size() < 4) return layout;
  std::vector<cv::Point2f> straight;
  for (const Eigen::Vector2d& seen : centres.seen) straight.push_back(point(lens.straight(seen)));
  const Eigen::Matrix3d h = homography(centres.on_board, straight, cv::RANSAC);
  if (!h.allFinite()) return layout;
  layout.legacy = legacy, layout.onto_straight = h, layout.lens = lens, layout.score = 0;
  std::vector<double> misfits;
  for (std::size_t i = 0; i < centres.seen.size(); ++i) {
    const cv::Point2f at = centres.on_board[i];
    const double misfit =
        (layout.pixel({static_cast<double>(at.x), static_cast<double>(at.y)}) - centres.seen[i]).norm();
    misfits.push_back(std::isfinite(misfit) ? misfit : 1e9);
    layout.score += std::min(misfits.back(), bound) / static_cast<double>(centres.seen.size());
  }
  layout.misfit = upper_median(std::move(misfits));
  return layout;
}

}  // namespace

Eigen::Vector2d CharucoLayout::pixel(const Eigen::Vector2d& squares) const {
  return lens.distorted(mapped(onto_straight, squares));
}

std::map<int, Eigen::Vector2d> charuco_markers(const Board& board, bool legacy) {
  std::map<int, Eigen::Vector2d> centres;
  int id = board.first_id;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if ((row + column) % 2 == (legacy ? 0 : 1))
        centres[id++] = {(column + 0.5) * board.square, -(row + 0.5) * board.square};
  return centres;
}

CharucoLayout find_layout(const Board& board, const std::vector<DetectedTag>& tags, int width, int height,
                          double bound) {
  DivisionLens lens{{0.5 * (width - 1), 0.5 * (height - 1)}, 0.5 * std::hypot(width, height), 0};
  const Centres present = centres_of(board, tags, false), legacy = centres_of(board, tags, true);
  CharucoLayout best;
  const auto look = [&](double lambda) {
    lens.lambda = lambda;
    for (const bool old : {false, true}) {
      const CharucoLayout layout = fitted(old ? legacy : present, old, lens, bound);
      if (layout.score < best.score) best = layout;
    }
  };
  look(0);
  if (best.misfit <= bound) return best;
  for (const double lambda : {-0.05, -0.1, -0.2, -0.3, -0.4, -0.5, -0.6, -0.7, -0.8, -0.9, 0.05, 0.1, 0.2})
    look(lambda);
  for (double step = 0.05; step > 0.01; step /= 2) {
    const double middle = best.lens.lambda;
    look(middle - step), look(middle + step);
  }
  return best;
}

void turn_alike(std::vector<DetectedTag>& tags, const std::map<int, Eigen::Vector2d>& centres,
                const CharucoLayout& layout, const Board& board) {
  const double h = 0.5 * board.marker;
  const Eigen::Vector2d offsets[] = {{-h, -h}, {h, -h}, {h, h}, {-h, h}};
  std::vector<TagCorners> expected, seen;
  for (const auto& tag : tags) {
    const auto at = centres.find(tag.id);
    if (at == centres.end()) continue;
    TagCorners& corners = expected.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) corners[k] = layout.pixel((at->second + offsets[k]) / board.square);
    seen.push_back(tag.corners);
  }
  const int quarter = turn_of(expected, seen).quarter;
  for (auto& tag : tags) std::rotate(tag.corners.begin(), tag.corners.begin() + (4 - quarter) % 4, tag.corners.end());
}

}  // namespace plumbline::detect
