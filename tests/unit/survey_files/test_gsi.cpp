#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "survey/files/gsi.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_gsi {

using namespace test_help;
using enum ObservationKind;

/// A second name is another instrument: its readings had the accuracy of the first.
TEST(Gsi, ReadingsAreOfTheInstrumentThatIsNamedBeforeThem) {
  const auto named = [](const std::string& name) {
    return "*110001+000000000000JOB1 13....+000000000000" + name + " \n";
  };
  const std::string station =
                        "*110002+00000000000000S1 84..10+0000000000500000 85..10+0000000001000000 86..10+"
                        "0000000000050000 88..10+0000000000001552 \n",
                    sight =
                        "*110004+00000000000000P1 21.322+0000000006530541 22.322+0000000009911398 31..00+"
                        "0000000000082470 87..10+0000000000001500 \n";
  const auto two = read_gsi(named("TS16") + station + sight + named("TM50") + station + sight, "two.gsi");
  ASSERT_EQ(two.instruments, (std::vector<std::string>{"TS16", "TM50"}));
  EXPECT_EQ(two.observations.front().instrument, 0);
  EXPECT_EQ(two.observations.back().instrument, 1);
  const auto one = read_gsi(named("TS16") + station + sight + named("TS16") + station + sight, "one.gsi");
  EXPECT_EQ(one.info.instrument, "TS16");
  EXPECT_TRUE(one.instruments.empty());
}

TEST(Gsi, ReadsGsi8WithStationCoordinatesAndAllUnits) {
  const auto survey = read_gsi(fixture("station_coordinates.gsi"), "a.gsi");
  ASSERT_EQ(survey.set_ups.size(), 2u);
  EXPECT_EQ(survey.set_ups[0].station, "S1");
  EXPECT_DOUBLE_EQ(survey.set_ups[0].instrument_height, 1.5);
  EXPECT_DOUBLE_EQ(survey.set_ups[1].instrument_height, 1.4);
  EXPECT_EQ(point(survey, "S1").coordinates, Eigen::Vector3d(100, 200, 10));
  EXPECT_EQ(point(survey, "KP07").coordinates, Eigen::Vector3d(120, -5, 12));
  EXPECT_TRUE(survey.skipped.empty());

  EXPECT_DOUBLE_EQ(value(survey, 0, direction), 50 * kGon);
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 12.345);
  EXPECT_EQ(observation(survey, 0, slope_distance).face, 1);
  EXPECT_EQ(observation(survey, 0, slope_distance).corrections,
            std::vector<std::string>{"in the instrument: ppm 220, prism constant 2 mm"});
  EXPECT_EQ(observation(survey, 0, direction).source.line, 2);
  EXPECT_EQ(point(survey, "A101").code, "PLATE A");
  EXPECT_EQ(observation(survey, 1, zenith_angle).face, 2);
  EXPECT_DOUBLE_EQ(value(survey, 1, zenith_angle), 310 * kGon) << "face 2 stays as measured";
  EXPECT_DOUBLE_EQ(value(survey, 2, direction), 45 * kDegree);
  EXPECT_DOUBLE_EQ(value(survey, 2, slope_distance), 10 * 0.3048);
  EXPECT_NEAR(value(survey, 3, direction), (359 + 59 / 60. + 56.1 / 3600) * kDegree, 1e-15);
  EXPECT_THROW(value(survey, 3, slope_distance), std::runtime_error) << "a distance of 0 is none";
  EXPECT_DOUBLE_EQ(value(survey, 4, direction), std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(value(survey, 4, slope_distance), 12.3456);
  EXPECT_DOUBLE_EQ(value(survey, 5, slope_distance), 12.34567);
  // Target height holds until changed; a change of the instrument height belongs to the observations after it.
  EXPECT_DOUBLE_EQ(observation(survey, 3, direction).target_height, 1.6);
  EXPECT_DOUBLE_EQ(observation(survey, 5, direction).target_height, 0);
  EXPECT_TRUE(std::isnan(observation(survey, 3, direction).instrument_height));
  EXPECT_DOUBLE_EQ(observation(survey, 5, direction).instrument_height, 1.51);
  EXPECT_TRUE(std::isnan(observation(survey, 6, direction).instrument_height)) << "a new set-up has its own";
  EXPECT_EQ(observation(survey, 6, direction).from, "S2");
}

