// survey.join as a host runs it, and what survey.adjust makes of its list in either order.
#include <algorithm>
#include <cmath>

#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/survey_readings.hpp"
#include "node_harness.hpp"
#include "simulated_network.hpp"

namespace plumbline::test {
namespace test_join_node {

SurveyObservationsT sensor(const std::string& file, std::uint64_t seed, const std::string& instrument,
                           bool far_away = false) {
  survey::test::SimulationSettings settings;
  settings.set_ups = 1;
  settings.sigmas = false;
  auto n = survey::test::simulate(settings, seed);
  n.survey.files = {file};
  n.survey.info.format = "gsi";
  n.survey.info.instrument = instrument;
  // Sights of another part of the site: no target in common, and coordinates that do not tell of the station.
  if (far_away) {
    for (auto& o : n.survey.observations) o.to[0] = 'N';
    for (auto& p : n.survey.points) {
      if (p.id[0] == 'M') p.id[0] = 'N';
      if (p.id[0] == 'S') p.coordinates.setConstant(survey::kNotGiven);
    }
  }
  return survey::to_artifact(n.survey);
}

NodeHarness joined(const std::vector<SurveyObservationsT>& readings, const PointsT* known = nullptr) {
  NodeHarness node("survey.join");
  for (const auto& r : readings) node.input<SurveyObservations>("observations", r);
  if (known) node.input<Points>("known", *known);
  node.run();
  return node;
}

bool warns(const SurveyObservationsT& survey, const std::string& text) {
  return std::any_of(survey.warnings.begin(), survey.warnings.end(),
                     [&](const std::string& w) { return w.find(text) != std::string::npos; });
}

TEST(JoinNode, AStationOnAKnownPointIsOneMark) {
  const std::vector<SurveyObservationsT> two = {sensor("monday.gsi", 1, ""), sensor("tuesday.gsi", 2, "", true)};
  const SurveyObservationsT apart = joined(two).output<SurveyObservations>("observations");
  EXPECT_TRUE(warns(apart, "monday:S1, tuesday:S1")) << "the result's page must be able to tell";
  EXPECT_EQ(apart.set_ups.at(1)->station, "tuesday:S1");

  PointsT known;
  auto point = std::make_unique<PointT>();
  point->id = "S1";
  point->position = Eigen::Vector3d(98, 235, 1.6);
  known.points.push_back(std::move(point));
  const SurveyObservationsT one = joined(two, &known).output<SurveyObservations>("observations");
  EXPECT_TRUE(warns(one, "station S1 of monday, tuesday was united to one point: it is a known point"));
  EXPECT_EQ(one.set_ups.at(1)->station, "S1");
  EXPECT_EQ(one.observations.size(), two[0].observations.size() + two[1].observations.size());
}

TEST(JoinNode, OneReaderPassesThroughAsItIs) {
  const SurveyObservationsT only = sensor("monday.gsi", 1, "TS16");
  const SurveyObservationsT out = joined({only}).output<SurveyObservations>("observations");
  EXPECT_EQ(out.observations.size(), only.observations.size());
  EXPECT_EQ(survey::from_artifact(out).info.instrument, "TS16");
  EXPECT_EQ(out.warnings.size(), only.warnings.size());
}

SurveyNetworkT adjusted(const std::vector<SurveyObservationsT>& readings) {
  NodeHarness node("survey.adjust");
  node.set("datum", "inner");
  for (const auto& r : readings) node.input<SurveyObservations>("observations", r);
  node.run();
  return node.output<SurveyNetwork>("network");
}

TEST(JoinNode, TwoInstrumentsKeepTheirProfilesWhicheverIsConnectedFirst) {
  const SurveyObservationsT precise = sensor("campaign.gsi", 1, "total_station_1arcsec"),
                            silent = sensor("tracker.gsi", 2, "");
  const auto join = [](const auto& a, const auto& b) {
    return joined({a, b}).template output<SurveyObservations>("observations");
  };
  for (const auto& readings : {std::vector{precise, silent}, std::vector{silent, precise},
                               std::vector{join(precise, silent)}, std::vector{join(silent, precise)}}) {
    const std::string model = adjusted(readings).stochastic_model;
    EXPECT_NE(model.find("total_station_1arcsec"), std::string::npos) << model;
    EXPECT_NE(model.find("ics50_assumed"), std::string::npos) << model;
    EXPECT_NE(model.find("used for 36 of 72 readings"), std::string::npos) << model;
  }
  EXPECT_TRUE(warns(join(precise, silent), "the instrument that the files name differs"));
}

SurveyReadingsT offered(const std::string& reader, const std::vector<std::string>& paths) {
  SurveyReadingsT readings;
  for (const std::string& path : paths) {
    auto one = std::make_unique<ReadSurveyFileT>();
    one->path = path, one->reader = reader;
    readings.files.push_back(std::move(one));
  }
  return readings;
}

NodeHarness collected(const std::vector<SurveyReadingsT>& offers, const std::vector<SurveyObservationsT>& read) {
  NodeHarness node("survey.collect");
  for (const auto& o : offers) node.input<SurveyReadings>("offered", o);
  for (const auto& r : read) node.input<SurveyObservations>("observations", r);
  return node;
}

/// Readers may be connected in any order: each file gets what was read of it, by its name.
TEST(CollectNode, PairsReadingsWithTheirFilesByName) {
  const std::vector<SurveyReadingsT> offers = {offered("read.x", {"b.x", "a.x"}), offered("read.y", {"c.y"})};
  NodeHarness node = collected(offers, {sensor("c.y", 3, "C"), sensor("a.x", 1, "A"), sensor("b.x", 2, "B")});
  node.run();
  const auto all = node.output<SurveyReadings>("readings");
  ASSERT_EQ(all.files.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(all.files[i]->path, (std::vector<std::string>{"a.x", "b.x", "c.y"})[i]);
    EXPECT_EQ(all.files[i]->observations->files.at(0), all.files[i]->path);
    EXPECT_EQ(survey::from_artifact(*all.files[i]->observations).info.instrument, std::string(1, "ABC"[i]));
  }
  EXPECT_EQ(all.files[2]->reader, "read.y");
}

TEST(CollectNode, RefusesReadingsOfOtherFiles) {
  const std::vector<SurveyReadingsT> offers = {offered("read.x", {"a.x", "b.x"})};
  const auto refusal = [&](const std::vector<SurveyObservationsT>& read) { return collected(offers, read).outcome(); };
  EXPECT_NE(refusal({sensor("a.x", 1, ""), sensor("c.x", 2, "")}).find("observations[1] is of c.x"), std::string::npos);
  EXPECT_NE(refusal({sensor("a.x", 1, ""), sensor("a.x", 2, "")}).find("a.x was read twice"), std::string::npos);
  EXPECT_NE(refusal({sensor("a.x", 1, "")}).find("b.x was given to read.x"), std::string::npos);
  auto of_two = sensor("a.x", 1, "");
  of_two.files.push_back("b.x");
  EXPECT_NE(refusal({of_two}).find("names 2 files"), std::string::npos);
}

}  // namespace test_join_node
}  // namespace plumbline::test
