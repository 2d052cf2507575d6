// Blocks of tags photographed by several cameras.
#include <gmock/gmock.h>

#include "synthetic_block.hpp"

namespace test_tag_block_cameras {

using namespace plumbline;
using testing::HasSubstr;
using testing::Not;

const std::vector<int> calibrated = {0, 1, 2, 3, 4, 5, 7, 8};  // fx, fy, cx, cy, k1, k2, p1, p2

block::TagBlockOptions plain_options() {
  auto options = test::bound_options();
  options.fixed_aspect = false;
  return options;
}

double largest_error(const test::SyntheticBlock& synthetic, const block::TagBlockResult& result) {
  double largest = 0;
  for (size_t j = 0; j < result.plates.size(); ++j)
    largest = std::max(largest, (result.anchors.segment<3>(3 * j) - synthetic.anchors[result.plates[j]]).norm());
  return largest;
}

TEST(SeveralCameras, EachHasAnInteriorOrientationOfItsOwn) {
  auto synthetic = test::make_block({.noise = false, .two_cameras = true});
  for (const bool with_poses : {true, false}) {
    if (!with_poses)  // the approximate pose of an image from plates is one by its own camera
      for (size_t i = 2; i < synthetic.block.images.size(); ++i) synthetic.block.images[i].cam_from_world.reset();
    const auto result = block::adjust_tag_block(synthetic.block, plain_options());
    EXPECT_TRUE(result.left_out.empty());
    EXPECT_LT(largest_error(synthetic, result), 1e-8);
    ASSERT_EQ(result.cameras.size(), 2u);
    for (int c = 0; c < 2; ++c) {
      const auto truth = (c == 0 ? synthetic.camera : synthetic.second).parameters();
      const auto found = result.cameras[c].interior.parameters();
      for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], truth[i], i < 4 ? 1e-4 : 1e-7) << c << " " << i;
      EXPECT_EQ(result.cameras[c].interior.width, c == 0 ? 11656 : 6000);
    }
  }
}

/// Taken as one camera, the same photographs are a failed adjustment or a failed test, and no result.
TEST(SeveralCameras, TakenForOneTheyDoNotPass) {
  auto synthetic = test::make_block({.floors = 1, .two_cameras = true});
  for (auto& image : synthetic.block.images) image.camera = 0;
  synthetic.block.cameras.resize(1);
  std::string verdict;
  try {
    auto options = plain_options();
    options.estimate_image_variance = true;
    for (const auto& test : block::adjust_tag_block(synthetic.block, options).tests) verdict += test.words;
  } catch (const std::runtime_error& error) {
    verdict = error.what();
  }
  EXPECT_NE(verdict, "");
}

/// The camera whose lens is not its model is named, and not the other one.
TEST(SeveralCameras, AnOddLensIsThatOfItsCamera) {
  for (const int odd : {0, 1}) {
    auto synthetic = test::make_block({.floors = 1, .stations = 4, .two_cameras = true});
    for (auto& seen : synthetic.block.observations) {
      const size_t i = static_cast<size_t>(seen.image), j = static_cast<size_t>(seen.plate);
      if (synthetic.block.images[i].camera != odd) continue;
      const BrownCamera& lens = synthetic.camera_of(seen.image);
      const auto corners = tag_corners_in_plate(synthetic.block.plates[j].plate);
      for (size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3d v =
            synthetic.cam_from_world[i] * (synthetic.anchors[j] + synthetic.world_from_plate[j] * corners[k]);
        BrownCamera there = lens;
        there.k1 += 0.4 * (1 / v.z() - 1 / 8.0);
        seen.corners[k] += *project(there, v) - *project(lens, v);
      }
    }
    const auto result = block::adjust_tag_block(synthetic.block, plain_options());
    double factor[2] = {0, 0};
    bool passed[2] = {true, true};
    for (const auto& test : result.models)
      for (const int c : {0, 1})
        if (test.group == std::string("distortion at all distances of ") + (c == 0 ? "first" : "second"))
          factor[c] = test.factor, passed[c] = test.passed;
    EXPECT_FALSE(passed[odd]) << odd;
    EXPECT_GT(factor[odd], 3 * factor[1 - odd]) << odd;
  }
}

/// Standard deviations and correlations of both, also between them.
TEST(SeveralCameras, InteriorOrientationsCoverTheirErrors) {
  const int trials = 12;
  double sum = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto synthetic = test::make_block(
        {.floors = 1, .stations = 3, .seed = 700u + static_cast<uint64_t>(trial), .two_cameras = true});
    const auto result = block::adjust_tag_block(synthetic.block, plain_options());
    std::vector<int> rows;
    Eigen::VectorXd error(16);
    for (int c = 0; c < 2; ++c) {
      const auto truth = (c == 0 ? synthetic.camera : synthetic.second).parameters();
      const auto found = result.cameras[c].interior.parameters();
      for (int value : calibrated) {
        error(static_cast<Eigen::Index>(rows.size())) = found[value] - truth[value];
        rows.push_back(11 * c + value);
      }
      EXPECT_EQ(result.cameras[c].covariance, (result.interior_covariance.block<9, 9>(11 * c, 11 * c)));
    }
    const Eigen::MatrixXd covariance = result.interior_covariance(rows, rows);
    EXPECT_GT(covariance.topRightCorner(8, 8).cwiseAbs().maxCoeff(), 0);
    sum += error.dot(covariance.ldlt().solve(error)) / 16;
  }
  EXPECT_NEAR(sum / trials, 1, 4 * std::sqrt(2.0 / (16 * trials)));
}

