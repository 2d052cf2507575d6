#include <gtest/gtest.h>

#include "survey/files/gama.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_gama {

using namespace test_help;

TEST(Gama, ADistanceModelHasNoNegativePart) {
  const auto survey = read_gama_xml(
      "<gama-local><network><points-observations distance-stdev='-1 3 1'><point id='A' x='0' y='0' fix='xy'/>"
      "<obs from='A'><distance to='B' val='2000'/><distance to='C' val='100' stdev='5'/></obs></points-observations>"
      "</network></gama-local>",
      "g.xml");
  ASSERT_FALSE(survey.skipped.empty()) << "-1 + 3 d is above zero from 333 m on";
  EXPECT_NE(survey.skipped[0].expected.find("not negative"), std::string::npos) << survey.skipped[0].expected;
}

TEST(GamaWriter, AnySurveyReadsBackTheSame) {
  for (unsigned long long seed = 1; seed <= 20; ++seed) {
    SurveyObservations survey = random_survey(seed);
    Random random{seed};
    for (Observation& o : survey.observations) {
      o.sigma = random.uniform(1e-6, 1e-2);
      o.face = 0;
      if (o.kind == ObservationKind::zenith_angle) o.value = std::abs(std::remainder(o.value, 2 * std::numbers::pi));
    }
    const std::string text = write_gama_xml(survey);
    const auto again = read_gama_xml(text, "again.gkf");
    EXPECT_TRUE(again.skipped.empty());
    ASSERT_EQ(again.observations.size(), survey.observations.size());
    EXPECT_EQ(again.set_ups.size(), survey.set_ups.size());
    for (std::size_t i = 0; i < survey.observations.size(); ++i) {
      const Observation &x = survey.observations[i], &y = again.observations[i];
      EXPECT_EQ(x.kind, y.kind);
      EXPECT_EQ(x.from, y.from);
      EXPECT_EQ(x.to, y.to);
      EXPECT_NEAR(std::remainder(x.value - y.value, 2 * std::numbers::pi), 0, 1e-11);
      EXPECT_NEAR(x.sigma, y.sigma, 1e-12);
      const double height =
          std::isnan(x.instrument_height) ? survey.set_ups[x.set_up].instrument_height : x.instrument_height;
      EXPECT_NEAR(height, y.instrument_height, 1e-12);
    }
    for (const Point& p : survey.points)
      for (int axis = 0; axis < 3; ++axis)
        if (!std::isnan(p.coordinates[axis])) {
          EXPECT_EQ(point(again, p.id).coordinates[axis], p.coordinates[axis]);
        }
  }
}

/// 'stdv' for 'stdev': the distance was taken with the default of 5 mm, and nobody was told.
TEST(Gama, AnAttributeThatNobodyReadsIsListed) {
  const auto network = [](const std::string& attribute) {
    return "<?xml version=\"1.0\"?><gama-local xmlns=\"http://www.gnu.org/software/gama/gama-local\"><network "
           "axes-xy=\"ne\"><parameters sigma-apr=\"1\"/><points-observations distance-stdev=\"5\" "
           "direction-stdev=\"10\">\n<point id=\"A\" x=\"0\" y=\"0\" fix=\"xy\"/><point id=\"P\" adj=\"xy\"/>\n"
           "<obs from=\"A\"><distance to=\"P\" val=\"70.71\" " +
           attribute + "=\"1\"/></obs></points-observations></network></gama-local>";
  };
  for (const char* known : {"stdev", "extern", "from_dh"})
    EXPECT_TRUE(read_gama_xml(network(known), "g.gkf").skipped.empty()) << known;
  const auto s = read_gama_xml(network("stdv"), "g.gkf");
  ASSERT_EQ(s.skipped.size(), 1u);
  EXPECT_EQ(s.skipped[0].found, "'stdv=\"1\"'");
  EXPECT_EQ(s.skipped[0].expected, "an attribute of <distance> that gama-local defines");
  EXPECT_EQ(s.skipped[0].source.line, 3);
}

}  // namespace test_gama
}  // namespace plumbline::survey
