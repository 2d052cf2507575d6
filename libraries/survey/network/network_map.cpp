// Part of network_model.cpp: which map a network is on, and what it makes of each observation.
#include <algorithm>
#include <cmath>

#include "survey/network/network_model_steps.hpp"

namespace plumbline::survey {

namespace {

/// E and N of the points that have them, of the file or as control, on the mean; of observed coordinates where there
/// are none.
Eigen::Vector2d middle_of_given(const NetworkModel& m) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero(), count = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < m.initial.size(); ++i)
    if (m.roles[i][0] != CoordinateRole::unused && m.initial[i].head<2>().allFinite())
      sum += m.initial[i].head<2>(), count += Eigen::Vector2d::Ones();
  if (count.isZero(0))
    for (const CoordinateGroup& g : m.survey.coordinates)
      for (size_t k = 0; k < g.components.size(); ++k)
        if (const int axis = g.components[k].axis; axis < 2)
          sum[axis] += g.values[static_cast<Eigen::Index>(k)], count[axis] += 1;
  return sum.cwiseQuotient(count.cwiseMax(1));
}

/// By how much the map of the file's own draws lengths wrongly at its farthest point [1]: it has true ones about E 0, N
/// 0.
double stretch_of_own_plane(const NetworkModel& m) {
  double farthest = 0;
  for (const Eigen::Vector3d& p : m.initial)
    if (p.head<2>().allFinite()) farthest = std::max(farthest, std::abs(p.x()));
  return 0.5 * farthest * farthest / (kEarthRadius * kEarthRadius);
}

/// Ends of a sight with the heights of instrument and target.
struct Sight {
  Eigen::Vector3d from, to;
};

Sight sight_of(const NetworkModel& m, const Observation& o, const std::string& to, double target_height) {
  const double own = o.set_up >= 0 ? m.survey.set_ups[o.set_up].instrument_height : 0.0;
  const auto end = [&](const std::string& id, double height) -> Eigen::Vector3d {
    return m.initial[m.index.at(id)] + or_zero(height) * Eigen::Vector3d::UnitZ();
  };
  return {end(o.from, or_else(o.instrument_height, own)), end(to, target_height)};
}

/// Plumb lines part upwards: from the station's horizon a target that lies higher by q is seen at (1 + q / 2R) of the
/// length between the two at their mean height. To be added to a zenith angle [rad]: 12 mm over 500 m to 300 m above.
double parting(const Sight& sight, double scale) {
  const double h = (sight.to - sight.from).head<2>().norm() / scale, up = sight.to.z() - sight.from.z();
  return h > 0 ? -h * up / (h * h + up * up) * up / (2 * kEarthRadius) : 0;
}

/// Instruments stand on the plumb line: what its deflection does to a sight, and how the geoid rises along it.
void add_deflection(const NetworkModel& m, const Observation& o, MapCorrection& c) {
  const Sight sight = sight_of(m, o, o.to, o.target_height);
  double direction = 0;
  m.map->add_deflection(sight.from, sight.to, direction, c.zenith, c.rise);
  if (o.kind == ObservationKind::angle) {
    double second = 0, unused = 0;
    const Sight right = sight_of(m, o, o.second_to, o.second_target_height);
    m.map->add_deflection(right.from, right.to, second, unused, c.second_rise);
    direction = second - direction;
  }
  c.direction += direction;
}

}  // namespace

