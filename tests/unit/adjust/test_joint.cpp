// Total-station readings and photographs in one adjustment, held by the adjustment in two steps, by minima of the sum
// of squares and by repeated simulation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "photo/joint/joint_adjustment.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/simulate/simulate_survey.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace test_joint {

using namespace plumbline;
using namespace plumbline::joint;
using testing::HasSubstr;

/// A storey of plates with photographs; two stations and three marks on the ground, which are known beforehand.
struct Site {
  test::SyntheticBlock images;
  survey::SurveyLayout layout;
  survey::SurveyObservations readings;
  survey::ControlPoints known;
  std::vector<Mark> marks;
  FrameLink link{"block", "survey", "", {}};
  std::unique_ptr<survey::KeptNetwork> network;
  survey::NetworkResult alone;

  JointResult adjust(const JointOptions& options) {
    return adjust_jointly(images.block, marks, *network, link, options);
  }
  void adjust_survey() {
    survey::AdjustOptions options;
    options.datum = survey::DatumMode::weighted;
    alone = survey::adjust_network(readings, options, known, network);
  }
};

JointOptions known_weights() {
  JointOptions options;
  options.block.loss = block::RobustLoss::none;
  options.block.estimate_image_variance = false;
  return options;
}

/// `noise` and `corner_noise` are factors on the standard deviations stated.
Site make_site(uint64_t seed, double noise = 1, double corner_noise = 1) {
  Site site;
  site.images = test::make_block({.floors = 1, .stations = 3, .corner_sigma = 0.2 * corner_noise, .seed = seed});
  for (auto& seen : site.images.block.observations)
    for (auto& covariance : seen.covariances) covariance /= corner_noise * corner_noise;
  for (size_t j = 0; j < site.images.anchors.size(); ++j) {
    site.layout.points.push_back({site.images.block.plates[j].anchor, site.images.anchors[j]});
    site.marks.push_back({site.images.block.plates[j].anchor, static_cast<int>(j)});
  }
  test::Random random(seed + 77);
  site.known.ids = {"G1", "G2", "G3"};
  site.known.coordinates.resize(9);
  site.known.covariance = 1e-6 * Eigen::MatrixXd::Identity(9, 9);
  const std::vector<Eigen::Vector3d> ground = {{-3, -6, 0.1}, {9, -7, 0.2}, {3, -14, -0.1}};
  for (size_t k = 0; k < 3; ++k) {
    site.layout.points.push_back({site.known.ids[k], ground[k]});
    for (int c = 0; c < 3; ++c)
      site.known.coordinates(3 * static_cast<Eigen::Index>(k) + c) = ground[k](c) + 0.001 * noise * random.normal();
  }
  std::vector<std::string> seen;
  for (const auto& point : site.layout.points) seen.push_back(point.id);
  site.layout.points.push_back({"S1", {0.5, -10, 1.6}});
  site.layout.points.push_back({"S2", {6.5, -11, 1.7}});
  site.layout.set_ups = {{"1", "S1", 0, 0.3, seen}, {"2", "S2", 0, 2.1, seen}};
  survey::SimulationOptions how;
  std::string remark;
  how.profile = survey::choose_profile("automatic", "", "", remark);
  how.noise = noise;
  how.coordinates = true;
  site.readings = survey::simulate_survey(site.layout, how, seed);
  site.adjust_survey();
  return site;
}

/// To first order they are the same. What is left is what the network's equations bend between the two solutions,
/// which falls with the square of the noise.
class JointAndTwoSteps : public testing::TestWithParam<std::pair<double, double>> {};
INSTANTIATE_TEST_SUITE_P(NoiseAndLimit, JointAndTwoSteps,
                         testing::Values(std::pair(1.0, 4e-6), std::pair(0.5, 1e-6), std::pair(0.1, 1e-7)));

