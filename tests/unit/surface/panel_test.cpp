// What points say of a panel where not all of them are its own.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {
namespace panel_test {

const PanelFace kFace{"P", facade_plane({3, 4, 5}, {0, -1, 0}), 1.2, 0.9};

/// Points every 10 mm with 0.1 mm of noise at the height of (u, v).
MeasuredTile points_at(const std::function<double(double, double)>& height) {
  MeasuredTile tile;
  tile.centre = kFace.plane.origin;
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 1e-4);
  for (double u = -0.595; u < 0.6; u += 0.01)
    for (double v = -0.445; v < 0.45; v += 0.01) {
      const Eigen::Vector3d at = kFace.plane.world({u, v, height(u, v) + noise(random)});
      tile.points.push_back({(at - tile.centre).cast<float>(), 1e-4f});
    }
  return tile;
}

TEST(Panel, WhatCoversMostOfItIsNotTakenForIt) {
  // A board 20 mm before the panel leaves 18 % of it to be seen: the surface of the board is not the panel's.
  const auto covered = points_at([](double u, double) { return u < 0.38 ? 0.022 : 0.002; });
  const PanelSurface panel = measure_panel(kFace, {covered}, {});
  EXPECT_NE(panel.not_measured.find("lies 20.0 mm behind"), std::string::npos)
      << panel.not_measured << " " << panel.plane(0);
  EXPECT_NE(panel.not_measured.find("before the panel"), std::string::npos) << panel.not_measured;
}

TEST(Panel, WhatStandsBeforeAPartOfItDoesNotMoveIt) {
  const auto partly = points_at([](double u, double) { return u < -0.42 ? 0.022 : 0.002; });
  const PanelSurface panel = measure_panel(kFace, {partly}, {});
  ASSERT_EQ(panel.not_measured, "");
  EXPECT_NEAR(panel.plane(0), 0.002, 1e-4);
  ASSERT_FALSE(panel.flatness.empty());
  EXPECT_GT(panel.flatness[0].with_outlying, 0.005);
}

TEST(Panel, ADentIsStillOne) {
  const auto dented = points_at([](double u, double v) { return std::hypot(u, v) < 0.12 ? -0.004 : 0.002; });
  const PanelSurface panel = measure_panel(kFace, {dented}, {});
  ASSERT_EQ(panel.not_measured, "");
  EXPECT_NEAR(panel.plane(0), 0.002, 1e-4);
  EXPECT_GT(panel.flatness[1].with_outlying, 0.005);
}

/// A cloud that was exported together with itself.
TEST(Panel, PointsThatStandTwiceSayNothingNew) {
  const auto once = points_at([](double, double) { return 0.002; });
  MeasuredTile twice = once;
  twice.points.insert(twice.points.end(), once.points.begin(), once.points.end());
  const PanelSurface of_once = measure_panel(kFace, {once}, {}), of_twice = measure_panel(kFace, {twice}, {}),
                     of_both = measure_panel(kFace, {once, once}, {});
  EXPECT_LT(of_once.repeated, 1.01);
  EXPECT_NEAR(of_twice.repeated, 2, 0.01);
  EXPECT_NEAR(of_both.repeated, 2, 0.01) << "as two scans of one file";
  EXPECT_NEAR(of_twice.plane_random(0, 0) / of_once.plane_random(0, 0), 1, 0.02);
  EXPECT_NEAR(of_twice.flatness[1].noise_mean / of_once.flatness[1].noise_mean, 1, 0.02);
}

/// A design's box says nothing of a panel's form: what is folded, corrugated or a step is no bow.
TEST(Panel, WhatIsNoPlaneIsNotMeasuredAsOne) {
  const std::function<double(double, double)> forms[] = {
      [](double u, double) { return 0.03 - 0.17 * std::abs(u); },                   // folded by 20°
      [](double u, double) { return std::fmod(u + 6, 0.2) < 0.1 ? 0.0 : -0.035; },  // trapezoidal sheet
      [](double u, double) { return -0.06 * std::sin(3 * M_PI * u / 1.2); }};       // a wave
  for (const auto& form : forms) {
    const PanelSurface panel = measure_panel(kFace, {points_at(form)}, {});
    EXPECT_NE(panel.not_measured, "") << panel.plane.transpose() << " rms " << panel.rms;
  }
}

}  // namespace panel_test
}  // namespace plumbline::surface
