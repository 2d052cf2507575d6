// Jobs of STAR*NET beside the listings of the program itself (STAR*NET-PRO 12, public files of jeelojacko/webnet,
// tests/fixtures/industry_case_*). Instruments and options are those of the head of each listing.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "survey/adjust/adjust_network.hpp"
#include "survey/files/starnet.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_starnet_listings {

constexpr double kSecond = std::numbers::pi / 180 / 3600;
const char* const kLevels = "survey/starnet/leveling_input.txt";
const char* const kLevelsListing = "survey/starnet/leveling_output.txt";
// The names of these two are exchanged: the output is the data, the input the listing.
const char* const kTraverse = "survey/starnet/traverse_output.txt";
const char* const kCombined = "survey/starnet/combined_input.txt";
const char* const kCombinedListing = "survey/starnet/combined_output.txt";
const char* const kTraverseListing = "survey/starnet/traverse_input.txt";
const char* const kVectors = "survey/starnet/gnss_input.txt";
const char* const kVectorsListing = "survey/starnet/gnss_output.txt";
const char* const kUnderground = "survey/starnet/underground_input.txt";
const char* const kUndergroundListing = "survey/starnet/underground_output.txt";

/// Rows of a table of the listing: a name and numbers, `least` or more, from `head` on to the first row that is none.
std::map<std::string, std::vector<double>> table(const std::string& listing, const std::string& head,
                                                 std::size_t least = 3) {
  std::map<std::string, std::vector<double>> rows;
  std::istringstream text(listing.substr(listing.find(head)));
  std::string line;
  while (std::getline(text, line)) {
    std::istringstream words(line);
    std::string name;
    std::vector<double> numbers;
    words >> name;
    for (double number = 0; words >> number;) numbers.push_back(number);
    if (numbers.size() >= least)
      rows[name] = numbers;
    else if (!rows.empty())
      break;
  }
  return rows;
}

TEST(StarNetListings, LevellingOfTwelvePoints) {
  PLUMBLINE_REQUIRE_DATA(kLevels);
  AdjustOptions options;
  options.profile.height_difference_per_sqrt_km = 1.5e-3;
  const NetworkResult r =
      adjust_network(read_starnet(test::read_file(test::data_file(kLevels)), "leveling.dat"), options);
  const auto listed = table(test::read_file(test::data_file(kLevelsListing)), "Adjusted Elevations and Error");
  ASSERT_EQ(listed.size(), 12u);
  for (const auto& [id, values] : listed) {
    EXPECT_NEAR(r.point(id).position.z(), values[0], 5.1e-5) << id;
    EXPECT_NEAR(r.sigma(r.point(id)).z(), values[1], 1e-6) << id;
  }
  EXPECT_NEAR(r.sigma0, 0.905, 5e-4);
  EXPECT_EQ(r.validity, Validity::sound);
}

InstrumentProfile instrument(double direction, double zenith, double constant, double ppm) {
  InstrumentProfile p;
  p.direction_sigma = direction * kSecond, p.zenith_sigma = zenith * kSecond;
  p.distance_constant = constant, p.distance_ppm = ppm;
  p.instrument_centring = p.target_centring = 1.5e-3;
  p.height_centring = std::numbers::sqrt2 * 0.5e-3;  // of each end
  return p;
}

std::map<std::string, InstrumentProfile> instruments_of_the_job() {
  return {{"S9", instrument(0.87377, 3.28473, 3e-3, 2)},
          {"SX12", instrument(0.671807, 6.064437, 3e-3, 1.5)},
          {"TS11", instrument(1.302108, 4.41756, 2e-3, 1.5)}};
}

struct Differences {
  size_t points = 0;
  double plan = 0, height = 0, sigma = 0;  ///< largest [m], and of standard deviations relative to the listing's
};

Differences beside(const NetworkResult& r, const std::string& listing, const std::string& fixed) {
  const auto listed = table(listing, "Adjusted Coordinates (Meters)"),
             sigmas = table(listing, "Station Coordinate Standard Deviations");
  Differences d;
  d.points = listed.size();
  for (const auto& [id, values] : listed) {
    const ResultPoint& p = r.point(id);
    const Eigen::Vector3d off = p.position - Eigen::Vector3d(values[1], values[0], values[2]);
    d.plan = std::max(d.plan, off.head<2>().norm());
    d.height = std::max(d.height, std::abs(off.z()));
    const auto own = sigmas.find(id);
    if (id == fixed || own == sigmas.end()) continue;
    const Eigen::Vector3d theirs(own->second[1], own->second[0], own->second[2]);
    d.sigma = std::max(d.sigma, ((r.sigma(p) - theirs).array().abs() / theirs.array()).maxCoeff());
  }
  return d;
}

AdjustOptions options_of_the_job() {
  AdjustOptions options;
  options.instruments = instruments_of_the_job();
  options.profile = instrument(1, 1, 1e-3, 1.5);
  for (auto& [name, profile] : options.instruments) profile.height_difference_per_sqrt_km = 1.5e-3;
  options.profile.height_difference_per_sqrt_km = 1.5e-3;
  options.centring_per_set_up = false;
  // "Default Coefficient of Refraction 0.07" of the listing is that of (1 - 2 m) s^2 / 2R, half of ours.
  options.refraction_coefficient = 0.14;
  options.map = "EPSG:2953";
  return options;
}

