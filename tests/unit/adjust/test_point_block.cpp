#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "photo/block/aicon_files.hpp"
#include "photo/block/control_list.hpp"
#include "photo/block/control_words.hpp"
#include "photo/block/image_block_folder.hpp"
#include "photo/block/photomodeler_files.hpp"
#include "photo/block/point_block_robust.hpp"
#include "photo/block/point_block_words.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace test_point_block {

using namespace plumbline;
using block::PointBlock;
using test::error_of;
using testing::HasSubstr;

/// 20 points on a table of half a metre, 8 images around it, distortion-free camera, one scale bar, no noise.
PointBlock small_block() {
  PointBlock block;
  block::SensorCamera camera;
  camera.id = 1;
  camera.values = {-28, 0.02, -0.03, 0, 0, 0, 0, 0, 0, 0};
  camera.balance_radius = 13;
  block.cameras.push_back(camera);
  test::Random random(3);
  for (int j = 0; j < 20; ++j)
    block.points.push_back(
        {std::to_string(j + 1), {0.5 * random.uniform(), 0.5 * random.uniform(), 0.1 * random.uniform()}});
  for (int i = 0; i < 8; ++i) {
    const double angle = 2 * M_PI * i / 8;
    const Eigen::Vector3d centre(0.25 + 0.6 * std::cos(angle), 0.25 + 0.6 * std::sin(angle), 0.9);
    // Camera z points away from the scene; roll alternates.
    const Eigen::Vector3d z = (centre - Eigen::Vector3d(0.25, 0.25, 0.05)).normalized();
    const Eigen::Vector3d x = Eigen::Vector3d(std::cos(i), std::sin(1.0 * i), 0).cross(z).normalized();
    Eigen::Matrix3d block_from_camera;
    block_from_camera << x, z.cross(x), z;
    block.images.push_back({i + 1, 0, centre, block::angles_from_rotation(block_from_camera)});
    for (int j = 0; j < 20; ++j) {
      const Eigen::Vector3d v = block_from_camera.transpose() * (block.points[j].position - centre);
      block::BlockMeasurement measured;
      measured.image = i;
      measured.point = j;
      measured.position = Eigen::Vector2d(0.02, -0.03) - 28 * v.head<2>() / v.z();
      block.measurements.push_back(measured);
    }
  }
  block.scale_bars.push_back({"bar", 0, 1, (block.points[0].position - block.points[1].position).norm(), 1e-5});
  return block;
}

block::PointBlockOptions options() {
  block::PointBlockOptions result;
  result.free_parameters = {"Ck", "xh", "yh"};
  return result;
}

TEST(PointBlock, AnglesAndBack) {
  const Eigen::Vector3d angles(2.1, -0.7, -3.0);
  EXPECT_LT((block::angles_from_rotation(block::rotation_from_angles(angles)) - angles).norm(), 1e-14);
}

TEST(PointBlock, RecoversTruthFromDisturbedValues) {
  const PointBlock truth = small_block();
  PointBlock start = truth;
  for (size_t i = 0; i < start.images.size(); ++i)
    start.images[i].centre += 0.01 * Eigen::Vector3d(std::sin(i), std::cos(i), 0.5);
  start.cameras[0].values[0] = -28.3;
  const auto result = block::adjust_point_block(start, options());
  EXPECT_NEAR(result.block.cameras[0].values[0], -28, 1e-7);
  EXPECT_EQ(result.constraints, 6);
  EXPECT_EQ(result.degrees_of_freedom, 2 * 160 + 1 - (60 + 48 + 3) + 6);
  for (size_t j = 0; j < truth.points.size(); ++j)
    EXPECT_LT((result.block.points[j].position - truth.points[j].position).norm(), 1e-8);
}

TEST(PointBlock, WithoutScaleBarScaleIsPartOfTheDatum) {
  PointBlock block = small_block();
  block.scale_bars.clear();
  const auto result = block::adjust_point_block(block, options());
  EXPECT_EQ(result.constraints, 7);
  EXPECT_EQ(result.degrees_of_freedom, 2 * 160 - (60 + 48 + 3) + 7);
}

/// What is held is known exactly, and not by what an inverse leaves of zero.
TEST(PointBlock, TheHeldImageHasNoStandardDeviation) {
  PointBlock block = small_block();
  block.scale_bars.clear();
  test::Random random(7);
  for (auto& m : block.measurements)
    m.position += 1e-3 * Eigen::Vector2d(random.uniform() - 0.5, random.uniform() - 0.5);
  block::PointBlockOptions held = options();
  held.free_datum = block::PointBlockOptions::FreeDatum::first_image;
  const auto result = block::adjust_point_block(block, held);
  EXPECT_EQ(result.constraints, 7);
  EXPECT_TRUE(result.orientation_covariance[0].isZero(0));
  EXPECT_TRUE(result.pose_interior_correlation[0].isZero(0));
  int zeros = 0;
  for (size_t i = 0; i < 8; ++i)
    for (int c = 0; c < 6; ++c) zeros += result.orientation_covariance[i](c, c) == 0;
  EXPECT_EQ(zeros, 7) << "and one coordinate of the furthest image";
  EXPECT_TRUE(result.pose_interior_correlation[4].allFinite());
}

