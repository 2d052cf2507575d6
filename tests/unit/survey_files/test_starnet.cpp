// STAR*NET: what a word of a line is for, and that no word is swallowed.
#include <gtest/gtest.h>

#include "survey/files/starnet.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_starnet {

using namespace test_help;
using enum ObservationKind;

TEST(StarNetUnits, AreSaidWhereTheFileHasNoneAndRefusedWhereTheyAreTheProjects) {
  const std::string job = ".ORDER EN ATFROMTO\nC A 0 0 0 ! ! !\nD A-B 100\n";
  const auto without = read_starnet(job, "u.dat");
  ASSERT_EQ(without.warnings.size(), 1u);
  EXPECT_NE(without.warnings[0].find("no .UNITS: metres"), std::string::npos) << without.warnings[0];
  EXPECT_TRUE(read_starnet(".UNITS Meters DMS\n" + job, "u.dat").warnings.empty());
  EXPECT_TRUE(skipped(read_starnet(".UNITS FeetUS\n.UNITS\n" + job, "u.dat"), 2, 1, "those of the project"));
  const std::string vector = "G1 A-B 100 200 50\nG2 1 1 1\n";
  EXPECT_TRUE(skipped(read_starnet(".UNITS FeetUS DMS\n" + vector + job, "v.dat"), 2, 1, "a job in metres"));
  EXPECT_EQ(read_starnet(".UNITS Meters DMS\n" + vector, "v.dat").vectors.size(), 1u);
}

/// As the manual's sample traverses count them.
TEST(StarNetAngles, AgainstTheClockAreNegative) {
  const auto s = read_starnet(".2D\nA 3-2-4 -102-34-12.5\nA 3-2-5 257-25-47.5\n", "a.dat");
  ASSERT_EQ(s.observations.size(), 2u);
  EXPECT_NEAR(s.observations[0].value, s.observations[1].value, 1e-12);
  EXPECT_TRUE(s.skipped.empty());
  EXPECT_TRUE(skipped(read_starnet("V A-B -5-00-00\nV A-C 85-00-00\n", "v.dat"), 1, 1, "an angle"))
      << "no zenith angle is";
}

TEST(StarNetTraverse, ABearingInPlaceOfABacksightIsNoPoint) {
  EXPECT_TRUE(skipped(read_starnet(".2D\nTB S30-42-15W\nT 1 90-00-00 274.00\nTE 2\nD 1-3 100\n", "t.dat"), 2, 1,
                      "the name of a backsight"));
}

/// L with a length and a standard deviation, as in the levelling job of a public repository (lines 42 and 43).
TEST(StarNetLevelling, AStandardDeviationBehindTheLengthCounts) {
  const auto s = read_starnet(
      "L PEAT-TIMS -15.978460 429.940 0.000393405\nL A-B 1.0 250\nL B-C 1.0 300 &\nL C-D 1 2 *\n", "l.dat");
  ASSERT_EQ(s.observations.size(), 3u) << "'*' takes no part";
  EXPECT_DOUBLE_EQ(s.observations[0].levelling_length, 429.94);
  EXPECT_DOUBLE_EQ(s.observations[0].sigma, 0.000393405);
  EXPECT_TRUE(std::isnan(s.observations[1].sigma));
  EXPECT_TRUE(std::isnan(s.observations[2].sigma));
}

TEST(StarNetLevelling, ALoneNumberThatIsNoLengthIsSaid) {
  const auto s = read_starnet("L A-B 1.0 0.001\n", "l.dat");
  EXPECT_DOUBLE_EQ(s.observations.at(0).sigma, 0.001);
  ASSERT_EQ(s.warnings.size(), 1u);
  EXPECT_NE(s.warnings[0].find("is no length"), std::string::npos) << s.warnings[0];
}

TEST(StarNetLevelling, TheWeightOfLinesIsPerRootOfAKilometreOrMile) {
  const auto metric = read_starnet(".LWEIGHT 0.0015\nL A-B 1.0 250\nL B-C 1 250 0.01\n", "l.dat");
  EXPECT_NEAR(metric.observations.at(0).sigma, 0.00075, 1e-12);
  EXPECT_DOUBLE_EQ(metric.observations.at(1).sigma, 0.01);
  const auto feet = read_starnet(".UNITS Feet\n.LWEIGHT 0.01\nL A-B 1.0 1320\n", "l.dat");
  EXPECT_NEAR(feet.observations.at(0).sigma, 0.005 * 0.3048, 1e-12);
}

