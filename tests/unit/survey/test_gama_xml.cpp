// gama-local XML: every element and attribute, units and senses, damage, and the way back.
#include <numbers>

#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/files/gama.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace {

constexpr double kGon = std::numbers::pi / 200;

std::string network(const std::string& content, const std::string& attributes = "axes-xy=\"en\"",
                    const std::string& defaults = "") {
  return "<?xml version=\"1.0\"?>\n<gama-local xmlns=\"http://www.gnu.org/software/gama/gama-local\">\n<network " +
         attributes + ">\n<parameters sigma-apr=\"1\" sigma-act=\"apriori\"/>\n<points-observations " + defaults +
         ">\n" + content + "</points-observations></network></gama-local>\n";
}

TEST(GamaXml, RolesAxesAndAngles) {
  const auto s = read_gama_xml(network("<point id='A' x='10' y='20' z='3' fix='xy' adj='z'/>"
                                       "<point id='B' x='11' y='22' adj='XY'/>"
                                       "<obs from='A' from_dh='1.5'><direction to='B' val='50' stdev='10' to_dh='0.2'/>"
                                       "<z-angle to='B' val='90-00-00' stdev='3.24'/></obs>",
                                       "axes-xy=\"sw\" angles=\"left-handed\""),
                               "t.gkf");
  ASSERT_EQ(s.points.size(), 2u);
  EXPECT_EQ(s.points[0].coordinates, Eigen::Vector3d(-20, -10, 3));  // x south, y west
  EXPECT_EQ(s.points[0].roles[0], CoordinateRole::fixed);
  EXPECT_EQ(s.points[0].roles[2], CoordinateRole::free);
  EXPECT_EQ(s.points[1].roles[1], CoordinateRole::constrained);
  EXPECT_EQ(s.points[1].roles[2], CoordinateRole::unused);
  ASSERT_EQ(s.observations.size(), 2u);
  EXPECT_NEAR(s.observations[0].value, 50 * kGon, 1e-15);
  EXPECT_NEAR(s.observations[0].sigma, 10e-4 * kGon, 1e-18);
  EXPECT_EQ(s.observations[0].target_height, 0.2);
  EXPECT_NEAR(s.observations[1].value, std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(s.observations[1].sigma, 10e-4 * kGon, 1e-12);  // 3.24" = 10 cc
  EXPECT_EQ(s.set_ups[0].instrument_height, 1.5);
}

TEST(GamaXml, RightHandedAnglesChangeSign) {
  const auto s = read_gama_xml(network("<point id='A' x='0' y='0' adj='xy'/><point id='B' x='1' y='1' adj='xy'/>"
                                       "<point id='C' x='1' y='0' adj='xy'/>"
                                       "<obs from='A'><angle bs='C' fs='B' val='50' stdev='10'/></obs>",
                                       "axes-xy=\"en\" angles=\"right-handed\""),
                               "t.gkf");
  ASSERT_EQ(s.observations.size(), 1u);
  EXPECT_NEAR(s.observations[0].value, -50 * kGon, 1e-15);
  EXPECT_EQ(s.observations[0].to, "C");
  EXPECT_EQ(s.observations[0].second_to, "B");
}

TEST(GamaXml, DefaultsAndDistanceModel) {
  const auto s =
      read_gama_xml(network("<point id='A' x='0' y='0' z='0' adj='xyz'/><point id='B' adj='xyz'/>"
                            "<obs from='A'><distance to='B' val='1000'/><direction to='B' val='0'/></obs>"
                            "<height-differences><dh from='A' to='B' val='1' dist='4'/></height-differences>",
                            "axes-xy=\"en\"", "distance-stdev=\"5 3 1\" direction-stdev=\"7\""),
                    "t.gkf");
  ASSERT_EQ(s.observations.size(), 3u);
  EXPECT_NEAR(s.observations[0].sigma, 0.008, 1e-15);
  EXPECT_NEAR(s.observations[1].sigma, 7e-4 * kGon, 1e-18);
  EXPECT_NEAR(s.observations[2].sigma, 0.002, 1e-15);  // sigma-apr 1 mm, 4 km
}

TEST(GamaXml, CovarianceOfAClusterWithMixedUnits) {
  const auto s = read_gama_xml(network("<point id='A' x='0' y='0' adj='xy'/><point id='B' x='9' y='9' adj='xy'/>"
                                       "<obs from='A'><direction to='B' val='10'/><distance to='B' val='12.7'/>"
                                       "<cov-mat dim='2' band='1'>100 5 4</cov-mat></obs>"),
                               "t.gkf");
  ASSERT_EQ(s.covariances.size(), 1u);
  EXPECT_NEAR(s.covariances[0].covariance(0, 0), 100e-8 * kGon * kGon, 1e-20);
  EXPECT_NEAR(s.covariances[0].covariance(0, 1), 5e-7 * kGon, 1e-18);
  EXPECT_NEAR(s.covariances[0].covariance(1, 1), 4e-6, 1e-18);
  EXPECT_NEAR(s.observations[1].sigma, 0.002, 1e-15);
}

TEST(GamaXml, VectorsAndCoordinatesTurnWithTheAxes) {
  const auto s = read_gama_xml(
      network("<point id='A' x='0' y='0' z='0' fix='xyz'/><point id='B' adj='xyz'/>"
              "<vectors><vec from='A' to='B' dx='1' dy='2' dz='3'/>"
              "<cov-mat dim='3' band='2'>1 0.1 0.2 4 0.3 9</cov-mat></vectors>"
              "<coordinates><point id='B' x='1' y='2' z='3'/><cov-mat dim='3' band='0'>1 4 9</cov-mat></coordinates>",
              "axes-xy=\"ne\""),
      "t.gkf");
  ASSERT_EQ(s.vectors.size(), 1u);
  EXPECT_EQ(s.vectors[0].values, Eigen::Vector3d(2, 1, 3));
  EXPECT_NEAR(s.vectors[0].covariance(0, 0), 4e-6, 1e-18);
  EXPECT_NEAR(s.vectors[0].covariance(0, 2), 0.3e-6, 1e-18);
  ASSERT_EQ(s.coordinates.size(), 1u);
  EXPECT_EQ(s.coordinates[0].values, Eigen::Vector3d(2, 1, 3));
  const NetworkResult r = adjust_network(s, {});
  EXPECT_LT((r.point("B").position - Eigen::Vector3d(2, 1, 3)).norm(), 1e-9);
  EXPECT_EQ(r.degrees_of_freedom, 3);
}

TEST(GamaXml, OneDimensionalLevelling) {
  const auto s = read_gama_xml(
      network(
          "<point id='A' z='10' fix='z'/><point id='B' adj='z'/><point id='C' adj='z'/>"
          "<height-differences><dh from='A' to='B' val='1.000' stdev='1'/><dh from='B' to='C' val='2.003' stdev='1'/>"
          "<dh from='C' to='A' val='-3.000' stdev='1'/></height-differences>"),
      "t.gkf");
  const NetworkResult r = adjust_network(s, {});
  EXPECT_EQ(r.degrees_of_freedom, 1);
  EXPECT_NEAR(r.point("B").position.z(), 10.999, 1e-9);
  EXPECT_NEAR(r.point("C").position.z(), 13.001, 1e-9);
  EXPECT_TRUE(std::isnan(r.point("B").position.x()));
}

TEST(GamaXml, PlaneTriangleFromAnglesAndOneDistance) {
  const auto s = read_gama_xml(
      network(
          "<point id='A' x='0' y='0' fix='xy'/><point id='B' x='100' y='0' fix='xy'/><point id='C' adj='xy'/>"
          "<obs from='A'><angle bs='C' fs='B' val='50' stdev='10'/></obs>"
          "<obs from='B'><angle bs='A' fs='C' val='50' stdev='10'/></obs>"
          "<obs from='C'><angle bs='B' fs='A' val='100' stdev='10'/><distance to='A' val='70.7107' stdev='5'/></obs>"),
      "t.gkf");
  const NetworkResult r = adjust_network(s, {});
  EXPECT_LT((r.point("C").position.head<2>() - Eigen::Vector2d(50, 50)).norm(), 1e-4);
  EXPECT_EQ(r.degrees_of_freedom, 2);
}

TEST(GamaXml, AnAzimuthOrientsTheSetUpOfItsStation) {
  const auto s = read_gama_xml(
      network("<point id='A' x='0' y='0' fix='xy'/><point id='B' adj='xy'/><point id='C' adj='xy'/>"
              "<obs from='A'><azimuth to='B' val='100-00-00' stdev='10'/><direction to='B' val='0' stdev='10'/>"
              "<direction to='C' val='350' stdev='10'/><distance to='B' val='10' stdev='5'/>"
              "<distance to='C' val='20' stdev='5'/></obs>"),
      "t.gkf");
  const NetworkResult r = adjust_network(s, {});
  const double azimuth = 100 * std::numbers::pi / 180;
  EXPECT_LT((r.point("B").position.head<2>() - 10 * Eigen::Vector2d(std::sin(azimuth), std::cos(azimuth))).norm(),
            1e-6);
  const double other = azimuth - 50 * kGon;
  EXPECT_LT((r.point("C").position.head<2>() - 20 * Eigen::Vector2d(std::sin(other), std::cos(other))).norm(), 1e-6);
}

TEST(GamaXml, WhatContradictsTheApproximateCoordinatesByAMetreIsLeftOut) {
  const auto s = read_gama_xml(
      network(
          "<point id='A' x='0' y='0' fix='xy'/><point id='B' x='100' y='0' fix='xy'/>"
          "<point id='C' x='50' y='50' adj='xy'/>"
          "<obs><distance from='A' to='C' val='70.711' stdev='5'/><distance from='B' to='C' val='70.711' stdev='5'/>"
          "<distance from='A' to='C' val='75.711' stdev='5'/></obs>"),
      "t.gkf");
  const NetworkResult r = adjust_network(s, {});
  EXPECT_EQ(r.observations, 2);
  ASSERT_FALSE(r.findings.empty());
  EXPECT_NE(r.findings[0].text.find("contradicts"), std::string::npos);
}

TEST(GamaXml, ObservedCoordinatesCanDeclareTheirPoints) {
  const auto s = read_gama_xml(
      network("<point id='B' adj='z'/><height-differences><dh from='A' to='B' val='2' stdev='1'/></height-differences>"
              "<coordinates><point id='A' z='10' adj='z'/><cov-mat dim='1' band='0'>4</cov-mat></coordinates>"),
      "t.gkf");
  const NetworkResult r = adjust_network(s, {});
  EXPECT_NEAR(r.point("B").position.z(), 12, 1e-9);
  EXPECT_NEAR(r.sigma(r.point("B")).z(), std::sqrt(5.0) * 1e-3, 1e-9);
}

TEST(GamaXml, ANetworkOfUnusedPointsIsAnError) {
  const auto s = read_gama_xml(network("<point id='A' x='0' y='0'/><point id='B' x='1' y='0'/>"
                                       "<obs><distance from='A' to='B' val='1' stdev='5'/></obs>"),
                               "t.gkf");
  EXPECT_THROW(adjust_network(s, {}), NetworkError);
}

TEST(GamaXml, SixtySecondsAreOneMinute) {
  double angle = 0;
  ASSERT_TRUE(parse_degrees_minutes_seconds("187-33-60.00", angle));
  EXPECT_NEAR(angle, (187 + 34.0 / 60) * std::numbers::pi / 180, 1e-14);
  EXPECT_FALSE(parse_degrees_minutes_seconds("187-33-61", angle));
  EXPECT_FALSE(parse_degrees_minutes_seconds("187-33", angle));
  ASSERT_TRUE(parse_degrees_minutes_seconds("-1-30-00", angle));
  EXPECT_NEAR(angle, -1.5 * std::numbers::pi / 180, 1e-15);
}

TEST(GamaXml, DamageIsListedAndTheRestIsRead) {
  const auto s = read_gama_xml(network("<point id='A' x='0' y='0' adj='XY'/><point id='B' x='9' y='9' adj='XY'/>\n"
                                       "<obs from='A'>\n<distance to='B' val='abc' stdev='5'/>\n"
                                       "<distance to='B' val='12' stdev='5'/>\n<direction to='B' val='1'/></obs>"),
                               "t.gkf");
  EXPECT_EQ(s.observations.size(), 1u);
  ASSERT_EQ(s.skipped.size(), 2u);
  EXPECT_EQ(s.skipped[0].source.line, 8);
  EXPECT_NE(s.skipped[0].found.find("abc"), std::string::npos);
}

TEST(GamaXml, OtherFilesAreRefused) {
  EXPECT_THROW(read_gama_xml("<a/>", "t"), SurveyReadError);
  EXPECT_THROW(read_gama_xml("no xml", "t"), SurveyReadError);
  EXPECT_THROW(read_gama_xml(network("<point id='A' fix='xyz'/><point id='B' x='1' y='1' adj='xy'/>"
                                     "<obs from='A'><distance to='B' val='1' stdev='1'/></obs>"),
                             "t"),
               SurveyReadError);
}

TEST(GamaXml, WritesWhatItReads) {
  test::SimulationSettings settings;
  auto n = test::simulate(settings, 3);
  n.survey.covariances.push_back({{0, 1, 2}, Eigen::Vector3d(2e-10, 2e-10, 1e-6).asDiagonal()});
  n.survey.covariances[0].covariance(0, 1) = n.survey.covariances[0].covariance(1, 0) = 1e-10;
  for (int k = 0; k < 3; ++k)
    n.survey.observations[static_cast<size_t>(k)].sigma = std::sqrt(n.survey.covariances[0].covariance(k, k));
  const auto back = read_gama_xml(write_gama_xml(n.survey), "back.gkf");
  AdjustOptions options;
  options.datum = DatumMode::inner;
  options.curvature = Switch::off;
  const NetworkResult a = adjust_network(n.survey, options), b = adjust_network(back, options);
  EXPECT_EQ(a.degrees_of_freedom, b.degrees_of_freedom);
  EXPECT_NEAR(a.sum_of_squares, b.sum_of_squares, 1e-6 * a.sum_of_squares);
  EXPECT_NEAR((a.point("M00").position - a.point("M23").position).norm(),
              (b.point("M00").position - b.point("M23").position).norm(), 1e-8);
  n.survey.observations[0].face = 2;
  EXPECT_THROW(write_gama_xml(n.survey), std::runtime_error);
}

}  // namespace
}  // namespace plumbline::survey
