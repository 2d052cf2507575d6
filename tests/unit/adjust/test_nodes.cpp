// The nodes over their artifacts: what goes in, what comes out, what is refused. The algorithms are tested beside this.
#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>

#include "adjuster_inputs.hpp"
#include "artifacts/block.hpp"
#include "artifacts/camera_artifact.hpp"
#include "artifacts/fitted_datum.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/survey_artifact.hpp"
#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace test_nodes {

using namespace plumbline;
using namespace plumbline::test;
using testing::HasSubstr;

Eigen::MatrixXd covariance_of(const PointsT& points, const std::vector<std::string>& ids) {
  std::vector<int> rows;
  for (const auto& id : ids)
    for (size_t i = 0; i < points.points.size(); ++i)
      if (points.points[i]->id == id)
        for (int c = 0; c < 3; ++c) rows.push_back(3 * static_cast<int>(i) + c);
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(points.points.size());
  Eigen::MatrixXd all(size, size);
  size_t next = 0;
  for (Eigen::Index r = 0; r < size; ++r)
    for (Eigen::Index c = 0; c <= r; ++c) all(r, c) = all(c, r) = points.covariance[next++];
  return all(rows, rows);
}

TEST(AdjustCeresNode, CheckAnchorsAreNeverControl) {
  SyntheticFacade facade = make_facade(noisy);
  facade.plates.plates[2]->role = "check";
  NodeHarness plain("adjust.ceres");
  connect(plain, facade);
  plain.run();
  facade.control.points[2]->position.z() += 5;  // a survey nobody may look at
  NodeHarness disturbed("adjust.ceres");
  connect(disturbed, facade);
  disturbed.run();
  EXPECT_EQ(plain.output_bytes("points"), disturbed.output_bytes("points"));
  EXPECT_EQ(plain.output<Block>("block").control.size(), 7u);
  EXPECT_EQ(plain.output<Points>("points").points[2]->role, "check");
}

/// What control was fitted to cannot be seen in the block either, and without control nothing says where it stands.
TEST(AdjustCeresNode, PointsCarryHowTheirDatumCameAbout) {
  SyntheticFacade facade = make_facade(noisy);
  const auto mark_of = [&](bool with_control) {
    NodeHarness node("adjust.ceres");
    connect(node, facade, with_control);
    node.run();
    const PointsT points = node.output<Points>("points");
    return points.fitted_to_design ? points.fitted_to_design->origin : "none";
  };
  EXPECT_EQ(mark_of(true), "none");
  EXPECT_EQ(mark_of(false).find("adjusted without control"), 0u);
  mark_fitted(facade.control, "fitted to 24 anchors", 0.003);
  EXPECT_EQ(mark_of(true), "fitted to 24 anchors");
}

/// Scripts must not build on a block that contradicts its survey: the exit code comes from this metric.
TEST(AdjustCeresNode, ABlockThatFailsAGlobalTestIsNoResult) {
  SyntheticFacade facade = make_facade(noisy);
  NodeHarness sound("adjust.ceres"), spoilt("adjust.ceres");
  connect(sound, facade);
  sound.run();
  EXPECT_EQ(sound.metric("invalid"), 0);
  for (auto& point : facade.control.points) point->position.x() *= 1.02;
  connect(spoilt, facade);
  spoilt.run();
  EXPECT_EQ(spoilt.metric("invalid"), 1);
}

/// (5) tests its control by default. robust_control=false keeps the point, which the global test then refuses.
TEST(AdjustSchurNode, LeavesAWrongControlPointOutByDefault) {
  SyntheticFacade facade = make_facade(noisy);
  facade.control.points[0]->position.z() += 0.05;
  const std::string wrong = facade.control.points[0]->id;
  NodeHarness robust("adjust.schur"), kept("adjust.schur");
  connect(robust, facade);
  robust.run();
  EXPECT_EQ(robust.metric("invalid"), 0);
  EXPECT_THAT(robust.output<Block>("block").left_out,
              testing::ElementsAre(HasSubstr("the control of " + wrong + ", which contradicts the photographs")));
  connect(kept, facade);
  kept.set("robust_control", "false");
  kept.run();
  EXPECT_EQ(kept.metric("invalid"), 1);
  EXPECT_TRUE(kept.output<Block>("block").left_out.empty());
}

