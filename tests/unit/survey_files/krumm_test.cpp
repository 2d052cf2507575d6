#include "survey/files/krumm.hpp"

#include <gtest/gtest.h>

#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace {

using namespace test_help;
using enum ObservationKind;

TEST(Krumm, ReadsSectionsAndListsWhatItCannotUse) {
  const auto survey = read_krumm(fixture("krumm.dat"), "k.dat");
  EXPECT_EQ(survey.info.title, "Test network");
  EXPECT_EQ(point(survey, "B").coordinates, Eigen::Vector3d(100, 0, 11));
  using enum CoordinateRole;
  EXPECT_EQ(point(survey, "A").roles, (std::array{fixed, fixed, fixed}));
  EXPECT_EQ(point(survey, "B").roles, (std::array{free, free, free}));
  EXPECT_EQ(point(survey, "H").roles, (std::array{unused, unused, free})) << "a lone coordinate is a height";
  ASSERT_EQ(survey.observations.size(), 3u);
  EXPECT_DOUBLE_EQ(survey.observations[0].sigma, std::sqrt(9e-6 + 100.004 * 1e-8));
  EXPECT_DOUBLE_EQ(survey.observations[1].sigma, std::sqrt(9e-6 + 50 * 1e-8)) << "that of the line before holds on";
  EXPECT_EQ(survey.observations[2].kind, height_difference);
  EXPECT_TRUE(skipped(survey, 8, 5, "a coordinate"));
  EXPECT_TRUE(skipped(survey, 11, 14, "name of a point"));
  EXPECT_TRUE(skipped(survey, 11, 17, "name of a point"));
  EXPECT_TRUE(skipped(survey, 17, 5, "above zero"));
  EXPECT_TRUE(skipped(survey, 18, 1, "another point"));
  EXPECT_TRUE(skipped(survey, 19, 1, "from, to, value"));
  EXPECT_TRUE(skipped(survey, 22, 1, "one of the sections"));
}

TEST(Krumm, ANegativeStandardDeviationOfTheDatumIsNone) {
  for (const char* sigma : {"0.01", "-0.01"}) {
    const auto survey = read_krumm(std::string("[Project]\nx\n[Coordinates]\nA 0 0 10\nB 100 0 11\n[Datum]\ndyn\nxA ") +
                                       sigma + "\nyA 0.01\n[Distances]\nA B 100.004 0.003 0 0\n",
                                   "k.dat");
    EXPECT_EQ(survey.coordinates.size(), sigma[0] == '-' ? 0u : 1u);
    EXPECT_EQ(skipped(survey, 8, 1, "not negative"), sigma[0] == '-');
  }
}

/// Lines without a standard deviation have that of the line above; of a line that was refused they take nothing.
TEST(Krumm, TheStandardDeviationOfARefusedLineIsNotHandedDown) {
  const std::string head = "[Coordinates]\nA 0 0\nB 100 0\nC 0 100\n[HorizontalDistances]\n";
  for (const std::string refused : {"A B 100.001 0.0 11.0 x z\n", "A B 100.001 0.5 0 x 1.6\n", "A B 100.001 0 0\n"}) {
    const SurveyObservations s = read_krumm(head + "A C 100.002 0.003\n" + refused + "B C 141.421\n", "f.dat");
    ASSERT_EQ(s.observations.size(), 2u) << refused;
    EXPECT_EQ(s.skipped.size(), 1u);
    EXPECT_DOUBLE_EQ(s.observations[1].sigma, 0.003);
  }
}

TEST(Krumm, ReadsTheNetworkOfBlankenbachAndWillert) {
  const std::string name = "survey/BlankenbachWillert3D_Distance_fix.dat";
  PLUMBLINE_REQUIRE_DATA(name);
  const auto survey = read_krumm(test::read_file(test::data_file(name)), "b.dat");
  EXPECT_EQ(survey.points.size(), 9u);
  EXPECT_EQ(point(survey, "MS").coordinates, Eigen::Vector3d(-2.59, 24.22, 9.62));
  EXPECT_EQ(point(survey, "MS").roles[0], CoordinateRole::free);
  EXPECT_EQ(point(survey, "102").roles[2], CoordinateRole::fixed);
  ASSERT_EQ(survey.observations.size(), 8u);
  EXPECT_EQ(survey.observations[6].to, "103");
  EXPECT_EQ(survey.observations[6].value, 8.17);
  for (const Observation& o : survey.observations) EXPECT_EQ(o.sigma, 0.05);
  EXPECT_TRUE(survey.skipped.empty());
}

}  // namespace
}  // namespace plumbline::survey
