// register.rigid as a node; what every registrar must do is in tests/conformance.
#include <gmock/gmock.h>

#include "artifacts/transform.hpp"
#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace plumbline {
namespace {

using test::NodeFailed;
using test::NodeHarness;
using testing::HasSubstr;

PointsT copy_of(const PointsT& points) {
  PointsT out;
  for (const auto& point : points.points) out.points.push_back(std::make_unique<PointT>(*point));
  out.covariance = points.covariance;
  return out;
}

std::string failure_of(NodeHarness& node) {
  try {
    node.run();
  } catch (const NodeFailed& error) {
    return error.what();
  }
  return "";
}

TEST(RegisterRigid, KeepsCheckPointsOutOfTheFitAndMovesThem) {
  const auto facade = test::make_facade({.floors = 2, .survey_sigma = 0.001, .seed = 2});
  PointsT target = copy_of(facade.control);
  target.points[3]->role = "check";
  target.points[3]->position.z() += 5;  // would be seen if it took part
  NodeHarness node("register.rigid");
  node.input<Points>("source", facade.truth);
  node.input<Points>("target", target);
  node.run();
  const TransformT transform = node.output<Transform>("transform");
  EXPECT_EQ(transform.residuals.size(), facade.truth.points.size() - 1);
  EXPECT_EQ(transform.covariance.size(), 21u);
  ASSERT_EQ(transform.residual_covariance.size(), 6u);
  EXPECT_GT(transform.residual_covariance_unbiased[0], transform.residual_covariance[0]);
  const PointsT points = node.output<Points>("points");
  ASSERT_EQ(points.points.size(), facade.truth.points.size());
  EXPECT_LT((points.points[3]->position - facade.truth.points[3]->position).norm(), 0.005);
}

TEST(RegisterRigid, GivesNoSigmaWhereTheSourceHasNone) {
  const auto facade = test::make_facade({.floors = 1, .survey_sigma = 0.001});
  NodeHarness node("register.rigid");
  node.input<Points>("source", facade.truth);
  node.input<Points>("target", facade.control);
  node.run();
  const PointsT points = node.output<Points>("points");
  EXPECT_TRUE(points.covariance.empty());
  EXPECT_TRUE(std::isnan(points.points[0]->sigma.x()));
}

TEST(RegisterRigid, PropagatesTheFullCovariance) {
  const auto facade = test::make_facade({.floors = 1, .survey_sigma = 0.001});
  NodeHarness node("register.rigid");
  node.input<Points>("source", facade.control);
  node.input<Points>("target", facade.control);
  node.set("scale", "estimated");
  node.run();
  const PointsT points = node.output<Points>("points");
  const size_t n = 3 * points.points.size();
  EXPECT_EQ(points.covariance.size(), n * (n + 1) / 2);
  EXPECT_GT(points.points[0]->sigma.z(), 0.0005);
  EXPECT_LT(points.points[0]->sigma.z(), 0.0015);
  EXPECT_EQ(node.output<Transform>("transform").covariance.size(), 28u);
}

TEST(RegisterRigid, SaysHowManyPointsBothSidesHave) {
  const auto facade = test::make_facade({.floors = 1});
  PointsT target = copy_of(facade.truth);
  for (auto& point : target.points) point->id += "x";
  NodeHarness node("register.rigid");
  node.input<Points>("source", facade.truth);
  node.input<Points>("target", target);
  EXPECT_THAT(failure_of(node), testing::AllOf(HasSubstr("at least 3"), HasSubstr("(8 points)"), HasSubstr("found 0")));
}

TEST(RegisterRigid, RefusesTwoPointsOfOneName) {
  const auto facade = test::make_facade({.floors = 1});
  PointsT source = copy_of(facade.truth);
  source.points[1]->id = source.points[0]->id;
  NodeHarness node("register.rigid");
  node.input<Points>("source", source);
  node.input<Points>("target", facade.truth);
  EXPECT_THAT(failure_of(node), HasSubstr("two points named " + source.points[0]->id));
}

}  // namespace
}  // namespace plumbline