TEST(StarNetCoordinates, OfThePlaneTheThirdNumberIsAStandardDeviation) {
  const auto s =
      read_starnet(".2D\n.ORDER EN\nC A 1000 1000 ! !\nC B 1100 1000 0.002 0.003\nD A-B 100.03 0.01\n", "c.dat");
  ASSERT_EQ(s.coordinates.size(), 1u);
  ASSERT_EQ(s.coordinates[0].components.size(), 2u);
  EXPECT_NEAR(s.coordinates[0].covariance(0, 0), 4e-6, 1e-18);
  EXPECT_NEAR(s.coordinates[0].covariance(1, 1), 9e-6, 1e-18);
  EXPECT_TRUE(std::isnan(point(s, "B").coordinates.z()));
  EXPECT_TRUE(s.skipped.empty());
}

TEST(StarNetCoordinates, FourNumbersWithoutADimensionMayBeEither) {
  const std::string line = "C B 1100 1000 0.002 0.003\n";
  EXPECT_TRUE(skipped(read_starnet("C A 1000 1000 ! !\n" + line, "c.dat"), 2, 1, "'.2D' or '.3D'"));
  EXPECT_EQ(point(read_starnet(".3D\n" + line, "c.dat"), "B").coordinates.z(), 0.002);
}

TEST(StarNetFlags, MayStandWithoutBlanks) {
  const auto s = read_starnet(".3D\nC A 1000 1000 10 !!*\nC B 1100 1000 10\nDV A-B 100 90-00-00 &!\n", "c.dat");
  using enum CoordinateRole;
  EXPECT_EQ(point(s, "A").roles, (std::array{fixed, fixed, free}));
  ASSERT_EQ(s.observations.size(), 2u);
  EXPECT_TRUE(std::isnan(s.observations[0].sigma));
  EXPECT_LT(s.observations[1].sigma, 1e-5);
}

/// Sets in two faces, as a field book's converter writes them: left in face 1, the circle read two hundred gon apart.
TEST(StarNetFaces, AZenithAngleBeyondHalfACircleIsOfFaceTwo) {
  const auto s = read_starnet(
      ".3D\n.ORDER NE\nDB 101\nDM 1001 0-00-00 42.1940 81-18-56.73\nDM 1001 180-00-09.35 42.1944 278-40-59.68\n"
      "DN 102 10-00-00\nDE\nM 101-1001-102 10-00-00 50 271-00-00\n",
      "f.dat");
  ASSERT_EQ(s.observations.size(), 10u);
  for (const Observation& o : s.observations)
    EXPECT_EQ(o.face, (o.source.line == 5 && o.kind != slope_distance) || (o.source.line == 8 && o.kind == zenith_angle)
                          ? 2
                          : 0)
        << o.source.line;
}

/// A swallowed word may be a standard deviation that somebody meant.
TEST(StarNetWords, ThatNothingReadsAreErrors) {
  const std::string control = ".3D\n.ORDER EN\nC A 0 0 100 ! ! !\nC B 100 0 100 ! ! !\n";
  for (const std::string line :
       {"C P 50 50 100 * * * 0.5", "E Q 105.0 0.01 more", "L A-Q 5.0 100 0.001 garbage", "DB A B", "DE A", "TB A B",
        ".2D now", ".ORDER EN NORTH", ".DELTA PERHAPS", ".SCALE 0.9996", ".INST S9 S6"}) {
    const auto s = read_starnet(control + line + "\n", "w.dat");
    ASSERT_EQ(s.skipped.size(), 1u) << line;
    EXPECT_EQ(s.skipped[0].source.line, 5) << line;
    EXPECT_TRUE(s.observations.empty()) << line;
  }
}

/// Three side shots to one chimney from three places were three different tops: as measurements they moved the
/// stations.
TEST(StarNetFlags, WhatIsFreedTakesNoPartAndIsSaid) {
  const auto survey = read_starnet(
      ".3D\n.ORDER NE\nC A 0 0 0 ! ! !\nC B 10 0 0\nDB A\nDM B 0-00-00 10.0 90-00-00 &&* 1.5/1.5\nDN B 0-00-00 &\nDE\n",
      "f");
  EXPECT_EQ(survey.observations.size(), 3u) << "without the zenith angle";
  ASSERT_FALSE(survey.warnings.empty());
  EXPECT_TRUE(survey.warnings.front().starts_with("1 values are freed by '*'")) << survey.warnings.front();
}

