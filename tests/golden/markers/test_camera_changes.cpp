// Cameras that change between the photographs of public sets: corners of real photographs, moved as a zoom, a program
// or a rolling shutter would have moved them.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <random>

#include "photo/detect/aruco_detector.hpp"
#include "photo/detect/board.hpp"
#include "photo/images/grey_image.hpp"
#include "photo/markers/calibration_parts.hpp"
#include "photo/markers/marker_block.hpp"
#include "photo/markers/marker_truth.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_camera_changes {

using testing::HasSubstr;

/// Where a point of photograph `k` of `count` would have been.
using Mistake = std::function<Eigen::Vector2d(int k, int count, const Eigen::Vector2d&)>;

struct Frame {
  double width, height;
  BrownCamera camera;

  Mistake zoomed(const std::function<double(int, int)>& factor) const {
    const Eigen::Vector2d middle(0.5 * width, 0.5 * height);
    return
        [=](int k, int n, const Eigen::Vector2d& p) -> Eigen::Vector2d { return middle + factor(k, n) * (p - middle); };
  }
  Mistake every_second_turned() const {
    return [w = width, h = height](int k, int, const Eigen::Vector2d& p) -> Eigen::Vector2d {
      return k % 2 ? Eigen::Vector2d(w - 1 - p.x(), h - 1 - p.y()) : p;
    };
  }
  Mistake every_second_undistorted() const {
    return [c = camera](int k, int, const Eigen::Vector2d& p) -> Eigen::Vector2d {
      const auto ray = unproject(c, p);
      return k % 2 && ray ? Eigen::Vector2d(c.fx * ray->x() + c.cx, c.fy * ray->y() + c.cy) : p;
    };
  }
  /// `rows` [px] from the first to the last, `shift` of the principal point [px], each from photograph to photograph.
  Mistake scattered(double rows, double shift) const {
    return [=, h = height](int k, int, const Eigen::Vector2d& p) -> Eigen::Vector2d {
      std::mt19937_64 random(static_cast<unsigned>(k));
      std::normal_distribution<double> unit(0, 1);
      const double x = unit(random), y = unit(random);
      return p + (shift + rows * (p.y() / h - 0.5)) * Eigen::Vector2d(x, y);
    };
  }
};

/// One zoomed and one untouched case of each set always, the others with PLUMBLINE_LONG.
#define ONLY_WITH_LONG() \
  if (!std::getenv("PLUMBLINE_LONG")) GTEST_SKIP() << "with PLUMBLINE_LONG"

double from_the_middle_on(double factor, int k, int count) { return 2 * k >= count ? factor : 1; }

// ---- a grid of tags: marker_board

markers::MarkerBlock grid() {
  static const markers::MarkerBlock block = [] {
    markers::MarkerBlock made;
    std::map<int, int> marker_of;
    const detect::ArucoDetector detector(detect::builtin_dictionary("DICT_6X6_1000"), {});
    for (int k = 0; k < 42; ++k) {
      const std::string name = std::to_string(k) + ".jpg";
      const GreyImage image = read_grey_image(test::data_file("images/aruco_grid/aruco_data") / name);
      if (made.cameras.empty()) {
        made.cameras.emplace_back();
        made.cameras[0].camera.width = image.width, made.cameras[0].camera.height = image.height;
      }
      made.images.push_back({name, 0});
      for (const auto& tag : detector.detect(image)) {
        const auto [at, is_new] = marker_of.emplace(tag.id, static_cast<int>(made.markers.size()));
        if (is_new) made.markers.push_back({"DICT_6X6_1000", tag.id, 0.0375, std::nullopt});
        made.views.push_back({k, at->second, tag.corners, tag.covariances, tag.refined});
      }
    }
    return made;
  }();
  return block;
}

const Frame grid_frame{640, 480, {640, 480, 811.9, 812.5, 325, 247, 0.08, -0.2, 0, 0, 0}};

