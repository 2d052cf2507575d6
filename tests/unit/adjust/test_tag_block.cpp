#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "geometry/statistics.hpp"
#include "synthetic_block.hpp"

namespace test_tag_block {

using namespace plumbline;
using block::TagBlockOptions;
using block::TagBlockResult;
using test::SyntheticBlock;

double largest_error(const SyntheticBlock& synthetic, const TagBlockResult& result) {
  double largest = 0;
  for (size_t j = 0; j < result.plates.size(); ++j)
    largest = std::max(largest, (result.anchors.segment<3>(3 * j) - synthetic.anchors[result.plates[j]]).norm());
  return largest;
}

TEST(TagBlock, RecoversTruthWithoutNoise) {
  const auto synthetic = test::make_block({.noise = false});
  const auto result = block::adjust_tag_block(synthetic.block, test::bound_options());
  EXPECT_LT(largest_error(synthetic, result), 1e-8);
  EXPECT_NEAR(result.cameras[0].interior.fx, synthetic.camera.fx, 1e-4);
  EXPECT_NEAR(result.cameras[0].interior.cy, synthetic.camera.cy, 1e-4);
  EXPECT_NEAR(result.cameras[0].interior.k1, synthetic.camera.k1, 1e-8);
  EXPECT_NEAR(result.batches[0].scale, 1, 1e-8);
  EXPECT_LT(result.weighted_sum_of_squares, 1e-6);
  for (size_t i = 0; i < synthetic.cam_from_world.size(); ++i) {
    ASSERT_TRUE(result.cam_from_world[i]);
    EXPECT_LT((result.cam_from_world[i]->translation - synthetic.cam_from_world[i].translation).norm(), 1e-6);
    EXPECT_LT(result.cam_from_world[i]->rotation.angularDistance(synthetic.cam_from_world[i].rotation), 1e-7);
  }
  EXPECT_TRUE(result.left_out.empty());
  EXPECT_TRUE(result.weak_datum.empty());
}

/// With a calibration that is a little off, through a lens that no polynomial of the tangent follows.
TEST(TagBlock, RecoversTruthThroughAFisheye) {
  const auto synthetic = test::make_block({.noise = false, .fisheye = true});
  double widest = 0;
  for (const auto& seen : synthetic.block.observations)
    for (const auto& corner : seen.corners) widest = std::max(widest, unproject(synthetic.camera, corner)->norm());
  ASSERT_GT(widest, std::tan(40 * M_PI / 180)) << "so far off the axis";
  const auto result = block::adjust_tag_block(synthetic.block, test::bound_options());
  EXPECT_LT(largest_error(synthetic, result), 1e-8);
  EXPECT_EQ(result.cameras[0].interior.lens, LensModel::fisheye);
  EXPECT_NEAR(result.cameras[0].interior.fx, synthetic.camera.fx, 1e-4);
  EXPECT_NEAR(result.cameras[0].interior.k1, synthetic.camera.k1, 1e-8);
  EXPECT_EQ(result.cameras[0].interior.k4, synthetic.camera.k4) << "held: nobody named it";
  EXPECT_EQ(result.cameras[0].distance_terms.norm(), 0);
  for (const auto& test : result.models) EXPECT_THAT(test.group, testing::Not(testing::HasSubstr("distances")));
  auto all = test::bound_options();
  all.free_interior = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "p1"};
  auto off = synthetic.block;
  off.cameras[0].interior.k3 += 1e-3, off.cameras[0].interior.k4 -= 5e-4;
  const auto freed = block::adjust_tag_block(off, all);
  EXPECT_NEAR(freed.cameras[0].interior.k3, synthetic.camera.k3, 1e-7);
  EXPECT_NEAR(freed.cameras[0].interior.k4, synthetic.camera.k4, 1e-7);
  EXPECT_GT(freed.cameras[0].covariance(7, 7), 0);
  EXPECT_EQ(freed.cameras[0].covariance(8, 8), 0) << "a fisheye has eight";
  all.free_interior = {"k5"};
  EXPECT_THAT([&] { block::adjust_tag_block(off, all); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("and k4 of a fisheye")));
}