TEST(Gsi, UsSurveyFeetOnRequest) {
  const auto survey = read_gsi(fixture("station_coordinates.gsi"), "a.gsi", {.us_survey_foot = true});
  EXPECT_DOUBLE_EQ(value(survey, 2, slope_distance), 10 * 1200.0 / 3937.0);
}

TEST(Gsi, ReadsCodeBlocksInAFileWithCrOnly) {
  const auto survey = read_gsi(fixture("code_block_cr_only.gsi"), "a.gsi");
  ASSERT_EQ(survey.set_ups.size(), 1u);
  EXPECT_EQ(survey.set_ups[0].station, "ST01");
  EXPECT_DOUBLE_EQ(survey.set_ups[0].instrument_height, 1.538);
  ASSERT_EQ(survey.observations.size(), 9u);
  EXPECT_EQ(observation(survey, 0, slope_distance).corrections.at(0), "in the instrument: ppm 17, prism constant 0 mm");
  EXPECT_EQ(observation(survey, 1, slope_distance).corrections.at(0),
            "in the instrument: ppm 12.0000, prism constant -34.4 mm");
  EXPECT_EQ(point(survey, "A-101").code, "") << "dashes are an empty remark";
  EXPECT_EQ(observation(survey, 2, direction).set_number, 1) << "first sighting in face 2";
  ASSERT_EQ(survey.warnings.size(), 1u);
  EXPECT_NE(survey.warnings[0].find("'13'"), std::string::npos);
}

TEST(Gsi, StationCodeIsConfigurable) {
  GsiOptions options;
  options.station_codes = {{.code = "13", .station_word = 42, .height_word = 43, .height_unit = 1.0}};
  const auto survey = read_gsi(fixture("code_block_cr_only.gsi"), "a.gsi", options);
  ASSERT_EQ(survey.set_ups.size(), 2u);
  EXPECT_EQ(survey.set_ups[0].station, "free-station-1");
  EXPECT_EQ(survey.set_ups[1].station, "REMARK");
}

TEST(Gsi, DamageCostsTheWordNotTheFile) {
  const auto survey = read_gsi(fixture("damaged.gsi"), "cut.gsi");
  ASSERT_EQ(survey.set_ups.size(), 3u);
  EXPECT_EQ(survey.set_ups[0].station, "ST01") << "word 16";
  EXPECT_EQ(survey.set_ups[1].station, "ST02");
  EXPECT_EQ(survey.set_ups[2].station, "free-station-1") << "after an unreadable start, never the station before";
  EXPECT_TRUE(skipped(survey, 2, 50, "16 digits")) << "text where digits belong";
  EXPECT_TRUE(skipped(survey, 3, 74, "16 digits")) << "a number cut in half must not become another number";
  EXPECT_TRUE(skipped(survey, 4, 26, "GSI word"));
  EXPECT_TRUE(skipped(survey, 5, 1, "GSI word"));
  EXPECT_TRUE(skipped(survey, 7, 26, "minutes and seconds below 60"));
  EXPECT_TRUE(skipped(survey, 7, 74, "100 km"));
  EXPECT_TRUE(skipped(survey, 8, 2, "code word"));
  EXPECT_TRUE(skipped(survey, 10, 2, "the line seems cut"));
  EXPECT_EQ(survey.skipped.front().source.file, "cut.gsi");
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 29.462) << "the good words of a damaged line are kept";
  EXPECT_THROW(value(survey, 1, slope_distance), std::runtime_error);
}

