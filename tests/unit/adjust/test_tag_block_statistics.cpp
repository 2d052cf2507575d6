// Every number that a tag block states of itself, held by something that does not share its code: repeated simulation
// for covariances, a second adjustment with a disturbed observation for influences, a plain computation for residuals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "photo/block/tag_block_model.hpp"
#include "plain_options.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace test_tag_block_statistics {

using namespace plumbline;
using test::error_of;
using test::plain_options;
using testing::HasSubstr;

TEST(TagBlockStatistics, PosesAndInteriorOrientationCoverTheirErrors) {
  const int trials = std::getenv("PLUMBLINE_LONG") ? 200 : 8;
  double poses = 0, interior = 0;
  int pose_count = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto synthetic = test::make_block({.floors = 1, .stations = 3, .seed = 500u + static_cast<uint64_t>(trial)});
    const auto result = block::adjust_tag_block(synthetic.block, plain_options());
    for (size_t i = 0; i < result.cam_from_world.size(); i += 5) {
      const RigidTransform &found = *result.cam_from_world[i], &truth = synthetic.cam_from_world[i];
      const Eigen::Quaterniond turn = found.rotation * truth.rotation.conjugate();
      Eigen::VectorXd error(6);
      error << 2 * (turn.w() < 0 ? -1 : 1) * turn.vec(), found.translation - truth.translation;
      poses += error.dot(result.pose_covariance[i].ldlt().solve(error)) / 6;
      ++pose_count;
    }
    const auto found = result.cameras[0].interior.parameters(), truth = synthetic.camera.parameters();
    const std::vector<int> free = {0, 1, 2, 3, 4, 5, 7, 8};
    Eigen::VectorXd error(8);
    for (size_t k = 0; k < free.size(); ++k) error(static_cast<Eigen::Index>(k)) = found[free[k]] - truth[free[k]];
    interior += error.dot(Eigen::MatrixXd(result.cameras[0].covariance(free, free)).ldlt().solve(error)) / 8;
  }
  // Poses of one trial share the survey's and the camera's errors: the trials count, not the poses.
  EXPECT_NEAR(poses / pose_count, 1, 4 * std::sqrt(2.0 / (6 * trials)));
  EXPECT_NEAR(interior / trials, 1, 4 * std::sqrt(2.0 / (8 * trials)));
}

/// What lies at depth Z is seen with k1 + slope (1/Z − 1/8 m), and every image with a principal point of its own.
struct OddLens {
  test::SyntheticBlock synthetic;
  std::vector<Eigen::Vector2d> shifts;
};
OddLens odd_lens(double slope, double shift_sigma, uint64_t seed) {
  OddLens odd;
  odd.synthetic = test::make_block({.floors = 1, .stations = 3, .seed = seed});
  test::Random random(seed + 1000);
  for (size_t i = 0; i < odd.synthetic.cam_from_world.size(); ++i)
    odd.shifts.emplace_back(shift_sigma * random.normal(), shift_sigma * random.normal());
  for (auto& seen : odd.synthetic.block.observations) {
    const size_t i = static_cast<size_t>(seen.image), j = static_cast<size_t>(seen.plate);
    const auto corners = tag_corners_in_plate(odd.synthetic.block.plates[j].plate);
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d v =
          odd.synthetic.cam_from_world[i] * (odd.synthetic.anchors[j] + odd.synthetic.world_from_plate[j] * corners[k]);
      BrownCamera there = odd.synthetic.camera;
      there.k1 += slope * (1 / v.z() - 1 / 8.0);
      seen.corners[k] += *project(there, v) - *project(odd.synthetic.camera, v) + odd.shifts[i];
    }
  }
  return odd;
}

const block::GroupTest& named(const std::vector<block::GroupTest>& tests, const std::string& name) {
  for (const auto& test : tests)
    if (test.group == name) return test;
  throw std::runtime_error("no test '" + name + "'");
}

TEST(CameraModel, ThatHoldsIsNotDoubted) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const auto result = block::adjust_tag_block(odd_lens(0, 0, seed).synthetic.block, plain_options());
    ASSERT_EQ(result.models.size(), 2u);
    for (const auto& test : result.models) EXPECT_TRUE(test.passed) << test.group << " " << test.words;
  }
}

