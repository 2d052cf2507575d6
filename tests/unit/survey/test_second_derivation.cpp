// Statistics that the adjustment gives, each derived a second time: by adjusting again with a reading changed or left
// out, by a dense formula, or by hand. A factor or a sign that is wrong in one of them shows here.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "network_words.hpp"
#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/model/instrument_profile.hpp"
#include "survey/simulate/simulate_survey.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_second_derivation {

constexpr size_t kRow = 20;  // a slope distance of test::simulate

AdjustOptions free_network() {
  AdjustOptions options;
  options.datum = DatumMode::inner;
  options.curvature = Switch::off;
  return options;
}

AdjustOptions held() {
  AdjustOptions options;
  options.curvature = Switch::off;
  return options;
}

TEST(SecondDerivation, ExternalEffectIsHowFarAPointMoves) {
  auto n = test::simulate({}, 51);
  const NetworkResult before = adjust_network(n.survey, free_network());
  const auto& s = before.rows[kRow].statistics;
  n.survey.observations[kRow].value += 0.01 * s.mdb;
  const NetworkResult after = adjust_network(n.survey, free_network());
  double largest = 0;
  std::string moved;
  for (size_t i = 0; i < before.points.size(); ++i) {
    const double d = (after.points[i].position - before.points[i].position).norm();
    if (d > largest) largest = d, moved = before.points[i].id;
  }
  EXPECT_NEAR(100 * largest / s.external_effect, 1, 0.01);
  EXPECT_EQ(before.rows[kRow].external_point, moved);
}

TEST(SecondDerivation, BiasToNoiseAndAdjustedSigma) {
  const NetworkResult r = adjust_network(test::simulate({}, 52).survey, free_network());
  const double delta0 = least_squares::non_centrality(0.001, 0.80);
  for (const ResultRow& row : r.rows) {
    const auto& s = row.statistics;
    // A blunder of size mdb is partly seen (delta0) and partly in the unknowns (bias to noise).
    EXPECT_NEAR(std::hypot(delta0, s.bias_to_noise) / (s.mdb / s.sigma), 1, 1e-9);
    EXPECT_NEAR(s.sigma_adjusted / (s.sigma * std::sqrt(1 - s.redundancy_number)), 1, 1e-6);
    EXPECT_NEAR(s.controlled, s.redundancy_number, 1e-9);
  }
}

TEST(SecondDerivation, EachKindOfObservationHasItsGroup) {
  const NetworkResult r = adjust_network(test::simulate({}, 52).survey, free_network());
  ASSERT_EQ(r.groups.size(), 3u);
  double redundancy = 0;
  for (const ResultGroup& g : r.groups) {
    EXPECT_EQ(g.component.rows, 36);
    redundancy += g.component.redundancy;
  }
  EXPECT_NEAR(redundancy, r.degrees_of_freedom, 1e-6);
}

TEST(SecondDerivation, PointingTestIsWhatTheSightingTakesOffTheSum) {
  auto n = test::simulate({}, 53);
  const NetworkResult r = adjust_network(n.survey, free_network());
  const ResultPointing& pointing = r.pointings[5];  // readings 15, 16, 17
  ASSERT_EQ(pointing.to, n.survey.observations[15].to);
  EXPECT_EQ(pointing.test.rank, 3);
  EXPECT_NEAR(pointing.critical, 16.266, 0.001) << "chi-squared of three degrees of freedom at 0.1 %, from a table";
  EXPECT_FALSE(pointing.flagged);
  n.survey.observations.erase(n.survey.observations.begin() + 15, n.survey.observations.begin() + 18);
  const NetworkResult without = adjust_network(n.survey, free_network());
  EXPECT_NEAR((r.sum_of_squares - without.sum_of_squares) / pointing.test.statistic, 1, 0.01);
  auto knocked = test::simulate({}, 53);
  knocked.survey.observations[17].value += 0.05;
  const NetworkResult seen = adjust_network(knocked.survey, free_network());
  for (size_t k = 0; k < seen.pointings.size(); ++k) {
    const ResultPointing& p = seen.pointings[k];
    EXPECT_EQ(p.flagged, p.test.statistic > 16.266 && p.test.rank == 3) << k;
    EXPECT_LE(p.test.statistic, seen.pointings[5].test.statistic) << k;
  }
  EXPECT_TRUE(seen.pointings[5].flagged);
}

