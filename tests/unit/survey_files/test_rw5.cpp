#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "survey/files/rw5.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_rw5 {

using namespace test_help;
using enum ObservationKind;

TEST(Rw5, ReadsAnglesFacesAndHeights) {
  const auto survey = read_rw5(fixture("carlson.rw5"), "c.rw5");
  EXPECT_EQ(point(survey, "K1").coordinates, Eigen::Vector3d(110, 210, 12));
  EXPECT_EQ(point(survey, "S1").description, "nail");
  EXPECT_DOUBLE_EQ(survey.set_ups.at(0).instrument_height, 1.5);
  EXPECT_NEAR(value(survey, 0, zenith_angle), 90.5 * kDegree, 1e-15);
  EXPECT_EQ(observation(survey, 1, direction).face, 2);
  EXPECT_NEAR(value(survey, 1, direction), (180 + 10 / 3600.) * kDegree, 1e-15);
  EXPECT_NEAR(value(survey, 2, direction), (55 + 5 / 60. + 52 / 3600.) * kDegree, 1e-15);
  EXPECT_TRUE(skipped(survey, 9, 24, "D.MMSS")) << "70 minutes";
  EXPECT_NEAR(value(survey, 3, direction), 350 * kDegree, 1e-14) << "angle left";
  EXPECT_NEAR(value(survey, 3, zenith_angle), 89 * kDegree, 1e-15) << "vertical angle";
  EXPECT_DOUBLE_EQ(value(survey, 3, horizontal_distance), 12.5);
  EXPECT_DOUBLE_EQ(value(survey, 4, height_difference), 0.5);
  EXPECT_DOUBLE_EQ(observation(survey, 4, direction).instrument_height, 1.51);
  EXPECT_DOUBLE_EQ(observation(survey, 4, direction).target_height, 2.0);
  // Azimuths need an orientation of their own, and a new backsight gives a new one.
  ASSERT_EQ(survey.set_ups.size(), 3u);
  EXPECT_EQ(survey.set_ups[1].id, "S1/2");
  EXPECT_EQ(observation(survey, 5, direction).set_up, 1);
  EXPECT_NEAR(value(survey, 6, direction), 225.5 * kDegree, 1e-14) << "bearing S45.30W";
  EXPECT_NEAR(value(survey, 7, direction), 190 * kDegree, 1e-14) << "deflection right";
  EXPECT_EQ(observation(survey, 7, direction).set_up, 2);
  EXPECT_TRUE(skipped(survey, 13, 35, "a number behind SD"));
  EXPECT_TRUE(skipped(survey, 18, 1, "a record"));
  ASSERT_EQ(survey.warnings.size(), 1u);
  EXPECT_NE(survey.warnings[0].find("'GPS'"), std::string::npos);
}

TEST(Rw5, ReadsARealFileInFeet) {
  PLUMBLINE_REQUIRE_DATA("survey/rw5/Leica1200.rw5");
  const auto survey = read_rw5(test::read_file(test::data_file("survey/rw5/Leica1200.rw5")), "Leica1200.rw5");
  EXPECT_EQ(survey.info.title, "MY RW5 JOB");
  ASSERT_EQ(survey.set_ups.size(), 1u);
  EXPECT_EQ(survey.set_ups[0].station, "111");
  EXPECT_DOUBLE_EQ(survey.set_ups[0].instrument_height, 5.684 * 0.3048);
  EXPECT_EQ(survey.observations.size(), 3u * 10u);
  EXPECT_NEAR(value(survey, 1, direction), (55 + 5 / 60. + 52.1 / 3600.) * kDegree, 1e-14);
  EXPECT_DOUBLE_EQ(value(survey, 1, slope_distance), 3.3566 * 0.3048);
  EXPECT_DOUBLE_EQ(observation(survey, 1, direction).instrument_height, 3.684 * 0.3048);
  EXPECT_DOUBLE_EQ(point(survey, "111").coordinates[1], 16556174.237 * 0.3048);
  EXPECT_TRUE(survey.skipped.empty());
}