TEST(Gsi, ALineCutInHalfNamesFileLineColumnAndWhatWasExpected) {
  try {
    read_gsi("*110015+000000000000BP03 21.322+00000000169\r\n", "half.gsi");
    FAIL() << "nothing usable in the file";
  } catch (const SurveyReadError& error) {
    EXPECT_NE(
        std::string(error.what()).find("half.gsi:1:26: found '21.322+00000000169', expected an angle of 16 digits"),
        std::string::npos)
        << error.what();
  }
}

TEST(Gsi, ALineCutBetweenTwoWordsIsTold) {
  const std::string station = "410001+00000021 42....+00000S1A 43....+00001500 \r\n";
  const std::string whole = "110002+000000P1 21.322+01000000 22.322+10000000 31..00+00012345 87..10+00001600 \r\n";
  const std::string next = "110003+000000P2 21.322+02000000 22.322+10000000 31..00+00012345 87..10+00001600 \r\n";
  const auto name_only = read_gsi(station + whole + next.substr(0, 16), "cut.gsi");
  ASSERT_EQ(name_only.skipped.size(), 1u);
  EXPECT_TRUE(skipped(name_only, 3, 1, "words 21, 22, 31, 87 after it"));
  const auto direction_only = read_gsi(station + whole + next.substr(0, 32), "cut.gsi");
  EXPECT_TRUE(direction_only.skipped.empty()) << "a direction alone is a measurement";
  ASSERT_EQ(direction_only.warnings.size(), 1u);
  EXPECT_NE(direction_only.warnings[0].find("line 3 ends where the sighting before goes on with words 22, 31, 87"),
            std::string::npos);
  const auto no_distance =
      read_gsi(station + whole + "110003+000000P2 21.322+02000000 22.322+10000000 87..10+00001600 \r\n", "whole.gsi");
  EXPECT_TRUE(no_distance.skipped.empty() && no_distance.warnings.empty()) << "another kind of sighting, not a cut one";
}

TEST(Gsi, ReadsBlocksWithoutLineEndsAndNamesInWindows1252) {
  const auto survey =
      read_gsi(fixture("one_line_windows_1252.gsi"), "a.gsi", {.vertical_reference = GsiVerticalReference::horizon});
  ASSERT_EQ(survey.set_ups.size(), 1u);
  EXPECT_EQ(survey.set_ups[0].station,
            "S\xC3\xBC"
            "d-1");
  EXPECT_EQ(observation(survey, 0, direction).to, "TOR T\xC3\x9CR");
  EXPECT_DOUBLE_EQ(value(survey, 0, zenith_angle), 90 * kGon);
  EXPECT_DOUBLE_EQ(value(survey, 1, zenith_angle), 310 * kGon) << "face 2";
  EXPECT_EQ(observation(survey, 1, direction).face, 2);
}

TEST(Gsi, WarnsOfAHorizonReference) {
  const auto survey = read_gsi(
      "110001+00000001 21.322+05000000 22.322+00100000 31..00+00012345\n"
      "110002+00000002 21.322+05000000 22.322+39900000 31..00+00012345\n",
      "a.gsi");
  ASSERT_EQ(survey.warnings.size(), 2u);
  EXPECT_NE(survey.warnings[1].find("'horizon'"), std::string::npos);
}

TEST(Gsi, AFileThatIsNoneSaysWhatIsUnderstood) {
  for (const std::string& bytes : {std::string(), std::string("\0\0\0\0", 4), std::string("hello\nworld\n"),
                                   std::string(100000, '*'), fixture("empty_words.gsi")}) {
    try {
      read_gsi(bytes, "none.gsi");
      FAIL() << bytes.substr(0, 20);
    } catch (const SurveyReadError& error) {
      EXPECT_NE(std::string(error.what()).find("none.gsi"), std::string::npos);
    }
  }
  try {
    read_gsi("hello", "none.gsi");
  } catch (const SurveyReadError& error) {
    EXPECT_NE(std::string(error.what()).find("JobXML"), std::string::npos) << error.what();
  }
}

