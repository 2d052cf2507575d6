// Whole networks whose answer is known.
#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <set>

#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_network {

using test::simulate;
using test::SimulationSettings;

/// Distance between two points of a result.
double distance(const NetworkResult& r, const std::string& a, const std::string& b) {
  return (r.point(a).position - r.point(b).position).norm();
}

TEST(Network, ExactObservationsGiveTheTruth) {
  SimulationSettings s;
  s.noise = 0;
  const auto n = simulate(s, 1);
  AdjustOptions options;
  options.curvature = Switch::off;
  const NetworkResult r = adjust_network(n.survey, options);
  EXPECT_EQ(r.defect, 4);
  EXPECT_EQ(r.datum, DatumMode::inner);
  for (size_t i = 0; i < n.truth.size(); ++i)
    EXPECT_LT((r.point(n.survey.points[i].id).position - n.truth[i]).norm(), 1e-8);
  EXPECT_NEAR(r.sum_of_redundancy_numbers, r.degrees_of_freedom, 1e-6);
}

TEST(Network, NeedsNoKnownPointAtAll) {
  SimulationSettings s;
  s.coordinates = false;
  const auto n = simulate(s, 2);
  AdjustOptions options;
  options.curvature = Switch::off;
  const NetworkResult r = adjust_network(n.survey, options);
  EXPECT_LT(std::abs(r.sigma0 - 1), 0.4);
  const double truth = (n.truth[0] - n.truth[11]).norm();
  EXPECT_NEAR(distance(r, "M00", "M23"), truth, 0.003);
}

TEST(Network, DatumsDifferInFrameNotInShape) {
  const auto n = simulate({}, 3);
  AdjustOptions inner, fixed;
  inner.curvature = fixed.curvature = Switch::off;
  inner.datum = DatumMode::inner;
  inner.datum_points = {"M00", "M03", "M20"};
  fixed.datum = DatumMode::inner;
  const NetworkResult a = adjust_network(n.survey, inner), b = adjust_network(n.survey, fixed);
  EXPECT_NEAR(a.sum_of_squares, b.sum_of_squares, 1e-6);
  EXPECT_NEAR(distance(a, "M01", "M22"), distance(b, "M01", "M22"), 1e-7);
  const Eigen::Matrix3d ab = a.relative_covariance(a.point("M01"), a.point("M21"));
  const Eigen::Matrix3d bb = b.relative_covariance(b.point("M01"), b.point("M21"));
  EXPECT_NEAR(ab(2, 2), bb(2, 2), 1e-6 * ab(2, 2));  // a height difference does not depend on the datum
}

TEST(Network, WeightedControlWithEqualCovarianceIsTheMean) {
  const auto n = simulate({}, 4);
  ControlPoints control;
  control.ids = {"M00", "M03", "M20", "M23"};
  control.coordinates.resize(12);
  for (int i = 0; i < 4; ++i)
    for (size_t k = 0; k < n.survey.points.size(); ++k)
      if (n.survey.points[k].id == control.ids[i]) control.coordinates.segment<3>(3 * i) = n.truth[k];
  control.covariance = 1e-6 * Eigen::MatrixXd::Identity(12, 12);
  AdjustOptions options;
  options.curvature = Switch::off;
  const NetworkResult r = adjust_network(n.survey, options, control);
  EXPECT_EQ(r.datum, DatumMode::weighted);
  EXPECT_EQ(r.defect, 0);
  for (size_t i = 0; i < n.truth.size(); ++i) {
    const Eigen::Vector3d error = r.point(n.survey.points[i].id).position - n.truth[i];
    EXPECT_LT(error.norm(), 0.005);
  }
  control.covariance.resize(0, 0);
  const NetworkResult held = adjust_network(n.survey, options, control);
  EXPECT_EQ(held.datum, DatumMode::fixed);
  EXPECT_EQ(held.sigma(held.point("M00")).norm(), 0.0);
}

TEST(Network, SnoopingRemovesTheBlunderAndSaysSo) {
  auto n = simulate({}, 5);
  Observation& wrong = n.survey.observations[20];  // a slope distance
  ASSERT_EQ(wrong.kind, ObservationKind::slope_distance);
  wrong.value += 0.05;
  AdjustOptions options;
  options.curvature = Switch::off;
  const NetworkResult flagged = adjust_network(n.survey, options);
  EXPECT_TRUE(flagged.rows[20].flagged);
  EXPECT_EQ(flagged.snooping.size(), 0u);
  options.remove_blunders = true;
  const NetworkResult r = adjust_network(n.survey, options);
  ASSERT_EQ(r.snooping.size(), 1u);
  EXPECT_EQ(r.snooping[0].row, 20);
  EXPECT_TRUE(r.rows[20].removed);
  EXPECT_NEAR(r.rows[20].statistics.estimated_blunder, 0.05, 0.006);
  EXPECT_LT(r.sigma0, 1.4);
}

