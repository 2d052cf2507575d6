// Field books of other makers. One geometry in all of them: from K (1000, 2000, 100; instrument 1.5 m) to A (1030,
// 2040, 101) and B (960, 2030, 99), targets at 1.3 m; azimuth = circle + 10 degrees.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "survey/files/field_books.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/starnet.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/survey_format.hpp"
#include "survey/files/zeiss.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_field_books {

using namespace test_help;
using enum ObservationKind;

constexpr double kSecond = std::numbers::pi / 180 / 3600;
const Eigen::Vector3d kA(1030, 2040, 101), kB(960, 2030, 99);

/// Where the pointing leads by what the file says of station, orientation and heights.
Eigen::Vector3d place_of(const SurveyObservations& s, int pointing) {
  const Observation& d = observation(s, pointing, direction);
  const SetUp& set_up = s.set_ups.at(d.set_up);
  const double azimuth = d.value + set_up.stated_orientation, z = value(s, pointing, zenith_angle),
               length = value(s, pointing, slope_distance);
  const Eigen::Vector3d at(length * std::sin(z) * std::sin(azimuth), length * std::sin(z) * std::cos(azimuth),
                           length * std::cos(z));
  return point(s, set_up.station).coordinates + at + Eigen::Vector3d(0, 0, set_up.instrument_height - d.target_height);
}

void expect_at(const Eigen::Vector3d& found, const Eigen::Vector3d& expected) {
  EXPECT_LT((found - expected).norm(), 2e-3) << found.transpose();
}

TEST(Nikon, ReadsStationsSightingsAndBothFaces) {
  const auto s = read_nikon(fixture("nikon.raw"), "n.raw");
  ASSERT_EQ(s.set_ups.size(), 1u);
  EXPECT_DOUBLE_EQ(s.set_ups[0].instrument_height, 1.5);
  expect_at(place_of(s, 0), kA);
  EXPECT_EQ(observation(s, 1, direction).face, 2);
  expect_at(place_of(s, 2), kB);
  EXPECT_EQ(point(s, "B").code, "bolt");
  EXPECT_EQ(point(s, "K").coordinates, Eigen::Vector3d(1000, 2000, 100)) << "ENZ";
  EXPECT_TRUE(skipped(s, 14, 1, "a record CO, ST"));
  EXPECT_EQ(s.observations.size(), 9u) << "SO and '*SS' are no sightings";
}

TEST(Nikon, AControlPointIsASightingWithASecondName) {
  const auto s = read_nikon(
      "CO,Dist Units: Metres\nCO,Angle Units: "
      "DDDMMSS\nST,S,,A,,1.5,0.0000,0.0000\nCP,P9,,2.000,150.000,270.0000,90.0000,"
      "08:31:00,POL\n",
      "c.raw");
  EXPECT_NEAR(value(s, 0, direction), 270 * kDegree, 1e-12);
  EXPECT_DOUBLE_EQ(value(s, 0, slope_distance), 150);
  EXPECT_DOUBLE_EQ(observation(s, 0, direction).target_height, 2);
  EXPECT_TRUE(s.skipped.empty());
}

TEST(Nikon, AzimuthsMayCountFromTheSouth) {
  const auto read = [](const std::string& origin) {
    return read_nikon("CO,Dist Units: Metres\nCO,Angle Units: DDDMMSS\nCO,Zero azimuth: " + origin +
                          "\nST,S,,A,,1.5,31.0000,0.0000\nSS,P,1.5,100.0,10.0000,90.0000,08:31:00,\n",
                      "z.raw");
  };
  EXPECT_NEAR(read("North").set_ups.at(0).stated_orientation, 31 * kDegree, 1e-9);
  EXPECT_NEAR(read("South").set_ups.at(0).stated_orientation, 211 * kDegree, 1e-9);
  EXPECT_TRUE(skipped(read("Magnetic"), 3, 1, "North or South"));
}