TEST(Gsi, ReadsTheNetworkOf22SetUps) {
  PLUMBLINE_REQUIRE_DATA("survey/gsi/network_22_setups.GSI");
  const auto survey = read_gsi(test::read_file(test::data_file("survey/gsi/network_22_setups.GSI")), "network.GSI");
  EXPECT_EQ(survey.set_ups.size(), 22u);
  EXPECT_EQ(survey.observations.size(), 3u * 1400u);
  EXPECT_EQ(survey.points.size(), 22u);
  EXPECT_TRUE(survey.skipped.empty());
  EXPECT_TRUE(survey.warnings.empty());
  // Lines 1 and 2 of the file.
  EXPECT_EQ(survey.set_ups[0].station, "BP04");
  EXPECT_DOUBLE_EQ(survey.set_ups[0].instrument_height, 1.538);
  EXPECT_EQ(observation(survey, 0, direction).to, "BP03");
  EXPECT_DOUBLE_EQ(value(survey, 0, direction), 169.01313 * kGon);
  EXPECT_DOUBLE_EQ(value(survey, 0, zenith_angle), 99.55914 * kGon);
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 29.462);
  EXPECT_DOUBLE_EQ(observation(survey, 0, slope_distance).target_height, 1.565);
  // Four targets, each in both faces, seven rounds.
  EXPECT_EQ(observation(survey, 4, zenith_angle).face, 2);
  EXPECT_EQ(observation(survey, 4, zenith_angle).set_number, 1);
  EXPECT_EQ(observation(survey, 8, zenith_angle).set_number, 2);
}

TEST(Gsi, ReadsSexagesimalAnglesWithoutAStation) {
  PLUMBLINE_REQUIRE_DATA("survey/gsi/gurob_gsi16_dms.gsi");
  const auto survey = read_gsi(test::read_file(test::data_file("survey/gsi/gurob_gsi16_dms.gsi")), "gurob.gsi");
  EXPECT_EQ(survey.observations.size(), 3u * 343u);
  ASSERT_EQ(survey.set_ups.size(), 1u);
  EXPECT_DOUBLE_EQ(survey.set_ups[0].instrument_height, 1.324);
  // 21.024+0000000003545100: 35 deg 45' 10.0"; 22.024+0000000009117510: 91 deg 17' 51.0".
  EXPECT_NEAR(value(survey, 0, direction), (35 + 45 / 60. + 10 / 3600.) * kDegree, 1e-15);
  EXPECT_NEAR(value(survey, 0, zenith_angle), (91 + 17 / 60. + 51 / 3600.) * kDegree, 1e-15);
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 13.825);
  EXPECT_EQ(survey.warnings.size(), 1u) << "the station has no name";
}

/// Two lines of an LS15 that holds heights and distances from the begin only; both begin at a height nobody keyed in.
TEST(Gsi, HeightsThatALevelStoredGiveDifferencesWhereNoStaffWasRead) {
  const auto s = read_gsi(
      "410001+?......4\n110002+00Y04H02 83..58+00000000\n110003+00000Z01 574..8+00100000 83..28+00000100\n"
      "110004+0000YSH4 574..8+00300000 83..28-00000050\n110006+00Y04H02 574..8+00700000 83..28+00000000\n"
      "410010+?......4\n110011+00Y02H01 83..58+00000000\n110012+00000Z01 574..8+00200000 83..28+00000030\n",
      "l.gsi");
  ASSERT_EQ(s.observations.size(), 4u);
  EXPECT_EQ(s.observations[1].from, "Z01");
  EXPECT_EQ(s.observations[1].to, "YSH4");
  EXPECT_NEAR(s.observations[1].value, -0.0015, 1e-12);
  EXPECT_NEAR(s.observations[1].levelling_length, 2.0, 1e-12);
  EXPECT_EQ(s.observations[3].from, "Y02H01") << "each line begins anew";
  for (const Point& p : s.points) EXPECT_FALSE(p.known[2]) << p.id << ": two heights of exactly 0 are none";
  ASSERT_EQ(s.warnings.size(), 2u);
}

