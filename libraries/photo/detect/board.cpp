#include "photo/detect/board.hpp"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "base/text/one_document.hpp"
#include "base/text/whole_file.hpp"
#include "photo/detect/aruco_detector.hpp"
#include "photo/detect/board_geometry.hpp"
#include "photo/detect/charuco_layout.hpp"
#include "photo/detect/chessboard.hpp"
#include "photo/detect/one_thread.hpp"
#include "photo/detect/tag_grid.hpp"
#include "photo/images/grey_image.hpp"

namespace plumbline::detect {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
  throw std::runtime_error(
      file + ": " + what +
      ". A board file has type (chessboard, charuco or tags), columns, rows, square [m], marker [m], "
      "gap [m], dictionary and first_id; docs/camera_calibration.md has an example of each");
}

YAML::Node value(const YAML::Node& root, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (root[name]) return root[name];
  return YAML::Node(YAML::NodeType::Undefined);
}

double length(const YAML::Node& root, const std::string& file, std::initializer_list<const char*> names,
              double fallback) {
  const YAML::Node node = value(root, names);
  if (!node.IsDefined()) return fallback;
  const double metres = node.as<double>(std::nan(""));
  if (!(metres > 0))
    refuse(file,
           std::string("'") + *names.begin() + "' is '" + node.as<std::string>("") + "', expected a length in metres");
  if (metres > 2)
    refuse(file, std::string("'") + *names.begin() + "' is " + node.as<std::string>("") +
                     " m; lengths are in metres: 0.025 for 25 mm");
  return metres;
}

int whole(const YAML::Node& root, const std::string& file, std::initializer_list<const char*> names, int fallback,
          int least) {
  const YAML::Node node = value(root, names);
  const int number = node.IsDefined() ? node.as<int>(-1) : fallback;
  if (number < least || number > 1000)
    refuse(file, std::string("'") + *names.begin() + "' is " +
                     (node.IsDefined() ? "'" + node.as<std::string>("") + "'" : "missing") +
                     ", expected a whole number of at least " + std::to_string(least));
  return number;
}

BoardKind kind_of(const YAML::Node& root, const std::string& file) {
  const YAML::Node node = value(root, {"type", "target_type", "pattern", "board"});
  if (!node.IsDefined()) refuse(file, "'type' is missing");
  std::string name;
  for (const char c : node.as<std::string>("")) name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name == "chessboard" || name == "checkerboard") return BoardKind::chessboard;
  if (name == "charuco") return BoardKind::charuco;
  if (name == "tags" || name == "aprilgrid" || name == "grid" || name == "aruco" || name == "tag_grid")
    return BoardKind::tags;
  if (name.find("circle") != std::string::npos)
    refuse(file, "'type' is '" + name +
                     "': grids of circles are not measured, because the image of a circle's centre is not the centre "
                     "of its image. Print a chessboard or a ChArUco board");
  refuse(file, "'type' is '" + name + "'");
}

TagDictionary dictionary_of(const YAML::Node& root, const std::string& file, const char* fallback) {
  const YAML::Node node = value(root, {"dictionary", "family", "dict"});
  const std::string name = node.IsDefined() ? node.as<std::string>("") : fallback;
  const size_t slash = file.find_last_of('/');
  const std::string path =
      name.empty() || name[0] == '/' || slash == std::string::npos ? name : file.substr(0, slash + 1) + name;
  std::error_code unreadable;
  if (name.find_first_of("./") != std::string::npos && std::filesystem::exists(path, unreadable))
    return parse_dictionary(text::read_whole(path), path);
  try {
    return builtin_dictionary(name);
  } catch (const std::runtime_error& error) {
    refuse(file, error.what());
  }
}

/// Whether the plane lies before the camera at all of `at`, and `onto` leaves an area of it: three of four corners in a
/// row make a mapping onto a line.
bool maps_an_area(const Eigen::Matrix3d& onto, const TagCorners& at) {
  constexpr double kLeast = 0.05 * 0.05;  // of a square
  if (!onto.allFinite()) return false;
  double twice_area = 0;
  for (size_t k = 0; k < 4; ++k) {
    const auto depth = [&](const Eigen::Vector2d& p) { return onto.row(2).dot(p.homogeneous()); };
    if (!(depth(at[k]) * depth(at[0]) > 0)) return false;
    const Eigen::Vector2d a = mapped(onto, at[k]), b = mapped(onto, at[(k + 1) % 4]);
    twice_area += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice_area) > 2 * kLeast;
}