markers::MarkerResult grid_with(const Mistake& mistake, markers::MarkerBlock* used = nullptr) {
  markers::MarkerBlock block = grid();
  for (markers::MarkerView& view : block.views)
    for (Eigen::Vector2d& corner : view.corners) corner = mistake(view.image, 42, corner);
  if (used) *used = block;
  return markers::adjust_marker_block(block, {});
}

TEST(ChangedGrid, ASoundOneIsNot) {
  PLUMBLINE_REQUIRE_DATA("images/aruco_grid/aruco_data/0.jpg");
  const auto sound = grid_with([](int, int, const Eigen::Vector2d& p) { return p; });
  EXPECT_FALSE(sound.cameras[0].truth.change)
      << in_words(*sound.cameras[0].truth.change, sound.cameras[0].truth.evidence);
}

/// Warnings that speak of the camera, in one text; goes into the test's report.
std::string told(const std::string& mistake, const markers::MarkerResult& result) {
  std::string words;
  for (const std::string& warning : result.warnings) words += (words.empty() ? "" : " | ") + warning;
  testing::Test::RecordProperty(mistake, words);
  return words;
}

TEST(ChangedGrid, FromTheMiddleOnIsNamedAndDivided) {
  PLUMBLINE_REQUIRE_DATA("images/aruco_grid/aruco_data/0.jpg");
  markers::MarkerBlock block;
  const auto late = grid_with(grid_frame.zoomed([](int k, int n) { return from_the_middle_on(1.02, k, n); }), &block);
  EXPECT_THAT(told("zoom_late_2", late), testing::AllOf(HasSubstr("from 21.jpg on the principal distance is"),
                                                        HasSubstr("longer: focus or zoom")));
  ASSERT_TRUE(late.cameras[0].truth.change);
  EXPECT_NEAR(late.cameras[0].truth.change->by(0), 0.02, 0.008);
  const std::string two = as_two_cameras(block, {}, late, 0);
  RecordProperty("as_two", two);
  EXPECT_THAT(two, HasSubstr("they fit to 0.0"));
}

TEST(ChangedGrid, IsNamed) {
  ONLY_WITH_LONG();
  PLUMBLINE_REQUIRE_DATA("images/aruco_grid/aruco_data/0.jpg");
  EXPECT_THAT(
      told("zoom_late_5", grid_with(grid_frame.zoomed([](int k, int n) { return from_the_middle_on(1.05, k, n); }))),
      testing::AllOf(HasSubstr("from 21.jpg on the principal distance is"), HasSubstr("longer: focus or zoom")));
  EXPECT_THAT(told("drift_2", grid_with(grid_frame.zoomed([](int k, int n) { return 0.98 + 0.04 * k / (n - 1); }))),
              HasSubstr("from 0.jpg to 41.jpg, bit by bit, the principal distance is"));
  EXPECT_THAT(told("every_second_zoomed_5", grid_with(grid_frame.zoomed([](int k, int) { return k % 2 ? 1.05 : 1; }))),
              HasSubstr("in every second photograph"));
  EXPECT_THAT(told("every_fourth_zoomed_2", grid_with(grid_frame.zoomed([](int k, int) { return k % 4 ? 1 : 1.02; }))),
              testing::AllOf(HasSubstr("in every fourth photograph (0.jpg, 4.jpg"), HasSubstr("longer")));
  // The middle of this camera's image is nearly its principal point, and it was held either way: what is decentred
  // tells.
  EXPECT_THAT(told("every_second_turned", grid_with(grid_frame.every_second_turned())),
              testing::AllOf(HasSubstr("in every second photograph (0.jpg"), HasSubstr("turned by 180 degrees")));
  EXPECT_THAT(told("every_second_undistorted", grid_with(grid_frame.every_second_undistorted())),
              HasSubstr("in every second photograph"));
}

