#include "report/network_page.hpp"

#include <gtest/gtest.h>

namespace plumbline::report {
namespace {

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

TEST(NetworkPage, RendersWithoutTestsAndStatistics) {
  ReportInput input;
  input.accuracy.tau = 0.005;
  input.network = network_page(small_network());
  EXPECT_NE(render_report(input).find("no redundancy to test"), std::string::npos);
}

}  // namespace
}  // namespace plumbline::report
