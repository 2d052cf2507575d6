// plan.survey, survey.compare_epochs and survey.check_control as a host runs them, with survey.adjust before them.
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "artifacts/file.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_comparison.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/survey_plan.hpp"
#include "geometry/statistics.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "record.hpp"
#include "simulated_network.hpp"
#include "stopping.hpp"

namespace plumbline::test {
namespace test_nodes {

using survey::ObservationKind;

/// Two set-ups before two floors; S2 does not see the last marker.
const char* const kLayout =
    "kind;id;east_m;north_m;height_m;floor;column;facing_azimuth_deg;sees\n"
    "marker;F1-C1-R1;0,0;0,0;1,0;1;1;180;\n"
    "marker;F1-C2-R1;2,0;0,1;1,0;1;2;180;\n"
    "marker;F1-C3-R1;4,0;0,0;1,0;1;3;180;\n"
    "marker;F1-C1-R2;0,0;0,0;3,0;1;1;180;\n"
    "marker;F1-C2-R2;2,0;0,1;3,0;1;2;180;\n"
    "marker;F1-C3-R2;4,0;0,0;3,0;1;3;180;\n"
    "marker;F2-C1-R1;0,0;0,0;5,0;2;1;180;\n"
    "marker;F2-C2-R1;2,0;0,1;5,0;2;2;180;\n"
    "marker;F2-C3-R1;4,0;0,0;5,0;2;3;180;\n"
    "marker;F2-C1-R2;0,0;0,0;7,0;2;1;180;\n"
    "marker;F2-C2-R2;2,0;0,1;7,0;2;2;180;\n"
    "marker;F2-C3-R2;4,0;0,0;7,0;2;3;180;\n"
    "set_up;S1;-2,0;-12,0;1,6;;;;\n"
    "set_up;S2;6,0;-13,0;1,6;;;;F1-* F2-C?-R1 F2-C1-R2 F2-C2-R2\n";

FileT file_of(const std::string& text) {
  FileT file;
  file.name = "layout.csv";
  file.content.assign(text.begin(), text.end());
  return file;
}

NodeHarness planned(const std::string& layout, const std::map<std::string, std::string>& settings = {}) {
  NodeHarness reader("read.layout");
  reader.input<File>("file", file_of(layout));
  reader.run();
  NodeHarness plan("plan.survey");
  plan.set("profile", "total_station_1arcsec");
  for (const auto& [name, value] : settings) plan.set(name, value);
  plan.input<Points>("markers", reader.output<Points>("markers"));
  plan.input<Plates>("plates", reader.output<Plates>("plates"));
  plan.input<SurveyObservations>("set_ups", reader.output<SurveyObservations>("set_ups"));
  plan.run();
  return plan;
}

TEST(PlanNode, NamesTheBrokenRuleAndTheSightThatMendsIt) {
  const NodeHarness node = planned(kLayout);
  const auto plan = node.output<SurveyPlan>("plan");
  EXPECT_FALSE(plan.holds);
  for (const auto& rule : plan.rules) EXPECT_EQ(rule->holds, rule->name != "set-ups per marker") << rule->text;
  ASSERT_EQ(plan.remedies.size(), 1u);
  EXPECT_EQ(plan.remedies[0]->text, "sight F2-C3-R2 also from S2");
  EXPECT_EQ(plan.remedies[0]->sightings, 1);
  EXPECT_EQ(plan.sights.size(), 23u);
  EXPECT_EQ(plan.points.size(), 14u);
  EXPECT_EQ(plan.ellipsoids.size(), 14u);
  EXPECT_EQ(plan.datum_points.size(), 6u);
  EXPECT_EQ(plan.transfers.size(), 4u);
  EXPECT_EQ(plan.drifts.size(), 2u);
  ASSERT_EQ(node.warnings().size(), 1u);
  EXPECT_EQ(node.warnings()[0], "set-ups per marker: seen from fewer than 2 set-ups: F2-C3-R2");
}

/// Each limit with its rule and in the unit that the rule says.
TEST(PlanNode, EachLimitIsThatOfItsRule) {
  const auto rule = [](const std::string& name, const std::map<std::string, std::string>& settings) {
    const auto plan = planned(kLayout, settings).output<SurveyPlan>("plan");
    for (const auto& one : plan.rules)
      if (one->name == name) return (one->holds ? "holds: " : "broken: ") + one->text;
    return "no rule " + name;
  };
  const auto expect = [&](const std::string& name, const std::map<std::string, std::string>& settings,
                          const std::string& begins, const std::string& says) {
    const std::string found = rule(name, settings);
    EXPECT_EQ(found.rfind(begins, 0), 0u) << found;
    EXPECT_NE(found.find(says), std::string::npos) << found;
  };
  expect("set-ups per marker", {{"set_ups_per_marker", "1"}}, "holds", "at least 1 set-ups");
  expect("set-ups per marker", {{"set_ups_per_marker", "3"}}, "broken", "fewer than 3 set-ups");
  expect("shared markers, floors 1 and 2", {{"shared_markers", "5"}}, "holds", "wanted 5");
  expect("shared markers, floors 1 and 2", {{"shared_markers", "7"}}, "broken", "wanted 7");
  expect("markers per floor", {{"markers_per_floor", "7"}}, "broken", "wanted 7");
  expect("marker spacing", {{"spacing", "2.6"}}, "broken", "2.6 m (± 0.5 m)");
  expect("marker spacing", {{"spacing", "2.6"}, {"spacing_tolerance", "0.7"}}, "holds", "2.6 m (± 0.7 m)");
  // S2 is to sight markers up to 16.5 m away, up to 33° from straight on, and up to 24° above itself.
  expect("range and incidence", {}, "holds", "60 m, incidence 60 deg, elevation 50 deg");
  expect("range and incidence", {{"largest_range", "15"}}, "broken", "15 m, incidence 60 deg, elevation 50 deg");
  expect("range and incidence", {{"largest_incidence", "24"}}, "broken", "60 m, incidence 24 deg, elevation 50 deg");
  expect("range and incidence", {{"steepest_sight", "18"}}, "broken", "60 m, incidence 60 deg, elevation 18 deg");
  expect("height transfer, floor 1 to 2", {}, "holds", "wanted 1.00 mm");
  expect("height transfer, floor 1 to 2", {{"tolerance", "0.0005"}}, "broken", "wanted 0.10 mm");
}

TEST(PlanNode, EveryParameterHasItsEffect) {
  const Situation situation = [] {
    NodeHarness node = planned(kLayout);
    node.set("profile", "automatic");
    return node;
  };
  EXPECT_EQ(parameters_at_fault({situation}), "");
}

/// By the coordinates of the layout, and precision by what the artifact has of the same thing elsewhere.
TEST(PlanNode, WhatItSaysOfSightsAndPointsIsThatOfTheLayout) {
  const auto plan = planned(kLayout).output<SurveyPlan>("plan");
  std::map<std::string, const PointT*> point;
  for (const auto& p : plan.points) point[p->id] = p.get();
  for (const auto& sight : plan.sights) {
    const Eigen::Vector3d way = point.at(sight->set_up)->position - point.at(sight->marker)->position;
    EXPECT_NEAR(sight->length, way.norm(), 1e-9) << sight->set_up << sight->marker;
    EXPECT_NEAR(sight->incidence, std::acos(-way.y() / way.norm()), 1e-9) << "plates face south";
  }
  for (const auto& ellipsoid : plan.ellipsoids)
    EXPECT_NEAR(ellipsoid->semi_axes.squaredNorm(), point.at(ellipsoid->id)->sigma.squaredNorm(), 1e-12)
        << ellipsoid->id;
  const auto finer = planned(kLayout, {{"sets", "4"}}).output<SurveyPlan>("plan");
  EXPECT_EQ(finer.sets, 4);
  for (size_t i = 0; i < plan.transfers.size(); ++i) {
    EXPECT_EQ(finer.transfers[i]->column, plan.transfers[i]->column);
    EXPECT_LT(finer.transfers[i]->sigma, plan.transfers[i]->sigma) << "of four sets";
    EXPECT_GT(finer.transfers[i]->sigma, 0.49 * plan.transfers[i]->sigma);
  }
  EXPECT_EQ(plan.profile, "total_station_1arcsec");
}

TEST(PlanNode, WithTheSightAddedEverythingHolds) {
  std::string layout = kLayout;
  layout.replace(layout.find("F2-C?-R1"), std::string::npos, "F2-*\n");
  const NodeHarness node = planned(layout);
  EXPECT_TRUE(node.output<SurveyPlan>("plan").holds);
  EXPECT_TRUE(node.warnings().empty());
}

TEST(PlanNode, ALayoutWithAMistakeIsRefusedWithItsPlace) {
  const auto message = [](std::string layout, const std::string& from, const std::string& to) {
    layout.replace(layout.find(from), from.size(), to);
    try {
      planned(layout);
    } catch (const NodeFailed& error) {
      return std::string(error.what());
    }
    return std::string("nothing was refused");
  };
  EXPECT_EQ(
      message(kLayout, "F1-* F2-C?-R1", "F9-*"),
      "layout.csv:15: found 'F9-*' in the column 'sees', expected the name of a marker, or a pattern that fits one");
  EXPECT_EQ(message(kLayout, "2,0;0,1;1,0", "2,0;x;1,0"),
            "layout.csv:3:21: found 'x' in the column 'north', expected a number");
  EXPECT_EQ(message(kLayout, "set_up;S2", "setup;S2"),
            "layout.csv:15: found 'setup' in the column 'kind', expected marker or set_up");
  EXPECT_EQ(message(kLayout, "F1-C2-R1", "F1-C1-R1"),
            "layout.csv:3: found 'F1-C1-R1' a second time, expected one row for each point");
  EXPECT_NE(
      message(kLayout, "floor", "storey").find("layout.csv:1: found the column 'storey', expected the columns kind"),
      std::string::npos);
}

// ------------------------------------------------------------------------------------------------------------ epochs

struct Adjusted {
  PointsT points;
  SurveyNetworkT network;
};

Adjusted adjust(const survey::SurveyObservations& survey) {
  NodeHarness node("survey.adjust");
  node.set("datum", "inner");
  node.set("curvature", "off");
  node.input<SurveyObservations>("observations", survey::to_artifact(survey));
  node.run();
  return {node.output<Points>("points"), node.output<SurveyNetwork>("network")};
}

/// Readings as if one marker stood elsewhere. Without any coordinates: every campaign has a frame of its own.
survey::SurveyObservations campaign(std::uint64_t seed, const std::string& moved = "",
                                    const Eigen::Vector3d& by = Eigen::Vector3d::Zero()) {
  survey::test::SimulationSettings settings;
  settings.set_ups = 4;
  settings.coordinates = false;
  settings.angle_sigma = 5e-6;
  settings.distance_sigma = 0.0005;
  auto n = survey::test::simulate(settings, seed);
  for (auto& o : n.survey.observations) {
    if (o.to != moved) continue;
    const Eigen::Vector3d& station = n.truth[12 + o.set_up];
    const auto at =
        std::find_if(n.survey.points.begin(), n.survey.points.end(), [&](const auto& p) { return p.id == moved; });
    const Eigen::Vector3d before = n.truth[at - n.survey.points.begin()] - station;
    const Eigen::Vector3d after = before + by;
    if (o.kind == ObservationKind::slope_distance) o.value += after.norm() - before.norm();
    if (o.kind == ObservationKind::zenith_angle)
      o.value += std::atan2(after.head<2>().norm(), after.z()) - std::atan2(before.head<2>().norm(), before.z());
    if (o.kind == ObservationKind::direction)
      o.value += std::atan2(after.x(), after.y()) - std::atan2(before.x(), before.y());
  }
  return n.survey;
}

NodeHarness compared(const Adjusted& first, const Adjusted& second) {
  NodeHarness node("survey.compare_epochs");
  node.input<Points>("first", first.points);
  node.input<Points>("second", second.points);
  node.input<SurveyNetwork>("first_network", first.network);
  node.input<SurveyNetwork>("second_network", second.network);
  return node;
}

TEST(AdjustNode, WithoutRedundancyTheGlobalTestIsNotCalledPassed) {
  survey::test::SimulationSettings settings;
  settings.set_ups = 1;
  const SurveyNetworkT network = adjust(survey::test::simulate(settings, 3).survey).network;
  EXPECT_EQ(network.statistics->degrees_of_freedom, 0);
  EXPECT_EQ(network.tests->verdict, "none");
  EXPECT_EQ(adjust(survey::test::simulate({}, 3).survey).network.tests->verdict, "pass");
}

/// What tests are made at stands beside them, and the test of the whole is that of the sum of squares.
TEST(AdjustNode, ThatCoordinatesWereTestedSaysNothingOfReadings) {
  NodeHarness node("survey.adjust");
  node.set("coordinates", "tested");
  node.input<SurveyObservations>("observations", survey::to_artifact(survey::test::simulate({}, 3).survey));
  node.run();
  EXPECT_FALSE(node.output<SurveyNetwork>("network").without_readings);
  const std::string said = testing::PrintToString(node.warnings());
  EXPECT_NE(said.find("coordinates=tested does nothing here"), std::string::npos) << said;
}

TEST(AdjustNode, TestsAreMadeAtTheLevelsThatAreAsked) {
  NodeHarness node("survey.adjust");
  node.set("datum", "inner"), node.set("alpha", "0.02"), node.set("alpha0", "0.005"), node.set("power", "0.9");
  node.input<SurveyObservations>("observations", survey::to_artifact(survey::test::simulate({}, 3).survey));
  node.run();
  const SurveyNetworkT network = node.output<SurveyNetwork>("network");
  EXPECT_EQ(network.tests->alpha, 0.02);
  EXPECT_EQ(network.tests->alpha0, 0.005);
  EXPECT_EQ(network.tests->power, 0.9);
  EXPECT_NEAR(network.tests->critical_w, normal_quantile(1 - 0.5 * 0.005), 1e-9);
  const StatisticsT& s = *network.statistics;
  const auto f = static_cast<double>(s.degrees_of_freedom);
  EXPECT_EQ(s.degrees_of_freedom, s.observations - s.unknowns + s.datum_defect);
  EXPECT_NEAR(s.sigma0, std::sqrt(s.weighted_sum_of_squares / f), 1e-9);
  // Whatever the statistic is divided by, its bounds are quantiles of the same share.
  EXPECT_NEAR(network.tests->lower / network.tests->statistic,
              chi_squared_quantile(0.01, f) / s.weighted_sum_of_squares, 1e-6);
  EXPECT_NEAR(network.tests->upper / network.tests->statistic,
              chi_squared_quantile(0.99, f) / s.weighted_sum_of_squares, 1e-6);
}

TEST(CompareEpochsNode, AMarkerMovedByTwoMillimetresIsNamed) {
  NodeHarness node = compared(adjust(campaign(1)), adjust(campaign(2, "M12", {0, 0, 0.002})));
  node.run();
  const auto c = node.output<SurveyComparison>("comparison");
  EXPECT_FALSE(c.congruent);
  EXPECT_EQ(c.rank, 3 * 12 - 4);
  ASSERT_EQ(c.excluded.size(), 1u);
  EXPECT_EQ(c.excluded[0]->id, "M12");
  ASSERT_EQ(c.points.size(), 12u) << "free set-ups are no common points";
  EXPECT_EQ(c.left_out, (std::vector<std::string>{"S1", "S2", "S3", "S4"}));
  for (const auto& p : c.points) {
    EXPECT_EQ(p->moved, p->id == "M12") << p->id;
    if (!p->moved) continue;
    EXPECT_NEAR(p->movement.z(), 0.002, 3.3 * p->sigma.z());
    EXPECT_NEAR(p->ellipsoid->semi_axes.squaredNorm(), p->sigma.squaredNorm(), 1e-15);
  }
  ASSERT_EQ(node.warnings().size(), 1u);
  EXPECT_EQ(node.warnings()[0].find("point M12 has moved: E "), 0u) << node.warnings()[0];
  EXPECT_NE(c.remark.find("; moved: M12"), std::string::npos) << c.remark;
  ASSERT_EQ(c.notes.size(), 1u) << "markers 6 m high to 0.1 mm";
  EXPECT_EQ(c.notes[0].find("no epoch says how warm it was"), 0u) << c.notes[0];
}

TEST(CompareEpochsNode, NothingMovedIsCalledCongruentAsOftenAsAlphaSays) {
  constexpr int kPairs = 200;
  int alarms = 0;
  for (std::uint64_t seed = 0; seed < kPairs; ++seed) {
    NodeHarness node = compared(adjust(campaign(1000 + 2 * seed)), adjust(campaign(1001 + 2 * seed)));
    node.run();
    alarms += !node.output<SurveyComparison>("comparison").congruent;
  }
  EXPECT_GE(alarms, 2);   // binomial with p = 0.05: 0.1 % below
  EXPECT_LE(alarms, 21);  // and above
}

/// Whatever the sigma0 of the networks: one below 1 has redundancy like any other.
TEST(CompareEpochsNode, VariancesAreThoseOfBothNetworks) {
  int below = 0, above = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Adjusted a = adjust(campaign(10 + seed)), b = adjust(campaign(20 + seed));
    NodeHarness node = compared(a, b);
    node.run();
    const auto c = node.output<SurveyComparison>("comparison");
    const double first = std::pow(a.points.statistics->sigma0, 2), second = std::pow(b.points.statistics->sigma0, 2);
    const auto f = static_cast<double>(a.points.statistics->degrees_of_freedom);
    ASSERT_EQ(a.points.statistics->degrees_of_freedom, b.points.statistics->degrees_of_freedom);
    EXPECT_NEAR(c.variance_ratio, std::max(first / second, second / first), 1e-9) << seed;
    EXPECT_NEAR(c.variance_critical, fisher_f_quantile(0.975, f, f), 1e-9) << seed;
    for (const double variance : {first, second}) (variance < 1 ? below : above) += 1;
  }
  EXPECT_GT(below, 0);
  EXPECT_GT(above, 0);
}

/// The same readings with one mark written otherwise.
survey::SurveyObservations renamed(survey::SurveyObservations survey, const std::string& id, const std::string& as) {
  for (auto& point : survey.points)
    if (point.id == id) point.id = as;
  for (auto& o : survey.observations)
    for (std::string* name : {&o.from, &o.to, &o.second_to})
      if (*name == id) *name = as;
  return survey;
}

/// A marker that sank by a centimetre and was called m12 was compared with nothing, and "the epochs are congruent".
TEST(CompareEpochsNode, APointThatIsWrittenOtherwiseIsNamed) {
  NodeHarness node = compared(adjust(campaign(1)), adjust(renamed(campaign(2, "M12", {0, 0, -0.01}), "M12", "m12")));
  node.run();
  const auto c = node.output<SurveyComparison>("comparison");
  const std::string said = testing::PrintToString(node.warnings());
  EXPECT_NE(said.find("M12 and m12 are two points here, and no epoch has both"), std::string::npos) << said;
  EXPECT_NE(said.find("not in the second epoch, so that no movement of theirs is seen: M12"), std::string::npos);
  EXPECT_NE(c.remark.find("; not in the second epoch: M12"), std::string::npos) << c.remark;
  ASSERT_GE(c.notes.size(), 2u);
  EXPECT_EQ(c.notes[0].find("M12 and m12"), 0u) << c.notes[0];
}

TEST(CompareEpochsNode, OneMeasurementIsNoTwoEpochs) {
  const Adjusted once = adjust(campaign(1));
  NodeHarness node = compared(once, once);
  try {
    node.run();
    FAIL() << "a file beside itself was congruent";
  } catch (const NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("they are one measurement, not two epochs"), std::string::npos)
        << error.what();
  }
}

