// STAR*NET: coordinates, measurements, sets and traverses line by line, and what is written back. The geometry is that
// of test_field_books.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "survey/files/starnet.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_starnet_lines {

using namespace test_help;
using enum ObservationKind;

constexpr double kSecond = std::numbers::pi / 180 / 3600;
const Eigen::Vector3d kA(1030, 2040, 101);

TEST(StarNet, ReadsCoordinatesMeasurementsSetsAndTraverses) {
  const auto s = read_starnet(fixture("starnet.dat"), "s.dat");
  using enum CoordinateRole;
  EXPECT_EQ(point(s, "K").roles, (std::array{fixed, fixed, fixed}));
  EXPECT_EQ(point(s, "A").coordinates, kA);
  ASSERT_EQ(s.coordinates.size(), 1u);
  EXPECT_EQ(s.coordinates[0].components.size(), 2u) << "'*' leaves the height free";
  const auto find = [&](ObservationKind kind, int line) -> const Observation& {
    for (const Observation& o : s.observations)
      if (o.kind == kind && o.source.line == line) return o;
    throw std::runtime_error("not found");
  };
  EXPECT_NEAR(find(azimuth, 8).sigma, 5 * kSecond, 1e-12);
  EXPECT_EQ(find(angle, 9).second_to, "B");
  EXPECT_EQ(find(slope_distance, 9).to, "B");
  EXPECT_DOUBLE_EQ(find(slope_distance, 9).sigma, 0.002);
  EXPECT_DOUBLE_EQ(find(zenith_angle, 9).target_height, 1.3);
  EXPECT_TRUE(std::isnan(find(slope_distance, 10).sigma));
  EXPECT_EQ(find(direction, 12).set_up, 0);
  EXPECT_TRUE(std::isnan(find(slope_distance, 13).sigma)) << "'&' is the program's default";
  EXPECT_LT(find(zenith_angle, 13).sigma, 1e-5) << "'!' holds";
  EXPECT_DOUBLE_EQ(find(height_difference, 16).levelling_length, 250);
  EXPECT_TRUE(skipped(s, 17, 1, "an angle as"));
  EXPECT_TRUE(skipped(s, 18, 1, "G2 and G3 behind it"));
  EXPECT_EQ(find(angle, 20).from + find(angle, 20).to + find(angle, 20).second_to, "KBC");
  EXPECT_EQ(find(angle, 21).from + find(angle, 21).to + find(angle, 21).second_to, "CKA");
  EXPECT_DOUBLE_EQ(find(slope_distance, 20).instrument_height, 1.5);
  for (const Observation& o : s.observations) EXPECT_NE(o.source.line, 15) << "'*' takes no part";
}

TEST(StarNet, AnOptionOrUnitThatIsNotKnownIsRefused) {
  const std::string coordinates = "C A 1000 1000 10 ! ! !\nC B 1100 1000 10\n";
  const auto in_us_feet = read_starnet(".UNITS FeetUS, DMS\n" + coordinates + "D A-B 100 0.01\n", "s.dat");
  EXPECT_DOUBLE_EQ(in_us_feet.observations.at(0).value, 100 * 1200.0 / 3937);
  for (const std::string line : {".UNITS Chains", ".ALIAS NAMES", ".DATA MAYBE"}) {
    const auto s = read_starnet(line + "\n" + coordinates, "s.dat");
    ASSERT_EQ(s.skipped.size(), 1u) << line;
    EXPECT_TRUE(skipped(s, 1, 1, line.starts_with(".U") ? "a unit" : ".DATA"));
  }
}

TEST(StarNet, WhatDataOffTakesOutStaysOut) {
  const auto s = read_starnet(
      "C A 1000 1000 10 ! ! !\nC B 1100 1000 10\nD A-B 100 0.01\n.DATA OFF\nD A-B 107 0.01\n.UNITS Feet\n.DATA ON\n"
      "D B-A 100.01 0.01\n",
      "s.dat");
  ASSERT_EQ(s.observations.size(), 2u);
  EXPECT_EQ(s.observations[1].value, 100.01);
  EXPECT_NE(s.warnings.at(0).find("lines 4 to 7"), std::string::npos) << s.warnings.at(0);
}

/// The station of a traverse is none of a direction set: its readings would have no orientation.
TEST(StarNet, DirectionsNeedASetOfTheirOwn) {
  const auto s = read_starnet("C A 1000 1000 10 ! ! !\nTB B\nT A 90-00-00 50.1 90-00-00\nDN C 26-52-11.6\n", "s.dat");
  EXPECT_TRUE(skipped(s, 4, 1, "DB with the occupied station"));
  EXPECT_TRUE(s.observations.empty());
}

