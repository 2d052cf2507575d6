#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "survey/files/jobxml.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/xml_file.hpp"

namespace plumbline::survey {
namespace {

using text::attribute;
using text::child_text;

constexpr double kLargestPrismConstant = 0.5;  // [m]

/// Points that were typed in or taken over from another file or job. The schema (5.3) has the words in SurveyMethod
/// beside Method "Coordinates"; other programs write them as the Method itself.
bool is_keyed_in(pugi::xml_node record) {
  const std::string method = child_text(record, "Method"), how = child_text(record, "SurveyMethod");
  if (method == "KeyedIn") return true;
  return (method == "Coordinates" || method == "CopiedPoint") && (how == "KeyedIn" || how == "Copied");
}

/// Of its class in the job: its coordinates go before others of its name.
bool is_control(pugi::xml_node record) {
  return child_text(record, "Classification") == "Control" && is_keyed_in(record) && !text::child(record, "Circle");
}

/// Methods whose Circle is no reading but what was computed from several. Where those are in the file they are read.
bool is_mean(const std::string& method) {
  return method.starts_with("MeanTurnedAngle") || method.starts_with("MatchedPair");
}

/// Methods whose Circle was computed from the reading and something that was entered or measured beside it.
bool is_offset(const std::string& method) {
  static constexpr std::array offsets = {"AngleOffset",    "HorizontalAngleOffset", "VerticalAngleOffset",
                                         "DistanceOffset", "DualPrismOffset",       "CircularObject",
                                         "RemoteObject"};
  return std::find(offsets.begin(), offsets.end(), method) != offsets.end();
}

class JobXmlReader {
 public:
  JobXmlReader(std::string_view bytes, const std::string& file)
      : xml_(bytes, file,
             {"PointRecord", "StationRecord", "TargetRecord", "AtmosphereRecord", "BackBearingRecord", "Point"}),
        builder_(file, "jobxml") {}

  SurveyObservations read();

 private:
  struct Target {
    double height = kNotGiven, prism_constant = kNotGiven;
  };

  void index(pugi::xml_node record);
  void read_record(pugi::xml_node record);
  void tell_what_was_left_out();
  void read_station(pugi::xml_node record);
  void read_target(pugi::xml_node record);
  void read_back_bearing(pugi::xml_node record);
  void read_point(pugi::xml_node record);
  void read_mean(pugi::xml_node record, const std::string& name);
  void index_pointing(pugi::xml_node record);
  void read_circle(pugi::xml_node record, pugi::xml_node circle, const std::string& name);
  void read_coordinates(const std::string& name, pugi::xml_node grid, bool known = false);
  void correct_distance(pugi::xml_node record, Sighting& sighting);
  double number(pugi::xml_node parent, const char* name);
  double degrees(pugi::xml_node parent, const char* name);
  void reject(pugi::xml_node node, const std::string& found, const std::string& expected) {
    const SourcePosition at = xml_.position(node);
    builder_.skip(at.line, at.column, found, expected);
  }