TEST(CompareEpochsNode, PointsAreChosenByPattern) {
  NodeHarness node = compared(adjust(campaign(1)), adjust(campaign(2)));
  node.set("points", "M0*\x1fS1");
  node.run();
  EXPECT_EQ(node.output<SurveyComparison>("comparison").points.size(), 5u);
  node.set("points", "M00");
  EXPECT_THROW(node.run(), NodeFailed);
}

// ------------------------------------------------------------------------------------------------------------ series

std::string text_in(const FileT& file) { return {file.content.begin(), file.content.end()}; }

/// Rows of a table by the names of its first line.
std::vector<std::map<std::string, std::string>> rows_in(const FileT& file) {
  std::istringstream lines(text_in(file));
  const auto cells = [](const std::string& line) {
    std::vector<std::string> list(1);
    for (const char c : line) c == ',' ? void(list.emplace_back()) : list.back().push_back(c);
    return list;
  };
  std::string line;
  std::getline(lines, line);
  const auto names = cells(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(lines, line)) {
    const auto values = cells(line);
    EXPECT_EQ(values.size(), names.size()) << line;
    for (size_t i = 0; i < std::min(names.size(), values.size()); ++i)
      (i == 0 ? rows.emplace_back() : rows.back())[names[i]] = values[i];
  }
  return rows;
}