/// Where more are suspect than may go, the robust start takes the worst of them.
TEST(Network, TheRobustStartTakesTheWorstOfTooManySuspects) {
  auto n = simulate({}, 7);
  std::set<int> large;
  int size = 0;
  for (const int row : {2, 14, 32, 50, 65, 77, 92, 104}) {  // slope distances, the later the worse
    ASSERT_EQ(n.survey.observations[row].kind, ObservationKind::slope_distance);
    n.survey.observations[row].value += 0.02 + 0.015 * size++;
    if (size > 5) large.insert(row);
  }
  AdjustOptions options;
  options.curvature = Switch::off;
  options.remove_blunders = options.robust_start = true;
  options.largest_removed_share = 3.5 / static_cast<double>(n.survey.observations.size());
  const NetworkResult r = adjust_network(n.survey, options);
  ASSERT_GE(r.snooping.size(), 3u);
  std::set<int> first;
  for (size_t k = 0; k < 3; ++k) first.insert(r.snooping[k].row);
  EXPECT_EQ(first, large);
}

/// Critical values of whole sightings: chi-squared with as many degrees of freedom as the sighting has readings.
TEST(Network, ASightingIsTestedWithAllOfItsReadings) {
  auto n = simulate({}, 8);
  n.survey.observations.erase(n.survey.observations.begin() + 17);  // a sighting of two readings
  AdjustOptions options;
  options.curvature = Switch::off;
  options.alpha0 = 0.01;
  const NetworkResult r = adjust_network(n.survey, options);
  std::set<int> ranks;
  for (const ResultPointing& p : r.pointings) {
    ranks.insert(p.test.rank);
    EXPECT_NEAR(p.critical, p.test.rank == 3 ? 11.345 : 9.210, 1e-3) << "chi-squared, 99 %, of the tables";
    EXPECT_EQ(p.flagged, p.test.statistic > p.critical);
  }
  EXPECT_EQ(ranks, (std::set<int>{2, 3}));
}

TEST(Network, MeansOfFacesAndSets) {
  auto n = simulate({}, 6);
  SurveyObservations two = n.survey;
  two.observations.clear();
  for (Observation o : n.survey.observations) {
    o.sigma = kNotGiven;
    const double error = 3e-4;  // of the instrument: cancels in the two faces
    Observation second = o;
    o.face = 1;
    second.face = 2;
    if (o.kind == ObservationKind::direction) {
      second.value = o.value + std::numbers::pi - error;
      o.value += error;
    }
    if (o.kind == ObservationKind::zenith_angle) {
      second.value = 2 * std::numbers::pi - (o.value - error);
      o.value += error;
    }
    two.observations.push_back(o);
    two.observations.push_back(second);
  }
  AdjustOptions options;
  options.profile = built_in_profile("total_station_2arcsec");
  options.curvature = Switch::off;
  const NetworkResult r = adjust_network(two, options);
  EXPECT_EQ(r.observations, static_cast<int>(n.survey.observations.size()));
  SurveyObservations one = n.survey;
  for (Observation& o : one.observations) o.sigma = kNotGiven;
  const NetworkResult same = adjust_network(one, options);
  EXPECT_NEAR(distance(r, "M01", "M22"), distance(same, "M01", "M22"), 1e-6);
}

TEST(Network, VarianceComponentsFindTheRightModel) {
  SimulationSettings s;
  s.columns = 8;
  s.rows = 5;
  s.set_ups = 5;
  auto n = simulate(s, 701);
  for (Observation& o : n.survey.observations)
    if (o.kind == ObservationKind::slope_distance) o.sigma /= 3;  // claimed three times too good
  AdjustOptions options;
  options.curvature = Switch::off;
  options.estimate_variance_components = true;
  const NetworkResult r = adjust_network(n.survey, options);
  for (const ResultGroup& g : r.groups) {
    if (g.name == "distances") {
      EXPECT_NEAR(g.applied_factor, 3, 0.4);
    }
    if (g.name == "directions") {
      EXPECT_NEAR(g.applied_factor, 1, 0.15);
    }
  }
  EXPECT_NEAR(r.sigma0, 1, 0.05);
}

