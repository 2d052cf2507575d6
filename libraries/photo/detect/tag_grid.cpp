#include "photo/detect/tag_grid.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "geometry/median.hpp"
#include "photo/detect/aruco_detector.hpp"
#include "photo/detect/board_geometry.hpp"
#include "photo/images/grey_image.hpp"

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

constexpr size_t kEnoughToTell = 6;  // tags: whether they lie as the file has them, and how they are turned

/// The tags of a photograph and their places on the board, in units of their spacing, y up.
struct Grid {
  Grid(const std::vector<DetectedTag>& found, const Board& as_in_file) : tags(found), board(as_in_file) {
    for (const DetectedTag& tag : tags) {
      ids.push_back(tag.id - board.first_id);
      centres.push_back(
          point(Eigen::Vector2d(0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]))));
    }
    place();
  }

  bool misplaced() const { return onto_board.allFinite() && misfit(onto_board, centres, cells) > kMisplaced; }

  /// Tags that are turned alike (OpenCV draws libapriltag's families upside down), and rows that count from the bottom:
  /// the corners tell.
  void tell_turn() {
    if (!onto_board.allFinite()) return;
    turn = seen_turn();
    if (!turn.mirrored) return;
    board.ids_from_bottom = !board.ids_from_bottom;
    place();
    turn = {};
    if (onto_board.allFinite()) turn = seen_turn();
  }

  /// Corner c of a tag as it was detected.
  Eigen::Vector2d corner(size_t tag, int c) const {
    const double h = 0.5 * board.marker / (board.marker + board.gap);
    const Eigen::Vector2d offsets[] = {{-h, -h}, {h, -h}, {h, h}, {-h, h}};
    return cell_of(ids[tag], board) + offsets[(c + turn.quarter) % 4];
  }

  /// Edge of the tags over their spacing.
  double marker_ratio() const {
    double ratio = 0;
    for (const TagCorners& c : on_board()) ratio += side(c) / static_cast<double>(tags.size());
    return ratio;
  }

  std::vector<int> ids;
  std::vector<cv::Point2f> centres;

 private:
  void place() {
    cells.clear();
    for (const int k : ids) cells.push_back(point(cell_of(k, board)));
    onto_board = homography(centres, cells, 0);
  }

  std::vector<TagCorners> on_board() const {
    std::vector<TagCorners> result(tags.size());
    for (size_t i = 0; i < tags.size(); ++i)
      for (size_t k = 0; k < 4; ++k) result[i][k] = mapped(onto_board, tags[i].corners[k]);
    return result;
  }

  TagTurn seen_turn() const {
    std::vector<TagCorners> expected(tags.size());
    for (size_t i = 0; i < tags.size(); ++i)
      for (int c = 0; c < 4; ++c) expected[i][c] = corner(i, c);
    return turn_of(expected, on_board());
  }

  const std::vector<DetectedTag>& tags;
  Board board;
  TagTurn turn;
  std::vector<cv::Point2f> cells;
  Eigen::Matrix3d onto_board;
};

