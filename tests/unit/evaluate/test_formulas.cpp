// Every formula of the evaluation against numbers worked by hand on the small building.
#include <gtest/gtest.h>

#include "building/judgement/comparison.hpp"
#include "building/judgement/drift.hpp"
#include "building/judgement/spectral_coordinates.hpp"
#include "building/judgement/tested_directions.hpp"
#include "building/judgement/tolerance.hpp"
#include "geometry/linear_algebra/lower_factor.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_formulas {

using test::mm;

AccuracyT evaluate_small(AnchorUse use = AnchorUse::check, Options options = {}) {
  return evaluate_accuracy(test::small_building(use), options);
}

TEST(Formulas, FloorMeansAndCumulativeDrift) {
  const AccuracyT accuracy = evaluate_small();
  const auto* c = test::find(accuracy, AnchorUse::check, AccuracyReference::survey);
  ASSERT_NE(c, nullptr);
  ASSERT_EQ(c->floors.size(), 3u);
  const double r[] = {2, -1, 3}, drift[] = {2, 1, 4}, relative[] = {0, -3, 1}, largest[] = {3, 2, 4};
  const double met[] = {2, 2, 4};
  for (std::size_t i = 0; i < 3; ++i) {
    const FloorAccuracyT& floor = *c->floors[i];
    EXPECT_EQ(floor.floor, static_cast<int>(i) + 1);
    EXPECT_EQ(floor.anchors, 2);
    EXPECT_NEAR(floor.mean_dz, r[i] * mm, 1e-15);
    EXPECT_NEAR(floor.drift, drift[i] * mm, 1e-15);
    EXPECT_NEAR(floor.relative_drift, relative[i] * mm, 1e-15);
    EXPECT_NEAR(floor.max_abs_dz, largest[i] * mm, 1e-15);
    EXPECT_NEAR(floor.smallest_tolerance_met, met[i] * mm, 1e-15);
    // u(dz) = 0.5 mm, independent: u(r_f) = 0.5/sqrt 2, u(D(F)) = sqrt F times that, u(r_F - r_1) = sqrt 2 times that.
    EXPECT_NEAR(floor.u_mean_dz, 0.5 * mm / std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(floor.u_drift, 0.5 * mm / std::sqrt(2.0) * std::sqrt(static_cast<double>(i + 1)), 1e-12);
    EXPECT_NEAR(floor.u_relative_drift, i == 0 ? 0 : 0.5 * mm, 1e-12);
  }
  // |D(3)| = 4 mm, u = 0.612 mm, k·u = 1.007 mm: 5 mm is not certain.
  EXPECT_EQ(c->floors[2]->drift_verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(c->floors[1]->drift_verdict, ToleranceVerdict::pass);
}

/// Measured by total station alone there is nothing to compare: no difference of zero is taken for evidence.
TEST(Formulas, AModelThatIsTheSurveyIsComparedWithNothing) {
  Inputs inputs = test::small_building(AnchorUse::check);
  inputs.survey = {}, inputs.model_is_survey = true;
  inputs.model.ids.push_back("mark 7"), inputs.model.positions.push_back({1, 2, 3}), inputs.model.covariance = {};
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  EXPECT_TRUE(accuracy.comparisons.empty());
  ASSERT_EQ(accuracy.anchors.size(), inputs.anchors.size());
  for (const auto& anchor : accuracy.anchors) {
    EXPECT_EQ(anchor->survey, nullptr);
    EXPECT_EQ(anchor->note, "");
  }
  std::string all;
  for (const std::string& warning : accuracy.warnings) all += warning + "\n";
  EXPECT_NE(all.find("measured by total station alone"), std::string::npos) << all;
  EXPECT_EQ(all.find("were not measured"), std::string::npos) << all;
  EXPECT_EQ(all.find("mark 7"), std::string::npos) << all;
  inputs.model.ids[0] = "another name";
  EXPECT_EQ(evaluate_accuracy(inputs, {}).anchors[0]->note, "not surveyed");
}

/// Control that the adjustment left out has no error in common with the model: once its difference was stated to less
/// than the survey itself.
TEST(Formulas, ControlThatWasLeftOutIsIndependentOfTheModel) {
  Inputs inputs = test::small_building(AnchorUse::control);
  inputs.not_adjusted_to = {inputs.anchors[2].id};
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  for (std::size_t i = 0; i < inputs.anchors.size(); ++i)
    EXPECT_NEAR(accuracy.anchors[i]->survey->u_dz, (i == 2 ? 0.5 : std::sqrt(0.16 - 0.09)) * mm, 1e-12) << i;
}

/// Once "pass 1.0000" beside 10 mm, because its height agreed, and one of "control 14, pass 14".
TEST(Formulas, ControlThatWasLeftOutHasNoVerdictAndIsNoneOfTheControl) {
  Inputs inputs = test::small_building(AnchorUse::control);
  const auto control = [](const AccuracyT& accuracy) {
    return test::find(accuracy, AnchorUse::control, AccuracyReference::survey)->anchors;
  };
  const int all = control(evaluate_accuracy(inputs, {}));
  inputs.not_adjusted_to = {inputs.anchors[2].id};
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  EXPECT_EQ(control(accuracy), all - 1);
  const AnchorAccuracyT& anchor = *accuracy.anchors[2];
  EXPECT_EQ(anchor.survey->verdict, ToleranceVerdict::undecided);
  EXPECT_TRUE(std::isnan(anchor.survey->conformance_probability));
  EXPECT_EQ(anchor.note, "left out of the adjustment as control: the photographs contradict its survey");
  EXPECT_NE(accuracy.anchors[1]->survey->verdict, ToleranceVerdict::undecided);
}

TEST(Formulas, SlopeOfFloorMeans) {
  const AccuracyT accuracy = evaluate_small();
  const DriftSlopeT& slope = *test::find(accuracy, AnchorUse::check, AccuracyReference::survey)->slope;
  // (r_3 - r_1)/2 for floors 1, 2, 3; its weights are ±1/4 on four anchors of u = 0.5 mm.
  EXPECT_NEAR(slope.per_floor, 0.5 * mm, 1e-15);
  EXPECT_NEAR(slope.u_per_floor, 0.25 * mm, 1e-12);
  EXPECT_NEAR(slope.lower, 0.5 * mm - 1.959964 * 0.25 * mm, 1e-9);
  EXPECT_NEAR(slope.upper, 0.5 * mm + 1.959964 * 0.25 * mm, 1e-9);
  EXPECT_NEAR(slope.p_value, 0.0455003, 1e-6);  // two standard uncertainties
  // The line is 4/3 + (f - 2)/2, its residuals 7/6, -7/3, 7/6: s² = 49/6, over Σ(f - 2)² = 2.
  EXPECT_NEAR(slope.scatter_per_floor, std::sqrt(49.0 / 6.0 / 2.0) * mm, 1e-12);
}

TEST(Formulas, ScatterOfTheSlopeIsThatOfAStraightLine) {
  Inputs inputs;
  const double r[] = {1, -2, 4, 3, -1, 6};
  for (int floor = 1; floor <= 6; ++floor)
    test::add_anchor(inputs, "F" + std::to_string(floor), floor, 1, AnchorUse::check, {0, 0, r[floor - 1] * mm});
  test::set_sigmas(inputs, 0.3 * mm, 0.4 * mm);
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const DriftSlopeT& slope = *test::find(accuracy, AnchorUse::check, AccuracyReference::survey)->slope;
  // By hand: mean 11/6, Sxx 17.5, Sxy 13.5, Syy 67 - 121/6; s² = (Syy - Sxy²/Sxx)/4.
  EXPECT_NEAR(slope.per_floor, 13.5 / 17.5 * mm, 1e-12);
  EXPECT_NEAR(slope.scatter_per_floor, std::sqrt((67 - 121.0 / 6 - 13.5 * 13.5 / 17.5) / 4 / 17.5) * mm, 1e-12);
}

TEST(Formulas, OneFloorHasNoSlope) {
  Inputs inputs;
  for (int column = 1; column <= 3; ++column)
    test::add_anchor(inputs, "C" + std::to_string(column), 1, column, AnchorUse::check, {0, 0, column * mm});
  test::set_sigmas(inputs, 0.3 * mm, 0.4 * mm);
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const auto* c = test::find(accuracy, AnchorUse::check, AccuracyReference::survey);
  ASSERT_NE(c, nullptr);
  EXPECT_EQ(c->slope, nullptr);
}

TEST(Formulas, StatisticsOfVerticalResiduals) {
  const AccuracyT accuracy = evaluate_small();
  const auto* c = test::find(accuracy, AnchorUse::check, AccuracyReference::survey);
  EXPECT_EQ(c->anchors, 6);
  EXPECT_NEAR(c->mean_dz, 8.0 / 6.0 * mm, 1e-15);
  EXPECT_NEAR(c->rmse_z, std::sqrt(34.0 / 6.0) * mm, 1e-15);
  EXPECT_NEAR(c->deviation_dz, std::sqrt((34.0 - 64.0 / 6.0) / 5.0) * mm, 1e-15);
  EXPECT_NEAR(c->max_abs_dz, 4 * mm, 1e-15);
  EXPECT_EQ(c->worst_anchor, "F3C1");
  EXPECT_NEAR(c->u_mean_dz, 0.5 * mm / std::sqrt(6.0), 1e-12);
  EXPECT_NEAR(c->predicted_rmse_z, 0.5 * mm, 1e-12);
  EXPECT_NEAR(c->predicted_rmse_3d, std::sqrt(3.0) * 0.5 * mm, 1e-12);
}

TEST(Formulas, DistanceIsThreeDimensional) {
  Inputs inputs;
  test::add_anchor(inputs, "a", 1, 1, AnchorUse::check, {1 * mm, 2 * mm, 2 * mm});
  test::set_sigmas(inputs, 0.3 * mm, 0.4 * mm);
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const AnchorDifferenceT& d = *accuracy.anchors[0]->survey;
  EXPECT_NEAR(d.distance, 3 * mm, 1e-15);
  EXPECT_NEAR(d.dz, 2 * mm, 1e-15);
  EXPECT_NEAR(d.u_dz, 0.5 * mm, 1e-12);
  EXPECT_NEAR(d.u_distance, 0.5 * mm, 1e-12);
  EXPECT_NEAR(accuracy.comparisons[0]->rmse_3d, 3 * mm, 1e-15);
}

std::vector<std::string> warnings_about(const Inputs& inputs, const std::string& word) {
  std::vector<std::string> found;
  for (const std::string& warning : evaluate_accuracy(inputs, {}).warnings)
    if (warning.find(word) != std::string::npos) found.push_back(warning);
  return found;
}

/// (9) to (11) look at heights; a plate that hangs beside its anchor must be told all the same.
TEST(Doubts, ACheckAnchorThatIsOffInPlanIsNamed) {
  Inputs inputs = test::small_building();
  EXPECT_TRUE(warnings_about(inputs, "not in place").empty());
  inputs.model.positions[3].x() += 0.04;
  const auto told = warnings_about(inputs, "not in place");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("F2C2 (40.0 mm in space, 0.0 mm in height)"), std::string::npos) << told[0];
}

TEST(Doubts, FloorsThatDoNotLieAboveOneAnother) {
  Inputs inputs = test::small_building();
  for (std::size_t i = 0; i < inputs.anchors.size(); ++i) {
    inputs.survey.positions[i].z() += 3.0 * inputs.anchors[i].floor;
    inputs.model.positions[i].z() += 3.0 * inputs.anchors[i].floor;
  }
  EXPECT_TRUE(warnings_about(inputs, "exchanged?").empty());
  for (auto& anchor : inputs.anchors) anchor.floor = anchor.floor == 3 ? 3 : 3 - anchor.floor;
  const auto told = warnings_about(inputs, "exchanged?");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].substr(0, 30), "Floor 2 lies below floor 1 (me");
  for (auto& anchor : inputs.anchors) --anchor.floor;
  EXPECT_EQ(warnings_about(inputs, "2 anchors have a floor below 1").size(), 1u);
}

