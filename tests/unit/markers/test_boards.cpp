// Boards that are drawn and found, and rigs of several cameras before them.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <atomic>
#include <random>
#include <thread>
#include <utility>

#include "photo/detect/board.hpp"
#include "photo/images/grey_image.hpp"
#include "photo/markers/rig.hpp"
#include "photo/markers/rig_adjustment.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_boards {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Board, IsReadWithItsUnitsChecked) {
  const auto b = detect::parse_board(
      "type: charuco\ncolumns: 8\nrows: 8\nsquare: 0.0254\nmarker: 0.01905\ndictionary: DICT_4X4_50\n", "b.yaml");
  EXPECT_EQ(b.columns, 8);
  for (const auto& [text, words] :
       {std::pair("type: chessboard\ncolumns: 9\nrows: 6\nsquare: 25\n", "0.025 for 25 mm"),
        std::pair("type: charuco\ncolumns: 20\nrows: 20\nsquare: 0.02\nmarker: 0.01\ndictionary: DICT_4X4_50\n",
                  "ends at 49"),
        std::pair("target_type: circlegrid\ntargetCols: 6\ntargetRows: 7\n", "circles are not measured"),
        std::pair("columns: 9\n", "b.yaml: 'type' is missing")})
    EXPECT_THAT([&] { detect::parse_board(text, "b.yaml"); }, ThrowsMessage<std::runtime_error>(HasSubstr(words)));
  const auto kalibr = detect::parse_board(
      "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 6\ntagSize: 0.088\ntagSpacing: 0.3\n", "k.yaml");
  EXPECT_NEAR(kalibr.gap, 0.0264, 1e-12);
  EXPECT_TRUE(kalibr.ids_from_bottom);
}

TEST(Rig, IsTheMeanOverMomentsWithoutThoseThatDisagree) {
  const RigidTransform right_from_left{Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY())),
                                       Eigen::Vector3d(-0.5, 0.01, 0.02)};
  std::vector<std::vector<markers::RigView>> cameras(3);
  for (int k = 0; k < 9; ++k) {
    const std::string moment = std::to_string(k);
    const RigidTransform left{Eigen::Quaterniond(Eigen::AngleAxisd(0.1 * k, Eigen::Vector3d(1, k, 0).normalized())),
                              Eigen::Vector3d(0.1 * k, 0.2, 1 + 0.1 * k)};
    RigidTransform right = right_from_left * left;
    right.translation.x() += k == 4 ? 0.1 : k % 2 ? 1e-4 : -1e-4;
    cameras[0].push_back({moment, left});
    cameras[1].push_back({moment, right});
    if (k < 2) cameras[2].push_back({moment, left});
  }
  const auto rig = markers::rig_of(cameras);
  ASSERT_EQ(rig.size(), 1u) << "two moments are too few";
  EXPECT_EQ(rig[0].left_out, std::vector<std::string>{"4"});
  EXPECT_EQ(rig[0].moments.size(), 8u);
  EXPECT_NEAR(rig[0].cam_from_reference.translation.x(), -0.5, 1e-9);
  EXPECT_NEAR(rig[0].cam_from_reference.rotation.angularDistance(right_from_left.rotation), 0, 1e-7);
  EXPECT_NEAR(rig[0].translation_sigma.x(), 1e-4 / std::sqrt(7.0), 1e-9);
}

/// A ChArUco board of OpenCV's present pattern in whole pixels, squares of 32 px with markers of 24, 40 px from the
/// border.
GreyImage drawn_charuco(const detect::Board& board) {
  const int width = 80 + 32 * board.columns, height = 80 + 32 * board.rows;
  GreyImage image{width, height, std::vector<std::uint8_t>(static_cast<size_t>(width * height), 210)};
  const auto fill = [&](int x0, int y0, int side, std::uint8_t value) {
    for (int y = y0; y < y0 + side; ++y)
      for (int x = x0; x < x0 + side; ++x) image.pixels[y * width + x] = value;
  };
  size_t id = 0;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      const int x = 40 + 32 * column, y = 40 + 32 * row;
      if ((row + column) % 2 == 0) {
        fill(x, y, 32, 30);
        continue;
      }
      fill(x + 4, y + 4, 24, 30);
      for (int k = 0; k < 16; ++k)
        if (board.dictionary.codes[id][k] != 0) fill(x + 8 + 4 * (k % 4), y + 8 + 4 * (k / 4), 4, 210);
      ++id;
    }
  return image;
}