TEST(PointBlock, RefusalsNameTheCause) {
  const auto refusal = [](const PointBlock& block) {
    return error_of([&] { block::adjust_point_block(block, options()); });
  };
  PointBlock one_image = small_block();
  one_image.images.resize(1);
  EXPECT_THAT(refusal(one_image), HasSubstr("at least 2 images, this one has 1"));
  PointBlock seen_once = small_block();
  std::erase_if(seen_once.measurements, [](const auto& m) { return m.point == 4 && m.image > 0; });
  EXPECT_THAT(refusal(seen_once), HasSubstr("object point 5 measured in fewer than 2 images"));
  PointBlock loose_image = small_block();
  std::erase_if(loose_image.measurements, [](const auto& m) { return m.image == 2 && m.point > 1; });
  EXPECT_THAT(refusal(loose_image), HasSubstr("image 3 (2) with fewer than 3 measured points"));
  // The same view eight times: no depth at all.
  PointBlock one_view = small_block();
  for (auto& image : one_view.images)
    image.centre = one_view.images[0].centre, image.angles = one_view.images[0].angles;
  for (auto& m : one_view.measurements) m.position = one_view.measurements[m.point].position;
  EXPECT_THAT(refusal(one_view), testing::AnyOf(HasSubstr("rank defect"), HasSubstr("is undetermined")));
}

/// One coordinate of 1e308 is the mean of all of them, so that innocent points seem undetermined.
TEST(PointBlock, CoordinatesThatAreNoneAreNamed) {
  const auto refusal = [](const PointBlock& block) {
    return error_of([&] { block::adjust_point_block(block, options()); });
  };
  PointBlock point = small_block();
  point.points[3].position.z() = 1e308;
  EXPECT_THAT(refusal(point), testing::AllOf(HasSubstr("point 4 is at ("), HasSubstr("1e+308"), HasSubstr("metres")));
  PointBlock image = small_block();
  image.images[2].centre.x() = -1e10;
  EXPECT_THAT(refusal(image), HasSubstr("the projection centre of image 3 is at (-1e+10, "));
  PointBlock nothing = small_block();
  nothing.points[0].position.x() = std::nan("");
  EXPECT_THAT(refusal(nothing), HasSubstr("point 1 is at (nan, "));
}

/// Five points known with their covariance, two of them held, one compared with only; approximate values in another
/// frame and of another size, at coordinates of seven digits.
TEST(PointBlock, ControlInAnotherFrame) {
  PointBlock block = small_block();
  block.scale_bars.clear();
  const Eigen::Vector3d far(1e6, 5e5, 100);
  const Eigen::Quaterniond turn = quaternion_from_rotation_vector({0.3, -0.2, 1.0});
  block.control.points = {0, 5, 10, 15, 19};
  block.control.is_check = {false, false, false, false, true};
  block.control.position.resize(15);
  block.control.covariance = 1e-8 * Eigen::MatrixXd::Identity(15, 15);
  block.control.covariance.topLeftCorner<6, 6>().setZero();
  block.control.covariance(6, 10) = block.control.covariance(10, 6) = 0.5e-8;
  for (Eigen::Index k = 0; k < 5; ++k)
    block.control.position.segment<3>(3 * k) = 2.0 * (turn * block.points[block.control.points[k]].position) + far;
  const auto result = block::adjust_point_block(block, options());
  EXPECT_EQ(result.constraints, 0);
  EXPECT_EQ(result.unknowns, 60 - 6 + 48 + 3);
  EXPECT_EQ(result.observations, 2 * 160 + 6);
  for (size_t j = 0; j < 20; ++j)
    EXPECT_LT((result.block.points[j].position - (2.0 * (turn * block.points[j].position) + far)).norm(), 2e-8);
  ASSERT_EQ(result.control.size(), 5u);
  EXPECT_TRUE(result.control[0].fixed);
  EXPECT_TRUE(result.point_covariances[0].isZero(0));
  EXPECT_TRUE(result.control[4].check);
  EXPECT_LT(result.control[4].residual.norm(), 2e-8);
}

/// What is given of control comes back as it was given: standard deviations, not variances, of each coordinate.
TEST(PointBlock, ControlComesBackWithItsStandardDeviations) {
  PointBlock block = small_block();
  block.control.points = {0, 5, 10, 15, 19};
  block.control.is_check = {false, false, false, false, true};
  block.control.position.resize(15);
  block.control.covariance = Eigen::MatrixXd::Zero(15, 15);
  for (Eigen::Index k = 0; k < 15; ++k) block.control.covariance(k, k) = std::pow(1e-4 * static_cast<double>(1 + k), 2);
  block.control.covariance(3, 4) = block.control.covariance(4, 3) = 0.5 * 4e-4 * 5e-4;
  for (Eigen::Index k = 0; k < 5; ++k)
    block.control.position.segment<3>(3 * k) = block.points[block.control.points[k]].position;
  block.control.position(14) += 0.01;  // of the check point
  const auto result = block::adjust_point_block(block, options());
  ASSERT_EQ(result.control.size(), 5u);
  for (Eigen::Index k = 0; k < 5; ++k)
    for (Eigen::Index c = 0; c < 3; ++c)
      EXPECT_NEAR(result.control[k].given_sigma(c), 1e-4 * static_cast<double>(1 + 3 * k + c), 1e-15);
  const auto& check = result.control[4];
  EXPECT_NEAR(check.residual.z(), -0.01, 1e-4);
  EXPECT_NEAR(check.w(2), check.residual.z() / std::sqrt(result.point_covariances[19](2, 2) + std::pow(15e-4, 2)),
              0.05 * std::abs(check.w(2)));
}