/// Another body, of another focal length, took a third of the photographs, in no order.
TEST(ChangedGrid, TwoCamerasInOneFolderAreNamed) {
  ONLY_WITH_LONG();
  PLUMBLINE_REQUIRE_DATA("images/aruco_grid/aruco_data/0.jpg");
  const Mistake zoomed = grid_frame.zoomed([](int k, int) { return k * k % 7 == 2 ? 1.25 : 1; });
  const auto two = grid_with([&](int k, int n, const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return zoomed(k, n, p) + (k * k % 7 == 2 ? Eigen::Vector2d(9, -6) : Eigen::Vector2d(0, 0));
  });
  EXPECT_THAT(told("two_cameras", two),
              testing::AnyOf(HasSubstr("the camera is another"), HasSubstr("photographs of another camera")));
}

/// Somebody put the tags elsewhere in the second half. They stand too close together to say that it is this.
TEST(ChangedGrid, RearrangedTagsAreNoBlock) {
  ONLY_WITH_LONG();
  PLUMBLINE_REQUIRE_DATA("images/aruco_grid/aruco_data/0.jpg");
  markers::MarkerBlock block = grid();
  const int count = static_cast<int>(block.markers.size());
  for (markers::MarkerView& view : block.views)
    if (view.image >= 21) view.marker = (view.marker * 7 + 3) % count;
  std::string words;
  try {
    words = told("rearranged", markers::adjust_marker_block(block, {}));
  } catch (const std::runtime_error& error) {
    RecordProperty("rearranged", words = error.what());
  }
  EXPECT_THAT(words, HasSubstr("do not calibrate 1 camera"));
}

TEST(ChangedGrid, WhatScattersIsInTheStandardDeviations) {
  ONLY_WITH_LONG();
  PLUMBLINE_REQUIRE_DATA("images/aruco_grid/aruco_data/0.jpg");
  for (const auto& [rows, shift] : {std::pair(6.0, 0.0), std::pair(0.0, 8.0)}) {
    const auto result = grid_with(grid_frame.scattered(rows, shift));
    EXPECT_THAT(told(rows > 0 ? "rows" : "principal_point", result), HasSubstr("photographs scatter"));
    const auto& camera = result.cameras[0];
    EXPECT_GT(camera.covariance(0, 0), 2 * camera.formal_covariance(0, 0));
    EXPECT_LT(std::abs(camera.camera.fx - 811.9), 3 * std::sqrt(camera.covariance(0, 0)));
  }
}

// ---- a ChArUco board: calibrate_camera