/// In a free block, too, whose scale the tags' size does not carry: the distance terms change with the scale.
TEST(CameraModel, ThatChangesWithTheDistanceIsNoticedAndEstimated) {
  const OddLens odd = odd_lens(0.1, 0, 3);
  auto options = plain_options();
  const auto without = block::adjust_tag_block(odd.synthetic.block, options);
  EXPECT_FALSE(named(without.models, "distortion at all distances").passed);
  EXPECT_THAT(named(without.models, "distortion at all distances").words, HasSubstr("add d1 and d2 to free_interior"));
  options.free_interior.push_back("d1");
  options.free_interior.push_back("d2");
  for (const bool free : {false, true}) {
    options.free_network = free;
    for (const bundle::Minimiser& engine :
         {bundle::Minimiser(bundle::minimise_schur), bundle::Minimiser(bundle::minimise_ceres)}) {
      options.minimiser = engine;
      const auto with = block::adjust_tag_block(odd.synthetic.block, options);
      EXPECT_LT(with.weighted_sum_of_squares, without.weighted_sum_of_squares - 30);
      EXPECT_NEAR(with.cameras[0].distance_terms.x(), 0.1, 4 * std::sqrt(with.interior_covariance(9, 9)));
      EXPECT_LT(std::sqrt(with.interior_covariance(9, 9)), 0.05);
      EXPECT_EQ(with.models.size(), 1u) << "what is estimated needs no test";
      EXPECT_NEAR(with.cameras[0].reference_distance, 8, 2);
    }
  }
}

/// Of a long lens before a facade the poses take up most of it: two pixels would neither be seen nor matter.
TEST(CameraModel, WithAPrincipalPointOfEachImageIsNoticedAndEstimated) {
  const OddLens odd = odd_lens(0, 30, 4);
  auto options = plain_options();
  const auto without = block::adjust_tag_block(odd.synthetic.block, options);
  EXPECT_FALSE(named(without.models, "one principal point").passed);
  EXPECT_THAT(named(without.models, "one principal point").words, HasSubstr("set image_principal_point_sigma to that"));
  EXPECT_GT(named(without.models, "one principal point").shift, 5) << "of 20 px and more";
  // What the test offers mends it: a standard deviation that is too small makes the images contradict it.
  options.image_principal_point_sigma = named(without.models, "one principal point").shift;
  for (const auto& test : block::adjust_tag_block(odd.synthetic.block, options).tests)
    EXPECT_TRUE(test.passed) << test.group << ": " << test.words;
  options.image_principal_point_sigma = 30;
  const auto with = block::adjust_tag_block(odd.synthetic.block, options);
  ASSERT_EQ(with.principal_points.size(), odd.shifts.size());
  EXPECT_LT(with.weighted_sum_of_squares, 0.9 * without.weighted_sum_of_squares);
  EXPECT_TRUE(named(with.models, "distortion at all distances").passed);
}

/// What nobody estimates is in the anchors' covariance as large as the residuals show it, in the modes that feel it:
/// one factor for all made (error/u)² 0.13, and none made it several times too large.
TEST(CameraModel, WhatItLeavesOutIsInTheCovarianceOfTheAnchors) {
  const int trials = std::getenv("PLUMBLINE_LONG") ? 100 : 12;
  for (const bool free : {false, true}) {
    double heights = 0, plan = 0;
    int found = 0;
    for (int trial = 0; trial < trials; ++trial) {
      const OddLens odd = odd_lens(0, 30, 300 + static_cast<uint64_t>(trial));
      auto options = plain_options();
      options.free_network = free;
      const auto result = block::adjust_tag_block(odd.synthetic.block, options);
      const block::GroupTest& test = named(result.models, "one principal point");
      if (test.passed) continue;
      EXPECT_THAT(test.words, HasSubstr("; standard deviations of anchors "));
      EXPECT_GE(test.points_factor, 1);
      ++found;
      if (free) {  // where it stands is not the truth's, but that of the datum's points all together
        const auto heights_of_all = Eigen::seq(2, Eigen::last, 3);
        const Eigen::MatrixXd z = result.anchor_covariance(heights_of_all, heights_of_all);
        EXPECT_NEAR(z.sum(), 0, 1e-6 * z.trace()) << "the mean of all heights is the datum's";
        continue;
      }
      const auto n = static_cast<double>(result.plates.size());
      for (size_t j = 0; j < result.plates.size(); ++j) {
        const auto at = 3 * static_cast<Eigen::Index>(j);
        const Eigen::Vector3d off = result.anchors.segment<3>(at) - odd.synthetic.anchors[result.plates[j]];
        const Eigen::Vector3d variance = result.anchor_covariance.diagonal().segment<3>(at);
        heights += off.z() * off.z() / variance.z() / n;
        plan += 0.5 * (off.x() * off.x() / variance.x() + off.y() * off.y() / variance.y()) / n;
      }
    }
    ASSERT_GT(found, trials / 2);
    if (free) continue;
    EXPECT_GT(heights / found, 0.5);
    EXPECT_LT(heights / found, 1.6);
    EXPECT_GT(plan / found, 0.5);
    EXPECT_LT(plan / found, 1.6);
  }
}