TEST(Formulas, HeightTransferByFloorAndByColumn) {
  const AccuracyT accuracy = evaluate_small();
  const auto& transfers = test::find(accuracy, AnchorUse::check, AccuracyReference::survey)->transfers;
  ASSERT_EQ(transfers.size(), 6u);
  const int column[] = {0, 0, 1, 1, 2, 2};
  const double difference[] = {-3, 4, -3, 6, -3, 2};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(transfers[i]->column, column[i]);
    EXPECT_EQ(transfers[i]->lower_floor, i % 2 == 0 ? 1 : 2);
    EXPECT_EQ(transfers[i]->upper_floor, transfers[i]->lower_floor + 1);
    EXPECT_NEAR(transfers[i]->difference, difference[i] * mm, 1e-15);
    EXPECT_NEAR(transfers[i]->error, std::abs(difference[i]) * mm, 1e-15);
    EXPECT_NEAR(transfers[i]->u, column[i] == 0 ? 0.5 * mm : 0.5 * mm * std::sqrt(2.0), 1e-12);
  }
  EXPECT_EQ(transfers[0]->verdict, ToleranceVerdict::pass);
  EXPECT_EQ(transfers[3]->verdict, ToleranceVerdict::undecided);  // 6 mm with u 0.71 mm against 5 mm
}

