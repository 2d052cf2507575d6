#include <gtest/gtest.h>

#include <array>

#include "survey/files/landxml.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_landxml {

using namespace test_help;
using enum ObservationKind;

TEST(LandXml, ReadsUnitsSetUpsAndFaces) {
  const auto survey = read_landxml(fixture("survey.landxml"), "s.xml");
  EXPECT_EQ(survey.info.title, "Facade & core");
  EXPECT_EQ(point(survey, "A-1").coordinates, Eigen::Vector3d(1000.25, 2000.5, 10.125)) << "north comes first";
  EXPECT_EQ(point(survey, "S1").coordinates, Eigen::Vector3d(200, 100, 5));
  EXPECT_EQ(survey.set_ups[0].instrument_height, 1.5);
  EXPECT_NEAR(value(survey, 0, direction), (10 + 30 / 60. + 15 / 3600.) * kDegree, 1e-15);
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 12.345);
  EXPECT_DOUBLE_EQ(observation(survey, 0, direction).target_height, 0.1);
  EXPECT_EQ(observation(survey, 0, direction).source.line, 8);
  EXPECT_EQ(observation(survey, 1, direction).face, 2);
  EXPECT_EQ(observation(survey, 1, direction).to, "A-1");
  EXPECT_TRUE(skipped(survey, 6, 67, "three numbers")) << "a coordinate 'nan'";
  EXPECT_TRUE(skipped(survey, 12, 8, "decimal dd.mm.ss")) << "61 minutes";
  EXPECT_TRUE(skipped(survey, 14, 8, "TargetPoint"));
  EXPECT_THROW(value(survey, 2, direction), std::runtime_error);
  EXPECT_DOUBLE_EQ(value(survey, 2, slope_distance), 5.0);
  ASSERT_EQ(survey.set_ups.size(), 2u);
  EXPECT_EQ(survey.set_ups[1].station, "s9") << "a set-up the file does not describe";
  EXPECT_EQ(survey.warnings.size(), 2u) << "that, and the deleted observation";
}

TEST(LandXml, HexmlDistancesGetPrismConstantAndPpm) {
  const auto survey = read_landxml(fixture("leica.hexml.xml"), "h.xml");
  EXPECT_EQ(survey.info.format, "hexml");
  EXPECT_EQ(observation(survey, 0, slope_distance).to, "A-1") << "oID is the surveyor's name";
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), (50.0 + 0.0344) * (1 + 20e-6) - 0.0344);
  EXPECT_EQ(observation(survey, 0, slope_distance).corrections,
            std::vector<std::string>{"ppm 20, prism constant -34.4 mm"});
  EXPECT_EQ(point(survey, "A-1").coordinates, Eigen::Vector3d(10, 20, 5));
  std::string exported = fixture("leica.hexml.xml");
  exported.replace(exported.find("Leica Captivate"), 15, "LandXML Export");
  EXPECT_EQ(value(read_landxml(exported, "h.xml"), 0, slope_distance), 50.0);
}

// pntSurv is LandXML's word (surveyType), class Leica's.
TEST(LandXml, PointsThatWereGivenToTheInstrumentAreKnown) {
  std::string control = fixture("survey.landxml");
  control.replace(control.find("<CgPoint name=\"A-1\""), 19, "<CgPoint pntSurv=\"control\" name=\"A-1\"");
  using Known = std::array<bool, 3>;
  EXPECT_EQ(Known(point(read_landxml(control, "s.xml"), "A-1").known), (Known{true, true, true}));
  EXPECT_EQ(Known(point(read_landxml(fixture("survey.landxml"), "s.xml"), "A-1").known), Known());
  // Measured first, known behind it and 40 mm beside: known is known.
  std::string given = fixture("leica.hexml.xml");
  given.replace(given.find("<CgPoint name=\"ST1\""), 0, "<CgPoint name=\"key\" oID=\"A-1\">20.04 10 5</CgPoint>");
  given.replace(given.find("<hexml:Point "), 0, "<hexml:Point uniqueID=\"key\" class=\"Control\"/>");
  const auto survey = read_landxml(given, "h.xml");
  EXPECT_EQ(point(survey, "A-1").coordinates, Eigen::Vector3d(10, 20.04, 5));
  EXPECT_EQ(Known(point(survey, "A-1").known), (Known{true, true, true}));
  EXPECT_EQ(Known(point(read_landxml(fixture("leica.hexml.xml"), "h.xml"), "A-1").known), Known());
}

TEST(LandXml, ATruncatedFileGivesItsGoodPart) {
  const std::string whole = fixture("survey.landxml");
  const std::size_t cut = whole.find("slopeDistance=\"12346\"") + 18;  // inside the number
  const auto survey = read_landxml(whole.substr(0, cut), "cut.xml");
  EXPECT_EQ(survey.observations.size(), 3u) << "the cut distance must not become 123 mm";
  EXPECT_TRUE(skipped(survey, 11, 80, "well-formed XML"));
  EXPECT_EQ(survey.skipped.back().source.line, 11);
  // Between two records nothing good is lost.
  const auto between = read_landxml(whole.substr(0, whole.find("</InstrumentSetup>")), "cut.xml");
  EXPECT_EQ(between.observations.size(), 3u);
}

