#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/geodesy/map_projection.hpp"

namespace plumbline::geodesy {
namespace test_map_projection {

constexpr double kDegree = std::numbers::pi / 180;

std::string error_of(const std::string& system) {
  try {
    MapProjection map(system);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

/// Snyder, Map Projections (USGS 1395), p. 269: UTM zone 18 on Clarke 1866, 40 30 N, 73 30 W: k = 0.9997989.
TEST(MapProjection, AgreesWithTheExampleOfSnyder) {
  const MapProjection map("EPSG:26718");  // NAD27 / UTM zone 18N
  const Eigen::Vector2d at = map.forward({40.5 * kDegree, -73.5 * kDegree});
  EXPECT_NEAR(at.x(), 627106.5, 0.1);
  EXPECT_NEAR(at.y(), 4484124.4, 0.1);
  EXPECT_NEAR(map.factors(at).scale, 0.9997989, 1e-7);
}

/// The double stereographic map of New Brunswick: 0.999912 at its centre, and 1 + r^2 / 4R^2 of that around it.
TEST(MapProjection, AStereographicMapGrowsWithTheSquareOfTheDistance) {
  const MapProjection map("EPSG:2953");
  const Eigen::Vector2d centre(2500000, 7500000), site(2488864, 7438248);
  EXPECT_NEAR(map.factors(centre).scale, 0.999912, 1e-9);
  const double r = (site - centre).norm(), radius = map.radius(map.inverse(centre));
  EXPECT_NEAR(map.factors(site).scale, 0.999912 * (1 + r * r / (4 * radius * radius)), 2e-8);
  EXPECT_NEAR(map.factors(centre).convergence, 0, 1e-9);
}

TEST(MapProjection, ConvergenceIsThatOfTheClosedFormula) {
  const MapProjection map("EPSG:25832");
  const Place place{50 * kDegree, 11 * kDegree};
  const MapFactors f = map.factors(map.forward(place));
  // East of the meridian grid north lies clockwise of true north by dlambda sin(phi) to the third order.
  EXPECT_NEAR(f.convergence, std::atan(std::tan(2 * kDegree) * std::sin(place.latitude)), 1e-6);
  EXPECT_GT(f.convergence, 0);
}

/// (N2 - N1)(2 E1 + E2) / 6R^2 with eastings from the meridian: the textbook's correction of a line in UTM.
TEST(MapProjection, TheArcLeadsToTheSideOfTheMeridian) {
  const MapProjection map("utm:32");
  const Eigen::Vector2d from(700000, 5500000), to(702000, 5510000);
  const double radius = map.radius(map.inverse(from));
  const double textbook = 10000 * (2 * 200000.0 + 202000.0) / (6 * radius * radius * 0.9996 * 0.9996);
  EXPECT_NEAR(std::abs(map.arc_to_chord(from, to)), textbook, 2e-3 * textbook);
  // East of the meridian the geodesic's image bulges east: going north it sets out clockwise of the straight line.
  EXPECT_LT(map.arc_to_chord(from, to), 0);
  EXPECT_GT(map.arc_to_chord(to, from), 0);
}

TEST(MapProjection, ReturnsWhereItCameFrom) {
  for (const char* system : {"EPSG:25832", "utm:19S", "EPSG:2953", "EPSG:2056", "EPSG:2154", "EPSG:28992"}) {
    const MapProjection map(system);
    const Eigen::Vector2d at = map.forward(map.inverse(Eigen::Vector2d(500000, 300000)));
    EXPECT_LT((at - Eigen::Vector2d(500000, 300000)).norm(), 1e-4) << system << " " << map.name();
  }
  EXPECT_EQ(MapProjection("NAD83(CSRS) / New Brunswick Stereographic").name(),
            "NAD83(CSRS) / New Brunswick Stereographic");
}

TEST(MapProjection, RefusesWhatIsNoMap) {
  EXPECT_NE(error_of("EPSG:4326").find("is no map"), std::string::npos);
  EXPECT_NE(error_of("Atlantis / Zone 3").find("no map is known as 'Atlantis / Zone 3'"), std::string::npos);
  EXPECT_NE(error_of("EPSG:2048").find("not east and north"), std::string::npos) << "south-orientated";
  const MapProjection equal_area("EPSG:3035");
  EXPECT_THROW(equal_area.factors({4800000, 3200000}), std::runtime_error);
}

}  // namespace test_map_projection
}  // namespace plumbline::geodesy
