#include "survey/files/jobxml.hpp"

#include <gtest/gtest.h>

#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace {

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

}  // namespace
}  // namespace plumbline::survey