  text::XmlFile xml_;
  SurveyBuilder builder_;
  std::map<std::string, pugi::xml_node> station_records_, control_records_;  // by ID, by name
  using Pointing = std::pair<std::string, std::string>;                      // station ID and point
  std::set<Pointing> sighted_;                                               // singly
  std::map<Pointing, pugi::xml_node> best_means_;                            // of those that were not
  std::map<std::string, int> stations_;                                      // ID -> set-up
  std::map<std::string, double> atmospheres_;                                // ID -> ppm
  std::map<std::string, std::string> air_of_station_;                        // station ID -> atmosphere ID
  std::map<std::string, Target> targets_;
  std::string last_station_, last_atmosphere_;
  std::size_t deleted_ = 0, means_ = 0, means_alone_ = 0, means_besides_ = 0, means_without_reading_ = 0, offsets_ = 0,
              levelled_ = 0, gnss_ = 0;
};

double JobXmlReader::number(pugi::xml_node parent, const char* name) {
  const std::string text = child_text(parent, name);
  if (text.empty()) return kNotGiven;
  if (const auto value = text::parse_number(text)) return *value;
  if (text != "?") reject(text::child(parent, name), text, std::string("a number in ") + name);
  return kNotGiven;
}

double JobXmlReader::degrees(pugi::xml_node parent, const char* name) {
  const double value = number(parent, name);
  if (std::isnan(value) || std::abs(value) <= 720) return degrees_to_rad(value);
  reject(text::child(parent, name), child_text(parent, name), "an angle in decimal degrees");
  return kNotGiven;
}

void JobXmlReader::read_station(pugi::xml_node record) {
  const std::string name = child_text(record, "StationName"), id = attribute(record, "ID");
  if (child_text(record, "Deleted") == "true") return;
  if (name.empty()) return reject(record, "a StationRecord", "its StationName");
  if (!id.empty() && stations_.contains(id)) return;  // a sighting in front of it asked for it
  stations_[id] = builder_.start_set_up(name, number(record, "TheodoliteHeight"), xml_.position(record));
  last_station_ = id;
  const std::string air = child_text(record, "AtmosphereID");
  air_of_station_[id] = air.empty() ? last_atmosphere_ : air;
  const double scale = number(record, "ScaleFactor");
  if (!std::isnan(scale) && scale != 1.0)
    builder_.warn("station " + text::quoted(name) + " has the scale factor " + text::format_shortest(scale) +
                  ", which is not applied to distances");
}

void JobXmlReader::read_target(pugi::xml_node record) {
  Target& target = targets_[attribute(record, "ID")];
  target.height = number(record, "TargetHeight");
  target.prism_constant = number(record, "PrismConstant");
  // Millimetres where the format has metres would be taken off each distance.
  if (!(std::abs(target.prism_constant) > kLargestPrismConstant)) return;
  reject(text::child(record, "PrismConstant"), child_text(record, "PrismConstant"),
         "a prism constant in metres, of at most " + text::format_shortest(kLargestPrismConstant) + " m");
  target.prism_constant = kNotGiven;
}

// What is added to the circle's readings to make them azimuths.
void JobXmlReader::read_back_bearing(pugi::xml_node record) {
  auto station = stations_.find(child_text(record, "StationRecordID"));
  const double correction = degrees(record, "OrientationCorrection");
  if (station == stations_.end()) station = stations_.find(last_station_);
  if (station != stations_.end() && !std::isnan(correction))
    builder_.survey.set_ups[station->second].stated_orientation = wrap_to_circle(correction);
}

void JobXmlReader::read_coordinates(const std::string& name, pugi::xml_node grid, bool known) {
  if (!grid) return;
  const Eigen::Vector3d at = {number(grid, "East"), number(grid, "North"), number(grid, "Elevation")};
  if (!at.array().isNaN().all()) builder_.give_coordinates(name, at, xml_.position(grid));
  if (known) builder_.know_coordinates(name, at, xml_.position(grid));
}

// The job stores what the distance meter gave before any correction.
void JobXmlReader::correct_distance(pugi::xml_node record, Sighting& sighting) {
  const auto target = targets_.find(child_text(record, "TargetID"));
  const auto air = air_of_station_.find(child_text(record, "StationID"));
  const auto found = atmospheres_.find(air == air_of_station_.end() ? last_atmosphere_ : air->second);
  if (found != atmospheres_.end() && !std::isnan(found->second)) {
    sighting.slope_distance *= 1 + found->second * 1e-6;
    sighting.distance_corrections.push_back("ppm " + text::format_shortest(found->second));
  }
  if (target != targets_.end() && !std::isnan(target->second.prism_constant)) {
    sighting.slope_distance += target->second.prism_constant;
    sighting.distance_corrections.push_back("prism constant " +
                                            text::format_fixed(target->second.prism_constant * 1e3, 1) + " mm");
  }
}

void JobXmlReader::read_circle(pugi::xml_node record, pugi::xml_node circle, const std::string& name) {
  Sighting sighting;
  sighting.to = name;
  sighting.source = xml_.position(record);
  sighting.direction = degrees(circle, "HorizontalCircle");
  sighting.zenith_angle = degrees(circle, "VerticalCircle");
  sighting.slope_distance = number(circle, "EDMDistance");
  const std::string face = child_text(circle, "Face");
  sighting.face = face == "Face1" ? 1 : face == "Face2" ? 2 : 0;
  if (sighting.slope_distance < 0 || sighting.slope_distance > 1e5) {
    reject(text::child(circle, "EDMDistance"), child_text(circle, "EDMDistance"), "a distance between 0 and 100 km");
    sighting.slope_distance = kNotGiven;
  }
  if (sighting.slope_distance > 0) correct_distance(record, sighting);
  if (const auto target = targets_.find(child_text(record, "TargetID")); target != targets_.end())
    sighting.target_height = target->second.height;
  std::string station = child_text(record, "StationID");
  if (station.empty()) station = last_station_;
  if (const auto behind = station_records_.find(station);
      !stations_.contains(station) && behind != station_records_.end())
    read_station(behind->second);
  if (!stations_.contains(station)) {
    builder_.warn("observations refer to the station record " + text::quoted(station) + ", which is not in the file");
    stations_[station] = builder_.start_unnamed_set_up(kNotGiven, sighting.source);
  }
  builder_.select_set_up(stations_.at(station));
  if (!builder_.add(sighting)) reject(record, "a Circle without values", "circle readings in decimal degrees");
}

/// A job may have been exported with its means alone: then these are what there is.
void JobXmlReader::read_mean(pugi::xml_node record, const std::string& name) {
  const Pointing pointing{child_text(record, "StationID"), name};
  const auto best = best_means_.find(pointing);
  if (sighted_.contains(pointing)) {
    ++means_;
  } else if (best == best_means_.end()) {
    ++means_without_reading_;
  } else if (best->second == record) {
    ++means_alone_;
    read_circle(record, text::child(record, "Circle"), name);
  } else {
    ++means_besides_;
  }
}

/// What was sighted singly, and of the rest the mean of all sets rather than that of two faces, the last of several.
void JobXmlReader::index_pointing(pugi::xml_node record) {
  if (!text::child(record, "Circle") || child_text(record, "Deleted") == "true") return;
  const std::string method = child_text(record, "Method");
  const Pointing pointing{child_text(record, "StationID"), child_text(record, "Name")};
  if (!is_mean(method)) {
    sighted_.insert(pointing);
    return;
  }
  pugi::xml_node& best = best_means_[pointing];
  const auto of_all = [](const std::string& m) { return m.starts_with("MeanTurnedAngle"); };
  if (!best || of_all(method) || !of_all(child_text(best, "Method"))) best = record;
}

void JobXmlReader::read_point(pugi::xml_node record) {
  const std::string name = child_text(record, "Name");
  if (child_text(record, "Deleted") == "true") {
    ++deleted_;
    return;
  }
  if (name.empty()) return reject(record, "a PointRecord", "its Name");
  const std::string method = child_text(record, "Method");
  if (is_mean(method)) return read_mean(record, name);
  levelled_ += method.ends_with("LevelObservation"), gnss_ += method.starts_with("Gps");
  const pugi::xml_node circle = text::child(record, "Circle");
  if (circle) {
    offsets_ += is_offset(method);
    read_circle(record, circle, name);
  } else {
    const auto control = control_records_.find(name);
    if (control != control_records_.end() && control->second != record)
      read_coordinates(name, text::child(control->second, "Grid"), true);
    read_coordinates(name, text::child(record, "Grid"), is_keyed_in(record));
  }
  const std::string code = child_text(record, "Code");
  if (!code.empty()) builder_.point(name, xml_.position(record)).code = code;
}

/// What others refer to may stand behind them.
void JobXmlReader::index(pugi::xml_node record) {
  const std::string_view kind = text::local_name(record);
  if (kind == "TargetRecord") return read_target(record);
  if (kind == "StationRecord") station_records_.emplace(attribute(record, "ID"), record);
  if (kind == "PointRecord") index_pointing(record);
  if (kind == "PointRecord" && is_control(record)) control_records_.emplace(child_text(record, "Name"), record);
}

void JobXmlReader::tell_what_was_left_out() {
  const auto tell = [&](std::size_t count, const std::string& what) {
    if (count > 0) builder_.warn(std::to_string(count) + " " + what);
  };
  tell(deleted_, "deleted point records were left out");
  tell(means_, "mean turned angles were left out; the single sightings are read");
  tell(
      means_alone_,
      "mean turned angles are of points that were not sighted singly in this file: they are taken as one reading each, "
      "though of how many sets they are is not said");
  tell(means_besides_, "further means of the same were left out");
  tell(means_without_reading_,
       "mean turned angles are of points that were not sighted singly in this file, and have no Circle to read: these "
       "sightings are lost");
  tell(offsets_,
       "sightings were computed from an offset that was measured or entered (AngleOffset, DistanceOffset, "
       "DualPrismOffset, CircularObject, RemoteObject); they are taken as read");
  tell(levelled_, "levelling records (LevelObservation) are not read");
  tell(gnss_, "GNSS records (Method Gps...) are not read; their points have the coordinates of the file alone");
}

void JobXmlReader::read_record(pugi::xml_node record) {
  const std::string_view kind = text::local_name(record);
  NetworkInfo& info = builder_.survey.info;
  if (kind == "StationRecord") return read_station(record);
  if (kind == "BackBearingRecord") return read_back_bearing(record);
  if (kind == "PointRecord") return read_point(record);
  if (kind == "AtmosphereRecord") {
    last_atmosphere_ = attribute(record, "ID");
    // "false": the distances have the correction already.
    atmospheres_[last_atmosphere_] =
        child_text(record, "ApplyPPMToRawDistances") == "false" ? kNotGiven : number(record, "PPM");
  } else if (kind == "InstrumentRecord") {
    builder_.use_instrument(child_text(record, "Model"));
    if (info.instrument_serial.empty()) info.instrument_serial = child_text(record, "Serial");
  }
}

SurveyObservations JobXmlReader::read() {
  if (text::local_name(xml_.root()) != "JOBFile")
    throw SurveyReadError(xml_.position(xml_.root()), "the root element " + text::quoted(xml_.root().name()),
                          "JOBFile, or " + understood_formats());
  builder_.survey.info.title = attribute(xml_.root(), "jobName");
  builder_.survey.info.program = attribute(xml_.root(), "product");
  builder_.survey.info.date = attribute(xml_.root(), "TimeStamp");
  builder_.survey.info.angles_in_degrees = true;
  const pugi::xml_node field_book = text::child(xml_.root(), "FieldBook");
  for (pugi::xml_node record : field_book.children())
    if (record.type() == pugi::node_element) index(record);
  for (pugi::xml_node record : field_book.children())
    if (record.type() == pugi::node_element) read_record(record);
  // Of the controller, and of the office program that hands out points to set out.
  for (const char* part : {"Reductions", "InventoryData"})
    for (pugi::xml_node point : text::children(text::child(xml_.root(), part), "Point"))
      if (const std::string name = child_text(point, "Name"); !name.empty())
        read_coordinates(name, text::child(point, "Grid"));
  tell_what_was_left_out();
  if (xml_.damage()) builder_.survey.skipped.push_back(*xml_.damage());
  return builder_.finish("JobXML without observations or coordinates", "PointRecord elements with Circle or Grid");
}

}  // namespace

SurveyObservations read_jobxml(std::string_view bytes, const std::string& file) {
  return JobXmlReader(bytes, file).read();
}

}  // namespace plumbline::survey