TEST(SecondDerivation, ARemovedReadingKeepsTheTestItHad) {
  auto n = test::simulate({}, 54);
  n.survey.observations[kRow].value += 0.05;
  AdjustOptions options = free_network();
  options.remove_blunders = true;
  const NetworkResult r = adjust_network(n.survey, options);
  ASSERT_EQ(r.snooping.size(), 1u);
  ASSERT_EQ(r.snooping[0].row, static_cast<int>(kRow));
  const auto& s = r.rows[kRow].statistics;
  EXPECT_TRUE(r.rows[kRow].removed);
  EXPECT_NEAR(s.w / r.snooping[0].w, 1, 0.02);
  // Predicted from the others: the variance of the prediction is that of the sight between two adjusted points.
  const NetworkResult without = [&] {
    auto rest = n;
    rest.survey.observations.erase(rest.survey.observations.begin() + static_cast<std::ptrdiff_t>(kRow));
    return adjust_network(rest.survey, free_network());
  }();
  const ResultPoint &a = without.point(r.rows[kRow].from), &b = without.point(r.rows[kRow].to);
  const Eigen::Vector3d along = (b.position - a.position).normalized();
  const double predicted = std::sqrt(along.dot(without.relative_covariance(a, b) * along));
  EXPECT_NEAR(s.sigma_adjusted / predicted, 1, 1e-3);
  EXPECT_NEAR(s.w, s.residual / std::hypot(s.sigma, predicted), 1e-2);
  const double delta0 = least_squares::non_centrality(0.001, 0.80);
  EXPECT_NEAR(std::hypot(delta0, s.bias_to_noise) / (s.mdb / s.sigma), 1, 1e-9);
}

TEST(SecondDerivation, CorrelatedRowsWithANegativeRedundancyNumberAreTested) {
  // One unknown observed twice, sigmas 1 and 2, correlation 0.9: the estimate is 1.57 l1 - 0.57 l2, so r_1 = -0.57.
  Eigen::Matrix2d sigma;
  sigma << 1, 1.8, 1.8, 4;
  const Eigen::Vector2d a(1, 1), l(3, -40);
  const Eigen::Matrix2d p = sigma.inverse();
  const double q = 1 / a.dot(p * a);
  const Eigen::Vector2d v = a * (q * a.dot(p * l)) - l;
  const Eigen::Matrix2d qvv = sigma - q * a * a.transpose(), pqp = p * qvv * p;
  const Eigen::Matrix2d lower = sigma.llt().matrixL();
  const Eigen::Matrix2d w = lower.inverse();
  const auto rows = least_squares::row_statistics(w, w * v, w * qvv * w.transpose(), 4.13);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(rows[0].redundancy_number, 1 - (4 - 1.8) / (5 - 3.6), 1e-9);
  EXPECT_LT(rows[0].redundancy_number, 0);
  for (int i = 0; i < 2; ++i) {
    const auto& row = rows[i];
    EXPECT_NEAR(row.w, (p * v)[i] / std::sqrt(pqp(i, i)), 1e-9);
    EXPECT_NEAR(row.estimated_blunder, -(p * v)[i] / pqp(i, i), 1e-9);
    EXPECT_NEAR(row.mdb, 4.13 / std::sqrt(pqp(i, i)), 1e-9);
    EXPECT_NEAR(row.controlled, pqp(i, i) / p(i, i), 1e-9);
  }
  EXPECT_GT(std::abs(rows[0].w), 3);
}

/// Levelling lines: from, to, height difference [m], sigma 1 mm.
SurveyObservations levelling(const std::vector<std::tuple<std::string, std::string, double>>& lines) {
  SurveyObservations s;
  for (const auto& [from, to, value] : lines) {
    Observation o;
    o.kind = ObservationKind::height_difference;
    o.from = from, o.to = to, o.value = value, o.sigma = 0.001;
    s.observations.push_back(o);
  }
  return s;
}

TEST(SecondDerivation, AReadingWithoutWhichAPointIsNotControlledStays) {
  // P hangs on two lines that contradict each other by 50 mm: either could be wrong.
  AdjustOptions options;
  options.datum = DatumMode::inner;
  options.remove_blunders = true;
  const NetworkResult r = adjust_network(
      levelling({{"A", "B", 1}, {"A", "B", 1.0002}, {"B", "C", 2}, {"A", "C", 3}, {"A", "P", 1}, {"B", "P", 0.05}}),
      options);
  for (const ResultRow& row : r.rows) EXPECT_FALSE(row.removed && row.to == "P");
  EXPECT_NE(all_words(r).find("but stays: without it a point would not be controlled"), std::string::npos)
      << all_words(r);
  // 50 mm over two lines of 1 mm: v'Pv 1250, sigma0 20.
  EXPECT_EQ(r.validity, Validity::invalid) << r.verdict;
}

