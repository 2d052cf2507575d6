// The fixture's readings were computed from geocentric places and local verticals on the ellipsoid, without a
// projection.
#include <gtest/gtest.h>

#include "survey/files/dynaml.hpp"
#include "survey/files/geodetic_frame.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_dynaml {

using namespace test_help;
using enum ObservationKind;

constexpr double kSecond = kDegree / 3600;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(DynaMl, ReadingsAgreeWithTheStationsOfTheirFile) {
  const auto s = read_dynaml(fixture("dynaml.xml"), "d.xml");
  EXPECT_TRUE(s.skipped.empty());
  ASSERT_EQ(s.set_ups.size(), 1u);
  EXPECT_EQ(point(s, "P1").roles[0], CoordinateRole::fixed);
  EXPECT_EQ(point(s, "P1").roles[2], CoordinateRole::fixed);
  EXPECT_EQ(point(s, "P3").roles[1], CoordinateRole::free);
  EXPECT_NEAR(point(s, "P3").coordinates.z(), 29.4, 1e-3) << "from geocentric coordinates";
  double orientation = kNotGiven;
  int distances = 0, zeniths = 0, directions = 0, others = 0;
  for (const Observation& o : s.observations) {
    Eigen::Vector3d d = point(s, o.to).coordinates - point(s, o.from).coordinates;
    if (o.instrument_height > 0) d.z() += o.target_height - o.instrument_height;
    const double h = d.head<2>().norm(), azimuth = std::atan2(d.x(), d.y());
    if (o.kind == slope_distance) {
      EXPECT_NEAR(o.value, d.norm(), 5e-4) << o.to;
      ++distances;
    } else if (o.kind == zenith_angle) {
      EXPECT_NEAR(o.value, std::atan2(h, d.z() - h * h / (2 * 6371000.0)), 2 * kSecond) << o.to;
      EXPECT_EQ(o.instrument_height, 1.55);
      EXPECT_NEAR(o.sigma, 2 * kSecond, 1e-15);
      ++zeniths;
    } else if (o.kind == direction) {
      if (std::isnan(orientation)) orientation = azimuth - o.value;
      EXPECT_NEAR(std::remainder(azimuth - o.value - orientation, 2 * std::numbers::pi), 0, kSecond) << o.to;
      ++directions;
    } else if (o.kind == angle) {
      const Eigen::Vector3d right = point(s, o.second_to).coordinates - point(s, o.from).coordinates;
      const double turn = std::atan2(right.x(), right.y()) - azimuth;
      EXPECT_NEAR(std::remainder(o.value - turn, 2 * std::numbers::pi), 0, kSecond);
      ++others;
    } else {
      EXPECT_EQ(o.kind, height_difference);
      EXPECT_NEAR(o.value, d.z(), 1e-9);
      ++others;
    }
  }
  EXPECT_EQ(distances, 4) << "three slopes and a chord from mark to mark; one is ignored";
  EXPECT_EQ(zeniths, 3);
  EXPECT_EQ(directions, 3) << "one is ignored";
  EXPECT_EQ(others, 2);
  ASSERT_EQ(s.coordinates.size(), 1u);
  EXPECT_EQ(s.coordinates[0].components[0].axis, 2);
  EXPECT_DOUBLE_EQ(s.coordinates[0].covariance(0, 0), 1e-4);
  bool told = false;
  for (const std::string& w : s.warnings) told = told || w.find("plane about latitude -37.800") != std::string::npos;
  EXPECT_TRUE(told) << "where the plane lies";
}

