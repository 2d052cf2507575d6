// Calibrations of cameras whose truth is known.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

#include "geometry/statistics.hpp"
#include "photo/markers/calibration.hpp"
#include "photo/markers/marker_block.hpp"
#include "photo/markers/repeated_sights.hpp"
#include "plumbline/stop.hpp"
#include "scene.hpp"
#include "test_support.hpp"

namespace plumbline::markers {
namespace test_board_calibration {

using testing::HasSubstr;

std::vector<CalibrationView> board_views(double sigma, double bend, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, 1);
  std::vector<CalibrationView> views;
  for (int k = 0; k < 14; ++k) {
    const RigidTransform pose =
        look({0.25 * std::cos(1.1 * k) + 0.12, -0.1 + 0.3 * std::sin(1.7 * k), 0.42 + 0.02 * (k % 4)},
             {0.12 + 0.05 * (k % 3 - 1), -0.08, 0}, 0.4 * k);
    CalibrationView view;
    view.path = std::to_string(k);
    for (int r = 0; r < 7; ++r)
      for (int c = 0; c < 10; ++c) {
        const Eigen::Vector3d board(0.025 * c, -0.025 * r, 0);
        const double x = (board.x() - 0.1125) / 0.1125;
        const auto pixel = project(true_camera(), pose * (board + Eigen::Vector3d(0, 0, bend * (1 - x * x))));
        if (!pixel || pixel->minCoeff() < 0 || pixel->x() > 1599 || pixel->y() > 1199) continue;
        view.points.push_back({board, *pixel + sigma * Eigen::Vector2d(noise(random), noise(random)), 0.1});
      }
    views.push_back(view);
  }
  return views;
}

/// Ctrl-C was answered at the end, after half a minute: no attempt of the calibration takes it for a failure of its own
/// and tries the next.
TEST(Calibration, StopsWhereverItIs) {
  struct Count {
    int asked, limit;
  };
  const auto views = board_views(0.15, 4e-4, 7);
  for (int limit = 1; limit < 3000; limit *= 3) {
    Count count{0, limit};
    const StopScope scope(
        [](const void* of) {
          auto& c = *static_cast<Count*>(const_cast<void*>(of));
          return ++c.asked > c.limit;
        },
        &count);
    EXPECT_THROW(calibrate(views, 1600, 1200, {}), Stopped) << limit;
  }
}

TEST(Calibration, RecoversCameraAndBendAndStatesTheirUncertainty) {
  CalibrationOptions options;
  options.bend_sigma = 1e-3;
  const Calibration c = calibrate(board_views(0.15, 4e-4, 7), 1600, 1200, options);
  const auto found = c.camera.parameters(), truth = true_camera().parameters();
  for (size_t k = 0; k < found.size(); ++k) {
    const double sigma = std::sqrt(c.covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)));
    EXPECT_GT(sigma, 0);
    EXPECT_LT(std::abs(found[k] - truth[k]), 4 * sigma) << InteriorOrientation::names_of(LensModel::brown)[k];
  }
  EXPECT_NEAR(c.bend_x, 4e-4, 4 * c.bend_x_sigma);
  EXPECT_NEAR(c.sigma, 0.15, 0.015);
  const auto u = projection_uncertainty(c.camera, c.covariance, 9, 7);
  EXPECT_LT(u[31], u[0]) << "the middle is surer than a corner";
  // A change of the camera that is nothing but a rotation leaves hardly a difference.
  BrownCamera turned = true_camera();
  turned.cx += 0.5;
  EXPECT_LT(projection_difference(true_camera(), turned, 9, 7)[31], 0.2);
}

/// The same sixteen photographs saved three times made the camera better known by a fourth.
TEST(Calibration, ABurstIsTold) {
  const auto first = board_views(0.15, 0, 3), again = board_views(0.15, 0, 4);  // of the same poses
  EXPECT_EQ(repeated_sights(first), "");
  auto views = first;
  views.insert(views.end(), again.begin(), again.begin() + 5);
  EXPECT_THAT(repeated_sights(views),
              testing::StartsWith("5 of the 19 photographs show the board from where another one does"));
}

