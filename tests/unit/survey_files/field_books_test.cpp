// Field books of other makers. One geometry in all of them: from K (1000, 2000, 100; instrument 1.5 m) to A (1030,
// 2040, 101) and B (960, 2030, 99), targets at 1.3 m; azimuth = circle + 10 degrees.
#include "survey/files/field_books.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "survey/files/gsi.hpp"
#include "survey/files/starnet.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/survey_format.hpp"
#include "survey/files/zeiss.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace field_books_test {

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

TEST(Zeiss, ReadsADigitalLevel) {
  const auto s = read_zeiss(fixture("dini.m5"), "d.m5");
  ASSERT_EQ(s.observations.size(), 3u);
  const Observation& first = s.observations[0];
  EXPECT_EQ(first.kind, height_difference);
  EXPECT_EQ(first.from + first.to, "BM1TP1");
  EXPECT_NEAR(first.value, (1.523 + 1.5234 - 1.211 - 1.2112) / 2, 1e-9)
      << "the repeated reading replaces its forerunner";
  EXPECT_NEAR(first.levelling_length, 50, 1e-9);
  EXPECT_NEAR(s.observations[1].value, -0.2, 1e-9) << "German marks";
  EXPECT_EQ(s.observations[2].to, "IS");
  EXPECT_NEAR(s.observations[2].value, 1.5 - 2.0, 1e-9);
  EXPECT_TRUE(s.set_ups.empty());
  EXPECT_DOUBLE_EQ(point(s, "BM1").coordinates.z(), 100);
}

TEST(Zeiss, ReadsTheShortRecordsOfR4) {
  const auto s = read_zeiss(
      "For R4|KR A     0|X        1.000 m   |Y        2.000 m   |                   |\n"
      "For R4|KR NTR1100|X       21.259 m   |Y       59.620 m   |Z       11.256 m   |\n",
      "a.r4");
  EXPECT_EQ(point(s, "1100").coordinates, Eigen::Vector3d(59.620, 21.259, 11.256)) << "X north, Y east";
}

/// From B of 20 m: 1.4 m back and 1.7 m ahead is down. BFFB, then BF by the other orders.
TEST(TopconLevel, BackAndAheadAreToldByTheNamesAndProvedByTheHeights) {
  const auto s = read_topcon_level(fixture("topcon_level.dat"), "t.dat");
  ASSERT_EQ(s.observations.size(), 4u);
  const auto is = [&](size_t i, const char* from, const char* to, double value, double length) {
    const Observation& o = s.observations[i];
    EXPECT_EQ(o.kind, ObservationKind::height_difference);
    EXPECT_EQ(o.from + ">" + o.to, std::string(from) + ">" + to);
    EXPECT_NEAR(o.value, value, 1e-12);
    EXPECT_NEAR(o.levelling_length, length, 1e-12);
  };
  is(0, "BM7", "1", 0.5 * (1.4020 - 1.7011 + 1.4022 - 1.7009), 41.01);
  is(1, "1", "2", 1.1000 - 0.3000, 61.0);
  is(2, "2", "3", 0.5 * (0.9000 - 1.9001 + 0.9002 - 1.9001), 30.2);
  is(3, "3", "BM8", 1.2500 - 1.2000, 50.0);
  EXPECT_TRUE(s.skipped.empty());
  EXPECT_NEAR(s.points.at(0).coordinates.z(), 20, 1e-12);
  EXPECT_TRUE(std::isnan(s.points.at(1).coordinates.z())) << "computed by the level, not given";

  std::string text = fixture("topcon_level.dat");
  text.replace(text.find("20.5009"), 7, "18.9001");  // 1.1 m ahead and 0.3 m back would give this
  const auto wrong = read_topcon_level(text, "t.dat");
  EXPECT_TRUE(skipped(wrong, 11, 1, "the height 20.5009"));
  EXPECT_EQ(wrong.observations.size(), 3u);
  text = fixture("topcon_level.dat");
  text.replace(text.find("Dist.(m)"), 8, "Dist.(f)");
  EXPECT_NE(error_of([&] { read_topcon_level(text, "t.dat"); }).find("lengths in metres"), std::string::npos);
}

/// A back or an ahead that stands alone is no height difference, and is told.
TEST(TopconLevel, OneOfTwoReadingsIsLeftOutAndTold) {
  const std::string whole = fixture("topcon_level.dat");
  for (const std::string& lost : {std::string("BM8 25.00 1.2000 08:40\n"), std::string("3 25.00 1.2500 08:41\n")}) {
    std::string text = whole;
    text.erase(text.find(lost), lost.size());
    const auto s = read_topcon_level(text, "t.dat");
    EXPECT_EQ(s.observations.size(), 3u);
    ASSERT_EQ(s.skipped.size(), 1u);
    EXPECT_EQ(s.skipped[0].source.line, 16);
    EXPECT_EQ(s.skipped[0].expected, "readings of '3' and of the next point, as BF, BFFB, BBFF, FB or FBBF");
  }
}