/// What the block says of them together, and what their survey says.
TEST(PointBlock, CheckPointsHaveTheirCovarianceInCommon) {
  PointBlock block = small_block();
  test::Random random(4);
  for (auto& m : block.measurements) m.position += 5e-4 * Eigen::Vector2d(random.normal(), random.normal());
  block.control.points = {0, 5, 10, 15, 19, 12};
  block.control.is_check = {false, true, false, false, true, false};
  block.control.position.resize(18);
  block.control.covariance = 1e-6 * Eigen::MatrixXd::Identity(18, 18);
  block.control.covariance(3, 14) = block.control.covariance(14, 3) = 0.4e-6;
  for (Eigen::Index k = 0; k < 6; ++k)
    block.control.position.segment<3>(3 * k) = block.points[block.control.points[k]].position;
  const auto result = block::adjust_point_block(block, options());
  const std::vector<Eigen::Index> points = {15, 16, 17, 57, 58, 59}, rows = {3, 4, 5, 12, 13, 14};
  const Eigen::MatrixXd expected = result.point_covariance(points, points) + block.control.covariance(rows, rows);
  ASSERT_EQ(result.check_covariance.rows(), 6);
  EXPECT_LT((result.check_covariance - expected).norm(), 1e-9 * expected.norm());
  EXPECT_GT(std::abs(result.check_covariance(0, 3)), 1e-9) << "the control shifts both";
  block::PointBlockOptions by_gradients = options();
  by_gradients.by_gradients = true;
  EXPECT_EQ(block::adjust_point_block(block, by_gradients).check_covariance.size(), 0);
}

/// Noise of `sigma` [mm] in the images, six known points of 0.2 mm.
PointBlock noisy_block(uint64_t seed, double sigma, double stated) {
  PointBlock block = small_block();
  test::Random random(seed);
  for (auto& m : block.measurements)
    m.position += sigma * Eigen::Vector2d(random.normal(), random.normal()), m.sigma = stated;
  block.scale_bars.clear();
  constexpr double survey = 2e-4;
  block.control.points = {0, 4, 8, 12, 16, 19};
  block.control.is_check.assign(6, false);
  block.control.position.resize(18);
  for (Eigen::Index k = 0; k < 6; ++k)
    for (Eigen::Index c = 0; c < 3; ++c)
      block.control.position(3 * k + c) = block.points[block.control.points[k]].position(c) + survey * random.normal();
  block.control.covariance = survey * survey * Eigen::MatrixXd::Identity(18, 18);
  return block;
}

/// Control and a check point of one survey, which has 1 mm of height in common and 0.2 mm of each coordinate of its
/// own.
PointBlock block_of_one_survey(uint64_t seed) {
  PointBlock block = noisy_block(seed, 3e-4, 3e-4);
  test::Random random(seed + 1000);
  block.control.points.push_back(6), block.control.is_check.push_back(true);
  block.control.position.conservativeResize(21);
  for (Eigen::Index c = 0; c < 3; ++c)
    block.control.position(18 + c) = block.points[6].position(c) + 2e-4 * random.normal();
  block.control.covariance = 4e-8 * Eigen::MatrixXd::Identity(21, 21);
  const double common = 1e-3 * random.normal();
  for (Eigen::Index k = 2; k < 21; k += 3) {
    block.control.position(k) += common;
    for (Eigen::Index j = 2; j < 21; j += 3) block.control.covariance(k, j) += 1e-6;
  }
  return block;
}

/// What both have in common was counted twice: a check point 2 mm off, eight of its standard deviations, was 1.4 of
/// what was stated.
TEST(PointBlock, WhatCheckPointsAndControlHaveInCommonCancels) {
  double squares = 0, w = 0;
  constexpr int trials = 200;
  for (uint64_t seed = 1; seed <= trials; ++seed) {
    const auto result = block::adjust_point_block(block_of_one_survey(seed), options());
    ASSERT_EQ(result.check_covariance.rows(), 3);
    const Eigen::Vector3d off = result.control[6].residual;
    squares += off.dot(result.check_covariance.ldlt().solve(off)) / trials;
    w += std::pow(result.control[6].w.z(), 2) / trials;
    EXPECT_LT(std::sqrt(result.check_covariance(2, 2)), 6e-4) << "not 1.4 mm";
  }
  RecordProperty("nees", std::to_string(squares) + " " + std::to_string(w));
  EXPECT_GT(squares, 2.3);
  EXPECT_LT(squares, 3.6);
  EXPECT_GT(w, 0.7);
  EXPECT_LT(w, 1.35);
  PointBlock wrong = block_of_one_survey(3);
  wrong.control.position(20) += 3e-3;
  EXPECT_GT(std::abs(block::adjust_point_block(wrong, options()).control[6].w.z()), 4);
}

/// A control point that was set aside came back, as what it is off was held against the height that all share.
TEST(PointBlock, AWrongControlPointOfASurveyWithACommonHeightStaysAside) {
  auto how = options();
  how.estimate_image_variance = true;
  PointBlock block = block_of_one_survey(5);
  block.control.position(3 * 3 + 2) += 3e-3;  // of point 13
  const auto result = block::adjust_without_wrong_control(block, how);
  ASSERT_EQ(result.control.size(), 7u);
  for (size_t k = 0; k < 7; ++k) EXPECT_EQ(result.control[k].aside, k == 3) << k;
  EXPECT_GT(std::abs(result.control[3].w.z()), 4);
  EXPECT_LT(std::abs(result.control[6].w.z()), 4);
}

