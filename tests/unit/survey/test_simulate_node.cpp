// simulate.survey as a host runs it: the mistakes it plants are those that the words name, of the size they say.
#include <cmath>
#include <numbers>

#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_observations.hpp"
#include "node_harness.hpp"

namespace plumbline::test {
namespace test_simulate_node {

using survey::ObservationKind;

/// One set-up that sights M1, M2, M3 and M4 in this order, without noise; M5 is there, and it does not see it.
survey::SurveyObservations readings(const std::string& mistakes) {
  PointsT markers, stations;
  SurveyObservationsT planned;
  const Eigen::Vector3d places[] = {{0, 20, 1}, {4, 21, 2}, {8, 20, 3}, {-3, 22, 4}, {5, 22, 5}};
  for (int k = 0; k < 5; ++k) {
    auto point = std::make_unique<PointT>();
    point->id = "M" + std::to_string(k + 1), point->position = places[k];
    markers.points.push_back(std::move(point));
  }
  survey::SurveyObservations set_ups;
  survey::Point station;
  station.id = "S1", station.coordinates = Eigen::Vector3d(1, 2, 1.5);
  set_ups.points.push_back(station);
  set_ups.set_ups.push_back({"S1", "S1", 0, {}});
  for (int k = 0; k < 4; ++k) {
    survey::Observation sight;
    sight.set_up = 0, sight.from = "S1", sight.to = "M" + std::to_string(k + 1);
    set_ups.observations.push_back(sight);
  }
  NodeHarness node("simulate.survey");
  node.input<Points>("markers", markers);
  node.input<SurveyObservations>("set_ups", survey::to_artifact(set_ups));
  node.set("noise", "0");
  node.set("mistakes", mistakes);
  node.run();
  return survey::from_artifact(node.output<SurveyObservations>("observations"));
}

std::string fault_of(const std::string& mistake) {
  try {
    readings(mistake);
  } catch (const NodeFailed& failed) {
    return failed.what();
  }
  return "none";
}

/// How much each reading of a kind differs from what it was without the mistake, in the order of the sights.
std::vector<double> changes(const std::string& mistake, ObservationKind kind) {
  const auto sound = readings(""), wrong = readings(mistake);
  EXPECT_EQ(sound.observations.size(), 12u);
  std::vector<double> list;
  for (size_t i = 0; i < sound.observations.size(); ++i)
    if (sound.observations[i].kind == kind) list.push_back(wrong.observations[i].value - sound.observations[i].value);
  return list;
}

std::vector<std::string> names(const std::string& mistake) {
  std::vector<std::string> list;
  for (const auto& o : readings(mistake).observations)
    if (o.kind == ObservationKind::slope_distance) list.push_back(o.to);
  return list;
}

void expect(const std::string& mistake, ObservationKind kind, const std::vector<double>& expected) {
  const auto found = changes(mistake, kind);
  ASSERT_EQ(found.size(), expected.size()) << mistake;
  for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-9) << mistake << ", sight " << i + 1;
}

constexpr auto kDirection = ObservationKind::direction, kZenith = ObservationKind::zenith_angle,
               kDistance = ObservationKind::slope_distance;
constexpr double kGon = std::numbers::pi / 200;
const std::vector<double> kNone(4, 0.0);

TEST(SimulateSurveyNode, OneReadingIsWrongInGonOrMetres) {
  expect("reading S1 M2 direction 0.5", kDirection, {0, 0.5 * kGon, 0, 0});
  expect("reading S1 M2 direction 0.5", kZenith, kNone);
  expect("reading S1 M3 zenith -0.5", kZenith, {0, 0, -0.5 * kGon, 0});
  expect("reading S1 M4 distance 0.5", kDistance, {0, 0, 0, 0.5});
  expect("reading S1 M4 distance 0.5", kDirection, kNone);
}

TEST(SimulateSurveyNode, NamesAreExchangedOrAnotherIsNoted) {
  EXPECT_EQ(names("swap S1 M1 M3"), (std::vector<std::string>{"M3", "M2", "M1", "M4"}));
  EXPECT_EQ(names("name S1 M1 M5"), (std::vector<std::string>{"M5", "M2", "M3", "M4"}));
  expect("swap S1 M1 M3", kDistance, kNone);
}

TEST(SimulateSurveyNode, FromASightOnTheCircleIsTurnedOrTheInstrumentStandsElsewhere) {
  expect("circle S1 3 0.5", kDirection, {0, 0, 0.5 * kGon, 0.5 * kGon});
  expect("circle S1 3 0.5", kDistance, kNone);
  const auto of = [](double east, int k) {  // slope distance without the earth's curvature
    const Eigen::Vector3d places[] = {{0, 20, 1}, {4, 21, 2}, {8, 20, 3}, {-3, 22, 4}};
    return (places[k] - Eigen::Vector3d(1 + east, 2, 1.5)).norm();
  };
  const auto moved = changes("moved S1 3 0.2", kDistance);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(moved.at(k), k < 2 ? 0 : of(0.2, k) - of(0, k), 1e-5) << k;
  EXPECT_EQ(changes("moved S1 3 0.2", kDirection).at(1), 0);
  EXPECT_GT(std::abs(changes("moved S1 3 0.2", kDirection).at(2)), 1e-3);
}

TEST(SimulateSurveyNode, DistancesOfASetUpAreWrongTogether) {
  std::vector<double> lengths, scaled, in_feet;
  for (const auto& o : readings("").observations)
    if (o.kind == kDistance) lengths.push_back(o.value);
  for (const double length : lengths) scaled.push_back(1e-4 * length), in_feet.push_back(length / 0.3048 - length);
  expect("prism S1 0.0344", kDistance, {0.0344, 0.0344, 0.0344, 0.0344});
  expect("scale S1 1e-4", kDistance, scaled);
  expect("unit S1 0.3048", kDistance, in_feet);
  expect("height S1 0.1", kDistance, kNone);
  EXPECT_DOUBLE_EQ(
      readings("height S1 0.1").set_ups.at(0).instrument_height - readings("").set_ups.at(0).instrument_height, 0.1);
}

TEST(SimulateSurveyNode, WhatCannotBePlantedIsRefusedInWords) {
  EXPECT_EQ(fault_of("prism S9 0.1"), "mistakes: found 'prism S9 0.1', but there is no set-up 'S9'");
  EXPECT_EQ(fault_of("reading S1 M5 distance 0.1"),
            "mistakes: found 'reading S1 M5 distance 0.1', but S1 has no distance to M5");
  EXPECT_EQ(fault_of("reading S1 M1 length 0.1"),
            "mistakes: found 'reading S1 M1 length 0.1', but S1 has no length to M1");
  for (const char* unfinished : {"prism S1", "unit S1 0", "unit S1 -1", "circle S1 3", "reading S1 M1 distance"})
    EXPECT_EQ(fault_of(unfinished),
              "mistakes: found '" + std::string(unfinished) + "', a part of it is missing or no number");
  EXPECT_EQ(fault_of("swop S1 M1 M2").rfind("mistakes: found 'swop S1 M1 M2', expected one that begins with", 0), 0u);
}

/// 2.5 kB a sight were taken for 60 000; what takes less than 64 MB is not waited for.
TEST(SimulateSurveyNode, AnnouncesWhatItTakes) {
  const auto announced = [](int set_ups) {
    PointsT markers;
    survey::SurveyObservations planned;
    for (int k = 0; k < 1000; ++k) {
      auto point = std::make_unique<PointT>();
      point->id = "M" + std::to_string(k), point->position = {0.1 * k, 20, 1};
      markers.points.push_back(std::move(point));
    }
    for (int k = 0; k < set_ups; ++k) {
      survey::Point station;
      station.id = "S" + std::to_string(k), station.coordinates = Eigen::Vector3d(4 * k, 0, 1.5);
      planned.points.push_back(station);
      planned.set_ups.push_back({station.id, station.id, 0, {}});
      for (int m = 0; m < 1000; ++m) {
        survey::Observation sight;
        sight.set_up = k, sight.from = station.id, sight.to = "M" + std::to_string(m);
        planned.observations.push_back(sight);
      }
    }
    NodeHarness node("simulate.survey");
    node.input<Points>("markers", markers);
    node.input<SurveyObservations>("set_ups", survey::to_artifact(planned));
    node.run();
    EXPECT_EQ(survey::from_artifact(node.output<SurveyObservations>("observations")).observations.size(),
              3000u * static_cast<size_t>(set_ups));
    return node.announced();
  };
  EXPECT_EQ(announced(25), 25'000u * 2700u);
  EXPECT_EQ(announced(2), 0u);
}

}  // namespace test_simulate_node
}  // namespace plumbline::test
