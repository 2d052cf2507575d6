#include "photo/detect/chessboard.hpp"

#include <algorithm>
#include <array>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "photo/detect/chess_lattice.hpp"
#include "photo/images/grey_image.hpp"
#include "plumbline/stop.hpp"

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
  stop_point();
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

std::string inner_corners(int columns, int rows) {
  return std::to_string(columns) + " x " + std::to_string(rows) + " inner corners";
}

/// Of the smaller boards and the larger ones that the board file may mean, the one in the photograph.
std::optional<ChessLattice> another_board(const cv::Mat& view, const Board& board) {
  constexpr std::array<std::array<int, 2>, 6> others = {{{-1, -1}, {1, 1}, {-1, 0}, {0, -1}, {1, 0}, {0, 1}}};
  for (const auto& [more_columns, more_rows] : others) {
    ChessLattice found{{}, board.columns + more_columns, board.rows + more_rows};
    if (std::min(found.columns, found.rows) < 3) continue;
    if (!search(view, {found.columns, found.rows}, 640, found.corners) || !is_chessboard(view, found)) continue;
    grow(view, found);  // to what the board file says, perhaps
    return found;
  }
  return std::nullopt;
}

SeenBoard other_board(const Board& board, const ChessLattice& found) {
  SeenBoard seen;
  const bool squares = found.columns == board.columns - 1 && found.rows == board.rows - 1;
  seen.contradicts = true;
  // One photograph does not tell a small board from a large one of which a part is covered or beyond its rim.
  const bool is_part = !squares && found.columns <= board.columns && found.rows <= board.rows;
  seen.problem = std::string("the chessboard ") + (is_part ? "shows " : "has ") +
                 inner_corners(found.columns, found.rows) + ", not " + std::to_string(board.columns) + " x " +
                 std::to_string(board.rows) + " as the board file says" +
                 (squares   ? ": columns and rows there are to count inner corners, not squares"
                  : is_part ? ": a part of it is covered or beyond the rim, or, if all photographs say so, the file is "
                              "wrong"
                            : "");
  return seen;
}

}  // namespace

SeenBoard find_chessboard(const GreyImage& image, const Board& board) {
  const cv::Mat view(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()));
  const cv::Size size(board.columns, board.rows);
  ChessLattice found{{}, board.columns, board.rows};
  Corners& corners = found.corners;
  if (!(search(view, size, 1000, corners) && is_chessboard(view, found)) &&
      !(cv::findChessboardCornersSB(view, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE) &&
        is_chessboard(view, found))) {
    const auto another = another_board(view, board);
    if (!another) {
      SeenBoard seen;
      seen.problem = "no chessboard of " + inner_corners(board.columns, board.rows) +
                     " was found; the whole board has to be in the photograph, sharp, and columns and rows in the "
                     "board file count inner corners";
      return seen;
    }
    found = *another;
  }
  if (ChessLattice whole = found; grow(view, whole) || whole.columns != board.columns || whole.rows != board.rows)
    return other_board(board, whole);
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
