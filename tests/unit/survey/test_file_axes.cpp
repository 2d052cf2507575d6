// A network result in the axes of its file: survey.in_file_axes.
#include <cmath>

#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "node_harness.hpp"

namespace plumbline::test {
namespace test_file_axes {

SurveyNetworkT network() {
  SurveyNetworkT n;
  n.statistics = std::make_unique<StatisticsT>();
  n.tests = std::make_unique<NetworkTestsT>();
  n.datum = "file";
  n.axes = "en";
  auto point = std::make_unique<PointT>();
  point->id = "A";
  point->position = {10, 20, std::nan("")};
  point->sigma = {0.001, 0.002, std::nan("")};
  n.points.push_back(std::move(point));
  auto ellipsoid = std::make_unique<NetworkEllipsoidT>();
  ellipsoid->id = "A";
  ellipsoid->semi_axes = {3, 2, 1};
  ellipsoid->first_axis = {0.6, 0.8, 0};
  ellipsoid->second_axis = {0, 0, 1};
  n.ellipsoids.push_back(std::move(ellipsoid));
  auto row = std::make_unique<NetworkObservationT>();
  row->kind = "vector";
  row->detail = "N";
  row->value = 5;
  row->residual = 0.25;
  row->w = 2;
  row->sigma = 0.125;
  n.observations.push_back(std::move(row));
  auto angle = std::make_unique<NetworkObservationT>();
  angle->kind = "angle";
  angle->detail = "N";  // the name of a point
  angle->value = 1;
  n.observations.push_back(std::move(angle));
  return n;
}

SurveyObservationsT observations(const std::string& axes) {
  SurveyObservationsT s;
  s.info = std::make_unique<SurveyInfoT>();
  s.info->axes_xy = axes;
  s.files = {"a.gkf"};
  return s;
}

TEST(FileAxes, SouthWest) {
  NodeHarness node("survey.in_file_axes");
  node.input<SurveyNetwork>("network", network());
  node.input<SurveyObservations>("observations", observations("sw"));
  node.run();
  const SurveyNetworkT n = node.output<SurveyNetwork>("network");
  EXPECT_EQ(n.axes, "sw");
  EXPECT_EQ(n.points[0]->position.head<2>(), Eigen::Vector2d(-20, -10));
  EXPECT_EQ(n.points[0]->sigma.head<2>(), Eigen::Vector2d(0.002, 0.001));
  EXPECT_TRUE(std::isnan(n.points[0]->position.z()));
  EXPECT_EQ(n.ellipsoids[0]->semi_axes, Eigen::Vector3d(3, 2, 1));
  EXPECT_EQ(n.ellipsoids[0]->first_axis, Eigen::Vector3d(-0.8, -0.6, 0));
  EXPECT_EQ(n.ellipsoids[0]->second_axis, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(n.observations[0]->detail, "x");
  EXPECT_EQ(n.observations[0]->value, -5);
  EXPECT_EQ(n.observations[0]->residual, -0.25);
  EXPECT_EQ(n.observations[0]->w, -2);
  EXPECT_EQ(n.observations[0]->sigma, 0.125);
  EXPECT_EQ(n.observations[1]->detail, "N");
  EXPECT_EQ(n.observations[1]->value, 1);
}

TEST(FileAxes, EastNorthChangesNothing) {
  NodeHarness node("survey.in_file_axes");
  node.input<SurveyNetwork>("network", network());
  node.input<SurveyObservations>("observations", observations("en"));
  node.run();
  const SurveyNetworkT n = node.output<SurveyNetwork>("network");
  EXPECT_EQ(n.axes, "en");
  EXPECT_EQ(n.points[0]->position.head<2>(), Eigen::Vector2d(10, 20));
  EXPECT_EQ(n.observations[0]->detail, "N");
}

TEST(FileAxes, FilesThatDiffer) {
  NodeHarness node("survey.in_file_axes");
  node.input<SurveyNetwork>("network", network());
  node.input<SurveyObservations>("observations", observations("sw"));
  node.input<SurveyObservations>("observations", observations("ne"));
  EXPECT_THROW(node.run(), NodeFailed);
}

TEST(FileAxes, AxesThatAreNone) {
  for (const std::string axes : {"ns", "x", "eee"}) {
    NodeHarness node("survey.in_file_axes");
    node.input<SurveyNetwork>("network", network());
    node.input<SurveyObservations>("observations", observations(axes));
    EXPECT_THROW(node.run(), NodeFailed) << axes;
  }
}

}  // namespace test_file_axes
}  // namespace plumbline::test