TEST(LandXml, EveryTruncationIsReadOrRefused) {
  for (const char* name : {"survey.landxml", "leica.hexml.xml"}) {
    const std::string whole = fixture(name);
    for (std::size_t n = 0; n < whole.size(); n += 3) {
      try {
        for (const Observation& o : read_landxml(whole.substr(0, n), "cut.xml").observations)
          EXPECT_TRUE(o.value > 0.1 || o.kind != slope_distance);
      } catch (const SurveyReadError&) {
      }
    }
  }
}

TEST(LandXml, HostileFilesEnd) {
  std::string nested = "<LandXML><Survey>";
  for (int i = 0; i < 400000; ++i) nested += "<RawObservation>";
  EXPECT_THROW(read_landxml(nested, "n.xml"), SurveyReadError);  // a recursion for each level would not end well
  const std::string entities =
      "<!DOCTYPE l [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;\"><!ENTITY x SYSTEM "
      "\"file:///etc/passwd\">]>"
      "<LandXML><Units><Metric linearUnit='meter' angularUnit='grads'/></Units><Survey>"
      "<CgPoints><CgPoint name='&b;&x;'>1 2 3</CgPoint></CgPoints></Survey></LandXML>";
  EXPECT_EQ(read_landxml(entities, "e.xml").points.at(0).id, "&b;&x;") << "never expanded, never opened";
  EXPECT_NE(error_of([] {
              read_landxml("<LandXML><Units><Metric linearUnit='cubit'/></Units></LandXML>", "u.xml");
            }).find("u.xml:1:18: found the linear unit 'cubit'"),
            std::string::npos);
  EXPECT_NE(error_of([] { read_landxml("<html/>", "u.xml"); }).find("formats understood"), std::string::npos);
  EXPECT_NE(error_of([] { read_landxml("", "u.xml"); }).find("an empty file"), std::string::npos);
}

TEST(LandXml, ReadsUtf16) {
  const std::string utf8 =
      "<LandXML><Units><Metric linearUnit='meter' angularUnit='grads'/></Units><CgPoints>"
      "<CgPoint name='P'>1 2 3</CgPoint></CgPoints></LandXML>";
  std::string utf16 = "\xFF\xFE";
  for (const char c : utf8) utf16 += {c, '\0'};
  EXPECT_EQ(read_landxml(utf16, "u.xml").points.at(0).coordinates, Eigen::Vector3d(2, 1, 3));
}

TEST(LandXml, ReadsARealFileWithSetupIdInBothPlaces) {
  PLUMBLINE_REQUIRE_DATA("survey/landxml/landxml.xml");
  const auto survey = read_landxml(test::read_file(test::data_file("survey/landxml/landxml.xml")), "landxml.xml");
  ASSERT_EQ(survey.set_ups.size(), 2u);
  EXPECT_EQ(survey.set_ups[1].station, "STAZLIB4");
  EXPECT_DOUBLE_EQ(survey.set_ups[1].instrument_height, 1.33);
  ASSERT_EQ(survey.observations.size(), 9u);
  EXPECT_EQ(observation(survey, 0, direction).from, "STAZLIB3");
  EXPECT_DOUBLE_EQ(value(survey, 0, direction), 281.9919 * kGon);
  EXPECT_DOUBLE_EQ(value(survey, 0, zenith_angle), 97.8425 * kGon);
  EXPECT_DOUBLE_EQ(value(survey, 2, slope_distance), 9.74);
  EXPECT_EQ(observation(survey, 2, slope_distance).to, "902");
  EXPECT_EQ(observation(survey, 2, slope_distance).from, "STAZLIB4");
  EXPECT_EQ(point(survey, "850").coordinates, Eigen::Vector3d(444.915, 449.72, 1.932));
  EXPECT_TRUE(survey.skipped.empty());
}

TEST(LandXmlWriter, AnySurveyReadsBackTheSame) {
  for (unsigned long long seed = 1; seed <= 20; ++seed) {
    SurveyObservations survey = random_survey(seed);
    for (Observation& o : survey.observations) o.instrument_height = kNotGiven;
    survey.points[1].description = "a < b & \"c\"";
    survey.points[1].coordinates = {1.0 / 3, -2.0 / 3, 1e-7};
    const std::string text = write_landxml(survey);
    const auto again = read_landxml(text, "again.xml");
    EXPECT_TRUE(again.skipped.empty());
    for (std::size_t i = 0; i < survey.observations.size(); ++i)
      survey.observations[i].set_number = again.observations.at(i).set_number;
    expect_same(survey, again, 1e-12);
    EXPECT_EQ(point(again, survey.points[1].id).coordinates, survey.points[1].coordinates);
    EXPECT_EQ(point(again, survey.points[1].id).description, survey.points[1].description);
  }
}

TEST(LandXmlWriter, RefusesWhatARawObservationCannotHold) {
  SurveyObservations survey = random_survey(1);
  survey.observations[0].instrument_height = 9;
  EXPECT_THROW(write_landxml(survey), std::runtime_error);
}

}  // namespace test_landxml
}  // namespace plumbline::survey