// As in a traverse that a public collection has: columns of another record stand in it.
TEST(Rw5, ANegativeZenithAngleIsNoSighting) {
  const auto survey = read_rw5(
      "MO,AD0,UN1,SF1.0\nOC,OP1,N 100.0,E 100.0,EL10.0\nLS,HI1.5,HR1.6\nSS,OP1,FP2,AR10.0000,ZE90.0000,SD50.0\n"
      "FD,OP1,FP3,AR34.0000,ZE-61.5811,SD90.212,--771.241000,--\n",
      "t.rw5");
  EXPECT_EQ(survey.observations.size(), 3u);
  ASSERT_EQ(survey.skipped.size(), 1u);
  EXPECT_EQ(survey.skipped[0].source.line, 5);
  EXPECT_NE(survey.skipped[0].expected.find("a zenith angle of zero or more"), std::string::npos);
}

// The same traverse: a backsight that was set and not measured was 2.4 gon from the horizon, and no result came of it.
TEST(Rw5, ABacksightThatWasSetIsADirectionOnly) {
  const auto survey = read_rw5(
      "MO,AD0,UN1,SF1.0\nOC,OP1,N 100.0,E 100.0,EL10.0\nLS,HI1.5,HR1.6\nBD,OP1,FP2,AR0.0000,ZE90.0000,SD0.000,--\n"
      "SS,OP1,FP3,AR10.0000,ZE90.0000,SD50.0,--\n",
      "t.rw5");
  ASSERT_EQ(survey.observations.size(), 4u);
  EXPECT_EQ(survey.observations[0].kind, direction);
  EXPECT_EQ(survey.observations[1].kind, direction) << "only the backsight's zenith angle is none";
  ASSERT_FALSE(survey.warnings.empty());
  EXPECT_NE(survey.warnings[0].find("line 4: ZE90 with SD0"), std::string::npos);
}