TEST(AdjustCeresNode, ControlGainsFromTheImages) {
  const SyntheticFacade facade = make_facade(noisy);
  NodeHarness node("adjust.ceres");
  connect(node, facade);
  node.set("estimate_image_variance", "false");
  node.run();
  const PointsT points = node.output<Points>("points");
  std::vector<std::string> ids;
  for (const auto& point : points.points) ids.push_back(point->id);
  const Eigen::MatrixXd gain = covariance_of(facade.control, ids) - covariance_of(points, ids);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gain).eigenvalues()(0), -1e-12);
  EXPECT_EQ(node.output<Camera>("camera").covariance.size(), 0u);  // a camera taken as exact stays so
}

TEST(AdjustCeresNode, FreeNetworkAndSelfCalibration) {
  const SyntheticFacade facade = make_facade(noisy);
  NodeHarness node("adjust.ceres");
  connect(node, facade, false);
  node.set("self_calibration", "free");
  node.run();
  const BlockT block = node.output<Block>("block");
  EXPECT_EQ(block.datum, "free");
  EXPECT_EQ(block.statistics->datum_defect, 6);
  EXPECT_TRUE(block.control.empty());
  EXPECT_EQ(block.images.size(), facade.images.size());
  const CameraT camera = node.output<Camera>("camera");
  EXPECT_EQ(camera.source, "self-calibration");
  EXPECT_EQ(camera.covariance.size(), 45u);
  EXPECT_NEAR(camera.parameters[0], facade.camera.fx, 5);
}

/// Images are their camera's by name; who projects with one camera only refuses the rest by name.
TEST(AdjustSchurNode, SeveralCamerasAreToldByTheirNames) {
  SyntheticFacade facade = make_facade(noisy);
  CameraT left = facade.camera_artifact(), right = left;
  left.id = "left", right.id = "right";
  right.parameters[0] += 1;  // a start
  CameraT both = joined_cameras({left, right});
  const auto run = [&](NodeHarness& node) {
    node.input<Camera>("camera", both);
    node.input<Plates>("plates", facade.plates);
    node.input<Poses>("poses", facade.poses);
    for (size_t i = 0; i < facade.images.size(); ++i) {
      facade.images[i].camera = i % 2 == 0 ? "left" : "right";
      node.input<ImageTags>("observations", facade.images[i]);
    }
    node.input<Points>("control", facade.control);
    node.set("self_calibration", "free");
    return failure(node);
  };
  for (const char* kind : {"adjust.schur", "adjust.ceres"}) {
    NodeHarness node(kind);
    ASSERT_EQ(run(node), "");
    const CameraT adjusted = node.output<Camera>("camera");
    EXPECT_EQ(adjusted.id, "left");
    ASSERT_EQ(adjusted.others.size(), 1u);
    EXPECT_EQ(adjusted.others[0]->id, "right");
    EXPECT_NE(adjusted.others[0]->parameters, adjusted.parameters);
    const BlockT block = node.output<Block>("block");
    ASSERT_EQ(block.interior_orientation.size(), 18u);
    EXPECT_EQ(block.interior_orientation[0]->name, "fx");
    EXPECT_EQ(block.interior_orientation[0]->camera, "left");
    EXPECT_EQ(block.interior_orientation[9]->name, "fx");
    EXPECT_EQ(block.interior_orientation[9]->camera, "right");
    EXPECT_GT(block.interior_orientation[9]->sigma, 0);
    EXPECT_EQ(block.interior_correlations.size(), 16u * 17 / 2);
    try {
      (void)camera_of(adjusted);
      FAIL() << "one camera is not both";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("of 2 cameras ('left', 'right')"));
    }
  }
  both.others[0]->id = "third";
  NodeHarness unnamed("adjust.schur");
  EXPECT_THAT(run(unnamed), HasSubstr("is of camera 'right', expected one of 'left', 'third'"));
  both.others[0]->id = "left";
  NodeHarness twice("adjust.schur");
  EXPECT_THAT(run(twice), HasSubstr("two cameras are called 'left'"));
}