TEST(StarNet, OfARefusedLineNothingIsTaken) {
  const auto s =
      read_starnet(".3D\nC K 1000 2000 100.000! ! !\nC K 1000 200 .000 100 ! ! !\nC B 1 2 3 ! ! !\n", "s.dat");
  EXPECT_TRUE(skipped(s, 2, 1, "a standard deviation"));
  EXPECT_TRUE(skipped(s, 3, 1, "the end of the line"))
      << "the fourth number is a standard deviation, the last '!' nothing";
  EXPECT_EQ(s.points.size(), 1u);
  EXPECT_TRUE(s.coordinates.empty());
}

TEST(StarNet, AHeightWithAStandardDeviationIsControl) {
  const auto s =
      read_starnet("E A 10.5 0.002\nE B 11\nE C 12 !\nE D 13 nonsense\nL A-B 0.5 0.001\nL B-C 1 0.001\n", "s.dat");
  ASSERT_EQ(s.coordinates.size(), 1u);
  EXPECT_EQ(s.coordinates[0].components.at(0).point, "A");
  EXPECT_EQ(s.coordinates[0].values[0], 10.5);
  EXPECT_DOUBLE_EQ(s.coordinates[0].covariance(0, 0), 4e-6);
  EXPECT_EQ(s.skipped.size(), 1u);
}

TEST(StarNetWriter, ReadsBackAsItWas) {
  SurveyObservations s = read_starnet(fixture("starnet.dat"), "s.dat");
  for (Point& p : s.points)
    if (p.id == "B") p.id = "F01-B";
  for (Observation& o : s.observations)
    for (std::string* id : {&o.from, &o.to, &o.second_to})
      if (*id == "B") *id = "F01-B";
  const std::string text = write_starnet(s);
  EXPECT_NE(text.find(".SEPARATOR |"), std::string::npos) << "a name has the '-' that joins names";
  const SurveyObservations again = read_starnet(text, "again.dat");
  EXPECT_TRUE(again.skipped.empty()) << text;
  ASSERT_EQ(again.observations.size(), s.observations.size()) << text;
  ASSERT_EQ(again.set_ups.size(), s.set_ups.size());
  // Distances without a direction stand behind the set, and belong to no set-up any more.
  const auto key = [](const Observation& o) {
    return std::tuple(o.kind, o.from, o.to, o.kind == ObservationKind::angle ? o.second_to : "",
                      std::round(1e7 * o.value), std::isnan(o.sigma) ? 0 : std::round(1e9 * o.sigma));
  };
  const auto sorted = [&](SurveyObservations& survey) {
    std::sort(survey.observations.begin(), survey.observations.end(),
              [&](const Observation& a, const Observation& b) { return key(a) < key(b); });
  };
  SurveyObservations back = again;
  sorted(s);
  sorted(back);
  for (size_t i = 0; i < s.observations.size(); ++i) {
    const Observation &a = s.observations[i], &b = back.observations[i];
    SCOPED_TRACE(a.from + " " + a.to + "\n" + text);
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.from + a.to, b.from + b.to);
    EXPECT_NEAR(a.value, b.value, 1e-10);
    EXPECT_EQ(std::isnan(a.sigma), std::isnan(b.sigma));
    if (!std::isnan(a.sigma)) {
      EXPECT_NEAR(a.sigma / b.sigma, 1, 1e-9);
    }
    if (a.kind == slope_distance || a.kind == zenith_angle) {
      EXPECT_EQ(std::isnan(a.target_height) ? 0 : a.target_height, std::isnan(b.target_height) ? 0 : b.target_height);
    }
    EXPECT_EQ(std::isnan(a.levelling_length), std::isnan(b.levelling_length));
  }
  EXPECT_EQ(point(again, "K").roles, point(s, "K").roles);
  ASSERT_EQ(again.coordinates.size(), s.coordinates.size());
  EXPECT_EQ(again.coordinates[0].covariance(0, 0), s.coordinates[0].covariance(0, 0));
  Observation horizontal;
  horizontal.kind = horizontal_distance;
  horizontal.from = "K", horizontal.to = "A", horizontal.value = 12.5;
  s.observations.push_back(horizontal);
  const SurveyObservations third = read_starnet(write_starnet(s), "third.dat");
  EXPECT_EQ(third.observations.back().kind, horizontal_distance);
  s.observations.back().to = "K";
  EXPECT_THROW(write_starnet(s), std::runtime_error) << "sights its own station";
  s.observations.pop_back();
  s.points.back().id = "a b";
  s.points.back().coordinates = {1, 2, 3};
  EXPECT_THROW(write_starnet(s), std::runtime_error);
}

}  // namespace test_starnet_lines
}  // namespace plumbline::survey
