// Covariance of the differences, the vacuous drift on control anchors, and input that is incomplete or wrong.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "building/judgement/check_anchors.hpp"
#include "building/judgement/difference.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_difference {

using test::mm;

Eigen::MatrixXd random_covariance(test::Normal& normal, Eigen::Index n) {
  Eigen::MatrixXd a(n, n + 4);
  for (Eigen::Index i = 0; i < a.size(); ++i) a.data()[i] = normal();
  return a * a.transpose() / static_cast<double>(n);
}

std::vector<Match> identity_matches(std::size_t n) {
  std::vector<Match> matches;
  for (std::size_t i = 0; i < n; ++i) matches.push_back({i, i, i});
  return matches;
}

// A linear model M of 4 points from images y = A x + n and the survey of points 0 and 1 with its covariance; M - S by
// propagation of both noises, against the formula that knows only the two covariances.
TEST(DifferenceCovariance, EqualsPropagationThroughAnAdjustment) {
  test::Normal normal(3);
  const Eigen::Index n = 12, control = 6;
  Eigen::MatrixXd design(20, n);
  for (Eigen::Index i = 0; i < design.size(); ++i) design.data()[i] = normal();
  const Eigen::MatrixXd survey = random_covariance(normal, n);
  const Eigen::MatrixXd weight = survey.topLeftCorner(control, control).inverse();
  Eigen::MatrixXd normal_matrix = design.transpose() * design;
  normal_matrix.topLeftCorner(control, control) += weight;
  const Eigen::MatrixXd model = normal_matrix.inverse();
  Eigen::MatrixXd by_survey = Eigen::MatrixXd::Zero(n, n);  // d(M - S)/dS
  by_survey.leftCols(control) = model.leftCols(control) * weight;
  by_survey -= Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd by_images = model * design.transpose();
  const Eigen::MatrixXd expected = by_images * by_images.transpose() + by_survey * survey * by_survey.transpose();

  PointSet m, s;
  m.covariance = model, s.covariance = survey;
  const auto matches = identity_matches(4);
  const auto result = difference_covariance(m, s, matches, {matches[0], matches[1]});
  EXPECT_TRUE(result.consistent);
  EXPECT_LT((result.matrix.dense() - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((result.matrix.dense().topLeftCorner(control, control) - (survey - model).topLeftCorner(control, control))
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

// The same with control all over the building and a survey of three days that know nothing of one another: as many
// points as go through more than one piece of the sum.
TEST(DifferenceCovariance, EqualsPropagationWithSurveysApartAndControlInBetween) {
  test::Normal normal(8);
  const Eigen::Index points = 72, n = 3 * points;
  Eigen::MatrixXd survey = random_covariance(normal, n);
  const auto day = [](Eigen::Index row) { return row / 3 == 7 ? 2 : row / 3 % 20 == 3 ? 1 : 0; };
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      if (day(i) != day(j)) survey(i, j) = 0;
  const auto matches = identity_matches(points);
  std::vector<Match> control;
  std::vector<Eigen::Index> rows;
  for (const Match& match : matches) {
    if (match.anchor % 3 == 2) continue;
    control.push_back(match);
    for (Eigen::Index k = 0; k < 3; ++k) rows.push_back(3 * static_cast<Eigen::Index>(match.anchor) + k);
  }
  const Eigen::MatrixXd weight = survey(rows, rows).inverse(), images = random_covariance(normal, n);
  Eigen::MatrixXd normal_matrix = images;
  normal_matrix(rows, rows) += weight;
  const Eigen::MatrixXd model = normal_matrix.inverse();
  Eigen::MatrixXd by_survey = -Eigen::MatrixXd::Identity(n, n);
  by_survey(Eigen::all, rows) += model(Eigen::all, rows) * weight;
  const Eigen::MatrixXd expected = model * images * model + by_survey * survey * by_survey.transpose();
  PointSet m, s;
  m.covariance = model, s.covariance = survey;
  ASSERT_EQ(s.covariance.clusters().size(), 3u);
  const auto result = difference_covariance(m, s, matches, control);
  EXPECT_TRUE(result.consistent);
  const Eigen::MatrixXd found = result.matrix.dense();
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
  EXPECT_EQ(found, found.transpose());
}

// A survey of points that know nothing of one another: images correlate all points of the model, but what is left
// between control and the others is nothing. Each keeps a matrix of its own.
TEST(DifferenceCovariance, TakesControlAndOthersApartWhereTheSurveyDoes) {
  test::Normal normal(4);
  const Eigen::Index points = 9, n = 3 * points;
  const Eigen::MatrixXd images = random_covariance(normal, n);
  Eigen::MatrixXd survey = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < points; ++i) survey.block<3, 3>(3 * i, 3 * i) = random_covariance(normal, 3);
  const auto matches = identity_matches(points);
  const std::vector<Match> control = {matches[1], matches[4], matches[8]};
  const std::vector<Eigen::Index> rows = {3, 4, 5, 12, 13, 14, 24, 25, 26};
  Eigen::MatrixXd normal_matrix = images;
  normal_matrix(rows, rows) += survey(rows, rows).inverse();
  const Eigen::MatrixXd model = normal_matrix.inverse();
  Eigen::MatrixXd by_survey = -Eigen::MatrixXd::Identity(n, n);
  by_survey(Eigen::all, rows) += model(Eigen::all, rows) * survey(rows, rows).inverse();
  const Eigen::MatrixXd expected = model * images * model + by_survey * survey * by_survey.transpose();
  PointSet m, s;
  m.covariance = model, s.covariance = survey;
  const auto result = difference_covariance(m, s, matches, control);
  EXPECT_TRUE(result.consistent);
  EXPECT_EQ(result.matrix.clusters().size(), 2u);
  EXPECT_LT((result.matrix.dense() - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
}

TEST(DifferenceCovariance, ForgivesTheSmallVarianceThatAnAdjustmentAdds) {
  PointSet model, survey;
  survey.covariance = test::isotropic(2, 0.3 * mm);
  model.covariance =
      survey.covariance.dense() + test::isotropic(2, 0.008 * mm);  // a block that adds nothing to its control
  const auto matches = identity_matches(2);
  const auto result = difference_covariance(model, survey, matches, matches);
  EXPECT_TRUE(result.consistent);
  EXPECT_NEAR(result.matrix.squaredNorm(), 0, 1e-30);
}

TEST(DifferenceCovariance, FallsBackWhenModelAndSurveyDoNotBelongTogether) {
  PointSet model, survey;
  model.covariance = test::isotropic(2, 3 * mm), survey.covariance = test::isotropic(2, 1 * mm);
  const auto matches = identity_matches(2);
  const auto result = difference_covariance(model, survey, matches, matches);
  EXPECT_FALSE(result.consistent);
  EXPECT_NEAR(result.matrix(0, 0), 10e-6, 1e-15);
}

TEST(DifferenceCovariance, SurvivesASingularSurvey) {
  PointSet model, survey;
  model.covariance = Eigen::MatrixXd::Zero(6, 6);
  Eigen::MatrixXd singular = test::isotropic(2, 1 * mm);
  singular(0, 0) = 0;
  survey.covariance = singular;
  const auto matches = identity_matches(2);
  const auto result = difference_covariance(model, survey, matches, matches);
  EXPECT_TRUE(result.matrix.allFinite());
}

// Control heights sum to zero after any fit that may shift the model: with equal numbers a floor the last D(F) is zero.
TEST(Control, DriftVanishesByConstructionAndIsRefusedAsEvidence) {
  test::Normal normal(11);
  Inputs inputs;
  double mean = 0;
  std::vector<double> dz(12);
  for (double& v : dz) mean += (v = normal() * mm) / 12;
  for (std::size_t i = 0; i < 12; ++i)
    test::add_anchor(inputs, "c" + std::to_string(i), 1 + static_cast<int>(i) / 4, 1 + static_cast<int>(i) % 4,
                     AnchorUse::control, {0, 0, dz[i] - mean});
  test::set_sigmas(inputs, 0.3 * mm, 1 * mm);

  const AccuracyT silent = evaluate_accuracy(inputs, {});
  const auto* c = test::find(silent, AnchorUse::control, AccuracyReference::survey);
  EXPECT_FALSE(c->evidence);
  EXPECT_FALSE(c->drift_computed);
  EXPECT_TRUE(std::isnan(c->floors[2]->drift));
  EXPECT_TRUE(test::warns(silent, "No check anchor was evaluated"));

  Options options;
  options.drift_on_control = true;
  const AccuracyT asked = evaluate_accuracy(inputs, options);
  const auto* drift = test::find(asked, AnchorUse::control, AccuracyReference::survey);
  EXPECT_TRUE(drift->drift_computed);
  EXPECT_FALSE(drift->evidence);
  EXPECT_NEAR(drift->floors[2]->drift, 0, 1e-15);
  EXPECT_TRUE(test::warns(asked, "D(F) was asked for on control anchors"));
  EXPECT_NE(drift->evidence_note.find("vanishes by construction"), std::string::npos);
}

TEST(Control, IsKeptApartFromCheckAnchors) {
  Inputs inputs = test::small_building();
  test::add_anchor(inputs, "K", 1, 3, AnchorUse::control, {0, 0, 7 * mm});
  test::set_sigmas(inputs, 0.3 * mm, 0.4 * mm);
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  ASSERT_EQ(accuracy.comparisons.size(), 2u);
  EXPECT_NEAR(test::find(accuracy, AnchorUse::check, AccuracyReference::survey)->rmse_z, std::sqrt(34.0 / 6) * mm,
              1e-12);
  EXPECT_NEAR(test::find(accuracy, AnchorUse::control, AccuracyReference::survey)->rmse_z, 7 * mm, 1e-12);
}

TEST(Control, UncertaintyOfAControlAnchorIsThatOfAnAdjustedResidual) {
  Inputs inputs;
  test::add_anchor(inputs, "K", 1, 1, AnchorUse::control, {0, 0, 0.5 * mm});
  test::add_anchor(inputs, "P", 1, 2, AnchorUse::check, {0, 0, 0.5 * mm});
  test::set_sigmas(inputs, 0.6 * mm, 1.0 * mm);
  const AccuracyT related = evaluate_accuracy(inputs, {});
  EXPECT_NEAR(related.anchors[0]->survey->u_dz, 0.8 * mm, 1e-12);
  EXPECT_NEAR(related.anchors[1]->survey->u_dz, std::sqrt(1.36) * mm, 1e-12);
  Options options;
  options.correlation = Correlation::independent;
  EXPECT_NEAR(evaluate_accuracy(inputs, options).anchors[0]->survey->u_dz, std::sqrt(1.36) * mm, 1e-12);
}

// A correlated survey compared with itself: the covariance of the differences is zero but for rounding.
TEST(Control, SurveyAgainstItselfIsExact) {
  test::Normal normal(5);
  Inputs inputs = test::small_building(AnchorUse::control);
  inputs.survey.covariance = 1e-6 * random_covariance(normal, 18);
  inputs.model = inputs.survey;
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  EXPECT_EQ(accuracy.comparisons[0]->passed, 6);
  EXPECT_EQ(accuracy.comparisons[0]->rmse_z, 0);
  EXPECT_NEAR(accuracy.comparisons[0]->predicted_rmse_z, 0, 1e-9);
}

TEST(Truth, HasNoUncertaintyOfItsOwn) {
  Inputs inputs = test::small_building();
  inputs.truth = inputs.survey;
  for (auto& p : inputs.truth->positions) p.z() += 1 * mm;
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const auto* c = test::find(accuracy, AnchorUse::check, AccuracyReference::truth);
  ASSERT_NE(c, nullptr);
  EXPECT_NEAR(c->mean_dz, (8.0 / 6 - 1) * mm, 1e-12);
  EXPECT_NEAR(c->predicted_rmse_z, 0.3 * mm, 1e-12);
  EXPECT_NEAR(accuracy.anchors[0]->truth->u_dz, 0.3 * mm, 1e-12);
}

/// 50 mm off, 90 standard deviations: "the stated uncertainties are too small" was said, which were right, and no name.
TEST(CheckAnchors, OneThatWasSurveyedWronglyIsNamedAndTheUncertaintiesAreNotBlamed) {
  test::Normal normal(4);
  Inputs inputs;
  Options options;
  options.name_contradicting_checks = true;
  for (int k = 1; k <= 6; ++k)
    test::add_anchor(inputs, "A" + std::to_string(k), 1, k, AnchorUse::check,
                     0.5 * mm * Eigen::Vector3d(normal(), normal(), normal()));
  test::set_sigmas(inputs, 0.3 * mm, 0.4 * mm);
  AccuracyT accuracy = evaluate_accuracy(inputs, options);
  EXPECT_TRUE(check_anchors_hold(accuracy));
  EXPECT_FALSE(test::warns(accuracy, "contradicts the model"));
  inputs.model.positions[2].z() += 50 * mm;
  accuracy = evaluate_accuracy(inputs, options);
  EXPECT_FALSE(check_anchors_hold(accuracy));
  EXPECT_TRUE(test::warns(accuracy, "The check anchor A3 contradicts the model: it is off by "));
  EXPECT_FALSE(test::warns(accuracy, "larger than their covariance allows"));
  // Where all are off by more than is stated, it is no matter of single points.
  test::set_sigmas(inputs, 0.03 * mm, 0.04 * mm);
  accuracy = evaluate_accuracy(inputs, options);
  EXPECT_FALSE(check_anchors_hold(accuracy));
  EXPECT_FALSE(test::warns(accuracy, "contradicts the model"));
  EXPECT_TRUE(test::warns(accuracy, "larger than their covariance allows"));
}

TEST(Incomplete, MissingAnchorsAreListedAndInNoMean) {
  Inputs inputs = test::small_building();
  inputs.anchors.push_back({"gone", 2, 3, 1, AnchorUse::check});
  inputs.anchors.push_back({"unsurveyed", 2, 3, 2, AnchorUse::check});
  inputs.model.ids.push_back("unsurveyed");
  inputs.model.positions.push_back({0, 0, 1});
  inputs.model.ids.push_back("stranger");
  inputs.model.positions.push_back({0, 0, 1});
  inputs.model.covariance = test::isotropic(8, 0.3 * mm);
  inputs.model.positions[0].z() = std::numeric_limits<double>::quiet_NaN();
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const auto* c = test::find(accuracy, AnchorUse::check, AccuracyReference::survey);
  EXPECT_EQ(c->anchors, 5);
  EXPECT_EQ(c->anchors_listed, 8);
  EXPECT_NEAR(c->floors[0]->mean_dz, 3 * mm, 1e-12);
  EXPECT_EQ(accuracy.anchors[0]->note, "the model position is not finite");
  EXPECT_EQ(accuracy.anchors[6]->note, "no model point");
  EXPECT_EQ(accuracy.anchors[7]->note, "no survey point");
  EXPECT_EQ(accuracy.anchors[7]->survey, nullptr);
  EXPECT_TRUE(test::warns(accuracy, "3 of 8 anchors were not measured"));
  EXPECT_TRUE(test::warns(accuracy, "F1C1, gone, unsurveyed"));
  EXPECT_TRUE(test::warns(accuracy, "stranger"));
}

TEST(Incomplete, DriftEndsBelowAFloorWithoutAnchors) {
  Inputs inputs = test::small_building();
  for (AnchorEntry& anchor : inputs.anchors)
    if (anchor.floor == 2) anchor.use = AnchorUse::control;
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const auto* c = test::find(accuracy, AnchorUse::check, AccuracyReference::survey);
  EXPECT_NEAR(c->floors[0]->drift, 2 * mm, 1e-12);
  EXPECT_TRUE(std::isnan(c->floors[1]->mean_dz));
  EXPECT_TRUE(std::isnan(c->floors[2]->drift));
  EXPECT_NEAR(c->floors[2]->relative_drift, 1 * mm, 1e-12);
  EXPECT_NEAR(c->slope->per_floor, 0.5 * mm, 1e-12);
  EXPECT_TRUE(c->transfers.empty());
}

TEST(Incomplete, WithoutCovarianceEveryVerdictIsUndecided) {
  Inputs inputs = test::small_building();
  inputs.model.covariance = {};
  AccuracyT accuracy = evaluate_accuracy(inputs, {});
  EXPECT_EQ(accuracy.comparisons[0]->undecided, 6);
  EXPECT_TRUE(std::isnan(accuracy.comparisons[0]->u_mean_dz));
  EXPECT_NEAR(accuracy.comparisons[0]->rmse_z, std::sqrt(34.0 / 6) * mm, 1e-12);
  EXPECT_TRUE(test::warns(accuracy, "model comes without a covariance"));
  inputs = test::small_building();
  Eigen::MatrixXd holed = inputs.survey.covariance.dense();
  holed(4, 4) = std::numeric_limits<double>::quiet_NaN();
  inputs.survey.covariance = holed;
  accuracy = evaluate_accuracy(inputs, {});
  EXPECT_EQ(accuracy.comparisons[0]->undecided, 6);
  EXPECT_TRUE(test::warns(accuracy, "covariance of the survey holds values that are not finite"));
}

TEST(Incomplete, EmptyModelIsAnAnswerAndNotAnError) {
  Inputs inputs = test::small_building();
  inputs.model = {};
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  EXPECT_EQ(accuracy.comparisons[0]->anchors, 0);
  EXPECT_FALSE(accuracy.comparisons[0]->evidence);
  EXPECT_TRUE(std::isnan(accuracy.comparisons[0]->rmse_z));
}

TEST(Wrong, InputIsNamedInTheError) {
  const auto message_of = [](const Inputs& inputs, const Options& options) -> std::string {
    try {
      evaluate_accuracy(inputs, options);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  Inputs inputs = test::small_building();
  inputs.anchors[1].id = "F1C1";
  EXPECT_NE(message_of(inputs, {}).find("'F1C1' twice"), std::string::npos);
  inputs = test::small_building();
  inputs.model.ids[2] = "F1C1";
  EXPECT_NE(message_of(inputs, {}).find("model points: 'F1C1' occurs twice"), std::string::npos);
  inputs = test::small_building();
  inputs.survey.covariance = Eigen::MatrixXd(Eigen::Matrix3d::Zero());
  EXPECT_NE(message_of(inputs, {}).find("3 x 3, expected 18 x 18 for 6 points"), std::string::npos);
  inputs = test::small_building();
  inputs.anchors.clear();
  EXPECT_NE(message_of(inputs, {}).find("anchor table is empty"), std::string::npos);
  Options options;
  options.tau = -1;
  EXPECT_NE(message_of(test::small_building(), options).find("tau must be a positive length"), std::string::npos);
}

}  // namespace test_difference
}  // namespace plumbline::judgement