/// What an adjustment finds beside the nine parameters leaves with camera and poses: evaluate.cost computes from them
/// what was minimised, and who projects with nine parameters only refuses by name.
TEST(AdjustSchurNode, ACameraWithMoreThanNineParametersIsWholeInItsArtifacts) {
  const SyntheticFacade facade = make_facade({.floors = 2, .pixel_sigma = 0.1, .survey_sigma = 0.001});
  const std::map<std::string, std::string> all = {
      {"", ""}, {"image_principal_point_sigma", "principal points of single images"}, {"free_interior", "(d1, d2)"}};
  for (const auto& [parameter, words] : all) {
    NodeHarness node("adjust.schur"), cost("evaluate.cost");
    connect(node, facade);
    for (const auto& [name, value] :
         {std::pair("estimate_image_variance", "false"), std::pair("loss", "none"), std::pair("reject_above", "0")})
      node.set(name, value);
    const auto tell_both = [&](const char* name, const char* value) { node.set(name, value), cost.set(name, value); };
    tell_both("tag_scale_sigma", "0.002");
    tell_both("corner_inset_sigma", "0.2");
    if (!parameter.empty()) tell_both("self_calibration", "free");
    if (parameter == "image_principal_point_sigma") tell_both("image_principal_point_sigma", "0.5");
    if (parameter == "free_interior")
      tell_both("free_interior",
                "fx\x1f"
                "d1\x1f"
                "d2");
    node.run();
    const CameraT camera = node.output<Camera>("camera");
    EXPECT_THAT(camera.beyond, HasSubstr(words));
    EXPECT_EQ(camera.beyond.empty(), words.empty());
    EXPECT_EQ(camera.image_principal_points, parameter == "image_principal_point_sigma");
    EXPECT_EQ(camera.distance_terms.size(), parameter == "free_interior" ? 2u : 0u);
    std::string refused;
    try {
      (void)camera_of(camera);
    } catch (const std::runtime_error& error) {
      refused = error.what();
    }
    EXPECT_THAT(refused, HasSubstr(words));
    EXPECT_EQ(refused.empty(), words.empty()) << refused;
    cost.input<Camera>("camera", camera);
    cost.input<Camera>("calibration", facade.camera_artifact());
    cost.input<Plates>("plates", facade.plates);
    cost.input<Poses>("poses", node.output<Poses>("poses"));
    cost.input<Points>("points", node.output<Points>("points"));
    cost.input<Points>("control", facade.control);
    for (const ImageTagsT& image : facade.images) cost.input<ImageTags>("observations", image);
    cost.run();
    double minimised = 0;
    for (const auto& group : node.output<Block>("block").groups) minimised += group->weighted_sum_of_squares;
    EXPECT_GT(cost.metric("cost_priors"), 0) << words;
    EXPECT_NEAR(cost.metric("cost") / minimised, 1, 1e-6) << words;
  }
}