TEST_P(JointAndTwoSteps, AreEqualWithFullCovariance) {
  const auto [noise, limit] = GetParam();
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    Site site = make_site(seed, noise);
    // Two steps: coordinates of all marks with their covariance, then the block.
    block::TagBlock block = site.images.block;
    std::vector<int> rows;
    block.control = {};
    block.control.position.resize(3 * static_cast<Eigen::Index>(site.marks.size()));
    for (size_t k = 0; k < site.marks.size(); ++k) {
      const auto& point = site.alone.point(site.marks[k].id);
      block.control.plates.push_back(site.marks[k].plate);
      block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)) = point.position;
      rows.insert(rows.end(), point.unknowns.begin(), point.unknowns.end());
    }
    block.control.covariance = site.alone.cofactors.joint(rows);
    const auto two_steps = block::adjust_tag_block(block, known_weights().block);
    const JointResult joint = site.adjust(known_weights());
    ASSERT_EQ(joint.block.plates, two_steps.plates);
    EXPECT_LT((joint.block.anchors - two_steps.anchors).cwiseAbs().maxCoeff(), limit) << seed;
    EXPECT_LT((joint.block.anchor_covariance - two_steps.anchor_covariance).norm(),
              1e-3 * two_steps.anchor_covariance.norm());
    EXPECT_EQ(joint.block.degrees_of_freedom, two_steps.degrees_of_freedom + site.alone.degrees_of_freedom);
    EXPECT_NEAR(joint.block.weighted_sum_of_squares, two_steps.weighted_sum_of_squares + site.alone.sum_of_squares,
                1e-3 * joint.block.weighted_sum_of_squares);
    EXPECT_LE(joint.iterations, 4);
  }
}

/// Every other unknown of the network is where the readings have their smallest sum of squares, given the marks.
TEST(Joint, TheNetworkEndsAtItsMinimumGivenTheMarks) {
  Site site = make_site(3);
  site.adjust(known_weights());
  const double least = site.network->sum_of_squares();
  for (const char* station : {"S1", "S2"})
    for (const int unknown : site.network->unknowns(station)) {
      Eigen::VectorXd step = Eigen::VectorXd::Zero(site.network->unknown_count());
      step(unknown) = 1e-3;
      site.network->move(step);
      const double ahead = site.network->sum_of_squares() - least;
      site.network->move(-2 * step);
      const double behind = site.network->sum_of_squares() - least;
      site.network->move(step);
      EXPECT_GT(std::min(ahead, behind), 0) << station;
      EXPECT_NEAR(ahead / behind, 1, 0.01) << station;
    }
}

/// Stations, ground marks and anchors together, in normalised squared errors; 200 trials with PLUMBLINE_LONG.
TEST(Joint, ItsCovarianceOfTheSurveyCoversItsErrors) {
  const int trials = std::getenv("PLUMBLINE_LONG") ? 200 : 8;
  double sum = 0, expected = 0;
  for (int trial = 0; trial < trials; ++trial) {
    Site site = make_site(100 + static_cast<uint64_t>(trial));
    const JointResult joint = site.adjust(known_weights());
    Eigen::VectorXd error(joint.survey_positions.size());
    for (size_t k = 0; k < joint.survey_ids.size(); ++k)
      for (const auto& point : site.layout.points)
        if (point.id == joint.survey_ids[k])
          error.segment<3>(3 * static_cast<Eigen::Index>(k)) =
              joint.survey_positions.segment<3>(3 * static_cast<Eigen::Index>(k)) - point.position;
    sum += error.dot(joint.survey_covariance.ldlt().solve(error));
    expected += static_cast<double>(error.size());
  }
  EXPECT_NEAR(sum, expected, 4 * std::sqrt(2 * expected));
}

TEST(Joint, EstimatesVariancesOfReadingsAndOfImages) {
  JointOptions options = known_weights();
  options.estimate_survey_variance = options.block.estimate_image_variance = true;
  Site site = make_site(5, 2, 0.5);
  const JointResult joint = site.adjust(options);
  EXPECT_NEAR(std::sqrt(joint.survey_variance), 2, 0.5);
  EXPECT_NEAR(std::sqrt(joint.block.image_variance_factor), 0.5, 0.03);
  EXPECT_NEAR(joint.block.sigma0, 1, 0.02);
}

/// A reading that nothing in the survey controls: the mark is sighted once. The photographs tell.
TEST(Joint, PhotographsTellAWrongReadingThatTheSurveyCannot) {
  Site site = make_site(7);
  const std::string id = site.marks[2].id;
  std::erase_if(site.readings.observations,
                [&](const auto& reading) { return reading.to == id && reading.set_up == 1; });
  for (auto& reading : site.readings.observations)
    if (reading.to == id && reading.kind == survey::ObservationKind::slope_distance) reading.value += 0.02;
  site.adjust_survey();
  EXPECT_EQ(site.alone.validity, survey::Validity::sound);
  const JointResult joint = site.adjust(known_weights());
  ASSERT_FALSE(joint.conspicuous.empty());
  EXPECT_THAT(joint.conspicuous[0].what, HasSubstr(id));
  EXPECT_THAT(joint.conspicuous[0].what, HasSubstr("distance"));
}