TEST(Calibration, SaysWhatIsMissing) {
  auto views = board_views(0.1, 0, 1);
  views.resize(2);
  EXPECT_THROW(calibrate(views, 1600, 1200, {}), std::runtime_error);
}

/// Photographs from one place straight at the board do not tell the principal distance, and noise then decides.
TEST(Calibration, OfPhotographsThatLookStraightSaysSo) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 1);
  std::vector<CalibrationView> views;
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector3d above(0.1 + 0.01 * (k % 3), -0.08 + 0.01 * (k % 4), 0);
    const RigidTransform pose = look(above + Eigen::Vector3d(0, 0, 0.42), above, 0.01 * k);
    CalibrationView view{std::to_string(k), {}};
    for (int i = 0; i < 48; ++i) {
      const Eigen::Vector3d board(0.025 * (i % 8), -0.025 * (i / 8), 0);
      const Eigen::Vector2d pixel = *project(true_camera(), pose * board);
      view.points.push_back({board, pixel + 1.5 * Eigen::Vector2d(noise(random), noise(random)), 0.1});
    }
    views.push_back(view);
  }
  try {
    calibrate(views, 1600, 1200, {});
    ADD_FAILURE() << "it converged";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("of straight, which does not tell the principal distance"));
  }
}

/// Changes drawn from what a prior and an adjustment of it allow, with correlations of 0.99: the statistic is
/// chi-squared of its degrees of freedom, and a change that no single parameter finds large is found against the
/// correlation.
TEST(CalibrationTest, IsChiSquaredOfCorrelatedParametersTogether) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> unit(0, 1);
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(9, 9);
  prior.diagonal() << 4, 4, 9, 9, 1e-4, 1e-2, 0, 1e-8, 1e-8;
  prior(0, 1) = prior(1, 0) = 0.99 * 4, prior(4, 5) = prior(5, 4) = -0.98 * 1e-3;
  // The photographs: a matrix of information of their own over the free parameters.
  const std::vector<int> free = {0, 1, 2, 3, 4, 5, 7, 8};
  Eigen::MatrixXd information = prior(free, free).inverse().eval();
  Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(8, 8);
  for (Eigen::Index k = 0; k < 8; ++k) {
    Eigen::VectorXd row(8);
    for (Eigen::Index j = 0; j < 8; ++j) row(j) = unit(random) / std::sqrt(prior(free[j], free[j]));
    seen += 20 * row * row.transpose();
  }
  const Eigen::MatrixXd after = (information + seen).inverse();
  Eigen::MatrixXd adjusted = Eigen::MatrixXd::Zero(9, 9);
  for (size_t i = 0; i < 8; ++i)
    for (size_t j = 0; j < 8; ++j)
      adjusted(free[i], free[j]) = after(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  const Eigen::MatrixXd root = (prior - adjusted)(free, free).llt().matrixL();
  double sum = 0, freedom = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Eigen::VectorXd drawn(8);
    for (Eigen::Index k = 0; k < 8; ++k) drawn(k) = unit(random);
    Eigen::VectorXd change = Eigen::VectorXd::Zero(9);
    change(free) = root * drawn;
    const auto test = test_calibration(change, prior, adjusted);
    EXPECT_GE(test.freedom, 6);
    sum += test.statistic, freedom += test.freedom;
  }
  EXPECT_GT(sum, chi_squared_quantile(0.001, freedom));
  EXPECT_LT(sum, chi_squared_quantile(0.999, freedom));
  Eigen::VectorXd against = Eigen::VectorXd::Zero(9);
  against(0) = 2, against(1) = -2;  // one standard deviation each, but fx and fy go together
  const auto test = test_calibration(against, prior, adjusted);
  EXPECT_GT(test.statistic, chi_squared_quantile(0.9995, test.freedom));
}

}  // namespace test_board_calibration
}  // namespace plumbline::markers
