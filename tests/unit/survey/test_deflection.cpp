// Networks on a map over a geoid that is not level with the ellipsoid. The readings are made in X, Y, Z of the earth,
// each instrument standing along the plumb line of its own place: nothing of the adjustment's formulas is used.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <numbers>

#include "survey/adjust/adjust_network.hpp"
#include "survey/model/map_frame.hpp"

namespace plumbline::survey {
namespace test_deflection {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geodesy::Geoid;
using geodesy::MapProjection;
using geodesy::Place;

constexpr double kSecond = std::numbers::pi / 180 / 3600;
constexpr const char* kMap = "EPSG:25832";

/// A valley: two stations below, targets up to 300 m above them.
const std::map<std::string, Vector3d> kPoints = {{"A", {691000, 5335000, 600}}, {"B", {691480, 5335060, 610}},
                                                 {"C", {691200, 5335420, 905}}, {"D", {690870, 5335380, 700}},
                                                 {"P", {691330, 5335290, 890}}, {"Q", {690980, 5335150, 760}}};

SurveyObservations measured(const Geoid& geoid) {
  const MapProjection map(kMap);
  SurveyObservations s;
  for (const auto& [id, at] : kPoints) {
    Point p;
    p.id = id;
    p.coordinates = at;
    if (id <= "B") p.roles.fill(CoordinateRole::fixed);
    s.points.push_back(p);
  }
  const auto earth = [&](const Vector3d& p) {
    const Place place = map.inverse(p.head<2>());
    return map.geocentric(place, p.z() + geoid.height(place));
  };
  for (const std::string station : {"A", "B"}) {
    const auto set_up = static_cast<int>(s.set_ups.size());
    s.set_ups.push_back({station, station, 0, {}});
    const Place place = map.inverse(kPoints.at(station).head<2>());
    const Vector2d deflection = geoid.deflection(place);
    const Eigen::Matrix3d plumb = MapProjection::horizon(
        {place.latitude + deflection.x(), place.longitude + deflection.y() / std::cos(place.latitude)});
    for (const auto& [id, at] : kPoints) {
      if (id == station) continue;
      const Vector3d d = plumb * (earth(at) - earth(kPoints.at(station)));
      const std::pair<ObservationKind, double> readings[] = {
          {ObservationKind::direction, std::atan2(d.x(), d.y()) + 1.0},
          {ObservationKind::zenith_angle, std::atan2(d.head<2>().norm(), d.z())},
          {ObservationKind::slope_distance, d.norm()}};
      for (const auto& [kind, value] : readings) {
        Observation o;
        o.kind = kind, o.value = value, o.set_up = set_up, o.from = station, o.to = id;
        o.sigma = kind == ObservationKind::slope_distance ? 1e-3 : kSecond;
        s.observations.push_back(o);
      }
    }
  }
  return s;
}

/// Of the points that were measured [m].
double largest_error(const SurveyObservations& survey, const GeoidChoice& geoid) {
  AdjustOptions options;
  options.datum = DatumMode::file;
  options.map = kMap;
  options.geoid = geoid;
  options.curvature = Switch::on;
  options.refraction_coefficient = 0;
  const NetworkResult r = adjust_network(survey, options);
  double largest = 0;
  for (const auto& [id, at] : kPoints) largest = std::max(largest, (r.point(id).position - at).norm());
  return largest;
}

Vector2d middle() {
  Vector2d sum = Vector2d::Zero();
  for (const auto& [id, at] : kPoints) sum += at.head<2>();
  return sum / static_cast<double>(kPoints.size());
}

TEST(Deflection, ConstantsAreTheSlopeOfTheGeoid) {
  GeoidChoice geoid;
  geoid.height = 46.2;
  geoid.deflection = kSecond * Vector2d(14, -22);
  const MapProjection map(kMap);
  const SurveyObservations survey = measured(Geoid(geoid.height, geoid.deflection, map.inverse(middle())));
  EXPECT_LT(largest_error(survey, geoid), 2e-4);
  GeoidChoice level = geoid;
  level.deflection.setZero();
  EXPECT_GT(largest_error(survey, level), 0.01) << "26\" at 35 gon of elevation";
  GeoidChoice turned = geoid;
  turned.deflection = -geoid.deflection;
  EXPECT_GT(largest_error(survey, turned), 0.02);
}

TEST(Deflection, WithoutAMapOrBesideAGridIsRefused) {
  const SurveyObservations survey = measured(Geoid());
  AdjustOptions options;
  options.datum = DatumMode::file;
  options.geoid.deflection = kSecond * Vector2d(1, 0);
  EXPECT_THROW(adjust_network(survey, options), NetworkError);
  options.map = kMap;
  options.geoid.grid = "/nowhere/geoid.gtx";
  EXPECT_THROW(adjust_network(survey, options), NetworkError);
  options.geoid.deflection.setZero();
  try {
    adjust_network(survey, options);
    ADD_FAILURE() << "a grid that is not there";
  } catch (const NetworkError& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/geoid.gtx cannot be read"), std::string::npos) << error.what();
  }
}

/// EGM96 in the Alps.
TEST(Deflection, OfAGridIsItsSlopeAtEachStation) {
  const Place reference = MapProjection(kMap).inverse(middle());
  EXPECT_TRUE(std::isfinite(reference.latitude));
  const std::string egm96 = "/usr/share/proj/egm96_15.gtx";
  std::shared_ptr<const geodesy::GeoidGrid> grid;
  try {
    grid = std::make_shared<const geodesy::GeoidGrid>(egm96);
  } catch (const std::runtime_error&) {
    GTEST_SKIP() << egm96 << " is not there";
  }
  const Geoid geoid(grid);
  ASSERT_GT(geoid.deflection(reference).norm(), 2 * kSecond);
  const SurveyObservations survey = measured(geoid);
  GeoidChoice choice;
  choice.grid = egm96;
  EXPECT_LT(largest_error(survey, choice), 2e-4);
  GeoidChoice level;
  level.height = geoid.height(reference);
  EXPECT_GT(largest_error(survey, level), 1e-3);
}

/// The distance that an instrument would measure is the chord in X, Y, Z of the earth. Once a map took it for the arc:
/// 1 mm at 10 km, a metre at 100 km.
TEST(MapFrame, LongDistancesAreChords) {
  const MapFrame frame(kMap, {}, {500000, 5300000});
  for (const double length : {100.0, 5e3, 2e4, 1e5})
    for (const double height : {0.0, 300.0})
      for (const double bearing : {0.0, 0.8, 1.6, 2.9}) {
        const Vector3d from(560000, 5300000, height),
            to = from + Vector3d(length * std::sin(bearing), length * std::cos(bearing), 0.01 * length);
        const double chord = (frame.geocentric(to) - frame.geocentric(from)).norm();
        const double modelled = std::hypot((to - from).head<2>().norm() / frame.scale(from, to), to.z() - from.z());
        // Above the ellipsoid the radius depends on the azimuth: 0.02 ppm at 100 m, 0.2 ppm at 800 m.
        EXPECT_NEAR(modelled / chord, 1, height > 0 || length > 5e4 ? 2.5e-7 : 3e-8)
            << length << " m at " << bearing << ", " << height << " m up: " << 1e3 * (modelled - chord) << " mm";
      }
}

/// Far from the meridian a map's scale is another: of the transverse Mercator on a sphere k0 cosh(E' / (k0 R)) (Snyder
/// 1987, eq. 8-4).
TEST(MapThatExplains, KnowsTheScaleFarFromTheMeridian) {
  constexpr double kRadius = 6371000;
  for (const auto& [on_meridian, name] : {std::pair{0.9996, "UTM zone 32"}, std::pair{1.0, "Gauss-Krueger zone 32"}})
    for (const double offset : {-300e3, 250e3}) {
      const double factor = on_meridian * std::cosh(offset / (on_meridian * kRadius)) * kRadius / (kRadius + 400);
      const std::string words = map_that_explains(factor, 1e-6, {Vector3d(32.5e6 + offset, 5.4e6, 400)});
      EXPECT_NE(words.find(name), std::string::npos) << offset << ": " << words;
    }
}

/// Directions and horizontal distances 700 m above the sea, seen from A and B; no point has a height.
SurveyObservations plan_at(double height) {
  const MapProjection map(kMap);
  SurveyObservations s = measured(Geoid(47, Vector2d::Zero(), {}));
  std::erase_if(s.observations, [](const Observation& o) {
    return o.kind == ObservationKind::zenith_angle || (o.from == "A" && o.to == "B") || (o.from == "B" && o.to == "A");
  });
  for (Point& p : s.points) {
    p.coordinates.z() = kNotGiven;
    p.roles[2] = CoordinateRole::unused;
    if (p.id == "B") p.roles[0] = p.roles[1] = CoordinateRole::free;  // the scale is that of the distances
  }
  for (Observation& o : s.observations) {
    const Vector2d from = kPoints.at(o.from).head<2>(), to = kPoints.at(o.to).head<2>(), d = to - from;
    const double radius = map.radius(map.inverse(from));
    if (o.kind == ObservationKind::direction)
      o.value = std::atan2(d.x(), d.y()) - map.arc_to_chord(from, to);
    else
      o.kind = ObservationKind::horizontal_distance,
      o.value = d.norm() / map.line_scale(from, to) * (radius + height + 47) / radius;
    o.sigma = o.kind == ObservationKind::direction ? 1e-6 : 1e-4;
  }
  Observation north;
  north.kind = ObservationKind::azimuth, north.from = "A", north.to = "P", north.sigma = 1e-7;
  const Vector3d d = kPoints.at("P") - kPoints.at("A");
  north.value = std::atan2(d.x(), d.y());
  s.observations.push_back(north);
  return s;
}

/// Heights that nobody gave were 0 m: 700 m above the sea that is 110 ppm, "sound".
TEST(Map, APlanNetworkIsReducedFromTheHeightThatIsGiven) {
  AdjustOptions options;
  options.map = kMap;
  options.geoid.height = 47;
  const SurveyObservations s = plan_at(700);
  try {
    adjust_network(s, options);
    ADD_FAILURE() << "no height, and no word of it";
  } catch (const NetworkError& e) {
    EXPECT_NE(std::string(e.what()).find("mean_height=METRES"), std::string::npos) << e.what();
  }
  options.mean_height = 700;
  const NetworkResult r = adjust_network(s, options);
  for (const ResultPoint& p : r.points) EXPECT_NEAR((p.position - kPoints.at(p.id)).head<2>().norm(), 0, 1e-4) << p.id;
  EXPECT_NE(r.frame.find("height factor 0.99988"), std::string::npos) << r.frame;
}

/// Vectors of ETRS89 on a map of Bessel's ellipsoid: "sound", and 8 cm beside control at 10 km.
TEST(Map, VectorsOfTheEarthNeedAMapOfTheEarth) {
  SurveyObservations s;
  for (const char* id : {"A", "B"}) {
    Point p;
    p.id = id;
    p.coordinates = {3500000, 5316300, 300};
    if (s.points.empty()) p.roles.fill(CoordinateRole::fixed);
    s.points.push_back(p);
  }
  VectorGroup g;
  g.is_geocentric = true;
  g.vectors = {{"A", "B"}};
  g.values = Vector3d(100, 200, 300);
  g.covariance = 1e-6 * Eigen::Matrix3d::Identity();
  s.vectors = {g};
  AdjustOptions options;
  options.map = "EPSG:31467";
  try {
    adjust_network(s, options);
    ADD_FAILURE() << "taken as they are";
  } catch (const NetworkError& e) {
    EXPECT_NE(std::string(e.what()).find("vectors in X, Y, Z of the earth, and the ellipsoid of the map DHDN"),
              std::string::npos)
        << e.what();
  }
  EXPECT_TRUE(MapProjection("EPSG:25832").is_geocentric());
  EXPECT_TRUE(MapProjection("EPSG:32632").is_geocentric());
  EXPECT_TRUE(MapProjection("EPSG:26917").is_geocentric());
  for (const char* other : {"EPSG:31467", "EPSG:2056", "EPSG:27700", "EPSG:23032"})
    EXPECT_FALSE(MapProjection(other).is_geocentric()) << other;
}

/// GNSS over kilometres with one height of the geoid: heights were off by what it rises, with a standard deviation of a
/// millimetre; and without a height it was taken as 0 m.
TEST(GeoidSlope, HeightsOfVectorsHoldWhatIsNotKnownOfTheGeoid) {
  const Vector2d middle(500000, 5316300);
  GeoidChoice geoid;
  geoid.height = 47.5, geoid.deflection = kSecond * Vector2d(6, -4);
  const MapFrame earth(kMap, geoid, middle);
  const std::map<std::string, Vector3d> places = {
      {"K", {500000, 5316300, 300}}, {"A", {503000, 5319000, 350}}, {"B", {501000, 5321000, 320}}};
  SurveyObservations s;
  for (const auto& [id, at] : places) {
    Point p;
    p.id = id, p.coordinates = at;
    if (id == "K") p.roles.fill(CoordinateRole::fixed);
    s.points.push_back(p);
  }
  for (const auto& [from, to] : {std::pair("K", "A"), {"K", "B"}, {"A", "B"}}) {
    VectorGroup& v = s.vectors.emplace_back();
    v.is_geocentric = true;
    v.vectors = {{from, to, 0, 0}};
    v.values = earth.geocentric(places.at(to)) - earth.geocentric(places.at(from));
    v.covariance = 4e-6 * Eigen::Matrix3d::Identity();
  }
  AdjustOptions options;
  options.datum = DatumMode::file;
  options.map = kMap;
  options.geoid.slope_sigma = 10 * kSecond;
  EXPECT_THROW(adjust_network(s, options), NetworkError) << "at 0 m, which nobody has said";
  options.geoid.height = 47.5;
  const NetworkResult r = adjust_network(s, options);
  for (const auto* id : {"A", "B"}) {
    const Vector3d error = r.point(id).position - places.at(id), sigma = r.sigma(r.point(id));
    const double length = (places.at(id) - places.at("K")).head<2>().norm();
    EXPECT_LT(error.head<2>().norm(), 1e-3);
    EXPECT_GT(std::abs(error.z()), 10 * sigma.x()) << "the geoid rises";
    EXPECT_LT(std::abs(error.z()), 2 * sigma.z());
    EXPECT_NEAR(sigma.z(), 10 * kSecond * length, 0.02 * sigma.z());
  }
  // Levelled lines beside the vectors tell the slope.
  for (const auto* id : {"A", "B"}) {
    Observation o;
    o.kind = ObservationKind::height_difference, o.from = "K", o.to = id, o.sigma = 0.001;
    o.value = places.at(id).z() - 300;
    s.observations.push_back(o);
  }
  const NetworkResult levelled = adjust_network(s, options);
  EXPECT_LT((levelled.point("A").position - places.at("A")).norm(), 1e-3);
  EXPECT_EQ(levelled.validity, Validity::sound) << levelled.verdict;
}

}  // namespace test_deflection
}  // namespace plumbline::survey