TEST(Formulas, DriftAlongEveryColumn) {
  const AccuracyT accuracy = evaluate_small();
  const auto& columns = test::find(accuracy, AnchorUse::check, AccuracyReference::survey)->columns;
  ASSERT_EQ(columns.size(), 2u);  // dz of 1, -2, 4 and of 3, 0, 2 mm
  const double sum[] = {3, 5}, top[] = {3, -1};
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(columns[i]->column, static_cast<int>(i) + 1);
    EXPECT_EQ(columns[i]->lowest_floor, 1);
    EXPECT_EQ(columns[i]->highest_floor, 3);
    EXPECT_EQ(columns[i]->anchors, 3);
    EXPECT_NEAR(columns[i]->drift, sum[i] * mm, 1e-15);
    EXPECT_NEAR(columns[i]->u_drift, 0.5 * mm * std::sqrt(3.0), 1e-12);
    EXPECT_NEAR(columns[i]->relative_drift, top[i] * mm, 1e-15);
    EXPECT_NEAR(columns[i]->u_relative_drift, 0.5 * mm * std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(columns[i]->slope->per_floor, 0.5 * top[i] * mm, 1e-15);
    EXPECT_EQ(columns[i]->relative_verdict, ToleranceVerdict::pass);
  }
}

TEST(Formulas, AColumnWithAGapHasNoSumAndControlNeverHasOne) {
  Inputs inputs = test::small_building();
  inputs.model.positions[2].setConstant(std::nan(""));  // column 1 on floor 2
  AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const auto& columns = test::find(accuracy, AnchorUse::check, AccuracyReference::survey)->columns;
  ASSERT_EQ(columns.size(), 2u);
  EXPECT_EQ(columns[0]->anchors, 2);
  EXPECT_TRUE(std::isnan(columns[0]->drift));
  EXPECT_TRUE(std::isfinite(columns[0]->relative_drift));
  EXPECT_TRUE(std::isfinite(columns[1]->drift));
  accuracy = evaluate_small(AnchorUse::control);
  EXPECT_TRUE(std::isnan(accuracy.comparisons[0]->columns[0]->drift));
}