/// Interior orientation with d1 and d2, and principal points of all images, in normalised squared errors; 200 trials
/// with PLUMBLINE_LONG. Checked anchors are off by no more than they say, too.
TEST(CameraModel, ItsCovariancesCoverItsErrors) {
  const int trials = std::getenv("PLUMBLINE_LONG") ? 200 : 6;
  double interior = 0, shifts = 0, anchors = 0;
  int shift_count = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const OddLens odd = odd_lens(0.1, 0.5, 900 + static_cast<uint64_t>(trial));
    auto options = plain_options();
    options.free_interior.insert(options.free_interior.end(), {"d1", "d2"});
    options.image_principal_point_sigma = 0.5;
    const auto result = block::adjust_tag_block(odd.synthetic.block, options);
    const auto found = result.cameras[0].interior.parameters();
    auto truth = odd.synthetic.camera.parameters();
    truth[4] += 0.1 * (1 / result.cameras[0].reference_distance - 1 / 8.0);
    const std::vector<int> free = {0, 1, 2, 3, 4, 5, 7, 8, 9, 10};
    Eigen::VectorXd error(10);
    for (size_t k = 0; k < 8; ++k) error(static_cast<Eigen::Index>(k)) = found[free[k]] - truth[free[k]];
    error.tail<2>() = result.cameras[0].distance_terms - Eigen::Vector2d(0.1, 0);
    interior += error.dot(Eigen::MatrixXd(result.interior_covariance(free, free)).ldlt().solve(error)) / 10;
    for (size_t i = 0; i < odd.shifts.size(); ++i, ++shift_count) {
      const Eigen::Vector2d off = result.principal_points[i].shift - odd.shifts[i];
      shifts += off.dot(result.principal_points[i].covariance.inverse() * off) / 2;
    }
    Eigen::VectorXd moved(result.anchors.size());
    for (size_t j = 0; j < result.plates.size(); ++j)
      moved.segment<3>(3 * static_cast<Eigen::Index>(j)) =
          result.anchors.segment<3>(3 * static_cast<Eigen::Index>(j)) - odd.synthetic.anchors[result.plates[j]];
    anchors += moved.dot(result.anchor_covariance.ldlt().solve(moved)) / static_cast<double>(moved.size());
  }
  EXPECT_NEAR(interior / trials, 1, 4 * std::sqrt(2.0 / (10 * trials)));
  EXPECT_NEAR(shifts / shift_count, 1, 4 * std::sqrt(2.0 / (12 * trials)));  // those of a trial share the camera's
  EXPECT_NEAR(anchors / trials, 1, 4 * std::sqrt(2.0 / (33 * trials)));
}