/// A number of the table as its heading says it, with so many digits behind the point; of none an empty cell.
void expect_cell(const std::string& cell, const nlohmann::json& value, double factor, int digits) {
  if (value.is_null()) {
    EXPECT_EQ(cell, "");
    return;
  }
  EXPECT_NEAR(std::stod(cell), factor * value.get<double>(), 0.5001 * std::pow(10, -digits)) << cell;
  EXPECT_EQ(cell.size() - cell.find('.') - 1, static_cast<size_t>(digits)) << cell;
}

class EpochSeriesNodes : public testing::Test {
 protected:
  /// Three epochs in which M12 goes on by 2 mm east, 1 mm south and 4 mm up a month.
  EpochSeriesNodes() : node_("survey.epoch_series") {
    for (int k = 0; k < 3; ++k)
      node_.input<SurveyObservations>(
          "epochs", survey::to_artifact(campaign(40 + static_cast<std::uint64_t>(k), "M12", k * by_)));
    node_.set("days",
              "0\x1f"
              "30\x1f"
              "60");
    node_.set("warning_level", "0.003");
    node_.set("alarm_level", "0.2");
    node_.run();
    json_ = nlohmann::json::parse(text_in(node_.output<File>("series")));
  }
  const nlohmann::json& point(const std::string& id) const {
    for (const auto& p : json_["points"])
      if (p["id"] == id) return p;
    throw std::out_of_range(id);
  }