/// A plate 30 mm beside its mark is left out, and the result is as if that mark had no plate; a wrong reading of a mark
/// that is sighted once is named all the same.
TEST(Joint, AMarkThatContradictsIsNotHeldAgainstThePhotographs) {
  JointOptions robust = known_weights();
  robust.block.robust_control = true;
  Site moved = make_site(7), without = make_site(7), sound = make_site(7);
  const Mark wrong = moved.marks[2];
  for (auto& seen : moved.images.block.observations)
    if (seen.plate == wrong.plate) {  // the plate, not its mark
      const auto corners = tag_corners_in_plate(moved.images.block.plates[wrong.plate].plate);
      const RigidTransform& pose = moved.images.cam_from_world[seen.image];
      for (size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3d place =
            moved.images.anchors[wrong.plate] + moved.images.world_from_plate[wrong.plate] * corners[k];
        seen.corners[k] += *project(moved.images.camera, pose * (place + Eigen::Vector3d(0, 0, 0.03))) -
                           *project(moved.images.camera, pose * place);
      }
    }
  without.images.block.observations = moved.images.block.observations;
  std::erase_if(without.marks, [&](const Mark& mark) { return mark.plate == wrong.plate; });
  const JointResult found = moved.adjust(robust), expected = without.adjust(known_weights());
  ASSERT_EQ(found.block.rejected_control.size(), 1u);
  EXPECT_EQ(found.block.rejected_control[0].plate, wrong.plate);
  EXPECT_NEAR(found.block.rejected_control[0].off.z(), -0.03, 0.004);
  EXPECT_LT((found.block.anchors - expected.block.anchors).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT((found.survey_positions - expected.survey_positions).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_FALSE(found.conspicuous.empty()) << "with the mark its readings do not fit";
  EXPECT_TRUE(expected.conspicuous.empty());
  const JointResult plain = make_site(7).adjust(known_weights()), tested = sound.adjust(robust);
  EXPECT_EQ(tested.block.anchors, plain.block.anchors) << "sound control gives the same bits";
  EXPECT_TRUE(tested.block.rejected_control.empty());
}

/// Readings twice as uncertain, unknowns with them: every normalised residual is half of what it was.
TEST(Joint, NormalisedResidualsCountInTheScatterThatTheReadingsHave) {
  Site site = make_site(8);
  for (auto& reading : site.readings.observations)
    if (reading.kind == survey::ObservationKind::slope_distance && reading.to == site.marks[3].id)
      reading.value += 0.02;
  site.adjust_survey();
  const Eigen::MatrixXd cofactors = site.network->estimate().cofactors;
  const auto stated = site.network->conspicuous(cofactors, 1, 3);
  const auto doubled = site.network->conspicuous(4 * cofactors, 4, 1.5);
  ASSERT_FALSE(stated.empty());
  ASSERT_EQ(doubled.size(), stated.size());
  for (size_t i = 0; i < stated.size(); ++i) EXPECT_NEAR(doubled[i].w, stated[i].w / 2, 1e-9 * std::abs(stated[i].w));
}

TEST(Joint, IsTheSameInAnotherFrame) {
  Site plain = make_site(9), turned = make_site(9);
  const RigidTransform motion{quaternion_from_rotation_vector({0, 0, 0.6}), {40, -20, 3}};
  turned.link.to_from_from = motion;
  for (auto& image : turned.images.block.images) image.cam_from_world = *image.cam_from_world * motion.inverse();
  for (auto& plate : turned.images.block.plates) plate.nominal_rotation = motion.rotation * plate.nominal_rotation;
  const JointResult a = plain.adjust(known_weights()), b = turned.adjust(known_weights());
  for (size_t j = 0; j < a.block.plates.size(); ++j) {
    const auto at = 3 * static_cast<Eigen::Index>(j);
    EXPECT_LT((motion * Eigen::Vector3d(a.block.anchors.segment<3>(at)) - b.block.anchors.segment<3>(at)).norm(), 1e-7);
  }
  EXPECT_LT((a.survey_positions - b.survey_positions).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(Joint, RefusesWhatItCannotDo) {
  Site site = make_site(1);
  JointOptions lambda = known_weights();
  lambda.block.weighting = block::TagBlockOptions::Weighting::lambda;
  EXPECT_THAT(test::error_of([&] { site.adjust(lambda); }), HasSubstr("needs weights by covariance"));
  site.marks.resize(2);
  EXPECT_THAT(test::error_of([&] { site.adjust(known_weights()); }), HasSubstr("at least 3 marks"));
}

}  // namespace test_joint