/// Edge of a marker at `centre` [m] in squares, by the corners of the squares around it: over these a lens is as good
/// as straight. nan where they are fewer than four, or tell no plane.
double marker_in_squares(const TagCorners& marker, const Eigen::Vector2d& centre, const std::vector<SeenPoint>& points,
                         double square) {
  std::vector<cv::Point2f> from, to;
  Eigen::AlignedBox2d box;
  for (const SeenPoint& p : points) {
    const Eigen::Vector2d at = (p.board.head<2>() - centre) / square;
    if (at.norm() > 1.7) continue;
    from.push_back(point(p.pixel)), to.push_back(point(at)), box.extend(at);
  }
  if (from.size() < 4 || box.sizes().minCoeff() < 0.5) return std::nan("");
  const Eigen::Matrix3d onto_board = homography(from, to, 0);
  if (!maps_an_area(onto_board, marker)) return std::nan("");
  TagCorners on_board;
  for (size_t k = 0; k < 4; ++k) on_board[k] = mapped(onto_board, marker[k]);
  return side(on_board);
}

/// Why the markers that were found are too few, or nothing.
std::string too_few_markers(const Board& board, size_t known, size_t expected, size_t found) {
  if (known >= 4) return {};
  return std::to_string(known) + " of the board's " + std::to_string(expected) + " markers were found (" +
         std::to_string(found) + " tags of " + board.dictionary.name +
         " in all), needed are 4; check the dictionary and first_id, or photograph it larger and sharper";
}

/// Corners [px] of the markers around a place on the board, beside theirs on the board [squares].
struct MarkersAround {
  std::vector<cv::Point2f> on_board, in_image;
  bool beside = false;  ///< one of them touches the place
};

MarkersAround markers_around(const Eigen::Vector2d& at, const Board& board,
                             const std::map<int, Eigen::Vector2d>& centres,
                             const std::map<int, const DetectedTag*>& by_id) {
  MarkersAround around;
  for (const auto& [id, centre] : centres) {
    const auto tag = by_id.find(id);
    const double distance = (centre - at).norm() / board.square;
    if (tag == by_id.end() || distance > 2.2) continue;
    around.beside = around.beside || distance < 0.8;
    const double h = 0.5 * board.marker;
    const Eigen::Vector2d offsets[] = {{-h, -h}, {h, -h}, {h, h}, {-h, h}};
    for (size_t k = 0; k < 4; ++k) {
      around.on_board.push_back(point((centre + offsets[k]) / board.square));
      around.in_image.push_back(point(tag->second->corners[k]));
    }
  }
  return around;
}

/// Inner corners as the markers around them have them, and as the image does.
struct InnerCorners {
  std::vector<SeenPoint> by_markers;
  std::vector<cv::Point2f> refined;  ///< [px], of each of them
  double smallest_square = 1e9;      ///< [px]
};

/// Each inner corner from the markers around it: over a few squares a lens is as good as straight.
InnerCorners inner_corners(const cv::Mat& view, const Board& board, const std::map<int, Eigen::Vector2d>& centres,
                           const std::map<int, const DetectedTag*>& by_id) {
  InnerCorners corners;
  const double free = 0.45 * (1 - board.marker / board.square);  // of a square: what holds no part of a marker
  for (int row = 1; row < board.rows; ++row)
    for (int column = 1; column < board.columns; ++column) {
      const Eigen::Vector2d at(column * board.square, -row * board.square);
      const MarkersAround around = markers_around(at, board, centres, by_id);
      if (!around.beside || around.on_board.size() < 8) continue;
      const Eigen::Matrix3d h = homography(around.on_board, around.in_image, 0);
      if (!h.allFinite()) continue;
      const Eigen::Vector2d pixel = mapped(h, at / board.square);
      const double square = std::min((mapped(h, at / board.square + Eigen::Vector2d(1, 0)) - pixel).norm(),
                                     (mapped(h, at / board.square + Eigen::Vector2d(0, 1)) - pixel).norm());
      const double margin = 0.3 * square;
      if (!(pixel.x() > margin && pixel.y() > margin && pixel.x() < view.cols - 1 - margin &&
            pixel.y() < view.rows - 1 - margin))
        continue;
      corners.smallest_square = std::min(corners.smallest_square, square);
      std::vector<cv::Point2f> corner{point(pixel)};
      const int window = std::clamp(static_cast<int>(free * square), 2, 11);
      cv::cornerSubPix(view, corner, {window, window}, {-1, -1},
                       cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 60, 0.001));
      corners.refined.push_back(corner.front());
      corners.by_markers.push_back({(row - 1) * (board.columns - 1) + column - 1, {at.x(), at.y(), 0}, pixel, 0.1});
    }
  return corners;
}