TEST(TagBlock, CountsAndRedundancyAddUp) {
  const auto synthetic = test::make_block({.floors = 1});
  const auto result = block::adjust_tag_block(synthetic.block, test::bound_options());
  const int tags = static_cast<int>(synthetic.block.observations.size());
  EXPECT_EQ(result.observations, 8 * tags + 3 * 8 + 1);  // corners, control, aspect condition
  EXPECT_EQ(result.unknowns, 6 * 16 + 6 * 11 + 8 + 1);   // poses, plates, interior orientation, tag scale
  EXPECT_EQ(result.degrees_of_freedom, result.observations - result.unknowns);
  double redundancy = 0;
  for (const auto& group : result.groups) redundancy += group.redundancy;
  EXPECT_NEAR(redundancy, result.degrees_of_freedom, 1e-6);
  EXPECT_EQ(result.tags.size(), synthetic.block.observations.size());
  ASSERT_EQ(result.control.size(), 8u);
  for (const auto& control : result.control)
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_GT(control.coordinates[c].redundancy_number, 0.3);
      EXPECT_NEAR(
          control.coordinates[c].mdb,
          least_squares::non_centrality(0.001, 0.8) * 0.001 / std::sqrt(control.coordinates[c].redundancy_number),
          1e-6);
      EXPECT_GT(control.effect_on_height[2], 0);
      EXPECT_LT(control.effect_on_height[c], control.coordinates[c].mdb);
    }
}

/// The whole block in another frame: far away, turned about an oblique axis.
TEST(TagBlock, EquivariantUnderAChangeOfFrame) {
  const auto synthetic = test::make_block({.floors = 1});
  const RigidTransform other_from_world{quaternion_from_rotation_vector({0.3, -0.5, 2.1}),
                                        {512345.6, 5412345.7, 432.1}};
  const Eigen::Matrix3d turn = other_from_world.rotation.toRotationMatrix();
  auto moved = synthetic.block;
  for (auto& image : moved.images) image.cam_from_world = *image.cam_from_world * other_from_world.inverse();
  for (auto& plate : moved.plates) plate.nominal_rotation = other_from_world.rotation * plate.nominal_rotation;
  // Anisotropic control, so that a covariance that is not turned along is noticed.
  auto block = synthetic.block;
  for (Eigen::Index i = 2; i < block.control.position.size(); i += 3) block.control.covariance(i, i) *= 4;
  for (size_t k = 0; k < block.control.plates.size(); ++k) {
    moved.control.position.segment<3>(3 * k) = other_from_world * block.control.position.segment<3>(3 * k);
    moved.control.covariance.block<3, 3>(3 * k, 3 * k) =
        turn * block.control.covariance.block<3, 3>(3 * k, 3 * k) * turn.transpose();
  }
  const auto here = block::adjust_tag_block(block, test::bound_options());
  const auto there = block::adjust_tag_block(moved, test::bound_options());
  EXPECT_NEAR(here.weighted_sum_of_squares, there.weighted_sum_of_squares, 1e-4);
  for (size_t j = 0; j < here.plates.size(); ++j) {
    const Eigen::Vector3d p = here.anchors.segment<3>(3 * j), q = there.anchors.segment<3>(3 * j);
    EXPECT_LT((other_from_world * p - q).norm(), 1e-8);
    const Eigen::Matrix3d expected = turn * here.anchor_covariance.block<3, 3>(3 * j, 3 * j) * turn.transpose();
    const Eigen::Matrix3d difference = expected - there.anchor_covariance.block<3, 3>(3 * j, 3 * j);
    EXPECT_LT(difference.norm(), 1e-5 * expected.norm());
  }
}

/// (5) as printed, of the solution's image and control residuals.
double equation_5(const SyntheticBlock& synthetic, const TagBlockResult& result, double lambda,
                  const Eigen::VectorXd& anchors) {
  double sum = 0;
  for (const auto& seen : synthetic.block.observations) {
    const size_t j = static_cast<size_t>(test::row_of_plate(result, seen.plate) / 3);
    MarkerPlate plate = synthetic.block.plates[seen.plate].plate;
    plate.tag_size *= result.batches[0].scale;
    const auto corners = tag_corners_in_plate(plate);
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d corner = anchors.segment<3>(3 * j) + result.world_from_plate[j] * corners[k];
      sum += (seen.corners[k] - *project(result.cameras[0].interior, *result.cam_from_world[seen.image] * corner))
                 .squaredNorm();
    }
  }
  for (size_t k = 0; k < synthetic.block.control.plates.size(); ++k) {
    const Eigen::Index row = test::row_of_plate(result, synthetic.block.control.plates[k]);
    sum += lambda * (anchors.segment<3>(row) - synthetic.block.control.position.segment<3>(3 * k)).squaredNorm();
  }
  return sum;
}