TEST(DynaMl, WhatCannotBeAdjustedIsNamed) {
  const std::string whole = fixture("dynaml.xml");
  for (const auto& [type, words] : {std::pair{"G", "a GNSS baseline (G)"},
                                    {"X", "a GNSS baseline cluster (X)"},
                                    {"K", "an astronomic azimuth (K)"},
                                    {"M", "a mean sea level arc (M)"},
                                    {"R", "an ellipsoidal height (R)"},
                                    {"w", "the measurement type"}}) {
    const auto s = read_dynaml(replaced(whole, "<Type>A<", "<Type>" + std::string(type) + "<"), "d.xml");
    ASSERT_EQ(s.skipped.size(), 1u) << type;
    EXPECT_NE(s.skipped[0].found.find(words), std::string::npos) << s.skipped[0].found;
    EXPECT_EQ(s.observations.size(), read_dynaml(whole, "d.xml").observations.size() - 1);
  }
  for (const auto& [from, to] : {std::pair{"<StdDev>3.0<", "<StdDev>0<"},
                                 {"<Value>88.114199983<", "<Value>88.7141<"},
                                 {"<Value>90.82757<", "<Value>-90.8<"},
                                 {"<InstHeight>1.550<", "<InstHeight>high<"},
                                 {"<Second>P2<", "<Second><"},
                                 {"CCC", "CFF"},
                                 {"<Type>LLH<", "<Type>ENU<"},
                                 {"-4131127.4376", "-431127.4376"}})
    EXPECT_EQ(read_dynaml(replaced(whole, from, to), "d.xml").skipped.size(), 1u) << from;
  EXPECT_NE(error_of([&] { read_dynaml(replaced(whole, "GDA2020", "AGD66"), "d.xml"); }).find("on GRS80"),
            std::string::npos);
  const std::string far = error_of([&] { read_dynaml(replaced(whole, "-37.480288", "-47.480288"), "d.xml"); });
  EXPECT_NE(far.find("a network within 500 km"), std::string::npos) << far;
  EXPECT_NE(error_of([] { read_dynaml("<DnaXmlFormat/>", "d.xml"); }).find("DnaStation"), std::string::npos);
}

/// A cluster of two baselines: their covariance with each other stands in a block of the first.
TEST(DynaMl, BaselinesOfAClusterKeepTheirCovariance) {
  const auto baseline = [](const std::string& to, double x, const std::string& block) {
    return "<First>A</First><Second>" + to + "</Second><GPSBaseline><X>" + std::to_string(x) +
           "</X><Y>-20.5</Y><Z>30.25</Z><SigmaXX>4e-6</SigmaXX><SigmaXY>1e-6</SigmaXY><SigmaXZ>0</SigmaXZ>"
           "<SigmaYY>9e-6</SigmaYY><SigmaYZ>-1e-6</SigmaYZ><SigmaZZ>5e-6</SigmaZZ>" +
           block + "</GPSBaseline>";
  };
  const std::string block =
      "<GPSCovariance><m11>1e-6</m11><m12>2e-7</m12><m13>0</m13><m21>3e-7</m21><m22>2e-6</m22><m23>0</m23>"
      "<m31>0</m31><m32>0</m32><m33>1e-6</m33></GPSCovariance>";
  const auto file = [&](const std::string& type, const std::string& content) {
    return "<DnaXmlFormat referenceframe=\"GDA2020\"><DnaMeasurement><Type>" + type +
           "</Type><Ignore/><Vscale>2.0</Vscale><Pscale>4</Pscale><Lscale>4</Lscale><Hscale>9</Hscale>" + content +
           "</DnaMeasurement></DnaXmlFormat>";
  };
  const auto s = read_dynaml(file("X", baseline("B", 10.125, block) + baseline("C", 11, "")), "d.xml");
  ASSERT_TRUE(s.skipped.empty()) << s.skipped.front().found;
  ASSERT_EQ(s.vectors.size(), 1u);
  const VectorGroup& g = s.vectors[0];
  EXPECT_TRUE(g.is_geocentric);
  EXPECT_EQ(g.horizontal_factor, 2) << "of standard deviations";
  EXPECT_EQ(g.vertical_factor, 3);
  ASSERT_EQ(g.vectors.size(), 2u);
  EXPECT_EQ(g.vectors[1].to, "C");
  EXPECT_EQ(g.values[0], 10.125);
  EXPECT_NEAR(g.covariance(0, 0), 8e-6, 1e-18);
  EXPECT_NEAR(g.covariance(1, 2), -2e-6, 1e-18);
  EXPECT_NEAR(g.covariance(0, 4), 4e-7, 1e-18) << "m12: X of the first, Y of the second";
  EXPECT_NEAR(g.covariance(4, 0), 4e-7, 1e-18);
  EXPECT_NEAR(g.covariance(1, 3), 6e-7, 1e-18);
  const auto single = read_dynaml(file("G", baseline("B", 10, "")), "d.xml");
  EXPECT_EQ(single.vectors.size(), 1u);
  for (const std::string& wrong :
       {file("X", baseline("B", 10, "") + baseline("C", 11, "")), file("G", baseline("A", 10, "")),
        file("G", baseline("B", 10, "") + "<First>C</First>"),
        replaced(file("G", baseline("B", 10, "")), "<Lscale>4", "<Lscale>5"),
        replaced(file("G", baseline("B", 10, "")), "4e-6", "-4e-6"),
        replaced(file("G", baseline("B", 10, "")), "<Y>-20.5", "<Y>west")}) {
    const std::string said = error_of([&] { read_dynaml(wrong, "d.xml"); });
    EXPECT_NE(said.find("d.xml:1:"), std::string::npos) << said;
  }
}