  const Eigen::Vector3d by_{0.002, -0.001, 0.004};
  NodeHarness node_;
  nlohmann::json json_;
};

TEST_F(EpochSeriesNodes, ThePlantedMovementIsTheRecords) {
  EXPECT_EQ(json_["unit_of_time"], "day");
  const auto& m12 = point("M12");
  EXPECT_EQ(m12["stable"], false);
  EXPECT_EQ(m12["moves"], true);
  ASSERT_EQ(m12["movements"].size(), 2u);
  // A frame without coordinates may be turned against that of the markers: in height and in length alone.
  for (const auto& at : m12["movements"]) {
    const int k = at["epoch"];
    EXPECT_NEAR(at["movement"][2].get<double>(), k * by_.z(), 4 * at["sigma"][2].get<double>()) << k;
    EXPECT_NEAR(std::hypot(at["movement"][0].get<double>(), at["movement"][1].get<double>()), k * by_.head<2>().norm(),
                4 * std::hypot(at["sigma"][0].get<double>(), at["sigma"][1].get<double>()))
        << k;
    EXPECT_NEAR(at["critical"].get<double>(), chi_squared_quantile(0.999, 3), 1e-6) << "no variance is estimated";
    EXPECT_EQ(at["moved"], at["statistic"].get<double>() > at["critical"].get<double>());
    EXPECT_NE(at["warning"], "below");
    EXPECT_EQ(at["alarm"], "below");
  }
  EXPECT_NEAR(m12["velocity"][2].get<double>(), by_.z() / 30, 4 * m12["velocity_sigma"][2].get<double>());
  EXPECT_GT(m12["velocity_statistic"].get<double>(), m12["velocity_critical"].get<double>());
  EXPECT_EQ(point("M21")["moves"], false);
  const auto& stable = json_["stable"];
  EXPECT_EQ(std::count(stable.begin(), stable.end(), "M12"), 0);
  EXPECT_EQ(std::count(stable.begin(), stable.end(), "M21"), 1);
  for (const char* station : {"S1", "S2"}) EXPECT_THROW(point(station), std::out_of_range) << "no mark";
  EXPECT_EQ(node_.metric("points_told"), 1);
  EXPECT_EQ(node_.metric("alarms"), 0);
}