TEST(Formulas, PassRateOverTheSweep) {
  const AccuracyT accuracy = evaluate_small();
  const auto& rates = test::find(accuracy, AnchorUse::check, AccuracyReference::survey)->pass_rates;
  ASSERT_EQ(rates.size(), 13u);
  EXPECT_EQ(rates.front()->tolerance, 2 * mm);
  EXPECT_EQ(rates.back()->tolerance, 8 * mm);
  EXPECT_EQ(rates[0]->passed, 4);  // |dz| = tau passes
  EXPECT_EQ(rates[1]->passed, 4);
  EXPECT_EQ(rates[2]->passed, 5);  // 3 mm
  EXPECT_EQ(rates[4]->passed, 6);  // 4 mm
  // Wilson (1927) for 4 of 6: (p + z²/2n ± z·sqrt(p(1-p)/n + z²/4n²)) / (1 + z²/n), z = 1.959964.
  EXPECT_NEAR(rates[0]->rate, 2.0 / 3.0, 1e-15);
  EXPECT_NEAR(rates[0]->lower, 0.29999, 1e-4);
  EXPECT_NEAR(rates[0]->upper, 0.90323, 1e-4);
}

TEST(Formulas, PassRateNeedsItsBound) {
  EXPECT_EQ(anchors_needed(0.95, 0.95), 59);
  const auto all_pass = [](Eigen::Index n) {
    return pass_rates(Eigen::VectorXd::Zero(n), {0.002}, 0.95)[0]->exact_lower;
  };
  EXPECT_NEAR(all_pass(6), std::pow(0.05, 1.0 / 6), 1e-12);  // 0.61, 0.69, 0.83, 0.93 in the literature
  EXPECT_NEAR(all_pass(8), 0.6877, 1e-4);
  EXPECT_NEAR(all_pass(16), 0.8292, 1e-4);
  EXPECT_NEAR(all_pass(40), 0.9278, 1e-4);
  EXPECT_LT(all_pass(58), 0.95);
  EXPECT_GT(all_pass(59), 0.95);
}