/// A cluster of points says where its points are in X, Y, Z of the earth, with one covariance of all.
TEST(DynaMl, PointClustersAreCoordinatesOfThePlane) {
  const auto station = [](const std::string& id, const Eigen::Vector3d& p, const std::string& type) {
    std::string at;
    for (int k = 0; k < 3; ++k) {
      static const char* const names[] = {"XAxis", "YAxis", "Height"};
      at += "<" + std::string(names[k]) + ">" + std::to_string(p[k]) + "</" + names[k] + ">";
    }
    return "<DnaStation><Name>" + id + "</Name><Constraints>FFF</Constraints><Type>" + type + "</Type><StationCoord>" +
           at + "</StationCoord></DnaStation>";
  };
  const Eigen::Vector3d a(-4297030.4411, 2827160.2328, -3759485.1852), b = a + Eigen::Vector3d(800, 1500, 200);
  const auto cluster_point = [](const std::string& id, const Eigen::Vector3d& p, const std::string& block) {
    return "<First>" + id + "</First><Clusterpoint><X>" + std::to_string(p.x()) + "</X><Y>" + std::to_string(p.y()) +
           "</Y><Z>" + std::to_string(p.z()) +
           "</Z><SigmaXX>4e-6</SigmaXX><SigmaXY>1e-6</SigmaXY><SigmaXZ>0</SigmaXZ><SigmaYY>9e-6</SigmaYY>"
           "<SigmaYZ>-1e-6</SigmaYZ><SigmaZZ>5e-6</SigmaZZ>" +
           block + "</Clusterpoint>";
  };
  const std::string block =
      "<PointCovariance><m11>1e-6</m11><m12>2e-7</m12><m13>0</m13><m21>3e-7</m21><m22>2e-6</m22><m23>0</m23>"
      "<m31>0</m31><m32>0</m32><m33>1e-6</m33></PointCovariance>";
  const Eigen::Vector3d shift(0.003, -0.002, 0.004);
  const auto file = [&](const std::string& scales) {
    return "<DnaXmlFormat referenceframe=\"GDA2020\">" + station("A", a, "XYZ") + station("B", b, "XYZ") +
           "<DnaMeasurement><Type>Y</Type><Ignore/>" + scales + "<Coords>XYZ</Coords><Total>2</Total>" +
           cluster_point("A", a + shift, block) + cluster_point("B", b, "") + "</DnaMeasurement></DnaXmlFormat>";
  };
  const auto s = read_dynaml(file("<Vscale>2.0</Vscale>"), "d.xml");
  ASSERT_TRUE(s.skipped.empty()) << s.skipped.front().found;
  ASSERT_EQ(s.coordinates.size(), 1u);
  const CoordinateGroup& g = s.coordinates[0];
  ASSERT_EQ(g.components.size(), 6u);
  EXPECT_EQ(g.components[4].point, "B");
  EXPECT_EQ(g.components[4].axis, 1);
  // East, north, up at A, from its latitude and longitude alone.
  const Geodetic place = from_geocentric(a);
  const double sl = std::sin(place.longitude), cl = std::cos(place.longitude), sp = std::sin(place.latitude),
               cp = std::cos(place.latitude);
  Eigen::Matrix3d level;
  level << -sl, cl, 0, -sp * cl, -sp * sl, cp, cp * cl, cp * sl, sp;
  EXPECT_LT((g.values.head<3>() - point(s, "A").coordinates - level * shift).norm(), 1e-6)
      << "and not by the station's own coordinates";
  Eigen::Matrix3d own, between;
  own << 4, 1, 0, 1, 9, -1, 0, -1, 5;
  between << 1, 0.2, 0, 0.3, 2, 0, 0, 0, 1;
  const Geodetic of_b = from_geocentric(b);
  Eigen::Matrix3d level_b;
  const double sm = std::sin(of_b.longitude), cm = std::cos(of_b.longitude), sq = std::sin(of_b.latitude),
               cq = std::cos(of_b.latitude);
  level_b << -sm, cm, 0, -sq * cm, -sq * sm, cq, cq * cm, cq * sm, sq;
  EXPECT_LT((g.covariance.topLeftCorner<3, 3>() - 2e-6 * level * own * level.transpose()).norm(), 5e-9);
  EXPECT_LT((g.covariance.topRightCorner<3, 3>() - 2e-6 * level * between * level_b.transpose()).norm(), 5e-9);
  const auto scaled = read_dynaml(file("<Pscale>4</Pscale><Lscale>4</Lscale><Hscale>9</Hscale>"), "d.xml");
  EXPECT_NEAR(scaled.coordinates[0].covariance(0, 1), 2 * g.covariance(0, 1), 1e-12);
  EXPECT_NEAR(scaled.coordinates[0].covariance(2, 2), 4.5 * g.covariance(2, 2), 1e-12);
  for (const auto& [what, with] : {std::pair{"XYZ</Coords>", "LLH</Coords>"},
                                   {"<First>B</First>", ""},
                                   {"4e-6", "-4e-6"},
                                   {"<m12>2e-7", "<m12>west"}}) {
    const auto wrong = read_dynaml(replaced(file(""), what, with), "d.xml");
    EXPECT_EQ(wrong.skipped.size(), 1u) << what;
    EXPECT_TRUE(wrong.coordinates.empty()) << what;
  }
}

