#include <gtest/gtest.h>

#include "survey/files/krumm.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_krumm {

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

/// Two corners of Leick's network (GPS Satellite Surveying, 2nd ed., ch. 5.3): where a series to the sixth order of its
/// own draws them.
TEST(Krumm, LatitudesAndLongitudesAreDrawnOnThePlaneOfTheEllipsoid) {
  const std::string ellipsoid =
      "[Ellipsoid,dms]\n6378137.000 0.00669438002 291\xC2\xB0"
      "0'0\" 0.9996\n";
  const std::string rest =
      "[Coordinates,Bdms,Ldms]\nSix#Mile@1 44\xC2\xB0"
      "51'42.44\" 291\xC2\xB0"
      "10'03.11\"  % 3.030\n"
      "Trav-14@15 44\xC2\xB0"
      "49'35.50\" 291\xC2\xB0"
      "13'53.52\"\n[Datum]\nfix\nxSix#Mile, ySix#Mile, xTrav-14\n"
      "%  {sigma=sigma_c + s[m]*sigma_s}\n[HorizontalDistances]\nTrav-14 Six#Mile 6399.312 0.002 0.05\n";
  const SurveyObservations s = read_krumm(ellipsoid + rest, "l.dat");
  EXPECT_TRUE(s.skipped.empty());
  const Point &a = point(s, "Six#Mile"), &b = point(s, "Trav-14");
  EXPECT_NEAR(a.coordinates.x(), 13235.6760, 6e-5);
  EXPECT_NEAR(a.coordinates.y(), 4967610.7338, 6e-5);
  EXPECT_NEAR(b.coordinates.x(), 18303.3487, 6e-5);
  EXPECT_EQ(a.roles, (std::array{CoordinateRole::fixed, CoordinateRole::fixed, CoordinateRole::unused}));
  EXPECT_EQ(b.roles[1], CoordinateRole::free);
  EXPECT_DOUBLE_EQ(s.observations.at(0).sigma, 0.002 + 0.05 * 6.399312);
  EXPECT_EQ(s.warnings.size(), 1u) << "what is assumed of the observations";
  EXPECT_FALSE(read_krumm(rest, "l.dat").skipped.empty()) << "no ellipsoid";
  EXPECT_FALSE(
      read_krumm("[Ellipsoid,dms]\n6377397.155 0.00667437 291\xC2\xB0 0.9996\n" + rest, "l.dat").skipped.empty())
      << "Bessel's";
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

}  // namespace test_krumm
}  // namespace plumbline::survey
