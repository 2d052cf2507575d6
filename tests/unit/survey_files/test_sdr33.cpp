#include <gtest/gtest.h>

#include <array>

#include "survey/files/sdr33.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_sdr33 {

using namespace test_help;
using enum ObservationKind;

TEST(Sdr33, ReadsRecordsOfFixedColumns) {
  const auto survey = read_sdr33(fixture("wide.sdr"), "wide.sdr");
  EXPECT_EQ(survey.info.title, "SITE");
  ASSERT_EQ(survey.set_ups.size(), 2u);
  EXPECT_EQ(survey.set_ups[0].instrument_height, 1.5);
  EXPECT_EQ(point(survey, "S1").coordinates, Eigen::Vector3d(100, 200, 10)) << "north comes first";
  EXPECT_EQ(point(survey, "K-1").code, "KP");
  EXPECT_DOUBLE_EQ(value(survey, 0, direction), 50.25 * kGon);
  EXPECT_DOUBLE_EQ(value(survey, 0, zenith_angle), 100.5 * kGon);
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 12.345);
  EXPECT_EQ(observation(survey, 0, slope_distance).target_height, 1.6);
  EXPECT_EQ(observation(survey, 0, slope_distance).corrections.at(0), "noted in the file: P.C. mm Applied:-30.000");
  EXPECT_EQ(observation(survey, 1, direction).face, 2);
  EXPECT_THROW(value(survey, 2, slope_distance), std::runtime_error) << "blank: not measured";
  EXPECT_TRUE(skipped(survey, 9, 37, "a measured value"));
  EXPECT_EQ(observation(survey, 4, direction).from, "S9");
  EXPECT_TRUE(skipped(survey, 13, 69, "the line seems cut")) << "51.0 may be the beginning of 51.0xxx";
  EXPECT_TRUE(skipped(survey, 14, 1, "two digits, two letters"));
  EXPECT_EQ(survey.warnings.size(), 2u) << "S9 without station record; reduced observations";
}

TEST(Sdr33, ACheckSumEndsWhatWasSentOverACable) {
  const std::string whole = fixture("wide.sdr");
  const auto framed = read_sdr33("\x02\r\n" + whole +
                                     "\x03"
                                     "58903\r\n",
                                 "wide.sdr");
  EXPECT_EQ(framed.skipped.size(), read_sdr33(whole, "wide.sdr").skipped.size());
}

// Derivation codes as r-barnes/sdr33_triangulation and geokoord/sdr33-toolbox list them.
TEST(Sdr33, DerivationCodesSayWhatIsKnownAndWhatIsAMean) {
  const std::string header = "00NMSDR20V03-05     000025-Nov-15 10:00 111111\n";
  const auto record = [](const std::string& head, const std::vector<std::string>& values) {
    std::string line = head;
    for (const std::string& value : values) line += value + std::string(10 - value.size(), ' ');
    return line + "\n";
  };
  const auto survey = read_sdr33(
      header + record("08KI0001", {"200", "100", "10"}) + record("08TP0002", {"300", "100", "10"}) +
          record("08CO0003", {"400", "100", "10"}) + record("08XD0004", {"500", "100", "10"}) +
          record("02KI0002", {"300", "100", "10", "1.5"}) + record("09F100020001", {"100.000", "90.000", "180.000"}) +
          record("09F200020001", {"100.000", "270.000", "0.000"}) +
          record("09MC00020001", {"100.000", "90.000", "180.000"}) +
          record("09MC00020003", {"100.000", "90.000", "0.000"}),
      "k.sdr");
  using Known = std::array<bool, 3>;
  const Known all{true, true, true}, none{};
  EXPECT_EQ(Known(point(survey, "0001").known), all);
  EXPECT_EQ(Known(point(survey, "0002").known), none) << "it was computed before it was stood on";
  EXPECT_EQ(Known(point(survey, "0003").known), none);
  EXPECT_EQ(Known(point(survey, "0004").known), all);
  EXPECT_EQ(survey.observations.size(), 9u) << "two faces, and what stands as corrected alone";
  EXPECT_EQ(survey.warnings.size(), 1u);
}

TEST(Sdr33, ReadsTheNarrowVariantInFeetEastFirstFromTheHorizon) {
  const auto survey = read_sdr33(fixture("narrow.sdr"), "narrow.sdr");
  EXPECT_EQ(point(survey, "0001").coordinates, Eigen::Vector3d(100, 200, 10) * 0.3048);
  EXPECT_DOUBLE_EQ(survey.set_ups.at(0).instrument_height, 5 * 0.3048);
  EXPECT_DOUBLE_EQ(value(survey, 0, zenith_angle), (90 - 10.5) * kDegree);
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 30.48);
  EXPECT_DOUBLE_EQ(observation(survey, 0, direction).target_height, 4 * 0.3048);
}

TEST(Sdr33, ReadsARealFileInAForeignCodePage) {
  PLUMBLINE_REQUIRE_DATA("survey/sdr33/20151125.sdr");
  const auto survey = read_sdr33(test::read_file(test::data_file("survey/sdr33/20151125.sdr")), "20151125.sdr");
  ASSERT_EQ(survey.set_ups.size(), 1u);
  EXPECT_EQ(survey.set_ups[0].station, "STLEV");
  EXPECT_DOUBLE_EQ(survey.set_ups[0].instrument_height, 0.9);
  // The header's coordinate order is E-N; the azimuth STLEV to KRYSHA, 202.318, of record 07 confirms it.
  EXPECT_EQ(point(survey, "STLEV").coordinates, Eigen::Vector3d(6594.363, 15102.106, 163.403));
  const Eigen::Vector3d sight = point(survey, "KRYSHA").coordinates - point(survey, "STLEV").coordinates;
  EXPECT_NEAR(std::atan2(sight.x(), sight.y()) / kDegree + 360, 202.31844673, 1e-4);
  // One backsight without distance, 13 sightings with one.
  EXPECT_EQ(survey.observations.size(), 2u + 3u * 13u);
  EXPECT_THROW(value(survey, 0, slope_distance), std::runtime_error);
  EXPECT_DOUBLE_EQ(value(survey, 0, direction), 201.27666667 * kDegree);
  EXPECT_DOUBLE_EQ(value(survey, 0, zenith_angle), 80.26888889 * kDegree);
  EXPECT_EQ(observation(survey, 1, direction).to, "0004");
  EXPECT_DOUBLE_EQ(value(survey, 1, slope_distance), 79.323);
  EXPECT_TRUE(survey.skipped.empty());
}

TEST(Sdr33, OtherTextIsRefused) {
  EXPECT_NE(error_of([] { read_sdr33("hello\n", "x.sdr"); }).find("x.sdr:1:1"), std::string::npos);
  EXPECT_NE(error_of([] { read_sdr33("00NMSDR33\n", "x.sdr"); }).find("without coordinates"), std::string::npos);
}

}  // namespace test_sdr33
}  // namespace plumbline::survey