/// Two epochs were held against each other's size, more than two were not: an epoch in feet moved every point.
TEST(EpochSeriesSize, AnEpochInFeetIsNoSeries) {
  NodeHarness node("survey.epoch_series");
  for (int k = 0; k < 3; ++k) {
    survey::SurveyObservations epoch = campaign(40 + static_cast<std::uint64_t>(k));
    if (k == 1)
      for (survey::Observation& o : epoch.observations)
        if (o.kind == survey::ObservationKind::slope_distance) o.value /= 0.3048;
    for (survey::SetUp& s : epoch.set_ups)
      if (k == 1) s.instrument_height /= 0.3048;
    node.input<SurveyObservations>("epochs", survey::to_artifact(epoch));
  }
  try {
    node.run();
    FAIL() << "no error";
  } catch (const NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("the second is in feet"), std::string::npos) << error.what();
  }
}

/// M12 goes on, and is called m12 from the third epoch on; M21 is no longer measured then.
TEST(EpochSeriesNames, APointThatChangesItsNameOrIsLostIsTold) {
  NodeHarness node("survey.epoch_series");
  for (int k = 0; k < 4; ++k) {
    auto epoch = campaign(40 + static_cast<std::uint64_t>(k), "M12", k * Eigen::Vector3d(0, 0, -0.004));
    if (k >= 2) {
      epoch = renamed(epoch, "M12", "m12");
      std::erase_if(epoch.observations, [](const auto& o) { return o.to == "M21"; });
      std::erase_if(epoch.points, [](const auto& p) { return p.id == "M21"; });
    }
    epoch.files = {"e" + std::to_string(k + 1)};
    node.input<SurveyObservations>("epochs", survey::to_artifact(epoch));
  }
  node.run();
  const std::string verdict = text_in(node.output<File>("verdict"));
  for (const char* part :
       {"Note: M12 and m12 are two points here, and no epoch has both",
        "Note: not in e4, so that no movement of theirs is seen; last seen: M12 (e2), M21 (e2)", "not seen since e2"})
    EXPECT_NE(verdict.find(part), std::string::npos) << part << "\n" << verdict;
  EXPECT_LT(verdict.find("Note: "), verdict.find("In their order"));
  const std::string said = testing::PrintToString(node.warnings());
  EXPECT_NE(said.find("M12 and m12"), std::string::npos) << said;
}