/// Another unit taken for one that is not known is a point in another place.
TEST(FieldBooks, AUnitThatNobodyKnowsIsNotAnother) {
  const std::string seen = "ST,S,,,,1.5,0.0000,0.0000\nSS,P,1.5,100.0,10.0000,90.0000,08:31:00,\n";
  EXPECT_TRUE(
      skipped(read_nikon("CO,Dist Units: Chains\nCO,Angle Units: Gons\n" + seen, "n.raw"), 1, 1, "Metres, Feet"));
  EXPECT_TRUE(skipped(read_nikon("CO,Dist Units: Metres\nCO,Angle Units: Points\n" + seen, "n.raw"), 2, 1, "DDDMMSS"));
  const std::string gts7 = fixture("topcon.gts7");
  const std::size_t units = gts7.find("UNITS");
  const auto with_units = [&](const std::string& text) {
    return std::string(gts7).replace(units, gts7.find('\n', units) - units, "UNITS   " + text);
  };
  const int line =
      static_cast<int>(std::count(gts7.begin(), gts7.begin() + static_cast<std::ptrdiff_t>(units), '\n')) + 1;
  EXPECT_TRUE(skipped(read_topcon_gts7(with_units("M,M"), "t.gts7"), line, 1, "of angles"));
  EXPECT_TRUE(skipped(read_topcon_gts7(with_units("C,D"), "t.gts7"), line, 1, "of lengths"));
  EXPECT_TRUE(skipped(read_geodimeter("23=1312\n2=K\n5=B\n7=33.99\n8=99.99\n9=50\n", "g.job"), 1, 1, "second digit"));
}

/// Once the known station moved by 20 mm, and every detail point with it.
TEST(FieldBooks, WhatIsKeyedInOfStationAndBacksightIsKnown) {
  const std::array<bool, 3> all{true, true, true}, none{};
  const auto gts7 = read_topcon_gts7(
      "TopSURV v1\nUNITS   M,G\nSTN     S,1.5,\nXYZ     5000,1000,100\nBKB     B,0.0,0.0\nXYZ     5000,1100,100\n"
      "BS      B,1.5\nSD      0.0,100.0,100.04\nSS      P,1.5,\nSD      50.0,100.0,50.0\nXYZ     5035,1035,100\n",
      "k.gts7");
  const auto job = read_geodimeter(
      "23=1112\n5=S\n37=1000\n38=5000\n39=100\n5=B\n37=1100\n38=5000\n39=100\n2=S\n3=1.5\n62=B\n21=0\n"
      "5=B\n6=1.5\n7=0\n8=100\n9=100.04\n5=P\n6=1.5\n7=50\n8=100\n9=50\n37=1035\n38=5035\n39=100\n",
      "k.job");
  for (const SurveyObservations& s : {gts7, job}) {
    EXPECT_EQ(point(s, "S").known, all) << s.info.format;
    EXPECT_EQ(point(s, "B").known, all) << s.info.format;
    EXPECT_EQ(point(s, "P").known, none) << "it came out: " << s.info.format;
  }
  // A free station has what came out of its sights.
  const auto free_gts7 = read_topcon_gts7(
      "TopSURV v1\nUNITS   M,G\nSTN     S,1.5,\nXYZ     5000,1000,100\nSS      P,1.5,\nSD      50.0,100.0,50.0\n",
      "f.gts7");
  const auto free_job =
      read_geodimeter("23=1112\n2=S\n37=1000\n38=5000\n39=100\n3=1.5\n5=P\n6=1.5\n7=50\n8=100\n9=50\n", "f.job");
  for (const SurveyObservations& s : {free_gts7, free_job}) EXPECT_EQ(point(s, "S").known, none) << s.info.format;
}