TEST(Formulas, VerdictHasAGuardBand) {
  const double k = 1.645;
  EXPECT_EQ(verdict_of(0.003, 0.0012, 0.005, k), ToleranceVerdict::pass);        // 3 + 1.974
  EXPECT_EQ(verdict_of(-0.003, 0.0013, 0.005, k), ToleranceVerdict::undecided);  // 3 + 2.139
  EXPECT_EQ(verdict_of(0.0065, 0.001, 0.005, k), ToleranceVerdict::undecided);   // 6.5 - 1.645
  EXPECT_EQ(verdict_of(-0.0067, 0.001, 0.005, k), ToleranceVerdict::fail);       // 6.7 - 1.645
  EXPECT_EQ(verdict_of(0.005, 0, 0.005, k), ToleranceVerdict::pass);
  EXPECT_EQ(verdict_of(0.001, std::nan(""), 0.005, k), ToleranceVerdict::undecided);
  EXPECT_EQ(verdict_of(std::nan(""), 0.001, 0.005, k), ToleranceVerdict::not_measured);
}

TEST(Formulas, ConformanceProbability) {
  EXPECT_NEAR(conformance_probability(0, 1, 1.959964), 0.95, 1e-6);
  EXPECT_NEAR(conformance_probability(0.005, 0.0001, 0.005), 0.5, 1e-9);
  EXPECT_EQ(conformance_probability(0.004, 0, 0.005), 1);
  EXPECT_TRUE(std::isnan(conformance_probability(0.004, std::nan(""), 0.005)));
}

TEST(Formulas, CommonSetUpHeightErrorStaysInTheDriftAndLeavesTheRelativeDrift) {
  Inputs inputs = test::small_building();
  Eigen::MatrixXd common = inputs.survey.covariance.dense();
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j < 6; ++j) common(3 * i + 2, 3 * j + 2) += 1 * mm * mm;
  inputs.survey.covariance = common;
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const auto& top = *test::find(accuracy, AnchorUse::check, AccuracyReference::survey)->floors[2];
  EXPECT_NEAR(top.u_mean_dz, std::sqrt(0.125 + 1) * mm, 1e-12);
  EXPECT_NEAR(top.u_drift, std::sqrt(3 * 0.125 + 9) * mm, 1e-12);
  EXPECT_NEAR(top.u_relative_drift, 0.5 * mm, 1e-12);
}

TEST(Formulas, ChiSquareOfCorrelatedErrors) {
  Eigen::Matrix2d s;
  s << 2, 1, 1, 2;  // inverse (2, -1; -1, 2)/3
  const auto test = consistency(Eigen::Vector2d(1, -1), {s, 1}, 0.95);
  EXPECT_NEAR(test->statistic, 2.0, 1e-12);
  EXPECT_EQ(test->degrees_of_freedom, 2);
  EXPECT_NEAR(test->lower, 0.050636, 1e-6);
  EXPECT_NEAR(test->upper, 7.377759, 1e-6);
  EXPECT_NEAR(test->probability, 1 - std::exp(-1.0), 1e-12);
  const auto singular = consistency(Eigen::Vector2d(3, 3), {Eigen::Matrix2d::Ones(), 1}, 0.95);
  EXPECT_EQ(singular->degrees_of_freedom, 1);
  EXPECT_NEAR(singular->statistic, 9, 1e-9);
  EXPECT_EQ(consistency(Eigen::Vector2d(3, 3), {Eigen::Matrix2d::Zero(), 1}, 0.95), nullptr);
}

