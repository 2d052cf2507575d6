#include "detect/chessboard.hpp"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "geometry/median.hpp"
#include "images/grey_image.hpp"

namespace plumbline::detect {
namespace {

using Corners = std::vector<cv::Point2f>;

void refine(const cv::Mat& view, Corners& points, double spacing) {
  const int window = std::clamp(static_cast<int>(0.25 * spacing), 2, 11);
  cv::cornerSubPix(view, points, {window, window}, {-1, -1},
                   cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 60, 0.001));
}

/// Smallest distance of neighbours in a row.
double spacing_of(const Corners& corners, int columns) {
  double spacing = 1e9;
  for (size_t i = 1; i < corners.size(); ++i)
    if (i % static_cast<size_t>(columns)) spacing = std::min(spacing, cv::norm(corners[i] - corners[i - 1]));
  return spacing;
}

/// Where a large photograph shows no such board this search takes minutes, so it looks at a reduced one of no more than
/// `longest` pixels.
bool search(const cv::Mat& view, cv::Size size, int longest, Corners& corners) {
  const int factor = (std::max(view.cols, view.rows) + longest - 1) / longest;
  cv::Mat reduced = view;
  if (factor > 1) cv::resize(view, reduced, {view.cols / factor, view.rows / factor}, 0, 0, cv::INTER_AREA);
  if (!cv::findChessboardCorners(reduced, size, corners, cv::CALIB_CB_ADAPTIVE_THRESH + cv::CALIB_CB_NORMALIZE_IMAGE))
    return false;
  const auto scale_x = static_cast<float>(view.cols) / static_cast<float>(reduced.cols),
             scale_y = static_cast<float>(view.rows) / static_cast<float>(reduced.rows);
  for (auto& c : corners) c = {(c.x + 0.5F) * scale_x - 0.5F, (c.y + 0.5F) * scale_y - 0.5F};
  return true;
}

/// Grey value in the middle of the square right below corner i: mean of its centre and of points halfway to its
/// corners.
double grey_of_square(const cv::Mat& view, const Corners& corners, size_t i, size_t columns) {
  const cv::Point2f around[] = {corners[i], corners[i + 1], corners[i + columns], corners[i + columns + 1]};
  const cv::Point2f centre = 0.25F * (around[0] + around[1] + around[2] + around[3]);
  const auto grey = [&](const cv::Point2f& p) {
    const int x = std::clamp(cvRound(p.x), 0, view.cols - 1), y = std::clamp(cvRound(p.y), 0, view.rows - 1);
    return static_cast<double>(view.at<std::uint8_t>(y, x));
  };
  double sum = grey(centre);
  for (const auto& corner : around) sum += grey(0.5F * (centre + corner));
  return sum / 5;
}

/// Whether neighbouring squares between the corners change from dark to bright and back everywhere. Where another board
/// than the one that is looked for is in the photograph, the second search finds corners that are none.
bool alternates(const cv::Mat& view, const Corners& corners, int columns, int rows) {
  const auto width = static_cast<size_t>(columns - 1), height = static_cast<size_t>(rows - 1);
  std::vector<double> grey, steps;
  for (size_t row = 0; row < height; ++row)
    for (size_t column = 0; column < width; ++column)
      grey.push_back(grey_of_square(view, corners, row * (width + 1) + column, width + 1));
  for (size_t row = 0; row < height; ++row)
    for (size_t column = 0; column < width; ++column) {
      const double sign = (row + column) % 2 ? -1 : 1, here = grey[row * width + column];
      if (column + 1 < width) steps.push_back(sign * (here - grey[row * width + column + 1]));
      if (row + 1 < height) steps.push_back(sign * (here - grey[(row + 1) * width + column]));
    }
  if (steps.empty()) return true;
  const double usual = upper_median(steps);
  return std::all_of(steps.begin(), steps.end(), [&](double step) { return step * usual > 0.1 * usual * usual; });
}

std::string inner_corners(int columns, int rows) {
  return std::to_string(columns) + " x " + std::to_string(rows) + " inner corners";
}

SeenBoard not_found(const cv::Mat& view, const Board& board) {
  SeenBoard seen;
  seen.problem = "no chessboard of " + inner_corners(board.columns, board.rows) + " was found";
  Corners corners;
  if (board.columns > 3 && board.rows > 3 && search(view, {board.columns - 1, board.rows - 1}, 640, corners)) {
    seen.contradicts = true;
    seen.problem += ", but one of at least " + inner_corners(board.columns - 1, board.rows - 1) +
                    ": columns and rows in the board file are to count inner corners, not squares";
  } else {
    seen.problem +=
        "; the whole board has to be in the photograph, sharp, and columns and rows in the board file count inner "
        "corners";
  }
  return seen;
}

}  // namespace

SeenBoard find_chessboard(const GreyImage& image, const Board& board) {
  const cv::Mat view(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()));
  const cv::Size size(board.columns, board.rows);
  Corners corners;
  const auto is_board = [&] { return alternates(view, corners, board.columns, board.rows); };
  if (!(search(view, size, 1000, corners) && is_board()) &&
      !(cv::findChessboardCornersSB(view, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE) &&
        is_board()))
    return not_found(view, board);
  refine(view, corners, spacing_of(corners, board.columns));
  SeenBoard seen;
  for (size_t i = 0; i < corners.size(); ++i)
    seen.points.push_back({static_cast<int>(i),
                           {static_cast<double>(i % static_cast<size_t>(board.columns)) * board.square,
                            -static_cast<double>(i / static_cast<size_t>(board.columns)) * board.square_y, 0},
                           {static_cast<double>(corners[i].x), static_cast<double>(corners[i].y)},
                           0.1});
  return seen;
}

}  // namespace plumbline::detect