/// What the formula says of withheld control against an adjustment that never had it: coordinates, and their covariance
/// plus the survey's own, which is correlated here.
TEST(Crossval, IsTheAdjustmentWithoutTheGroup) {
  auto synthetic = test::make_block({.floors = 2, .stations = 3, .seed = 31});
  block::TagControl& control = synthetic.block.control;
  const Eigen::Index n = control.position.size();
  for (Eigen::Index a = 2; a < n; a += 3)
    for (Eigen::Index b = 2; b < n; b += 3) control.covariance(a, b) += 4e-6;  // one height error of the instrument
  auto options = plain_options();
  options.withhold = {{control.plates[1], control.plates[6]}, {control.plates[3]}, control.plates};
  const auto result = block::adjust_tag_block(synthetic.block, options);
  ASSERT_EQ(result.withheld.size(), 3u);
  EXPECT_THAT(result.withheld[2].undetermined, HasSubstr("does not hold the block"));
  options.withhold.clear();
  for (int g = 0; g < 2; ++g) {
    block::TagBlock without = synthetic.block;
    std::vector<int> rows, out;
    without.control.plates.clear();
    for (size_t k = 0; k < control.plates.size(); ++k) {
      const auto& plates = result.withheld[g].plates;
      const bool stays = std::find(plates.begin(), plates.end(), control.plates[k]) == plates.end();
      if (stays) without.control.plates.push_back(control.plates[k]);
      for (int c = 0; c < 3; ++c) (stays ? rows : out).push_back(3 * static_cast<int>(k) + c);
    }
    without.control.position = control.position(rows);
    without.control.covariance = control.covariance(rows, rows);
    const auto expected = block::adjust_tag_block(without, options);
    // The survey's correlations tell of the withheld points, too: x + C Q⁻¹ (x_c − l_c) is not formed by the adjustment
    // without them, so the difference is taken from what the rest of the survey predicts of its error.
    const Eigen::MatrixXd gain =
        control.covariance(out, rows) * control.covariance(rows, rows)
                                            .llt()
                                            .solve(Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(rows.size()),
                                                                             static_cast<Eigen::Index>(rows.size())));
    Eigen::VectorXd residual(static_cast<Eigen::Index>(rows.size()));
    for (size_t k = 0; k < without.control.plates.size(); ++k)
      residual.segment<3>(static_cast<Eigen::Index>(3 * k)) =
          without.control.position.segment<3>(static_cast<Eigen::Index>(3 * k)) -
          expected.anchors.segment<3>(test::row_of_plate(expected, without.control.plates[k]));
    const Eigen::VectorXd predicted = gain * residual;
    const auto& group = result.withheld[g];
    for (size_t k = 0; k < group.plates.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(3 * k);
      const Eigen::Vector3d off = control.position(out).segment<3>(at) -
                                  expected.anchors.segment<3>(test::row_of_plate(expected, group.plates[k])) -
                                  predicted.segment<3>(at);
      EXPECT_LT((group.off.segment<3>(at) - off).norm(), 2e-6) << g;
    }
    // l_c − C Q⁻¹ l has no part in the adjustment of the rest; anchors there are correlated among each other.
    std::vector<int> anchors;
    for (const std::vector<int>& plates : {group.plates, without.control.plates})
      for (int plate : plates)
        for (int c = 0; c < 3; ++c) anchors.push_back(static_cast<int>(test::row_of_plate(expected, plate)) + c);
    Eigen::MatrixXd by_anchors(gain.rows(), gain.rows() + gain.cols());
    by_anchors << Eigen::MatrixXd::Identity(gain.rows(), gain.rows()), -gain;
    const Eigen::MatrixXd covariance =
        control.covariance(out, out) - gain * control.covariance(rows, out) +
        by_anchors * expected.anchor_covariance(anchors, anchors) * by_anchors.transpose();
    EXPECT_LT((group.covariance - covariance).norm(), 1e-4 * covariance.norm()) << g;
  }
}

/// w² of an uncorrelated observation is what the sum of squares loses without it (Baarda 1968); here the coordinates of
/// a tag take turns in weighing nothing.
TEST(TagBlockStatistics, TheLargestNormalisedResidualOfATagIsThatOfItsWorstCoordinate) {
  auto synthetic = test::make_block({.floors = 1, .stations = 3, .seed = 41});
  const size_t observation = 17;
  synthetic.block.observations[observation].corners[2].y() += 1.1;  // w < 0: the largest is of absolute values
  const auto all = block::adjust_tag_block(synthetic.block, plain_options());
  double largest = 0;
  for (size_t corner = 0; corner < 4; ++corner)
    for (int axis = 0; axis < 2; ++axis) {
      block::TagBlock without = synthetic.block;
      without.observations[observation].covariances[corner](axis, axis) *= 1e10;
      const auto rest = block::adjust_tag_block(without, plain_options());
      largest = std::max(largest, std::sqrt(all.weighted_sum_of_squares - rest.weighted_sum_of_squares));
    }
  for (const auto& tag : all.tags)
    if (tag.observation == static_cast<int>(observation)) {
      EXPECT_NEAR(tag.largest_normalised, largest, 1e-3 * largest);
      EXPECT_GT(largest, 4);
      return;
    }
  FAIL() << "the tag has no line";
}

