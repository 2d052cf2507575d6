// evaluate.errors, evaluate.crlb, evaluate.withhold and evaluate.lengths as nodes.
#include <gmock/gmock.h>

#include <cmath>

#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/image_plan.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/survey_observations.hpp"
#include "node_harness.hpp"

namespace plumbline::test {
namespace trial_nodes_test {

using testing::HasSubstr;

std::unique_ptr<PointT> point(const std::string& id, double x, double y, double z, const std::string& role) {
  auto made = std::make_unique<PointT>();
  made->id = id;
  made->position = {x, y, z};
  made->sigma.setConstant(1e-3);
  made->role = role;
  return made;
}

PointsT points(std::initializer_list<std::tuple<const char*, double, double, double, const char*>> list) {
  PointsT made;
  for (const auto& [id, x, y, z, role] : list) made.points.push_back(point(id, x, y, z, role));
  return made;
}

TEST(Errors, OfCheckPointsOnlyAndModelMinusTruth) {
  NodeHarness node("evaluate.errors");
  node.input<Points>("model", points({{"A", 1, 2, 3.002, ""}, {"B", 0, 0, 5, ""}, {"C", 0, 0, 0.999, ""}}));
  node.input<Points>("truth", points({{"A", 1, 2, 3, "check"}, {"B", 0, 0, 0, "control"}, {"C", 0, 0, 1, "check"}}));
  node.run();
  const PointsT off = node.output<Points>("errors");
  ASSERT_EQ(off.points.size(), 2u);
  EXPECT_NEAR(off.points[0]->position.z(), 0.002, 1e-12);
  EXPECT_NEAR(node.metric("rmse_z"), std::sqrt((4e-6 + 1e-6) / 2), 1e-12);
  EXPECT_NEAR(node.metric("bias_z"), 0.5e-3, 1e-12);
  EXPECT_NEAR(node.metric("max_abs_z"), 2e-3, 1e-12);
  EXPECT_TRUE(std::isnan(node.metric("nees_z"))) << "the model has no covariance";
}

TEST(Errors, NeesTakesTheFullCovarianceOfModelAndTruth) {
  PointsT model = points({{"A", 0, 0, 1e-3, ""}, {"B", 0, 0, 2e-3, ""}}),
          truth = points({{"A", 0, 0, 0, "check"}, {"B", 0, 0, 0, "check"}});
  for (PointsT* p : {&model, &truth}) p->covariance.assign(21, 0.0);
  for (size_t k : {0, 2, 5, 9, 14, 20}) model.covariance[k] = 1e-6, truth.covariance[k] = 1e-6;
  model.covariance[17] = 1e-6;  // row 5, column 2: the two heights
  NodeHarness node("evaluate.errors");
  node.input<Points>("model", model);
  node.input<Points>("truth", truth);
  node.run();
  // S = [2 1; 1 2] mm², e = (1, 2) mm: (2·1 - 2·1·2 + 2·4) / 3 = 2.
  EXPECT_NEAR(node.metric("nees_z"), 2.0, 1e-9);
  EXPECT_NEAR(node.metric("predicted_rmse_z"), std::sqrt(2e-6), 1e-12);
}

TEST(Errors, AModelWithoutMostOfThePointsIsNoResult) {
  NodeHarness node("evaluate.errors");
  node.input<Points>("model", points({{"A", 0, 0, 0, ""}}));
  node.input<Points>("truth", points({{"A", 0, 0, 0, "check"}, {"B", 0, 0, 0, "check"}}));
  try {
    node.run();
    FAIL();
  } catch (const NodeFailed& error) {
    EXPECT_THAT(error.what(), HasSubstr("1 of 2 points are missing in the model, such as B"));
  }
}

/// The adjuster's own covariance and the bound are two programs' answers to the same question.
TEST(Crlb, IsWhatTheAdjusterPredictsForACleanSite) {
  NodeHarness site("simulate.observations");
  site.seed(5);
  site.set("floors", "2");
  site.run();
  NodeHarness poses("pose.opengv"), block("adjust.ceres"), bound("evaluate.crlb");
  for (NodeHarness* node : {&poses, &block, &bound}) {
    for (std::size_t i = 0; i < site.output_count("observations"); ++i)
      node->input<ImageTags>("observations", site.output<ImageTags>("observations", i));
    node->input<Camera>("camera", site.output<Camera>("camera"));
    node->input<Plates>("plates", site.output<Plates>("plates"));
  }
  poses.input<Points>("points", site.output<Points>("design"));
  poses.run();
  block.input<Poses>("poses", poses.output<Poses>("poses"));
  block.input<Points>("control", site.output<Points>("points"));
  block.set("estimate_image_variance", "false");
  block.run();
  bound.input<Poses>("poses", site.output<Poses>("true_poses"));
  bound.input<Points>("points", site.output<Points>("truth"));
  bound.input<Points>("control", site.output<Points>("points"));
  bound.run();
  const PointsT predicted = block.output<Points>("points"), limit = bound.output<Points>("bound");
  std::map<std::string, const PointT*> of_limit;
  for (const auto& p : limit.points) of_limit[p->id] = p.get();
  ASSERT_EQ(predicted.points.size(), limit.points.size());
  for (const auto& p : predicted.points)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(p->sigma(c) / of_limit.at(p->id)->sigma(c), 1, 0.02) << p->id << " " << c;
}

/// The simulator's two surveys, each once as coordinates with their covariance and once as what they come from: jointly
/// adjusted with the photographs at the same weights they give the same anchors, because all is nearly linear.
TEST(SimulatedSurvey, JointlyAdjustedIsWhatItsCoordinatesGive) {
  for (const char* survey : {"coordinates", "readings"}) {
    NodeHarness site("simulate.observations"), two_steps("adjust.schur"), joint("adjust.joint");
    site.seed(3);
    site.set("floors", "1");
    site.set("images_per_floor", "6");
    site.set("survey", survey);
    site.run();
    for (NodeHarness* node : {&two_steps, &joint}) {
      for (std::size_t i = 0; i < site.output_count("observations"); ++i)
        node->input<ImageTags>("observations", site.output<ImageTags>("observations", i));
      node->input<Camera>("camera", site.output<Camera>("camera"));
      node->input<Plates>("plates", site.output<Plates>("plates"));
      node->input<Poses>("poses", site.output<Poses>("true_poses"));
      node->set("estimate_image_variance", "false");
      node->set("loss", "none");
    }
    two_steps.input<Points>("control", site.output<Points>("points"));
    joint.input<SurveyObservations>("survey", site.output<SurveyObservations>("survey"));
    joint.set("estimate_survey_variance", "false");
    two_steps.run();
    joint.run();
    const PointsT a = two_steps.output<Points>("points"), b = joint.output<Points>("points");
    ASSERT_EQ(a.points.size(), b.points.size());
    for (std::size_t i = 0; i < a.points.size(); ++i) {
      EXPECT_LT((a.points[i]->position - b.points[i]->position).norm(), 1e-6) << survey << " " << a.points[i]->id;
      EXPECT_LT((a.points[i]->sigma - b.points[i]->sigma).norm(), 1e-7) << survey << " " << a.points[i]->id;
    }
    EXPECT_GT((a.points[0]->position - site.output<Points>("points").points[0]->position).norm(), 1e-5)
        << "the photographs add something";
  }
}

TEST(SimulatedSurvey, HasErrorsOfCoordinatesOrOfReadings) {
  NodeHarness site("simulate.observations");
  site.set("floors", "1");
  site.set("survey", "readings");
  site.set("control_blunders", "0.1");
  try {
    site.run();
    FAIL() << "a blunder of a coordinate that nobody observed";
  } catch (const NodeFailed& error) {
    EXPECT_THAT(error.what(), HasSubstr("with survey=readings the errors are those of the instrument"));
  }
}

TEST(EvaluatePoses, CountsWhatIsWrongAndMissing) {
  PosesT truth;
  for (const char* path : {"a", "b", "c", "d", "e"}) {
    truth.poses.push_back(std::make_unique<PoseT>());
    truth.poses.back()->path = path;
    truth.poses.back()->cam_from_world = {quaternion_from_rotation_vector({0.3, 0, 0.1}), {1, 2, 3}};
  }
  PosesT found;
  for (int i = 0; i < 4; ++i) found.poses.push_back(std::make_unique<PoseT>(*truth.poses[i]));
  // A projection centre 3 mm off, and one half a metre off because of a wrong attitude.
  auto& shifted = found.poses[0]->cam_from_world;
  shifted.translation -= shifted.rotation * Eigen::Vector3d(0, 0.003, 0);
  auto& turned = found.poses[1]->cam_from_world;
  turned.rotation = quaternion_from_rotation_vector({0, 0.2, 0}) * turned.rotation;
  const double far = (turned.inverse().translation - truth.poses[1]->cam_from_world.inverse().translation).norm();
  NodeHarness node("evaluate.poses");
  node.input<Poses>("poses", found);
  node.input<Poses>("truth", truth);
  node.run();
  EXPECT_EQ(node.metric("images"), 5);
  EXPECT_EQ(node.metric("missing"), 1);
  EXPECT_EQ(node.metric("wrong"), 1);
  EXPECT_NEAR(node.metric("rms_position"), std::sqrt((9e-6 + far * far) / 4), 1e-12);
  EXPECT_NEAR(node.metric("median_position"), 0.003, 1e-12);
  EXPECT_NEAR(node.metric("max_rotation"), 0.2, 1e-12);
  EXPECT_EQ(node.output<Poses>("poses").poses.size(), 3u);
  node.set("max_missing", "0.1");
  EXPECT_THROW(node.run(), NodeFailed);
}

/// With control on the ground floor only, what helps is a survey higher up; the words say so.
TEST(PlanImages, AdvisesToSurveyWhereTheControlIsMissing) {
  NodeHarness site("simulate.observations"), plan("plan.images");
  site.seed(5);
  site.set("floors", "3");
  site.set("control", "ground_floor");
  site.run();
  for (std::size_t i = 0; i < site.output_count("observations"); ++i)
    plan.input<ImageTags>("observations", site.output<ImageTags>("observations", i));
  plan.input<Camera>("camera", site.output<Camera>("camera"));
  plan.input<Plates>("plates", site.output<Plates>("plates"));
  plan.input<Poses>("poses", site.output<Poses>("true_poses"));
  plan.input<Points>("points", site.output<Points>("truth"));
  plan.input<Points>("control", site.output<Points>("points"));
  plan.set("additions", "2");
  plan.run();
  const ImagePlanT result = plan.output<ImagePlan>("plan");
  ASSERT_EQ(result.additions.size(), 6u) << "two of each kind";
  EXPECT_EQ(result.additions[0]->what, "survey");
  EXPECT_EQ(result.additions[0]->of.substr(0, 3), "F03");
  EXPECT_LT(result.additions[0]->rmse_z, 0.7 * result.rmse_z);
  EXPECT_GT(result.rmse_3d, result.rmse_z);
  EXPECT_NEAR(result.pass_rate, 1, 0.02);
  const FileT file = plan.output<File>("verdict");
  EXPECT_THAT(std::string(file.content.begin(), file.content.end()), HasSubstr("survey: " + result.additions[0]->of));
}

PlatesT plates_of(int floors) {
  PlatesT table;
  for (int f = 1; f <= floors; ++f)
    for (int k = 1; k <= 4; ++k) {
      auto plate = std::make_unique<PlateT>();
      plate->anchor = "F" + std::to_string(f) + "-" + std::to_string(k);
      plate->tag_family = "tag36h11";
      plate->tag_id = 10 * f + k;
      plate->tag_size = 0.2;
      plate->role = k == 4 ? "check" : "control";
      plate->floor = f;
      table.plates.push_back(std::move(plate));
    }
  return table;
}

PointsT control_of(const PlatesT& table) {
  PointsT control;
  for (const auto& plate : table.plates)
    control.points.push_back(point(plate->anchor, 0, 0, plate->floor, plate->role));
  return control;
}

TEST(Withhold, EveryControlPointIsWithheldInOneFoldAndCheckPointsStay) {
  const PlatesT table = plates_of(3);
  std::map<std::string, int> withheld;
  for (int fold = 1; fold <= 3; ++fold) {
    NodeHarness node("evaluate.withhold");
    node.input<Plates>("plates", table);
    node.input<Points>("control", control_of(table));
    node.set("folds", "3");
    node.set("fold", std::to_string(fold));
    node.run();
    const PointsT check = node.output<Points>("withheld"), control = node.output<Points>("control");
    EXPECT_EQ(check.points.size(), 3u) << "nine control points in three folds";
    for (const auto& p : check.points) {
      EXPECT_EQ(p->role, "check");
      ++withheld[p->id];
    }
    size_t used = 0;
    for (const auto& p : control.points) used += p->role == "control";
    EXPECT_EQ(used, 6u);
    for (size_t i = 0; i < table.plates.size(); ++i)
      EXPECT_EQ(node.output<Plates>("plates").plates[i]->role, control.points[i]->role);
  }
  EXPECT_EQ(withheld.size(), 9u);
  for (const auto& [id, count] : withheld) EXPECT_EQ(count, 1) << id;
}

TEST(Withhold, AWholeFloor) {
  NodeHarness node("evaluate.withhold");
  const PlatesT table = plates_of(3);
  node.input<Plates>("plates", table);
  node.input<Points>("control", control_of(table));
  node.set("by", "floor");
  node.set("fold", "2");
  node.run();
  for (const auto& p : node.output<Points>("withheld").points) EXPECT_EQ(p->id.substr(0, 2), "F2");
  node.set("fold", "4");
  EXPECT_THROW(node.run(), NodeFailed);
}

TEST(Lengths, LargestErrorAgainstTheSpecification) {
  NodeHarness node("evaluate.lengths");
  node.input<Points>("model", points({{"A", 0, 0, 0, ""}, {"B", 3.001, 0, 0, ""}, {"C", 0, 4, 0, ""}}));
  node.input<Points>("reference", points({{"A", 0, 0, 0, "check"}, {"B", 3, 0, 0, "check"}, {"C", 0, 4, 0, "check"}}));
  node.set("a", "0.0005");
  node.set("k", "0.0001");
  node.run();
  EXPECT_EQ(node.metric("lengths"), 3);
  EXPECT_NEAR(node.metric("max_error"), 1e-3, 1e-9);               // AB; BC is off by 0.6 mm
  EXPECT_NEAR(node.metric("largest_share"), 1e-3 / 0.8e-3, 1e-6);  // of A + L / K at 3 m
  EXPECT_EQ(node.metric("exceeded"), 1);                           // BC: 0.6 mm of 1.0 mm
}

/// Leaving each control point out once ended in an error of this node, which no output needs.
TEST(Lengths, OfOnePointThereIsNoneAndThatIsSaid) {
  NodeHarness node("evaluate.lengths");
  node.input<Points>("model", points({{"A", 0, 0, 0, ""}, {"B", 3, 0, 0, ""}}));
  node.input<Points>("reference", points({{"A", 0, 0, 0, "check"}}));
  node.run();
  EXPECT_EQ(node.metric("lengths"), 0);
  NodeHarness elsewhere("evaluate.lengths");
  elsewhere.input<Points>("model", points({{"A", 0, 0, 0, ""}}));
  elsewhere.input<Points>("reference", points({{"X", 0, 0, 0, "check"}}));
  EXPECT_THROW(elsewhere.run(), NodeFailed);
}

}  // namespace trial_nodes_test
}  // namespace plumbline::test
