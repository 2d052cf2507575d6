#include "detect/tag_grid.hpp"

#include <map>

#include "detect/aruco_detector.hpp"
#include "detect/board_geometry.hpp"
#include "geometry/median.hpp"
#include "images/grey_image.hpp"

namespace plumbline::detect {
namespace {

/// Place of a grid's tag number k, in units of the spacing, y up.
Eigen::Vector2d cell_of(int k, const Board& board) {
  const int row = k / board.columns;
  return {static_cast<double>(k % board.columns),
          static_cast<double>(board.ids_from_bottom ? row + 1 - board.rows : -row)};
}

constexpr double kMisplaced = 0.25;  // of the spacing: no lens and no bent paper moves tags that far

/// Median distance of the mapped points from where they should be.
double misfit(const Eigen::Matrix3d& h, const std::vector<cv::Point2f>& from, const std::vector<cv::Point2f>& to) {
  std::vector<double> distances;
  for (size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector2d at = mapped(h, {static_cast<double>(from[i].x), static_cast<double>(from[i].y)});
    distances.push_back(std::hypot(at.x() - static_cast<double>(to[i].x), at.y() - static_cast<double>(to[i].y)));
  }
  return upper_median(std::move(distances));
}

/// Tags that do not lie as the board file has them: in rows of how many they do lie.
std::string misplaced(const std::vector<int>& ids, const std::vector<cv::Point2f>& centres, const Board& board) {
  int columns = 0;
  double best = 0.5 * kMisplaced;
  Board other = board;
  for (other.columns = 2; other.columns <= ids.back(); ++other.columns) {
    std::vector<cv::Point2f> cells;
    for (const int k : ids) cells.push_back(point(cell_of(k, other)));
    const Eigen::Matrix3d h = homography(centres, cells, 0);
    const double off = h.allFinite() ? misfit(h, centres, cells) : best;
    if (off < best) best = off, columns = other.columns;
  }
  const std::string begin =
      "the tags do not lie in rows of " + std::to_string(board.columns) + " as the board file has them";
  if (columns == 0) return begin + ": check columns, rows and first_id there, and whether single tags were replaced";
  return begin + ", but in rows of " + std::to_string(columns) + ": 'columns' there is wrong";
}

/// Tags of the board, also with a border of the other width: which one a grid has is in none of the files that programs
/// write.
std::vector<DetectedTag> tags_of(const GreyImage& image, TagDictionary dictionary) {
  std::vector<DetectedTag> tags = ArucoDetector(dictionary, {}).detect(image);
  if (!tags.empty() || dictionary.size > 8) return tags;
  std::string& name = dictionary.name;
  name = dictionary.border > 1 ? name.substr(0, name.size() - 2) : name + "b2";
  dictionary.border = 3 - dictionary.border;
  return ArucoDetector(dictionary, {}).detect(image);
}

}  // namespace

SingleTags single_tags(std::vector<DetectedTag> found, int first_id, int count) {
  std::map<int, std::vector<DetectedTag>> by_id;
  for (auto& tag : found)
    if (tag.id >= first_id && tag.id < first_id + count) by_id[tag.id].push_back(std::move(tag));
  SingleTags result;
  size_t doubles = 0;
  for (auto& [id, tags] : by_id)
    if (tags.size() == 1)
      result.tags.push_back(std::move(tags.front()));
    else
      result.twice += (doubles++ > 0 ? ", " : "") + std::to_string(id);
  if (doubles >= 3 && 3 * doubles >= result.tags.size())
    result.problem = std::to_string(doubles) + " of the board's tags are there twice (" + result.twice +
                     "): two boards, or two pictures side by side as stereo cameras write them. Cut these into a "
                     "file for each camera (0001/left.png, 0001/right.png)";
  return result;
}

SeenBoard find_tags(const GreyImage& image, const Board& board) {
  SeenBoard seen;
  const double pitch = board.marker + board.gap, h = 0.5 * board.marker;
  const SingleTags once = single_tags(tags_of(image, board.dictionary), board.first_id, board.columns * board.rows);
  if (!once.problem.empty()) {
    seen.problem = once.problem;
    return seen;
  }
  std::vector<cv::Point2f> from, to;  // centres, in units of the pitch
  std::vector<int> ids;
  for (const DetectedTag& tag : once.tags) {
    const int k = tag.id - board.first_id;
    const Eigen::Vector2d cell = cell_of(k, board);
    const Eigen::Vector3d centre(pitch * cell.x(), pitch * cell.y(), 0);
    const Eigen::Vector3d offsets[] = {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
    for (int c = 0; c < 4; ++c) {
      const size_t i = static_cast<size_t>(c);
      seen.points.push_back(
          {4 * k + c, centre + offsets[i], tag.corners[i], std::sqrt(0.5 * tag.covariances[i].trace() + 0.1 * 0.1)});
    }
    ids.push_back(k), to.push_back(point(cell));
    from.push_back(point(Eigen::Vector2d(0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]))));
  }
  if (once.tags.size() < 2) {
    seen.points.clear();
    seen.problem = std::to_string(once.tags.size()) + " of the board's " + std::to_string(board.columns * board.rows) +
                   " tags were found" +
                   (once.twice.empty() ? "" : " (without " + once.twice + ", found more than once)") +
                   "; check dictionary and first_id";
    return seen;
  }
  if (once.tags.size() < 6) return seen;
  const Eigen::Matrix3d onto_board = homography(from, to, 0);
  if (!onto_board.allFinite()) return seen;
  if (misfit(onto_board, from, to) > kMisplaced) {
    seen.points.clear();
    seen.problem = misplaced(ids, from, board), seen.contradicts = true;
    return seen;
  }
  double ratio = 0, pixels = 0;
  for (const DetectedTag& tag : once.tags) {
    std::array<Eigen::Vector2d, 4> corners;
    for (size_t k = 0; k < 4; ++k) corners[k] = mapped(onto_board, tag.corners[k]);
    ratio += side(corners) / static_cast<double>(once.tags.size());
    pixels += side(tag.corners) / static_cast<double>(once.tags.size());
  }
  if (std::isfinite(ratio)) seen.marker_ratio = ratio, seen.marker_pixels = pixels;
  return seen;
}

}  // namespace plumbline::detect