/// A file's standard deviation of 1 px where 0.3 px is right once scaled what the survey states as well: control of 1
/// mm was given as 0.3 mm, and a point 50 of its sigmas off held the block without a word.
TEST(PointBlock, WhatProgramsStateOfTheirImagesDoesNotScaleTheControl) {
  constexpr double noise = 3e-4;
  auto how = options();
  how.estimate_image_variance = true;
  for (const double stated : {noise / 5, noise, 10 * noise}) {
    const auto result = block::adjust_point_block(noisy_block(1, noise, stated), how);
    const auto right = block::adjust_point_block(noisy_block(1, noise, noise), how);
    EXPECT_NEAR(std::sqrt(result.image_variance_factor) * stated, noise, 0.06 * noise) << stated;
    for (size_t k = 0; k < 6; ++k) {
      const auto of = [&](const block::PointBlockResult& r) {
        return r.point_covariances[r.control[k].point].diagonal().cwiseSqrt().eval();
      };
      EXPECT_LT((of(result) - of(right)).norm(), 0.03 * of(right).norm()) << stated;
      EXPECT_LT((result.control[k].residual - right.control[k].residual).norm(), 2e-6);
    }
    EXPECT_EQ(block::control_against_images(result), "");
    EXPECT_EQ(result.block.measurements[0].sigma, stated) << "what came with the file stays";
  }
}

TEST(PointBlock, ASingleWrongControlPointIsNamedThoughAllTogetherMayBeChance) {
  auto how = options();
  how.estimate_image_variance = true;
  PointBlock block = noisy_block(2, 3e-4, 1e-3);
  block.control.position(3 * 3 + 2) += 2e-3;  // of point 13, ten sigmas up
  const std::string words = block::control_against_images(block::adjust_point_block(block, how));
  EXPECT_THAT(words, HasSubstr("control and images contradict each other"));
  EXPECT_THAT(words, HasSubstr("an error of 13 by"));
  int named = 0;
  for (uint64_t seed = 10; seed < 60; ++seed)
    named += !block::control_against_images(block::adjust_point_block(noisy_block(seed, 3e-4, 1e-3), how)).empty();
  EXPECT_LE(named, 1) << "of 50 sound blocks";
}

/// It was named and kept, and bent the block until innocent check points were called wrong.
TEST(PointBlock, AWrongControlPointIsSetAsideAndCheckPointsAreJudgedWithoutIt) {
  auto how = options();
  how.estimate_image_variance = true;
  PointBlock block = noisy_block(2, 3e-4, 1e-3);
  block.control.points.push_back(6);
  block.control.is_check.push_back(true);
  block.control.position.conservativeResize(21);
  block.control.position.tail<3>() = block.points[6].position;
  block.control.covariance = 4e-8 * Eigen::MatrixXd::Identity(21, 21);
  PointBlock sound = block;
  sound.control.is_check[3] = true;
  const double off = 2e-3;
  block.control.position(3 * 3 + 2) += off;  // of point 13
  const auto result = block::adjust_without_wrong_control(block, how);
  const auto expected = block::adjust_point_block(sound, how);
  ASSERT_EQ(result.control.size(), 7u);
  for (size_t k = 0; k < 7; ++k) {
    EXPECT_EQ(result.control[k].aside, k == 3) << k;
    EXPECT_EQ(result.control[k].check, k == 6) << k;
    EXPECT_EQ(result.control[k].point, block.control.points[k]);
  }
  EXPECT_NEAR(result.control[3].residual.z(), -off, 1e-3);
  EXPECT_LT((result.control[6].residual - expected.control[6].residual).norm(), 1e-5);
  EXPECT_EQ(block::control_against_images(result), "");
  EXPECT_EQ(result.degrees_of_freedom, expected.degrees_of_freedom);
  EXPECT_EQ(result.block.control.points, block.control.points);
  EXPECT_THAT(block::set_aside_in_words(result),
              testing::ElementsAre(HasSubstr("the control of 13, which contradicts the images")));
}

TEST(PointBlock, SoundControlStaysToTheBit) {
  auto how = options();
  how.estimate_image_variance = true;
  for (uint64_t seed = 10; seed < 20; ++seed) {
    const PointBlock block = noisy_block(seed, 3e-4, 1e-3);
    const auto result = block::adjust_without_wrong_control(block, how);
    EXPECT_TRUE(block::set_aside_in_words(result).empty()) << seed;
    EXPECT_EQ(result.block.points[7].position, block::adjust_point_block(block, how).block.points[7].position);
  }
}

/// Level ground with its coordinates exchanged is seen as well from below: no residual tells, and no number is right.
TEST(PointBlock, MirroredControlIsRefused) {
  PointBlock block = small_block();
  block.scale_bars.clear();
  block.control.points = {0, 5, 10, 15, 19};
  block.control.is_check.assign(5, false);
  block.control.position.resize(15);
  block.control.covariance = 1e-8 * Eigen::MatrixXd::Identity(15, 15);
  for (Eigen::Index k = 0; k < 5; ++k) {
    const Eigen::Vector3d p = block.points[block.control.points[k]].position;
    block.control.position.segment<3>(3 * k) = Eigen::Vector3d(p.y(), p.x(), p.z());
  }
  EXPECT_THAT(error_of([&] { block::adjust_point_block(block, options()); }),
              testing::AllOf(HasSubstr("the control is the mirror image of the block"), HasSubstr("east and north")));
}

