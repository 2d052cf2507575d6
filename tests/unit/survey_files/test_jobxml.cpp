#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <regex>

#include "survey/files/jobxml.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_jobxml {

using namespace test_help;
using enum ObservationKind;

TEST(JobXml, ReadsStationsTargetsAndCorrectsDistances) {
  const auto survey = read_jobxml(fixture("job.jxl"), "job.jxl");
  ASSERT_EQ(survey.set_ups.size(), 1u);
  EXPECT_EQ(survey.set_ups[0].instrument_height, 1.55);
  EXPECT_EQ(survey.info.instrument, "S7");
  EXPECT_DOUBLE_EQ(value(survey, 0, direction), 45.5 * kDegree) << "degrees whatever the units record shows";
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 40 * (1 + 12.5e-6) - 0.002);
  EXPECT_EQ(observation(survey, 0, slope_distance).corrections,
            (std::vector<std::string>{"ppm 12.5", "prism constant -2.0 mm"}));
  EXPECT_EQ(observation(survey, 0, zenith_angle).target_height, 1.6);
  EXPECT_EQ(observation(survey, 1, zenith_angle).face, 2);
  EXPECT_DOUBLE_EQ(value(survey, 1, zenith_angle), 270.75 * kDegree);
  EXPECT_THROW(value(survey, 1, slope_distance), std::runtime_error);
  EXPECT_EQ(point(survey, "KP1").coordinates, Eigen::Vector3d(100, 200, 10));
  EXPECT_EQ(point(survey, "KP1").code, "CTRL");
  EXPECT_EQ(point(survey, "A-1").coordinates, Eigen::Vector3d(128.5, 228.5, 10.5));
  EXPECT_EQ(survey.observations.size(), 6u);
  EXPECT_EQ(survey.skipped.size(), 2u) << "'NaN' and an angle of 1e9 degrees";
  EXPECT_EQ(survey.skipped[0].source.line, 14);
  EXPECT_EQ(survey.warnings.size(), 2u) << "a deleted record and a mean";
}

std::string job(const std::string& records, const std::string& behind = "") {
  return "<JOBFile version=\"5.3\"><FieldBook>" + records + "</FieldBook>" + behind + "</JOBFile>";
}

std::string coordinates(const std::string& name, const std::string& how, double north) {
  return "<PointRecord><Name>" + name + "</Name>" + how + "<Deleted>false</Deleted><Grid><North>" +
         std::to_string(north) + "</North><East>1</East><Elevation>2</Elevation></Grid></PointRecord>";
}

std::string sighting(const std::string& to, const std::string& method) {
  return "<PointRecord><Name>" + to + "</Name><Method>" + method +
         "</Method><Circle><HorizontalCircle>10</HorizontalCircle><VerticalCircle>90</VerticalCircle><EDMDistance>100"
         "</EDMDistance><Face>Face1</Face></Circle><StationID>5</StationID></PointRecord>";
}

bool warns_of(const SurveyObservations& survey, const std::string& text) {
  return std::any_of(survey.warnings.begin(), survey.warnings.end(),
                     [&](const auto& warning) { return warning.find(text) != std::string::npos; });
}

// The words of the schema 5.3 and of jobs that a Survey Controller wrote (KubaSzostak/JobXML, docs): Method says that
// there are coordinates, SurveyMethod where they are from.
TEST(JobXml, CoordinatesAreKnownWhereTheyWereTypedInOrTakenOver) {
  const auto way = [](const std::string& method, const std::string& how, const std::string& rank = "Normal") {
    return "<Method>" + method + "</Method><SurveyMethod>" + how + "</SurveyMethod><Classification>" + rank +
           "</Classification>";
  };
  const auto survey = read_jobxml(
      job(coordinates("KEYED", way("Coordinates", "KeyedIn"), 10) +
          coordinates("COPIED", way("CopiedPoint", "Copied"), 20) +
          coordinates("COMPUTED", way("CogoCalculated", "KeyedIn"), 30) +
          coordinates("FREE", way("Resection", "Code"), 40) + coordinates("TWICE", way("Coordinates", "KeyedIn"), 50) +
          coordinates("TWICE", way("Coordinates", "KeyedIn", "Control"), 60) +
          coordinates("RTK", way("GpsRTKQuickMark", "NetworkFix"), 70)),
      "x.jxl");
  using Known = std::array<bool, 3>;
  const Known all{true, true, true}, none{};
  EXPECT_EQ(Known(point(survey, "KEYED").known), all);
  EXPECT_EQ(Known(point(survey, "COPIED").known), all);
  EXPECT_EQ(Known(point(survey, "COMPUTED").known), none);
  EXPECT_EQ(Known(point(survey, "FREE").known), none);
  EXPECT_EQ(point(survey, "TWICE").coordinates.y(), 60) << "control goes before what is none";
  EXPECT_EQ(Known(point(survey, "TWICE").known), all);
  EXPECT_TRUE(warns_of(survey, "point 'TWICE' has different coordinates"));
  EXPECT_TRUE(warns_of(survey, "1 GNSS records"));
}

