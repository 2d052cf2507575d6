// register.rigid as a node; what every registrar must do is in tests/conformance.
#include <gmock/gmock.h>

#include "artifacts/fitted_datum.hpp"
#include "artifacts/transform.hpp"
#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace plumbline {
namespace test_register_node {

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

/// What a target was fitted to cannot be seen in what is registered on it either.
TEST(RegisterRigid, CarriesTheMarkOfATargetThatWasFittedToTheDesign) {
  const auto facade = test::make_facade({.floors = 2, .survey_sigma = 0.001, .seed = 2});
  const auto mark_of = [&](bool fitted) {
    PointsT target = copy_of(facade.control);
    if (fitted) mark_fitted(target, "fitted to 24 anchors", 0.003);
    NodeHarness node("register.rigid");
    node.input<Points>("source", facade.truth);
    node.input<Points>("target", target);
    node.run();
    const PointsT points = node.output<Points>("points");
    return points.fitted_to_design ? points.fitted_to_design->origin : "none";
  };
  EXPECT_EQ(mark_of(true), "fitted to 24 anchors");
  EXPECT_EQ(mark_of(false), "none");
}

/// Another program's least squares of equal weights: same transform, and the same statistics about it.
TEST(RegisterOpengvArun, AgreesWithOurClosedForm) {
  auto facade = test::make_facade({.floors = 2, .survey_sigma = 0.001, .seed = 2});
  facade.control.points[3]->role = "check";
  for (auto& point : facade.control.points) point->position += Eigen::Vector3d(4e6, 5e6, 300);  // national coordinates
  NodeHarness ours("register.rigid"), theirs("register.opengv_arun");
  ours.set("weights", "equal");
  for (NodeHarness* node : {&ours, &theirs}) {
    node->input<Points>("source", facade.truth);
    node->input<Points>("target", facade.control);
    node->run();
  }
  const TransformT a = ours.output<Transform>("transform"), b = theirs.output<Transform>("transform");
  EXPECT_LT(a.to_from_from.rotation.angularDistance(b.to_from_from.rotation), 1e-12);
  EXPECT_LT((a.to_from_from.translation - b.to_from_from.translation).norm(), 1e-8);
  ASSERT_EQ(b.residuals.size(), a.residuals.size());
  ASSERT_EQ(b.covariance.size(), a.covariance.size());
  for (size_t i = 0; i < a.covariance.size(); ++i)
    EXPECT_NEAR(b.covariance[i], a.covariance[i], 1e-9 * a.covariance[20]);
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(b.residual_covariance[i], a.residual_covariance[i], 1e-14);
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

/// A source that knows its scale to 1 % and is 0.5 % too small: six parameters would take it for exact.
TEST(RegisterRigid, TestsTheScaleThatTheSourceHasNotTheOneItMayHave) {
  const auto facade = test::make_facade({.floors = 2, .survey_sigma = 0.001, .seed = 2});
  PointsT source = copy_of(facade.truth);
  const size_t n = 3 * source.points.size();
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j <= i; ++j)
      source.covariance.push_back(1e-4 * facade.truth.points[i / 3]->position[i % 3] *
                                      facade.truth.points[j / 3]->position[j % 3] +
                                  (i == j ? 1e-8 : 0));
  for (const double scale : {0.995, 1.0}) {
    for (size_t i = 0; i < source.points.size(); ++i)
      source.points[i]->position = scale * facade.truth.points[i]->position;
    NodeHarness node("register.rigid");
    node.input<Points>("source", source);
    node.input<Points>("target", facade.control);
    node.set("scale", "tested");
    node.run();
    const TransformT transform = node.output<Transform>("transform");
    EXPECT_EQ(transform.statistics->unknowns, scale < 1 ? 7 : 6);
    EXPECT_EQ(std::abs(transform.scale_w) > 20, scale < 1) << transform.scale_w;
  }
}

TEST(RegisterRigid, WarnsOfASourceWithoutCorrelations) {
  auto facade = test::make_facade({.floors = 1, .survey_sigma = 0.001});
  for (auto& point : facade.truth.points) point->sigma.setConstant(0.001);
  NodeHarness node("register.rigid");
  node.input<Points>("source", facade.truth);
  node.input<Points>("target", facade.control);
  node.run();
  EXPECT_THAT(node.warnings(), testing::Contains(HasSubstr("not the correlations between its points")));
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

}  // namespace test_register_node
}  // namespace plumbline
