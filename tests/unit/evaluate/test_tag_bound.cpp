// The bound against a second derivation: the whole system at once, its derivatives by differences of the projection.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "geometry/marker_plate.hpp"
#include "geometry/random.hpp"
#include "photo/block/image_plan.hpp"
#include "photo/block/tag_bound.hpp"

namespace plumbline::block {
namespace test_tag_bound {

/// Five plates on a facade in two batches, four convergent images, control on three of them with correlated heights.
BoundProblem small_problem() {
  BoundProblem p;
  p.camera.width = 6000, p.camera.height = 4000;
  p.camera.fx = p.camera.fy = 7000, p.camera.cx = 3000, p.camera.cy = 2000, p.camera.k1 = -0.05;
  p.free_parameters = {0, 1, 2, 3, 4};
  p.camera_prior = Eigen::VectorXd::Constant(5, 4.0).asDiagonal();
  p.camera_prior(4, 4) = 1e-6;
  p.camera_prior(0, 1) = p.camera_prior(1, 0) = 3.9;
  Random random(7);
  const Eigen::Quaterniond facade(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  for (int i = 0; i < 5; ++i) {
    BoundPlate plate;
    plate.anchor = "P" + std::to_string(i);
    plate.position = {2.0 * (i % 3), 0.1 * i, 2.0 * (i / 3)};
    plate.world_from_plate = facade * Eigen::Quaterniond(Eigen::AngleAxisd(0.05 * i, Eigen::Vector3d::UnitY()));
    plate.tag_centre_in_plate = {0, -0.15, 0};
    plate.corners_in_plate = tag_corners_in_plate({0.2, plate.tag_centre_in_plate});
    plate.batch = i % 2;
    p.plates.push_back(plate);
  }
  p.batches = 2;
  p.batch_scale_sigma = 1e-3;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d place(-1.0 + 2 * i, -8, 1.0 + 0.5 * (i % 2)), ahead = Eigen::Vector3d(2, 0.2, 1) - place;
    Eigen::Matrix3d rotation;
    rotation.row(2) = ahead.normalized();
    rotation.row(0) = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
    rotation.row(1) = rotation.row(2).cross(rotation.row(0));
    const Eigen::Quaterniond turned =
        Eigen::AngleAxisd(i % 2 ? M_PI / 2 : 0, Eigen::Vector3d::UnitZ()) * Eigen::Quaterniond(rotation);
    p.cam_from_world.push_back({turned, -(turned * place)});
    for (std::size_t j = 0; j < 5; ++j) {
      if (i == 3 && j == 0) continue;  // not every image sees all
      BoundTag tag;
      tag.image = static_cast<std::size_t>(i), tag.plate = j;
      for (Eigen::Matrix2d& c : tag.covariances) c << 0.01, 0.002 * random.uniform(), 0, 0.02, c(1, 0) = c(0, 1);
      p.tags.push_back(tag);
    }
  }
  p.control = {0, 2, 4};
  p.control_covariance = 1e-6 * Eigen::MatrixXd::Identity(9, 9);
  for (int a = 2; a < 9; a += 3)
    for (int b = 2; b < 9; b += 3) p.control_covariance(a, b) += 0.5e-6;
  return p;
}

/// All pixels for changed unknowns: poses, plates, camera, batches.
Eigen::VectorXd pixels(const BoundProblem& p, const Eigen::VectorXd& change) {
  Eigen::Index at = 0;
  const auto next = [&](Eigen::Index count) {
    const Eigen::VectorXd part = change.segment(at, count);
    at += count;
    return part;
  };
  std::vector<RigidTransform> poses = p.cam_from_world;
  for (RigidTransform& pose : poses) {
    const Eigen::VectorXd d = next(6);
    pose.rotation = quaternion_from_rotation_vector(d.head<3>()) * pose.rotation;
    pose.translation += d.tail<3>();
  }
  std::vector<BoundPlate> plates = p.plates;
  for (BoundPlate& plate : plates) {
    const Eigen::VectorXd d = next(6);
    plate.position += d.head<3>();
    plate.world_from_plate = quaternion_from_rotation_vector(d.tail<3>()) * plate.world_from_plate;
  }
  BrownCamera camera = p.camera;
  auto values = camera.parameters();
  const Eigen::VectorXd d = next(static_cast<Eigen::Index>(p.free_parameters.size()));
  for (std::size_t k = 0; k < p.free_parameters.size(); ++k)
    values[p.free_parameters[k]] += d(static_cast<Eigen::Index>(k));
  camera.set_parameters(values);
  const Eigen::VectorXd scales = next(p.batches);
  Eigen::VectorXd all(static_cast<Eigen::Index>(8 * p.tags.size()));
  for (std::size_t t = 0; t < p.tags.size(); ++t) {
    const BoundPlate& plate = plates[p.tags[t].plate];
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d corner =
          plate.tag_centre_in_plate +
          (1 + scales(plate.batch)) * (plate.corners_in_plate[i] - plate.tag_centre_in_plate);
      all.segment<2>(static_cast<Eigen::Index>(8 * t + 2 * i)) =
          *project(camera, poses[p.tags[t].image] * (plate.position + plate.world_from_plate * corner));
    }
  }
  return all;
}

Eigen::MatrixXd bound_by_differences(const BoundProblem& p) {
  const auto poses = static_cast<Eigen::Index>(6 * p.cam_from_world.size()),
             plates = static_cast<Eigen::Index>(6 * p.plates.size()),
             camera = static_cast<Eigen::Index>(p.free_parameters.size()), n = poses + plates + camera + p.batches;
  Eigen::MatrixXd slope(static_cast<Eigen::Index>(8 * p.tags.size()), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index of_camera = k - poses - plates;
    const bool in_pixels = of_camera >= 0 && of_camera < camera && p.free_parameters[of_camera] < 4;
    Eigen::VectorXd change = Eigen::VectorXd::Zero(n);
    change(k) = in_pixels ? 1e-1 : 1e-5;
    slope.col(k) = (pixels(p, change) - pixels(p, -change)) / (2 * change(k));
  }
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(slope.rows(), slope.rows());
  for (std::size_t t = 0; t < p.tags.size(); ++t)
    for (std::size_t i = 0; i < 4; ++i)
      weights.block<2, 2>(static_cast<Eigen::Index>(8 * t + 2 * i), static_cast<Eigen::Index>(8 * t + 2 * i)) =
          p.tags[t].covariances[i].inverse();
  Eigen::MatrixXd normal = slope.transpose() * weights * slope;
  normal.block(poses + plates, poses + plates, camera, camera) += p.camera_prior.inverse();
  for (int b = 0; b < p.batches; ++b)
    normal(n - p.batches + b, n - p.batches + b) += 1 / (p.batch_scale_sigma * p.batch_scale_sigma);
  const Eigen::MatrixXd control = p.control_covariance.inverse();
  for (std::size_t a = 0; a < p.control.size(); ++a)
    for (std::size_t b = 0; b < p.control.size(); ++b)
      normal.block<3, 3>(poses + static_cast<Eigen::Index>(6 * p.control[a]),
                         poses + static_cast<Eigen::Index>(6 * p.control[b])) +=
          control.block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * b));
  const Eigen::MatrixXd whole = normal.fullPivLu().inverse();
  Eigen::MatrixXd anchors(static_cast<Eigen::Index>(3 * p.plates.size()),
                          static_cast<Eigen::Index>(3 * p.plates.size()));
  for (Eigen::Index a = 0; a < anchors.rows(); ++a)
    for (Eigen::Index b = 0; b < anchors.rows(); ++b)
      anchors(a, b) = whole(poses + 6 * (a / 3) + a % 3, poses + 6 * (b / 3) + b % 3);
  return anchors;
}