namespace {

/// Vectors and geoid grids are of the earth: laid on another datum's ellipsoid as they are, vectors of some kilometres
/// are turned and stretched by centimetres, and the geoid lies 50 m beside it.
void refuse_other_datum(const NetworkModel& m, bool has_vectors, bool has_grid) {
  if (m.map->is_geocentric()) return;
  const std::string expected =
      " is one of another datum: take a map of ETRS89, WGS 84, NAD83 or another datum of the earth";
  if (has_vectors)
    throw NetworkError("the network has vectors in X, Y, Z of the earth, and the ellipsoid of the map " +
                       m.map->name() + expected + ", with control in it");
  if (has_grid)
    throw NetworkError("a geoid grid has heights above the ellipsoid of the earth, and that of the map " +
                       m.map->name() + expected + ", or give geoid_height above the map's own ellipsoid");
}

/// Of points whose height nothing observes, too: a known one is where it is. NaN without any.
double mean_of_given_heights(const NetworkModel& m) {
  double sum = 0;
  int heights = 0;
  for (const Eigen::Vector3d& p : m.initial)
    if (!std::isnan(p.z())) sum += p.z(), ++heights;
  return heights > 0 ? sum / heights : kNotGiven;
}

/// A length is the shorter on the map the higher it was measured, 16 mm in a kilometre for each 100 m: taken at 0 m it
/// would be wrong, and nothing in the readings shows it.
double height_of_lengths(const NetworkModel& m) {
  if (!std::isnan(m.mean_height)) return m.mean_height;
  double sum = 0;
  int heights = 0;
  for (size_t i = 0; i < m.initial.size(); ++i)
    if (m.roles[i][2] != CoordinateRole::unused && !std::isnan(m.initial[i].z())) sum += m.initial[i].z(), ++heights;
  if (heights > 0) return sum / heights;
  if (m.survey.info.coordinate_system.starts_with("+proj=")) return 0;  // the file's own, true at its own height
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const ObservationKind kind = m.observations[i].observation.kind;
    if (!m.dropped[i] && (kind == ObservationKind::slope_distance || kind == ObservationKind::horizontal_distance))
      throw NetworkError("map " + m.map->name() +
                         ": lengths are reduced to the map from the height that they were measured at (16 mm in a "
                         "kilometre for each 100 m), and no point has one: say how high the site lies, "
                         "network.with.mean_height=METRES above the sea, and geoid_height");
  }
  return 0;
}

/// Vectors end above the ellipsoid, and heights are counted from the sea.
void require_geoid(const std::string& system, const GeoidChoice& geoid) {
  if (!geoid.is_open() || geoid.height != 0 || system.starts_with("+proj=")) return;
  throw NetworkError(
      "the network has GNSS vectors, and nothing says how high the geoid lies above the ellipsoid of the map " +
      system +
      ": taken as 0 m, plan positions are wrong by 7.5 ppm for 48 m, and heights by what it rises over the site. Give "
      "geoid_height=47.5 (metres there) or geoid_grid=FILE.gtx; where all heights are above the ellipsoid, "
      "network.with.geoid_slope=0");
}

/// One height of the geoid is none of a site of kilometres.
void tell_of_slope(const GeoidChoice& geoid, NetworkModel& m) {
  constexpr double kSite = 1000;  // [m]
  if (!geoid.is_open()) return;
  double across = 0;
  for (const VectorGroup& g : m.survey.vectors)
    for (Eigen::Index k = 0; g.is_geocentric && k + 2 < g.values.size(); k += 3)
      across = std::max(across, g.values.segment<3>(k).norm());
  if (!(across > kSite)) return;
  m.findings.push_back({Finding::Severity::warning,
                        "one height of the geoid holds for vectors of " + fixed_digits(across / 1000, 1) +
                            " km: heights from GNSS vectors follow the ellipsoid, and by how much the geoid rises "
                            "along them nobody has said. That is an unknown here (geoid_slope), with a standard "
                            "deviation of " +
                            fixed_digits(1e3 * across * geoid.slope_sigma, 0) +
                            " mm along the longest, and theirs hold it; give geoid_grid=FILE.gtx",
                        {}});
}

}  // namespace