TEST(JobXml, DistancesThatAreCorrectedAlreadyStayAsTheyAre) {
  const auto distance = [](const std::string& apply) {
    return value(
        read_jobxml(job("<AtmosphereRecord ID=\"3\"><PPM>25</PPM>" + apply +
                        "</AtmosphereRecord><StationRecord ID=\"5\"><StationName>S</StationName><AtmosphereID>3"
                        "</AtmosphereID></StationRecord>" +
                        sighting("P", "DirectReading")),
                    "x.jxl"),
        0, slope_distance);
  };
  EXPECT_DOUBLE_EQ(distance(""), 100 * (1 + 25e-6));
  EXPECT_DOUBLE_EQ(distance("<ApplyPPMToRawDistances>true</ApplyPPMToRawDistances>"), 100 * (1 + 25e-6));
  EXPECT_EQ(distance("<ApplyPPMToRawDistances>false</ApplyPPMToRawDistances>"), 100);
}

TEST(JobXml, AStationMayStandBehindWhatWasSeenFromIt) {
  const std::string station = "<StationRecord ID=\"5\"><StationName>S</StationName></StationRecord>";
  const auto survey =
      read_jobxml(job("<StationRecord ID=\"4\"><StationName>R</StationName></StationRecord>"
                      "<BackBearingRecord><OrientationCorrection>30</OrientationCorrection></BackBearingRecord>" +
                      std::regex_replace(sighting("Q", "DirectReading"), std::regex(">5<"), ">4<") +
                      sighting("P", "DirectReading") + station),
                  "x.jxl");
  ASSERT_EQ(survey.set_ups.size(), 2u);
  EXPECT_TRUE(survey.warnings.empty());
  EXPECT_EQ(survey.set_ups[observation(survey, 1, direction).set_up].station, "S");
  EXPECT_DOUBLE_EQ(survey.set_ups[0].stated_orientation, 30 * kDegree);
  EXPECT_TRUE(std::isnan(survey.set_ups[1].stated_orientation));
}

TEST(JobXml, WhatIsNoReadingIsSaidAndLeftOut) {
  const auto survey = read_jobxml(
      job("<StationRecord ID=\"5\"><StationName>S</StationName></StationRecord>" + sighting("A", "DirectReading") +
          sighting("B", "MatchedPair") + sighting("B", "MeanTurnedAngleHidden") + sighting("C", "DistanceOffset") +
          "<PointRecord><Name>L</Name><Method>LevelObservation</Method></PointRecord>"),
      "x.jxl");
  EXPECT_EQ(survey.observations.size(), 9u) << "of A, C and the mean of B, three each";
  EXPECT_TRUE(warns_of(survey, "1 mean turned angles are of points that were not sighted singly"));
  EXPECT_TRUE(warns_of(survey, "1 further means"));
  EXPECT_TRUE(warns_of(survey, "1 sightings were computed from an offset"));
  EXPECT_TRUE(warns_of(survey, "1 levelling records"));
}

/// They were "left out; the single sightings are read", where there were none, and a set-up of means alone was lost.
TEST(JobXml, MeansCountWhereNothingSingleWasRead) {
  const auto survey = read_jobxml(
      job("<StationRecord ID=\"5\"><StationName>S</StationName></StationRecord>" + sighting("A", "DirectReading") +
          sighting("A", "MeanTurnedAngle") + sighting("B", "MeanTurnedAngle") +
          "<PointRecord><Name>C</Name><Method>MeanTurnedAngle</Method></PointRecord>"),
      "x.jxl");
  EXPECT_EQ(survey.observations.size(), 6u) << "of A and the mean of B, three each";
  EXPECT_TRUE(warns_of(survey, "1 mean turned angles were left out; the single sightings are read"));
  EXPECT_TRUE(warns_of(survey, "1 mean turned angles are of points that were not sighted singly"));
  EXPECT_TRUE(warns_of(survey,
                       "1 mean turned angles are of points that were not sighted singly in this file, and "
                       "have no Circle"));
}

/// -17.5 was taken off as metres.
TEST(JobXml, APrismConstantOfMetresIsRefused) {
  const auto survey =
      read_jobxml(job("<StationRecord ID=\"5\"><StationName>S</StationName></StationRecord><TargetRecord ID=\"1\">"
                      "<PrismConstant>-17.5</PrismConstant></TargetRecord>" +
                      sighting("A", "DirectReading")),
                  "x.jxl");
  ASSERT_EQ(survey.skipped.size(), 1u);
  EXPECT_EQ(survey.skipped[0].found, "'-17.5'");
}

TEST(JobXml, PointsThatTheOfficeHandsOutAreRead) {
  const auto survey = read_jobxml(job("",
                                      "<InventoryData><Point><Name>100A</Name><Grid><North>5</North><East>6</East>"
                                      "<Elevation>7</Elevation></Grid></Point></InventoryData>"),
                                  "x.jxl");
  EXPECT_EQ(point(survey, "100A").coordinates, Eigen::Vector3d(6, 5, 7));
}

TEST(JobXml, EveryTruncationIsReadOrRefused) {
  const std::string whole = fixture("job.jxl");
  for (std::size_t n = 0; n < whole.size(); ++n) {
    try {
      for (const Observation& o : read_jobxml(whole.substr(0, n), "cut.jxl").observations)
        EXPECT_TRUE(o.kind != slope_distance || o.value > 11) << "a number cut at byte " << n;
    } catch (const SurveyReadError&) {
    }
  }
}

TEST(JobXml, OtherXmlIsRefused) {
  EXPECT_NE(error_of([] { read_jobxml("<LandXML/>", "x.jxl"); }).find("x.jxl:1:2: found the root element 'LandXML'"),
            std::string::npos);
}

}  // namespace test_jobxml
}  // namespace plumbline::survey