/// A bench mark is given: it needs nothing that controls it, and its only line may go.
TEST(SecondDerivation, TheOnlyLineToAFixedPointMayBeTakenOut) {
  SurveyObservations s = levelling({{"A", "P", 5.05}});
  for (const auto& [id, height] : std::map<std::string, double>{{"A", 100}, {"B", 101}, {"C", 102}}) {
    Point p;
    p.id = id, p.coordinates.z() = height;
    p.roles = {CoordinateRole::unused, CoordinateRole::unused, CoordinateRole::fixed};
    s.points.push_back(p);
    if (id == "A") continue;
    for (const auto& [to, h] : std::map<std::string, double>{{"P", 105}, {"Q", 106}, {"R", 107}})
      for (const double error : {0.0003, -0.0004}) {
        SurveyObservations line = levelling({{id, to, h - height + error}});
        s.observations.push_back(line.observations[0]);
      }
  }
  AdjustOptions options;
  options.remove_blunders = true;
  const NetworkResult r = adjust_network(s, options);
  ASSERT_EQ(r.snooping.size(), 1u) << all_words(r);
  EXPECT_EQ(r.rows[r.snooping[0].row].from, "A");
  EXPECT_NEAR(r.point("P").position.z(), 105, 0.001);
}

TEST(SecondDerivation, AnAngleHasTheSigmaOfItsTwoSights) {
  SurveyObservations s;
  const auto add = [&](const std::string& id, double e, double n, CoordinateRole role) {
    Point p;
    p.id = id, p.coordinates = {e, n, 0};
    p.roles = {role, role, CoordinateRole::unused};
    s.points.push_back(p);
  };
  add("A", 0, 0, CoordinateRole::fixed), add("B", 0, 100, CoordinateRole::fixed), add("P", 24, 7, CoordinateRole::free);
  Observation o;
  o.kind = ObservationKind::angle, o.from = "A", o.to = "B", o.second_to = "P", o.value = std::atan2(24, 7);
  s.observations.push_back(o);
  o.kind = ObservationKind::horizontal_distance, o.to = "P", o.second_to.clear(), o.value = 25;
  s.observations.push_back(o);
  AdjustOptions options = held();
  options.profile = built_in_profile("total_station_1arcsec");
  options.profile.instrument_centring = 0;  // common to both sights; listings of another program hold it
  const NetworkResult r = adjust_network(s, options);
  EXPECT_NEAR(r.rows[0].statistics.sigma,
              std::hypot(options.profile.direction(100, 100, 1, false), options.profile.direction(25, 25, 1, false)),
              1e-12);
}

TEST(SecondDerivation, LocalCoordinatesWithoutCovarianceHaveThatOfTheirSight) {
  SurveyObservations s;
  s.set_ups.push_back({"S", "S", kNotGiven, {}});
  s.set_ups.push_back({"T", "T", kNotGiven, {}});
  for (int set_up = 0; set_up < 2; ++set_up)
    for (int k = 0; k < 4; ++k) {
      LocalCoordinate c;
      c.set_up = set_up;
      c.point = "P" + std::to_string(k);
      const Eigen::Vector3d p(k == 0 ? 0 : 3.0 * k, 20, k == 0 ? 0 : 1.0 * k);
      c.position = set_up == 0 ? p : Eigen::Vector3d(p - Eigen::Vector3d(5, -2, 0));
      s.local_coordinates.push_back(c);
    }
  AdjustOptions options = free_network();
  options.profile = built_in_profile("total_station_1arcsec");
  const NetworkResult r = adjust_network(s, options);
  const auto sigma = [&](const char* axis) {
    for (const ResultRow& row : r.rows)
      if (row.set_up == "S" && row.to == "P0" && row.detail == axis) return row.statistics.sigma;
    return 0.0;
  };
  EXPECT_NEAR(sigma("x"), 20 * options.profile.direction(20, 20, 1, true), 1e-9);
  EXPECT_NEAR(sigma("y"), options.profile.distance(20, 1), 1e-9);
  EXPECT_NEAR(sigma("z"), 20 * options.profile.zenith_angle(20, 1, true), 1e-9);
}

TEST(SecondDerivation, OneFaceCountsLessInZenithAngles) {
  const InstrumentProfile p = built_in_profile("total_station_1arcsec");
  const double both = p.zenith_angle(1000, 1, false), one = p.zenith_angle(1000, 1, true);
  const double centring = p.height_centring / 1000;
  const auto angle = [&](double sigma) { return std::sqrt(sigma * sigma - centring * centring); };
  EXPECT_NEAR(angle(one) / angle(both), std::numbers::sqrt2, 1e-6);
}

