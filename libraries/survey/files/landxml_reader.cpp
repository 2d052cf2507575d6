#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "survey/files/landxml.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/xml_file.hpp"

namespace plumbline::survey {
namespace {

using text::attribute;
using text::XmlFile;

struct DistanceConstants {
  double reflector_constant = kNotGiven;  // [m]
  double ppm = kNotGiven;
};

class LandXmlReader {
 public:
  LandXmlReader(std::string_view bytes, const std::string& file)
      : xml_(bytes, file, {"RawObservation", "CgPoint", "Point"}), builder_(file, "landxml") {}

  SurveyObservations read();

 private:
  void read_units();
  void read_hexagon(pugi::xml_node hexagon);
  std::set<std::string> given_to_the_instrument() const;
  void read_point(pugi::xml_node node, bool known);
  void read_points();
  void read_set_ups();
  void read_observation(pugi::xml_node node);
  void apply_constants(pugi::xml_node node, const std::string& set_up, Sighting& sighting) const;

  std::string target_of(pugi::xml_node node, pugi::xml_node target);
  std::string set_up_of(pugi::xml_node observation) const;
  std::string point_name(const std::string& reference) const;
  Eigen::Vector3d north_east_height(pugi::xml_node node);
  double length(pugi::xml_node node, const char* name);
  double angle(pugi::xml_node node, const char* name);
  void reject(pugi::xml_node node, const std::string& found, const std::string& expected) {
    const SourcePosition at = xml_.position(node);
    builder_.skip(at.line, at.column, found, expected);
  }

