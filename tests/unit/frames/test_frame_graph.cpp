// Points through chains of frames, and their covariance against numerical derivatives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "geometry/frame_graph.hpp"
#include "geometry/random.hpp"

namespace plumbline {
namespace test_frame_graph {

FrameLink link(const std::string& to, const std::string& from, double scale, bool plan_only, double tilt) {
  FrameLink l;
  l.to = to, l.from = from, l.scale = scale, l.plan_only = plan_only;
  l.to_from_from.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())) *
                            Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()));
  l.to_from_from.translation = {100, -50, 7};
  Random random(3);
  Matrix7 root;
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 7; ++j) root(i, j) = 1e-3 * random.normal();
  l.covariance = root * root.transpose();
  return l;
}

/// The link with changed parameters: a rotation vector in `to`, a shift, a scale.
FrameLink changed(FrameLink l, const Eigen::Matrix<double, 7, 1>& by) {
  l.to_from_from.rotation = quaternion_from_rotation_vector(by.head<3>()) * l.to_from_from.rotation;
  l.to_from_from.translation += by.segment<3>(3);
  l.scale += by(6);
  return l;
}

TEST(FrameGraph, ALinkGoesThereAndBack) {
  const FrameLink l = link("b", "a", 1.25, true, 0);
  const Eigen::Vector3d p(3, 4, 5);
  EXPECT_NEAR((l.apply_inverse(l.apply(p)) - p).norm(), 0, 1e-12);
  EXPECT_NEAR(l.apply(p).z(), 12, 1e-12) << "a map's scale leaves heights alone";
  const double c = std::cos(0.7), s = std::sin(0.7);
  EXPECT_NEAR(l.apply(p).x(), 100 + 1.25 * (3 * c - 4 * s), 1e-12);
  EXPECT_NEAR(l.apply(p).y(), -50 + 1.25 * (3 * s + 4 * c), 1e-12);
}

/// Covariance of two points and of what they have in common, both ways, against differences of the map itself.
TEST(FrameGraph, CovarianceIsThatOfPointsAndLink) {
  for (const bool plan_only : {false, true})
    for (const bool backwards : {false, true}) {
      const FrameLink l = link("b", "a", 1.1, plan_only, plan_only ? 0 : 0.3);
      FrameGraph graph;
      graph.add(l);
      FramePoints given;
      given.positions = {{1, 2, 3}, {-8, 5, 2}};
      if (backwards)
        for (auto& p : given.positions) p = l.apply(p);
      given.covariance = 1e-6 * Eigen::MatrixXd::Identity(6, 6);
      given.covariance(0, 4) = given.covariance(4, 0) = 4e-7;
      const FramePoints there = backwards ? graph.express(given, "a", "b") : graph.express(given, "b", "a");
      const auto map = [&](const Eigen::Matrix<double, 13, 1>& by) {
        const FrameLink moved = changed(l, by.tail<7>());
        Eigen::Matrix<double, 6, 1> out;
        for (int i = 0; i < 2; ++i) {
          const Eigen::Vector3d p = given.positions[i] + by.segment<3>(3 * i);
          out.segment<3>(3 * i) = backwards ? moved.apply_inverse(p) : moved.apply(p);
        }
        return out;
      };
      Eigen::Matrix<double, 6, 13> slope;
      for (int k = 0; k < 13; ++k) {
        Eigen::Matrix<double, 13, 1> step = Eigen::Matrix<double, 13, 1>::Zero();
        step(k) = 1e-6;
        slope.col(k) = (map(step) - map(-step)) / 2e-6;
      }
      Eigen::Matrix<double, 13, 13> of_all = Eigen::Matrix<double, 13, 13>::Zero();
      of_all.topLeftCorner<6, 6>() = given.covariance;
      of_all.bottomRightCorner<7, 7>() = l.covariance;
      const Eigen::MatrixXd expected = slope * of_all * slope.transpose();
      EXPECT_LT((there.covariance - expected).norm(), 1e-6 * expected.norm()) << plan_only << backwards;
    }
}

TEST(FrameGraph, TakesTheShortestWayAndNamesWhatCanBeReached) {
  FrameGraph graph;
  graph.add(link("building", "survey", 1, false, 0.1));
  graph.add(link("building", "block", 1, false, 0.2));
  graph.add(link("map", "building", 1.0004, true, 0));
  const FramePoints in_block{{{1, 2, 3}}, {}};
  const FramePoints in_map = graph.express(in_block, "map", "block");
  EXPECT_NEAR((in_map.positions[0] - graph.links()[2].apply(graph.links()[1].apply(in_block.positions[0]))).norm(), 0,
              1e-12);
  const FramePoints in_survey = graph.express(in_map, "survey", "map");
  EXPECT_NEAR((graph.express(in_survey, "block", "survey").positions[0] - in_block.positions[0]).norm(), 0, 1e-9);
  EXPECT_EQ(graph.way("survey", "map").size(), 2u);
  EXPECT_THAT(graph.frames(), ::testing::ElementsAre("survey", "building", "block", "map"));
  try {
    graph.express(in_map, "robot", "map");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "no transform leads from the frame 'map' to 'robot'; from there one can reach 'map', 'building', "
                 "'survey', 'block'");
  }
}

}  // namespace test_frame_graph
}  // namespace plumbline
