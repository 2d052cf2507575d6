// gama-local XML: every element and attribute, units and senses, damage, and the way back.
#include <numbers>

#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/files/gama.hpp"
#include "survey/model/map_frame.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_gama_xml {

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

TEST(GamaXml, APointThatOnlyReadingsNameIsNoPointOfTheResult) {
  const auto s = read_gama_xml(
      network(
          "<point id='A' z='10' fix='z'/><point id='B' adj='z'/>"
          "<height-differences><dh from='A' to='B' val='1.000' stdev='1'/><dh from='B' to='A' val='-1.001' stdev='1'/>"
          "<dh from='A' to='X' val='2.000' stdev='1'/></height-differences>"),
      "t.gkf");
  const NetworkResult r = adjust_network(s, {});
  ASSERT_EQ(r.points.size(), 2u);
  for (const ResultPoint& p : r.points) EXPECT_FALSE(p.position.array().isNaN().all()) << p.id;
  bool told = false;
  for (const Finding& f : r.findings) told |= f.text.find("A -> X") != std::string::npos;
  EXPECT_TRUE(told);
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

std::string vector_of(const char* from, const char* to, const char* d, const char* variances) {
  return std::string("<obs><vector><from>") + from + "</from><to>" + to + "</to>" + d +
         "</vector><cov-mat><dim>3</dim><band>0</band>" + variances + "</cov-mat></obs>\n";
}

/// Networks demo-g3-01 and demo-g3-03 of GNU Gama's suite with the results of gama-g3 1.10 that lie beside them: X, Y,
/// Z to 1e-5 m, covariances (a posteriori) in the horizon of each point [mm^2]. Ours is on a plane of its own.
struct G3Point {
  const char* id;
  Eigen::Vector3d earth;
  double nn, ne, nu, ee, eu, uu;
};

void expect_as_gama_g3(const std::string& content, const std::vector<G3Point>& expected, int redundancy,
                       double sum_of_squares) {
  const auto survey = read_gama_xml(
      "<?xml version=\"1.0\"?>\n<gnu-gama-data xmlns=\"http://www.gnu.org/software/gama/"
      "gnu-gama-data\"><g3-model><constants><ellipsoid><id>wgs84</id></ellipsoid>"
      "</constants>" +
          content + "</g3-model></gnu-gama-data>",
      "g3.xml");
  EXPECT_TRUE(survey.skipped.empty()) << survey.skipped.front().found;
  const NetworkResult r = adjust_network(survey, {});
  EXPECT_EQ(r.degrees_of_freedom, redundancy);
  EXPECT_NEAR(r.sum_of_squares * 100, sum_of_squares, 1e-5 * sum_of_squares);        // its weights are of 10 mm
  const MapFrame frame(survey.info.coordinate_system, {}, Eigen::Vector2d::Zero());  // by PROJ
  for (const G3Point& p : expected) {
    const auto& at = r.point(p.id);
    EXPECT_LT((frame.geocentric(at.position) - p.earth).norm(), 2e-5) << p.id;
    const Eigen::Matrix3d c = 1e6 * r.covariance(at, at);
    const double tolerance = 4e-3 * (p.nn + p.ee + p.uu);  // the plane's north is turned by up to 0.2 degrees
    EXPECT_NEAR(c(1, 1), p.nn, tolerance) << p.id;
    EXPECT_NEAR(c(0, 0), p.ee, tolerance) << p.id;
    EXPECT_NEAR(c(2, 2), p.uu, tolerance) << p.id;
    EXPECT_NEAR(c(0, 1), p.ne, tolerance) << p.id;
    EXPECT_NEAR(c(1, 2), p.nu, tolerance) << p.id;
    EXPECT_NEAR(c(0, 2), p.eu, tolerance) << p.id;
  }
}

std::string g3_vectors() {
  return vector_of("B", "C", "<dx>-8882.8485</dx><dy>-10727.3349</dy><dz>9069.8455</dz>",
                   "<flt>0.4</flt><flt>0.2</flt><flt>0.5</flt>") +
         vector_of("A", "D", "<dx>-2590.2863</dx><dy>4708.4222</dy><dz>1156.5328</dz>",
                   "<flt>0.4</flt><flt>0.2</flt><flt>0.4</flt>") +
         vector_of("D", "E", "<dx>497.5786</dx><dy>5544.6487</dy><dz>-1483.8326</dz>",
                   "<flt>0.6</flt><flt>0.4</flt><flt>0.7</flt>") +
         vector_of("E", "C", "<dx>1680.9135</dx><dy>6095.1480</dy><dz>-2576.4300</dz>",
                   "<flt>0.5</flt><flt>0.3</flt><flt>0.5</flt>");
}

std::string g3_points(const char* names) {
  std::string text;
  for (; *names; ++names) text += "<point><id>" + std::string(1, *names) + "</id></point>";
  return text;
}

TEST(GamaXml, VectorsOfGamaG3BetweenFixedPoints) {
  expect_as_gama_g3(
      "<fixed><n/><e/><u/></fixed>"
      "<point><id>A</id><x>3897173.613</x><y> 997293.454</y><z>4933466.708</z></point>"
      "<point><id>B</id><x>3905644.621</x><y>1024368.968</y><z>4921493.098</z></point>"
      "<free><n/><e/><u/></free>" +
          g3_points("CDE") + g3_vectors(),
      {{"C",
        {3896761.78225, 1013641.64034, 4930562.95176},
        351.69311,
        30.149195,
        38.326750,
        181.46210,
        -24.455896,
        367.85306},
       {"D",
        {3894583.31695, 1002001.86896, 4934623.23419},
        328.05066,
        29.885334,
        8.9450219,
        181.25619,
        -24.191690,
        331.86009},
       {"E",
        {3895080.88093, 1007546.50319, 4933139.39002},
        508.88385,
        39.645842,
        32.130135,
        298.80450,
        -32.117219,
        522.51691}},
      3, 3.14167e5);
}

TEST(GamaXml, VectorsPlacesAndDistancesOfGamaG3) {
  expect_as_gama_g3(
      "<free><n/><e/><u/></free>" + g3_points("ABCDE") + g3_vectors() +
          "<obs><xyz><id>A</id><x>3897173.613</x><y> 997293.454</y><z>4933466.708</z></xyz>"
          "<xyz><id>B</id><x>3905644.621</x><y>1024368.968</y><z>4921493.098</z></xyz>"
          "<cov-mat><dim>6</dim><band>2</band><flt>0.31</flt><flt>0.10</flt><flt>0.04</flt><flt>0.32</flt>"
          "<flt>0.11</flt><flt>0.00</flt><flt>0.33</flt><flt>0.00</flt><flt>0.00</flt><flt>0.34</flt><flt>0.12</flt>"
          "<flt>0.05</flt><flt>0.35</flt><flt>0.13</flt><flt>0.36</flt></cov-mat></obs>"
          "<obs><distance><from>B</from><to>C</to><val>16620.550</val><stdev>15</stdev><from-dh>0</from-dh>"
          "<to-dh>0</to-dh></distance></obs>"
          "<obs><distance><from>B</from><to>C</to><val>16620.550</val></distance>"
          "<cov-mat><dim>1</dim><band>0</band><flt>225</flt></cov-mat></obs>",
      {{"A",
        {3897173.60567, 997293.44515, 4933466.70186},
        93.378582,
        -1.2054154,
        -6.8481306,
        83.519306,
        35.720275,
        127.00042},
       {"B",
        {3905644.62929, 1024368.97795, 4921493.10499},
        99.373793,
        -1.3603334,
        -8.4641809,
        87.576706,
        40.389821,
        138.64470},
       {"C",
        {3896761.78725, 1013641.64687, 4930562.95562},
        194.51366,
        8.1732940,
        4.9877192,
        131.69996,
        23.830677,
        230.21407},
       {"D",
        {3894583.31292, 1002001.86353, 4934623.23055},
        184.47237,
        8.6405386,
        -2.0169870,
        128.93974,
        21.403273,
        214.11464}},
      5, 1.86378e5);
}

TEST(GamaXml, WhatGamaG3CannotBeReadIsNamed) {
  const auto read = [](const std::string& content) {
    return read_gama_xml("<gnu-gama-data><g3-model>" + content + "</g3-model></gnu-gama-data>", "g3.xml");
  };
  EXPECT_THROW(read("<constants><ellipsoid><id>bessel</id></ellipsoid></constants>"), SurveyReadError);
  EXPECT_THROW(read_gama_xml("<gnu-gama-data><text>x</text></gnu-gama-data>", "g3.xml"), SurveyReadError);
  const auto s = read(
      "<free><n/><e/><u/></free><point><id>A</id><x>3897173.613</x><y> 997293.454</y>"
      "<z>4933466.708</z></point>" +
      g3_points("CDE") + g3_vectors() + "<obs><zenith><from>A</from><to>D</to><val>99</val></zenith></obs>");
  ASSERT_EQ(s.skipped.size(), 2u);
  EXPECT_NE(s.skipped[0].expected.find("two points that the file declares"), std::string::npos) << "B is not";
  EXPECT_NE(s.skipped[1].found.find("<zenith>"), std::string::npos);
  EXPECT_EQ(s.vectors.size(), 3u);
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
  for (int k = 0; k < 3; ++k) n.survey.observations[k].sigma = std::sqrt(n.survey.covariances[0].covariance(k, k));
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

}  // namespace test_gama_xml
}  // namespace plumbline::survey