/// 42 points, 1 354 readings of three instruments in 149 direction sets, on the double stereographic map of New
/// Brunswick: without the map the coordinates are up to 53 mm off, and everything looks sound.
TEST(StarNetListings, TraverseOnTheMapOfNewBrunswick) {
  PLUMBLINE_REQUIRE_DATA(kTraverse);
  const AdjustOptions options = options_of_the_job();
  const SurveyObservations survey = read_starnet(test::read_file(test::data_file(kTraverse)), "traverse.dat");
  EXPECT_TRUE(survey.skipped.empty());
  const NetworkResult r = adjust_network(survey, options);
  EXPECT_EQ(r.degrees_of_freedom, 1064);
  EXPECT_NEAR(r.sum_of_squares, 1153.55, 1);  // of the listing
  const Differences d = beside(r, test::read_file(test::data_file(kTraverseListing)), "GPS5");
  EXPECT_EQ(d.points, 42u);
  EXPECT_LT(d.plan, 1e-4);
  EXPECT_LT(d.height, 6e-5);
  EXPECT_LT(d.sigma, 0.002);
  AdjustOptions plane = options;
  plane.map = "";
  EXPECT_GT((adjust_network(survey, plane).point("GPS3").position - r.point("GPS3").position).norm(), 0.03);
}

/// The same with twelve GNSS vectors and sixty levelled lines in one network; side shots take no part.
TEST(StarNetListings, TraverseWithVectorsAndLevelling) {
  PLUMBLINE_REQUIRE_DATA(kCombined);
  const SurveyObservations survey = read_starnet(test::read_file(test::data_file(kCombined)), "combined.dat");
  EXPECT_TRUE(survey.skipped.empty()) << survey.skipped.front().found << ": " << survey.skipped.front().expected;
  EXPECT_EQ(survey.vectors.size(), 12u);
  const NetworkResult r = adjust_network(survey, options_of_the_job());
  const Differences d = beside(r, test::read_file(test::data_file(kCombinedListing)), "FRDN");
  EXPECT_EQ(r.degrees_of_freedom, 1302);
  EXPECT_NEAR(r.sum_of_squares, 1250.71, 0.5);  // of the listing
  EXPECT_EQ(d.points, 43u);
  EXPECT_LT(d.plan, 1e-4);
  EXPECT_LT(d.height, 6e-5);
  EXPECT_LT(d.sigma, 0.002);
}

/// Fifteen GNSS vectors. Where the listing's correlations show the factor 1.2 of two of them the data say 1: in plan
/// four standard deviations are up to 10 % off, in height none.
TEST(StarNetListings, FifteenVectors) {
  PLUMBLINE_REQUIRE_DATA(kVectors);
  PLUMBLINE_REQUIRE_DATA(kVectorsListing);
  AdjustOptions options = options_of_the_job();
  options.geoid.slope_sigma = 0;
  const NetworkResult r = adjust_network(read_starnet(test::read_file(test::data_file(kVectors)), "gnss.dat"), options);
  const std::string listing = test::read_file(test::data_file(kVectorsListing));
  EXPECT_EQ(r.degrees_of_freedom, 27);
  EXPECT_NEAR(r.sigma0, 1.225, 0.01);
  const Differences d = beside(r, listing, "FRDN");
  EXPECT_EQ(d.points, 7u);
  EXPECT_LT(d.plan, 1.5e-4);
  EXPECT_LT(d.height, 6e-5);
  EXPECT_LT(d.sigma, 0.11);
}

/// A traverse underground of 16 points, angles and distances of a plan, sights of 0.4 to 34 m: the centring decides.
TEST(StarNetListings, TraverseUnderground) {
  PLUMBLINE_REQUIRE_DATA(kUnderground);
  PLUMBLINE_REQUIRE_DATA(kUndergroundListing);
  AdjustOptions options;
  options.profile = instrument(0.5, 1, 1e-3, 1);
  options.profile.angle_sigma = 0.5 * kSecond;
  options.profile.instrument_centring = 0.5e-3, options.profile.target_centring = 0;
  options.centring_per_set_up = false;
  const SurveyObservations survey = read_starnet(test::read_file(test::data_file(kUnderground)), "underground.dat");
  EXPECT_TRUE(survey.skipped.empty());
  const NetworkResult r = adjust_network(survey, options);
  EXPECT_EQ(r.degrees_of_freedom, 134);
  EXPECT_NEAR(r.sum_of_squares, 149.176, 0.2);
  const std::string listing = test::read_file(test::data_file(kUndergroundListing));
  const auto listed = table(listing, "Adjusted Coordinates (Meters)", 2),
             sigmas = table(listing, "Station Coordinate Standard Deviations", 2);
  ASSERT_EQ(listed.size(), 16u);
  for (const auto& [id, values] : listed) {
    const ResultPoint& p = r.point(id);
    EXPECT_LT((p.position.head<2>() - Eigen::Vector2d(values[1], values[0])).norm(), 1.5e-4) << id;
    if (sigmas.at(id)[0] == 0) continue;
    EXPECT_NEAR(r.sigma(p).y() / sigmas.at(id)[0], 1, 0.01) << id;
    EXPECT_NEAR(r.sigma(p).x() / sigmas.at(id)[1], 1, 0.01) << id;
  }
}

}  // namespace test_starnet_listings
}  // namespace plumbline::survey