  XmlFile xml_;
  SurveyBuilder builder_;
  double metres_ = 1.0;
  std::string angular_unit_ = "decimal degrees";
  bool is_hexml_ = false, distances_are_corrected_ = true;
  std::map<std::string, std::string> names_;                                  // of CgPoint -> point id
  std::map<std::string, int> set_ups_;                                        // id in the file -> index
  std::map<std::pair<std::string, std::string>, DistanceConstants> hexagon_;  // set-up and target reference
  std::size_t deleted_ = 0, reduced_ = 0;
};

void LandXmlReader::read_units() {
  const pugi::xml_node units = text::child(xml_.root(), "Units");
  pugi::xml_node system = text::child(units, "Metric");
  if (!system) system = text::child(units, "Imperial");
  if (!system) {
    builder_.warn("the file names no units; metres and decimal degrees are assumed");
    return;
  }
  static const std::map<std::string, double> kLengths = {
      {"meter", 1.0},       {"metre", 1.0},        {"millimeter", 1e-3}, {"centimeter", 1e-2},
      {"decimeter", 0.1},   {"kilometer", 1000.0}, {"foot", kFoot},      {"ussurveyfoot", kUsSurveyFoot},
      {"inch", kFoot / 12}, {"mile", 5280 * kFoot}};
  const std::string linear = text::to_lower(attribute(system, "linearUnit"));
  if (const auto known = kLengths.find(linear); known != kLengths.end())
    metres_ = known->second;
  else if (!linear.empty())
    throw SurveyReadError(xml_.position(system), "the linear unit " + text::quoted(linear),
                          "meter, millimeter, foot or USSurveyFoot");
  const std::string angular = text::to_lower(attribute(system, "angularUnit"));
  if (!angular.empty()) angular_unit_ = angular;
  if (angular_unit_ != "grads" && angular_unit_ != "radians" && angular_unit_ != "decimal degrees" &&
      angular_unit_ != "decimal dd.mm.ss")
    throw SurveyReadError(xml_.position(system), "the angular unit " + text::quoted(angular_unit_),
                          "radians, grads, decimal degrees or decimal dd.mm.ss");
  builder_.survey.info.angles_in_degrees = angular_unit_.starts_with("decimal");
}

double LandXmlReader::length(pugi::xml_node node, const char* name) {
  const std::string text = attribute(node, name);
  if (text.empty()) return kNotGiven;
  const auto value = text::parse_number(text);
  if (value) return *value * metres_;
  reject(node, text, std::string("a number in attribute ") + name);
  return kNotGiven;
}

double LandXmlReader::angle(pugi::xml_node node, const char* name) {
  const std::string text = attribute(node, name);
  if (text.empty()) return kNotGiven;
  const auto value = text::parse_number(text);
  std::optional<double> angle;
  if (value && std::abs(*value) < 1e4) {
    if (angular_unit_ == "grads")
      angle = gon_to_rad(*value);
    else if (angular_unit_ == "radians")
      angle = *value;
    else if (angular_unit_ == "decimal degrees")
      angle = degrees_to_rad(*value);
    else
      angle = packed_degrees_to_rad(*value);
  }
  if (angle) return *angle;
  reject(node, text, std::string("an angle (") + angular_unit_ + ") in attribute " + name);
  return kNotGiven;
}

// Points are written "north east height", height optional.
Eigen::Vector3d LandXmlReader::north_east_height(pugi::xml_node node) {
  Eigen::Vector3d result = Eigen::Vector3d::Constant(kNotGiven);
  const std::string_view text = text::trim(node.child_value());
  if (text.empty()) return result;
  const auto parts = text::split_blanks(text);
  constexpr int axis_of[] = {1, 0, 2};
  if (parts.size() == 2 || parts.size() == 3) {
    bool good = true;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const auto value = text::parse_number(parts[i]);
      good = good && value;
      if (value) result[axis_of[i]] = *value * metres_;
    }
    if (good) return result;
  }
  reject(node, std::string(text), "coordinates as two or three numbers: north east height");
  return Eigen::Vector3d::Constant(kNotGiven);
}

// Hexagon's tree: constants of distances by set-up and target, coordinates of points.
void LandXmlReader::read_hexagon(pugi::xml_node hexagon) {
  builder_.survey.info.format = "hexml";
  is_hexml_ = true;
  const std::string application = attribute(text::child(xml_.root(), "Application"), "name");
  distances_are_corrected_ = application == "LandXML Export";
  std::map<std::string, double> ppm;
  for (pugi::xml_node correction : text::descendants(hexagon, {"TPSCorrection"}))
    if (const auto value = text::parse_number(attribute(correction, "atmosphericPPM")))
      ppm[attribute(correction, "uniqueID")] = *value;
  for (pugi::xml_node set_up : text::descendants(hexagon, {"InstrumentSetup"})) {
    for (pugi::xml_node observation : text::children(set_up, "RawObservation")) {
      DistanceConstants constants;
      if (const auto value = text::parse_number(attribute(observation, "reflectorConstant")))
        constants.reflector_constant = *value * metres_;
      if (const auto known = ppm.find(attribute(observation, "tpsCorrectionRef")); known != ppm.end())
        constants.ppm = known->second;
      hexagon_[{attribute(set_up, "uniqueID"), attribute(observation, "targetPntRef")}] = constants;
    }
  }
}

/// Leica's class of points that were given to the instrument, by the keys of their measurements.
std::set<std::string> LandXmlReader::given_to_the_instrument() const {
  std::set<std::string> keys;
  for (pugi::xml_node node : text::children(xml_.root(), "HexagonLandXML"))
    for (pugi::xml_node point : text::children(node, "Point"))
      if (text::to_lower(attribute(point, "class")) == "control") keys.insert(attribute(point, "uniqueID"));
  return keys;
}

void LandXmlReader::read_point(pugi::xml_node node, bool known) {
  const std::string name = attribute(node, "name"), original = attribute(node, "oID");
  // In HeXML `name` is a key that is unique for each measurement, oID what the surveyor called the point.
  const std::string id = is_hexml_ && !original.empty() ? original : name.empty() ? original : name;
  if (id.empty()) return reject(node, "a CgPoint", "its attribute name or oID");
  if (!name.empty()) names_[name] = id;
  const Eigen::Vector3d at = north_east_height(node);
  if (at.array().isNaN().all()) return;
  if (known)
    builder_.know_coordinates(id, at, xml_.position(node));
  else
    builder_.give_coordinates(id, at, xml_.position(node));
  Point& point = builder_.point(id, xml_.position(node));
  if (point.code.empty()) point.code = attribute(node, "code");
  if (point.description.empty()) point.description = attribute(node, "desc");
}

void LandXmlReader::read_points() {
  const std::set<std::string> given = given_to_the_instrument();
  const auto points = text::descendants(xml_.root(), {"CgPoint"});
  const auto is_known = [&](pugi::xml_node node) {
    return attribute(node, "pntSurv") == "control" || given.contains(attribute(node, "name"));
  };
  // What was measured of a known point bears its name as well.
  for (pugi::xml_node node : points)
    if (is_known(node)) read_point(node, true);
  for (pugi::xml_node node : points)
    if (!is_known(node)) read_point(node, false);
  for (pugi::xml_node node : text::children(xml_.root(), "HexagonLandXML")) {
    for (pugi::xml_node point : text::children(node, "Point")) {
      const std::string key = attribute(point, "uniqueID");
      const auto grids = text::descendants(point, {"Grid"});
      if (key.empty() || grids.empty()) continue;
      const Eigen::Vector3d at = {length(grids.front(), "e"), length(grids.front(), "n"),
                                  length(grids.front(), "hghthO")};
      if (at.array().isNaN().all()) continue;
      if (given.contains(key))
        builder_.know_coordinates(point_name(key), at, xml_.position(point));
      else
        builder_.give_coordinates(point_name(key), at, xml_.position(point));
    }
  }
}

std::string LandXmlReader::point_name(const std::string& reference) const {
  const auto known = names_.find(reference);
  return known == names_.end() ? reference : known->second;
}

void LandXmlReader::read_set_ups() {
  for (pugi::xml_node survey : text::children(xml_.root(), "Survey")) {
    for (pugi::xml_node node : text::descendants(survey, {"InstrumentSetup"})) {
      const std::string id = attribute(node, "id");
      if (attribute(node, "status") == "deleted") continue;
      const pugi::xml_node instrument = text::child(node, "InstrumentPoint");
      std::string station = attribute(node, "stationName");
      if (station.empty()) station = attribute(instrument, "name");
      if (station.empty()) station = point_name(attribute(instrument, "pntRef"));
      if (station.empty()) station = id;
      if (station.empty()) {
        reject(node, "an InstrumentSetup", "its attribute stationName or id");
        continue;
      }
      if (set_ups_.contains(id)) builder_.warn("two set-ups have the id " + text::quoted(id));
      const int index = builder_.start_set_up(station, length(node, "instrumentHeight"), xml_.position(node));
      if (!id.empty()) set_ups_.try_emplace(id, index);
      // To the backsight: its azimuth and the circle's reading. Programs write 0.0 for "none": only both say something.
      const double azimuth = angle(node, "orientationAzimuth"), reading = angle(node, "circleAzimuth");
      if (!std::isnan(azimuth) && !std::isnan(reading))
        builder_.survey.set_ups[index].stated_orientation = wrap_to_circle(azimuth - reading);
      const Eigen::Vector3d at = north_east_height(instrument);
      if (!at.array().isNaN().all()) builder_.give_coordinates(station, at, xml_.position(instrument));
    }
  }
}

std::string LandXmlReader::set_up_of(pugi::xml_node observation) const {
  std::string id = attribute(observation, "setupID");
  int levels = 8;  // more than any file nests its observations
  for (pugi::xml_node parent = observation.parent(); id.empty() && parent && --levels > 0; parent = parent.parent()) {
    const std::string_view name = text::local_name(parent);
    if (name == "ObservationGroup" || name == "Backsight") id = attribute(parent, "setupID");
    if (name == "InstrumentSetup") id = attribute(parent, "id");
  }
  return id;
}

std::string LandXmlReader::target_of(pugi::xml_node node, pugi::xml_node target) {
  std::string id = attribute(target, "name");
  if (id.empty()) id = point_name(attribute(target, "pntRef"));
  if (id.empty()) id = attribute(target, "desc");
  if (id.empty()) reject(node, "a RawObservation", "a TargetPoint with name, pntRef or desc");
  return id;
}

// (s - c)(1 + ppm 1e-6) + c: the ppm belong to the way in air, not to the constant of the reflector.
void LandXmlReader::apply_constants(pugi::xml_node node, const std::string& set_up, Sighting& sighting) const {
  if (!is_hexml_ || std::isnan(sighting.slope_distance)) return;
  const auto known = hexagon_.find({set_up, attribute(text::child(node, "TargetPoint"), "pntRef")});
  if (known == hexagon_.end()) return;
  const double c = std::isnan(known->second.reflector_constant) ? 0.0 : known->second.reflector_constant;
  const double ppm = std::isnan(known->second.ppm) ? 0.0 : known->second.ppm;
  const std::string constants =
      "ppm " + text::format_shortest(ppm) + ", prism constant " + text::format_fixed(c * 1e3, 1) + " mm";
  if (!distances_are_corrected_) sighting.slope_distance = (sighting.slope_distance - c) * (1 + ppm * 1e-6) + c;
  sighting.distance_corrections.push_back(distances_are_corrected_ ? "by the exporting program: " + constants
                                                                   : constants);
}

void LandXmlReader::read_observation(pugi::xml_node node) {
  if (attribute(node, "status") == "deleted") {
    ++deleted_;
    return;
  }
  const pugi::xml_node target = text::child(node, "TargetPoint");
  Sighting sighting;
  sighting.to = target_of(node, target);
  if (sighting.to.empty()) return;
  sighting.source = xml_.position(node);
  sighting.direction = angle(node, "horizAngle");
  sighting.zenith_angle = angle(node, "zenithAngle");
  sighting.slope_distance = length(node, "slopeDistance");
  sighting.horizontal_distance = length(node, "horizDistance");
  sighting.target_height = length(node, "targetHeight");
  if (sighting.slope_distance < 0 || sighting.horizontal_distance < 0)
    return reject(node, "a negative distance", "a distance that is not negative");
  const bool has_slope = sighting.slope_distance > 0 && !std::isnan(sighting.zenith_angle);
  if (has_slope) sighting.horizontal_distance = kNotGiven;  // computed from the other two
  if (attribute(node, "directFace") == "false") sighting.face = 2;
  const std::string set_up = set_up_of(node);
  apply_constants(node, set_up, sighting);
  if (metres_ != 1.0) sighting.distance_corrections.push_back("to metres by " + text::format_shortest(metres_));
  const auto known = set_ups_.find(set_up);
  if (known == set_ups_.end()) {
    builder_.warn("observations refer to the set-up " + text::quoted(set_up) + ", which the file does not describe");
    set_ups_[set_up] = set_up.empty() ? builder_.start_unnamed_set_up(kNotGiven, sighting.source)
                                      : builder_.start_set_up(set_up, kNotGiven, sighting.source);
  }
  builder_.select_set_up(set_ups_.at(set_up));
  if (!builder_.add(sighting))
    return reject(node, "a RawObservation", "at least one of horizAngle, zenithAngle, slopeDistance, horizDistance");
  const Eigen::Vector3d at = north_east_height(target);
  if (!at.array().isNaN().all()) builder_.give_coordinates(sighting.to, at, xml_.position(target));
}

SurveyObservations LandXmlReader::read() {
  if (text::local_name(xml_.root()) != "LandXML")
    throw SurveyReadError(xml_.position(xml_.root()), "the root element " + text::quoted(xml_.root().name()),
                          "LandXML, or " + understood_formats());
  read_units();
  for (pugi::xml_node hexagon : text::children(xml_.root(), "HexagonLandXML")) read_hexagon(hexagon);
  NetworkInfo& info = builder_.survey.info;
  info.title = attribute(text::child(xml_.root(), "Project"), "name");
  info.program = attribute(text::child(xml_.root(), "Application"), "name");
  info.date = attribute(xml_.root(), "date");
  for (pugi::xml_node details : text::descendants(xml_.root(), {"InstrumentDetails"})) {
    info.instrument = attribute(details, "model");
    info.instrument_serial = attribute(details, "serialNumber");
  }
  read_points();
  read_set_ups();
  for (pugi::xml_node survey : text::children(xml_.root(), "Survey")) {
    reduced_ += text::descendants(survey, {"ReducedObservation"}).size();
    for (pugi::xml_node node : text::descendants(survey, {"RawObservation"})) read_observation(node);
  }
  if (deleted_ > 0) builder_.warn(std::to_string(deleted_) + " observations with status 'deleted' were left out");
  if (reduced_ > 0) builder_.warn(std::to_string(reduced_) + " reduced observations were not read, only raw ones are");
  if (xml_.damage()) builder_.survey.skipped.push_back(*xml_.damage());
  return builder_.finish("LandXML without survey points or observations",
                         "CgPoint coordinates or RawObservation elements under Survey");
}

}  // namespace

SurveyObservations read_landxml(std::string_view bytes, const std::string& file) {
  return LandXmlReader(bytes, file).read();
}

}  // namespace plumbline::survey
