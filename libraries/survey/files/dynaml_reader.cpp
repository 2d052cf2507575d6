#include "survey/files/dynaml_reader.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include "survey/files/dynaml.hpp"

namespace plumbline::survey {
namespace {

using text::child_text;
using enum ObservationKind;

constexpr double kSecondOfArc = std::numbers::pi / 180 / 3600;
constexpr const char* kRead =
    "S, C, V, Z, A, D, L, H, G, X or Y: slope and chord distances, zenith and vertical angles, "
    "horizontal angles, direction sets, level differences, heights, GNSS baselines and their clusters, point clusters";

}  // namespace

std::optional<double> DynaMlReader::number(pugi::xml_node parent, const char* name, const char* expected) {
  const std::string text = child_text(parent, name);
  if (const auto value = text::parse_number(text)) return value;
  const pugi::xml_node node = text::child(parent, name);
  reject(node ? node : parent, text.empty() ? std::string("no ") + name : text, expected);
  return std::nullopt;
}

std::optional<double> DynaMlReader::angle(pugi::xml_node parent, const char* name) {
  const auto packed = number(parent, name, "an angle as D.MMSSs");
  if (!packed) return std::nullopt;
  const auto value = std::abs(*packed) <= 720 ? packed_degrees_to_rad(std::abs(*packed)) : std::nullopt;
  if (value) return std::copysign(*value, *packed);
  reject(text::child(parent, name), child_text(parent, name), "an angle as D.MMSSs");
  return std::nullopt;
}

std::optional<double> DynaMlReader::sigma(pugi::xml_node parent, bool angular) {
  const char* expected =
      angular ? "a standard deviation in seconds above zero" : "a standard deviation in m above zero";
  const auto value = number(parent, "StdDev", expected);
  if (!value) return std::nullopt;
  if (*value > 0) return angular ? *value * kSecondOfArc : *value;
  reject(text::child(parent, "StdDev"), child_text(parent, "StdDev"), expected);
  return std::nullopt;
}

std::optional<Geodetic> DynaMlReader::place_of(pugi::xml_node coordinates, const std::string& type) {
  if (type == "LLH" || type == "LLh") {
    const auto latitude = angle(coordinates, "XAxis"), longitude = angle(coordinates, "YAxis");
    const auto height = number(coordinates, "Height", "a height in m");
    if (!latitude || !longitude || !height) return std::nullopt;
    if (std::abs(*latitude) < 1.5) return Geodetic{*latitude, *longitude, *height};
    reject(coordinates, child_text(coordinates, "XAxis"), "a latitude below 86 degrees");
    return std::nullopt;
  }
  const auto x = number(coordinates, "XAxis", "a coordinate in m"),
             y = number(coordinates, "YAxis", "a coordinate in m");
  const auto z = number(coordinates, "Height", "a coordinate in m");
  if (!x || !y || !z) return std::nullopt;
  if (type == "XYZ") {
    const Eigen::Vector3d p(*x, *y, *z);
    const Geodetic place = from_geocentric(p);
    if (std::abs(p.norm() - 6.37e6) < 5e4 && std::abs(place.latitude) < 1.5) return place;
    reject(coordinates, "geocentric coordinates " + text::format_fixed(p.norm() / 1000, 0) + " km from the centre",
           "a place on the earth, below a latitude of 86 degrees");
    return std::nullopt;
  }
  if (type != "UTM") {
    reject(coordinates, "coordinates of the type " + text::quoted(type), "LLH, XYZ or UTM");
    return std::nullopt;
  }
  // Without a letter a zone is a southern one: the format is Australian.
  std::string text = child_text(coordinates, "HemisphereZone");
  const bool northern = text.find_first_of("Nn") != std::string::npos;
  std::erase_if(text, [](char c) { return c == 'N' || c == 'n' || c == 'S' || c == 's' || c == ' '; });
  const auto zone = text::parse_number(text);
  if (!zone || *zone < 1 || *zone > 60 || *zone != std::floor(*zone) || std::abs(*x - 5e5) > 5e5 || *y < 0 ||
      *y > 1e7) {
    reject(coordinates,
           "UTM coordinates " + child_text(coordinates, "XAxis") + ", " + child_text(coordinates, "YAxis") +
               " of zone " + text::quoted(child_text(coordinates, "HemisphereZone")),
           "easting, northing and a zone from 1 to 60");
    return std::nullopt;
  }
  Geodetic place = from_utm(*x, *y, static_cast<int>(*zone), !northern);
  place.height = *z;
  return place;
}

void DynaMlReader::read_station(pugi::xml_node node) {
  const std::string name = child_text(node, "Name"), type = child_text(node, "Type");
  if (name.empty()) return reject(node, "a DnaStation", "its Name");
  const auto place = place_of(text::child(node, "StationCoord"), type);
  if (place) stations_.push_back({name, child_text(node, "Constraints"), *place, node});
}

/// Two letters for the plan and one for the height: C constrained, F free.
void DynaMlReader::hold(const Station& station) {
  const std::string& c = station.constraints;
  if (c.size() != 3 || c.find_first_not_of("CF") != std::string::npos || c[0] != c[1])
    return reject(station.node, "the constraints " + text::quoted(c),
                  "three of C and F, the same for both coordinates in plan");
  auto& roles = builder_.point(station.name, xml_.position(station.node)).roles;
  if (c[0] == 'C') roles[0] = roles[1] = CoordinateRole::fixed;
  if (c[2] == 'C') roles[2] = CoordinateRole::fixed;
}

void DynaMlReader::place_stations() {
  if (stations_.empty()) return;
  const std::string frame = text::attribute(xml_.root(), "referenceframe");
  for (const char* older : {"AGD", "ED50", "NAD27", "Clarke"})
    if (frame.starts_with(older))
      throw SurveyReadError(xml_.position(xml_.root()), "the reference frame " + text::quoted(frame),
                            "one on GRS80, such as GDA94, GDA2020 or ITRF: transform the stations first");
  Geodetic mean;
  const auto n = static_cast<double>(stations_.size());
  for (const Station& s : stations_) {
    // Beside the first one, so that the meridian at 180 degrees does no harm.
    mean.longitude += std::remainder(s.place.longitude - stations_[0].place.longitude, 2 * std::numbers::pi) / n;
    mean.latitude += s.place.latitude / n, mean.height += s.place.height / n;
  }
  mean.longitude += stations_[0].place.longitude;
  const GroundPlane& plane = plane_.emplace(mean);
  for (const Station& s : stations_) {
    Geodetic beside = s.place;
    beside.longitude = mean.longitude + std::remainder(s.place.longitude - mean.longitude, 2 * std::numbers::pi);
    const Eigen::Vector2d p = plane(beside);
    if (!(p.norm() < kFarthestStation))
      throw SurveyReadError(xml_.position(s.node),
                            "station " + text::quoted(s.name) + " " + text::format_fixed(p.norm() / 1000, 0) +
                                " km from the middle of the stations",
                            "a network within 500 km; DynAdjust is for larger ones");
    builder_.give_coordinates(s.name, {p.x(), p.y(), s.place.height}, xml_.position(s.node));
    hold(s);
  }
  builder_.survey.info.coordinate_system = plane.as_map();
  const auto degrees = [](double rad) { return text::format_fixed(rad * 180 / std::numbers::pi, 6); };
  builder_.warn("E and N are of a plane about latitude " + degrees(mean.latitude) + ", longitude " +
                degrees(mean.longitude) + " degrees with true lengths at the height " +
                text::format_fixed(mean.height, 1) +
                " m (a map of the network's own, to which lengths are reduced); heights are as given, above the "
                "ellipsoid where X, Y, Z are");
}

void DynaMlReader::read_single(pugi::xml_node node, ObservationKind kind, bool vertical_angle) {
  const bool angular = kind == zenith_angle || kind == ObservationKind::angle;
  Observation o;
  o.kind = kind;
  o.from = child_text(node, "First"), o.to = child_text(node, "Second");
  if (kind == ObservationKind::angle) o.second_to = child_text(node, "Third");
  o.source = xml_.position(node);
  if (o.from.empty() || o.to.empty() || (kind == ObservationKind::angle && o.second_to.empty()))
    return reject(node, "a measurement without First, Second or Third", "the names of its stations");
  const auto value = angular ? angle(node, "Value") : number(node, "Value", "a length in m");
  const auto s = value ? sigma(node, angular) : std::nullopt;
  if (!s) return;
  o.value = vertical_angle ? std::numbers::pi / 2 - *value : *value, o.sigma = *s;
  if (kind == slope_distance && o.value <= 0)
    return reject(text::child(node, "Value"), child_text(node, "Value"), "a distance above zero");
  if (kind == zenith_angle && (o.value <= 0 || o.value >= std::numbers::pi))
    return reject(text::child(node, "Value"), child_text(node, "Value"), "a zenith angle from 0 to 180 degrees");
  const bool from_mark_to_mark = child_text(node, "Type") == "C" || kind == height_difference;
  for (const auto& [name, height] : {std::pair{"InstHeight", &o.instrument_height}, {"TargHeight", &o.target_height}}) {
    if (from_mark_to_mark || child_text(node, name).empty()) continue;
    const auto given = number(node, name, "a height in m");
    if (!given) return;
    *height = *given;
  }
  builder_.point(o.from, o.source);
  builder_.point(o.to, o.source);
  if (!o.second_to.empty()) builder_.point(o.second_to, o.source);
  builder_.add(o);
}

void DynaMlReader::read_direction(pugi::xml_node node, const std::string& from, const std::string& to, int set_up) {
  if (is_ignored(node)) {
    ++ignored_;
    return;
  }
  const auto value = angle(node, "Value");
  const auto s = value ? sigma(node, true) : std::nullopt;
  if (!s) return;
  if (to.empty()) return reject(node, "a direction", "the name of its target");
  Observation o;
  o.kind = direction, o.set_up = set_up, o.from = from, o.to = to, o.value = wrap_to_circle(*value), o.sigma = *s;
  o.pointing = pointings_++, o.source = xml_.position(node);
  builder_.point(from, o.source);
  builder_.point(to, o.source);
  builder_.add(o);
}

/// First is the station, Second the target of the first direction; the others follow, each an element of its own.
void DynaMlReader::read_directions(pugi::xml_node node) {
  const std::string from = child_text(node, "First");
  if (from.empty()) return reject(node, "a direction set without First", "the name of its station");
  const int set_up = builder_.start_set_up(from, kNotGiven, xml_.position(node));
  read_direction(node, from, child_text(node, "Second"), set_up);
  for (const pugi::xml_node one : text::children(node, "Directions"))
    read_direction(one, from, child_text(one, "Target"), set_up);
}

void DynaMlReader::read_height(pugi::xml_node node) {
  const std::string id = child_text(node, "First");
  if (id.empty()) return reject(node, "a height without First", "the name of its station");
  const auto value = number(node, "Value", "a height in m");
  const auto s = value ? sigma(node, false) : std::nullopt;
  if (!s) return;
  builder_.point(id, xml_.position(node));
  CoordinateGroup group;
  group.components.push_back({id, 2});
  group.values = Eigen::VectorXd::Constant(1, *value);
  group.covariance = Eigen::MatrixXd::Constant(1, 1, *s * *s);
  group.source = xml_.position(node);
  builder_.survey.coordinates.push_back(group);
}

void DynaMlReader::read_measurement(pugi::xml_node node) {
  const std::string type = child_text(node, "Type");
  if (is_ignored(node)) {
    ++ignored_;
  } else if (type == "S" || type == "C") {
    read_single(node, slope_distance, false);
  } else if (type == "V" || type == "Z") {
    read_single(node, zenith_angle, type == "Z");
  } else if (type == "A") {
    read_single(node, ObservationKind::angle, false);
  } else if (type == "L") {
    read_single(node, height_difference, false);
  } else if (type == "D") {
    read_directions(node);
  } else if (type == "H") {
    read_height(node);
  } else if (type == "G" || type == "X") {
    read_baselines(node, type);
  } else if (type == "Y") {
    read_points(node);
  } else {
    reject(node, name_of_dynaml_type(type), kRead);
  }
}

SurveyObservations DynaMlReader::read() {
  if (text::local_name(xml_.root()) != "DnaXmlFormat")
    throw SurveyReadError(xml_.position(xml_.root()), "the root element " + text::quoted(xml_.root().name()),
                          "DnaXmlFormat, or " + understood_formats());
  builder_.survey.info.angles_in_degrees = true;
  for (const pugi::xml_node node : text::children(xml_.root(), "DnaStation")) read_station(node);
  place_stations();
  for (const pugi::xml_node node : text::children(xml_.root(), "DnaMeasurement")) read_measurement(node);
  if (ignored_ > 0)
    builder_.warn(std::to_string(ignored_) + " measurements that the file says to ignore were left out");
  if (has_point_clusters_)
    builder_.warn(
        "heights of point clusters (Y) are above the ellipsoid: the height of a geoid given beside them would be "
        "wrong");
  if (xml_.damage()) builder_.survey.skipped.push_back(*xml_.damage());
  return builder_.finish("DynaML without a station or measurement that is read",
                         std::string("DnaStation, or ") + kRead);
}

SurveyObservations read_dynaml(std::string_view bytes, const std::string& file) {
  return DynaMlReader(bytes, file).read();
}

}  // namespace plumbline::survey