/// Inner corners of which the image says what the markers say.
void take_agreeing(const InnerCorners& corners, SeenBoard& seen) {
  if (corners.by_markers.size() < 6) {
    seen.problem = std::to_string(corners.by_markers.size()) + " inner corners have a marker beside them, needed are 6";
    return;
  }
  for (size_t i = 0; i < corners.by_markers.size(); ++i) {
    const Eigen::Vector2d refined(static_cast<double>(corners.refined[i].x), static_cast<double>(corners.refined[i].y));
    SeenPoint point = corners.by_markers[i];
    if ((refined - point.pixel).norm() > std::max(1.5, 0.15 * corners.smallest_square)) continue;
    point.pixel = refined;
    seen.points.push_back(point);
  }
  if (seen.points.size() >= 6) return;
  seen.problem =
      "only " + std::to_string(seen.points.size()) + " inner corners could be measured; the photograph is blurred";
  seen.points.clear();
}

/// The markers' edges in squares, which the whole of the board must have.
void measure_markers(const Board& board, const std::vector<DetectedTag>& tags,
                     const std::map<int, Eigen::Vector2d>& centres, SeenBoard& seen) {
  double ratio = 0;
  size_t measured = 0;
  for (const auto& tag : tags) {
    const auto at = centres.find(tag.id);
    if (at == centres.end()) continue;
    const double squares = marker_in_squares(tag.corners, at->second, seen.points, board.square);
    if (std::isfinite(squares)) ratio += squares, ++measured;
  }
  if (measured == 0) {
    seen.problem = "its " + std::to_string(seen.points.size()) +
                   " inner corners lie in a row or far apart, so that no marker can be held against the squares around "
                   "it; photograph more of the board at once";
    seen.points.clear();
    return;
  }
  seen.marker_ratio = ratio / static_cast<double>(measured);
  if (seen.marker_ratio > 0.05 && seen.marker_ratio < 1.2) return;
  seen.points.clear();
  seen.marker_ratio = std::nan("");
  seen.problem = "the markers are not where a board of " + std::to_string(board.columns) + " x " +
                 std::to_string(board.rows) +
                 " squares has them; check columns and rows (are they exchanged?) and first_id";
}

SeenBoard find_charuco(const GreyImage& image, const cv::Mat& view, const Board& board) {
  SeenBoard seen;
  ArucoOptions options;
  options.refinement = Refinement::apriltag;
  options.limit = LikenessLimit{};  // the board's geometry tells what does not belong to it
  const auto found = ArucoDetector(board.dictionary, options).detect(image);
  const size_t expected = charuco_markers(board, false).size();
  const SingleTags once = single_tags(found, board.first_id, static_cast<int>(expected) + 1);
  seen.problem = once.problem.empty() ? too_few_markers(board, once.tags.size(), expected, found.size()) : once.problem;
  if (!seen.problem.empty()) return seen;
  auto tags = once.tags;
  const double bound = 0.01 * std::max(image.width, image.height);
  const CharucoLayout best = find_layout(board, tags, image.width, image.height, bound);
  if (best.misfit > bound) {
    seen.problem = "the markers are not where the board file has them: they miss their squares by " +
                   std::to_string(best.misfit) + " px, with a lens as wide as any; check columns, rows and first_id";
    return seen;
  }
  const auto centres = charuco_markers(board, best.legacy);
  turn_alike(tags, centres, best, board);
  std::map<int, const DetectedTag*> by_id;
  for (const auto& tag : tags) by_id[tag.id] = &tag;
  take_agreeing(inner_corners(view, board, centres, by_id), seen);
  if (seen.problem.empty()) measure_markers(board, tags, centres, seen);
  return seen;
}

}  // namespace