/// With five rows three of them fit the older pattern exactly, moved by a square; and boards are printed inverted, too.
TEST(Board, OfAnOddNumberOfRowsIsFoundAsPrintedAlsoInNegative) {
  const auto board = detect::parse_board(
      "type: charuco\ncolumns: 4\nrows: 5\nsquare: 0.032\nmarker: 0.024\ndictionary: DICT_4X4_50\n", "b.yaml");
  for (const bool negative : {false, true}) {
    GreyImage image = drawn_charuco(board);
    if (negative)
      for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);
    const auto seen = detect::find_board(image, board);
    EXPECT_EQ(seen.problem, "");
    ASSERT_EQ(seen.points.size(), 12u) << negative;
    EXPECT_NEAR(seen.marker_ratio, 0.75, 0.02);
    for (const auto& p : seen.points) {
      const Eigen::Vector2d truth(39.5 + 1000 * p.board.x(), 39.5 - 1000 * p.board.y());
      EXPECT_LT((p.pixel - truth).norm(), 0.1) << p.id;
    }
  }
}

/// Before a wide lens the outer markers lie a tenth of the image's width off the homography of the inner ones.
TEST(Board, OfCharucoIsFoundBeforeAWideLens) {
  const auto board = detect::parse_board(
      "type: charuco\ncolumns: 16\nrows: 12\nsquare: 0.032\nmarker: 0.024\ndictionary: DICT_4X4_100\n", "b.yaml");
  const GreyImage flat = drawn_charuco(board);
  // The print at r = f tan(theta), the photograph at r = f theta from its middle, 50 degrees off in the corners.
  const double f = 0.42 * std::hypot(flat.width, flat.height);
  GreyImage image{flat.width, flat.height, {}};
  const Eigen::Vector2d middle(0.5 * (flat.width - 1), 0.5 * (flat.height - 1));
  const auto bent = [&](const Eigen::Vector2d& from, double (*angle)(double)) {
    const Eigen::Vector2d d = from - middle;
    const double r = d.norm();
    return Eigen::Vector2d(middle + (r > 0 ? f * angle(r / f) / r : 1) * d);
  };
  const auto tangent = [](double r) { return std::tan(std::min(1.5, r)); };
  const auto arc = [](double r) { return std::atan(r); };
  for (int y = 0; y < flat.height; ++y)
    for (int x = 0; x < flat.width; ++x) {
      double sum = 0;
      for (const double dy : {-0.375, -0.125, 0.125, 0.375})
        for (const double dx : {-0.375, -0.125, 0.125, 0.375}) {
          const Eigen::Vector2d p = bent({x + dx, y + dy}, tangent);
          const long i = std::lround(p.x()), j = std::lround(p.y());
          sum += i >= 0 && j >= 0 && i < flat.width && j < flat.height ? flat.pixels[j * flat.width + i] : 210;
        }
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(sum / 16)));
    }
  const auto seen = detect::find_board(image, board);
  ASSERT_EQ(seen.problem, "");
  EXPECT_GT(seen.points.size(), 130u) << "of 165";
  EXPECT_NEAR(seen.marker_ratio, 0.75, 0.045) << "of the squares: within what detect.board takes";
  for (const auto& p : seen.points) {
    const Eigen::Vector2d print(39.5 + 1000 * p.board.x(), 39.5 - 1000 * p.board.y());
    EXPECT_LT((p.pixel - bent(print, arc)).norm(), 0.3) << p.id;
  }
}

