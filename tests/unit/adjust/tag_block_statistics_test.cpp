// Every number that a tag block states of itself, held by something that does not share its code: repeated simulation
// for covariances, a second adjustment with a disturbed observation for influences, a plain computation for residuals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>

#include "block/tag_block_model.hpp"
#include "block/tag_cost.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace {

using namespace plumbline;
using test::error_of;
using testing::HasSubstr;

adjust::TagBlockOptions plain_options() {
  auto options = test::bound_options();
  options.fixed_aspect = false;
  return options;
}

TEST(TagBlockStatistics, PosesAndInteriorOrientationCoverTheirErrors) {
  const int trials = std::getenv("PLUMBLINE_LONG") ? 200 : 8;
  double poses = 0, interior = 0;
  int pose_count = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto synthetic = test::make_block({.floors = 1, .stations = 3, .seed = 500u + static_cast<uint64_t>(trial)});
    const auto result = adjust::adjust_tag_block(synthetic.block, plain_options());
    for (size_t i = 0; i < result.cam_from_world.size(); i += 5) {
      const RigidTransform &found = *result.cam_from_world[i], &truth = synthetic.cam_from_world[i];
      const Eigen::Quaterniond turn = found.rotation * truth.rotation.conjugate();
      Eigen::VectorXd error(6);
      error << 2 * (turn.w() < 0 ? -1 : 1) * turn.vec(), found.translation - truth.translation;
      poses += error.dot(result.pose_covariance[i].ldlt().solve(error)) / 6;
      ++pose_count;
    }
    const auto found = result.camera.parameters(), truth = synthetic.camera.parameters();
    const std::vector<int> free = {0, 1, 2, 3, 4, 5, 7, 8};
    Eigen::VectorXd error(8);
    for (size_t k = 0; k < free.size(); ++k)
      error(static_cast<Eigen::Index>(k)) = found[static_cast<size_t>(free[k])] - truth[static_cast<size_t>(free[k])];
    interior += error.dot(Eigen::MatrixXd(result.camera_covariance(free, free)).ldlt().solve(error)) / 8;
  }
  // Poses of one trial share the survey's and the camera's errors: the trials count, not the poses.
  EXPECT_NEAR(poses / pose_count, 1, 4 * std::sqrt(2.0 / (6 * trials)));
  EXPECT_NEAR(interior / trials, 1, 4 * std::sqrt(2.0 / (8 * trials)));
}

TEST(TagBlockStatistics, CornersAreWeightedByTheirFullCovariance) {
  auto synthetic = test::make_block({.floors = 1, .noise = false});
  Eigen::Matrix2d covariance;
  covariance << 0.04, 0.03, 0.03, 0.09;
  for (auto& seen : synthetic.block.observations) seen.covariances.fill(covariance);
  std::vector<std::string> left_out;
  const auto start =
      adjust::start_tag_block(synthetic.block, std::vector<bool>(synthetic.block.observations.size(), true), left_out);
  const auto model = adjust::build_tag_model(synthetic.block, plain_options(), start);
  for (const auto& whitening : model.problem.image_tags.front().whitening)
    EXPECT_LT((whitening.transpose() * whitening * covariance - Eigen::Matrix2d::Identity()).norm(), 1e-12);
}

TEST(TagBlockStatistics, ImageVarianceIsEstimatedTheRightWayUp) {
  auto synthetic = test::make_block({.floors = 1});
  for (auto& seen : synthetic.block.observations)
    for (auto& covariance : seen.covariances) covariance /= 9;  // the detector claims a third of its noise
  auto options = plain_options();
  options.estimate_image_variance = true;
  const auto result = adjust::adjust_tag_block(synthetic.block, options);
  EXPECT_NEAR(result.image_variance_factor, 9, 0.9);
  const auto right = adjust::adjust_tag_block(test::make_block({.floors = 1}).block, options);
  EXPECT_NEAR(right.image_variance_factor, 1, 0.1);
  EXPECT_LT((result.pose_covariance[3] - right.pose_covariance[3]).norm(), 0.01 * right.pose_covariance[3].norm());
}