TEST(PointBlock, AnImageThatTurnsOverIsNamed) {
  const PointBlock block = small_block();
  const auto result = block::adjust_point_block(block, options());
  EXPECT_EQ(block::turned_images(block, result), "");
  PointBlock wrong = block;  // as if the adjustment had found image 3 elsewhere than it was given
  wrong.images[2].angles = block::angles_from_rotation(block::rotation_from_angles(block.images[2].angles) *
                                                       Eigen::AngleAxisd(3, Eigen::Vector3d::UnitX()).matrix());
  EXPECT_THAT(block::turned_images(wrong, result), HasSubstr("image 3 has turned by more than 45 degrees"));
  for (auto& image : wrong.images)  // another frame is no finding
    image.angles = block::angles_from_rotation(Eigen::AngleAxisd(2, Eigen::Vector3d::UnitY()).matrix() *
                                               block::rotation_from_angles(image.angles));
  EXPECT_THAT(block::turned_images(wrong, result), HasSubstr("image 3 has turned"));
  wrong.images[2] = block.images[2];
  wrong.images[2].angles = block::angles_from_rotation(Eigen::AngleAxisd(2, Eigen::Vector3d::UnitY()).matrix() *
                                                       block::rotation_from_angles(block.images[2].angles));
  EXPECT_EQ(block::turned_images(wrong, result), "");
}

TEST(PointBlock, AMarkOfAnotherPointIsNamed) {
  PointBlock block = small_block();
  test::Random random(7);
  for (auto& m : block.measurements)
    m.position += 1e-3 * Eigen::Vector2d(random.uniform() - 0.5, random.uniform() - 0.5);
  EXPECT_EQ(block::blunders_in_words(block::adjust_point_block(block, options())), "");
  block.measurements[47].position.x() += 0.1;  // point 8 in image 3
  EXPECT_THAT(block::blunders_in_words(block::adjust_point_block(block, options())),
              testing::AllOf(HasSubstr("1 image point of 160 contradicts"), HasSubstr("point 8 in image 3")));
}

/// Two lengths of one bar, a millimetre apart and known to a hundredth, were averaged without a word.
TEST(PointBlock, ScaleBarsThatContradictEachOtherAreNamed) {
  PointBlock block = small_block();
  test::Random random(7);
  for (auto& m : block.measurements)
    m.position += 1e-3 * Eigen::Vector2d(random.uniform() - 0.5, random.uniform() - 0.5);
  const auto told = [&] { return block::scale_bars_against_images(block::adjust_point_block(block, options())); };
  EXPECT_EQ(told(), "") << "nothing checks the only bar";
  for (const int to : {7, 12, 19})
    block.scale_bars.push_back({"to " + std::to_string(to), 0, to,
                                (block.points[0].position - block.points[to].position).norm() + 0.5e-5, 1e-5});
  EXPECT_EQ(told(), "") << "half a sigma is no contradiction";
  block.scale_bars[2].length += 1e-3;
  EXPECT_THAT(told(), testing::AllOf(HasSubstr("scale bars contradict each other"), HasSubstr("most to 12 of ")));
  block.scale_bars = {block.scale_bars[0], block.scale_bars[0]};
  block.scale_bars[1].name = "again", block.scale_bars[1].length += 1e-3;
  EXPECT_THAT(told(), testing::AllOf(HasSubstr("most bar of"), HasSubstr("again of"))) << "of two either may be wrong";
}

TEST(PointBlock, ControlOfAnotherBlockIsNamedAsSuch) {
  std::vector<std::string> names;
  std::vector<Eigen::Vector3d> block, control;
  for (int k = 0; k < 6; ++k) {
    names.push_back("P" + std::to_string(k));
    block.emplace_back(k, 3 * std::sin(5.0 * k), std::cos(3.0 * k));
    control.push_back(20 * block.back() + Eigen::Vector3d(7e5, 5e6, 0));  // another frame and scale
  }
  EXPECT_NO_THROW(block::require_same_figure(names, block, control));
  control[2] += Eigen::Vector3d(300, 0, 0);  // one wrong point is not another list
  EXPECT_NO_THROW(block::require_same_figure(names, block, control));
  control[2] -= Eigen::Vector3d(300, 0, 0);
  std::rotate(control.begin(), control.begin() + 2, control.end());
  EXPECT_THAT(error_of([&] { block::require_same_figure(names, block, control); }),
              testing::AllOf(HasSubstr("6 control points are not the points of these names"), HasSubstr("15 distances"),
                             HasSubstr("another block")));
}