/// Points "moved" by metres, and the note beside it said that its cause was taken off, which a series does not do.
TEST(EpochSeriesNames, ExchangedNamesAreTheFirstLine) {
  NodeHarness node("survey.epoch_series");
  for (int k = 0; k < 3; ++k) {
    auto epoch = campaign(40 + static_cast<std::uint64_t>(k));
    if (k == 1) epoch = renamed(renamed(renamed(epoch, "M12", "x"), "M13", "M12"), "x", "M13");
    epoch.files = {"e" + std::to_string(k + 1)};
    node.input<SurveyObservations>("epochs", survey::to_artifact(epoch));
  }
  node.run();
  const std::string verdict = text_in(node.output<File>("verdict"));
  EXPECT_NE(
      verdict.find("\nA mistake in an epoch would explain movements (see the notes): mend it first. As it is 2 points "
                   "seem to move, to have moved or to reach a level.\n"),
      std::string::npos)
      << verdict;
  EXPECT_NE(verdict.find("M12 and M13 have each other's name in one of the epochs: each lies where the other was; the "
                         "movements and velocities of this series hold it\n"),
            std::string::npos)
      << verdict;
}

TEST(EpochSeriesNames, OneMeasurementTwiceIsNoSeries) {
  NodeHarness node("survey.epoch_series");
  for (const std::uint64_t seed : {40, 41, 41})
    node.input<SurveyObservations>("epochs", survey::to_artifact(campaign(seed)));
  try {
    node.run();
    FAIL() << "two epochs that are one took part";
  } catch (const NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("epoch 2 and epoch 3 have the same readings"), std::string::npos)
        << error.what();
  }
}