/// A facade seen through a lens whose distortion changes with the distance, principal points shifted from image to
/// image, drawn here; who reads camera and poses finds the facade again.
TEST(CompleteCamera, IsTheOneThatTheFacadeWasSeenWith) {
  SyntheticFacade facade = make_facade({.floors = 1});
  CameraT whole = facade.camera_artifact();
  const double d1 = 2, reference = 7;
  whole.beyond = "distance-dependent distortion (d1, d2) and principal points of single images";
  whole.distance_terms = {d1, 0};
  whole.reference_distance = reference;
  whole.image_principal_points = true;
  Random random(5);
  for (size_t i = 0; i < facade.images.size(); ++i) {
    const Eigen::Vector2d shift(3 * random.normal(), 3 * random.normal());
    PoseT& pose = *facade.poses.poses[i];
    ASSERT_EQ(pose.path, facade.images[i].path);
    pose.principal_point = {shift.x(), shift.y()};
    for (const auto& tag : facade.images[i].tags) {
      const size_t j = static_cast<size_t>(tag->id);  // as make_facade() turns its plates
      const PlateT& plate = *facade.plates.plates[j];
      Random turn(1000 + j);
      const RigidTransform world_from_plate{
          plate.nominal_rotation * quaternion_from_rotation_vector(turn.normal3(0.02)),
          facade.truth.points[j]->position};
      const auto corners = tag_corners_in_plate({plate.tag_size, plate.tag_centre_in_plate});
      for (size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3d v = pose.cam_from_world * (world_from_plate * corners[k]);
        BrownCamera there = facade.camera;
        there.k1 += d1 * (1 / v.z() - 1 / reference);
        tag->corners[k] += *project(there, v) - *project(facade.camera, v) + shift;
      }
    }
  }
  CameraT nine = whole;
  nine.beyond.clear(), nine.distance_terms.clear(), nine.image_principal_points = false;
  const auto cost_with = [&](const CameraT& camera) {
    auto node = std::make_unique<NodeHarness>("evaluate.cost");
    node->input<Camera>("camera", camera);
    node->input<Plates>("plates", facade.plates);
    node->input<Poses>("poses", facade.poses);
    node->input<Points>("points", facade.truth);
    for (const ImageTagsT& image : facade.images) node->input<ImageTags>("observations", image);
    return node;
  };
  const auto judged = cost_with(whole), wrong = cost_with(nine);
  judged->run();
  wrong->run();
  EXPECT_LT(judged->metric("cost"), 1e-6);
  EXPECT_GT(wrong->metric("cost"), 1e4);

  const auto worst_of = [&](const PointsT& points) {
    double worst = 0;
    EXPECT_EQ(points.points.size(), facade.truth.points.size());
    for (size_t j = 0; j < points.points.size(); ++j)
      worst = std::max(worst, (points.points[j]->position - facade.truth.points[j]->position).norm());
    return worst;
  };
  for (const char* kind : {"triangulate.dlt", "triangulate.midpoint", "triangulate.angular"})
    for (const CameraT* camera : {&whole, &nine}) {
      NodeHarness node(kind);
      node.input<Camera>("camera", *camera);
      node.input<Plates>("plates", facade.plates);
      node.input<Poses>("poses", facade.poses);
      for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
      node.run();
      const double worst = worst_of(node.output<Points>("points"));
      if (camera == &whole)
        EXPECT_LT(worst, 1e-7) << kind;
      else
        EXPECT_GT(worst, 1e-4) << kind;
    }

  // Held, it goes through an adjustment as it came.
  NodeHarness node("adjust.schur");
  node.input<Camera>("camera", whole);
  node.input<Plates>("plates", facade.plates);
  node.input<Poses>("poses", facade.poses);
  for (auto& point : facade.control.points) point->sigma.setConstant(0.001);
  node.input<Points>("control", facade.control);
  for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
  node.set("self_calibration", "off");
  node.set("tag_scale_sigma", "0");
  node.run();
  EXPECT_LT(worst_of(node.output<Points>("points")), 1e-6);
  const CameraT out = node.output<Camera>("camera");
  EXPECT_EQ(out.distance_terms, whole.distance_terms);
  EXPECT_NEAR(out.reference_distance, reference, 1e-12);
  EXPECT_TRUE(out.image_principal_points);
  const PosesT poses = node.output<Poses>("poses");
  for (size_t i = 0; i < poses.poses.size(); ++i)
    EXPECT_EQ(poses.poses[i]->principal_point, facade.poses.poses[i]->principal_point);

  // Words without numbers are of an older version; a pose without its principal point is of another adjustment.
  CameraT words = nine;
  words.beyond = "distance-dependent distortion (d1, d2)";
  const auto older = cost_with(words);
  EXPECT_THAT(failure(*older), HasSubstr("distance-dependent distortion (d1, d2) beside its parameters"));
  facade.poses.poses[2]->principal_point.clear();
  const auto mixed = cost_with(whole);
  EXPECT_THAT(failure(*mixed), HasSubstr("the pose of " + facade.images[2].path + " has none"));
}

TEST(AdjustCeresNode, LambdaIsReported) {
  NodeHarness node("adjust.ceres");
  connect(node, make_facade(noisy));
  node.set("weighting", "lambda");
  node.set("lambda", "10000");
  node.run();
  EXPECT_EQ(node.output<Block>("block").weighting, "lambda");
  EXPECT_EQ(node.output<Block>("block").lambda, 1e4);
}