/// A chessboard of 7 x 5 squares of 24 px: 6 x 4 inner corners.
GreyImage drawn_chessboard() {
  GreyImage image{260, 220, std::vector<std::uint8_t>(260 * 220, 210)};
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 168; ++x)
      if ((x / 24 + y / 24) % 2 == 0) image.pixels[(y + 50) * 260 + x + 46] = 30;
  return image;
}

/// A tag of 24 px with its top left pixel at (x0, y0), turned counter-clockwise by so many quarters.
void draw_tag(GreyImage& image, const detect::Board& board, int id, int x0, int y0, int turn = 0) {
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x) {
      int row = y / 4 - 1, column = x / 4 - 1;
      for (int k = 0; k < turn; ++k) row = std::exchange(column, 3 - row);
      const bool code = row >= 0 && row < 4 && column >= 0 && column < 4;
      const bool white = code && board.dictionary.codes[id][4 * row + column] != 0;
      image.pixels[(y0 + y) * image.width + x0 + x] = white ? 210 : 30;
    }
}

/// Tags of 24 px in steps of 32; the spacing is measured, and a tag that is there twice is none.
TEST(Board, OfTagsMeasuresTheirSpacingAndLeavesOutIdsThatAreTwice) {
  const auto board = detect::parse_board(
      "type: tags\ncolumns: 3\nrows: 3\nmarker: 0.024\ngap: 0.008\ndictionary: DICT_4X4_50\n", "b.yaml");
  GreyImage image{200, 160, std::vector<std::uint8_t>(200 * 160, 210)};
  for (int k = 0; k < 9; ++k) draw_tag(image, board, k, 20 + 32 * (k % 3), 20 + 32 * (k / 3));
  const auto seen = detect::find_board(image, board);
  EXPECT_EQ(seen.points.size(), 36u);
  EXPECT_NEAR(seen.marker_ratio, 0.75, 0.01);
  draw_tag(image, board, 4, 150, 100);
  EXPECT_EQ(detect::find_board(image, board).points.size(), 32u);
}

/// What no markers tell is no number: of a chessboard, and of tags that are too few to say how they lie.
TEST(Board, RatioOfMarkersIsMeasuredOrNoNumber) {
  const auto board = detect::parse_board(
      "type: tags\ncolumns: 3\nrows: 3\nmarker: 0.024\ngap: 0.008\ndictionary: DICT_4X4_50\n", "b.yaml");
  for (const auto& [tags, step] : {std::pair(9, 36), {6, 40}, {5, 32}}) {
    GreyImage image{200, 180, std::vector<std::uint8_t>(200 * 180, 210)};
    for (int k = 0; k < tags; ++k) draw_tag(image, board, k, 20 + step * (k % 3), 20 + step * (k / 3));
    const auto seen = detect::find_board(image, board);
    EXPECT_EQ(seen.points.size(), 4u * tags) << seen.problem;
    if (tags < 6) {
      EXPECT_TRUE(std::isnan(seen.marker_ratio)) << seen.marker_ratio;
      EXPECT_EQ(seen.marker_pixels, 0);
    } else {
      EXPECT_NEAR(seen.marker_ratio, 24.0 / step, 0.01);
      EXPECT_NEAR(seen.marker_pixels, 24, 0.2);
    }
  }
  const auto chessboard = detect::parse_board("type: chessboard\ncolumns: 6\nrows: 4\nsquare: 0.024\n", "b.yaml");
  const auto seen = detect::find_board(drawn_chessboard(), chessboard);
  EXPECT_EQ(seen.points.size(), 24u);
  EXPECT_TRUE(std::isnan(seen.marker_ratio));
}

