// A map that is not that of the coordinates is a hypothesis of the doctor of causes: it is tried, and told where it
// takes the scale of the distances away.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "network_words.hpp"
#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/model/map_frame.hpp"

namespace plumbline::survey {
namespace test_map_causes {

/// A network of 200 m at E 380 km, N 5540 km, H 480 m, read on the ground under `map` with that geoid above the
/// ellipsoid; every mark is known to a hundredth of a millimetre.
SurveyObservations on_map(const std::string& map, double geoid) {
  test::SimulationSettings settings;
  settings.columns = 6, settings.rows = 4, settings.set_ups = 3;
  settings.distance_sigma = 2e-5, settings.angle_sigma = 2e-6;
  test::SimulatedNetwork n = test::simulate(settings, 5);
  const Eigen::Vector3d larger(10, 10, 1);  // times the network of the simulation
  const Eigen::Vector3d origin(380000, 5540000, 480);
  GeoidChoice height;
  height.height = geoid;
  std::map<std::string, Eigen::Vector3d> small, places;
  for (size_t i = 0; i < n.truth.size(); ++i) {
    Point& p = n.survey.points[i];
    small[p.id] = n.truth[i];
    p.coordinates = places[p.id] = larger.cwiseProduct(n.truth[i]) + origin;
    if (p.id[0] != 'M') continue;
    CoordinateGroup g;
    for (int k = 0; k < 3; ++k) g.components.push_back({p.id, k});
    g.values = p.coordinates;
    g.covariance = 1e-10 * Eigen::Matrix3d::Identity();
    g.is_control = true;
    n.survey.coordinates.push_back(std::move(g));
  }
  std::optional<MapFrame> frame;
  if (map != kPlane) frame.emplace(map, height, origin.head<2>());
  for (Observation& o : n.survey.observations) {
    const Eigen::Vector3d before = small.at(o.to) - small.at(o.from), d = larger.cwiseProduct(before);
    const double across = d.head<2>().norm() / (frame ? frame->scale(places.at(o.from), places.at(o.to)) : 1);
    if (o.kind == ObservationKind::slope_distance) o.value += std::hypot(across, d.z()) - before.norm();
    if (o.kind == ObservationKind::zenith_angle)
      o.value += std::atan2(across, d.z()) - std::atan2(before.head<2>().norm(), before.z());
  }
  return n.survey;
}

std::string words(const SurveyObservations& survey, const std::string& map) {
  AdjustOptions options;
  options.curvature = Switch::off;
  options.map = map;
  const NetworkResult r = adjust_network(survey, options);
  return r.verdict + "\n" + all_words(r);
}

TEST(MapCauses, CoordinatesOfAPlaneAreNamedWhereAMapIsGiven) {
  const std::string said = words(on_map(kPlane, 0), "EPSG:25832");
  EXPECT_NE(said.find("probably: the known points lie in a plane of their own"), std::string::npos) << said;
  EXPECT_NE(said.find("map=plane"), std::string::npos) << said;
}

TEST(MapCauses, UtmIsNamedWhereAnotherMapIsGiven) {
  const std::string said = words(on_map("EPSG:25832", 0), "EPSG:3765");
  EXPECT_NE(said.find("probably: the known points lie in UTM"), std::string::npos) << said;
  EXPECT_EQ(said.find("a plane of their own"), std::string::npos) << said;
}

/// Distances between heights above a geoid that nobody gave are off as by a ppm setting; 47 m are 7.4 ppm.
TEST(MapCauses, AGeoidThatNobodyGaveIsNamedBesideAPpmSettingThatWouldDoTheSame) {
  for (const double height : {47.0, -30.0}) {
    const std::string said = words(on_map("EPSG:25832", height), "EPSG:25832");
    const std::string words = "probably: the geoid lies about ";
    const size_t at = said.find(words);
    ASSERT_NE(at, std::string::npos) << said;
    EXPECT_NEAR(std::stod(said.substr(at + words.size())), height, 3) << said;  // 0.12 ppm are 0.75 m
    EXPECT_NE(said.find("these readings do not tell apart"), std::string::npos) << said;
  }
  EXPECT_EQ(words(on_map("EPSG:25832", 0), "EPSG:25832").find("the geoid lies"), std::string::npos);
}

/// What no map here explains is a ppm setting, and the map is named as one that it may be.
TEST(MapCauses, AScaleThatNoneExplainsIsNotCalledAMap) {
  SurveyObservations survey = on_map("EPSG:25832", 0);
  for (Observation& o : survey.observations)
    if (o.kind == ObservationKind::slope_distance) o.value *= 1.000150;
  const std::string said = words(survey, "EPSG:25832");
  EXPECT_EQ(said.find("probably: "), std::string::npos) << said;
  EXPECT_NE(said.find("check the ppm setting, the unit, and the map: its scale here is 0.99"), std::string::npos)
      << said;
}

}  // namespace test_map_causes
}  // namespace plumbline::survey