TEST(TagBound, IsTheInverseOfTheWholeInformation) {
  const BoundProblem problem = small_problem();
  const Eigen::MatrixXd bound = tag_bound(problem), other = bound_by_differences(problem);
  for (Eigen::Index i = 0; i < bound.rows(); ++i)
    for (Eigen::Index j = 0; j < bound.rows(); ++j)
      EXPECT_NEAR(bound(i, j), other(i, j), 1e-5 * std::sqrt(other(i, i) * other(j, j))) << i << " " << j;
}

/// All nine parameters free and none zero, one prior for each so loose that its slope counts.
TEST(TagBound, EveryLensParameterActsAsInTheProjection) {
  BoundProblem problem = small_problem();
  problem.camera.fy = 6900;
  problem.camera.k2 = 0.4, problem.camera.k3 = -0.7, problem.camera.p1 = 0.004, problem.camera.p2 = -0.006;
  const std::vector<double> prior = {3, 3, 5, 5, 0.02, 0.3, 3, 2e-3, 2e-3};
  for (int alone = -1; alone < 9; ++alone) {
    problem.free_parameters.clear();
    std::vector<double> variances;
    for (int k = 0; k < 9; ++k) {
      if (alone >= 0 && k != alone) continue;
      problem.free_parameters.push_back(k);
      variances.push_back(std::pow(prior[k], 2));
    }
    problem.camera_prior =
        Eigen::Map<Eigen::VectorXd>(variances.data(), std::ssize(variances)).asDiagonal().toDenseMatrix();
    const Eigen::MatrixXd bound = tag_bound(problem), other = bound_by_differences(problem);
    for (Eigen::Index i = 0; i < bound.rows(); ++i)
      EXPECT_NEAR(bound(i, i) / other(i, i), 1, 2e-5) << "parameter " << alone << ", coordinate " << i;
  }
}