TEST(PhotoModelerFiles, ErrorsNameFileAndLine) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a-pmexport.txt";
  const auto read = [&](const std::string& text) {
    std::ofstream(file) << text;
    return error_of([&] { block::read_photomodeler_export(file); });
  };
  EXPECT_THAT(read(""), HasSubstr("the file ends, expected a title"));
  EXPECT_THAT(read("t\n0.0005 20\n"), HasSubstr(":2: the second line has no image size"));
  EXPECT_THAT(error_of([&] { block::read_photomodeler_export(file, {2000, 1000}); }), HasSubstr("the file ends"));
  const std::string head = "t\n0.0005 20 2000 1000\n1 0.1\n7 4 2 8 4 0 0 0 0 0\n0\n";
  EXPECT_THAT(read(head + "\n\n\n\n"), HasSubstr("the export has no photo"));
  const std::string photo = "0 a.jpg\n0 0 0 5 0 0 0\n0 0 0 0 0 0 0\n\n0 7 4 2 8 4 0 0 0 0 0\n0 0\n\n";
  EXPECT_THAT(read(head + photo + "\n1 0 x 0\n\n"), HasSubstr(":14: 'x' is not a number"));
  EXPECT_THAT(read(head + photo + "\n1 0 0 0\n\n0 1 10 10 1 1\n0 1 10 10 1 1\n"),
              HasSubstr("point 1 is marked a second time"));
  EXPECT_THAT(read(head + photo + "\n1 0 0 0\n\n3 1 10 10 1 1\n"), HasSubstr("photo 3 is not in the file"));
  EXPECT_THAT(error_of([&] { block::read_image_block(folder.path(), "b", "", {}); }),
              HasSubstr("project=b does not choose one"));
}

TEST(PhotoModelerFiles, ControlListsOfEveryShape) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "control.txt";
  const auto read = [&](const std::string& text, const std::vector<std::string>& check = {}) {
    std::ofstream(file) << text;
    block::ReadBlock block;
    block.block.points = {{"12", {0, 0, 0}}, {"P7", {0, 0, 0}}, {"13", {0, 0, 0}}};
    block::add_control(file, check, block);
    return block;
  };
  const auto full = read("# a comment\n12, CP1, 1.5, 2, 3, 0.1, 0.2, 0.3\n13 4 5 6\n99, P7, 7, 8, 9\n", {"P7"});
  ASSERT_EQ(full.block.control.points, (std::vector<int>{0, 2, 1}));
  EXPECT_EQ(full.block.control.is_check, (std::vector<bool>{false, false, true}));
  EXPECT_EQ(full.block.control.position(0), 1.5);
  EXPECT_EQ(full.block.control.position(5), 6);
  EXPECT_NEAR(full.block.control.covariance(2, 2), 0.09, 1e-15);
  EXPECT_EQ(full.block.control.covariance(4, 4), 0);
  EXPECT_THAT(error_of([&] { read("12, 1, 2\n"); }), HasSubstr("control.txt:1: found 3 columns and no header"));
  EXPECT_THAT(error_of([&] { read("55, 1, 2, 3\n"); }), HasSubstr("none of its points (55) is measured"));
  EXPECT_THAT(error_of([&] { read("12, 1, 2, 3\n12, 1, 2, 3\n"); }),
              HasSubstr("control.txt:2: point '12' stands in it twice"));
  EXPECT_THAT(error_of([&] { read("12, 1, 2, 3\n", {"14"}); }), HasSubstr("holds no check point 14"));
  EXPECT_THAT(error_of([&] { read("12, 1, 2, 3\n13 4 5 6\n", {"12", "13"}); }), HasSubstr("are check points"));
  const std::string marked = "12 1.5 2 3\r13 4 5 6\r";  // CR alone, and two bytes a character
  EXPECT_EQ(read(marked).block.control.position(5), 6);
  std::string wide = "\xFF\xFE";
  for (const char c : marked) wide += {c, '\0'};
  EXPECT_EQ(read(wide).block.control.position(0), 1.5);
}

TEST(PhotoModelerFiles, FiveNumbersAreWhatTheHeadingOrTheNumbersSay) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "control.txt";
  const auto x_of = [&](const std::string& text) {
    std::ofstream(file) << text;
    block::ReadBlock block;
    block.block.points = {{"12", {0, 0, 0}}, {"13", {0, 0, 0}}};
    block::add_control(file, {}, block);
    return block.block.control.position(0);
  };
  const std::string rows = "12, 200, 80.995, 50.6, 155.573\n13, 201, 80.989, 50.611, 151.37\n";
  EXPECT_EQ(x_of(rows), 80.995);
  EXPECT_EQ(x_of("# Id, Name, X, Y, Z, sigmaX, sigmaY, sigmaZ\n" + rows), 80.995);
  EXPECT_EQ(x_of("# id, X, Y, Z, sigma\n" + rows), 200);
  EXPECT_EQ(x_of("id,x,y,z,sigma\n" + rows), 200);
  EXPECT_EQ(x_of("12 1.5 2.5 3.5 0.005  # the name plate\n"), 1.5);
  EXPECT_EQ(x_of("#Label,X,Y,Z,Accuracy_X/Y/Z_(m)\n12,1.5,2.5,3.5,0.05\n"), 1.5);
  EXPECT_THAT(error_of([&] { x_of("12 1 2 3 4\n"); }), HasSubstr("control.txt:1: found '12 1 2 3 4': is the second"));
  // Commas within numbers, and what a spreadsheet puts first.
  EXPECT_EQ(x_of("\xEF\xBB\xBF"
                 "12;1,5;2,5;3,5\n"),
            1.5);
  EXPECT_EQ(x_of("12 1,5 2,5 3,5\n"), 1.5);
  EXPECT_EQ(x_of("12 P4;1,5;2,5;3,5\n"), 1.5);
}

