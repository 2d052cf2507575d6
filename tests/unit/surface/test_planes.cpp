// Planes in a cloud without a design.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "plumbline/stop.hpp"
#include "surface/dense/find_planes.hpp"

namespace plumbline::surface {
namespace test_planes {

using Places = std::vector<Eigen::Vector3d>;

/// Two walls of 4 m x 3 m that meet at a right angle, at coordinates of a map, with 2 mm of noise; a bush before them.
Places corner() {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 0.002);
  std::uniform_real_distribution<double> somewhere(0, 0.8);
  const Eigen::Vector3d at(352100.4, 5810400.7, 30);
  Places points;
  for (double along = 0.01; along < 4; along += 0.02)
    for (double up = 0.01; up < 3; up += 0.02) {
      points.push_back(at + Eigen::Vector3d(along, noise(random), up));
      points.push_back(at + Eigen::Vector3d(noise(random), -along, up));
    }
  for (int i = 0; i < 4000; ++i)
    points.push_back(at + Eigen::Vector3d(1 + somewhere(random), -1.5 - somewhere(random), somewhere(random)));
  return points;
}

std::vector<FoundPlane> found_in(const Places& points, const PlaneOptions& options = {}) {
  PlaneFinder finder(options);
  for (const Eigen::Vector3d& point : points) finder.add(point);
  return finder.planes();
}

TEST(FindPlanes, BothWallsOfACornerAndNoBush) {
  Places points = corner();
  const std::vector<FoundPlane> planes = found_in(points);
  ASSERT_EQ(planes.size(), 2U);
  for (const FoundPlane& plane : planes) {
    EXPECT_NEAR(std::max(std::abs(plane.normal.x()), std::abs(plane.normal.y())), 1, 1e-6);
    EXPECT_NEAR(plane.width, 3.8, 0.11) << "the cells of the corner itself are of neither";
    EXPECT_NEAR(plane.height, 3, 0.11);
    EXPECT_NEAR(plane.area, plane.width * plane.height, 0.06 * plane.width * plane.height);
    EXPECT_NEAR(plane.roughness, 0.002, 2e-4);
    EXPECT_NEAR(plane.origin.z(), 31.5, 0.06);
    const bool south = std::abs(plane.normal.y()) > 0.5;
    EXPECT_NEAR(south ? plane.origin.y() : plane.origin.x(), south ? 5810400.7 : 352100.4, 1e-4);
  }
  std::reverse(points.begin(), points.end());
  const std::vector<FoundPlane> again = found_in(points);
  ASSERT_EQ(again.size(), 2U);
  for (const FoundPlane& plane : again)
    EXPECT_LT(std::min((plane.origin - planes[0].origin).norm(), (plane.origin - planes[1].origin).norm()), 1e-6);
}

TEST(FindPlanes, ABallAndAStepAreNoPlaneOfTheirOwn) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 1);
  Places ball;
  for (int i = 0; i < 40000; ++i)
    ball.push_back(Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized());
  EXPECT_TRUE(found_in(ball).empty());
  Places step;  // by 50 mm: two planes, not one between
  for (double u = 0.01; u < 4; u += 0.02)
    for (double v = 0.01; v < 2; v += 0.02) step.emplace_back(u, u < 2 ? 0.0 : 0.05, v);
  const std::vector<FoundPlane> planes = found_in(step);
  ASSERT_EQ(planes.size(), 2U);
  EXPECT_NEAR(std::abs(planes[0].origin.y() - planes[1].origin.y()), 0.05, 1e-3);
}

/// Bytes that are taken from the heap now.
size_t taken() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

TEST(FindPlanes, TakesNoMoreMemoryThanItSays) {
  const size_t before = taken();
  PlaneOptions options;
  options.most_cells = 200'000;
  PlaneFinder finder(options);
  for (int i = 0; i < 400; ++i)
    for (int j = 0; j < 500; ++j)
      for (const double aside : {0.01, 0.09}) finder.add({0.1 * i + aside, 0.0503, 0.1 * j + aside});
  EXPECT_THROW(finder.add({-3, 0, 0}), std::length_error) << "one cell more";
  size_t most = 0;
  struct Watch {
    size_t before, *most;
  } watch{before, &most};
  {
    const StopScope look(
        [](const void* of) {
          const auto* w = static_cast<const Watch*>(of);
          *w->most = std::max(*w->most, taken() - w->before);
          return false;
        },
        &watch);
    ASSERT_EQ(finder.planes().size(), 1U) << "the worst of all: one plane that has all cells";
  }
  EXPECT_LT(most, options.most_cells * PlaneFinder::kBytesOfCell);
  EXPECT_GT(most, options.most_cells * PlaneFinder::kBytesOfCell / 2) << "or the node announces what nobody takes";
}

TEST(FindPlanes, WhatIsNoLengthOrNoPlaceIsRefused) {
  EXPECT_THROW(PlaneFinder({0, 0.006, 0.09, 1}), std::invalid_argument);
  PlaneFinder finder({});
  EXPECT_THROW(finder.add({std::nan(""), 0, 0}), std::length_error);
  EXPECT_TRUE(finder.planes().empty());
}

}  // namespace test_planes
}  // namespace plumbline::surface