TEST(SecondDerivation, HingesAreWhatHoldsTwoPartsTogether) {
  AdjustOptions options;
  options.datum = DatumMode::inner;
  const std::vector<std::tuple<std::string, std::string, double>> loop = {{"A", "B", 1}, {"B", "C", 1}, {"A", "C", 2}};
  auto joined = loop;
  joined.insert(joined.end(), {{"C", "D", 1}, {"D", "E", 1}, {"C", "E", 2}});
  EXPECT_NE(all_words(adjust_network(levelling(joined), options)).find("hangs on C"), std::string::npos);
  auto dead_end = loop;
  dead_end.push_back({"C", "D", 1});
  EXPECT_EQ(all_words(adjust_network(levelling(dead_end), options)).find("hangs on"), std::string::npos);
  EXPECT_EQ(all_words(adjust_network(levelling(loop), options)).find("hangs on"), std::string::npos);
}

TEST(SecondDerivation, WeightedControlHasThePrecisionItIsGiven) {
  const auto n = test::simulate({}, 55);
  ControlPoints control;
  for (int i = 0; i < 3; ++i) control.ids.push_back(n.survey.points[i].id);
  control.coordinates.resize(9);
  for (int i = 0; i < 3; ++i) control.coordinates.segment<3>(3 * i) = n.truth[i];
  control.covariance = 1e-10 * Eigen::MatrixXd::Identity(9, 9);  // 0.01 mm
  AdjustOptions options = free_network();
  options.datum = DatumMode::weighted;
  const NetworkResult r = adjust_network(n.survey, options, control);
  for (const ResultRow& row : r.rows)
    if (row.kind == "coordinate") {
      EXPECT_NEAR(row.statistics.sigma, std::sqrt(1e-10 + 1e-12), 1e-12) << "a micrometre makes it invertible";
    }
}

// Optional unknowns: what was planted is found where the network can tell it, and nothing is shown where it cannot.

test::SimulatedNetwork held_markers(std::uint64_t seed, double noise = 1) {
  test::SimulationSettings settings;
  settings.noise = noise;
  auto n = test::simulate(settings, seed);
  for (size_t i = 0; i < 12; ++i) n.survey.points[i].roles.fill(CoordinateRole::fixed);
  return n;
}

void expect_parameter(const NetworkResult& r, const std::string& name, double value) {
  ASSERT_EQ(r.parameters.size(), 1u) << all_words(r);
  EXPECT_EQ(r.parameters[0].name, name);
  EXPECT_NEAR(r.parameters[0].value, value, 4 * r.parameters[0].sigma);
  EXPECT_GT(std::abs(value), 5 * r.parameters[0].sigma) << "the test would not see a zero";
}

void expect_absent(const NetworkResult& r, const std::string& name) {
  EXPECT_TRUE(r.parameters.empty());
  EXPECT_NE(all_words(r).find(name + " cannot be told"), std::string::npos) << all_words(r);
}

TEST(OptionalUnknowns, Scale) {
  auto n = held_markers(61);
  for (Observation& o : n.survey.observations)
    if (o.kind == ObservationKind::slope_distance) o.value *= 1 + 5e-4;
  AdjustOptions options = held();
  options.scale_sigma = 1e-3;
  expect_parameter(adjust_network(n.survey, options), "scale", 5e-4);
  test::SimulationSettings noisy;
  noisy.noise = 10;
  options.datum = DatumMode::inner;
  for (const Switch scaled : {Switch::off, Switch::on}) {  // sigma0 10 makes every sigma and the prior ten times larger
    options.scale_with_sigma0 = scaled;
    expect_absent(adjust_network(test::simulate(noisy, 61).survey, options), "scale");
  }
}

TEST(OptionalUnknowns, AdditiveConstant) {
  auto n = held_markers(62);
  for (Observation& o : n.survey.observations)
    if (o.kind == ObservationKind::slope_distance) o.value += 0.008;
  AdjustOptions options = held();
  options.additive_constant_sigma = 0.02;
  expect_parameter(adjust_network(n.survey, options), "additive constant", 0.008);
  options.additive_constant_sigma = 1e-5;  // a prior no network can add to
  expect_absent(adjust_network(test::simulate({}, 62).survey, options), "additive constant");
}

