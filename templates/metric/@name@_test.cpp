// The node by itself, with inputs made here.
#include <gtest/gtest.h>

#include "artifacts/points.hpp"
#include "node_harness.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::test;

PointsT heights(const std::vector<double>& values, const std::string& role) {
  PointsT points;
  for (size_t i = 0; i < values.size(); ++i) {
    auto point = std::make_unique<PointT>();
    point->id = "P" + std::to_string(i);
    point->position = {0, 0, values[i]};
    point->sigma.setConstant(0.001);
    point->role = role;
    points.points.push_back(std::move(point));
  }
  return points;
}

TEST(Metric, IsTheMedianOfTheErrors) {
  NodeHarness node("evaluate.@name@");
  node.input<Points>("model", heights({0.001, -0.003, 0.1}, "check"));
  node.input<Points>("truth", heights({0, 0, 0}, ""));
  node.run();
  EXPECT_NEAR(node.metric("median_z"), 0.003, 1e-12);
  EXPECT_EQ(node.output<Points>("points").points.size(), 3u);
}

TEST(Metric, OfTwoIsTheMeanOfBoth) {
  NodeHarness node("evaluate.@name@");
  node.input<Points>("model", heights({0.001, -0.1}, "check"));
  node.input<Points>("truth", heights({0, 0}, ""));
  node.run();
  EXPECT_NEAR(node.metric("median_z"), 0.0505, 1e-12);
}

TEST(Metric, RefusesToJudgeByControl) {
  NodeHarness node("evaluate.@name@");
  node.input<Points>("model", heights({0.001}, "control"));
  node.input<Points>("truth", heights({0}, ""));
  EXPECT_THROW(node.run(), NodeFailed);
}

}  // namespace
