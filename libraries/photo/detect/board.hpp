// Calibration boards: what they look like, and their points in a photograph.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "photo/detect/tag_dictionary.hpp"

namespace plumbline {
struct GreyImage;
}

namespace plumbline::detect {

enum class BoardKind { chessboard, charuco, tags };

/// A board as its file describes it. Board frame: origin at the top left corner of the printed pattern's first square
/// (ChArUco), first inner corner (chessboard) or first tag; x to the right, y up, z out of the board.
struct Board {
  BoardKind kind = BoardKind::chessboard;
  int columns = 0, rows = 0;  ///< squares of a ChArUco board, inner corners of a chessboard, tags of a grid
  double square = 0;          ///< edge of a square [m]; of a chessboard in x
  double square_y = 0;        ///< edge in y [m]
  double marker = 0;          ///< edge of a marker or tag [m]
  double gap = 0;             ///< between the tags of a grid [m]
  int first_id = 0;
  bool ids_from_bottom = false;  ///< Kalibr's grids count from the bottom left
  TagDictionary dictionary;
  std::string words() const;
};

/// Reads a board file (YAML or JSON): type, columns, rows, square, marker, gap, dictionary, first_id, or Kalibr's
/// target file. Throws std::runtime_error that names file, key and mend.
Board parse_board(const std::string& text, const std::string& file);

struct SeenPoint {
  int id = 0;
  Eigen::Vector3d board;
  Eigen::Vector2d pixel;
  double sigma = 0;  ///< [px]
};

struct SeenBoard {
  std::vector<SeenPoint> points;  ///< by id; empty if the board was not found
  /// Of points that are corners of tags by their edges: see DetectedTag::inset_sigma, the mean over the tags [px]; nan
  /// of points where black and white fields meet.
  double inset_sigma = std::nan("");
  std::string problem;       ///< why it was not found
  bool contradicts = false;  ///< the board is there, but otherwise than the file says
  double marker_pixels = 0;  ///< edge of the tags of a grid in the photograph, their mean [px]
  double marker_ratio =
      std::nan("");  ///< edge of the markers over that of the squares, of tags over their spacing, in the photograph
};

SeenBoard find_board(const GreyImage& image, const Board& board);

}  // namespace plumbline::detect
