// evaluate.crossval over its artifacts: what the block says of a part without it.
#include <gmock/gmock.h>

#include "adjuster_inputs.hpp"
#include "artifacts/block.hpp"
#include "artifacts/file.hpp"
#include "node_harness.hpp"
#include "stopping.hpp"
#include "synthetic_facade.hpp"

namespace test_crossval_node {

using namespace plumbline;
using namespace plumbline::test;
using testing::HasSubstr;

TEST(EvaluateCrossvalNode, SaysOfAFloorWhatTheAdjustmentWithoutItSays) {
  SyntheticFacade facade = make_facade({.floors = 3, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 12});
  NodeHarness all("evaluate.crossval"), without("adjust.schur");
  connect(all, facade);
  all.set("by", "floor");
  all.set("estimate_image_variance", "false");
  all.run();
  EXPECT_EQ(all.metric("folds"), 3);
  EXPECT_EQ(all.metric("failed_folds"), 0);
  EXPECT_EQ(all.metric("points"), static_cast<double>(facade.control.points.size()));
  const double freedom = all.metric("freedom_3d");
  EXPECT_NEAR(all.metric("nees_3d"), freedom, 6 * std::sqrt(2 * freedom)) << "folds share what they say";
  std::set<std::string> second;
  for (auto& plate : facade.plates.plates)
    if (plate->floor == 2) plate->role = "check", second.insert(plate->anchor);
  connect(without, facade);
  without.set("estimate_image_variance", "false");
  without.run();
  const PointsT model = without.output<Points>("points"), differences = all.output<Points>("differences");
  int compared = 0;
  for (const auto& difference : differences.points) {
    if (!second.count(difference->id)) continue;
    const auto find = [&](const PointsT& points) -> const PointT& {
      for (const auto& point : points.points)
        if (point->id == difference->id) return *point;
      throw std::runtime_error("no point " + difference->id);
    };
    const PointT &surveyed = find(facade.control), &adjusted = find(model);
    EXPECT_LT((difference->position - (surveyed.position - adjusted.position)).norm(), 5e-6) << difference->id;
    const Eigen::Vector3d sigma = (surveyed.sigma.cwiseAbs2() + adjusted.sigma.cwiseAbs2()).cwiseSqrt();
    EXPECT_LT((difference->sigma - sigma).norm(), 0.01 * sigma.norm()) << difference->id;
    ++compared;
  }
  EXPECT_GT(compared, 5);
}

/// A fold that was stopped is no fold that failed.
TEST(EvaluateCrossvalNode, CanBeStopped) {
  const SyntheticFacade facade = make_facade({.floors = 2, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 12});
  EXPECT_EQ(stopping_at_fault([&] {
              NodeHarness node("evaluate.crossval");
              connect(node, facade), node.set("by", "floor");
              return node;
            }),
            "");
}

/// As the adjuster does: what contradicts predicts nobody, is no part of the figures, and stands in the table.
TEST(EvaluateCrossvalNode, LeavesWrongControlOutAsTheAdjusterDoes) {
  SyntheticFacade facade = make_facade({.floors = 2, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 12});
  facade.control.points[3]->position.z() += 0.05;
  const std::string wrong = facade.control.points[3]->id;
  for (const char* by : {"fold", "floor"}) {
    NodeHarness node("evaluate.crossval");
    connect(node, facade);
    node.set("by", by);
    node.run();
    EXPECT_EQ(node.metric("left_out"), 1) << by;
    EXPECT_EQ(node.metric("points"), static_cast<double>(facade.control.points.size() - 1)) << by;
    EXPECT_EQ(node.metric("invalid"), 0) << by;
    EXPECT_LT(node.metric("rmse_z"), 0.003) << by;
    const FileT table = node.output<File>("table");
    EXPECT_THAT(std::string(table.content.begin(), table.content.end()), HasSubstr("left out," + wrong + ","));
    for (const auto& point : node.output<Points>("differences").points) EXPECT_NE(point->id, wrong);
  }
  NodeHarness kept("evaluate.crossval");
  connect(kept, facade);
  kept.set("robust_control", "false");
  kept.run();
  EXPECT_EQ(kept.metric("left_out"), 0);
  EXPECT_EQ(kept.metric("invalid"), 1);
}

TEST(EvaluateCrossvalNode, HalvesAreOffByWhatBothSay) {
  const SyntheticFacade facade = make_facade({.floors = 2, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 13});
  NodeHarness halves("evaluate.crossval");
  connect(halves, facade);
  halves.set("by", "halves");
  halves.run();
  const double freedom = halves.metric("freedom_3d");
  EXPECT_NEAR(halves.metric("nees_3d"), freedom, 4 * std::sqrt(2 * freedom));
  EXPECT_GT(halves.metric("within_two_sigma_z"), 0.8);
}

TEST(EvaluateCrossvalNode, NamesAFoldWithoutWhichNothingHolds) {
  const SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 14});
  NodeHarness node("evaluate.crossval");
  connect(node, facade);
  node.set("by", "floor");
  EXPECT_THAT(failure(node), HasSubstr("without its points the control does not hold the block"));
}

}  // namespace test_crossval_node
