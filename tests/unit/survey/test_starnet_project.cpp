// Instruments of a STAR*NET project. Keys and units as in two public projects (version 13, jeelojacko/webnet,
// tests/fixtures/*.snproj), whose listing says "Differential Levels 0.0015 Meters / Km" for 0.0000474 here.
#include <gtest/gtest.h>

#include <numbers>

#include "survey/model/starnet_project.hpp"

namespace plumbline::survey {
namespace test_starnet_project {

constexpr double kSecond = std::numbers::pi / 180 / 3600;

const std::string kInstrument =
    "distance_std_err 0.001\nedm_ppm 1.5\nangle_std_err 1.414\ndirection_std_err 1.0\nazimuth_std_err 1.2\n"
    "zenith_std_err 3.0\ndelta_elev_std_err 0.01524\ninstrument_centering_error 0.00075\n"
    "target_centering_error 0.0005\nvertical_centering_error 0.0005\n";

std::string project(const std::string& units = "Meters") {
  return "*STAR*NET 3\n#\n# 13.0.2\n[Adjustment]\n#\nlinear_units   " + units +
         "\nlocal_or_grid_adjustment 1\ncoordinate_system_name UTM83-19\ncoordinate_order EN\n"
         "angle_station_order At-From-To\nindex_of_refraction 0.07\nscale_factor 1.0\n[Instrument]\n" +
         kInstrument +
         "level_section_type LENGTH\nlevel_std_err 0.000047434164903\n[InstrumentLibrary]\ninstrument_name S9\n" +
         kInstrument + "direction_std_err 0.5\ninstrument_name SX 12\n" + kInstrument +
         "[DataFileList]\n0 \"Off.dat\"\n3 \"Day one.dat\"\n2 \"Checked, off.dat\"\n1 \"Two.dat\"\n";
}

std::string error_of(const std::string& text) {
  try {
    parse_starnet_project(text, "job.snproj");
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST(StarNetProject, HasItsInstruments) {
  const StarNetProject p = parse_starnet_project(project(), "job.snproj");
  EXPECT_NEAR(p.instrument.direction_sigma, kSecond, 1e-15);
  EXPECT_NEAR(p.instrument.angle_sigma, 1.414 * kSecond, 1e-15);
  EXPECT_NEAR(p.instrument.azimuth_sigma, 1.2 * kSecond, 1e-15);
  EXPECT_NEAR(p.instrument.zenith_sigma, 3 * kSecond, 1e-15);
  EXPECT_EQ(p.instrument.distance_constant, 0.001);
  EXPECT_EQ(p.instrument.distance_ppm, 1.5);
  EXPECT_EQ(p.instrument.instrument_centring, 0.00075);
  EXPECT_EQ(p.instrument.target_centring, 0.0005);
  EXPECT_NEAR(p.instrument.height_centring, std::numbers::sqrt2 * 0.0005, 1e-15);
  EXPECT_NEAR(p.instrument.height_difference_per_sqrt_km, 0.0015, 1e-9);
  ASSERT_EQ(p.library.size(), 2u);
  EXPECT_NEAR(p.library.at("S9").direction_sigma, 0.5 * kSecond, 1e-15);
  EXPECT_NEAR(p.library.at("SX 12").height_difference_per_sqrt_km, 0.0015, 1e-9);
  EXPECT_EQ(p.files, (std::vector<std::string>{"Day one.dat", "Two.dat"}));
}

TEST(StarNetProject, SaysWhatElseItSets) {
  std::string all;
  for (const std::string& s : parse_starnet_project(project(), "job.snproj").settings) all += s + "; ";
  for (const char* words : {"coordinates EN, angles At-From-To", "the map UTM83-19", "refraction_coefficient=0.14"})
    EXPECT_NE(all.find(words), std::string::npos) << all;
  EXPECT_EQ(all.find("scale factor"), std::string::npos);
}

TEST(StarNetProject, WhatIsNotOneIsRefusedByItsLine) {
  EXPECT_TRUE(is_starnet_project("\n*STAR*NET 3\n"));
  EXPECT_FALSE(is_starnet_project("name: mine\n"));
  EXPECT_NE(error_of(project("FeetUS")).find("job.snproj:6: linear_units are 'FeetUS'"), std::string::npos);
  std::string wrong = project();
  wrong.replace(wrong.find("edm_ppm 1.5"), 11, "edm_ppm x.5");
  EXPECT_NE(error_of(wrong).find("edm_ppm is 'x.5'"), std::string::npos) << error_of(wrong);
  wrong = project();
  wrong.replace(wrong.find("zenith_std_err"), 14, "zenith_other  ");
  EXPECT_NE(error_of(wrong).find("the instrument has no zenith_std_err"), std::string::npos) << error_of(wrong);
  EXPECT_NE(error_of("*STAR*NET 3\n").find("no linear_units"), std::string::npos);
}

}  // namespace test_starnet_project
}  // namespace plumbline::survey