TEST(SeveralCameras, AWrongCalibrationIsNamed) {
  auto synthetic = test::make_block({.floors = 1, .two_cameras = true});
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(9, 9);
  covariance.diagonal() << 9, 9, 9, 9, 1e-6, 1e-6, 0, 1e-8, 1e-8;
  for (auto& camera : synthetic.block.cameras) camera.covariance = covariance;
  synthetic.block.cameras[1].interior.fx *= 1.03, synthetic.block.cameras[1].interior.fy *= 1.03;
  const auto result = block::adjust_tag_block(synthetic.block, plain_options());
  int named = 0;
  for (const auto& test : result.tests) {
    if (test.group == "interior prior of first") {
      EXPECT_TRUE(test.passed) << test.factor;
    }
    if (test.group != "interior prior of second") continue;
    EXPECT_FALSE(test.passed) << test.factor;
    EXPECT_THAT(test.words, HasSubstr("the calibration of camera second far beyond its sigmas"));
    ++named;
  }
  EXPECT_EQ(named, 1);
}

/// d1 of one lens is no reason to doubt the other.
TEST(SeveralCameras, TheModelOfEachIsTested) {
  auto synthetic = test::make_block({.floors = 1, .two_cameras = true});
  for (auto& seen : synthetic.block.observations) {
    const size_t i = static_cast<size_t>(seen.image), j = static_cast<size_t>(seen.plate);
    if (synthetic.block.images[i].camera == 0) continue;
    const auto corners = tag_corners_in_plate(synthetic.block.plates[j].plate);
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d v =
          synthetic.cam_from_world[i] * (synthetic.anchors[j] + synthetic.world_from_plate[j] * corners[k]);
      BrownCamera there = synthetic.second;
      there.k1 += 0.6 * (1 / v.z() - 1 / 8.0);
      seen.corners[k] += *project(there, v) - *project(synthetic.second, v);
    }
  }
  const auto result = block::adjust_tag_block(synthetic.block, plain_options());
  std::string failed;
  for (const auto& test : result.models)
    if (!test.passed) failed += test.words + "; ";
  EXPECT_THAT(failed, HasSubstr("the lens' distortion of second changes with the distance"));
  EXPECT_THAT(failed, Not(HasSubstr("of first")));
}

/// What a detector draws inwards is the blur and the curve of one camera.
TEST(SeveralCameras, InsetsAreTheCameras) {
  auto synthetic = test::make_block({.floors = 1, .corner_sigma = 0.05, .noise = false, .two_cameras = true});
  const double inset[] = {0.05, 0.2};
  for (auto& seen : synthetic.block.observations)
    seen.corners = test::drawn_inwards(seen.corners, inset[synthetic.block.images[seen.image].camera]);
  auto options = plain_options();
  options.corner_inset_sigma = 10;
  const auto result = block::adjust_tag_block(synthetic.block, options);
  ASSERT_EQ(result.batches.size(), 2u);
  EXPECT_EQ(result.batches[1].name, "a in second");
  EXPECT_NEAR(result.batches[0].inset, inset[0], 1e-3);
  EXPECT_NEAR(result.batches[1].inset, inset[1], 1e-3);
  EXPECT_EQ(result.batches[1].scale_sigma, 0);
  EXPECT_NEAR(result.batches[0].scale, 1, 2e-6);
  EXPECT_LT(largest_error(synthetic, result), 1e-5);
}

/// What a detector states of its photographs is the prior of their camera's inset, of no other camera's: two witnesses
/// of the same weight.
TEST(SeveralCameras, InsetsHaveThePriorThatTheDetectorStates) {
  auto synthetic = test::make_block({.floors = 1, .corner_sigma = 0.05, .two_cameras = true});
  auto options = plain_options();
  options.corner_inset_sigma = 10;
  const auto alone = block::adjust_tag_block(synthetic.block, options);
  bool first = true;  // which states none
  for (auto& image : synthetic.block.images)
    if (image.camera == 1 && !std::exchange(first, false)) image.inset_sigma = alone.batches[1].inset_sigma;
  const auto stated = block::adjust_tag_block(synthetic.block, options);
  EXPECT_NEAR(stated.batches[1].inset_sigma, alone.batches[1].inset_sigma / std::sqrt(2.0),
              0.05 * alone.batches[1].inset_sigma);
  // The other camera has none, and learns through the size of the tags alone, which both see.
  EXPECT_LT(stated.batches[0].inset_sigma, alone.batches[0].inset_sigma);
  EXPECT_NEAR(stated.batches[1].inset, 0.5 * alone.batches[1].inset, 0.15 * std::abs(alone.batches[1].inset) + 1e-4);
}

TEST(SeveralCameras, OneWithoutImagesStaysAsItIsGiven) {
  auto synthetic = test::make_block({.floors = 1});
  synthetic.block.cameras.push_back(synthetic.block.cameras[0]);
  synthetic.block.cameras[1].name = "spare";
  const auto with = block::adjust_tag_block(synthetic.block, plain_options());
  EXPECT_EQ(with.cameras[1].interior.parameters(), synthetic.block.cameras[1].interior.parameters());
  EXPECT_EQ(with.cameras[1].covariance.norm(), 0);
  synthetic.block.cameras.pop_back();
  const auto without = block::adjust_tag_block(synthetic.block, plain_options());
  EXPECT_EQ(with.anchors, without.anchors);
  EXPECT_EQ(with.unknowns, without.unknowns);
}

}  // namespace test_tag_block_cameras