/// Inner corners in one row span no plane: no marker can be held against them, whatever the numbers come to. With a
/// second row, its sound twin, every marker can.
TEST(Board, OfWhichOneRowOfCornersShowsIsNotMeasured) {
  const auto board = detect::parse_board(
      "type: charuco\ncolumns: 9\nrows: 5\nsquare: 0.032\nmarker: 0.024\ndictionary: DICT_4X4_50\n", "b.yaml");
  const GreyImage whole = drawn_charuco(board);
  for (const int rows : {2, 3}) {  // of squares
    GreyImage part{whole.width, 44 + 32 * rows, {}};
    part.pixels.assign(whole.pixels.begin(), whole.pixels.begin() + part.width * part.height);
    const auto seen = detect::find_board(part, board);
    if (rows == 2) {
      EXPECT_THAT(seen.problem, HasSubstr("its 8 inner corners lie in a row or far apart"));
      EXPECT_TRUE(seen.points.empty());
      EXPECT_TRUE(std::isnan(seen.marker_ratio)) << seen.marker_ratio;
    } else {
      EXPECT_EQ(seen.problem, "");
      EXPECT_EQ(seen.points.size(), 16u);
      EXPECT_NEAR(seen.marker_ratio, 0.75, 0.02);
    }
  }
}

/// OpenCV draws libapriltag's families upside down, and programs count rows from either end: the corners tell.
TEST(Board, OfTagsDrawnTurnedOrCountedFromTheBottomIsFoundOut) {
  const auto board = detect::parse_board(
      "type: tags\ncolumns: 4\nrows: 3\nmarker: 0.024\ngap: 0.008\ndictionary: DICT_4X4_50\n", "b.yaml");
  for (int turn = 0; turn < 4; ++turn)
    for (const bool from_bottom : {false, true}) {
      GreyImage image{200, 160, std::vector<std::uint8_t>(200 * 160, 210)};
      for (int k = 0; k < 12; ++k)
        draw_tag(image, board, k, 30 + 32 * (k % 4), 20 + 32 * (from_bottom ? 2 - k / 4 : k / 4), turn);
      const auto seen = detect::find_board(image, board);
      ASSERT_EQ(seen.points.size(), 48u) << turn;
      const Eigen::Vector2d board_0 = seen.points[0].board.head<2>(), pixel_0 = seen.points[0].pixel;
      for (const auto& p : seen.points) {
        const Eigen::Vector2d at = 1000 * (p.board.head<2>() - board_0), moved = p.pixel - pixel_0;
        EXPECT_LT((moved - Eigen::Vector2d(at.x(), -at.y())).norm(), 0.3) << turn << from_bottom << " point " << p.id;
      }
    }
}

/// The same for a board of squares and markers.
TEST(Board, OfCharucoMarkersDrawnTurnedIsFoundOut) {
  const auto board = detect::parse_board(
      "type: charuco\ncolumns: 5\nrows: 4\nsquare: 0.032\nmarker: 0.024\ndictionary: DICT_4X4_50\n", "c.yaml");
  for (int turn = 0; turn < 4; ++turn) {
    GreyImage image{220, 190, std::vector<std::uint8_t>(220 * 190, 210)};
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 160; ++x)
        if ((x / 32 + y / 32) % 2 == 0) image.pixels[(y + 30) * image.width + x + 30] = 30;
    for (int k = 0; k < 10; ++k) {
      const int row = 2 * k / 5, column = 2 * k - 5 * row + (row % 2 == 0 ? 1 : 0);
      draw_tag(image, board, k, 34 + 32 * column, 34 + 32 * row, turn);
    }
    const auto seen = detect::find_board(image, board);
    EXPECT_GE(seen.points.size(), 10u) << turn << ": " << seen.problem;
    EXPECT_NEAR(seen.marker_ratio, 0.75, 0.02);
    for (const auto& p : seen.points)
      EXPECT_LT((p.pixel - Eigen::Vector2d(29.5 + 1000 * p.board.x(), 29.5 - 1000 * p.board.y())).norm(), 0.2) << turn;
  }
}