TEST(TagBlockStatistics, ResidualsAreThoseOfTheProjection) {
  const auto synthetic = test::make_block({.floors = 1});
  auto options = plain_options();
  options.tag_scale_sigma = 0;
  const auto result = adjust::adjust_tag_block(synthetic.block, options);
  for (const auto& tag : result.tags) {
    const auto& seen = synthetic.block.observations[static_cast<size_t>(tag.observation)];
    const Eigen::Index at = test::row_of_plate(result, seen.plate);
    double squares = 0;
    const auto corners = tag_corners_in_plate(synthetic.block.plates[static_cast<size_t>(seen.plate)].plate);
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d world =
          result.anchors.segment<3>(at) + result.world_from_plate[static_cast<size_t>(at / 3)] * corners[k];
      squares +=
          (*project(result.camera, *result.cam_from_world[static_cast<size_t>(seen.image)] * world) - seen.corners[k])
              .squaredNorm();
    }
    EXPECT_NEAR(tag.rms, std::sqrt(squares / 8), 1e-6);
  }
}

/// An error of the size of the MDB in one control coordinate, put in: the largest height change is the one stated.
TEST(TagBlockStatistics, EffectOnHeightsIsThatOfADisturbedControlPoint) {
  const auto synthetic = test::make_block({.floors = 2, .noise = false});
  const auto before = adjust::adjust_tag_block(synthetic.block, plain_options());
  for (const size_t coordinate : {size_t{0}, size_t{2}}) {
    const size_t point = 5;
    auto disturbed = synthetic.block;
    const double mdb = before.control[point].coordinates[coordinate].mdb;
    disturbed.control.position(static_cast<Eigen::Index>(3 * point + coordinate)) += mdb;
    const auto after = adjust::adjust_tag_block(disturbed, plain_options());
    double largest = 0;
    for (Eigen::Index j = 2; j < after.anchors.size(); j += 3)
      largest = std::max(largest, std::abs(after.anchors(j) - before.anchors(j)));
    EXPECT_NEAR(before.control[point].effect_on_height[coordinate] / largest, 1, 0.02) << coordinate;
    EXPECT_NEAR(
        std::abs(after.control[point].coordinates[coordinate].w - before.control[point].coordinates[coordinate].w),
        4.13, 0.05);
  }
}

TEST(TagBlockStatistics, GlobalTestsTellWhatIsWrong) {
  auto options = test::bound_options();
  options.estimate_image_variance = true;
  options.tag_scale_sigma = 1e-3;
  const auto failed = [&](const test::SyntheticBlock& synthetic, const adjust::TagBlockOptions& how) {
    std::string groups;
    for (const auto& test : adjust::adjust_tag_block(synthetic.block, how).tests)
      if (!test.passed) groups += test.group + ";";
    return groups;
  };
  auto sound = test::make_block({.floors = 2});
  EXPECT_EQ(failed(sound, options), "");
  auto printed = sound;  // at 98 %
  for (auto& plate : printed.block.plates) plate.plate.tag_size /= 0.98;
  EXPECT_THAT(failed(printed, options), HasSubstr("tag scale prior"));
  auto held = options;
  held.self_calibration = false;
  auto focal = sound;
  focal.block.camera = sound.camera;
  EXPECT_EQ(failed(focal, held), "");
  focal.block.camera.fx *= 1.03;
  focal.block.camera.fy *= 1.03;
  EXPECT_THAT(failed(focal, held), HasSubstr("images"));
  focal.block.camera_covariance = Eigen::MatrixXd::Zero(9, 9);
  focal.block.camera_covariance.diagonal() << 9, 9, 9, 9, 1e-6, 1e-6, 0, 1e-8, 1e-8;
  EXPECT_THAT(failed(focal, options), HasSubstr("interior prior"));
  auto survey = sound;  // a set-up 2 cm too high
  for (Eigen::Index k = 2; k < survey.block.control.position.size() / 2; k += 3)
    survey.block.control.position(k) += 0.02;
  EXPECT_THAT(failed(survey, options), HasSubstr("control"));
}