TEST(DynaMl, EveryTruncationIsReadOrRefused) {
  const std::string whole = fixture("dynaml.xml");
  for (std::size_t n = 0; n < whole.size(); n += 7) {
    try {
      for (const Observation& o : read_dynaml(whole.substr(0, n), "cut.xml").observations)
        EXPECT_TRUE(o.kind != slope_distance || o.value > 90) << "a number cut at byte " << n;
    } catch (const SurveyReadError&) {
    }
  }
}

double degrees(double d, double m, double s) { return (d + m / 60 + s / 3600) * kDegree; }

// Flinders Peak and Buninyong, whose coordinates the technical manual of GDA94 gives.
TEST(GeodeticFrame, UtmOfTheManual) {
  const Geodetic flinders = from_utm(273741.297, 5796489.777, 55, true);
  EXPECT_NEAR(flinders.latitude, -degrees(37, 57, 3.72030), 3e-10);
  EXPECT_NEAR(flinders.longitude, degrees(144, 25, 29.52440), 3e-10);
  const Geodetic buninyong = from_utm(758173.797, 5828674.340, 54, true);
  EXPECT_NEAR(buninyong.latitude, -degrees(37, 39, 10.15610), 3e-10);
  EXPECT_NEAR(buninyong.longitude, degrees(143, 55, 35.38390), 3e-10);
  const Eigen::Vector2d back = TransverseMercator(147 * kDegree, 0.9996).forward(flinders);
  EXPECT_NEAR(back.x(), 273741.297 - 500000, 1e-6);
  EXPECT_NEAR(back.y(), 5796489.777 - 10000000, 1e-6);
}

Eigen::Vector3d geocentric(const Geodetic& p) {
  const double e2 = (2 - 1 / 298.257222101) / 298.257222101, s = std::sin(p.latitude), c = std::cos(p.latitude);
  const double n = 6378137 / std::sqrt(1 - e2 * s * s);
  return {(n + p.height) * c * std::cos(p.longitude), (n + p.height) * c * std::sin(p.longitude),
          (n * (1 - e2) + p.height) * s};
}

TEST(GeodeticFrame, LengthsOfTheGroundPlaneAreTrue) {
  for (const double latitude : {-37.8, 0.5, 47.3, 68.0})
    for (const double height : {0.0, 35.0, 1800.0}) {
      const Geodetic centre{latitude * kDegree, 11 * kDegree, height};
      const Geodetic back = from_geocentric(geocentric(centre));
      EXPECT_NEAR(back.latitude, centre.latitude, 1e-13);
      EXPECT_NEAR(back.height, height, 1e-6);
      // High up the two curvatures of the ellipsoid differ: H (1/M - 1/N) / 2, at most 1e-6 at 1800 m.
      const GroundPlane plane(centre);
      EXPECT_LT(plane(centre).norm(), 1e-6);
      for (int k = 0; k < 6; ++k) {
        const double turn = k * std::numbers::pi / 3;
        const Geodetic a{centre.latitude + 7e-5 * std::cos(turn), centre.longitude + 9e-5 * std::sin(turn), height};
        const Geodetic b{centre.latitude - 4e-5 * std::sin(turn), centre.longitude + 6e-5 * std::cos(turn), height};
        const double chord = (geocentric(a) - geocentric(b)).norm();
        EXPECT_NEAR((plane(a) - plane(b)).norm() / chord, 1, height > 1000 ? 1e-6 : 1e-7)
            << latitude << " " << height << " " << k;
      }
      const Eigen::Vector2d north = plane({centre.latitude + 1e-5, centre.longitude, height});
      EXPECT_GT(north.y(), 0);
      EXPECT_NEAR(north.x(), 0, 1e-6);
    }
}

}  // namespace test_dynaml
}  // namespace plumbline::survey
