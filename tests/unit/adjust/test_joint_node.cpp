// adjust.joint over its artifacts: readings and photographs together.
#include <gmock/gmock.h>

#include "adjuster_inputs.hpp"
#include "artifacts/block.hpp"
#include "artifacts/camera_artifact.hpp"
#include "artifacts/survey_artifact.hpp"
#include "node_harness.hpp"
#include "stopping.hpp"
#include "survey/simulate/simulate_survey.hpp"
#include "synthetic_facade.hpp"

namespace test_joint_node {

using namespace plumbline;
using namespace plumbline::test;
using testing::HasSubstr;

/// A node with the facade's photographs and readings from two stations before it.
NodeHarness joint_node(const SyntheticFacade& facade) {
  survey::SurveyLayout layout;
  for (const auto& point : facade.truth.points) layout.points.push_back({point->id, point->position});
  std::vector<std::string> seen;
  for (const auto& point : layout.points) seen.push_back(point.id);
  layout.points.push_back({"S1", {0.5, -10, 1.6}});
  layout.points.push_back({"S2", {6.5, -11, 1.7}});
  layout.set_ups = {{"1", "S1", 0, 0.3, seen}, {"2", "S2", 0, 2.1, seen}};
  survey::SimulationOptions how;
  std::string remark;
  how.profile = survey::choose_profile("automatic", "", "", remark);
  how.coordinates = true;
  NodeHarness node("adjust.joint");
  node.input<Camera>("camera", facade.camera_artifact());
  node.input<Plates>("plates", facade.plates);
  node.input<Poses>("poses", facade.poses);
  for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
  node.input<SurveyObservations>("survey", survey::to_artifact(survey::simulate_survey(layout, how, 4)));
  return node;
}

TEST(AdjustJointNode, GivesAnchorsStationsAndTheSurveyAsAGroup) {
  const SyntheticFacade facade = make_facade(noisy);
  NodeHarness node = joint_node(facade), again = joint_node(facade);
  node.run();
  again.run();
  for (const char* port : {"points", "poses", "block", "survey_points"})
    EXPECT_EQ(node.output_bytes(port), again.output_bytes(port)) << port;
  const PointsT points = node.output<Points>("points"), survey = node.output<Points>("survey_points");
  ASSERT_EQ(points.points.size(), facade.truth.points.size());
  for (size_t i = 0; i < points.points.size(); ++i) {
    EXPECT_LT((points.points[i]->position - facade.truth.points[i]->position).norm(), 0.005);
    EXPECT_LT(points.points[i]->sigma.norm(), 0.003);
  }
  EXPECT_EQ(survey.points.size(), facade.truth.points.size() + 2);
  const BlockT block = node.output<Block>("block");
  EXPECT_EQ(block.adjuster, "adjust.joint");
  const auto group =
      std::find_if(block.groups.begin(), block.groups.end(), [](const auto& g) { return g->name == "survey"; });
  ASSERT_NE(group, block.groups.end());
  EXPECT_EQ((*group)->observations, 2 * 3 * static_cast<int>(facade.truth.points.size()));
  EXPECT_NEAR((*group)->variance_factor, 1, 0.02);
  node.set("estimate_survey_variance", "false");
  node.run();
  EXPECT_NE(node.output_bytes("points"), again.output_bytes("points"));
}

TEST(AdjustJointNode, CanBeStopped) {
  const SyntheticFacade facade = make_facade(noisy);
  EXPECT_EQ(stopping_at_fault([&] { return joint_node(facade); }), "");
}

/// A plate that hangs 50 mm beside its mark: named, and adjusted as if it carried none; the readings stay.
TEST(AdjustJointNode, LeavesAMarkOutWhosePlateContradicts) {
  SyntheticFacade facade = make_facade(noisy);
  SyntheticFacade surveyed = facade;
  const std::string wrong = facade.truth.points[2]->id;
  for (auto& point : surveyed.truth.points)
    if (point->id == wrong) point->position.z() += 0.05;
  NodeHarness robust = joint_node(surveyed), kept = joint_node(surveyed);
  robust.run();
  EXPECT_EQ(robust.metric("invalid"), 0);
  const BlockT block = robust.output<Block>("block");
  EXPECT_THAT(block.left_out,
              testing::ElementsAre(HasSubstr("the control of " + wrong + ", which contradicts the photographs")));
  const auto entry = std::find_if(block.control.begin(), block.control.end(),
                                  [&](const auto& control) { return control->anchor == wrong; });
  ASSERT_NE(entry, block.control.end());
  EXPECT_TRUE((*entry)->left_out);
  EXPECT_NEAR((*entry)->coordinates[2]->residual, -0.05, 0.004);
  const PointsT points = robust.output<Points>("points");
  for (size_t i = 0; i < points.points.size(); ++i)
    EXPECT_LT((points.points[i]->position - facade.truth.points[i]->position).norm(), 0.005);
  kept.set("robust_control", "false");
  kept.run();
  EXPECT_EQ(kept.metric("invalid"), 1);
  EXPECT_TRUE(kept.output<Block>("block").left_out.empty());
}

TEST(AdjustJointNode, SaysThatAnchorsAreNotCalledAsInTheSurvey) {
  SyntheticFacade facade = make_facade(noisy);
  for (auto& plate : facade.plates.plates) plate->anchor += "-other";
  NodeHarness node = joint_node(facade);
  EXPECT_THAT(failure(node), HasSubstr("are the anchors of the plates called as in the survey?"));
}

}  // namespace test_joint_node