/// A field that is left out is missed by nobody who reads the others.
TEST_F(EpochSeriesNodes, TheRecordHasAllItsFields) {
  const auto names = [](const nlohmann::json& object) {
    std::set<std::string> found;
    for (const auto& [name, value] : object.items()) found.insert(name);
    return found;
  };
  EXPECT_EQ(names(json_),
            (std::set<std::string>{"alarm_level", "bartlett", "bartlett_critical", "contradicted", "degrees_of_freedom",
                                   "epochs", "not_compared", "not_followed", "notes", "points", "seen_once", "sigma0",
                                   "stable", "unit_of_time", "variances", "warning_level"}));
  EXPECT_EQ(names(json_["epochs"][0]), (std::set<std::string>{"name", "time", "variance_factor"}));
  EXPECT_EQ(
      names(json_["points"][0]),
      (std::set<std::string>{"first_epoch", "id", "misfit", "misfit_critical", "movements", "moves", "reference_epochs",
                             "stable", "velocity", "velocity_critical", "velocity_sigma", "velocity_statistic"}));
  EXPECT_EQ(
      names(json_["points"][0]["movements"][0]),
      (std::set<std::string>{"alarm", "critical", "epoch", "moved", "movement", "sigma", "statistic", "warning"}));
  EXPECT_EQ(json_["warning_level"], 0.003);
  EXPECT_EQ(json_["alarm_level"], 0.2);
  // Three epochs of two unknowns a coordinate: one is left to see whether it moves evenly.
  EXPECT_NEAR(point("M12")["misfit_critical"].get<double>(), chi_squared_quantile(0.999, 3), 1e-6);
}

/// Page and verdict, element by element: what is on them is in the record, which the other tests look at.
TEST_F(EpochSeriesNodes, PageAndVerdictAreTheRecordedOnes) {
  expect_recorded("unit/survey/records/series.txt", with_few_digits(text_in(node_.output<File>("verdict"))) +
                                                        elements_of(text_in(node_.output<File>("page"))));
}

TEST_F(EpochSeriesNodes, TheTableHasTheFiguresOfTheRecord) {
  const auto rows = rows_in(node_.output<File>("table"));
  const auto& epochs = json_["epochs"];
  size_t row = 0;
  for (const auto& p : json_["points"])
    for (const auto& at : p["movements"]) {
      ASSERT_LT(row, rows.size());
      const auto& cells = rows[row++];
      const auto& epoch = epochs[at["epoch"].get<size_t>()];
      EXPECT_EQ(cells.at("point"), p["id"]);
      EXPECT_EQ(cells.at("epoch"), epoch["name"]);
      expect_cell(cells.at("time [day]"), epoch["time"], 1, 3);
      for (size_t k = 0; k < 3; ++k) {
        const std::string axis(1, "ENH"[k]);
        expect_cell(cells.at("d" + axis + " [mm]"), at["movement"][k], 1000, 3);
        expect_cell(cells.at("s" + axis + " [mm]"), at["sigma"][k], 1000, 3);
        EXPECT_EQ(cells.at(axis + " since"), epochs[p["reference_epochs"][k].get<size_t>()]["name"]);
      }
      expect_cell(cells.at("statistic"), at["statistic"], 1, 2);
      expect_cell(cells.at("critical"), at["critical"], 1, 2);
      EXPECT_EQ(cells.at("moved"), at["moved"].get<bool>() ? "yes" : "no");
      EXPECT_EQ(cells.at("warning"), at["warning"]);
      EXPECT_EQ(cells.at("alarm"), at["alarm"]);
    }
  EXPECT_EQ(row, rows.size());
  EXPECT_EQ(rows.size(), 24u) << "twelve markers, two movements each";
}

TEST(CompareEpochsNode, EveryParameterHasItsEffect) {
  const Adjusted first = adjust(campaign(1)), second = adjust(campaign(2, "M12", {0, 0, 0.002}));
  const auto situation = [&](bool held) -> Situation {
    return [&, held] {
      NodeHarness node = compared(first, second);
      if (held) node.set("points", "M0*");
      return node;
    };
  };
  EXPECT_EQ(parameters_at_fault({situation(false), situation(true)}), "");
}

