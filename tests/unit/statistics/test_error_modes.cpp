// Errors taken apart into heights, plan and motions of the block.
#include <gmock/gmock.h>

#include <cmath>
#include <map>

#include "base/statistics/error_modes.hpp"
#include "geometry/random.hpp"

namespace test_error_modes {

using namespace plumbline;
using namespace plumbline::statistics;

Eigen::VectorXd facade() {
  Random random(3);
  Eigen::VectorXd points(30);
  for (Eigen::Index i = 0; i < 10; ++i)
    points.segment<3>(3 * i) << random.uniform(0, 12), random.uniform(0, 1), random.uniform(0, 30);
  return points;
}

std::map<std::string, StatedError> modes_of(const Eigen::VectorXd& points, const Eigen::VectorXd& errors,
                                            const Eigen::MatrixXd& covariance = {}) {
  std::map<std::string, StatedError> modes;
  for (const ErrorMode& mode : error_modes(points, errors, covariance)) modes[mode.name] = mode.error;
  return modes;
}

double rms(const Eigen::VectorXd& errors) {
  return std::sqrt(errors.squaredNorm() / (static_cast<double>(errors.size()) / 3));
}

TEST(ErrorModes, EachMotionIsFoundWhole) {
  const Eigen::VectorXd points = facade();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < 10; ++i) centre += 0.1 * points.segment<3>(3 * i);
  const auto moved = [&](auto&& motion) {
    Eigen::VectorXd errors(30);
    for (Eigen::Index i = 0; i < 10; ++i) errors.segment<3>(3 * i) = motion(points.segment<3>(3 * i) - centre);
    return errors;
  };
  const std::map<std::string, Eigen::VectorXd> motions{
      {"scale", moved([](const Eigen::Vector3d& x) -> Eigen::Vector3d { return 1e-4 * x; })},
      {"turn", moved([](const Eigen::Vector3d& x) -> Eigen::Vector3d {
         return {-1e-4 * x.y(), 1e-4 * x.x(), 0};
       })},
      {"tilt", moved([](const Eigen::Vector3d& x) -> Eigen::Vector3d {
         return {1e-4 * x.z(), 0, -1e-4 * x.x()};
       })},
      {"shift", moved([](const Eigen::Vector3d&) -> Eigen::Vector3d {
         return {1e-3, 2e-3, -1e-3};
       })}};
  for (const auto& [name, errors] : motions)
    for (const auto& [mode, error] : modes_of(points, errors)) {
      if (mode == "heights" || mode == "plan") continue;
      EXPECT_NEAR(error.found, mode == name ? rms(errors) : 0, 1e-12) << name << " seen as " << mode;
    }
}

TEST(ErrorModes, HeightsAndPlanAreAllThereIs) {
  Random random(4);
  Eigen::VectorXd errors(30);
  for (double& e : errors) e = random.normal(1e-3);
  auto modes = modes_of(facade(), errors);
  EXPECT_NEAR(std::hypot(modes["heights"].found, modes["plan"].found), rms(errors), 1e-15);
}

/// Drawn from the covariance, NEES of each mode is chi-squared of its freedom; a scale stated four times too large
/// gives a sixteenth of it, and nothing in the other motions.
TEST(ErrorModes, NeesOfAModeSeesWhatIsWrongInIt) {
  const Eigen::VectorXd points = facade();
  Eigen::VectorXd scale(30);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < 10; ++i) centre += 0.1 * points.segment<3>(3 * i);
  for (Eigen::Index i = 0; i < 10; ++i) scale.segment<3>(3 * i) = points.segment<3>(3 * i) - centre;
  scale.normalize();
  const Eigen::MatrixXd own = 1e-8 * Eigen::MatrixXd::Identity(30, 30), stated = own + 1e-4 * scale * scale.transpose();
  Random random(9);
  std::map<std::string, double> nees, freedom;
  const int trials = 400;
  for (int k = 0; k < trials; ++k) {
    Eigen::VectorXd errors = 1e-2 / 4 * random.normal() * scale;
    for (double& e : errors) e += random.normal(1e-4);
    for (const auto& [mode, error] : modes_of(points, errors, stated))
      nees[mode] += error.nees, freedom[mode] += error.freedom;
  }
  EXPECT_EQ(freedom["tilt"], 2 * trials);
  EXPECT_NEAR(nees["scale"] / freedom["scale"], 1 / 16.0, 0.02);
  for (const char* mode : {"turn", "tilt", "shift"})
    EXPECT_NEAR(nees[mode] / freedom[mode], 1, 4 * std::sqrt(2 / freedom[mode])) << mode;
}

TEST(ErrorModes, WhatThePointsCannotShowIsLeftOut) {
  const Eigen::VectorXd one = Eigen::Vector3d(1, 2, 3), errors = Eigen::Vector3d(1e-3, 0, 0);
  EXPECT_EQ(modes_of(one, errors).size(), 3u) << "heights, plan and shift";
  Eigen::VectorXd upright(6), two(6);
  upright << 1, 2, 0, 1, 2, 9;
  two.setZero();
  EXPECT_EQ(modes_of(upright, two).count("turn"), 0u) << "about the line they stand on";
  EXPECT_EQ(modes_of(upright, two).count("tilt"), 1u);
}

}  // namespace test_error_modes
