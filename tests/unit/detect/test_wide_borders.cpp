// Tags with a border of two black cells between black squares, as on the grids that Kalibr prints.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "photo/detect/aruco_detector.hpp"
#include "photo/detect/board.hpp"
#include "photo/detect/family_guess.hpp"
#include "photo/detect/tag_detector.hpp"
#include "photo/detect/tag_family.hpp"
#include "photo/detect/tag_pyramid.hpp"
#include "photo/images/grey_image.hpp"
#include "tag_rendering.hpp"
#include "test_support.hpp"

namespace plumbline::detect {
namespace test_wide_borders {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int kColumns = 4, kRows = 3, kCells = 10, kStep = 13;  // cells of a tag, and from one tag to the next

/// Colour of the printed grid, 0 black, at cells from the lower left tag's lower left corner, y up.
double printed(const SquareFamily& family, double x, double y) {
  constexpr int kGap = kStep - kCells;
  if (x < -kGap || y < -kGap || x >= kColumns * kStep || y >= kRows * kStep) return 1;
  const int column = static_cast<int>(std::floor((x + kGap) / kStep)),
            row = static_cast<int>(std::floor((y + kGap) / kStep));
  const double u = x + kGap - column * kStep, v = y + kGap - row * kStep;  // from the square before the tag
  if (u < kGap && v < kGap) return 0;
  if (u < kGap || v < kGap || column == kColumns || row == kRows) return 1;
  const int i = static_cast<int>(u) - kGap, j = kCells - 1 - (static_cast<int>(v) - kGap);
  const std::uint64_t code = family.codes[row * kColumns + column];
  for (std::size_t k = 0; k < family.cells.size(); ++k)
    if (family.cells[k][0] == i && family.cells[k][1] == j)
      return static_cast<double>(code >> (family.cells.size() - 1 - k) & 1);
  return 0;
}

/// Pixels from cells: tilted, in perspective, 4 px a cell.
Eigen::Matrix3d view() {
  Eigen::Matrix3d h;
  h << 4.0, 0.9, 60, 0.5, -3.8, 230, 0.002, 0.003, 1;
  return h;
}

/// `spread`: how far white fields grow, as they do where a camera exposes them long [cells].
GreyImage photograph(double spread = 0) {
  const SquareFamily family = apriltag_square_family("tag36h11b2");
  const Eigen::Matrix3d back = view().inverse();
  GreyImage image{320, 260, {}};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      double sum = 0, weights = 0;
      for (double dy = -2.4; dy < 2.5; dy += 0.3)
        for (double dx = -2.4; dx < 2.5; dx += 0.3) {
          const Eigen::Vector3d p = back * Eigen::Vector3d(x + dx, y + dy, 1);
          const double weight = std::exp(-0.5 * (dx * dx + dy * dy) / (0.9 * 0.9));
          double white = 0;
          for (const double sy : {-spread, 0.0, spread})
            for (const double sx : {-spread, 0.0, spread})
              if (white == 0 && (spread > 0 || (sx == 0 && sy == 0)))
                white = printed(family, p.x() / p.z() + sx, p.y() / p.z() + sy);
          sum += weight * white, weights += weight;
        }
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(40 + 140 * sum / weights)));
    }
  return image;
}

void expect_the_grid(const std::vector<DetectedTag>& tags) {
  ASSERT_EQ(tags.size(), kColumns * kRows);
  for (const DetectedTag& tag : tags) {
    EXPECT_EQ(tag.family, "tag36h11b2");
    EXPECT_TRUE(tag.refined) << tag.id;
    const double x = tag.id % kColumns * kStep, y = tag.id / kColumns * kStep;
    const std::array<Eigen::Vector2d, 4> cells = {{{x, y}, {x + kCells, y}, {x + kCells, y + kCells}, {x, y + kCells}}};
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d pixel = (view() * cells[k].homogeneous()).hnormalized();
      EXPECT_LT((tag.corners[k] - pixel).norm(), 0.12) << tag.id << " corner " << k;
    }
  }
}

TEST(WideBorders, AreFoundByEveryDetectorThoughTheirCornersTouchBlackSquares) {
  const GreyImage image = photograph();
  expect_the_grid(ArucoDetector(builtin_dictionary("tag36h11b2"), {}).detect(image));
  DetectorOptions options;
  options.families = {"tag36h11b2"};
  expect_the_grid(TagDetector(options).detect(image));
  expect_the_grid(TagPyramid({square_family("DICT_APRILTAG_36h11b2")}, {}).detect(image).tags);
  EXPECT_TRUE(ArucoDetector(builtin_dictionary("tag36h11"), {}).detect(image).empty());
}