/// A prior adds its own information to what the block says of a scale or an inset, and nothing else.
TEST(TagBlockStatistics, SigmasOfABatchGainWhatAPriorGives) {
  const auto synthetic = test::make_block({.floors = 1, .stations = 3, .seed = 43});
  auto options = plain_options();
  options.corner_inset_sigma = 10;
  const auto loose = block::adjust_tag_block(synthetic.block, options).batches.at(0);
  const auto information = [](double sigma) { return 1 / (sigma * sigma); };
  options.corner_inset_sigma = 2 * loose.inset_sigma;
  const auto inset = block::adjust_tag_block(synthetic.block, options).batches.at(0);
  EXPECT_NEAR((information(inset.inset_sigma) - information(loose.inset_sigma)) /
                  (information(2 * loose.inset_sigma) - information(10)),
              1, 1e-3);
  options.corner_inset_sigma = 10;
  options.tag_scale_sigma = 2 * loose.scale_sigma;
  const auto scale = block::adjust_tag_block(synthetic.block, options).batches.at(0);
  EXPECT_NEAR((information(scale.scale_sigma) - information(loose.scale_sigma)) / information(2 * loose.scale_sigma), 1,
              1e-3);
}

/// What is said of a plate: the images that see it, and w of the worse of its survey and the tag in the middle, so that
/// one spoilt tag of many does not speak for the plate.
TEST(TagBlockStatistics, APlateIsJudgedByItsSurveyAndItsMiddleTag) {
  auto synthetic = test::make_block({.floors = 1, .stations = 3, .seed = 44});
  synthetic.block.control.position(3 * 2 + 2) += 0.008;
  const auto result = block::adjust_tag_block(synthetic.block, plain_options());
  for (size_t j = 0; j < result.plates.size(); ++j) {
    std::vector<double> tags;
    for (const auto& tag : result.tags)
      if (synthetic.block.observations[tag.observation].plate == result.plates[j])
        tags.push_back(tag.largest_normalised);
    std::sort(tags.begin(), tags.end());
    EXPECT_EQ(result.images_per_plate[j], static_cast<int>(tags.size()));
    double survey = 0;
    for (const auto& control : result.control)
      if (control.plate == result.plates[j])
        for (const auto& coordinate : control.coordinates) survey = std::max(survey, std::abs(coordinate.w));
    EXPECT_EQ(result.plate_w[j], std::max(survey, tags[tags.size() / 2]));
    if (result.plates[j] == synthetic.block.control.plates[2]) {
      EXPECT_GT(result.plate_w[j], 6);
    }
  }
}

TEST(TagBlockStatistics, CornersAreWeightedByTheirFullCovariance) {
  auto synthetic = test::make_block({.floors = 1, .noise = false});
  Eigen::Matrix2d covariance;
  covariance << 0.04, 0.03, 0.03, 0.09;
  for (auto& seen : synthetic.block.observations) seen.covariances.fill(covariance);
  std::vector<std::string> left_out;
  const auto start =
      block::start_tag_block(synthetic.block, std::vector<bool>(synthetic.block.observations.size(), true), left_out);
  const auto model = block::build_tag_model(synthetic.block, plain_options(), start);
  for (const auto& whitening : model.problem.image_tags.front().whitening)
    EXPECT_LT((whitening.transpose() * whitening * covariance - Eigen::Matrix2d::Identity()).norm(), 1e-12);
}

TEST(TagBlockStatistics, ImageVarianceIsEstimatedTheRightWayUp) {
  auto synthetic = test::make_block({.floors = 1});
  for (auto& seen : synthetic.block.observations)
    for (auto& covariance : seen.covariances) covariance /= 9;  // the detector claims a third of its noise
  auto options = plain_options();
  options.estimate_image_variance = true;
  const auto result = block::adjust_tag_block(synthetic.block, options);
  EXPECT_NEAR(result.image_variance_factor, 9, 0.9);
  const auto right = block::adjust_tag_block(test::make_block({.floors = 1}).block, options);
  EXPECT_NEAR(right.image_variance_factor, 1, 0.1);
  EXPECT_LT((result.pose_covariance[3] - right.pose_covariance[3]).norm(), 0.01 * right.pose_covariance[3].norm());
}