TEST(OptionalUnknowns, VerticalIndex) {
  auto n = held_markers(63);
  for (Observation& o : n.survey.observations)
    if (o.kind == ObservationKind::zenith_angle) o.value += 2e-4;
  AdjustOptions options = held();
  options.vertical_index_sigma = 1e-3;
  expect_parameter(adjust_network(n.survey, options), "vertical index", 2e-4);
  options.vertical_index_sigma = 1e-8;
  expect_absent(adjust_network(test::simulate({}, 63).survey, options), "vertical index");
}

/// Stations far apart that sight each other.
SurveyObservations long_sights(double size) {
  SurveyLayout layout;
  layout.points = {{"A", {0, 0, 100}}, {"B", {size, 0, 110}}, {"C", {0, size, 90}}, {"D", {size, size, 105}}};
  for (const SimulatedPoint& p : layout.points) {
    SimulatedSetUp s;
    s.id = s.station = p.id;
    s.instrument_height = 1.6;
    for (const SimulatedPoint& q : layout.points)
      if (q.id != p.id) s.sees.push_back(q.id);
    layout.set_ups.push_back(s);
  }
  SimulationOptions simulation;
  simulation.profile = built_in_profile("total_station_1arcsec");
  simulation.coordinates = true;
  SurveyObservations survey = simulate_survey(layout, simulation, 64);
  for (Point& p : survey.points) p.roles.fill(CoordinateRole::fixed);
  survey.points[3].roles.fill(CoordinateRole::free);
  return survey;
}

TEST(OptionalUnknowns, Refraction) {
  AdjustOptions options;
  options.curvature = Switch::on;
  options.refraction_coefficient = 0.6;  // wrong by far; the sights were bent by 0.13
  options.refraction_sigma = 1;
  expect_parameter(adjust_network(long_sights(900), options), "refraction coefficient", 0.13);
  options.refraction_sigma = 0.01;
  expect_absent(adjust_network(long_sights(30), options), "refraction coefficient");
}

TEST(OptionalUnknowns, Tilts) {
  auto n = held_markers(65, 0);  // without noise: sigma of a tilt here is 4e-5, a seventh of what is planted
  // The instrument of the first set-up leans: what it takes for vertical is turned about east.
  const double lean = 3e-4;
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitX()).toRotationMatrix();
  for (Observation& o : n.survey.observations) {
    if (o.set_up != 0) continue;
    const auto marker =
        std::find_if(n.survey.points.begin(), n.survey.points.end(), [&](const auto& p) { return p.id == o.to; });
    const Eigen::Vector3d d = n.truth[marker - n.survey.points.begin()] - n.truth[12];
    const Eigen::Vector3d seen = turned.transpose() * d;
    if (o.kind == ObservationKind::direction) o.value += std::atan2(seen.x(), seen.y()) - std::atan2(d.x(), d.y());
    if (o.kind == ObservationKind::zenith_angle)
      o.value += std::atan2(seen.head<2>().norm(), seen.z()) - std::atan2(d.head<2>().norm(), d.z());
  }
  AdjustOptions options = held();
  options.tilt_sigma = 1;  // a prior that pulls nothing
  const NetworkResult r = adjust_network(n.survey, options);
  constexpr double kSecondOrder = 3e-7;  // lean squared times tan(elevation)
  EXPECT_NEAR(r.set_ups[0].tilt[0], lean, kSecondOrder);
  EXPECT_NEAR(r.set_ups[0].tilt[1], 0, kSecondOrder);
  EXPECT_NEAR(r.set_ups[1].tilt[0], 0, kSecondOrder);
  EXPECT_LT(r.sigma0, 0.01);
  options.tilt_sigma = 1e-8;
  EXPECT_TRUE(std::isnan(adjust_network(test::simulate({}, 65).survey, options).set_ups[0].tilt[0]));
}

TEST(OptionalUnknowns, InstrumentHeights) {
  auto n = held_markers(66);
  n.survey.points[12].roles.fill(CoordinateRole::fixed);  // S1 stands on a known point
  n.survey.set_ups[0].instrument_height = 0.03;           // in truth 0
  n.survey.set_ups[1].instrument_height = 0.03;           // of a free station: nothing can tell
  AdjustOptions options = held();
  options.instrument_height_sigma = 0.05;
  const NetworkResult r = adjust_network(n.survey, options);
  EXPECT_NEAR(r.set_ups[0].instrument_height_correction, -0.03, 0.002);
  EXPECT_TRUE(std::isnan(r.set_ups[1].instrument_height_correction));
}

}  // namespace test_second_derivation
}  // namespace plumbline::survey