TEST(GsiWriter, RealNetworkReadsBackTheSame) {
  PLUMBLINE_REQUIRE_DATA("survey/gsi/network_22_setups.GSI");
  const auto survey = read_gsi(test::read_file(test::data_file("survey/gsi/network_22_setups.GSI")), "network.GSI");
  const std::string text = write_gsi(survey);
  const auto again = read_gsi(text, "again.gsi");
  expect_same(survey, again, 1e-12);
  EXPECT_EQ(write_gsi(again), text);
}

bool warns_of(const SurveyObservations& survey, const std::string& words) {
  return std::any_of(survey.warnings.begin(), survey.warnings.end(),
                     [&](const std::string& w) { return w.find(words) != std::string::npos; });
}

/// A station at E 100, N 200, H 10 with its axis 1.5 m above, and sights of 50 m to the points on a quarter of a
/// circle.
std::string computed_coordinates(const std::vector<std::pair<std::string, Eigen::Vector3d>>& targets) {
  const auto word = [](const std::string& head, double value) {
    return fmt::format("{}{}{:016d} ", head, value < 0 ? '-' : '+', std::llround(std::abs(value)));
  };
  std::string text = "*110001+00000000000000S1 " + word("84..10", 100000) + word("85..10", 200000) +
                     word("86..10", 10000) + word("88..10", 1500) + "\n";
  double gon = 0;
  for (const auto& [name, offset] : targets) {
    const double angle = gon * std::numbers::pi / 200;
    const Eigen::Vector3d at = Eigen::Vector3d(100 + 50 * std::sin(angle), 200 + 50 * std::cos(angle), 11.5) + offset;
    text += fmt::format("*110002+{:0>16} ", name) + word("21.322", gon * 1e5) + word("22.322", 100e5) +
            word("31..00", 50000) + word("81..40", 1000 * at.x()) + word("82..40", 1000 * at.y()) +
            word("83..40", 1000 * at.z()) + word("87..10", 0) + "\n";
    gon += 10;
  }
  return text;
}

/// 81 to 83 have the middle of a tree, 21, 22 and 31 the prism in front of it. One such sighting was P3, two in a row
/// made a station of their own, and one in height another instrument height from there on.
TEST(Gsi, SightingsBesideTheirPointAreNotThePoint) {
  using P = std::pair<std::string, Eigen::Vector3d>;
  const Eigen::Vector3d none(0, 0, 0), east(0.4, 0, 0), down(0, 0, -0.4);
  const auto read = [](const std::vector<P>& targets) { return read_gsi(computed_coordinates(targets), "o.gsi"); };
  const auto names = [](const SurveyObservations& s) {
    std::string all;
    for (const Observation& o : s.observations)
      if (o.kind == direction) all += (all.empty() ? "" : ", ") + o.to;
    return all;
  };
  const auto sound = read({{"P1", none}, {"P2", none}, {"P3", none}, {"P4", none}});
  EXPECT_TRUE(sound.warnings.empty());
  const std::vector<std::vector<P>> cases = {{{"P1", none}, {"P2", none}, {"P3", east}, {"P4", none}},
                                             {{"P1", none}, {"P2", east}, {"P3", east}, {"P4", none}},
                                             {{"P1", none}, {"P2", none}, {"P3", down}, {"P4", none}},
                                             {{"P1", none}, {"P2", none}, {"P3", none}, {"P4", east}}};
  const char* const expected[] = {"P1, P2, P3 (sighted), P4", "P1, P2 (sighted), P3 (sighted), P4",
                                  "P1, P2, P3 (sighted), P4", "P1, P2, P3, P4 (sighted)"};
  for (size_t k = 0; k < cases.size(); ++k) {
    const auto survey = read(cases[k]);
    EXPECT_EQ(names(survey), expected[k]);
    ASSERT_EQ(survey.set_ups.size(), 1u) << k;
    EXPECT_TRUE(warns_of(survey, "an offset was keyed")) << k;
    EXPECT_TRUE(std::all_of(survey.observations.begin(), survey.observations.end(), [](const Observation& o) {
      return std::isnan(o.instrument_height);
    })) << k;
  }
}