TEST(TagBlockStatistics, SurveyInAnotherFrameUnitOrOrder) {
  const auto synthetic = test::make_block({.floors = 2});
  const auto options = plain_options();
  const auto here = adjust::adjust_tag_block(synthetic.block, options);
  EXPECT_TRUE(here.warnings.empty());
  const RigidTransform move{quaternion_from_rotation_vector({0, 0, 2.1}), {691000, 5335000, 500}};
  auto elsewhere = synthetic.block;
  for (Eigen::Index k = 0; k < elsewhere.control.position.size(); k += 3)
    elsewhere.control.position.segment<3>(k) = move * Eigen::Vector3d(synthetic.block.control.position.segment<3>(k));
  const auto there = adjust::adjust_tag_block(elsewhere, options);
  ASSERT_EQ(there.warnings.size(), 1u);
  EXPECT_THAT(there.warnings[0], HasSubstr("different frames"));
  for (Eigen::Index k = 0; k < here.anchors.size(); k += 3)
    EXPECT_LT((there.anchors.segment<3>(k) - move * Eigen::Vector3d(here.anchors.segment<3>(k))).norm(), 1e-6);

  auto feet = synthetic.block;
  feet.control.position /= 0.3048;
  EXPECT_THAT(error_of([&] { adjust::adjust_tag_block(feet, options); }), HasSubstr("feet"));
  auto swapped = synthetic.block;
  const Eigen::Vector3d first = swapped.control.position.segment<3>(0);
  swapped.control.position.segment<3>(0) = Eigen::Vector3d(swapped.control.position.segment<3>(9));
  swapped.control.position.segment<3>(9) = first;
  EXPECT_THAT(error_of([&] { adjust::adjust_tag_block(swapped, options); }),
              HasSubstr("the plate of F01-C01-R1 hangs where the survey has F01-C02-R2"));
}

/// The cost that anybody computes of a result is the one that the adjustment reached, and no other place has less.
TEST(TagCost, IsWhatTheAdjustmentMinimised) {
  auto synthetic = test::make_block({.floors = 1});
  synthetic.block.camera = synthetic.camera;
  adjust::TagBlockOptions options;
  options.self_calibration = options.estimate_image_variance = false;
  options.tag_scale_sigma = options.reject_above = 0;
  options.loss = adjust::RobustLoss::none;
  const auto result = adjust::adjust_tag_block(synthetic.block, options);
  std::map<std::string, Eigen::Vector3d> start, found;
  for (size_t j = 0; j < result.plates.size(); ++j) {
    const size_t plate = static_cast<size_t>(result.plates[j]);
    found[synthetic.block.plates[plate].anchor] = result.anchors.segment<3>(3 * static_cast<Eigen::Index>(j));
    start[synthetic.block.plates[plate].anchor] = synthetic.anchors[plate];
  }
  const double at_start = adjust::cost_of_tag_block(synthetic.block, start).total();
  // Where an adjustment starts by itself, from approximate poses and from true ones.
  const adjust::TagCost own_start = adjust::start_cost_of_tag_block(synthetic.block);
  EXPECT_GT(own_start.total(), 10 * result.weighted_sum_of_squares);
  EXPECT_EQ(own_start.left_out, 0);
  adjust::TagBlock at_truth = synthetic.block;
  at_truth.camera = synthetic.camera;
  for (size_t i = 0; i < at_truth.images.size(); ++i) at_truth.images[i].cam_from_world = synthetic.cam_from_world[i];
  EXPECT_LT(adjust::start_cost_of_tag_block(at_truth).total(), 0.01 * own_start.total());
  adjust::TagBlock adjusted = synthetic.block;
  for (size_t i = 0; i < adjusted.images.size(); ++i) adjusted.images[i].cam_from_world = result.cam_from_world[i];
  const adjust::TagCost cost = adjust::cost_of_tag_block(adjusted, found);
  EXPECT_NEAR(cost.total() / result.weighted_sum_of_squares, 1, 1e-7);
  EXPECT_EQ(cost.corner_rows + cost.control_rows, result.observations);
  EXPECT_EQ(cost.left_out, 0);
  EXPECT_GT(at_start, 1.1 * cost.total());
  adjusted.images[3].cam_from_world->translation.x() += 1e-4;
  EXPECT_GT(adjust::cost_of_tag_block(adjusted, found).total(), cost.total());
  found.erase(synthetic.block.plates[0].anchor);
  EXPECT_GT(adjust::cost_of_tag_block(adjusted, found).left_out, 0);
}

}  // namespace