TEST(TagBound, EveryParameterOfAFisheyeActsAsInTheProjection) {
  BoundProblem problem = small_problem();
  problem.camera.lens = LensModel::fisheye, problem.camera.fx = 5000, problem.camera.fy = 4900;
  problem.camera.k1 = 0.05, problem.camera.k2 = 0.04, problem.camera.k3 = -0.07, problem.camera.k4 = 0.03;
  const std::vector<double> prior = {3, 3, 5, 5, 0.02, 0.3, 3, 3};
  for (int alone = 0; alone < 8; ++alone) {
    problem.free_parameters = {alone};
    problem.camera_prior = Eigen::MatrixXd::Constant(1, 1, std::pow(prior[alone], 2));
    const Eigen::MatrixXd bound = tag_bound(problem), other = bound_by_differences(problem);
    for (Eigen::Index i = 0; i < bound.rows(); ++i)
      EXPECT_NEAR(bound(i, i) / other(i, i), 1, 2e-5) << "parameter " << alone << ", coordinate " << i;
  }
}

TEST(TagBound, ControlOnOneLineLeavesTheDatumOpen) {
  BoundProblem problem = small_problem();
  problem.control = {0};
  problem.control_covariance = 1e-6 * Eigen::MatrixXd::Identity(3, 3);
  try {
    tag_bound(problem);
    FAIL() << "one anchor holds no rotation";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("rotation about"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("of the whole block"));
  }
}

TEST(TagBound, MoreObservationsNeverRaiseIt) {
  BoundProblem problem = small_problem(), less = problem;
  less.tags.pop_back();
  const Eigen::MatrixXd all = tag_bound(problem), fewer = tag_bound(less);
  for (Eigen::Index i = 0; i < all.rows(); ++i) EXPECT_LE(all(i, i), fewer(i, i) * (1 + 1e-9));
}

TEST(TagBound, APlateThatNoImageShowsHasNone) {
  BoundProblem problem = small_problem();
  problem.plates.push_back(problem.plates[1]);
  problem.plates.back().anchor = "unseen";
  const Eigen::MatrixXd bound = tag_bound(problem);
  EXPECT_TRUE(std::isinf(bound(15, 15)));
  EXPECT_TRUE(bound.topLeftCorner(15, 15).allFinite());
}

const std::vector<std::size_t> all_plates{0, 1, 2, 3, 4};

/// Variances of the heights of all plates.
Eigen::VectorXd height_variances(const BoundProblem& problem) {
  const Eigen::VectorXd diagonal = tag_bound(problem).diagonal();
  return diagonal(Eigen::seqN(2, static_cast<Eigen::Index>(problem.plates.size()), 3));
}

TEST(ImagePlan, GainOfAnImageIsThatOfAdjustingWithIt) {
  const BoundProblem problem = small_problem();
  BoundProblem more = problem;
  std::vector<BoundTag> tags;
  for (const BoundTag& tag : problem.tags)
    if (tag.image == 3) tags.push_back(tag);
  more.cam_from_world.push_back(problem.cam_from_world[3]);
  for (BoundTag tag : tags) tag.image = 4, more.tags.push_back(tag);
  const TagBound bound(problem);
  const Eigen::VectorXd gain = bound.height_gain(bound.of_image(problem.cam_from_world[3], tags), all_plates),
                        expected = height_variances(problem) - height_variances(more);
  for (Eigen::Index i = 0; i < gain.size(); ++i) EXPECT_NEAR(gain(i), expected(i), 1e-6 * expected.maxCoeff());
  EXPECT_GT(expected.minCoeff(), 0);
}

