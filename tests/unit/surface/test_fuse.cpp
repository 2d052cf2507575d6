// Several sources of one face: what they agree on with true errors, holes where they contradict.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "surface/dense/fuse.hpp"

namespace plumbline::surface {
namespace test_fuse {

const PanelFace kFace{"P", facade_plane({3, 4, 5}, {0, -1, 0}), 1.0, 0.8};
constexpr double kNoise = 5e-4, kCommon = 1e-3;

/// Points every 20 mm at the height of (u, v), with noise; stated to be off by kCommon out of the face as a whole.
MeasuredTile source_of(const std::function<double(double, double)>& height, unsigned seed, double left = -0.5) {
  MeasuredTile tile;
  tile.centre = kFace.plane.origin;
  tile.factor = Eigen::MatrixXd::Zero(6, 1);
  tile.factor.block<3, 1>(0, 0) = kCommon * kFace.plane.axes.col(2);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, kNoise);
  for (double u = left + 0.01; u < 0.5; u += 0.02)
    for (double v = -0.39; v < 0.4; v += 0.02) {
      const Eigen::Vector3d at = kFace.plane.world({u, v, height(u, v) + noise(random)});
      tile.points.push_back({(at - tile.centre).cast<float>(), static_cast<float>(kNoise)});
    }
  return tile;
}

std::function<double(double, double)> at(double height) {
  return [height](double, double) { return height; };
}

TEST(Fuse, WhatSeveralAgreeOnIsKnownBetterAndKeepsItsSystematicPart) {
  FuseOptions independent;
  independent.may_share_errors = false;
  const std::vector<std::vector<MeasuredTile>> sources = {{source_of(at(0.004), 1)}, {source_of(at(0.0055), 2)}};
  const FusedFace fused = fuse_face({kFace}, 0, sources, {1, 1}, 0.1, independent);
  EXPECT_EQ(fused.counts.contradicted, 0);
  EXPECT_EQ(fused.counts.agreed, 20 * 16);
  const PanelSurface panel = measure_panel(kFace, fused.tiles, {});
  ASSERT_EQ(panel.not_measured, "");
  EXPECT_NEAR(panel.plane(0), 0.00475, 5e-5);
  EXPECT_NEAR(std::sqrt(panel.plane_systematic(0, 0)), kCommon / std::sqrt(2.0), 1e-5) << "two of them, independent";
  const FusedFace shared = fuse_face({kFace}, 0, sources, {1, 1}, 0.1, {});
  EXPECT_NEAR(std::sqrt(measure_panel(kFace, shared.tiles, {}).plane_systematic(0, 0)), kCommon, 1e-5)
      << "of sources that may share their errors it is no smaller than of one";
}

TEST(Fuse, ErrorsOfTheMeanAreThoseStated) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> common(0, kCommon);
  constexpr int trials = 60;
  double independent = 0, alike = 0;
  FuseOptions apart;
  apart.may_share_errors = false;
  for (unsigned i = 0; i < trials; ++i) {
    const double first = common(random), second = common(random);
    const auto nees = [&](double a, double b, const FuseOptions& options) {
      const FusedFace fused =
          fuse_face({kFace}, 0, {{source_of(at(a), 2 * i)}, {source_of(at(b), 2 * i + 1)}}, {1, 1}, 0.1, options);
      const PanelSurface panel = measure_panel(kFace, fused.tiles, {});
      EXPECT_EQ(panel.not_measured, "");
      return std::pow(panel.plane(0), 2) / panel.plane_covariance()(0, 0) / trials;
    };
    independent += nees(first, second, apart), alike += nees(first, first, {});
  }
  // 60 degrees of freedom: 99 % within 0.59 and 1.53.
  EXPECT_GT(independent, 0.59);
  EXPECT_LT(independent, 1.53);
  EXPECT_GT(alike, 0.59);
  EXPECT_LT(alike, 1.53);
}

TEST(Fuse, ContradictionsAreHolesAndAMajorityHolds) {
  const auto dent = [](double u, double) { return u > 0.3 ? 0.03 : 0.004; };
  const FusedFace two = fuse_face({kFace}, 0, {{source_of(at(0.004), 1)}, {source_of(dent, 2)}}, {1, 1}, 0.1, {});
  EXPECT_EQ(two.counts.contradicted, 4 * 16) << "nobody knows which of two is right";
  EXPECT_EQ(two.counts.agreed, 16 * 16);
  for (const MeasuredTile& tile : two.tiles)
    for (const MeasuredPoint& point : tile.points) EXPECT_LT(kFace.plane.local(tile.at(point)).z(), 0.01);
  const FusedFace three = fuse_face(
      {kFace}, 0, {{source_of(at(0.004), 1)}, {source_of(dent, 2)}, {source_of(at(0.004), 3)}}, {1, 1, 1}, 0.1, {});
  EXPECT_EQ(three.counts.contradicted, 0);
  for (const MeasuredTile& tile : three.tiles)
    for (const MeasuredPoint& point : tile.points) EXPECT_LT(kFace.plane.local(tile.at(point)).z(), 0.01);
}

TEST(Fuse, WhatOneHasAloneStaysAndWhatNobodyHasIsEmpty) {
  const FusedFace fused =
      fuse_face({kFace}, 0, {{source_of(at(0.004), 1, 0)}, {source_of(at(0.004), 2, 0.3)}}, {1, 1}, 0.1, {});
  EXPECT_EQ(fused.counts.empty, 10 * 16);
  EXPECT_EQ(fused.counts.alone, 6 * 16);
  EXPECT_EQ(fused.counts.agreed, 4 * 16);
  EXPECT_THROW(fuse_face({kFace}, 0, {{source_of(at(0), 1)}}, {2}, 0.1, {}), std::invalid_argument);
}

/// Faces of two designs' layers, or of a panel that a design has twice.
TEST(Fuse, WhereFacesOverlapEachPointIsOneFacesOnly) {
  PanelFace behind = kFace, twice = kFace;
  FuseOptions every;
  every.least_points = 1;
  behind.plane.origin -= 0.03 * kFace.plane.axes.col(2), behind.width = 0.6;
  for (const PanelFace& other : {behind, twice}) {
    const std::vector<PanelFace> faces = {kFace, other};
    const auto layers = [](double u, double) {
      return u < 0 ? 0.004 : -0.029;
    };  // of the first face and 1 mm over the second
    const std::vector<std::vector<MeasuredTile>> sources = {{source_of(layers, 1)}, {source_of(layers, 2)}};
    size_t given = 0, kept[2] = {0, 0};
    for (const auto& source : sources) given += source[0].points.size();
    for (const size_t which : {0, 1})
      for (const MeasuredTile& tile : fuse_face(faces, which, sources, {1, 1}, 0.1, every).tiles)
        kept[which] += tile.points.size();
    EXPECT_EQ(kept[0] + kept[1], given) << "each point is written once";
    const bool layered = other.width < kFace.width;
    EXPECT_EQ(kept[1], layered ? given * 3 / 10 : 0) << "the second face has what lies nearer to it, of two alike none";
  }
}

}  // namespace test_fuse
}  // namespace plumbline::surface