TEST(Zeiss, ABacksightMayStandBehindItsStation) {
  const std::string station =
      "For M5|Adr 00001|TI   KN STAT                   |                      |                      |               "
      "       | \nFor M5|Adr 00002|PI1           S            S100|Y         5000.000 m  |X         1000.000 m  |Z     "
      "  "
      "   100.000 m  | \n";
  const std::string sight =
      "For M5|Adr 00003|PI1           A            B101|SD       100.0400 m  |Hz         0.0000 gon|V1       100.0000 "
      "gon| \n";
  const auto s = read_zeiss(station + sight, "b.m5");
  EXPECT_EQ(s.observations.size(), 3u);
  EXPECT_EQ(point(s, "S100").known, (std::array<bool, 3>{true, true, true}));
  const std::string begun = station.substr(0, station.find('\n') + 1);
  EXPECT_TRUE(skipped(read_zeiss(station + sight + begun + sight, "b.m5"), 5, 1, "a station (code S)"));
}

TEST(Nikon, TheSecondFaceHasTheTargetHeightOfTheFirst) {
  const auto s = read_nikon(
      "CO,Dist Units: Metres\nCO,Angle Units: Gons\nCO,Zero VA: Horizon\nST,S1,,,,1.500,0.0000,0.0000\n"
      "SS,A,1.600,10.000,50.0000,1.2345,10:00:00,\nF2,A,,10.002,250.0000,198.7655,10:00:30\n"
      "F2,B,,20.000,-10.0000,398.0000,10:01:00,\n",
      "n.raw");
  EXPECT_EQ(observation(s, 1, ObservationKind::slope_distance).target_height, 1.6);
  EXPECT_TRUE(std::isnan(observation(s, 2, ObservationKind::slope_distance).target_height)) << "another target";
}

TEST(Nikon, ABacksightReadBeforeItsAzimuthWasSetIsASetUpOfItsOwn) {
  const auto s = read_nikon(
      "CO,Dist Units: Metres\nCO,Angle Units: Gons\nST,S,,A,,1.2,100.0000,100.0000\nF1,A,1.3,50.0,30.0000,99.0,\n"
      "SS,P,1.3,20.0,150.0000,98.0,\nSS,Q,1.3,20.0,160.0000,98.0,\n",
      "r.raw");
  ASSERT_EQ(s.set_ups.size(), 2u);
  EXPECT_NEAR(s.set_ups[0].stated_orientation, 70 * kGon, 1e-12);
  EXPECT_NEAR(s.set_ups[1].stated_orientation, 0, 1e-12);
  EXPECT_EQ(observation(s, 1, direction).set_up, observation(s, 2, direction).set_up);
}

TEST(Topcon, ReadsGts7) {
  const auto s = read_topcon_gts7(fixture("topcon.gts7"), "t.gts7");
  expect_at(place_of(s, 0), kA);
  expect_at(place_of(s, 1), kB);
  EXPECT_NEAR(value(s, 2, zenith_angle), (89 + 59.0 / 60 + 50.0 / 3600) * kDegree, kSecond);
  EXPECT_DOUBLE_EQ(value(s, 3, horizontal_distance), 10);
  EXPECT_TRUE(s.skipped.empty());
}

TEST(Topcon, ReadsGts210AndTakesOffCheckSums) {
  const std::string one = fixture("topcon.210");
  const auto s = read_topcon_gts210(one, "t.210");
  point(s, "K");
  for (const auto& [pointing, expected] : {std::pair{0, kA}, {1, kB}}) {
    const Observation& d = observation(s, pointing, direction);
    EXPECT_NEAR(d.value,
                std::fmod(std::atan2(expected.x() - 1000, expected.y() - 2000) - 10 * kDegree + 4 * std::numbers::pi,
                          2 * std::numbers::pi),
                2 * kSecond);
    EXPECT_NEAR(value(s, pointing, slope_distance), pointing == 0 ? 50.006 : 50.014, 1e-9);
    EXPECT_DOUBLE_EQ(d.target_height, 1.3);
  }
  EXPECT_EQ(point(s, "B").code, "bolt");
  ASSERT_EQ(s.skipped.size(), 1u) << "another mode than slope distances";
  const std::string lines = one.substr(0, 100) + "0048\r\n" + one.substr(100) + "1081\r\n";
  EXPECT_EQ(read_topcon_gts210(lines, "t.210").observations.size(), s.observations.size());
  const std::string framed = "\x02" + one.substr(0, 100) + "0048\x03\r\n\x02" + one.substr(100) + "1081\x03\r\n";
  EXPECT_EQ(read_topcon_gts210(framed, "t.210").observations.size(), s.observations.size());
  EXPECT_EQ(detect_survey_format(framed, "t"), SurveyFormat::topcon_gts210);
}

