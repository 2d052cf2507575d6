#include "formats/gsi.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "test_support.hpp"

namespace plumbline::survey {
namespace {

constexpr double kGon = std::numbers::pi / 200;
constexpr double kDegree = std::numbers::pi / 180;

std::string fixture(const std::string& name) {
  return test::read_file(std::filesystem::path(PLUMBLINE_SOURCE_DIR) / "tests/unit/formats/fixtures" / name);
}

const Observation& observation(const SurveyObservations& survey, int pointing, ObservationKind kind) {
  for (const Observation& o : survey.observations)
    if (o.pointing == pointing && o.kind == kind) return o;
  throw std::runtime_error("no such observation of pointing " + std::to_string(pointing));
}

double value(const SurveyObservations& survey, int pointing, ObservationKind kind) {
  return observation(survey, pointing, kind).value;
}

const Point& point(const SurveyObservations& survey, const std::string& id) {
  for (const Point& p : survey.points)
    if (p.id == id) return p;
  throw std::runtime_error("no point " + id);
}

using enum ObservationKind;

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
  const auto skipped = [&](int line, int column, const std::string& expected) {
    for (const SkippedLine& s : survey.skipped)
      if (s.source.line == line && s.source.column == column) return s.expected.find(expected) != std::string::npos;
    return false;
  };
  EXPECT_TRUE(skipped(2, 50, "16 digits")) << "text where digits belong";
  EXPECT_TRUE(skipped(3, 74, "16 digits")) << "a number cut in half must not become another number";
  EXPECT_TRUE(skipped(4, 26, "GSI word"));
  EXPECT_TRUE(skipped(5, 1, "GSI word"));
  EXPECT_TRUE(skipped(7, 26, "minutes and seconds below 60"));
  EXPECT_TRUE(skipped(7, 74, "100 km"));
  EXPECT_TRUE(skipped(8, 2, "code word"));
  EXPECT_TRUE(skipped(10, 2, "the line seems cut"));
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

// Everything of `survey` that GSI holds, compared to `tolerance` [rad, m].
void expect_same(const SurveyObservations& a, const SurveyObservations& b, double tolerance) {
  ASSERT_EQ(a.set_ups.size(), b.set_ups.size());
  for (std::size_t i = 0; i < a.set_ups.size(); ++i) {
    EXPECT_EQ(a.set_ups[i].station, b.set_ups[i].station);
    EXPECT_NEAR(a.set_ups[i].instrument_height, b.set_ups[i].instrument_height, tolerance);
  }
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    const Observation &x = a.observations[i], &y = b.observations[i];
    EXPECT_EQ(x.kind, y.kind);
    EXPECT_EQ(x.set_up, y.set_up);
    EXPECT_EQ(x.pointing, y.pointing);
    EXPECT_EQ(x.to, y.to);
    EXPECT_EQ(x.face, y.face);
    EXPECT_EQ(x.set_number, y.set_number);
    EXPECT_NEAR(std::remainder(x.value - y.value, 2 * std::numbers::pi), 0, tolerance);
    const auto height = [](const SurveyObservations& s, const Observation& o) {
      return std::isnan(o.instrument_height) ? s.set_ups[static_cast<std::size_t>(o.set_up)].instrument_height
                                             : o.instrument_height;
    };
    EXPECT_NEAR(height(a, x), height(b, y), tolerance);
    EXPECT_NEAR(std::isnan(x.target_height) ? 0 : x.target_height, y.target_height, tolerance);
  }
}

TEST(GsiWriter, RealNetworkReadsBackTheSame) {
  PLUMBLINE_REQUIRE_DATA("survey/gsi/network_22_setups.GSI");
  const auto survey = read_gsi(test::read_file(test::data_file("survey/gsi/network_22_setups.GSI")), "network.GSI");
  const std::string text = write_gsi(survey);
  const auto again = read_gsi(text, "again.gsi");
  expect_same(survey, again, 1e-12);
  EXPECT_EQ(write_gsi(again), text);
}

// Small generator of the tests; the standard distributions differ between libraries.
struct Random {
  unsigned long long state;
  double uniform(double low, double high) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return low + (high - low) * static_cast<double>(state >> 11) / 9007199254740992.0;
  }
};

SurveyObservations random_survey(unsigned long long seed) {
  Random random{seed};
  SurveyObservations survey;
  const auto add_point = [&](const std::string& id) {
    Point p;
    p.id = id;
    if (random.uniform(0, 1) < 0.5)
      p.coordinates = {random.uniform(-5000, 5000), random.uniform(-5000, 5000), random.uniform(-10, 100)};
    survey.points.push_back(p);
  };
  for (int s = 0; s < 3; ++s) {
    SetUp set_up;
    set_up.id = set_up.station = "S-" + std::to_string(s);
    set_up.instrument_height = random.uniform(0, 2);
    add_point(set_up.id);
    survey.set_ups.push_back(set_up);
  }
  for (int p = 0; p < 8; ++p) add_point("TOR \xC3\x9C " + std::to_string(p));
  for (int pointing = 0; pointing < 60; ++pointing) {
    Observation o;
    o.set_up = pointing / 20;
    o.pointing = pointing;
    o.from = survey.set_ups[static_cast<std::size_t>(o.set_up)].station;
    o.to = survey.points[3 + static_cast<std::size_t>(random.uniform(0, 7.99))].id;
    o.target_height = random.uniform(-1, 3);
    if (pointing % 20 != 0 && random.uniform(0, 1) < 0.2) o.instrument_height = random.uniform(0, 2);
    const double zenith = random.uniform(1e-4, 2 * std::numbers::pi - 1e-4);
    o.face = zenith > std::numbers::pi ? 2 : 1;
    const auto add = [&](ObservationKind kind, double v) {
      o.kind = kind;
      o.value = v;
      survey.observations.push_back(o);
    };
    add(direction, random.uniform(0, 2 * std::numbers::pi));
    add(zenith_angle, zenith);
    if (random.uniform(0, 1) < 0.8) add(slope_distance, random.uniform(0.5, 3000));
  }
  return survey;
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

}  // namespace
}  // namespace plumbline::survey
