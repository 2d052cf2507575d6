// What points say of a panel where not all of them are its own.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "surface/dense/joint_pairs.hpp"
#include "surface/dense/joint_places.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {
namespace test_panel {

const PanelFace kFace{"P", facade_plane({3, 4, 5}, {0, -1, 0}), 1.2, 0.9};

/// Points every 10 mm with 0.1 mm of noise at the height of (u, v).
MeasuredTile points_at(const std::function<double(double, double)>& height, const PanelFace& face = kFace,
                       std::uint64_t seed = 3) {
  MeasuredTile tile;
  tile.centre = face.plane.origin;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, 1e-4);
  for (double u = -0.595; u < 0.6; u += 0.01)
    for (double v = -0.445; v < 0.45; v += 0.01) {
      const Eigen::Vector3d at = face.plane.world({u, v, height(u, v) + noise(random)});
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
  ASSERT_FALSE(panel.before.empty()) << "joints beside it are not measured there";
  for (const Eigen::Vector2d& middle : panel.before) EXPECT_LT(middle.x(), -0.4);
}

TEST(Panel, ADentIsStillOne) {
  const auto dented = points_at([](double u, double v) { return std::hypot(u, v) < 0.12 ? -0.004 : 0.002; });
  const PanelSurface panel = measure_panel(kFace, {dented}, {});
  ASSERT_EQ(panel.not_measured, "");
  EXPECT_NEAR(panel.plane(0), 0.002, 1e-4);
  EXPECT_GT(panel.flatness[1].with_outlying, 0.005);
  EXPECT_TRUE(panel.before.empty());
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

/// Edges that are bent back are no bow: what the fitted surface lacks there is in the step's standard deviation.
TEST(Panel, AStepIsNoSurerThanTheFittedSurfaceFitsAtTheEdge) {
  const auto bent = [](double r) {  // third degree: neither plane nor bow
    return [r](double u, double) { return r * 0.5 * (5 * std::pow(u / 0.6, 3) - 3 * u / 0.6); };
  };
  std::vector<PanelFace> faces(2, kFace);
  faces[0].id = "left", faces[1].id = "right";
  faces[1].plane.origin = kFace.plane.world({kFace.width + 0.012, 0, 0});
  for (const double r : {0.0, 0.0002, 0.0004, 0.0008}) {
    const std::vector<PanelSurface> surfaces = {measure_panel(faces[0], {points_at(bent(r), faces[0], 1)}, {}),
                                                measure_panel(faces[1], {points_at(bent(r), faces[1], 2)}, {})};
    const std::vector<Joint> joints = joints_of(faces);
    ASSERT_EQ(joints.size(), 1U);
    const auto [a, b] = edge_lines(joints[0], faces, surfaces);
    JointStation station;
    station.along = 0.2;
    add_step(station, a, b, joints[0].plane, -0.006, 0.006);
    EXPECT_LT(std::abs(station.step + 2 * r), 3 * station.step_sigma) << station.step << " of " << -2 * r;
    EXPECT_LT(station.step_sigma, 5e-5 + 2 * r) << r;
  }
}

/// The last 60 mm of an edge, by more than the fit takes for noise.
TEST(Panel, AStepAtAnEdgeThatIsBentSharplyIsUnsure) {
  const auto bent = [](double u, double) { return 0.003 * std::max(0.0, (u - 0.54) / 0.06); };
  const PanelSurface panel = measure_panel(kFace, {points_at(bent)}, {});
  ASSERT_EQ(panel.not_measured, "");
  EXPECT_GT(panel.edge_misfit(1), 0.001);
  EXPECT_LT(panel.edge_misfit(0), 1e-4);
}

/// A tag's plate 30 mm before the panel at a part of its edge is no bent edge.
TEST(Panel, WhatStandsBeforeAPartOfAnEdgeLeavesItsHeightSure) {
  const auto plated = [](double u, double v) { return u > 0.46 && std::abs(v) < 0.1 ? 0.03 : 0.0; };
  const PanelSurface panel = measure_panel(kFace, {points_at(plated)}, {});
  ASSERT_EQ(panel.not_measured, "");
  EXPECT_LT(panel.edge_misfit(1), 1e-4);
  const auto covered = [](double u, double v) { return u > 0.46 && std::abs(v) < 0.35 ? 0.03 : 0.0; };
  EXPECT_GT(measure_panel(kFace, {points_at(covered)}, {}).edge_misfit(1), 0.005) << "nobody knows the rest of it";
}

/// Where a cell has one point that is hardly known, the point would be the whole cell.
TEST(Panel, PointsThatAreHardlyKnownAreNoUnevenness) {
  MeasuredTile tile;
  const MeasuredTile all = points_at([](double, double) { return 0.0; });
  const auto in = [](const Eigen::Vector3d& at, double u, double v) {
    return std::abs(at.x() - u) < 0.06 && std::abs(at.y() - v) < 0.06;
  };
  tile.centre = all.centre;
  for (const MeasuredPoint& point : all.points) {
    const Eigen::Vector3d at = kFace.plane.local(all.centre + point.offset.cast<double>());
    if (!in(at, 0.1, 0) && !in(at, 0.54, 0.2)) tile.points.push_back(point);
  }
  for (const auto& [u, v] : {std::pair{0.1, 0.0}, {0.12, 0.03}, {0.57, 0.2}, {0.57, 0.24}})
    tile.points.push_back({(kFace.plane.world({u, v, -0.009}) - tile.centre).cast<float>(), 0.0019F});
  const PanelSurface panel = measure_panel(kFace, {tile}, {});
  ASSERT_EQ(panel.not_measured, "");
  EXPECT_GT(panel.coverage, 0.9);
  for (const Gap& gap : panel.flatness) EXPECT_LT(gap.gap, 0.0005) << gap.length;
  EXPECT_LT(panel.edge_misfit.maxCoeff(), 1e-4);
}

/// Waves of a sheet, or a scanner's own errors, are the same for many neighbouring points.
TEST(Panel, WhatIsOffTogetherDoesNotAverageOutPointByPoint) {
  double of_bow = 0, flat = 0;
  constexpr int trials = 12;
  for (int trial = 0; trial < trials; ++trial) {
    std::mt19937_64 random(static_cast<std::uint64_t>(trial));
    std::uniform_real_distribution<double> phase(0, 2 * M_PI);
    const double a = phase(random), b = phase(random), c = phase(random);
    const auto waves = [&](double u, double v) {
      return 3e-4 * (std::sin(2 * M_PI * u / 0.41 + a) + std::sin(2 * M_PI * v / 0.37 + b) +
                     std::sin(2 * M_PI * (u + v) / 0.52 + c));
    };
    const PanelSurface panel = measure_panel(kFace, {points_at(waves, kFace, 40 + trial)}, {});
    ASSERT_EQ(panel.not_measured, "");
    of_bow += std::pow(panel.form(3), 2) / panel.form_covariance()(3, 3) / trials;
    const PanelSurface plane =
        measure_panel(kFace, {points_at([](double, double) { return 0.0; }, kFace, 90 + trial)}, {});
    flat += std::pow(plane.form(3), 2) / plane.form_covariance()(3, 3) / trials;
  }
  EXPECT_LT(of_bow, 3);
  EXPECT_GT(flat, 0.3) << "noise alone stays as it is stated";
}

TEST(Panel, WhatIsSmallerThanACellIsSeenInItsScatter) {
  const PanelSurface corrugated =
      measure_panel(kFace, {points_at([](double u, double) { return 2e-4 * std::sin(2 * M_PI * u / 0.05); })}, {});
  ASSERT_EQ(corrugated.not_measured, "");
  EXPECT_GT(corrugated.hidden, 3e-4) << "0.4 mm, and of the cell with most";
  EXPECT_LT(corrugated.hidden, 6.5e-4);
  EXPECT_EQ(measure_panel(kFace, {points_at([](double, double) { return 0.0; })}, {}).hidden, 0);
}

/// A scanner of 0.1 mm for which 2 mm are stated, as nobody who states nothing says otherwise.
TEST(Panel, ANoiseThatIsStatedTooLargeHidesNoWave) {
  PanelOptions scan;
  scan.independent = true;
  const auto stated = [&](const std::function<double(double, double)>& height) {
    auto tile = points_at(height);
    for (MeasuredPoint& point : tile.points) point.sigma = 2e-3f;
    return tile;
  };
  // Along a valley neighbours differ by their noise alone.
  const auto wavy = [](double u, double) { return 0.00275 * std::sin(2 * M_PI * u / 0.035); };
  EXPECT_NEAR(measure_panel(kFace, {stated(wavy)}, scan).hidden, 0.0055, 0.0012);
  EXPECT_EQ(measure_panel(kFace, {stated([](double, double) { return 0.0; })}, scan).hidden, 0);
  EXPECT_EQ(measure_panel(kFace, {stated(wavy)}, {}).hidden, 0) << "facets share pixels: what is stated counts";
  auto twice = stated([](double, double) { return 0.0; });
  const auto once = twice.points;
  twice.points.insert(twice.points.end(), once.begin(), once.end());
  EXPECT_EQ(measure_panel(kFace, {twice}, scan).hidden, 0) << "a point that stands there twice is no neighbour";
}

/// Cells of few points: the least of two estimates of their noise is low, and 1400 cells are many.
TEST(Panel, WhiteNoiseIsNoWaveWhereCellsHaveFewPoints) {
  PanelOptions scan;
  scan.independent = true, scan.cell = 0.04;
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    EXPECT_EQ(measure_panel(kFace, {points_at([](double, double) { return 0.0; }, kFace, seed)}, scan).hidden, 0)
        << seed;
}

/// Grooves of 12 mm every 0.1 m are fewer than half of a cell: they do not count in the surface, and are of the panel.
TEST(Panel, GroovesThatTheSurfaceLeavesOutAreHiddenInIt) {
  PanelOptions scan;
  scan.independent = true;
  const auto face = [](double u, double) { return std::fmod(u + 10, 0.1) < 0.012 ? -0.006 : 0.0; };
  EXPECT_NEAR(measure_panel(kFace, {points_at(face)}, scan).hidden, 0.006, 2e-4);
  const auto bolts = [](double u, double v) {
    return std::hypot(std::fmod(u + 10, 0.1) - 0.05, std::fmod(v + 10, 0.1) - 0.05) < 0.012 ? 0.006 : 0.0;
  };
  EXPECT_EQ(measure_panel(kFace, {points_at(bolts)}, scan).hidden, 0) << "what stands before a panel is not its own";
}

}  // namespace test_panel
}  // namespace plumbline::surface