TEST(TagBlock, LambdaEqualsCovarianceForIsotropicNoise) {
  const auto synthetic = test::make_block({.floors = 1, .corner_sigma = 0.2, .survey_sigma = 0.001});
  TagBlockOptions by_covariance = test::bound_options(), by_lambda = by_covariance;
  by_lambda.weighting = TagBlockOptions::Weighting::lambda;
  by_lambda.lambda = std::pow(0.2 / 0.001, 2);  // (σ_px / σ_S)²
  by_lambda.corner_sigma = 0.2;
  const auto a = block::adjust_tag_block(synthetic.block, by_covariance);
  const auto b = block::adjust_tag_block(synthetic.block, by_lambda);
  EXPECT_LT((a.anchors - b.anchors).norm(), 1e-9);
  EXPECT_LT((a.anchor_covariance - b.anchor_covariance).norm(), 1e-6 * a.anchor_covariance.norm());
  // And it is the minimum of the formula: the slope along every anchor coordinate vanishes, the curvature does not.
  constexpr double step = 1e-5;
  const double at_minimum = equation_5(synthetic, b, by_lambda.lambda, b.anchors);
  for (Eigen::Index i = 0; i < b.anchors.size(); ++i) {
    Eigen::VectorXd up = b.anchors, down = b.anchors;
    up(i) += step;
    down(i) -= step;
    const double above = equation_5(synthetic, b, by_lambda.lambda, up),
                 below = equation_5(synthetic, b, by_lambda.lambda, down);
    EXPECT_GT(above + below - 2 * at_minimum, 0);
    EXPECT_LT(std::abs(above - below), 1e-3 * (above + below - 2 * at_minimum)) << i;
  }
}

/// Of one tag, adjusted minus measured [px].
Eigen::VectorXd residuals_of(const SyntheticBlock& synthetic, const TagBlockResult& result, size_t observation) {
  const auto& seen = synthetic.block.observations[observation];
  const Eigen::Index at = test::row_of_plate(result, seen.plate);
  MarkerPlate plate = synthetic.block.plates[seen.plate].plate;
  plate.tag_size *= result.batches[0].scale;
  const auto corners = tag_corners_in_plate(plate);
  Eigen::VectorXd residuals(8);
  for (size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d corner = result.anchors.segment<3>(at) + result.world_from_plate[at / 3] * corners[k];
    residuals.segment<2>(2 * static_cast<Eigen::Index>(k)) =
        *project(result.cameras[0].interior, *result.cam_from_world[seen.image] * corner) - seen.corners[k];
  }
  return residuals;
}

