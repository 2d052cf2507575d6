// plan.survey, survey.compare_epochs and survey.check_control as a host runs them, with survey.adjust before them.
#include <algorithm>
#include <cmath>

#include "artifacts/file.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_comparison.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/survey_plan.hpp"
#include "node_harness.hpp"
#include "simulated_network.hpp"

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

NodeHarness planned(const std::string& layout) {
  NodeHarness reader("read.layout");
  reader.input<File>("file", file_of(layout));
  reader.run();
  NodeHarness plan("plan.survey");
  plan.set("profile", "total_station_1arcsec");
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

TEST(CompareEpochsNode, PointsAreChosenByPattern) {
  NodeHarness node = compared(adjust(campaign(1)), adjust(campaign(2)));
  node.set("points", "M0*\x1fS1");
  node.run();
  EXPECT_EQ(node.output<SurveyComparison>("comparison").points.size(), 5u);
  node.set("points", "M00");
  EXPECT_THROW(node.run(), NodeFailed);
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
