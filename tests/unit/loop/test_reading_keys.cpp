// Readings of a campaign before in the folder of this one: found by their numbers, and not where rounded numbers agree
// by chance.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/random.hpp"
#include "loop/state/reading_keys.hpp"

namespace plumbline::loop {
namespace test_reading_keys {

/// `n` sightings of other points from each of two set-ups; angles as an instrument shows them, to 0.1 mgon.
SurveyObservationsT campaign(int n, std::uint64_t seed) {
  SurveyObservationsT out;
  Random random(seed, "readings");
  for (const char* name : {"S1", "S2"}) {
    auto set_up = std::make_unique<SurveySetUpT>();
    set_up->id = name, set_up->station = name;
    out.set_ups.push_back(std::move(set_up));
    for (int i = 0; i < n; ++i)
      for (const SurveyKind kind : {SurveyKind::direction, SurveyKind::zenith_angle, SurveyKind::slope_distance}) {
        auto one = std::make_unique<SurveyObservationT>();
        one->kind = kind, one->set_up = static_cast<int>(out.set_ups.size()) - 1, one->face = 1;
        one->pointing = n * one->set_up + i;
        one->from = name, one->to = "a" + std::to_string(i);
        one->value = kind == SurveyKind::slope_distance ? 20 + 1e-4 * std::round(10 * random.normal())
                     : kind == SurveyKind::zenith_angle ? M_PI / 2 + M_PI / 2e6 * std::round(10 * random.normal())
                                                        : M_PI / 2e6 * std::round(4e6 * random.uniform());
        out.observations.push_back(std::move(one));
      }
  }
  return out;
}

std::vector<std::string> hashes(const SurveyObservationsT& of) {
  std::vector<std::string> out;
  for (const ReadingKey& key : reading_keys(of)) out.push_back(key.hash);
  std::sort(out.begin(), out.end());
  return out;
}

TEST(ReadingKeys, AFolderThatHoldsOneSetUpOfTheDayBeforeIsFound) {
  const SurveyObservationsT monday = campaign(20, 1);
  SurveyObservationsT tuesday = campaign(20, 2);
  ASSERT_EQ(hashes(monday).size(), 40u);
  EXPECT_EQ(repeated_readings(reading_keys(tuesday), hashes(monday)).count, 0u);
  // Monday's second set-up, under another number of the file.
  for (const auto& one : monday.observations)
    if (one->set_up == 1 && one->to != "a0") {
      tuesday.observations.push_back(std::make_unique<SurveyObservationT>(*one));
      tuesday.observations.back()->set_up = 2, tuesday.observations.back()->pointing += 100;
    }
  tuesday.set_ups.push_back(std::make_unique<SurveySetUpT>(*monday.set_ups[1]));
  tuesday.set_ups.back()->id = "S2 (2)";
  const RepeatedReadings repeated = repeated_readings(reading_keys(tuesday), hashes(monday));
  EXPECT_EQ(repeated.count, 19u);
  EXPECT_EQ(repeated.all, 59u);
  EXPECT_EQ(repeated.set_ups, std::set<std::string>{"S2 (2)"});
  EXPECT_EQ(repeated.targets.count("a0"), 0u);
  EXPECT_EQ(repeated.targets.count("a1"), 1u);
  EXPECT_EQ(words_of(repeated).rfind(
                "19 of 59 readings are those of a campaign before, to the last digit (set-up S2 (2))", 0),
            0u)
      << words_of(repeated);
}

/// The circle set to zero at the mark that one begins with, and two that agree by chance.
TEST(ReadingKeys, TwoThatAgreeByChanceAreNoCampaignBefore) {
  const SurveyObservationsT monday = campaign(20, 1);
  SurveyObservationsT tuesday = campaign(20, 2);
  for (std::size_t i = 0; i < 6; ++i) tuesday.observations[i]->value = monday.observations[i]->value;
  EXPECT_EQ(repeated_readings(reading_keys(tuesday), hashes(monday)).count, 0u);
  EXPECT_TRUE(words_of(repeated_readings(reading_keys(tuesday), hashes(monday))).empty());
}

/// Coordinates in the frame of a set-up, as an instrument that tracks targets gives them.
TEST(ReadingKeys, CoordinatesOfASetUpAreReadingsToo) {
  SurveyObservationsT monday = campaign(1, 1), tuesday = campaign(1, 2);
  Random random(3, "places");
  for (int i = 0; i < 5; ++i) {
    auto place = std::make_unique<SurveyLocalCoordinateT>();
    place->set_up = 0, place->point = "a" + std::to_string(i), place->position = random.normal3(10);
    tuesday.local_coordinates.push_back(std::make_unique<SurveyLocalCoordinateT>(*place));
    monday.local_coordinates.push_back(std::move(place));
  }
  tuesday.local_coordinates[0]->position.x() += 0.0001;
  EXPECT_EQ(repeated_readings(reading_keys(tuesday), hashes(monday)).count, 4u);
}

/// `n` coordinates in the frame of a set-up, as a file with `digits` decimals has them, and off by `sigma`.
SurveyObservationsT coordinates(int n, int digits, double sigma = 0, std::uint64_t seed = 1) {
  SurveyObservationsT out = campaign(0, 1);
  Random places(3, "places"), errors(seed, "errors");
  for (int i = 0; i < n; ++i) {
    auto place = std::make_unique<SurveyLocalCoordinateT>();
    place->set_up = 0, place->point = "a" + std::to_string(i);
    const Eigen::Vector3d exact = places.normal3(10), off = errors.normal3(1);
    const double step = std::pow(10, -digits);
    // Of five decimals, which leaves ties.
    const Eigen::Vector3d first = 1e-5 * (1e5 * exact).array().round();
    place->position = step * ((first + sigma * off) / step).array().round();
    out.local_coordinates.push_back(std::move(place));
  }
  return out;
}

std::vector<std::string> all_hashes(const SurveyObservationsT& of) {
  std::vector<std::string> out;
  for (const ReadingKey& key : reading_keys(of)) {
    out.push_back(key.hash);
    out.insert(out.end(), key.rounded.begin(), key.rounded.end());
  }
  std::sort(out.begin(), out.end());
  return out;
}

TEST(ReadingKeys, ACampaignThatIsExportedAgainWithFewerDigitsIsFoundAndOneThatIsMeasuredIsNot) {
  for (const int before : {5, 6})
    for (const int digits : {3, 4}) {
      const std::vector<std::string> known = all_hashes(coordinates(20, before));
      const RepeatedReadings repeated = repeated_readings(reading_keys(coordinates(20, digits)), known);
      EXPECT_EQ(repeated.count, 20u) << before << " " << digits;
      EXPECT_EQ(words_of(repeated).find("20 of 20 readings are those of a campaign before, with fewer digits"), 0u)
          << words_of(repeated);
      for (std::uint64_t seed = 1; seed < 20; ++seed)
        EXPECT_EQ(repeated_readings(reading_keys(coordinates(20, digits, 0.0003, seed)), known).count, 0u) << digits;
      EXPECT_EQ(repeated_readings(reading_keys(coordinates(9, digits)), known).count, 0u) << "may be chance";
    }
}

}  // namespace test_reading_keys
}  // namespace plumbline::loop