/// Tags whose corners touch black squares, as on Kalibr's grids: there two black and two white fields meet, and where
/// they do neither exposure nor sharpening moves, as they move edges.
class Saddles {
 public:
  Saddles(const GreyImage& image, const Board& board)
      : image_(image), view_(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())) {
    const int cells = board.dictionary.size + 2 * board.dictionary.border;
    gap_ = board.gap / board.marker, border_ = static_cast<double>(board.dictionary.border) / cells;
  }

  /// Share of the tags' corners that have a black square outside.
  double share(const std::vector<DetectedTag>& tags) const {
    double dark = 0, all = 0;
    for (const DetectedTag& tag : tags)
      for (int k = 0; k < 4; ++k) dark += is_one(tag, k), all += 1;
    return all > 0 ? dark / all : 0;
  }

  /// The corner as the point where the fields meet; nothing if it has no black square or cannot be measured.
  std::optional<Eigen::Vector2d> measured(const DetectedTag& tag, int k) const {
    if (!is_one(tag, k)) return std::nullopt;
    const auto at = static_cast<size_t>(k);
    const double free = 0.6 * std::min(gap_, border_) * side(tag.corners);  // no other edge is that near
    const int window = std::clamp(static_cast<int>(free), 2, 11);
    std::vector<cv::Point2f> corner{point(tag.corners[at])};
    cv::cornerSubPix(view_, corner, {window, window}, {-1, -1},
                     cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 60, 0.001));
    const Eigen::Vector2d found(static_cast<double>(corner.front().x), static_cast<double>(corner.front().y));
    if ((found - tag.corners[at]).norm() > std::max(1.5, 0.5 * free)) return std::nullopt;
    return found;
  }

 private:
  bool is_one(const DetectedTag& tag, int k) const {
    const auto at = [&](double along, double across) {
      const Eigen::Vector2d o = tag.corners[k], next = tag.corners[(k + 1) % 4] - o,
                            previous = tag.corners[(k + 3) % 4] - o;
      return grey(o + along * next + across * previous);
    };
    const double square = at(-0.5 * gap_, -0.5 * gap_), inside = at(0.5 * border_, 0.5 * border_),
                 paper = std::min(at(0.5, -0.5 * gap_), at(-0.5 * gap_, 0.5));
    return square >= 0 && paper > inside + 20 && square < 0.5 * (paper + inside);
  }

  /// −1 outside of the photograph.
  double grey(const Eigen::Vector2d& p) const {
    const int x = static_cast<int>(std::lround(p.x())), y = static_cast<int>(std::lround(p.y()));
    if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return -1;
    return image_.pixels[static_cast<size_t>(y) * image_.width + x];
  }

  const GreyImage& image_;
  cv::Mat view_;
  double gap_ = 0, border_ = 0;
};

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
  const SingleTags once = single_tags(tags_of(image, board.dictionary), board.first_id, board.columns * board.rows);
  if (!once.problem.empty()) {
    seen.problem = once.problem;
    return seen;
  }
  if (once.tags.size() < 2) {
    seen.problem = std::to_string(once.tags.size()) + " of the board's " + std::to_string(board.columns * board.rows) +
                   " tags were found" +
                   (once.twice.empty() ? "" : " (without " + once.twice + ", found more than once)") +
                   "; check dictionary and first_id";
    return seen;
  }
  Grid grid(once.tags, board);
  if (once.tags.size() >= kEnoughToTell) {
    if (grid.misplaced()) {
      seen.problem = misplaced(grid.ids, grid.centres, board), seen.contradicts = true;
      return seen;
    }
    grid.tell_turn();
    if (const double ratio = grid.marker_ratio(); std::isfinite(ratio)) {
      seen.marker_ratio = ratio;
      for (const DetectedTag& tag : once.tags)
        seen.marker_pixels += side(tag.corners) / static_cast<double>(once.tags.size());
    }
  }
  const Saddles saddles(image, board);
  const bool touching = saddles.share(once.tags) > 0.6;
  for (size_t i = 0; i < once.tags.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      const DetectedTag& tag = once.tags[i];
      const auto k = static_cast<size_t>(c);
      const double sigma = std::sqrt(0.5 * tag.covariances[k].trace() + 0.1 * 0.1);
      const auto saddle = touching ? saddles.measured(tag, c) : tag.corners[k];
      const Eigen::Vector2d place = (board.marker + board.gap) * grid.corner(i, c);
      if (saddle)
        seen.points.push_back({4 * grid.ids[i] + c, {place.x(), place.y(), 0}, *saddle, touching ? 0.1 : sigma});
    }
  if (!touching) {
    double squares = 0, fitted = 0;
    for (const DetectedTag& tag : once.tags)
      if (tag.inset_sigma > 0) squares += tag.inset_sigma * tag.inset_sigma, fitted += 1;
    if (fitted > 0) seen.inset_sigma = std::sqrt(squares / fitted);
  }
  return seen;
}

}  // namespace plumbline::detect
