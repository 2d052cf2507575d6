// Digital levels: staff readings to height differences, and the heights that the level itself computed.
#include <gtest/gtest.h>

#include <array>
#include <tuple>

#include "survey/files/field_books.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/zeiss.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_levels {

using namespace test_help;
using enum ObservationKind;

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

/// A staff that was edited: what the level had computed from it stands two lines below.
TEST(Zeiss, HeightsOfALevelAreComparedWithItsReadings) {
  const auto line = [](const std::string& ahead) {
    return "For M5|Adr     2|TO  Start-Line         BF     1|                      |                      |           "
           "           |\n"
           "For M5|Adr     3|KD1     BM01                  1|                      |                      |Z       "
           "100.00000 m   |\n"
           "For M5|Adr     4|KD1     BM01       08:01:121  1|Rb        1.52300 m   |HD         25.340 m   |           "
           "           |\n"
           "For M5|Adr     5|KD1      TP1       08:02:051  1|Rf        " +
           ahead +
           " m   |HD         24.870 m   |                      |\n"
           "For M5|Adr     6|KD1      TP1                  1|                      |                      |Z       "
           "100.31200 m   |\n";
  };
  EXPECT_TRUE(read_zeiss(line("1.21100"), "d.dat").warnings.empty());
  const auto s = read_zeiss(line("1.22100"), "d.dat");
  ASSERT_EQ(s.warnings.size(), 1u);
  EXPECT_NE(s.warnings[0].find("line 5: the level's own height of 'TP1' is 10.0 mm off what its readings give"),
            std::string::npos)
      << s.warnings[0];
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

}  // namespace test_levels
}  // namespace plumbline::survey