/// Against eigenvectors by another algorithm; two directions of 40 are known exactly.
TEST(SpectralCoordinates, AreThoseAlongEigenvectors) {
  test::Normal normal(11);
  Eigen::MatrixXd a(40, 38);
  for (Eigen::Index i = 0; i < a.size(); ++i) a.data()[i] = normal();
  const Eigen::MatrixXd s = 1e-6 * a * a.transpose();
  Eigen::VectorXd d(40);
  for (Eigen::Index i = 0; i < d.size(); ++i) d[i] = 1e-3 * normal();
  const SpectralCoordinates found = spectral_coordinates(s, d);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(s, Eigen::ComputeFullU);
  std::vector<std::pair<double, double>> pairs;
  for (Eigen::Index i = 0; i < 40; ++i) pairs.emplace_back(-found.eigenvalues[i], std::abs(found.along[i]));
  std::sort(pairs.begin(), pairs.end());
  double statistic = 0;
  for (Eigen::Index i = 0; i < 40; ++i) {
    EXPECT_NEAR(-pairs[i].first, svd.singularValues()[i], 1e-15);
    if (i < 38) {
      const double along = svd.matrixU().col(i).dot(d);
      EXPECT_NEAR(pairs[i].second, std::abs(along), 1e-9) << i;
      statistic += along * along / svd.singularValues()[i];
    }
  }
  const auto chi = consistency(d, {s, 1}, 0.95);
  EXPECT_NEAR(chi->statistic, statistic, 1e-6 * statistic);
  EXPECT_EQ(chi->degrees_of_freedom, 38);
}

/// Many points are tested by conjugate gradients on one factor: as a solution by LU, also where one direction is known
/// hardly worse than what is not tested.
TEST(Formulas, TheTestOfManyPointsIsThatOfASolution) {
  test::Normal normal(12);
  const Eigen::Index n = 303;
  Eigen::MatrixXd a(n, 6);
  Eigen::VectorXd d(n);
  for (double& v : d) v = normal() * mm;
  for (Eigen::Index i = 0; i < a.size(); ++i) a.data()[i] = normal() * mm;
  Eigen::MatrixXd s = a * a.transpose() + 0.04 * mm * mm * Eigen::MatrixXd::Identity(n, n);
  for (const double least : {0.04 * mm * mm, 1.001 * 4e-10}) {
    s(0, 0) = least, s.row(0).tail(n - 1).setZero(), s.col(0).tail(n - 1).setZero();
    const double expected = d.dot(s.partialPivLu().solve(d));
    const auto chi = consistency(d, {s, 1}, 0.95);
    EXPECT_EQ(chi->degrees_of_freedom, n);
    EXPECT_NEAR(chi->statistic, expected, 1e-9 * expected);
  }
}

/// Of control that the model follows in a few directions these are left out without eigenvalues of the whole: as by
/// eigenvectors. 60 of them, too.
TEST(Formulas, AFewDirectionsThatAreNotTestedAreTakenOutOfMany) {
  test::Normal normal(13);
  const Eigen::Index n = 420;
  Eigen::MatrixXd a(n, n);
  for (Eigen::Index i = 0; i < a.size(); ++i) a.data()[i] = normal();
  const Eigen::MatrixXd turned = Eigen::HouseholderQR<Eigen::MatrixXd>(a).householderQ();
  for (const Eigen::Index few : {1, 7, 24, 60}) {
    Eigen::VectorXd variances(n), along(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      variances[i] = i < few ? 4e-12 * static_cast<double>(i) : 1e-7 * (1 + static_cast<double>(i % 17));
      along[i] = std::sqrt(variances[i]) * normal();
    }
    Eigen::MatrixXd s = turned * variances.asDiagonal() * turned.transpose();
    const double expected = (along.array().square() / variances.array()).tail(n - few).sum();
    const auto tested = tested_directions(turned * along, s, 4e-10, true);
    ASSERT_TRUE(tested.has_value()) << few;
    EXPECT_EQ(tested->number, n - few);
    EXPECT_NEAR(tested->statistic, expected, 1e-8 * expected);
    EXPECT_FALSE(tested_directions(turned * along, s, 4e-10, false).has_value());
    const auto chi = consistency(turned * along, {s, 1}, 0.95);
    EXPECT_EQ(chi->degrees_of_freedom, n - few);
    EXPECT_NEAR(chi->statistic, expected, 1e-8 * expected);
  }
}