TEST(TopconLevel, EveryModelIsKnownByItsName) {
  for (const auto& [line, is] : {std::pair("DL-502,1,2,3,4,5", true),
                                 {"SDL30,1,2,3,4,5", true},
                                 {"DL503,1,2,3,4,5", true},
                                 {"DL-100 TEXT", true},
                                 {"DL-502,1,2,3", false},
                                 {"DL-levelled,1,2,3,4,5", false},
                                 {"XDL30,1,2,3,4,5", false}})
    EXPECT_EQ(is_topcon_level(line), is) << line;
}

TEST(TopconLevel, ReadsTheTableOfTheSdl) {
  const auto s = read_topcon_level(fixture("sokkia_level.csv"), "s.csv");
  ASSERT_EQ(s.observations.size(), 2u);
  EXPECT_EQ(s.observations[0].from + ">" + s.observations[0].to, "0001>0002");
  EXPECT_NEAR(s.observations[0].value, 0.5 * (1.41 - 1.70 + 1.412 - 1.701), 1e-12);
  EXPECT_NEAR(s.observations[0].levelling_length, 80.22, 1e-9);
  EXPECT_EQ(s.observations[1].from + ">" + s.observations[1].to, "0002>0003");
  EXPECT_NEAR(s.observations[1].value, 0.85, 1e-12);
  ASSERT_EQ(s.skipped.size(), 1u);  // a kind of reading that nobody has described
  EXPECT_EQ(s.skipped[0].source.line, 7);
  EXPECT_EQ(s.info.instrument, "SDL30");

  const auto one_sided = read_topcon_level(
      "SDL30,15X4,260504,SITE,0,73,2,,\n0001,0001,0,1,1,40.10,1.41000,20.00000,\n"
      "0005,0002,0,1,1,30.00,1.95000,19.71100,\n0007,0003,0,1,2,30.50,1.10000,20.56100,\n",
      "s.csv");
  ASSERT_EQ(one_sided.observations.size(), 1u) << "the first position has nothing ahead";
  EXPECT_EQ(one_sided.observations[0].to, "0003");
  EXPECT_TRUE(skipped(one_sided, 2, 1, "a reading back and one ahead of the same position"));
}

TEST(GsiLevel, GivesHeightDifferences) {
  const auto s = read_gsi(fixture("level.gsi"), "l.gsi");
  ASSERT_EQ(s.observations.size(), 3u);
  EXPECT_NEAR(s.observations[0].value, 0.3120, 1e-9);
  EXPECT_NEAR(s.observations[0].levelling_length, 50.21, 1e-9);
  EXPECT_NEAR(s.observations[1].value, -0.8967, 1e-9);
  EXPECT_EQ(s.observations[2].from + s.observations[2].to, "TP1IS01");
  EXPECT_NEAR(s.observations[2].value, 0.9875 - 2.1050, 1e-9);
  for (const Observation& o : s.observations) EXPECT_EQ(o.kind, height_difference);
  EXPECT_TRUE(s.set_ups.empty());
  EXPECT_TRUE(s.skipped.empty());
}

/// A level's own height that its readings do not give is said; its rounding and the bench mark's closing height are
/// not.
TEST(GsiLevel, ItsHeightsAreComparedWithItsReadings) {
  const auto loop = [](const std::string& height) {
    return "410001+?......1 \n110002+0000BM01 83...6+01000000 \n110003+0000BM01 32...6+00253400 331.06+00015230 \n"
           "110004+00000TP1 32...6+00248700 332.06+00012110 \n110005+00000TP1 573..6+00004700 574..6+00502100 83..06+" +
           height +
           " \n110006+00000TP1 32...6+00301200 331.06+00009875 \n110007+0000BM01 32...6+00296500 332.06+00012995 \n"
           "110008+0000BM01 573..6+00009400 574..6+01099800 83..06+01000000 \n";
  };
  EXPECT_TRUE(read_gsi(loop("01003120"), "l.gsi").warnings.empty());
  const auto s = read_gsi(loop("01003220"), "l.gsi");
  ASSERT_FALSE(s.warnings.empty());
  EXPECT_NE(s.warnings[0].find("line 5: the level's own height of 'TP1' is 10.0 mm off"), std::string::npos);
  EXPECT_EQ(point(s, "BM01").known, (std::array{false, false, true}));
  EXPECT_EQ(point(s, "TP1").known, (std::array{false, false, false}));
}

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

}  // namespace field_books_test
}  // namespace plumbline::survey