/// Of the unit weights of (5): residuals by projection, how much of an error in an observation shows in its residual by
/// putting one in, the common variance by the sum of squares as printed. The corner sigma given is three times too
/// large, and none of the numbers may follow it.
TEST(TagBlock, LambdaTestsTagsAndControlAgainstTheVarianceFound) {
  const auto synthetic = test::make_block({.floors = 1, .stations = 3, .seed = 7});
  TagBlockOptions options = test::bound_options();
  options.fixed_aspect = false;
  options.weighting = TagBlockOptions::Weighting::lambda;
  options.lambda = std::pow(0.2 / 0.001, 2);
  options.corner_sigma = 0.6;
  options.estimate_image_variance = true;
  const auto found = block::adjust_tag_block(synthetic.block, options);
  const double variance = equation_5(synthetic, found, options.lambda, found.anchors) / found.degrees_of_freedom;
  EXPECT_NEAR(std::sqrt(variance), 0.2, 0.01);
  const double non_centrality = normal_quantile(1 - 0.0005) + normal_quantile(0.8);

  const size_t observation = 17;
  const auto& tag = found.tags[observation];
  ASSERT_EQ(tag.observation, static_cast<int>(observation));
  const Eigen::VectorXd residuals = residuals_of(synthetic, found, observation);
  constexpr double error = 0.02;  // [px]
  double smallest = 1, largest_w = 0, largest_mdb = 0;
  for (Eigen::Index row = 0; row < 8; ++row) {
    SyntheticBlock disturbed = synthetic;
    disturbed.block.observations[observation].corners[row / 2](row % 2) += error;
    const auto after = block::adjust_tag_block(disturbed.block, options);
    const double shown = (residuals - residuals_of(disturbed, after, observation))(row) / error;
    smallest = std::min(smallest, shown);
    largest_w = std::max(largest_w, std::abs(residuals(row)) / std::sqrt(variance * shown));
    largest_mdb = std::max(largest_mdb, non_centrality * std::sqrt(variance / shown));
  }
  EXPECT_LT(smallest, 0.95);
  EXPECT_NEAR(tag.smallest_redundancy, smallest, 1e-3);  // residuals bend the sum of squares a little
  EXPECT_NEAR(tag.largest_normalised, largest_w, 1e-3 * largest_w);
  EXPECT_NEAR(tag.largest_detectable_error, largest_mdb, 1e-3 * largest_mdb);

  const size_t point = 3;
  for (size_t c = 0; c < 3; ++c) {
    constexpr double metres = 1e-3;
    SyntheticBlock disturbed = synthetic;
    disturbed.block.control.position(static_cast<Eigen::Index>(3 * point + c)) += metres;
    const auto after = block::adjust_tag_block(disturbed.block, options);
    const auto& control = found.control[point].coordinates[c];
    const double shown = (control.residual - after.control[point].coordinates[c].residual) / metres;
    const double sigma = std::sqrt(variance / options.lambda);
    EXPECT_NEAR(control.redundancy_number, shown, 1e-4);
    EXPECT_NEAR(std::abs(control.w), std::abs(control.residual) / (sigma * std::sqrt(shown)), 1e-3) << c;
    EXPECT_NEAR(control.mdb, non_centrality * sigma / std::sqrt(shown), 1e-3 * control.mdb) << c;
  }

  // The same weights as variances that are known: every covariance is that block's.
  TagBlockOptions known = options;
  known.weighting = TagBlockOptions::Weighting::covariance;
  known.estimate_image_variance = false;
  auto stated = synthetic.block;
  for (auto& seen : stated.observations) seen.covariances.fill(variance * Eigen::Matrix2d::Identity());
  stated.control.covariance = variance / options.lambda *
                              Eigen::MatrixXd::Identity(stated.control.position.size(), stated.control.position.size());
  const auto expected = block::adjust_tag_block(stated, known);
  const auto same = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).norm() < 1e-5 * b.norm(); };
  EXPECT_TRUE(same(found.anchor_covariance, expected.anchor_covariance));
  EXPECT_TRUE(same(found.interior_covariance, expected.interior_covariance));
  for (size_t i = 0; i < found.pose_covariance.size(); ++i)
    EXPECT_TRUE(same(found.pose_covariance[i], expected.pose_covariance[i])) << i;
  EXPECT_NEAR(found.batches[0].scale_sigma, expected.batches[0].scale_sigma, 1e-5 * expected.batches[0].scale_sigma);
  EXPECT_NEAR(found.image_variance_factor, variance / 0.36, 1e-6 * found.image_variance_factor);
}

TEST(TagBlock, LambdaOfOneIgnoresControl) {
  auto synthetic = test::make_block({.floors = 1, .noise = false});
  synthetic.block.control.position(2) += 0.01;
  TagBlockOptions options = test::bound_options();
  options.weighting = TagBlockOptions::Weighting::lambda;
  for (double lambda : {1.0, 1e11}) {
    options.lambda = lambda;
    const auto result = block::adjust_tag_block(synthetic.block, options);
    const double pulled = result.control[0].coordinates[2].residual;  // adjusted minus survey
    if (lambda == 1)
      EXPECT_LT(pulled, -0.005);
    else
      EXPECT_GT(pulled, -0.001);
  }
}

