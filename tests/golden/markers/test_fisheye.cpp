// The fisheye's model beside OpenCV's, which has the same formula in other hands: projection, calibration of the same
// corners, and photographs of a board that others took with a fisheye.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <random>

#include "photo/detect/board.hpp"
#include "photo/images/grey_image.hpp"
#include "photo/markers/calibration.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_fisheye {

InteriorOrientation wide_camera() {
  InteriorOrientation c;
  c.lens = LensModel::fisheye, c.width = 1600, c.height = 1200;
  c.fx = 520, c.fy = 522, c.cx = 809, c.cy = 591, c.k1 = 0.035, c.k2 = -0.014, c.k3 = 0.006, c.k4 = -0.0012;
  return c;
}

std::array<double, 4> coefficients_of(const InteriorOrientation& c) { return {c.k1, c.k2, c.k3, c.k4}; }

TEST(Fisheye, ProjectsAsOpenCV) {
  const InteriorOrientation c = wide_camera();
  std::vector<cv::Point3d> points;
  for (double angle = 2; angle < 85; angle += 7)
    for (double turn = 0; turn < 6; turn += 0.9) {
      const double a = angle * std::numbers::pi / 180;
      points.emplace_back(2 * std::sin(a) * std::cos(turn), 2 * std::sin(a) * std::sin(turn), 2 * std::cos(a));
    }
  std::vector<cv::Point2d> theirs;
  const auto k = coefficients_of(c);
  cv::fisheye::projectPoints(points, theirs, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0),
                             cv::Matx33d(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1),
                             cv::Mat(4, 1, CV_64F, (void*)k.data()));
  for (size_t i = 0; i < points.size(); ++i) {
    const auto ours = project(c, {points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(ours);
    EXPECT_NEAR(ours->x(), theirs[i].x, 1e-9) << i;
    EXPECT_NEAR(ours->y(), theirs[i].y, 1e-9) << i;
  }
}

/// A board of 9 × 7 points in `count` places all over the image, corners of 0.1 px.
std::vector<markers::CalibrationView> drawn_views(const InteriorOrientation& camera, int count) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.1);
  std::vector<markers::CalibrationView> views;
  for (int v = 0; v < count; ++v) {
    // Not further: OpenCV's start fails of boards that reach 80 degrees off the axis.
    const double across = 0.6 * ((v % 5) / 2.0 - 1), up = 0.45 * ((v / 5 % 4) / 1.5 - 1);
    const Eigen::Quaterniond aside =
        Eigen::AngleAxisd(across, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(up, Eigen::Vector3d::UnitX());
    const Eigen::Quaterniond tilt(
        Eigen::AngleAxisd(0.5, Eigen::Vector3d(std::cos(2.4 * v), std::sin(2.4 * v), 0.2 * v).normalized()));
    markers::CalibrationView view;
    view.path = "photo" + std::to_string(100 + v) + ".jpg";
    for (int k = 0; k < 63; ++k) {
      const Eigen::Vector3d board(0.03 * (k % 9), 0.03 * (k / 9), 0);
      const Eigen::Vector3d p = aside * (tilt * (board - Eigen::Vector3d(0.12, 0.09, 0)) + Eigen::Vector3d(0, 0, 0.22));
      const auto pixel = project(camera, p);
      if (!pixel || pixel->minCoeff() < 0 || pixel->x() > camera.width - 1 || pixel->y() > camera.height - 1) continue;
      view.points.push_back({board, *pixel + Eigen::Vector2d(noise(random), noise(random)), 0.1});
    }
    if (view.points.size() > 20) views.push_back(view);
  }
  return views;
}

TEST(Fisheye, CalibratesAsOpenCV) {
  const InteriorOrientation truth = wide_camera();
  const auto views = drawn_views(truth, 20);
  ASSERT_GE(views.size(), 16u);
  markers::CalibrationOptions options;
  options.lens = LensModel::fisheye, options.reject_above = 0;
  const markers::Calibration ours = markers::calibrate(views, truth.width, truth.height, options);
  std::vector<std::vector<cv::Point3d>> board;
  std::vector<std::vector<cv::Point2d>> seen;
  for (const auto& view : views) {
    board.emplace_back(), seen.emplace_back();
    for (const auto& p : view.points)
      board.back().emplace_back(p.board.x(), p.board.y(), 0), seen.back().emplace_back(p.pixel.x(), p.pixel.y());
  }
  cv::Mat matrix = (cv::Mat_<double>(3, 3) << 500, 0, 800, 0, 500, 600, 0, 0, 1), k = cv::Mat::zeros(4, 1, CV_64F);
  std::vector<cv::Mat> rotations, translations;
  const double rms = cv::fisheye::calibrate(
      board, seen, cv::Size(truth.width, truth.height), matrix, k, rotations, translations,
      cv::fisheye::CALIB_USE_INTRINSIC_GUESS | cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW,
      cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-10));
  EXPECT_NEAR(ours.rms, rms, 1e-5);
  const double theirs[] = {matrix.at<double>(0, 0), matrix.at<double>(1, 1), matrix.at<double>(0, 2),
                           matrix.at<double>(1, 2), k.at<double>(0),         k.at<double>(1),
                           k.at<double>(2),         k.at<double>(3)};
  const auto values = ours.camera.parameters(), true_values = truth.parameters();
  for (int i = 0; i < 8; ++i) {
    const auto at = static_cast<size_t>(i);
    const double sigma = std::sqrt(ours.formal_covariance(i, i));
    ASSERT_GT(sigma, 0);
    EXPECT_NEAR(values[at], theirs[i], 0.02 * sigma) << ours.camera.names()[at];
    EXPECT_NEAR(values[at], true_values[at], 3.5 * sigma) << ours.camera.names()[at];
  }
}

/// A GoPro Hero3+ before a board of 15 × 9 corners of 26 mm, of which OpenCV's own sample program made nothing.
TEST(Fisheye, IsRecognisedInPhotographsOfOthers) {
  const std::string folder = "images/gopro_fisheye";
  PLUMBLINE_REQUIRE_DATA(folder + "/3D_L0478.JPG");
  const detect::Board board =
      detect::parse_board("type: chessboard\ncolumns: 15\nrows: 9\nsquare: 0.026\n", "board.yaml");
  std::vector<markers::CalibrationView> views;
  int width = 0, height = 0;
  for (const char* name : {"0478", "0480", "0485", "0487", "0489", "0491", "0493", "0497", "0500", "0503"}) {
    const GreyImage image = read_grey_image(test::data_file(folder) / ("3D_L" + std::string(name) + ".JPG"));
    width = image.width, height = image.height;
    markers::CalibrationView view;
    view.path = name;
    for (const auto& p : detect::find_board(image, board).points) view.points.push_back({p.board, p.pixel, p.sigma});
    if (view.points.size() > 50) views.push_back(view);
  }
  ASSERT_GE(views.size(), 8u);
  markers::CalibrationOptions bent;
  bent.bend_sigma = 1e-3;
  const auto found = markers::calibrate_lens_and_camera(views, width, height, bent);
  EXPECT_EQ(found.calibration.camera.lens, LensModel::fisheye);
  EXPECT_TRUE(found.lenses.held_out);
  EXPECT_LT(found.lenses.fisheye, 0.5 * found.lenses.brown);
  EXPECT_LT(found.calibration.rms, 0.2);
}

}  // namespace test_fisheye
}  // namespace plumbline