/// With ON the centring of the instrument is added to what is written, not to what is held or left to it.
TEST(StarNetOptions, CentringIsAddedToWhatIsWrittenWhereTheFileSaysSo) {
  const std::string lines =
      "C A 0 0 0 ! ! !\nC B 4 3 12 ! ! !\nC P 9 9 1\nD A-B 13.0000 0.010\nD A-P 12.8 &\nD B-P 12.8 !\nL A-B 12 0.1 "
      "0.001\n";
  const auto added = [&](const std::string& option) {
    const auto survey = read_starnet(".3D\n" + option + "\n" + lines, "f");
    EXPECT_TRUE(survey.skipped.empty()) << option;
    std::string flags;
    for (const Observation& o : survey.observations) flags += o.without_centring ? '1' : '0';
    return flags;
  };
  for (const char* on : {".ADDC ON", ".ADDC", ".ADDCENTERING ON"}) EXPECT_EQ(added(on), "1000") << on;
  for (const char* off : {".ADDC OFF", ".ADDCENTERING OFF", ""}) EXPECT_EQ(added(off), "0000") << off;
  const auto wrong = read_starnet(".3D\n.ADDC SOMETIMES\n" + lines, "f");
  ASSERT_EQ(wrong.skipped.size(), 1u);
  EXPECT_EQ(wrong.skipped[0].expected, ".ADDCENTERING ON or .ADDCENTERING OFF");
}

TEST(StarNetOptions, CentringThatIsAddedIsWrittenAndReadAgain) {
  const auto survey = read_starnet(".3D\n.ADDC ON\nC A 0 0 0 ! ! !\nC B 4 3 12 ! ! !\nD A-B 13.0000 0.010\n", "f");
  const std::string text = write_starnet(survey);
  EXPECT_NE(text.find(".ADDCENTERING ON"), std::string::npos) << text;
  const auto back = read_starnet(text, "g");
  ASSERT_EQ(back.observations.size(), 1u);
  EXPECT_TRUE(back.observations[0].without_centring);
  auto both =
      read_starnet(".3D\nC A 0 0 0 ! ! !\nC B 4 3 12 ! ! !\nD A-B 13.0 0.010\n.ADDC ON\nD A-B 13.0 0.010\n", "f");
  EXPECT_THROW(write_starnet(both), std::runtime_error);
}

TEST(StarNetSideShots, PlaceAPointAndTakeNoPart) {
  const auto s = read_starnet(
      ".3D\n.ORDER EN\nC A 0 0 100 ! ! !\nC B 100 0 100 ! ! !\nM A-B-P 315-00-00 70.7107 90-00-00\nSS A-B-Q 300-00-00 "
      "50 "
      "90-00-00\nSS B-A-Q 60-00-00 60 89-00-00\nSS B-A-P 45-00-00 71 90-00-00\n",
      "s.dat");
  EXPECT_EQ(s.observations.size(), 6u) << "the measurement, and the first side shot to Q";
  ASSERT_FALSE(s.warnings.empty());
  EXPECT_NE(s.warnings[0].find("2 side shots (SS)"), std::string::npos) << s.warnings[0];
}

TEST(StarNetVectors, AreTakenWithTheirCovarianceAndFactors) {
  const std::string head = ".3D\nC A 0 0 100 ! ! !\nC B 100 0 100\n.GPS WEIGHT COVARIANCE\n.GPS FACTOR 2 VERT 1.5\n";
  const auto s = read_starnet(head + "G0 'one\nG1 A-B 10 20 30\nG2 4e-6 9e-6 1.6e-5\nG3 1e-6 -2e-6 3e-6\n", "g.dat");
  ASSERT_EQ(s.vectors.size(), 1u);
  EXPECT_TRUE(s.vectors[0].is_geocentric);
  EXPECT_EQ(s.vectors[0].horizontal_factor, 2);
  EXPECT_EQ(s.vectors[0].vertical_factor, 1.5);
  EXPECT_EQ(s.vectors[0].covariance(0, 2), -2e-6);
  EXPECT_EQ(s.vectors[0].values, Eigen::Vector3d(10, 20, 30));
  EXPECT_TRUE(s.skipped.empty());
  for (const std::string bad :
       {"G1 A-B 10 20 30\n", "G1 A-B 10 20 30\nG2 4e-6 9e-6 1e-6\nG3 9e-6 0 0\n", "G2 1 1 1\n", ".GPS USE VERT\n"})
    EXPECT_EQ(read_starnet(head + bad + "D A-B 100\n", "g.dat").skipped.size(), 1u) << bad;
}

TEST(StarNetInstruments, AreThoseOfTheReadingsBehindThem) {
  const auto s = read_starnet(
      ".3D\nC A 0 0 100 ! ! !\nC B 100 0 100\nD A-B 100\n.INST S9\t#SET 1\nD A-B 100\n.INST SX12\nDB A\nDN B "
      "0-0-0\nDE\n"
      ".INST S9\nL A-B 0 100\n",
      "i.dat");
  EXPECT_EQ(s.instruments, (std::vector<std::string>{"S9", "SX12"}));
  std::vector<int> of;
  for (const Observation& o : s.observations) of.push_back(o.instrument);
  EXPECT_EQ(of, (std::vector<int>{-1, 0, 1, 0}));
}

}  // namespace test_starnet
}  // namespace plumbline::survey