TEST(ImagePlan, GainOfASurveyedMarkerIsThatOfAdjustingWithIt) {
  const BoundProblem problem = small_problem();
  BoundProblem more = problem;
  more.control.push_back(3);
  more.control_covariance.conservativeResizeLike(Eigen::MatrixXd::Zero(12, 12));
  more.control_covariance.bottomRightCorner<3, 3>() = 4e-6 * Eigen::Matrix3d::Identity();
  const TagBound bound(problem);
  const Eigen::VectorXd gain = bound.height_gain(bound.of_survey(3, 2e-3), all_plates),
                        expected = height_variances(problem) - height_variances(more);
  for (Eigen::Index i = 0; i < gain.size(); ++i) EXPECT_NEAR(gain(i), expected(i), 1e-6 * expected.maxCoeff());
}

TEST(ImagePlan, ListsWhatSaysLittleAndWhatGainsMost) {
  BoundProblem problem = small_problem();
  std::erase_if(problem.tags, [](const BoundTag& tag) { return tag.image == 1 && tag.plate > 1; });
  const ImagePlan plan = plan_images(problem, TagBound(problem), {0, 2, 3, 4}, {});
  ASSERT_EQ(plan.weak.size(), 1u);
  EXPECT_EQ(plan.weak[0].image, 1u);
  EXPECT_EQ(plan.weak[0].plates, 2);
  const std::vector<int> wanted{0, 2, 3, 4};
  const Eigen::VectorXd heights = height_variances(problem)(wanted);
  EXPECT_NEAR(plan.rmse_z, std::sqrt(heights.mean()), 1e-12);
  EXPECT_NEAR(plan.worst_sigma, std::sqrt(heights.maxCoeff()), 1e-12);
  std::size_t surveys = 0;
  for (std::size_t i = 0; i < plan.additions.size(); ++i) {
    const Addition& a = plan.additions[i];
    EXPECT_LE(a.rmse_z, plan.rmse_z);
    const double cost = a.kind == Addition::Kind::survey ? 3 : 1;
    EXPECT_NEAR(a.per_cost, (1 - a.rmse_z / plan.rmse_z) / cost, 1e-12);
    EXPECT_LE(a.per_cost, plan.additions[i > 0 ? i - 1 : 0].per_cost);
    surveys += a.kind == Addition::Kind::survey;
  }
  EXPECT_EQ(surveys, 1u);  // plate 1: neither control nor one that counts
}

/// A tag so far off the axis that the distortion polynomial folds it back into the image covers none of it.
TEST(ImagePlan, WhatTheDistortionFoldsBackIsNotInTheImage) {
  ImagePlanOptions all;
  all.least_coverage = 1;  // every image is listed with its coverage
  const std::vector<std::size_t> wanted{0, 2, 3, 4};
  BoundProblem problem = small_problem();
  const ImagePlan without = plan_images(problem, TagBound(problem), wanted, all);
  problem.plates.push_back(problem.plates.back());
  const RigidTransform world_from_cam = problem.cam_from_world[0].inverse();
  const double folded = std::sqrt(1 / 0.05);  // r (1 + k1 r²) is zero again there
  problem.plates.back().position = world_from_cam * Eigen::Vector3d(2 * folded - 0.2, 0.4, 2);
  problem.tags.push_back(problem.tags.front());
  problem.tags.back().image = 0, problem.tags.back().plate = 5;
  const auto drawn = project(problem.camera, problem.cam_from_world[0] * problem.plates.back().position);
  ASSERT_TRUE(drawn && drawn->x() > 0 && drawn->x() < 6000 && drawn->y() > 0 && drawn->y() < 4000)
      << "or none is folded";
  const ImagePlan plan = plan_images(problem, TagBound(problem), wanted, all);
  ASSERT_EQ(plan.weak.size(), without.weak.size());
  EXPECT_NEAR(plan.weak[0].coverage, without.weak[0].coverage, 1e-12);
}

}  // namespace test_tag_bound
}  // namespace plumbline::block
