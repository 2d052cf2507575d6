// The instrument stands beside its mark by one amount for all that it measures from there.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {
namespace {

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

}  // namespace
}  // namespace plumbline::survey