TEST(TagBlockStatistics, ResidualsAreThoseOfTheProjection) {
  const auto synthetic = test::make_block({.floors = 1});
  auto options = plain_options();
  options.tag_scale_sigma = 0;
  const auto result = block::adjust_tag_block(synthetic.block, options);
  for (const auto& tag : result.tags) {
    const auto& seen = synthetic.block.observations[tag.observation];
    const Eigen::Index at = test::row_of_plate(result, seen.plate);
    double squares = 0;
    const auto corners = tag_corners_in_plate(synthetic.block.plates[seen.plate].plate);
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d world = result.anchors.segment<3>(at) + result.world_from_plate[at / 3] * corners[k];
      squares += (*project(result.cameras[0].interior, *result.cam_from_world[seen.image] * world) - seen.corners[k])
                     .squaredNorm();
    }
    EXPECT_NEAR(tag.rms, std::sqrt(squares / 8), 1e-6);
  }
}

/// An error of the size of the MDB in one control coordinate, put in: the largest height change is the one stated.
TEST(TagBlockStatistics, EffectOnHeightsIsThatOfADisturbedControlPoint) {
  const auto synthetic = test::make_block({.floors = 2, .noise = false});
  const auto before = block::adjust_tag_block(synthetic.block, plain_options());
  for (const size_t coordinate : {size_t{0}, size_t{2}}) {
    const size_t point = 5;
    auto disturbed = synthetic.block;
    const double mdb = before.control[point].coordinates[coordinate].mdb;
    disturbed.control.position(static_cast<Eigen::Index>(3 * point + coordinate)) += mdb;
    const auto after = block::adjust_tag_block(disturbed, plain_options());
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
  const auto failed = [&](const test::SyntheticBlock& synthetic, const block::TagBlockOptions& how) {
    std::string groups;
    for (const auto& test : block::adjust_tag_block(synthetic.block, how).tests)
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
  focal.block.cameras[0].interior = sound.camera;
  EXPECT_EQ(failed(focal, held), "");
  focal.block.cameras[0].interior.fx *= 1.03;
  focal.block.cameras[0].interior.fy *= 1.03;
  EXPECT_THAT(failed(focal, held), HasSubstr("images"));
  focal.block.cameras[0].covariance = Eigen::MatrixXd::Zero(9, 9);
  focal.block.cameras[0].covariance.diagonal() << 9, 9, 9, 9, 1e-6, 1e-6, 0, 1e-8, 1e-8;
  EXPECT_THAT(failed(focal, options), HasSubstr("interior prior"));
  auto survey = sound;  // a set-up 2 cm too high
  for (Eigen::Index k = 2; k < survey.block.control.position.size() / 2; k += 3)
    survey.block.control.position(k) += 0.02;
  EXPECT_THAT(failed(survey, options), HasSubstr("control"));
}

TEST(TagBlockStatistics, SurveyInAnotherFrameUnitOrOrder) {
  const auto synthetic = test::make_block({.floors = 2});
  const auto options = plain_options();
  const auto here = block::adjust_tag_block(synthetic.block, options);
  EXPECT_TRUE(here.warnings.empty());
  const RigidTransform move{quaternion_from_rotation_vector({0, 0, 2.1}), {691000, 5335000, 500}};
  auto elsewhere = synthetic.block;
  for (Eigen::Index k = 0; k < elsewhere.control.position.size(); k += 3)
    elsewhere.control.position.segment<3>(k) = move * Eigen::Vector3d(synthetic.block.control.position.segment<3>(k));
  const auto there = block::adjust_tag_block(elsewhere, options);
  ASSERT_EQ(there.warnings.size(), 1u);
  EXPECT_THAT(there.warnings[0], HasSubstr("different frames"));
  for (Eigen::Index k = 0; k < here.anchors.size(); k += 3)
    EXPECT_LT((there.anchors.segment<3>(k) - move * Eigen::Vector3d(here.anchors.segment<3>(k))).norm(), 1e-6);

  auto feet = synthetic.block;
  feet.control.position /= 0.3048;
  EXPECT_THAT(error_of([&] { block::adjust_tag_block(feet, options); }), HasSubstr("feet"));
  auto swapped = synthetic.block;
  const Eigen::Vector3d first = swapped.control.position.segment<3>(0);
  swapped.control.position.segment<3>(0) = Eigen::Vector3d(swapped.control.position.segment<3>(9));
  swapped.control.position.segment<3>(9) = first;
  EXPECT_THAT(error_of([&] { block::adjust_tag_block(swapped, options); }),
              HasSubstr("the plate of F01-C01-R1 hangs where the survey has F01-C02-R2"));
}

}  // namespace test_tag_block_statistics