/// Two pictures of the board in one, as stereo cameras write them: neither half is taken for the board, nor tags of
/// both.
TEST(Board, TwiceInAPhotographIsNone) {
  const auto board = detect::parse_board(
      "type: tags\ncolumns: 3\nrows: 3\nmarker: 0.024\ngap: 0.008\ndictionary: DICT_4X4_50\n", "b.yaml");
  GreyImage image{280, 160, std::vector<std::uint8_t>(280 * 160, 210)};
  for (int k = 0; k < 9; ++k) draw_tag(image, board, k, 20 + 32 * (k % 3), 20 + 32 * (k / 3));
  for (int k = 0; k < 5; ++k) draw_tag(image, board, k, 150 + 32 * (k % 3), 22 + 32 * (k / 3));
  const auto seen = detect::find_board(image, board);
  EXPECT_TRUE(seen.points.empty());
  EXPECT_FALSE(seen.contradicts);
  EXPECT_THAT(seen.problem, HasSubstr("5 of the board's tags are there twice (0, 1, 2, 3, 4): two boards, or two"));
  const auto charuco = detect::parse_board(
      "type: charuco\ncolumns: 3\nrows: 6\nsquare: 0.032\nmarker: 0.024\ndictionary: DICT_4X4_50\n", "c.yaml");
  EXPECT_THAT(detect::find_board(image, charuco).problem, HasSubstr("5 of the board's tags are there twice"));
}

/// Tags of 24 px in steps of 30, five in a row, of which the board file knows four: no photograph says that alone, and
/// neither does it mean that the lengths are wrong.
TEST(Board, OfTagsInRowsOfAnotherLengthIsContradictedInWords) {
  const auto board = detect::parse_board(
      "type: tags\ncolumns: 4\nrows: 5\nmarker: 0.024\ngap: 0.006\ndictionary: DICT_4X4_50\n", "b.yaml");
  GreyImage image{220, 220, std::vector<std::uint8_t>(220 * 220, 210)};
  for (int k = 0; k < 25; ++k) draw_tag(image, board, k, 36 + 30 * (k % 5), 36 + 30 * (k / 5));
  const auto seen = detect::find_board(image, board);
  EXPECT_TRUE(seen.contradicts);
  EXPECT_THAT(seen.problem, HasSubstr("not lie in rows of 4 as the board file has them, but in rows of 5: 'columns'"));
  EXPECT_TRUE(seen.points.empty());
  for (int k = 0; k < 25; ++k) draw_tag(image, board, k, 36 + 30 * ((7 * k) % 25 % 5), 36 + 30 * ((7 * k) % 25 / 5));
  EXPECT_THAT(detect::find_board(image, board).problem, HasSubstr("check columns, rows and first_id"));
}

TEST(Board, OfWhichTheSquaresWereCountedSaysSo) {
  const auto squares = detect::parse_board("type: chessboard\ncolumns: 7\nrows: 5\nsquare: 0.024\n", "b.yaml");
  const auto corners = detect::parse_board("type: chessboard\ncolumns: 6\nrows: 4\nsquare: 0.024\n", "b.yaml");
  const auto seen = detect::find_board(drawn_chessboard(), squares);
  EXPECT_TRUE(seen.contradicts);
  EXPECT_THAT(seen.problem, HasSubstr("has 6 x 4 inner corners, not 7 x 5 as the board file says: columns and rows"));
  const auto found = detect::find_board(drawn_chessboard(), corners);
  ASSERT_EQ(found.points.size(), 24u) << found.problem;
  for (const auto& p : found.points) {
    const Eigen::Vector2d at(69.5 + 1000 * p.board.x(), 73.5 - 1000 * p.board.y());
    EXPECT_LT((p.pixel - at).norm(), 0.1) << p.id;
  }
}