/// Level with a line of sight that is off: forth and back it closes, and the height is wrong.
TEST(Gsi, SightsOfUnequalLengthAreToldOfALevel) {
  const auto line = [](int back, int ahead) {
    std::string text = "410001+?......1\n110002+00000BM1 83...8+10000000\n";
    for (int k = 0; k < 6; ++k)
      text += fmt::format(
          "11{:04d}+{:0>8} 32...8+{:08d} 331.08+00160000\n11{:04d}+{:0>8} 32...8+{:08d} 332.08+00040000\n", 2 * k + 3,
          k == 0 ? "BM1" : fmt::format("T{}", k), back * 100000, 2 * k + 4, fmt::format("T{}", k + 1), ahead * 100000);
    return read_gsi(text, "level.gsi");
  };
  EXPECT_EQ(line(30, 30).observations.size(), 6u);
  EXPECT_FALSE(warns_of(line(30, 30), "sights back and ahead"));
  EXPECT_TRUE(warns_of(line(40, 30), "between 'BM1' and 'T6' the level's sights back and ahead differ by 60 m in all"));
}

TEST(GsiWriter, AnySurveyReadsBackTheSame) {
  for (unsigned long long seed = 1; seed <= 50; ++seed) {
    auto survey = random_survey(seed);
    for (const auto start : {GsiStationStart::code_block, GsiStationStart::station_coordinates}) {
      const std::string text = write_gsi(survey, {.station_start = start});
      const auto again = read_gsi(text, "again.gsi");
      EXPECT_TRUE(again.skipped.empty());
      for (std::size_t i = 0; i < survey.observations.size() && i < again.observations.size(); ++i)
        survey.observations[i].set_number = again.observations[i].set_number;
      expect_same(survey, again, 1e-5);
      EXPECT_EQ(write_gsi(again, {.station_start = start}), text) << "seed " << seed;
    }
  }
}

TEST(GsiWriter, RefusesWhatGsiCannotHold) {
  const auto with = [](auto change) {
    auto survey = random_survey(1);
    change(survey);
    return survey;
  };
  using Survey = SurveyObservations;
  EXPECT_THROW(write_gsi(with([](Survey& s) { s.observations[0].to = "A NAME OF 17 CHARS"; })), std::runtime_error);
  EXPECT_THROW(write_gsi(with([](Survey& s) { s.observations[0].to = ""; })), std::runtime_error);
  EXPECT_THROW(write_gsi(with([](Survey& s) { s.observations[0].to = "\xD0\x96"; })), std::runtime_error);
  EXPECT_THROW(write_gsi(with([](Survey& s) { s.observations[0].to = "7", s.observations[3].to = "007"; })),
               std::runtime_error);
  EXPECT_THROW(write_gsi(with([](Survey& s) { s.observations[0].kind = azimuth; })), std::runtime_error);
  EXPECT_THROW(write_gsi(with([](Survey& s) { s.observations[0].set_up = -1; })), std::runtime_error);
  EXPECT_THROW(write_gsi(with([](Survey& s) { s.observations[2].value = 1e30; })), std::runtime_error);
  EXPECT_THROW(write_gsi(with([](Survey& s) { s.observations[1].kind = direction; })), std::runtime_error);
}

}  // namespace test_gsi
}  // namespace plumbline::survey