TEST(EpochSeriesNode, EveryParameterHasItsEffect) {
  const auto situation = [](const std::string& days) -> Situation {
    return [=] {
      NodeHarness node("survey.epoch_series");
      for (std::uint64_t k = 0; k < 3; ++k)
        node.input<SurveyObservations>(
            "epochs",
            survey::to_artifact(campaign(40 + k, "M12", static_cast<double>(k) * Eigen::Vector3d(0, 0, 0.0006))));
      node.set("days", days);
      return node;
    };
  };
  // Of networks without a map and without known points: what brings either about changes nothing.
  EXPECT_EQ(parameters_at_fault({situation("0\x1f"
                                           "30\x1f"
                                           "60")},
                                {"geoid_height", "geoid_slope", "mean_height", "datum"}),
            "");
  EXPECT_EQ(stopping_at_fault(situation("0\x1f"
                                        "30\x1f"
                                        "60")),
            "");
}

// ------------------------------------------------------------------------------------------------------------ control

PointsT control_of(const survey::test::SimulatedNetwork& n, std::uint64_t seed) {
  survey::test::Normal normal(seed);
  PointsT control;
  for (size_t i : {size_t{0}, size_t{3}, size_t{8}, size_t{11}}) {
    auto p = std::make_unique<PointT>();
    p->id = n.survey.points[i].id;
    for (int k = 0; k < 3; ++k) p->position[k] = n.truth[i][k] + 0.0005 * normal();
    p->sigma.setConstant(0.0005);
    control.points.push_back(std::move(p));
  }
  return control;
}

TEST(CheckControlNode, WarnsOfTheBadPointBeforeItBendsTheNetwork) {
  const auto n = survey::test::simulate({}, 5);
  PointsT control = control_of(n, 6);
  NodeHarness node("survey.check_control");
  node.input<SurveyObservations>("observations", survey::to_artifact(n.survey));
  node.input<Points>("control", control);
  node.run();
  EXPECT_TRUE(node.output<SurveyComparison>("check").congruent);
  EXPECT_TRUE(node.warnings().empty());

  control.points[1]->position.x() += 0.01;
  NodeHarness bad("survey.check_control");
  bad.input<SurveyObservations>("observations", survey::to_artifact(n.survey));
  bad.input<Points>("control", control);
  bad.run();
  const auto check = bad.output<SurveyComparison>("check");
  EXPECT_FALSE(check.congruent);
  ASSERT_EQ(bad.warnings().size(), 1u);
  EXPECT_EQ(bad.warnings()[0].find("control point M03 does not fit the observations"), 0u) << bad.warnings()[0];
}

TEST(CheckControlNode, EveryParameterHasItsEffect) {
  const auto n = survey::test::simulate({}, 5);
  PointsT control = control_of(n, 6);
  control.points[1]->position.x() += 0.0015;
  survey::SurveyObservations unweighted = n.survey;
  for (auto& o : unweighted.observations) o.sigma = survey::kNotGiven;
  unweighted.observations[5].value += 0.05;
  const auto situation = [&](const survey::SurveyObservations& of) -> Situation {
    return [&, of] {
      NodeHarness node("survey.check_control");
      node.input<SurveyObservations>("observations", survey::to_artifact(of));
      node.input<Points>("control", control);
      return node;
    };
  };
  // One file, in a plane: no stations of several, and nothing that a map would change.
  EXPECT_EQ(parameters_at_fault({situation(n.survey), situation(unweighted)},
                                {"geoid_height", "geoid_slope", "mean_height", "same_stations"}),
            "");
}

TEST(CheckControlNode, WithoutControlItSaysSoAndGoesOn) {
  NodeHarness node("survey.check_control");
  node.input<SurveyObservations>("observations", survey::to_artifact(survey::test::simulate({}, 7).survey));
  node.run();
  const auto check = node.output<SurveyComparison>("check");
  EXPECT_EQ(check.rank, 0);
  EXPECT_EQ(check.remark, "there are no control points to check");
}

TEST(GamaWriter, AdjustedCoordinatesMakeAFreeNetworkThatGamaCanStartFrom) {
  survey::test::SimulationSettings blind;
  blind.coordinates = false;
  const auto observations = survey::to_artifact(survey::test::simulate(blind, 3).survey);
  NodeHarness adjust("survey.adjust");
  adjust.input<SurveyObservations>("observations", observations);
  adjust.set("datum", "inner");
  adjust.run();
  const PointsT points = adjust.output<Points>("points");
  NodeHarness writer("write.gama");
  writer.input<SurveyObservations>("observations", observations);
  writer.input<Points>("points", points);
  writer.run();
  const FileT file = writer.output<File>("file");
  const std::string text(file.content.begin(), file.content.end());
  EXPECT_NE(text.find("adj=\"XYZ\""), std::string::npos) << "capital letters: these points carry the datum";
  EXPECT_EQ(text.find("<point id=\"M00\" adj"), std::string::npos) << "a point without coordinates";
}

}  // namespace test_nodes
}  // namespace plumbline::test