// Of the backsight only the name is given, and its coordinates: they are its azimuth.
TEST(Rw5, ABacksightWithoutAzimuthIsAtItsCoordinates) {
  const std::string head =
      "MO,AD0,UN1,SF1.0\nSP,PN100,N 1000.0,E 5000.0,EL100.0,--\nSP,PN101,N 900.0,E 4900.0,EL99.5,--\n"
      "OC,OP100,N 1000.0,E 5000.0,EL100.0,--\nLS,HI1.5,HR1.8\n";
  const auto oriented = [&](const std::string& backsight) {
    const auto survey = read_rw5(head + backsight + "SS,OP100,FP1,AR45.1234,ZE95.0000,SD100.0,--\n", "t.rw5");
    EXPECT_EQ(survey.observations.size(), 3u);
    return survey.set_ups.at(0).stated_orientation;
  };
  EXPECT_NEAR(oriented("BK,OP100,BP101,BC0.0000\n"), 1.25 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(oriented("BK,OP100,BP101,BS200.0000,BC0.0000\n"), 200 * std::numbers::pi / 180, 1e-12)
      << "what is stated wins";
  EXPECT_TRUE(std::isnan(oriented("BK,OP100,BP102,BC0.0000\n"))) << "of a point nobody knows";
}

/// What MO says of azimuths and of the instrument is applied, or said.
TEST(Rw5, AzimuthsFromTheSouthAndAnOffsetOfTheInstrument) {
  const auto read = [](const std::string& modes) {
    return read_rw5("JB,NMx\nMO," + modes +
                        "\nSP,PN1,N 0.0,E 0.0,EL0.0\nOC,OP1,N 0.0,E 0.0,EL0.0\nBK,OP1,BP2,BS90.0000,BC0.0\n"
                        "LS,HI1.5,HR1.5\nSS,OP1,FP3,AR10.0000,ZE90.0000,SD50.0\n",
                    "s.rw5");
  };
  const auto north = read("AD0,UN1,SF1.0,EC0,EO0.0,AU0"), south = read("AD1,UN1,SF1.0,EC0,EO0.0,AU0");
  EXPECT_NEAR(north.set_ups.back().stated_orientation, std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(std::remainder(south.set_ups.back().stated_orientation + std::numbers::pi / 2, 2 * std::numbers::pi), 0,
              1e-12);
  EXPECT_TRUE(north.warnings.empty());
  const auto offset = read("AD0,UN1,SF1.0,EC0,EO30.0,AU0");
  ASSERT_EQ(offset.warnings.size(), 1u);
  EXPECT_NE(offset.warnings[0].find("EO30 is not applied"), std::string::npos) << offset.warnings[0];
  EXPECT_EQ(read("AD2,UN1,AU0").skipped.size(), 1u);
  EXPECT_EQ(read("AD0,UN1,AU7").skipped.size(), 1u);
}

/// The instrument height of the station before was taken without a word, and all points were as much too low.
TEST(Rw5, ASetUpWithoutInstrumentHeightIsTold) {
  const auto read = [](const std::string& before, const std::string& second) {
    return read_rw5(
        "JB,NMx\nMO,AD0,UN1,SF1.0,AU0\nOC,OPA,N 0.0,E 0.0,EL0.0\nLS,HI1.5,HR1.5\n"
        "SS,OPA,FP3,AR10.0000,ZE90.0000,SD50.0\nLS,HI1.5,HR1.7\nSS,OPA,FP4,AR20.0000,ZE90.0000,SD50.0\n" +
            before + "OC,OPB,N 9.0,E 0.0,EL0.0\n" + second + "SS,OPB,FP3,AR10.0000,ZE90.0000,SD50.0\n" +
            "SS,OPB,FP4,AR11.0000,ZE90.0000,SD50.0\n",
        "h.rw5");
  };
  const auto missing = read("", "");
  ASSERT_EQ(missing.warnings.size(), 1u);
  EXPECT_NE(missing.warnings[0].find("line 9: no record LS gives the instrument height of the set-up on 'B'"),
            std::string::npos)
      << missing.warnings[0];
  EXPECT_TRUE(read("LS,HI1.6,HR1.5\n", "").warnings.empty());
  EXPECT_TRUE(read("", "LS,HI1.6,HR1.5\n").warnings.empty());
}

/// "HI1,55" would be an instrument height of 1 m and a field that nobody reads.
TEST(Rw5, ADecimalCommaIsNoField) {
  const auto survey = read_rw5(
      "JB,NMx\nMO,AD0,UN1,SF1.0,AU0\nOC,OP1,N 0.0,E 0.0,EL0.0\nLS,HI1,55,HR1,60\n"
      "SS,OP1,FP3,AR10.0000,ZE90.0000,SD50.0\n",
      "c.rw5");
  ASSERT_EQ(survey.skipped.size(), 1u);
  EXPECT_EQ(survey.skipped[0].source.line, 4);
  EXPECT_EQ(survey.skipped[0].found, "'55'");
}

TEST(Rw5, OtherTextIsRefused) {
  EXPECT_NE(error_of([] { read_rw5("hello\n", "x.rw5"); }).find("x.rw5:1:1: found 'hello'"), std::string::npos);
}

TEST(Rw5, AUnitThatIsNotKnownIsRefused) {
  const auto s = read_rw5(
      "JB,NMjob\nMO,AD0,UN5,SF1.0,EC1,EO0.0,AU0\nOC,OP1,N 5000,E 5000,EL100\nSS,OP1,FP2,AR10.0,ZE90.0,SD100\n", "f");
  EXPECT_TRUE(skipped(s, 2, 1, "the unit of distances"));
}

}  // namespace test_rw5
}  // namespace plumbline::survey