/// Most of the variances lie about the limit: eigenvalues tell.
TEST(Formulas, ManyDirectionsThatAreNotTestedAreToldByEigenvalues) {
  test::Normal normal(14);
  const Eigen::Index n = 320;
  Eigen::MatrixXd s = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd d(n);
  for (Eigen::Index i = 0; i < n; ++i) s(i, i) = 1e-10 * (1 + static_cast<double>(i % 8)), d[i] = 1e-5 * normal();
  double expected = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    if (i % 8 > 3) expected += d[i] * d[i] / s(i, i);
  for (Eigen::Index i = 1; i < n; ++i) s(i, i - 1) = s(i - 1, i) = 1e-20;  // one cluster
  EXPECT_FALSE(tested_directions(d, s, 4e-10 + 1e-15, true).has_value());
  const auto chi = consistency(d, {s + 1e-15 * Eigen::MatrixXd::Identity(n, n), 1}, 0.95);
  EXPECT_EQ(chi->degrees_of_freedom, n / 8 * 5);
}

/// The factor that uses wide vectors: the same bits with all of them, as Eigen's to rounding, nothing above the
/// diagonal touched; sizes that no tile divides.
TEST(LowerFactor, HasTheSameBitsWithVectorsOfEveryWidth) {
  using linear_algebra::Vectors;
  test::Normal normal(15);
  for (const Eigen::Index n : {1, 5, 16, 130, 391}) {
    Eigen::MatrixXd a(n, 9);
    for (Eigen::Index i = 0; i < a.size(); ++i) a.data()[i] = normal();
    Eigen::MatrixXd s = a * a.transpose() + 2 * Eigen::MatrixXd::Identity(n, n);
    s(0, n - 1) = n > 1 ? 77 : s(0, 0);  // not read
    Eigen::MatrixXd narrow = s;
    ASSERT_TRUE(linear_algebra::lower_factor(narrow.data(), n, Vectors::of_two));
    const Eigen::MatrixXd eigen = Eigen::LLT<Eigen::MatrixXd>(s).matrixL();
    EXPECT_LT((Eigen::MatrixXd(narrow.triangularView<Eigen::Lower>()) - eigen).cwiseAbs().maxCoeff(), 1e-12) << n;
    EXPECT_TRUE(Eigen::MatrixXd(narrow.triangularView<Eigen::StrictlyUpper>()) ==
                Eigen::MatrixXd(s.triangularView<Eigen::StrictlyUpper>()));
    for (const Vectors vectors : {Vectors::of_four, Vectors::of_eight}) {
      if (vectors > linear_algebra::widest_vectors()) continue;
      Eigen::MatrixXd wide = s;
      ASSERT_TRUE(linear_algebra::lower_factor(wide.data(), n, vectors));
      EXPECT_TRUE(wide == narrow) << n;
    }
    s(n - 1, n - 1) = -1;
    EXPECT_FALSE(linear_algebra::lower_factor(s.data(), n));
  }
}

TEST(Formulas, PredictedRmseAndItsRangeCoverSimulatedErrors) {
  // Six heights with a common part: 600 draws; 95 % of their RMSE must fall into the predicted range, and of their
  // chi-square statistics between the critical values. 3 standard deviations of a binomial of 600: 0.027.
  Eigen::MatrixXd s = 0.25 * Eigen::MatrixXd::Identity(6, 6) + 0.5 * Eigen::MatrixXd::Ones(6, 6);
  const Eigen::MatrixXd root = s.llt().matrixL();
  const PredictedRmse predicted = predicted_rmse({s, 1}, 6, 0.95);
  EXPECT_NEAR(predicted.value, std::sqrt(0.75), 1e-12);
  test::Normal normal(7);
  int in_range = 0, consistent = 0;
  for (int trial = 0; trial < 600; ++trial) {
    Eigen::VectorXd d(6);
    for (double& v : d) v = normal();
    d = root * d;
    const double rmse = std::sqrt(d.squaredNorm() / 6);
    in_range += rmse >= predicted.lower && rmse <= predicted.upper;
    const auto chi = consistency(d, {s, 1}, 0.95);
    consistent += chi->statistic >= chi->lower && chi->statistic <= chi->upper;
  }
  EXPECT_NEAR(in_range / 600.0, 0.95, 0.03);
  EXPECT_NEAR(consistent / 600.0, 0.95, 0.03);
}

}  // namespace test_formulas
}  // namespace plumbline::judgement