TEST(AdjustSchurNode, LambdaSaysWhatItBelievesOfTheSurvey) {
  const auto with = [](const char* lambda) {
    NodeHarness node("adjust.schur");
    connect(node, make_facade({.floors = 1, .pixel_sigma = 0.2, .survey_sigma = 0.001}));
    node.set("weighting", "lambda");
    node.set("lambda", lambda);
    node.run();
    return std::pair(node.output<Block>("block").lambda_control_sigma, node.warnings());
  };
  // Corners of 0.2 px and coordinates of 1 mm: (0.2 / 0.001)² = 40 000.
  const auto [right, silent] = with("40000");
  EXPECT_NEAR(right, 0.001, 1e-4);
  EXPECT_THAT(silent, testing::Not(testing::Contains(HasSubstr("believes"))));
  const auto [wrong, said] = with("1");
  EXPECT_NEAR(wrong, 0.2, 0.02);
  EXPECT_THAT(said,
              testing::Contains(testing::AllOf(HasSubstr("λ of 1 px²/m² believes a standard deviation of"),
                                               HasSubstr("the survey states 1 mm"), HasSubstr("would be right"))));
}

TEST(AdjustCeresNode, RefusesContradictions) {
  SyntheticFacade twice = make_facade(noisy);
  twice.plates.plates[1]->tag_id = twice.plates.plates[0]->tag_id;
  NodeHarness same_tag("adjust.ceres");
  connect(same_tag, twice);
  EXPECT_THAT(failure(same_tag), HasSubstr("tag tag36h11:0 stands for both F01-C01-R1 and F01-C02-R1"));

  SyntheticFacade broken = make_facade(noisy);
  broken.images[0].tags[0]->corners[1].x() = std::nan("");
  NodeHarness no_number("adjust.ceres");
  connect(no_number, broken);
  EXPECT_THAT(failure(no_number), HasSubstr("in image100.jpg has a corner that is not a number"));

  SyntheticFacade short_camera = make_facade(noisy);
  CameraT camera = short_camera.camera_artifact();
  camera.parameters.pop_back();
  NodeHarness eight("adjust.ceres");
  eight.input<Camera>("camera", camera);
  eight.input<Plates>("plates", short_camera.plates);
  eight.input<Poses>("poses", short_camera.poses);
  EXPECT_THAT(failure(eight), HasSubstr("camera 'camera' has 8 parameters, expected 9: fx, fy"));
}

TEST(AdjustCeresNode, TwoControlPointsLeaveARotation) {
  SyntheticFacade facade = make_facade(noisy);
  for (auto& plate : facade.plates.plates)
    if (plate->column != 2) plate->role = "check";
  NodeHarness node("adjust.ceres");
  connect(node, facade);
  EXPECT_THAT(failure(node), HasSubstr("rotation about the line through F01-C02-R1 and F01-C02-R2"));
}

TEST(AdjustColmapNode, RefusesMeasuredTargetsInWords) {
  NodeHarness node("adjust.colmap");
  node.input<ImageBlock>("block", ImageBlockT());
  EXPECT_THAT(failure(node), HasSubstr("use adjust.schur or adjust.ceres"));
}

TEST(AdjusterNode, NeedsTagsOrTargets) {
  NodeHarness node("adjust.schur");
  EXPECT_THAT(failure(node), HasSubstr("connect either 'observations', 'poses', 'camera' and 'plates'"));
}

TEST(AdjusterNode, GlobalTestsNameAWrongCalibration) {
  SyntheticFacade facade = make_facade(noisy);
  NodeHarness sound("adjust.schur");
  connect(sound, facade);
  sound.run();
  const BlockT good = sound.output<Block>("block");
  EXPECT_GE(good.tests.size(), 2u);
  for (const auto& test : good.tests) EXPECT_TRUE(test->passed) << test->group << " " << test->variance_factor;
  CameraT camera = facade.camera_artifact();
  camera.parameters[0] *= 1.01;
  camera.parameters[1] *= 1.01;
  NodeHarness wrong("adjust.schur");
  wrong.input<Camera>("camera", camera);
  wrong.input<Plates>("plates", facade.plates);
  wrong.input<Poses>("poses", facade.poses);
  for (const ImageTagsT& image : facade.images) wrong.input<ImageTags>("observations", image);
  wrong.input<Points>("control", facade.control);
  wrong.run();
  bool failed = false;
  for (const auto& test : wrong.output<Block>("block").tests)
    failed = failed || (!test->passed && !test->words.empty());
  EXPECT_TRUE(failed);
}

}  // namespace test_nodes