/// Corners of the rim are no inner corners, and a part of a board is not the board: either was measured where it was
/// found.
TEST(Board, OfAnotherSizeIsNamed) {
  for (const auto& [columns, rows] : {std::pair(5, 3), {5, 4}, {6, 3}, {6, 5}, {7, 4}}) {
    const auto board = detect::parse_board("type: chessboard\ncolumns: " + std::to_string(columns) +
                                               "\nrows: " + std::to_string(rows) + "\nsquare: 0.024\n",
                                           "b.yaml");
    const auto seen = detect::find_board(drawn_chessboard(), board);
    EXPECT_TRUE(seen.contradicts) << columns << " x " << rows;
    EXPECT_TRUE(seen.points.empty()) << columns << " x " << rows;
    // A larger one may be there, and covered in part.
    const bool may_be_part = columns >= 6 && rows >= 4;
    EXPECT_THAT(seen.problem, HasSubstr(may_be_part ? "shows 6 x 4 inner corners" : "has 6 x 4 inner corners"));
    EXPECT_EQ(seen.problem.find("a part of it is covered") != std::string::npos, may_be_part) << seen.problem;
  }
}

/// The number of OpenCV's threads was set anew for each photograph, which ends the threads that another one works with.
TEST(Board, IsLookedForByManyThreadsAtOnce) {
  const auto board = detect::parse_board(
      "type: charuco\ncolumns: 4\nrows: 5\nsquare: 0.032\nmarker: 0.024\ndictionary: DICT_4X4_50\n", "b.yaml");
  const GreyImage image = drawn_charuco(board);
  std::atomic<int> found = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int k = 0; k < 50; ++k) found += static_cast<int>(detect::find_board(image, board).points.size());
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(found, 4 * 50 * 12);
}

/// Three cameras, a board that moves before them; images with noise of 0.1 px.
struct SimulatedRig {
  std::vector<RigidTransform> from_first;
  std::vector<std::vector<markers::CalibrationView>> views;
  std::vector<markers::Calibration> calibrations;
  std::vector<std::vector<std::string>> moments;

  explicit SimulatedRig(unsigned seed, int late = -1) : views(3), calibrations(3), moments(3) {
    std::mt19937_64 random(seed);
    const auto noise = [&](double sigma) {  // a sum of 12 uniform deviates
      double sum = -6;
      for (int k = 0; k < 12; ++k) sum += static_cast<double>(random() >> 11) * 0x1p-53;
      return sigma * sum;
    };
    for (int c = 0; c < 3; ++c)
      from_first.push_back({Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * c, Eigen::Vector3d::UnitY())),
                            Eigen::Vector3d(0.35 * c, 0.02 * c, 0.1 * c)});
    for (size_t c = 0; c < 3; ++c) {
      calibrations[c].camera = {1280, 960, 1000, 1000, 640, 480, -0.1, 0.05, 0, 0, 0};
      calibrations[c].rms = 0.1414;
    }
    for (int e = 0; e < 8; ++e) {
      const auto pose = [&](double time) {
        const Eigen::Vector3d axis(std::cos(time), std::sin(time), 0.2 * std::sin(3 * time));
        return RigidTransform{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()) *
                                                 Eigen::AngleAxisd(0.6, axis.normalized())),
                              Eigen::Vector3d(-0.2 + 0.25 * std::cos(2 * time), 0.2 * std::sin(time), 1.3)};
      };
      for (size_t c = 0; c < 3; ++c) {
        const RigidTransform board = from_first[c] * pose(e + (c == 1 && e == late ? 0.1 : 0.0));
        markers::CalibrationView view;
        view.path = "cam" + std::to_string(c) + "_" + std::to_string(e) + ".jpg";
        markers::CalibratedView found;
        found.view = e;
        for (int k = 0; k < 15; ++k) {
          const Eigen::Vector3d point(0.06 * (k % 5), -0.06 * (k / 5), 0);
          const auto pixel = project(calibrations[c].camera, board * point);
          found.points.push_back(k);
          view.points.push_back({point, *pixel + Eigen::Vector2d(noise(0.1), noise(0.1)), 0.1});
        }
        found.cam_from_board = board;
        found.cam_from_board.translation += Eigen::Vector3d(noise(2e-3), noise(2e-3), noise(5e-3));
        calibrations[c].views.push_back(found);
        views[c].push_back(view);
        moments[c].push_back(std::to_string(e));
      }
    }
  }

  std::vector<markers::AdjustedRig> adjust() const {
    std::vector<markers::RigCamera> cameras;
    for (size_t c = 0; c < 3; ++c) cameras.push_back({"c" + std::to_string(c), &views[c], &calibrations[c]});
    return markers::adjust_rigs(cameras, moments, {});
  }
};