void take_map(NetworkModel& m, const AdjustOptions& options) {
  const auto& vectors = m.survey.vectors;
  const auto geocentric = [](const VectorGroup& g) { return g.is_geocentric; };
  const bool some = std::any_of(vectors.begin(), vectors.end(), geocentric);
  const std::string& own = m.survey.info.coordinate_system;
  const std::string system = options.map.empty() && own.starts_with("+proj=") ? own : options.map;
  const bool plane = system.empty() || system == kPlane;
  if (own.starts_with("+proj=") && !plane && system != own)
    throw NetworkError("E and N of the file are of the map " + own + ", not of another: leave out map=" + system);
  constexpr double kNothing = 1e-6;  // a millimetre in a kilometre, 9 km from the middle
  if (const double stretch = stretch_of_own_plane(m); plane && own.starts_with("+proj=") && stretch > kNothing)
    throw NetworkError("map=" + std::string(kPlane) +
                       " takes the map of the file's own as a plane, and its lengths are " +
                       fixed_digits(1e6 * stretch, 0) +
                       " ppm too long at the farthest point: leave map out, and they are reduced to it");
  if (plane && some)
    throw NetworkError(
        "the network has vectors in X, Y, Z of the earth: say which map its E and N are on, such as "
        "map=EPSG:25832, or leave them out");
  if (plane && (!options.geoid.grid.empty() || !options.geoid.deflection.isZero(0)))
    throw NetworkError(
        "a geoid grid or a deflection of the vertical is given and no map: say which one E and N are on, "
        "such as map=EPSG:25832");
  if (plane) return;
  m.mean_height = or_else(options.mean_height, mean_of_given_heights(m));
  if (!options.geoid.grid.empty() && (options.geoid.height != 0 || !options.geoid.deflection.isZero(0)))
    throw NetworkError("a geoid grid is given and constants of the geoid beside it: give one of the two");
  if (!std::all_of(vectors.begin(), vectors.end(), geocentric))
    throw NetworkError(
        "the network has vectors dE, dN, dH of a plane, which are not adjusted on a map: leave out map=" + system);
  try {
    m.map = std::make_shared<const MapFrame>(system, options.geoid, middle_of_given(m));
  } catch (const std::runtime_error& error) {
    throw NetworkError(std::string("map: ") + error.what());
  }
  refuse_other_datum(m, some, !options.geoid.grid.empty());
  if (some) require_geoid(system, options.geoid), tell_of_slope(options.geoid, m);
}

void find_map_corrections(NetworkModel& m) {
  m.corrections.clear();
  if (!m.map) return;
  if (!m.starts_from_known_points)
    throw NetworkError(
        "map: no point has coordinates, so that nothing says where on the map the network lies; give "
        "control points");
  m.mean_height = height_of_lengths(m);
  const auto place = [&](const std::string& id) -> const Eigen::Vector3d& { return m.initial[m.index.at(id)]; };
  const auto has_height = [&](const std::string& id) {
    const int point = m.index.at(id);
    return m.roles[point][2] != CoordinateRole::unused && !std::isnan(m.initial[point].z());
  };
  const auto at_height = [&](const std::string& id, const std::string& other) -> Eigen::Vector3d {
    const double height = has_height(id) ? place(id).z() : has_height(other) ? place(other).z() : m.mean_height;
    return {place(id).x(), place(id).y(), height};
  };
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const Observation& o = m.observations[i].observation;
    MapCorrection& c = m.corrections.emplace_back();
    // A levelled difference is one of heights above the geoid, an azimuth one of the map.
    if (m.dropped[i] || o.kind == ObservationKind::height_difference || o.kind == ObservationKind::azimuth) continue;
    const Eigen::Vector3d &from = place(o.from), &to = place(o.to);
    try {
      c.scale = m.map->scale(at_height(o.from, o.to), at_height(o.to, o.from));
      if (o.kind == ObservationKind::direction) c.direction = m.map->direction(from, to);
      if (o.kind == ObservationKind::angle)
        c.direction = m.map->direction(from, place(o.second_to)) - m.map->direction(from, to);
      if (o.kind == ObservationKind::zenith_angle) c.zenith = parting(sight_of(m, o, o.to, o.target_height), c.scale);
      if (m.map->has_deflection()) add_deflection(m, o, c);
    } catch (const std::runtime_error& error) {
      throw NetworkError("map " + m.map->name() + ": " + o.from + " at E " + fixed_digits(from.x(), 1) + ", N " +
                         fixed_digits(from.y(), 1) + ": " + error.what());
    }
  }
}

}  // namespace plumbline::survey