TEST(Geodimeter, ReadsLabelsOfBothFaces) {
  const auto s = read_geodimeter(fixture("geodimeter.job"), "g.job");
  EXPECT_EQ(point(s, "K").coordinates, Eigen::Vector3d(1000, 2000, 100));
  EXPECT_NEAR(value(s, 0, zenith_angle), 89.083346 * kDegree, kSecond);
  EXPECT_EQ(observation(s, 1, direction).face, 2);
  EXPECT_NEAR(observation(s, 1, direction).value - value(s, 0, direction), std::numbers::pi, 1e-9);
  EXPECT_NEAR(value(s, 2, slope_distance), 50.0144, 1e-9);
  EXPECT_DOUBLE_EQ(observation(s, 2, direction).target_height, 1.3);
  EXPECT_DOUBLE_EQ(s.set_ups.at(0).instrument_height, 1.5);
  EXPECT_TRUE(skipped(s, 21, 1, "a label and a value"));
}

TEST(Geodimeter, WithoutLabel23TheReadingsShowTheirUnit) {
  const std::string gon = "2=K\n37=2000\n38=1000\n39=100\n62=A\n37=2040\n38=1030\n39=101\n21=30.9666\n3=1.5\n";
  const auto s =
      read_geodimeter(gon + "5=B\n6=1.3\n7=332.3\n8=101.5\n9=50.01\n5=C\n7=398.1250\n8=99.7\n9=10\n", "g.are");
  EXPECT_NEAR(value(s, 0, direction), 332.3 * kGon, 1e-12);
  EXPECT_TRUE(s.skipped.empty());
  ASSERT_FALSE(s.warnings.empty());
  EXPECT_NE(s.warnings[0].find("can only be in gon"), std::string::npos) << s.warnings[0];
  // The azimuth of the reference object follows from coordinates, the circle was set to label 21.
  EXPECT_NEAR(wrap_to_circle(s.set_ups.at(0).stated_orientation - std::atan2(30, 40) + 30.9666 * kGon + 1), 1, 1e-9);
  EXPECT_THROW(read_geodimeter("2=K\n5=B\n7=33.99\n8=99.99\n9=50\n", "g.are"), SurveyReadError)
      << "no D.MMSS, and nothing tells gon from degrees";
  const auto faces = read_geodimeter("2=K\n5=B\n24=33.99\n25=99.99\n17=233.99\n18=300.01\n9=50\n", "g.are");
  EXPECT_NEAR(value(faces, 0, zenith_angle), 99.99 * kGon, 1e-12) << "the faces add up to 400";
}

TEST(Idx, ATableWithinATableIsNoRowOfIt) {
  std::string text = fixture("leica.idx");
  const std::size_t end = text.find("\tEND POINTS");
  ASSERT_NE(end, std::string::npos);
  text.insert(end, "\t\tTHEMINFO(PointNo, PointID, Attribute, Value)\r\n\t\tEND THEMINFO\r\n");
  const auto s = read_idx(text, "l.idx");
  EXPECT_TRUE(s.skipped.empty());
  EXPECT_EQ(s.observations.size(), 5u);
}

TEST(Idx, ReadsTheColumnsThatTheFileNames) {
  const auto s = read_idx(fixture("leica.idx"), "l.idx");
  ASSERT_EQ(s.set_ups.size(), 1u);
  EXPECT_EQ(s.set_ups[0].station, "K");
  EXPECT_DOUBLE_EQ(s.set_ups[0].instrument_height, 1.5);
  EXPECT_NEAR(value(s, 0, slope_distance), 50.0064, 1e-9);
  EXPECT_EQ(s.observations.size(), 5u) << "a distance of zero is none";
  EXPECT_TRUE(std::isnan(point(s, "A").coordinates.x())) << "what the instrument computed is no given coordinate";
  EXPECT_DOUBLE_EQ(point(s, "K").coordinates.y(), 2000);
}

