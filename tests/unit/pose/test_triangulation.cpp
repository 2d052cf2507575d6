// Intersection of rays: held by exact geometry, by a search over neighbours, and by the Cramér-Rao bound.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "geometry/triangulation.hpp"
#include "synthetic_facade.hpp"

namespace test_triangulation {

using namespace plumbline;

const Triangulation methods[] = {Triangulation::dlt, Triangulation::midpoint, Triangulation::angular};
const Eigen::Vector3d truth(700012.3, 5300004.1, 312.7);  // a national grid: digits must not be lost

/// Images that look at the point from `centres`, each rolled differently and not quite at it.
std::vector<PointView> views_from(const std::vector<Eigen::Vector3d>& centres) {
  std::vector<PointView> views;
  for (size_t i = 0; i < centres.size(); ++i) {
    const Eigen::Vector3d z = (truth + Eigen::Vector3d(0.3, -0.2, 0.1 * double(i)) - centres[i]).normalized();
    const Eigen::Vector3d x = z.cross(Eigen::Vector3d(std::cos(double(i)), 0.2, 1)).normalized();
    Eigen::Matrix3d cam_from_world;
    cam_from_world << x.transpose(), z.cross(x).transpose(), z.transpose();
    PointView view;
    view.cam_from_world.rotation = Eigen::Quaterniond(cam_from_world);
    view.cam_from_world.translation = -(view.cam_from_world.rotation * centres[i]);
    const Eigen::Vector3d seen = view.cam_from_world.rotation * (truth - centres[i]);
    view.normalised = seen.hnormalized();
    views.push_back(view);
  }
  return views;
}

/// One image near, the others far: here the methods differ.
std::vector<Eigen::Vector3d> near_and_far() {
  return {truth + Eigen::Vector3d(0.5, -2, 0.3), truth + Eigen::Vector3d(15, -20, -6),
          truth + Eigen::Vector3d(-12, -24, 9), truth + Eigen::Vector3d(3, -30, 1)};
}

/// Turns the measured direction by about `sigma` about both axes across it.
void disturb(PointView& view, double sigma, test::Random& random) {
  const Eigen::Vector3d d = view.normalised.homogeneous().normalized();
  const Eigen::Vector3d a = d.unitOrthogonal(), b = d.cross(a);
  const double first = random.normal(), second = random.normal();
  view.normalised = (d + sigma * (first * a + second * b)).hnormalized();
}

double sum_of_chords(const std::vector<PointView>& views, const Eigen::Vector3d& point) {
  double sum = 0;
  for (const auto& view : views)
    sum += ((view.cam_from_world * point).normalized() - view.normalised.homogeneous().normalized()).squaredNorm();
  return sum;
}

TEST(Triangulation, ExactRaysMeetInThePoint) {
  const auto views = views_from(near_and_far());
  for (const auto method : methods) {
    const auto found = triangulate(views, method);
    ASSERT_TRUE(found);
    EXPECT_LT((found->point - truth).norm(), 2e-8);
    EXPECT_LT(found->rms_angle, 1e-9);
    EXPECT_GT(found->parallax, 0.3);
  }
}

/// Root mean square and largest angle, again from the views one by one.
TEST(Triangulation, AnglesAreThoseOfTheRaysToThePoint) {
  for (const std::size_t count : {std::size_t{2}, std::size_t{3}, near_and_far().size()}) {
    auto views = views_from(near_and_far());
    views.resize(std::min(count, views.size()));
    test::Random random(11);
    for (auto& view : views) disturb(view, 1e-3, random);
    const auto found = triangulate(views, Triangulation::angular);
    ASSERT_TRUE(found) << count;
    double squares = 0, largest = 0;
    std::vector<Eigen::Vector3d> rays;
    for (const auto& view : views) {
      const Eigen::Vector3d measured =
          view.cam_from_world.rotation.conjugate() * view.normalised.homogeneous().normalized();
      const Eigen::Vector3d computed = (found->point - view.cam_from_world.inverse().translation).normalized();
      squares += std::pow(2 * std::asin(0.5 * (measured - computed).norm()), 2);
      for (const Eigen::Vector3d& other : rays)
        largest = std::max(largest, 2 * std::asin(0.5 * (measured - other).norm()));
      rays.push_back(measured);
    }
    EXPECT_NEAR(found->rms_angle / std::sqrt(squares / static_cast<double>(views.size())), 1, 1e-9) << count;
    EXPECT_NEAR(found->parallax, largest, 1e-9) << count;
    EXPECT_GT(found->parallax, 0.01) << "two views have one, too";
  }
}

TEST(Triangulation, WhatDoesNotMeetInFrontOfTheCamerasIsNothing) {
  auto views = views_from(near_and_far());
  for (const auto method : methods) {
    EXPECT_FALSE(triangulate({}, method));
    EXPECT_FALSE(triangulate({views[0]}, method));
    EXPECT_FALSE(triangulate({views[0], views[0]}, method));
    auto behind = views;
    for (auto& view : behind) {  // the same lines, run backwards
      view.cam_from_world.rotation = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()) * view.cam_from_world.rotation;
      view.cam_from_world.translation =
          Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()) * view.cam_from_world.translation;
      view.normalised.x() *= -1;
    }
    EXPECT_FALSE(triangulate(behind, method));
  }
}

TEST(Triangulation, AngularHasTheLeastAnglesOfAll) {
  test::Random random(5);
  auto views = views_from(near_and_far());
  for (auto& view : views) disturb(view, 3e-3, random);
  const Eigen::Vector3d best = triangulate(views, Triangulation::angular)->point;
  const double cost = sum_of_chords(views, best);
  for (int axis = 0; axis < 3; ++axis)
    for (const double step : {-1e-5, 1e-5})
      EXPECT_GT(sum_of_chords(views, best + step * Eigen::Vector3d::Unit(axis)), cost);
  EXPECT_LT(cost, sum_of_chords(views, triangulate(views, Triangulation::dlt)->point));
  EXPECT_LT(cost, sum_of_chords(views, triangulate(views, Triangulation::midpoint)->point));
}

TEST(Triangulation, AngularReachesTheBoundAndMidpointDoesNot) {
  constexpr double sigma = 1e-4;
  constexpr int trials = 400;
  const auto exact = views_from(near_and_far());
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const auto& centre : near_and_far()) {
    const Eigen::Vector3d away = truth - centre, d = away.normalized();
    information += (Eigen::Matrix3d::Identity() - d * d.transpose()) / (sigma * sigma * away.squaredNorm());
  }
  const Eigen::Matrix3d bound = information.inverse();
  double error[3] = {0, 0, 0}, nees = 0;
  test::Random random(9);
  for (int trial = 0; trial < trials; ++trial) {
    auto views = exact;
    for (auto& view : views) disturb(view, sigma, random);
    for (size_t m = 0; m < 3; ++m) {
      const Eigen::Vector3d e = triangulate(views, methods[m])->point - truth;
      error[m] += e.squaredNorm() / trials;
      if (methods[m] == Triangulation::angular) nees += e.dot(information * e) / (3 * trials);
    }
  }
  const double slack = 4 * std::sqrt(2.0 / (3 * trials));  // four standard deviations of a mean of squares
  EXPECT_NEAR(nees, 1, slack);
  EXPECT_NEAR(error[2] / bound.trace(), 1, 2 * slack);
  EXPECT_GT(error[1], 1.3 * bound.trace());
}

}  // namespace test_triangulation
