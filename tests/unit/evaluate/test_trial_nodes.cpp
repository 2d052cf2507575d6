// evaluate.errors, evaluate.crlb, evaluate.withhold and evaluate.lengths as nodes.
#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/image_plan.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/survey_observations.hpp"
#include "geometry/packed_symmetric.hpp"
#include "geometry/random.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"

namespace plumbline::test {
namespace test_trial_nodes {

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

std::string in_full(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
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

/// Six points off by what is drawn, one of them no check point and one missing in the model.
TEST(Errors, EveryMetricIsThatOfItsName) {
  Random random(5);
  PointsT model, truth;
  for (int i = 0; i < 6; ++i) {
    const std::string id(1, static_cast<char>('A' + i));
    const Eigen::Vector3d place = random.normal3(10), off = random.normal3(0.004);
    truth.points.push_back(point(id, place.x(), place.y(), place.z(), i == 2 ? "control" : "check"));
    if (i != 4) model.points.insert(model.points.begin(), point(id, 0, 0, 0, ""));  // in another order
    if (i != 4) model.points.front()->position = place + off;
  }
  const auto covariance = [&](PointsT& of, double sigma) {
    const auto n = static_cast<Eigen::Index>(3 * of.points.size());
    Eigen::MatrixXd root(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) root(i, j) = random.normal(sigma / std::sqrt(static_cast<double>(n)));
    const Eigen::MatrixXd all = root * root.transpose() + 1e-7 * Eigen::MatrixXd::Identity(n, n);
    of.covariance = pack_symmetric(all);
    return all;
  };
  const Eigen::MatrixXd of_model = covariance(model, 0.003), of_truth = covariance(truth, 0.002);
  NodeHarness node("evaluate.errors");
  node.input<Points>("model", model);
  node.input<Points>("truth", truth);
  node.set("max_missing", "0.3"), node.set("mounting_sigma", "0.001");
  node.run();
  std::vector<Eigen::Index> in_model, in_truth, heights = {2, 5, 8, 11};
  Eigen::VectorXd off(12);
  for (Eigen::Index k = 0; const Eigen::Index i : {0, 1, 3, 5}) {
    const Eigen::Index at = i < 4 ? 4 - i : 0;  // in the model, which has no E and is the other way round
    for (Eigen::Index c = 0; c < 3; ++c) in_model.push_back(3 * at + c), in_truth.push_back(3 * i + c);
    off.segment<3>(3 * k++) = model.points[at]->position - truth.points[i]->position;
  }
  const Eigen::MatrixXd all = Eigen::MatrixXd(of_model(in_model, in_model)) +
                              Eigen::MatrixXd(of_truth(in_truth, in_truth)) + 1e-6 * Eigen::MatrixXd::Identity(12, 12);
  const Eigen::VectorXd z = off(heights);
  const Eigen::MatrixXd of_z = all(heights, heights);
  double farthest = 0;
  for (Eigen::Index k = 0; k < 4; ++k) farthest = std::max(farthest, off.segment<3>(3 * k).norm());
  const std::map<std::string, double> expected = {{"points", 4},
                                                  {"missing", 1},
                                                  {"rmse_z", z.norm() / 2},
                                                  {"bias_z", z.mean()},
                                                  {"max_abs_z", z.cwiseAbs().maxCoeff()},
                                                  {"rmse_3d", off.norm() / 2},
                                                  {"max_3d", farthest},
                                                  {"predicted_rmse_z", std::sqrt(of_z.trace() / 4)},
                                                  {"predicted_rmse_3d", std::sqrt(all.trace() / 4)},
                                                  {"nees_z", z.dot(of_z.inverse() * z)},
                                                  {"freedom_z", 4},
                                                  {"nees_3d", off.dot(all.inverse() * off)},
                                                  {"freedom_3d", 12}};
  for (const auto& [name, value] : expected)
    EXPECT_NEAR(node.metric(name), value, 1e-9 * (1 + std::abs(value))) << name;
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

/// NEES of poses in rotation vector and translation, both in the camera frame, in which a pose has its covariance.
TEST(EvaluatePoses, EveryMetricIsThatOfItsName) {
  Random random(3);
  PosesT truth, found;
  double squares = 0, positions = 0, rotations = 0, farthest = 0, most_turned = 0;
  for (int k = 0; k < 3; ++k) {
    truth.poses.push_back(std::make_unique<PoseT>());
    PoseT& exact = *truth.poses.back();
    exact.path = std::string(1, static_cast<char>('a' + k));
    exact.cam_from_world = {quaternion_from_rotation_vector(random.normal3(1)), random.normal3(5)};
    Eigen::Matrix<double, 6, 6> root;
    for (double& value : root.reshaped()) value = random.normal(0.001);
    const Eigen::Matrix<double, 6, 6> covariance =
        root * root.transpose() + 1e-8 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> off;
    for (double& value : off) value = random.normal(0.001);
    found.poses.push_back(std::make_unique<PoseT>(exact));
    PoseT& pose = *found.poses.back();
    pose.cam_from_world.rotation = quaternion_from_rotation_vector(-off.head<3>()) * exact.cam_from_world.rotation;
    pose.cam_from_world.translation -= off.tail<3>();
    if (k < 2) {
      pose.covariance = pack_symmetric(covariance);
      squares += off.dot(covariance.inverse() * off);
    }
    const double place =
        (pose.cam_from_world.inverse().translation - exact.cam_from_world.inverse().translation).norm();
    const double turn = off.head<3>().norm();
    positions += place * place / 3, rotations += turn * turn / 3;
    farthest = std::max(farthest, place), most_turned = std::max(most_turned, turn);
  }
  NodeHarness node("evaluate.poses");
  node.input<Poses>("poses", found), node.input<Poses>("truth", truth), node.run();
  const std::map<std::string, double> expected = {{"pose_nees", squares / 12},
                                                  {"pose_freedom", 12},
                                                  {"missing", 0},
                                                  {"max_position", farthest},
                                                  {"max_rotation", most_turned},
                                                  {"rms_position", std::sqrt(positions)},
                                                  {"rms_rotation", std::sqrt(rotations)}};
  for (const auto& [name, value] : expected) EXPECT_NEAR(node.metric(name), value, 1e-6 * (1e-3 + value)) << name;
  node.set("wrong_above", in_full(0.999 * farthest));
  node.run();
  EXPECT_EQ(node.metric("wrong"), 1);
  EXPECT_EQ(node.output<Poses>("poses").poses.size(), 2u);
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

/// A small site with all that nodes about it are given.
NodeHarness given(const std::string& kind, const std::vector<std::pair<std::string, std::string>>& settings = {}) {
  static const NodeHarness* const site = [] {
    auto* made = new NodeHarness("simulate.observations");
    made->seed(5), made->set("floors", "2"), made->set("images_per_floor", "4");
    made->set("control", "two_per_floor");
    made->run();
    return made;
  }();
  NodeHarness node(kind);
  if (node.has_input("observations"))
    for (std::size_t i = 0; i < site->output_count("observations"); ++i)
      node.input<ImageTags>("observations", site->output<ImageTags>("observations", i));
  if (node.has_input("camera")) node.input<Camera>("camera", site->output<Camera>("camera"));
  node.input<Plates>("plates", site->output<Plates>("plates"));
  if (node.has_input("poses")) node.input<Poses>("poses", site->output<Poses>("true_poses"));
  if (node.has_input("points")) node.input<Points>("points", site->output<Points>("truth"));
  for (const char* surveyed : {"control", "model", "survey"})
    if (node.has_input(surveyed)) node.input<Points>(surveyed, site->output<Points>("points"));
  if (node.has_input("truth")) node.input<Points>("truth", site->output<Points>("truth"));
  for (const auto& [name, value] : settings) node.set(name, value);
  return node;
}

/// What a plan says is what the bound of the same photographs says, and its list is what is worth most.
TEST(PlanImages, ItsFiguresAreThoseOfTheBound) {
  NodeHarness node = given("plan.images", {{"tolerance", "0.002"}, {"additions", "3"}}), bound = given("evaluate.crlb");
  node.run(), bound.run();
  const ImagePlanT plan = node.output<ImagePlan>("plan");
  EXPECT_NEAR(plan.rmse_z, bound.metric("rmse_z"), 1e-12);
  EXPECT_NEAR(plan.rmse_3d, bound.metric("rmse_3d"), 1e-12);
  EXPECT_NEAR(plan.drift_sigma, bound.metric("drift"), 1e-12);
  EXPECT_NEAR(plan.relative_drift_sigma, bound.metric("relative_drift"), 1e-12);
  EXPECT_NEAR(plan.pass_rate, bound.metric("within_2mm"), 1e-12);
  double squares = 0, distances = 0, worst = 0, count = 0, inside = 0;
  std::string of_worst;
  for (const auto& p : bound.output<Points>("bound").points) {
    if (p->role != "check") continue;
    squares += p->sigma.z() * p->sigma.z(), distances += p->sigma.squaredNorm(), ++count;
    inside += std::erf(0.002 / p->sigma.z() / std::sqrt(2.0));
    if (p->sigma.z() > worst) worst = p->sigma.z(), of_worst = p->id;
  }
  ASSERT_GT(count, 1);
  EXPECT_NEAR(plan.rmse_z, std::sqrt(squares / count), 1e-12);
  EXPECT_NEAR(plan.rmse_3d, std::sqrt(distances / count), 1e-12);
  EXPECT_NEAR(plan.pass_rate, inside / count, 1e-9);
  EXPECT_NEAR(plan.worst_sigma, worst, 1e-12);
  EXPECT_EQ(plan.worst, of_worst);
  ASSERT_EQ(plan.additions.size(), 9u) << "three of each kind";
  for (size_t i = 1; i < plan.additions.size(); ++i) EXPECT_LE(plan.additions[i]->gain, plan.additions[i - 1]->gain);
  for (const auto& addition : plan.additions) EXPECT_LT(addition->rmse_z, plan.rmse_z) << addition->of;
}

TEST(NodesOfTrials, EveryParameterHasItsEffect) {
  const auto situation = [](const std::string& kind,
                            const std::vector<std::pair<std::string, std::string>>& settings = {}) -> Situation {
    return [=] { return given(kind, settings); };
  };
  // Corners of the site have their covariance: what is taken of those without is not looked at.
  EXPECT_EQ(parameters_at_fault({situation("plan.images")}, {"corner_sigma"}), "");
  EXPECT_EQ(parameters_at_fault({situation("evaluate.crlb")}, {"corner_sigma"}), "");
  EXPECT_EQ(parameters_at_fault({situation("evaluate.accuracy")}), "");
  EXPECT_EQ(parameters_at_fault({situation("evaluate.withhold")}), "");
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

TEST(Lengths, EveryMetricIsThatOfItsName) {
  NodeHarness node("evaluate.lengths");
  node.input<Points>("model", points({{"A", 0, 0, 0, ""}, {"B", 3.002, 0, 0, ""}, {"C", 0, 3.999, 0, ""}}));
  node.input<Points>("reference", points({{"A", 0, 0, 0, "check"}, {"B", 3, 0, 0, "check"}, {"C", 0, 4, 0, "check"}}));
  const double ab = 0.002, ac = -0.001, bc = std::hypot(3.002, 3.999) - 5;
  const auto expect = [&](const std::vector<double>& errors, double longest) {
    double sum = 0, squares = 0, largest = 0;
    for (const double error : errors)
      sum += error, squares += error * error, largest = std::max(largest, std::abs(error));
    const auto n = static_cast<double>(errors.size());
    EXPECT_EQ(node.metric("lengths"), n);
    EXPECT_NEAR(node.metric("mean_error"), sum / n, 1e-12);
    EXPECT_NEAR(node.metric("rms_error"), std::sqrt(squares / n), 1e-12);
    EXPECT_NEAR(node.metric("max_error"), largest, 1e-12);
    EXPECT_NEAR(node.metric("longest"), longest, 1e-12);
  };
  node.run();
  expect({ab, ac, bc}, 5);
  const PointsT off = node.output<Points>("errors");
  EXPECT_NEAR(off.points[0]->sigma.x(), 0.002, 1e-12) << "the largest of those that end at A";
  EXPECT_NEAR(off.points[2]->sigma.x(), 0.001, 1e-12);
  node.set("shortest", "3.5"), node.run();
  expect({ac, bc}, 5);
  EXPECT_TRUE(node.warnings().empty());
  node.set("shortest", "100"), node.run();
  EXPECT_EQ(node.metric("lengths"), 0);
  ASSERT_EQ(node.warnings().size(), 1u);
  EXPECT_THAT(node.warnings()[0], HasSubstr("between the 3 reference points")) << "they are in the model";
}

/// Of what is withheld the covariance goes with it, and no other's.
TEST(Withhold, WhatIsWithheldKeepsItsOwnCovariance) {
  const PlatesT table = plates_of(3);
  PointsT control = control_of(table);
  const size_t n = 3 * control.points.size();
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j <= i; ++j) control.covariance.push_back(1e-6 * static_cast<double>(100 * i + j));
  NodeHarness node("evaluate.withhold");
  node.input<Plates>("plates", table), node.input<Points>("control", control);
  node.set("by", "floor"), node.set("fold", "2"), node.run();
  const PointsT part = node.output<Points>("withheld");
  ASSERT_EQ(part.points.size(), 3u) << "the check point of the floor was none before";
  for (size_t i = 0; i < 9; ++i)
    for (size_t j = 0; j <= i; ++j)
      EXPECT_NEAR(part.covariance.at(i * (i + 1) / 2 + j), 1e-6 * static_cast<double>(100 * (12 + i) + 12 + j), 1e-15);
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

}  // namespace test_trial_nodes
}  // namespace plumbline::test