TEST(WideBorders, AreThoseOfAKalibrTarget) {
  const Board board =
      parse_board("target_type: 'aprilgrid'\ntagCols: 4\ntagRows: 3\ntagSize: 0.05\ntagSpacing: 0.3\n", "k.yaml");
  const SeenBoard seen = find_board(photograph(), board);
  EXPECT_EQ(seen.problem, "");
  EXPECT_EQ(seen.points.size(), 4u * kColumns * kRows);
  Board ours = board;  // "dictionary: tag36h11" in a file of our own
  ours.dictionary = builtin_dictionary("tag36h11");
  EXPECT_EQ(find_board(photograph(), ours).points.size(), 4u * kColumns * kRows);
}

/// Where black squares touch the corners, these stay though the edges move.
TEST(WideBorders, CornersOfAKalibrTargetDoNotMoveWithTheExposure) {
  const Board board =
      parse_board("target_type: 'aprilgrid'\ntagCols: 4\ntagRows: 3\ntagSize: 0.05\ntagSpacing: 0.3\n", "k.yaml");
  const GreyImage image = photograph(0.15);
  const auto truth = [](int id, int k) {
    const double x = id % kColumns * kStep + (k == 1 || k == 2 ? kCells : 0),
                 y = id / kColumns * kStep + (k > 1 ? kCells : 0);
    return Eigen::Vector2d((view() * Eigen::Vector3d(x, y, 1)).hnormalized());
  };
  const auto tags = ArucoDetector(board.dictionary, {}).detect(image);
  ASSERT_GT(tags.size(), 6u);
  double nearest = 1e9;
  for (const DetectedTag& tag : tags)
    for (int k = 0; k < 4; ++k) nearest = std::min(nearest, (tag.corners[k] - truth(tag.id, k)).norm());
  EXPECT_GT(nearest, 0.3) << "where edges meet";
  const SeenBoard seen = find_board(image, board);
  EXPECT_EQ(seen.points.size(), 4 * tags.size());
  for (const SeenPoint& point : seen.points)
    EXPECT_LT((point.pixel - truth(point.id / 4, point.id % 4)).norm(), 0.15) << point.id;
}

TEST(FamilyGuess, NamesTheTagsThatAreThereAndNothingElse) {
  EXPECT_EQ(tags_of_another_family(photograph(), {"DICT_4X4_50"}), "12 tags of tag36h11b2");
  EXPECT_EQ(tags_of_another_family(photograph(), {"tag36h11b2"}), "");
  test::TagScene scene;
  scene.corners = test::square_corners({100, 100}, 80, 0.3);
  EXPECT_EQ(tags_of_another_family(test::render(scene), {"tag16h5"}), "") << "one tag may be chance";
}

/// OpenCV's dictionaries of one size are parts of one another: tags of DICT_6X6_50 are none of another family than
/// DICT_6X6_1000.
TEST(FamilyGuess, APartOfTheFamilyIsNoOther) {
  PLUMBLINE_REQUIRE_DATA("images/aruco_grid/aruco_data/0.jpg");
  const GreyImage image = read_grey_image(test::data_file("images/aruco_grid/aruco_data/0.jpg"));
  EXPECT_THAT(tags_of_another_family(image, {"DICT_5X5_1000"}), testing::HasSubstr("tags of DICT_6X6_50"));
  EXPECT_EQ(tags_of_another_family(image, {"DICT_6X6_50"}), "");
  EXPECT_EQ(tags_of_another_family(image, {"DICT_6X6_1000"}), "");
}

TEST(WideBorders, AreNamedWithTheFamily) {
  EXPECT_EQ(square_family("4X4_50b2").modules, 8);
  EXPECT_EQ(builtin_dictionary("dict_4x4_50b2").name, "DICT_4X4_50b2");
  EXPECT_EQ(parse_dictionary("markersize: 3\nmarkerBorderBits: 2\nmarker_0: \"110100000\"\n", "d.yml").border, 2);
  EXPECT_THAT([] { parse_dictionary("markersize: 3\nmarkerBorderBits: 3\nmarker_0: \"110100000\"\n", "d.yml"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("expected a border of 1 or 2 cells")));
  EXPECT_THAT([] { square_family("tagStandard41h12b2"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("no black border")));
  std::vector<std::string> names = {"tag36h11", "tagCircle21h7"};
  EXPECT_TRUE(with_two_cells(names));
  EXPECT_EQ(names, std::vector<std::string>{"tag36h11b2"});
}

}  // namespace test_wide_borders
}  // namespace plumbline::detect