const std::vector<markers::CalibrationView>& board() {
  static const std::vector<markers::CalibrationView> views = [] {
    const auto pattern = detect::parse_board(
        "type: charuco\ncolumns: 8\nrows: 8\nsquare: 0.0254\nmarker: 0.01905\ndictionary: DICT_4X4_50\n", "board.yaml");
    std::vector<markers::CalibrationView> made;
    for (const auto& entry : std::filesystem::directory_iterator(test::data_file("images/charuco_lifecam_1280"))) {
      const auto seen = detect::find_board(read_grey_image(entry.path()), pattern);
      markers::CalibrationView view;
      view.path = entry.path().filename().string();
      for (const auto& p : seen.points) view.points.push_back({p.board, p.pixel, p.sigma});
      made.push_back(view);
    }
    std::sort(made.begin(), made.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
    return made;
  }();
  return views;
}

const Frame board_frame{1280, 720, {1280, 720, 1124, 1124, 645, 338, 0.13, -1.0, 1.9, 0, 0}};

std::vector<markers::CalibrationView> board_with(const Mistake& mistake) {
  auto views = board();
  for (size_t k = 0; k < views.size(); ++k)
    for (auto& point : views[k].points)
      point.pixel = mistake(static_cast<int>(k), static_cast<int>(views.size()), point.pixel);
  return views;
}

markers::CalibrationOptions bent() {
  markers::CalibrationOptions options;
  options.bend_sigma = 1e-3;
  return options;
}

std::string change_of(const char* name, const Mistake& mistake) {
  const auto c = markers::calibrate(board_with(mistake), 1280, 720, bent());
  const std::string words = c.truth.change ? in_words(*c.truth.change, c.truth.evidence) : "no change";
  testing::Test::RecordProperty(name, words + "; fx " + std::to_string(c.camera.fx) + " +- " +
                                          std::to_string(std::sqrt(c.covariance(0, 0))) + ", corners alone " +
                                          std::to_string(std::sqrt(c.formal_covariance(0, 0))));
  return words;
}

TEST(ChangedBoard, IsNamed) {
  PLUMBLINE_REQUIRE_DATA("images/charuco_lifecam_1280");
  const auto longer = testing::AllOf(HasSubstr("the principal distance is"), HasSubstr("% longer: focus or zoom"));
  EXPECT_EQ(change_of("sound", [](int, int, const Eigen::Vector2d& p) { return p; }), "no change");
  EXPECT_THAT(change_of("zoom_late_5", board_frame.zoomed([](int k, int n) { return from_the_middle_on(1.05, k, n); })),
              longer);
  EXPECT_THAT(change_of("every_second_turned", board_frame.every_second_turned()),
              HasSubstr("the principal point lies elsewhere"));
}

/// As small a zoom, or one that few photographs have, is within the scatter of this camera: it is not told, but the
/// standard deviations hold it.
TEST(ChangedBoard, WhatIsNotNamedIsInTheStandardDeviations) {
  ONLY_WITH_LONG();
  PLUMBLINE_REQUIRE_DATA("images/charuco_lifecam_1280");
  for (const auto& [name, factor] : {std::pair<const char*, std::function<double(int, int)>>(
                                         "zoom_late_2", [](int k, int n) { return from_the_middle_on(1.02, k, n); }),
                                     {"drift_2", [](int k, int n) { return 0.98 + 0.04 * k / (n - 1); }},
                                     {"every_second_zoomed_5", [](int k, int) { return k % 2 ? 1.05 : 1; }},
                                     {"every_fourth_zoomed_2", [](int k, int) { return k % 4 ? 1 : 1.02; }}}) {
    const Mistake mistake = board_frame.zoomed(factor);
    change_of(name, mistake);
    const auto c = markers::calibrate(board_with(mistake), 1280, 720, bent());
    EXPECT_GT(c.covariance(0, 0), 4 * c.formal_covariance(0, 0)) << name;
    EXPECT_LT(std::abs(c.camera.fx - 1124), 3 * std::sqrt(c.covariance(0, 0))) << name;
  }
}

/// Halves at random and by time, each calibrated with the covariance that camera.yaml would have: their differences
/// over it, where the corners alone make 13 of it.
TEST(ChangedBoard, HalvesOfASoundSetAgreeWithinWhatIsWritten) {
  ONLY_WITH_LONG();
  PLUMBLINE_REQUIRE_DATA("images/charuco_lifecam_1280");
  constexpr int splits = 12;
  double written = 0, formal = 0;
  for (int split = 0; split < splits; ++split) {
    auto views = board();
    if (split > 0) std::shuffle(views.begin(), views.end(), std::mt19937_64(static_cast<unsigned>(split)));
    const auto middle = views.begin() + static_cast<std::ptrdiff_t>(views.size() / 2);
    const auto a = markers::calibrate({views.begin(), middle}, 1280, 720, bent()),
               b = markers::calibrate({middle, views.end()}, 1280, 720, bent());
    Eigen::VectorXd d(9);
    for (Eigen::Index k = 0; k < 9; ++k) d(k) = a.camera.parameters()[k] - b.camera.parameters()[k];
    const auto over = [&](const Eigen::MatrixXd& covariance) { return d.dot(covariance.ldlt().solve(d)) / 9; };
    written += over(a.covariance + b.covariance) / splits;
    formal += over(a.formal_covariance + b.formal_covariance) / splits;
  }
  RecordProperty("formal", std::to_string(formal));
  RecordProperty("written", std::to_string(written));
  EXPECT_GT(formal, 2);
  EXPECT_GT(written, 0.35);
  EXPECT_LT(written, 1.5);
}

}  // namespace test_camera_changes
}  // namespace plumbline