TEST(TagBlock, PredictedCovarianceCoversTheErrors) {
  constexpr int trials = 40;
  double chi_squared = 0, sum_of_squares = 0;
  int dimension = 0, freedom = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto synthetic = test::make_block({.floors = 1, .seed = 100 + static_cast<uint64_t>(trial)});
    const auto result = block::adjust_tag_block(synthetic.block, test::bound_options());
    std::vector<int> rows;
    for (int plate : synthetic.check)
      for (int c = 0; c < 3; ++c) rows.push_back(static_cast<int>(test::row_of_plate(result, plate)) + c);
    Eigen::VectorXd error(rows.size());
    for (size_t i = 0; i < rows.size(); ++i)
      error(static_cast<Eigen::Index>(i)) =
          result.anchors(rows[i]) - synthetic.anchors[synthetic.check[i / 3]](static_cast<int>(i % 3));
    chi_squared += error.dot(result.anchor_covariance(rows, rows).llt().solve(error));
    dimension += static_cast<int>(rows.size());
    sum_of_squares += result.weighted_sum_of_squares;
    freedom += result.degrees_of_freedom;
  }
  EXPECT_GT(chi_squared, chi_squared_quantile(0.005, dimension));
  EXPECT_LT(chi_squared, chi_squared_quantile(0.995, dimension));
  EXPECT_GT(sum_of_squares, chi_squared_quantile(0.005, freedom));
  EXPECT_LT(sum_of_squares, chi_squared_quantile(0.995, freedom));
}

TEST(TagBlock, VarianceComponentOfTheImagesIsFound) {
  auto synthetic = test::make_block({.floors = 1, .corner_sigma = 0.2});
  for (auto& seen : synthetic.block.observations)
    for (auto& covariance : seen.covariances) covariance /= 9;  // the detector claims a third of its standard deviation
  auto options = test::bound_options();
  options.estimate_image_variance = true;
  const auto result = block::adjust_tag_block(synthetic.block, options);
  EXPECT_NEAR(result.image_variance_factor, 9, 0.9);
  EXPECT_NEAR(result.sigma0, 1, 0.02);
}

TEST(TagBlock, TagScaleAndInsetAreSeparated) {
  auto synthetic = test::make_block({.floors = 1, .corner_sigma = 0.05, .noise = false});
  const double printed = 1.0005, inset = 0.125;
  for (auto& seen : synthetic.block.observations) {
    const size_t i = static_cast<size_t>(seen.image), j = static_cast<size_t>(seen.plate);
    MarkerPlate plate = synthetic.block.plates[j].plate;
    plate.tag_size *= printed;
    const auto corners = tag_corners_in_plate(plate);
    for (size_t k = 0; k < 4; ++k)
      seen.corners[k] =
          *project(synthetic.camera,
                   synthetic.cam_from_world[i] * (synthetic.anchors[j] + synthetic.world_from_plate[j] * corners[k]));
    seen.corners = test::drawn_inwards(seen.corners, inset);
  }
  auto options = test::bound_options();
  options.corner_inset_sigma = 10;
  const auto result = block::adjust_tag_block(synthetic.block, options);
  EXPECT_NEAR(result.batches[0].scale, printed, 2e-6);
  EXPECT_NEAR(result.batches[0].inset, inset, 1e-3);
  EXPECT_LT(largest_error(synthetic, result), 1e-5);
}

TEST(TagBlock, BlundersAreNamedAndLeftOut) {
  auto synthetic = test::make_block({.floors = 1});
  auto options = test::bound_options();
  options.loss = block::RobustLoss::huber;
  const auto clean = block::adjust_tag_block(synthetic.block, options);
  EXPECT_TRUE(clean.rejected.empty());
  synthetic.block.observations[7].corners[2] += Eigen::Vector2d(15, -10);
  std::swap(synthetic.block.observations[40].corners[0], synthetic.block.observations[40].corners[1]);
  for (auto loss : {block::RobustLoss::huber, block::RobustLoss::cauchy, block::RobustLoss::tukey}) {
    options.loss = loss;
    const auto result = block::adjust_tag_block(synthetic.block, options);
    EXPECT_EQ(result.rejected, (std::vector<int>{7, 40}));
    EXPECT_LT((result.anchors - clean.anchors).cwiseAbs().maxCoeff(), 2e-4);
  }
}