// Class FIX as KubaSzostak/coordinatus writes it for points without a height.
TEST(Idx, AHeightOfZeroOfAKnownPointIsSaidAndNotKnown) {
  std::string text = fixture("leica.idx");
  text.replace(text.find("100.0,\t\"\",\t,\tCTRL"), 17, "0.000000,\t\"\",\t,\tFIX");
  const auto s = read_idx(text, "l.idx");
  EXPECT_TRUE(point(s, "K").known[0] && point(s, "K").known[1]);
  EXPECT_FALSE(point(s, "K").known[2]);
  ASSERT_EQ(s.warnings.size(), 1u);
  EXPECT_NE(s.warnings[0].find("'K' has the height 0"), std::string::npos) << s.warnings[0];
  EXPECT_TRUE(point(read_idx(fixture("leica.idx"), "l.idx"), "K").known[2]);
}

TEST(Idx, HeightsAndPointsThatCannotBeReadAreListed) {
  std::string text = fixture("leica.idx");
  text.replace(text.find("1.500000;"), 9, "1,500 m;");
  text.insert(text.find("\tEND POINTS"), "\t\tgone\n");
  const auto s = read_idx(text, "l.idx");
  ASSERT_EQ(s.skipped.size(), 2u);
  EXPECT_EQ(s.skipped[0].found, "'gone'");
  EXPECT_EQ(s.skipped[1].found, "'1,500 m'");
  EXPECT_TRUE(std::isnan(s.set_ups[0].instrument_height));
}

TEST(Zeiss, ReadsATotalStation) {
  const auto s = read_zeiss(fixture("elta.m5"), "e.m5");
  ASSERT_EQ(s.set_ups.size(), 2u) << "before and after the circle was oriented";
  EXPECT_NEAR(s.set_ups[0].stated_orientation, 10 * kDegree, 1e-12);
  expect_at(place_of(s, 1), kA);
  expect_at(place_of(s, 2), kB);
  EXPECT_NEAR(value(s, 0, direction) + 10 * kDegree, value(s, 1, direction), kSecond);
  EXPECT_TRUE(skipped(s, 10, 1, "a record 'For M5|"));
}

TEST(Zeiss, ReadsTheShortRecordsOfR4) {
  const auto s = read_zeiss(
      "For R4|KR A     0|X        1.000 m   |Y        2.000 m   |                   |\n"
      "For R4|KR NTR1100|X       21.259 m   |Y       59.620 m   |Z       11.256 m   |\n",
      "a.r4");
  EXPECT_EQ(point(s, "1100").coordinates, Eigen::Vector3d(59.620, 21.259, 11.256)) << "X north, Y east";
}

TEST(FieldBooks, RefuseWhatIsNone) {
  const std::string nothing = "Dear all,\nplease find attached\n";
  EXPECT_NE(error_of([&] { read_nikon(nothing, "x"); }).find("x:1:1"), std::string::npos);
  EXPECT_NE(error_of([&] { read_topcon_gts7(nothing, "x"); }).find("x:1:1"), std::string::npos);
  EXPECT_NE(error_of([&] { read_topcon_gts210(nothing, "x"); }).find("x"), std::string::npos);
  EXPECT_NE(error_of([&] { read_geodimeter(nothing, "x"); }).find("x:1:1"), std::string::npos);
  EXPECT_NE(error_of([&] { read_topcon_level(nothing, "x"); }).find("x"), std::string::npos);
  EXPECT_NE(error_of([&] { read_idx(nothing, "x"); }).find("x"), std::string::npos);
  EXPECT_NE(error_of([&] { read_zeiss(nothing, "x"); }).find("x:1:1"), std::string::npos);
  EXPECT_NE(error_of([&] { read_starnet(nothing, "x"); }).find("x:1:1"), std::string::npos);
}

}  // namespace test_field_books
}  // namespace plumbline::survey
