#include <gtest/gtest.h>

#include "geometry/packed_symmetric.hpp"
#include "show/report/network_page.hpp"

namespace plumbline::report {
namespace test_network_page {

SurveyNetworkT small_network() {
  SurveyNetworkT network;
  auto point = std::make_unique<PointT>();
  point->id = "A1", point->position = {1, 2, 3}, point->sigma = {0.001, 0.002, 0.003};
  network.points.push_back(std::move(point));
  point = std::make_unique<PointT>();
  point->id = "S1", point->position = {0, 0, 0}, point->sigma = {0.001, 0.001, 0.001};
  network.points.push_back(std::move(point));
  auto ellipsoid = std::make_unique<NetworkEllipsoidT>();
  ellipsoid->id = "A1", ellipsoid->semi_axes = {0.005, 0.002, 0.001};
  ellipsoid->first_axis = {0, 1, 0}, ellipsoid->second_axis = {0, 0, 1};
  network.ellipsoids.push_back(std::move(ellipsoid));
  auto set_up = std::make_unique<NetworkSetUpT>();
  set_up->id = "1", set_up->station = "S1";
  network.set_ups.push_back(std::move(set_up));
  auto observation = std::make_unique<NetworkObservationT>();
  observation->kind = "zenith_angle", observation->from = "S1", observation->to = "A1", observation->file = "a.gsi";
  observation->line = 7;
  network.observations.push_back(std::move(observation));
  network.datum = "weighted", network.datum_points = {"A1"};
  return network;
}

TEST(NetworkPage, TakesEllipsoidsApart) {
  const NetworkPage page = network_page(small_network());
  ASSERT_EQ(page.points.size(), 2u);
  EXPECT_NEAR(page.points[0].covariance(1, 1), 25e-6, 1e-15);
  EXPECT_NEAR(page.points[0].covariance(2, 2), 4e-6, 1e-15);
  EXPECT_NEAR(page.points[0].covariance(0, 0), 1e-6, 1e-15);
  EXPECT_NEAR(page.points[1].covariance(0, 0), 1e-6, 1e-15);  // no ellipsoid: the standard deviations
  EXPECT_TRUE(page.points[0].datum);
  EXPECT_TRUE(page.points[1].station);
  EXPECT_TRUE(page.observations[0].angular);
  EXPECT_EQ(page.observations[0].source, "a.gsi:7");
}

TEST(NetworkPage, CoordinatesInTheAxesOfTheFile) {
  SurveyNetworkT file = small_network();
  file.axes = "sw";
  file.points[0]->position = {-2, -1, 3};
  ReportInput input;
  input.network = network_page(small_network(), &file);
  const std::string html = render_report(input);
  for (const char* words :
       {"x south [m]", "y west [m]", "In the axes of the file", "control points with their standard"})
    EXPECT_NE(html.find(words), std::string::npos) << words;
  EXPECT_EQ(input.network->coordinates[0].position.x(), -2);
  EXPECT_EQ(input.network->points[0].position.x(), 1) << "drawings keep north up";
}

TEST(NetworkPage, NeighboursRelativeToEachOther) {
  SurveyNetworkT network = small_network();
  auto second = std::make_unique<PointT>();
  second->id = "A2", second->position = {1, 2, 6};
  network.points.push_back(std::move(second));
  PointsT points;
  for (const auto& p : network.points) points.points.push_back(std::make_unique<PointT>(*p));
  // Heights of A1 and A2 of 3 mm each with correlation 0.5: 3 mm relative to each other.
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(9, 9) * 9e-6;
  covariance(2, 8) = covariance(8, 2) = 4.5e-6;
  points.covariance = pack_symmetric(covariance);
  const NetworkPage page = network_page(network, nullptr, &points);
  ASSERT_EQ(page.relative.size(), 1u) << "the station is no marker";
  EXPECT_EQ(page.relative[0].from + page.relative[0].to, "A1A2");
  EXPECT_NEAR(page.relative[0].sigma_height, 0.003, 1e-12);
  EXPECT_NEAR(page.relative[0].distance, 3, 1e-12);
  ReportInput input;
  input.network = page;
  EXPECT_NE(render_report(input).find("relative to each other"), std::string::npos);
}

TEST(NetworkPage, RingsOnlyWhereTheyTellPointsApart) {
  ReportInput input;
  input.network = network_page(small_network());
  const std::string all = render_report(input);
  EXPECT_EQ(all.find("\"datum-ring\""), std::string::npos);
  EXPECT_NE(all.find("All markers are points that carry the datum"), std::string::npos);
  SurveyNetworkT network = small_network();
  auto other = std::make_unique<PointT>();
  other->id = "A2", other->position = {1, 2, 6};
  network.points.push_back(std::move(other));
  input.network = network_page(network);
  EXPECT_NE(render_report(input).find("\"datum-ring\""), std::string::npos);
}

TEST(NetworkPage, RendersWithoutTestsAndStatistics) {
  ReportInput input;
  input.accuracy.tau = 0.005;
  input.network = network_page(small_network());
  EXPECT_NE(render_report(input).find("no redundancy to test"), std::string::npos);
}

TEST(NetworkPage, AnInvalidResultSaysSoAndHasNoEllipses) {
  SurveyNetworkT network = small_network();
  network.validity = "invalid", network.verdict = "not a result: set-ups contradict each other";
  network.ellipsoids.clear();
  ReportInput input;
  input.network = network_page(network);
  EXPECT_FALSE(input.network->points[0].covariance.allFinite());
  const std::string html = render_report(input);
  EXPECT_NE(html.find("NOT A RESULT"), std::string::npos);
  EXPECT_EQ(html.find("class=\"ellipse\""), std::string::npos);
  input.network = network_page(small_network());
  EXPECT_EQ(render_report(input).find("NOT A RESULT"), std::string::npos);
}

TEST(NetworkPage, TheVerdictStandsFirstAndWarningsBeforeNotes) {
  SurveyNetworkT network = small_network();
  network.validity = "doubtful", network.verdict = "doubtful: 5 readings fail the test";
  const auto add = [&](const char* severity, const std::string& text) {
    auto finding = std::make_unique<NetworkFindingT>();
    finding->severity = severity, finding->text = text;
    network.findings.push_back(std::move(finding));
  };
  network.findings.clear();
  for (int i = 0; i < 5; ++i) add("note", "note " + std::to_string(i));
  add("warning", "the first to mend");
  ReportInput input;
  input.network = network_page(network);
  const std::string html = render_report(input);
  const size_t verdict = html.find("Doubtful: 5 readings fail the test."), warning = html.find("the first to mend"),
               folded = html.find("5\u00A0notes"), note = html.find("note 0");
  ASSERT_NE(verdict, std::string::npos);
  EXPECT_LT(verdict, warning);
  EXPECT_LT(warning, folded);
  EXPECT_LT(folded, note);
}

TEST(NetworkPage, ASoundNetworkIsNotToldThatBlundersAreLeft) {
  SurveyNetworkT network = small_network();
  network.validity = "sound", network.verdict = "sound: the readings agree as well as their accuracies say";
  ReportInput input;
  input.network = network_page(network);
  input.network->verdict = "high";
  EXPECT_EQ(render_report(input).find("there are blunders"), std::string::npos);
  input.network->validity = "doubtful";
  EXPECT_NE(render_report(input).find("there are blunders"), std::string::npos);
}

TEST(NetworkPage, SetUpsValuesAndSuspects) {
  SurveyNetworkT network = small_network();
  auto& set_up = *network.set_ups[0];
  set_up.orientation = -M_PI / 2, set_up.instrument_height = 1.603;
  set_up.constant = 0.0344, set_up.constant_sigma = 0.0004;
  set_up.collimation = -1.3e-3 * M_PI / 200, set_up.collimation_sigma = 7e-5 * M_PI / 200;
  network.observations[0]->value = M_PI / 2, network.observations[0]->flagged = true;
  network.instrument = "TS 16, no. 4711", network.date = "2026-11-21";
  ReportInput input;
  input.network = network_page(network);
  const std::string html = render_report(input);
  for (const char* words : {"300.0000", "1.603", "+34.4 ± 0.4", "−1.30 ± 0.07", "100.0000", "sight suspect",
                            "TS 16, no. 4711", "2026-11-21"})
    EXPECT_NE(html.find(words), std::string::npos) << words;
}

}  // namespace test_network_page
}  // namespace plumbline::report