TEST(PhotoModelerFiles, MarksWithoutCoordinatesAreOneSentence) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a-pmexport.txt";
  std::ofstream(file)
      << "t\n0.0005 20 2000 1000\n1 0.1\n7 4 2 8 4 0 0 0 0 0\n0\n0 a.jpg\n0 0 0 5 0 0 0\n0 0 0 0 0 0 0\n\n"
         "0 7 4 2 8 4 0 0 0 0 0\n0 0\n\n\n1 0 0 0\n\n0 1 9 9 1 1\n0 2 9 9 1 1\n0 3 8 8 1 1\n";
  const block::ReadBlock read = block::read_photomodeler_export(file);
  EXPECT_THAT(read.left_out, testing::ElementsAre("2 marks of 2 points without coordinates in the export: 2 and 3"));
  EXPECT_EQ(read.contradictions, read.left_out) << "most of what was measured";
}

TEST(PhotoModelerFiles, AnImageSizeThatIsNotThePhotographsIsRefused) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a-pmexport.txt";
  std::ofstream(file) << "t\n0.0005 20\n1 0.1\n7 4 2 8 4 0 0 0 0 0\n0\n0 a.jpg\n0 0 0 5 0 0 0\n0 0 0 0 0 0 0\n\n"
                         "0 7 4 2 8 4 0 0 0 0 0\n0 0\n\n\n1 0 0 0\n\n0 1 1900 9 1 1\n";
  EXPECT_EQ(block::read_photomodeler_export(file, {2000, 1000}).block.measurements.size(), 1u);
  EXPECT_THAT(error_of([&] {
                block::read_photomodeler_export(file, {1000, 2000});
              }),
              testing::AllOf(HasSubstr("sides of 8 and 2 um"), HasSubstr("exchanged?")));
  EXPECT_THAT(error_of([&] {
                block::read_photomodeler_export(file, {1000, 500});
              }),
              HasSubstr("point 1 is marked at (1900.0, 9.0) in photo 0, outside of 1000 x 500 pixels"));
}

TEST(PointBlock, OneOrTwoControlPointsAreNoDatum) {
  PointBlock block = small_block();
  block.control.points = {4};
  block.control.is_check = {false};
  block.control.position = block.points[4].position;
  block.control.covariance = 1e-8 * Eigen::Matrix3d::Identity();
  EXPECT_THAT(error_of([&] { block::adjust_point_block(block, options()); }),
              testing::AllOf(HasSubstr("only 1 point of the control (5)"), HasSubstr("list that of another block")));
}

TEST(PhotoModelerFiles, ANameThatIsANumberIsNotTakenForAnotherPointsNumber) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "control.txt";
  block::ReadBlock block;
  block.block.points = {{"1", {0, 0, 0}}, {"103", {5, 0, 0}}};
  std::ofstream(file)
      << "# Id, Name, X, Y, Z\n1, 101, 0, 0, 0\n24, 103, 9, 9, 9\n";  // 24 is in no image, and 103 is another point
  block::add_control(file, {}, block);
  EXPECT_EQ(block.block.control.points, std::vector<int>{0});
  EXPECT_THAT(block.left_out, testing::ElementsAre(HasSubstr("control 103: measured in no image")));
}

TEST(PhotoModelerFiles, ControlThatIsAnotherPointIsLeftOutByName) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "control.txt";
  const std::vector<Eigen::Vector3d> places = {{0, 0, 0}, {10, 0, 0}, {0, 8, 0}, {3, 4, 6}, {9, 9, 1}};
  const auto read = [&](double off) {
    block::ReadBlock block;
    std::ofstream list(file);
    for (size_t j = 0; j < places.size(); ++j) {
      const Eigen::Vector3d given = 2 * places[j] + (j == 3 ? off : 0) * Eigen::Vector3d(1, -1, 1);
      block.block.points.push_back({std::to_string(j), places[j]});
      list << j << ' ' << given.x() << ' ' << given.y() << ' ' << given.z() << " 0.005\n";
    }
    list.close();
    block::add_control(file, {}, block);
    return block;
  };
  EXPECT_TRUE(read(0).contradictions.empty());
  EXPECT_TRUE(read(0.1).contradictions.empty()) << "a mistake of centimetres is the adjustment's to find";
  const block::ReadBlock wrong = read(15);
  EXPECT_EQ(wrong.block.control.points, (std::vector<int>{0, 1, 2, 4}));
  EXPECT_EQ(wrong.block.control.position.size(), 12);
  EXPECT_EQ(wrong.block.control.covariance.rows(), 12);
  EXPECT_EQ(wrong.block.control.position(9), 18);
  EXPECT_THAT(wrong.contradictions, testing::ElementsAre(HasSubstr("control 3: other points in the block")));
  EXPECT_EQ(wrong.left_out, wrong.contradictions);
}

