// A network whose cofactors are found on demand says the same as with all of them in one matrix.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "geometry/random.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/epochs/check_control.hpp"
#include "survey/simulate/simulate_survey.hpp"

namespace plumbline::survey {
namespace test_large_network {

/// A long facade in rows of ten markers; set-ups along it that each see the markers in front of them.
SurveyObservations facade(int markers, int set_ups) {
  SurveyLayout layout;
  const double length = 2.0 * markers / 10, reach = 3.5 * length / set_ups;
  for (int m = 0; m < markers; ++m)
    layout.points.push_back({"M" + std::to_string(m), {2.0 * (m / 10), 0.2 * (m % 3), 3.0 * (m % 10)}});
  for (int i = 0; i < set_ups; ++i) {
    const std::string id = "S" + std::to_string(i);
    const double x = length * (i + 0.5) / set_ups;
    layout.points.push_back({id, {x, -18.0 - 3.0 * (i % 3), 0.0}});
    layout.set_ups.push_back({id, id, 1.6, 0.1 * i, {}});
    for (int m = 0; m < markers; ++m)
      if (std::abs(layout.points[m].position.x() - x) < reach)
        layout.set_ups.back().sees.push_back("M" + std::to_string(m));
  }
  SimulationOptions simulation;
  simulation.profile = built_in_profile("total_station_2arcsec");
  SurveyObservations survey = simulate_survey(layout, simulation, 5);
  survey.info.format = "csv";
  return survey;
}

/// Largest difference of two covariances, in parts of the standard deviations they belong to.
double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::VectorXd s = a.diagonal().cwiseSqrt();
  return ((a - b).array() / (s * s.transpose()).array()).abs().maxCoeff();
}

/// Blunders whose stations see no point in common go together: each by itself would be an adjustment of the whole.
TEST(LargeNetwork, BlundersFarApartGoInOneAdjustment) {
  SurveyObservations survey = facade(600, 36);
  std::set<int> wrong;  // lines, and one more beside the first: of the same set-up, so it waits
  for (const int set_up : {1, 11, 21, 31, 1})
    for (Observation& o : survey.observations)
      if (o.kind == ObservationKind::slope_distance && o.set_up == set_up && !wrong.contains(o.source.line)) {
        o.value += set_up == 1 && wrong.size() > 1 ? 0.008 : 0.01;
        wrong.insert(o.source.line);
        break;
      }
  ASSERT_EQ(wrong.size(), 5u);
  AdjustOptions options;
  options.profile = built_in_profile("total_station_2arcsec");
  options.remove_blunders = true;
  const NetworkResult r = adjust_network(survey, options);
  std::set<int> removed;
  for (const ResultRow& row : r.rows)
    if (row.removed) removed.insert(row.source.line);
  EXPECT_EQ(removed, wrong);
  std::map<double, int> steps;  // by the sum of squares after them
  for (const SnoopingAction& a : r.snooping) ++steps[a.sum_of_squares];
  EXPECT_EQ(steps.size(), 2u);
  EXPECT_EQ(r.validity, Validity::sound) << r.verdict;
}

TEST(LargeNetwork, CovariancesOnDemandAreThoseOfTheWholeMatrix) {
  const SurveyObservations survey = facade(1000, 60);
  AdjustOptions options;
  options.profile = built_in_profile("total_station_2arcsec");
  const NetworkResult whole = adjust_network(survey, options);
  options.largest_whole = 0;
  const NetworkResult sparse = adjust_network(survey, options);
  ASSERT_TRUE(whole.cofactors.is_whole());
  ASSERT_FALSE(sparse.cofactors.is_whole());
  ASSERT_EQ(whole.points.size(), 1060u);
  EXPECT_GT(whole.defect, 0) << "a free network: its datum too";
  EXPECT_THROW(sparse.full_covariance(), std::runtime_error);
  double own = 0, relative = 0, apart = 0;
  for (size_t i = 0; i < whole.points.size(); i += 7) {
    EXPECT_LT((whole.points[i].position - sparse.points[i].position).norm(), 1e-9);
    const auto &a = whole.points[i], &b = whole.points[(i + 11) % 1060], &far = whole.points[(i + 531) % 1060];
    own = std::max(own, difference(whole.covariance(a, a), sparse.covariance(a, a)));
    relative = std::max(relative, difference(whole.relative_covariance(a, b), sparse.relative_covariance(a, b)));
    apart = std::max(apart, difference(whole.relative_covariance(a, far), sparse.relative_covariance(a, far)));
  }
  EXPECT_LT(own, 1e-9);
  EXPECT_LT(relative, 1e-9);
  EXPECT_LT(apart, 1e-9);
  const std::vector<size_t> some = {3, 999, 1001, 500, 17, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 1059};
  EXPECT_LT(difference(whole.covariance_of(some), sparse.covariance_of(some)), 1e-9);
  ASSERT_EQ(whole.rows.size(), sparse.rows.size());
  size_t of_own_points = 0;
  for (size_t r = 0; r < whole.rows.size(); ++r) {
    const auto &a = whole.rows[r].statistics, &b = sparse.rows[r].statistics;
    EXPECT_NEAR(a.redundancy_number, b.redundancy_number, 1e-9);
    EXPECT_NEAR(a.w, b.w, 1e-6);
    if (!std::isfinite(a.mdb)) continue;
    EXPECT_NEAR(a.mdb, b.mdb, 1e-9 * a.mdb);
    EXPECT_LE(b.external_effect, a.external_effect * (1 + 1e-9)) << "on its own points only";
    const ResultRow& row = whole.rows[r];
    if (row.external_point.empty() || (row.external_point != row.from && row.external_point != row.to)) continue;
    EXPECT_NEAR(a.external_effect, b.external_effect, 1e-4 * a.external_effect) << "and on these all of it";
    ++of_own_points;
  }
  EXPECT_GT(of_own_points, 0u);
  EXPECT_NEAR(sparse.sum_of_redundancy_numbers, sparse.degrees_of_freedom, 1e-5);
  for (size_t s = 0; s < whole.set_ups.size(); ++s) {
    EXPECT_NEAR(whole.set_ups[s].orientation_sigma, sparse.set_ups[s].orientation_sigma,
                1e-9 * whole.set_ups[s].orientation_sigma);
    EXPECT_NEAR(whole.set_ups[s].index.sigma, sparse.set_ups[s].index.sigma, 1e-9 * whole.set_ups[s].index.sigma);
    EXPECT_NEAR(whole.set_ups[s].constant.value, sparse.set_ups[s].constant.value, 1e-9);
  }
  EXPECT_EQ(whole.verdict, sparse.verdict);
}

/// Known points against the network, and the check of control, where the cofactors are on demand.
TEST(LargeNetwork, ControlIsComparedLikewise) {
  SurveyObservations survey = facade(120, 8);
  AdjustOptions options;
  options.profile = built_in_profile("total_station_2arcsec");
  ControlPoints control;
  control.ids = {"M0", "M9", "M58", "M110", "M119"};
  control.coordinates.resize(15);
  for (size_t k = 0; k < control.ids.size(); ++k) {
    const int m = std::stoi(control.ids[k].substr(1));
    control.coordinates.segment<3>(static_cast<Eigen::Index>(3 * k)) =
        Eigen::Vector3d(2.0 * (m / 10), 0.2 * (m % 3), 3.0 * (m % 10));
  }
  control.coordinates[6] += 0.020;  // M58 was knocked
  control.covariance = 1e-6 * Eigen::MatrixXd::Identity(15, 15);
  const NetworkResult whole = adjust_network(survey, options, control);
  const ControlCheck checked = check_control(survey, control, options, {});
  options.largest_whole = 0;
  const NetworkResult sparse = adjust_network(survey, options, control);
  const ControlCheck on_demand = check_control(survey, control, options, {});
  ASSERT_EQ(whole.known_points.size(), 5u);
  ASSERT_EQ(sparse.known_points.size(), 5u);
  EXPECT_EQ(whole.known_points[0].id, "M58");
  for (size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(whole.known_points[k].id, sparse.known_points[k].id);
    EXPECT_NEAR(whole.known_points[k].statistic, sparse.known_points[k].statistic,
                1e-6 * (1 + whole.known_points[k].statistic));
  }
  ASSERT_EQ(checked.problem, "");
  ASSERT_EQ(on_demand.problem, "");
  ASSERT_EQ(checked.comparison.movements.size(), on_demand.comparison.movements.size());
  for (size_t k = 0; k < checked.comparison.movements.size(); ++k) {
    EXPECT_EQ(checked.comparison.movements[k].moved, on_demand.comparison.movements[k].moved);
    EXPECT_LT((checked.comparison.movements[k].movement - on_demand.comparison.movements[k].movement).norm(), 1e-8);
  }
}

}  // namespace test_large_network
}  // namespace plumbline::survey