TEST(Rig, IsOneAdjustmentWhoseCovarianceIsTrue) {
  double nees = 0, halves = 0;
  int count = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const SimulatedRig scene(seed);
    const auto rigs = scene.adjust();
    ASSERT_EQ(rigs.size(), 1u);
    ASSERT_EQ(rigs[0].refused, "");
    ASSERT_EQ(rigs[0].cameras.size(), 3u);
    EXPECT_THAT(rigs[0].left_out, testing::IsEmpty());
    EXPECT_NEAR(rigs[0].sigma, 0.1, 0.01);
    for (size_t c = 1; c < 3; ++c) {
      const auto& camera = rigs[0].cameras[c];
      const RigidTransform truth = scene.from_first[c];
      const Eigen::AngleAxisd turn(camera.cam_from_reference.rotation * truth.rotation.conjugate());
      Eigen::Matrix<double, 6, 1> error;
      error << turn.angle() * turn.axis(), camera.cam_from_reference.translation - truth.translation;
      nees += error.dot(camera.covariance.ldlt().solve(error)) / 6, halves += camera.halves, ++count;
      EXPECT_LT(std::sqrt(camera.covariance(3, 3)), 5e-3);
    }
  }
  EXPECT_GT(nees / count, 0.5);
  EXPECT_LT(nees / count, 1.8);  // 36 degrees of freedom: 99.9 % are below
  EXPECT_LT(halves / count, 1.8);
}

/// One camera's points move together by what is stated of them: so does its place in the rig, and the covariance holds
/// exactly that beside what it held.
TEST(Rig, HoldsWhatTheEdgesOfEachCameraAreDrawnInBy) {
  SimulatedRig scene(4), moved(4);
  for (auto& view : scene.views[1])
    for (auto& p : view.points) p.by_inset = 0.05 * (p.pixel - Eigen::Vector2d(640, 480)).normalized();
  for (auto& view : moved.views[1])
    for (auto& p : view.points) p.pixel += 0.05 * (p.pixel - Eigen::Vector2d(640, 480)).normalized();
  const auto without = SimulatedRig(4).adjust(), with = scene.adjust(), after = moved.adjust();
  const auto &before = without[0].cameras[1], &held = with[0].cameras[1];
  ASSERT_EQ(held.by_inset.cols(), 3);
  EXPECT_EQ(held.by_inset.col(0).norm() + held.by_inset.col(2).norm(), 0) << "nothing is stated of the others";
  EXPECT_LT((held.covariance - before.covariance - held.by_inset * held.by_inset.transpose()).norm(),
            1e-9 * held.covariance.norm());
  const Eigen::Vector3d found =
      after[0].cameras[1].cam_from_reference.translation - before.cam_from_reference.translation;
  ASSERT_GT(found.norm(), 1e-5);
  EXPECT_LT((found - held.by_inset.col(1).tail<3>()).norm(), 0.05 * found.norm());
  EXPECT_GT(held.interior_covariance(0, 0), 1.0001 * before.interior_covariance(0, 0));
}

TEST(Rig, LeavesOutWhatWasNotTakenTogetherAndRefusesAWrongGrouping) {
  const auto late = SimulatedRig(5, 6).adjust();
  ASSERT_EQ(late.size(), 1u);
  ASSERT_EQ(late[0].refused, "");
  EXPECT_EQ(late[0].left_out, std::vector<std::string>{"cam1_6.jpg"});
  SimulatedRig mixed(6);
  std::rotate(mixed.moments[1].begin(), mixed.moments[1].begin() + 3, mixed.moments[1].end());
  const auto rigs = mixed.adjust();
  ASSERT_EQ(rigs.size(), 1u);
  EXPECT_THAT(rigs[0].refused, HasSubstr("were not taken together"));
}

}  // namespace test_boards
}  // namespace plumbline