/// Once left out like control: the witness was gone before anybody judged, and a block with a check point 50 mm off
/// ended with "They hold".
TEST(PhotoModelerFiles, ACheckPointThatIsOffStaysToBeJudged) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "control.txt";
  const std::vector<Eigen::Vector3d> places = {{0, 0, 0}, {10, 0, 0}, {0, 8, 0}, {3, 4, 6}, {9, 9, 1}, {1, 7, 3}};
  block::ReadBlock block;
  std::ofstream list(file);
  for (size_t j = 0; j < places.size(); ++j) {
    const Eigen::Vector3d given = places[j] + (j == 3 || j == 5 ? 9.0 : 0.0) * Eigen::Vector3d(1, -1, 1);
    block.block.points.push_back({std::to_string(j), places[j]});
    list << j << ' ' << given.x() << ' ' << given.y() << ' ' << given.z() << " 0.005\n";
  }
  list.close();
  block::ReadBlock of_one = block;
  block::add_control(file, {"3"}, block);
  EXPECT_EQ(block.block.control.points, (std::vector<int>{0, 1, 2, 3, 4}));
  EXPECT_EQ(block.block.control.is_check, (std::vector<bool>{false, false, false, true, false}));
  EXPECT_THAT(block.contradictions, testing::ElementsAre(HasSubstr("control 5: other points in the block")));
  block::add_control(file, {"3", "5"}, of_one);
  EXPECT_EQ(of_one.block.control.points.size(), 6u);
  EXPECT_TRUE(of_one.contradictions.empty());
}

TEST(AiconFiles, ErrorsNameFileAndLine) {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder.path() / name) << text; };
  const auto read = [&] { return error_of([&] { block::read_aicon_folder(folder.path()); }); };
  EXPECT_THAT(read(), HasSubstr("holds no *.ior file"));
  write("b.ior", "1 -999 -28.7 0 0 0 0 13.4\n0\n0 0\n0 0\n");
  EXPECT_THAT(read(), HasSubstr("b.ior:1: the camera that begins here has 4 lines, expected 5"));
  write("b.ior", "1 -999 -28.7 0 0 0 0 13.4\n0\n0 0\n0 0\n36 24 8688 5792\n");
  write("b.eor", "1 2 0 0 0 0 0 0\n");
  EXPECT_THAT(read(), HasSubstr("b.eor:1: camera 2 is not in the .ior file"));
  write("b.eor", "1 1 0 0 0 0 0 0\n\n2 1 0 0 0 0 0\n");
  EXPECT_THAT(read(), HasSubstr("b.eor:3: found 7 columns, expected at least 8"));
  write("b.eor", "1 1 0 0 0 0 0 0\n2 1 0 0 0 0 0 0\n");
  write("b.obc", "7 1.0 2.0 x 0 0 0 5 1\n");
  EXPECT_THAT(read(), HasSubstr("b.obc:1: column 4 is 'x', expected a number"));
  write("b.obc", "7 1.0 2.0 3 0 0 0 5 1\n");
  write("b.phc", "1 7 0 0 0 0 0 0 1 1\n1 7 0 0 0 0 0 0 1 1\n");
  EXPECT_THAT(read(), HasSubstr("b.phc:2: point 7 is measured a second time in image 1, first in line 1"));
  write("b.phc", "1 7 0 0 0 0 0 0 1 1\n");
  write("b.scale", "0 \"my bar\" 7 8 100 0.1 1\n");
  EXPECT_THAT(read(), HasSubstr("b.scale:1: point 8 of scale bar 'my bar'"));
  write("b.obc", "7 1.0 2.0 3 0 0 0 5 1\n8 2.0 2.0 3 0 0 0 5 1\n");
  write("b.scale", "0 \"my bar\" 7 8 100 0.1 1\n1 \"my bar\" 8 7 100 0.1 1\n");
  EXPECT_THAT(read(), HasSubstr("b.scale:2: scale bar 'my bar' stands here a second time"));
  write("c.phc", "");
  EXPECT_THAT(error_of([&] { block::read_image_block(folder.path(), "", "", {}); }),
              HasSubstr("holds 2 *.phc files (b.phc, c.phc), expected one"));
}

/// The same minimum, and of nothing else is anything claimed.
TEST(PointBlock, ConjugateGradientsComeToTheMinimumAndStateNothing) {
  PointBlock block = small_block();
  test::Random random(8);
  for (auto& m : block.measurements) m.position += 5e-4 * Eigen::Vector2d(random.normal(), random.normal());
  block::PointBlockOptions by_factor = options(), by_gradients = options();
  by_gradients.by_gradients = true;
  const auto expected = adjust_point_block(block, by_factor), found = adjust_point_block(block, by_gradients);
  EXPECT_NEAR(found.sigma0 / expected.sigma0, 1, 1e-9);
  for (size_t j = 0; j < block.points.size(); ++j) {
    const Eigen::Vector3d sigma = expected.point_covariances[j].diagonal().cwiseSqrt();
    const Eigen::Vector3d apart = found.block.points[j].position - expected.block.points[j].position;
    EXPECT_LT(apart.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-3) << block.points[j].name;
    EXPECT_TRUE(found.point_covariances[j].array().isNaN().all());
  }
  EXPECT_EQ(found.point_covariance.size(), 0);
  for (size_t m = 0; m < block.measurements.size(); ++m) {
    const auto &ours = found.measurement_reliability[m][0], &theirs = expected.measurement_reliability[m][0];
    EXPECT_NEAR(ours.residual, theirs.residual, 1e-8);
    EXPECT_TRUE(std::isnan(ours.w) && std::isnan(ours.redundancy_number));
  }
  EXPECT_TRUE(found.pose_covariance[0].array().isNaN().all());
  EXPECT_TRUE(found.interior_covariance[0].array().isNaN().all());
}

}  // namespace test_point_block