std::string Board::words() const {
  const auto mm = [](double metres) { return fmt::format("{:.5g} mm", 1e3 * metres); };
  const std::string size = std::to_string(columns) + " x " + std::to_string(rows);
  if (kind == BoardKind::chessboard) return "chessboard of " + size + " inner corners, squares " + mm(square);
  if (kind == BoardKind::charuco)
    return "ChArUco board of " + size + " squares of " + mm(square) + ", markers " + mm(marker) + ", " +
           dictionary.name;
  return "grid of " + size + " tags of " + mm(marker) + ", gap " + mm(gap) + ", " + dictionary.name;
}

Board parse_board(const std::string& text, const std::string& file) {
  YAML::Node root;
  try {
    root = text::load_one_document(text);
  } catch (const YAML::Exception& error) {
    refuse(file, "neither YAML nor JSON (line " + std::to_string(error.mark.line + 1) + ": " + error.msg + ")");
  }
  if (!root.IsMap()) refuse(file, "holds no keys");
  Board board;
  board.kind = kind_of(root, file);
  board.columns =
      whole(root, file, {"columns", "cols", "squares_x", "squaresX", "targetCols", "tagCols", "width"}, -1, 2);
  board.rows = whole(root, file, {"rows", "squares_y", "squaresY", "targetRows", "tagRows", "height"}, -1, 2);
  board.first_id = whole(root, file, {"first_id", "start_id", "tagStartId"}, 0, 0);
  board.square = length(root, file, {"square", "square_size", "square_length", "squareLength", "colSpacingMeters"}, 0);
  board.square_y = length(root, file, {"square_y", "rowSpacingMeters"}, board.square);
  board.marker =
      length(root, file, {"marker", "marker_size", "marker_length", "markerLength", "tag_size", "tagSize", "size"}, 0);
  board.gap = length(root, file, {"gap", "separation", "marker_separation", "markerSeparation"}, 0);
  if (root["tagSpacing"]) board.gap = root["tagSpacing"].as<double>(0) * board.marker, board.ids_from_bottom = true;
  if (board.kind != BoardKind::tags && !(board.square > 0))
    refuse(file, "'square' is missing: the edge of a square in metres");
  if (board.kind == BoardKind::chessboard) return board;
  if (!(board.marker > 0)) refuse(file, "'marker' is missing: the edge of a marker in metres");
  if (board.kind == BoardKind::charuco && board.marker >= board.square)
    refuse(file, "the markers are not smaller than the squares (" + std::to_string(board.marker) + " m, " +
                     std::to_string(board.square) + " m)");
  if (board.kind == BoardKind::tags && !(board.gap > 0))
    refuse(file, "'gap' is missing: the space between two tags in metres");
  board.dictionary = dictionary_of(root, file, root["target_type"] ? "tag36h11b2" : "");
  const int needed = board.kind == BoardKind::charuco ? board.columns * board.rows / 2 : board.columns * board.rows;
  if (board.first_id + needed > 1 + *std::max_element(board.dictionary.ids.begin(), board.dictionary.ids.end()))
    refuse(file, "the board has " + std::to_string(needed) + " markers from number " + std::to_string(board.first_id) +
                     ", but " + board.dictionary.name + " ends at " +
                     std::to_string(*std::max_element(board.dictionary.ids.begin(), board.dictionary.ids.end())));
  return board;
}

SeenBoard find_board(const GreyImage& image, const Board& board) {
  if (image.width < 32 || image.height < 32) {
    SeenBoard seen;
    seen.problem = "the photograph is too small";
    return seen;
  }
  keep_opencv_to_one_thread();
  if (board.kind == BoardKind::chessboard) {
    return find_chessboard(image, board);
  }
  const auto find = [&](const GreyImage& grey) {
    const cv::Mat pixels(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.pixels.data()));
    return board.kind == BoardKind::charuco ? find_charuco(grey, pixels, board) : find_tags(grey, board);
  };
  const SeenBoard seen = find(image);
  if (!seen.points.empty()) return seen;
  GreyImage negative = image;  // boards are also printed white on black
  for (auto& pixel : negative.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);
  const SeenBoard inverted = find(negative);
  return inverted.points.empty() ? seen : inverted;
}

}  // namespace plumbline::detect