TEST(Network, OptionalUnknownsAreFound) {
  SimulationSettings s;
  s.noise = 0.1;
  s.rows = 5;
  auto n = simulate(s, 8);
  ControlPoints control;
  control.ids = {"M00", "M03", "M40", "M43", "M21"};
  control.coordinates.resize(15);
  for (int i = 0; i < 5; ++i)
    for (size_t k = 0; k < n.survey.points.size(); ++k)
      if (n.survey.points[k].id == control.ids[i]) control.coordinates.segment<3>(3 * i) = n.truth[k];
  for (Observation& o : n.survey.observations)
    if (o.kind == ObservationKind::slope_distance) o.value += 0.004;
  AdjustOptions options;
  options.curvature = Switch::off;
  options.additive_constant_sigma = 0.01;
  const NetworkResult r = adjust_network(n.survey, options, control);
  ASSERT_EQ(r.parameters.size(), 1u);
  EXPECT_NEAR(r.parameters[0].value, 0.004, 0.0005);
  EXPECT_LT(r.parameters[0].sigma, 0.001);
  EXPECT_NEAR(r.sum_of_redundancy_numbers, r.degrees_of_freedom, 1e-6);
}

TEST(Network, LocalCoordinatesOfACameraSensor) {
  SimulationSettings s;
  s.noise = 0;
  const auto n = simulate(s, 9);
  SurveyObservations local = n.survey;
  local.observations.clear();
  for (const Observation& o : n.survey.observations) {
    if (o.kind != ObservationKind::direction) continue;
    const Observation& z = *(&o + 1);
    const Observation& d = *(&o + 2);
    LocalCoordinate c;
    c.set_up = o.set_up;
    c.point = o.to;
    c.position = d.value * Eigen::Vector3d(std::sin(z.value) * std::sin(o.value), std::sin(z.value) * std::cos(o.value),
                                           std::cos(z.value));
    c.covariance = 1e-6 * Eigen::Matrix3d::Identity();
    local.local_coordinates.push_back(c);
  }
  const NetworkResult r = adjust_network(local, {});
  EXPECT_EQ(r.defect, 4);
  EXPECT_LT(r.sum_of_squares, 1e-6);
  EXPECT_NEAR(distance(r, "M00", "M23"), (n.truth[0] - n.truth[11]).norm(), 1e-7);
}

TEST(Network, BadIndicesAndValuesAreErrors) {
  auto n = simulate({}, 10);
  for (const int wrong : {99, -2, 1 << 30}) {  // the last far outside: a look at it would end the program
    n.survey.observations[3].set_up = wrong;
    EXPECT_THROW(adjust_network(n.survey, {}), NetworkError);
  }
  n = simulate({}, 10);
  n.survey.observations[3].value = kNotGiven;
  EXPECT_THROW(adjust_network(n.survey, {}), NetworkError);
  EXPECT_THROW(adjust_network(SurveyObservations{}, {}), NetworkError);
}

TEST(InstrumentProfile, LevellingErrorGrowsWithElevationAndIsNotAveraged) {
  const InstrumentProfile p = parse_profile(
      "{direction_arcsec: 1, zenith_angle_arcsec: 1, distance_mm: 1, distance_ppm: 1, levelling_arcsec: 3}", "test");
  const double second = std::numbers::pi / 180 / 3600;
  EXPECT_NEAR(p.direction(20, 20, 1, false), second, 1e-12);
  EXPECT_NEAR(p.direction(20, 25, 1, false), second * std::hypot(1, 3 * 0.75), 1e-12);  // height 15
  EXPECT_NEAR(p.direction(20, 25, 4, false), second * std::hypot(0.5, 3 * 0.75), 1e-12);
  EXPECT_NEAR(p.zenith_angle(25, 4, false), second * std::hypot(0.5, 3), 1e-12);
}

TEST(InstrumentProfile, ObservationsNameTheirProfile) {
  std::string remark;
  EXPECT_EQ(choose_profile("automatic", "", "total_station_1arcsec", remark).name, "total_station_1arcsec");
  EXPECT_EQ(choose_profile("total_station_2arcsec", "", "total_station_1arcsec", remark).name, "total_station_2arcsec");
  EXPECT_EQ(choose_profile("automatic", "", "", remark).name, "ics50_assumed");
  EXPECT_EQ(remark, "");
  EXPECT_EQ(choose_profile("automatic", "", "Wild T2", remark).name, "ics50_assumed");
  EXPECT_NE(remark.find("'Wild T2'"), std::string::npos) << remark;
}

}  // namespace test_network
}  // namespace plumbline::survey