/// Tags are judged by the median tag, not by what the detector says of itself: claims ten times too small or too large
/// reject the same tags.
TEST(TagBlock, RejectionIsInUnitsOfTheMedianTag) {
  auto synthetic = test::make_block({.floors = 1, .stations = 3, .seed = 5});
  auto options = test::bound_options();
  options.loss = block::RobustLoss::huber;
  const Eigen::Vector2d off(0.2 / std::sqrt(2.0), -0.2 / std::sqrt(2.0));  // at each corner: no motion of the plate
  const auto disturb = [&](size_t observation, double sigmas) {
    for (size_t k = 0; k < 4; ++k)
      synthetic.block.observations[observation].corners[k] += (k % 2 == 0 ? sigmas : -sigmas) * off;
  };
  disturb(7, 14);  // root mean square of its eight residuals: ten sigmas
  disturb(40, 4);  // and 2.8
  for (const double claim : {0.1, 1.0}) {
    auto block = synthetic.block;
    for (auto& seen : block.observations)
      for (auto& covariance : seen.covariances) covariance *= claim * claim;
    EXPECT_EQ(block::adjust_tag_block(block, options).rejected, std::vector<int>{7}) << claim;
  }
}

TEST(TagBlock, ImagesWithoutPoseAreOrientedFromTheirNeighbours) {
  auto synthetic = test::make_block({.floors = 2});
  const auto all = block::adjust_tag_block(synthetic.block, test::bound_options());
  for (size_t i = 0; i < synthetic.block.images.size(); ++i)
    if (i % 16 > 2) synthetic.block.images[i].cam_from_world.reset();
  for (size_t i = 16; i < 32; ++i) synthetic.block.images[i].cam_from_world.reset();  // the whole upper floor
  const auto some = block::adjust_tag_block(synthetic.block, test::bound_options());
  EXPECT_LT((all.anchors - some.anchors).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(TagBlock, FreeNetworkHasTheFigureOfTheImagesAndNoDatum) {
  auto synthetic = test::make_block({.floors = 1});
  auto options = test::bound_options();
  options.free_network = true;
  for (double sigma : {1e-3, std::numeric_limits<double>::infinity()}) {
    options.tag_scale_sigma = sigma;
    const auto result = block::adjust_tag_block(synthetic.block, options);
    const int defect = std::isinf(sigma) ? 7 : 6;
    EXPECT_EQ(result.datum_defect, defect);
    double redundancy = 0;
    for (const auto& group : result.groups) redundancy += group.redundancy;
    EXPECT_NEAR(redundancy, result.degrees_of_freedom, 1e-6);
    // Inner constraints: the anchors' common translation has no variance.
    Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(result.anchors.size(), 3);
    for (Eigen::Index i = 0; i < mean.rows(); ++i) mean(i, i % 3) = 1.0 / static_cast<double>(result.plates.size());
    EXPECT_LT((mean.transpose() * result.anchor_covariance * mean).norm(), 1e-6 * result.anchor_covariance.trace());
    // Distances within the figure are right to a few tenths of a millimetre (and the prior of the scale).
    const Eigen::Vector3d a = result.anchors.head<3>(), b = result.anchors.segment<3>(18);
    const double truth = (synthetic.anchors[0] - synthetic.anchors[6]).norm();
    EXPECT_NEAR((a - b).norm() / truth, 1, std::isinf(sigma) ? 0.01 : 0.003);
  }
}

TEST(TagBlock, SameInputGivesTheSameBits) {
  const auto synthetic = test::make_block({.floors = 1});
  const auto first = block::adjust_tag_block(synthetic.block, {});
  std::vector<std::vector<char>> litter;  // moves the heap, so that nothing may hang on addresses
  for (size_t i = 1; i < 6; ++i) {
    for (size_t k = 0; k < 200; ++k) litter.emplace_back((i * 7919 + k * 104729) % 3000);
    for (size_t k = 0; k < litter.size(); k += 3) litter[k] = {};
    const auto copy = std::make_unique<block::TagBlock>(synthetic.block);
    const auto again = block::adjust_tag_block(*copy, {});
    EXPECT_TRUE((first.anchors.array() == again.anchors.array()).all());
    EXPECT_TRUE((first.anchor_covariance.array() == again.anchor_covariance.array()).all());
  }
}

}  // namespace test_tag_block
