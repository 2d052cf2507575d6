// The instrument stands beside its mark by one amount for all that it measures from there.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "survey/adjust/adjust_network.hpp"
#include "survey/simulate/simulate_survey.hpp"

namespace plumbline::survey {
namespace test_centring {

constexpr double kSecond = std::numbers::pi / 180 / 3600;

/// Standard deviations of angles in a listing of STAR*NET 12 (UNDERGROUND of jeelojacko/webnet): angles 0.5", centring
/// of the instrument 0.5 mm, of targets 0, from the coordinates that the job enters.
TEST(Centring, OfAnAngleIsThatOfAListing) {
  const std::map<std::string, Eigen::Vector2d> at = {{"1000", {0.9958, 2.0623}},
                                                     {"235", {18.407659, 2.845067}},
                                                     {"1", {2.3, -2.4}},
                                                     {"2", {-19.9, -2.4}},
                                                     {"3", {-20, -2}},
                                                     {"4", {-20, 2}},
                                                     {"5", {-4, -1}},
                                                     {"6", {29, -3}},
                                                     {"2000", {-19.9, 3}}};
  InstrumentProfile p;
  p.angle_sigma = 0.5 * kSecond;
  p.instrument_centring = 0.5e-3;
  const auto seconds = [&](const char* from, const char* left, const char* right) {
    const double arms[] = {(at.at(left) - at.at(from)).norm(), (at.at(right) - at.at(from)).norm()};
    return p.angle(arms, arms, (at.at(left) - at.at(right)).norm(), 1) / kSecond;
  };
  EXPECT_NEAR(seconds("1000", "235", "1"), 21.57, 0.005);
  EXPECT_NEAR(seconds("1", "1000", "2"), 21.36, 0.005);
  EXPECT_NEAR(seconds("3", "4", "2000"), 5.21, 0.005) << "a small angle: both arms see the same error";
  EXPECT_NEAR(seconds("3", "4", "5"), 26.19, 0.005);
  EXPECT_NEAR(seconds("5", "3", "6"), 9.55, 0.005) << "a straight one: it counts twice";
}

/// A station between two fixed points 40 m apart, 4 m to the side: the angle between them, from readings of two sets.
SurveyObservations two_set_ups_on_a_mark(bool marked) {
  SurveyObservations s;
  using R = CoordinateRole;
  const auto point = [&](const std::string& id, const Eigen::Vector3d& at, R role) {
    Point& p = s.points.emplace_back();
    p.id = id, p.coordinates = at, p.roles = {role, role, role};
  };
  point("S", {4, 0, 0}, R::free), point("A", {0, 20, 0}, R::fixed), point("B", {0, -20, 0}, R::fixed);
  point("P", {30, 0, 0}, R::free);
  s.info.format = "gama-xml";
  const auto add = [&](int set_up, const std::string& from, const std::string& to, ObservationKind kind, double value) {
    Observation o;
    o.kind = kind, o.set_up = set_up, o.from = from, o.to = to, o.value = value;
    s.observations.push_back(o);
  };
  const auto sight = [&](int set_up, const std::string& from, const std::string& to) {
    const auto at = [&](const std::string& id) {
      for (const Point& p : s.points)
        if (p.id == id) return p.coordinates;
      return Eigen::Vector3d();
    };
    const Eigen::Vector3d d = at(to) - at(from);
    add(set_up, from, to, ObservationKind::direction, std::atan2(d.x(), d.y()));
    add(set_up, from, to, ObservationKind::zenith_angle, std::numbers::pi / 2);
    add(set_up, from, to, ObservationKind::slope_distance, d.norm());
  };
  s.set_ups = {{"S", "S", kNotGiven, {}, kNotGiven}, {"S/2", marked ? "S" : "T", kNotGiven, {}, kNotGiven}};
  if (!marked) point("T", {4, 0, 0}, R::free);
  for (const std::string to : {"A", "B", "P"}) sight(0, "S", to), sight(1, marked ? "S" : "T", to);
  return s;
}

double sigma_of_target(bool marked, double centring, bool per_set_up) {
  AdjustOptions options;
  options.profile.direction_sigma = options.profile.zenith_sigma = kSecond;
  options.profile.distance_constant = 0.1e-3;
  options.profile.instrument_centring = centring;
  options.centring_per_set_up = per_set_up;
  const NetworkResult r = adjust_network(two_set_ups_on_a_mark(marked), options);
  return r.sigma(r.point("P")).head<2>().norm();
}

/// Instruments over no mark have no centring: what they see of each other's targets is as good as the readings.
TEST(Centring, OfAFreeStationIsNone) {
  EXPECT_NEAR(sigma_of_target(false, 2e-3, true), sigma_of_target(false, 0, true), 1e-9);
}

TEST(Centring, OfASetUpMovesAllItsSightsTogether) {
  // All targets are seen from where the instruments are; the mark alone is uncertain.
  EXPECT_NEAR(sigma_of_target(true, 2e-3, true), sigma_of_target(false, 0, true), 2e-6);
  EXPECT_GT(sigma_of_target(true, 2e-3, false), 3 * sigma_of_target(true, 2e-3, true)) << "reading by reading";
}

/// Where a target stood in a set-up as a point of its own, tied to its mark by a vector of no length: the displacement
/// as an unknown with its prior, which the covariance of the sight eliminates.
SurveyObservations with_displaced_targets(SurveyObservations s, double horizontal, double vertical) {
  std::map<std::string, bool> known;
  for (Observation& o : s.observations) {
    const std::string stood = o.to + "@" + std::to_string(o.set_up);
    if (!known[stood]) {
      VectorGroup& g = s.vectors.emplace_back();
      g.vectors = {{o.to, stood}};
      g.values = Eigen::Vector3d::Zero();
      g.covariance = Eigen::Vector3d(horizontal, horizontal, vertical).cwiseAbs2().asDiagonal();
      for (const Point& p : std::vector<Point>(s.points))
        if (p.id == o.to) {
          s.points.push_back(p);
          s.points.back().id = stood;
          s.points.back().coordinates.x() += 2e-3 * (o.set_up + 1);  // equal ones would be placeholders
        }
      known[stood] = true;
    }
    o.to = stood;
  }
  return s;
}

TEST(Centring, OfATargetIsAnUnknownOfItsSetUp) {
  SimulationOptions simulation;
  simulation.profile = built_in_profile("total_station_2arcsec");
  simulation.sigmas = false;
  simulation.coordinates = true;
  SurveyLayout layout = facade_layout(15, 3, 5);
  for (SimulatedPoint& p : layout.points)
    if (p.id[0] == 'M') p.position.z() += 3 * (p.position.z() - 1);  // steep sights
  SurveyObservations survey = simulate_survey(layout, simulation, 5);
  for (size_t i = 0, n = survey.observations.size(); i < n; i += 3)  // read twice, not averaged
    if (i % 2 == 0) {
      Observation again = survey.observations[i];
      again.value += 1e-5, again.target_height = 1e-12;
      survey.observations.push_back(again);
    }
  AdjustOptions with, without;
  with.profile = without.profile = simulation.profile;
  with.profile.instrument_centring = without.profile.instrument_centring = 0;
  with.profile.target_centring = 1e-3, with.profile.height_centring = 0.5e-3;
  without.profile.target_centring = without.profile.height_centring = 0;
  with.datum = without.datum = DatumMode::fixed;
  with.datum_points = without.datum_points = {"M1", "M3"};
  const NetworkResult covariances = adjust_network(survey, with);
  const NetworkResult unknowns = adjust_network(with_displaced_targets(survey, 1e-3, 0.5e-3), without);
  EXPECT_EQ(covariances.degrees_of_freedom, unknowns.degrees_of_freedom);
  EXPECT_NEAR(covariances.sum_of_squares, unknowns.sum_of_squares, 1e-3 * unknowns.sum_of_squares);
  for (const ResultPoint& p : covariances.points) {
    const ResultPoint& q = unknowns.point(p.id);
    EXPECT_LT((p.position - q.position).norm(), 2e-6) << p.id;
    const Eigen::Matrix3d c = covariances.covariance(p, p), d = unknowns.covariance(q, q);
    EXPECT_LE((c - d).norm(), 2e-3 * d.norm()) << p.id;
  }
}

/// STAR*NET's M: angle, distance and zenith angle of one line share the instrument's and the target's displacement.
TEST(Centring, OfASingleLineIsSharedByItsReadings) {
  SurveyObservations s;
  s.info.format = "starnet";
  const auto point = [&](const std::string& id, const Eigen::Vector3d& at, CoordinateRole role) {
    Point& p = s.points.emplace_back();
    p.id = id, p.coordinates = at, p.roles = {role, role, role};
  };
  point("A", {0, 0, 0}, CoordinateRole::fixed), point("B", {0, 50, 0}, CoordinateRole::fixed);
  point("P", {12, 16, 15}, CoordinateRole::free);
  const auto add = [&](ObservationKind kind, const std::string& to, const std::string& second, double value) {
    Observation o;
    o.kind = kind, o.from = "A", o.to = to, o.second_to = second, o.value = value;
    o.source = {"m.dat", 7, 1};
    s.observations.push_back(o);
  };
  add(ObservationKind::angle, "B", "P", std::atan2(12.0, 16.0));
  add(ObservationKind::slope_distance, "P", "", 25);
  add(ObservationKind::zenith_angle, "P", "", std::atan2(20.0, 15.0));
  AdjustOptions o;
  o.profile.direction_sigma = o.profile.zenith_sigma = 1e-9, o.profile.distance_constant = 1e-9;
  o.profile.instrument_centring = 2e-3, o.profile.target_centring = 1e-3, o.profile.height_centring = 0.5e-3;
  const NetworkResult r = adjust_network(s, o);
  const Eigen::Matrix3d c = r.covariance(r.point("P"), r.point("P"));
  // With perfect readings P is off by the displacement of its target, and by that of the instrument less what the
  // angle to B, 50 m away, makes of it: dE (1 - 16/50) + ..., by hand.
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();  // of P by a displacement of the instrument
  const double turn = 1.0 / 50;                         // of the orientation by dE of the instrument (towards B)
  shift(0, 0) -= turn * 16, shift(1, 0) += turn * 12;
  const Eigen::Matrix3d target = Eigen::Vector3d(1e-6, 1e-6, 0.25e-6).asDiagonal();
  const Eigen::Matrix3d instrument = shift * Eigen::Vector3d(4e-6, 4e-6, 0).asDiagonal() * shift.transpose();
  Eigen::Matrix3d left = Eigen::Matrix3d::Zero();  // B's target turns P about A
  const Eigen::Vector3d across(16, -12, 0);
  left = across * across.transpose() * std::pow(1e-3 / 50, 2);
  EXPECT_LT((c - (target + instrument + left)).norm(), 1e-3 * c.norm()) << c << "\n\n" << target + instrument + left;
}

/// The instrument's own standard deviations, written out and centring added to them (STAR*NET's .ADDCENTERING ON), are
/// the instrument's: in set-ups and in single lines, as unknowns of the set-up and reading by reading.
TEST(Centring, AddedToWhatIsWrittenIsThatOfTheInstrument) {
  SimulationOptions simulation;
  simulation.profile = built_in_profile("total_station_2arcsec");
  simulation.profile.instrument_centring = 1e-3, simulation.profile.target_centring = 2e-3;
  simulation.profile.height_centring = 0.5e-3;
  simulation.sigmas = false;
  simulation.coordinates = true;
  SurveyObservations left_to_it = simulate_survey(facade_layout(12, 3, 5), simulation, 7);
  for (const char* to : {"M1", "M5"}) {  // single lines
    Observation o;
    o.kind = ObservationKind::slope_distance, o.from = "M9", o.to = to;
    const auto at = [&](const std::string& id) {
      return std::find_if(left_to_it.points.begin(), left_to_it.points.end(),
                          [&](const Point& p) { return p.id == id; })
          ->coordinates;
    };
    o.value = (at(to) - at("M9")).norm();
    left_to_it.observations.push_back(o);
  }
  AdjustOptions options, bare;
  options.profile = simulation.profile, bare.profile = simulation.profile.without_centring();
  options.datum = bare.datum = DatumMode::inner;
  SurveyObservations written = left_to_it;
  const NetworkResult own = adjust_network(left_to_it, bare);
  ASSERT_EQ(own.rows.size(), written.observations.size());
  for (size_t i = 0; i < own.rows.size(); ++i) {
    ASSERT_EQ(own.rows[i].to, written.observations[i].to);
    written.observations[i].sigma = own.rows[i].statistics.sigma;
  }
  const NetworkResult whole = adjust_network(written, options);  // as it is written: without
  for (Observation& o : written.observations) o.without_centring = true;
  for (const bool per_set_up : {true, false}) {
    options.centring_per_set_up = per_set_up;
    const NetworkResult a = adjust_network(left_to_it, options), b = adjust_network(written, options);
    EXPECT_NEAR(a.sum_of_squares, b.sum_of_squares, 1e-6 * a.sum_of_squares) << per_set_up;
    EXPECT_GT(whole.sum_of_squares, 1.05 * b.sum_of_squares) << "it matters";
    for (const ResultPoint& p : a.points)
      EXPECT_LT((a.sigma(p) - b.sigma(b.point(p.id))).norm(), 1e-6 * a.sigma(p).norm()) << p.id;
  }
}

}  // namespace test_centring
}  // namespace plumbline::survey
