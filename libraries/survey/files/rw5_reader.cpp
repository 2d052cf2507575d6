#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "base/text/text.hpp"
#include "survey/files/rw5.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

constexpr double kPi = std::numbers::pi;

struct Field {
  std::string_view value;
  int column = 0;
};

struct Record {
  std::string_view type;
  std::map<std::string_view, Field> fields;
  std::string_view note;
  Field stray;  ///< first part that is no field: a decimal comma, a name with one
};

// "SS,OP1,FP2,AR0.0044,N 5000.0,--note": the head of N and E is the letter and a blank.
Record parse(std::string_view line) {
  Record record;
  const std::size_t note = line.find("--");
  if (note != std::string_view::npos) {
    record.note = text::trim(line.substr(note + 2));
    line = line.substr(0, note);
  }
  bool first = true;
  for (const std::string_view raw : text::split(line, ',')) {
    const std::string_view part = text::trim(raw);
    if (first) record.type = part;
    const bool one_letter = part.size() > 1 && part[1] == ' ';
    const int column = static_cast<int>(part.data() - line.data()) + 1;
    const bool is_field = part.find_first_of("0123456789.+-") != 0;
    if (!first && !is_field && record.stray.column == 0) record.stray = {part, column};
    if (!first && part.size() >= 2)
      record.fields[part.substr(0, one_letter ? 1 : 2)] = {text::trim(part.substr(one_letter ? 1 : 2)), column};
    first = false;
  }
  return record;
}

class Rw5Reader {
 public:
  Rw5Reader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "rw5") {}
  SurveyObservations read();

 private:
  void read_record(const Record& record);
  void read_modes(const Record& record);
  void read_heights(const Record& record);
  void read_sighting(const Record& record);
  void read_point(const Record& record, const char* name_field);
  void begin_set_up(const std::string& station);
  void tell_missing_height(const std::string& station);
  void read_backsight(const Record& record);
  double direction(const Record& record);
  double zenith_angle(const Record& record);
  bool refuse_negative_zenith_angle(const Record& record);

  std::string text(const Record& record, const char* head) const {
    const auto found = record.fields.find(head);
    return found == record.fields.end() ? std::string() : std::string(found->second.value);
  }
  double length(const Record& record, const char* head);
  double angle(const Record& record, const char* head);
  double bearing(const Record& record);
  void reject(const Field& field, const std::string& expected) {
    builder_.skip(line_, field.column, field.value, expected);
  }

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  int line_ = 0;
  double metres_ = kFoot;  // what MO's UN says; without MO the format's default is feet
  bool gon_ = false, has_modes_ = false, absolute_ = false;
  double azimuth_origin_ = 0;  // AD1: azimuths count from the south
  double instrument_height_ = kNotGiven, rod_height_ = kNotGiven;
  bool height_is_new_ = false;            // given since the last sighting
  std::string station_of_last_sighting_;  // heights hold on as long as the instrument stands
  std::size_t observations_at_start_ = 0, records_ = 0;
  std::map<std::string, int> unread_;  // record types -> how many
};

double Rw5Reader::length(const Record& record, const char* head) {
  const auto found = record.fields.find(head);
  if (found == record.fields.end() || found->second.value.empty()) return kNotGiven;
  if (const auto value = text::parse_number(found->second.value)) return *value * metres_;
  reject(found->second, std::string("a number behind ") + head);
  return kNotGiven;
}

double Rw5Reader::angle(const Record& record, const char* head) {
  const auto found = record.fields.find(head);
  if (found == record.fields.end() || found->second.value.empty()) return kNotGiven;
  const auto value = text::parse_number(found->second.value);
  const auto in_rad = !value || std::abs(*value) > 1000 ? std::nullopt
                      : gon_                            ? std::optional<double>(gon_to_rad(*value))
                                                        : packed_degrees_to_rad(*value);
  if (in_rad) return *in_rad;
  reject(found->second, std::string(gon_ ? "an angle in gon" : "an angle D.MMSS") + " behind " + head);
  return kNotGiven;
}

// N45.3015E: from north or south towards east or west.
double Rw5Reader::bearing(const Record& record) {
  const Field& field = record.fields.at("BR");
  const std::string_view text = field.value;
  if (text.size() >= 3) {
    const char from = text.front(), towards = text.back();
    const auto value = text::parse_number(text.substr(1, text.size() - 2));
    const auto size = !value ? std::nullopt
                      : gon_ ? std::optional<double>(gon_to_rad(*value))
                             : packed_degrees_to_rad(*value);
    if (size && (from == 'N' || from == 'S') && (towards == 'E' || towards == 'W')) {
      const double from_north = from == 'N' ? *size : kPi - *size;
      return towards == 'E' ? from_north : -from_north;
    }
  }
  reject(field, "a bearing such as N45.3015E");
  return kNotGiven;
}

void Rw5Reader::read_modes(const Record& record) {
  has_modes_ = true;
  const std::string unit = text(record, "UN"), angles = text(record, "AU");
  metres_ = unit == "1" ? 1.0 : unit == "2" ? kUsSurveyFoot : kFoot;
  if (unit != "0" && unit != "1" && unit != "2")
    builder_.skip(line_, 1, "UN" + unit, "the unit of distances: UN0 (feet), UN1 (metres) or UN2 (US survey feet)");
  gon_ = angles == "1";
  if (!angles.empty() && angles != "0" && angles != "1")
    builder_.skip(line_, 1, "AU" + angles, "the unit of angles: AU0 (degrees D.MMSS) or AU1 (gon)");
  builder_.survey.info.angles_in_degrees = !gon_;
  const std::string from = text(record, "AD");
  azimuth_origin_ = from == "1" ? kPi : 0;
  if (!from.empty() && from != "0" && from != "1")
    builder_.skip(line_, 1, "AD" + from, "where azimuths count from: AD0 (north) or AD1 (south)");
  if (const auto offset = text::parse_number(text(record, "EO")); offset && *offset != 0)
    builder_.warn("line " + std::to_string(line_) + ": the EDM offset EO" + text::format_shortest(*offset) +
                  " is not applied: where it belongs to the zenith angles or distances, correct them");
  const auto scale = text::parse_number(text(record, "SF"));
  if (scale && *scale != 1.0) builder_.warn("the scale factor " + text::format_shortest(*scale) + " is not applied");
}

void Rw5Reader::begin_set_up(const std::string& station) {
  builder_.start_set_up(station, instrument_height_, builder_.at(line_, 1));
  observations_at_start_ = builder_.survey.observations.size();
}

/// The first sighting from another station: LS may stand before OC or behind it, and before the backsight or not.
void Rw5Reader::tell_missing_height(const std::string& station) {
  const bool moved = !station_of_last_sighting_.empty() && station != station_of_last_sighting_;
  if (moved && !height_is_new_ && !std::isnan(instrument_height_))
    builder_.warn("line " + std::to_string(line_) + ": no record LS gives the instrument height of the set-up on " +
                  text::quoted(station) + "; the one before (" + text::format_fixed(instrument_height_, 3) +
                  " m) is taken to hold");
  height_is_new_ = false;
  station_of_last_sighting_ = station;
}

void Rw5Reader::read_heights(const Record& record) {
  const double rod = length(record, "HR"), instrument = length(record, "HI");
  if (!std::isnan(rod)) rod_height_ = rod;
  if (std::isnan(instrument)) return;
  instrument_height_ = instrument;
  height_is_new_ = true;
  const int current = builder_.current_set_up();
  if (current >= 0 && builder_.survey.observations.size() == observations_at_start_)
    builder_.survey.set_ups[current].instrument_height = instrument;
}

void Rw5Reader::read_point(const Record& record, const char* name_field) {
  const std::string name = text(record, name_field);
  const Eigen::Vector3d at = {length(record, "E"), length(record, "N"), length(record, "EL")};
  if (name.empty()) return builder_.skip(line_, 1, record.type, std::string("a point name behind ") + name_field);
  if (!at.array().isNaN().all()) builder_.give_coordinates(name, at, builder_.at(line_, 1));
  if (record.type == "SP") builder_.know_coordinates(name, at, builder_.at(line_, 1));
  Point& point = builder_.point(name, builder_.at(line_, 1));
  if (point.description.empty()) point.description = std::string(record.note);
}

// BK: occupied point, backsight, its azimuth BS and the circle's reading to it BC. Sightings count from the backsight;
// with another reading than zero it is not said whether they hold it.
void Rw5Reader::read_backsight(const Record& record) {
  const std::string station = text(record, "OP");
  if (station.empty()) return;
  const int current = builder_.current_set_up();
  const bool measured = builder_.survey.observations.size() > observations_at_start_;
  if (current < 0 || measured || builder_.survey.set_ups[current].station != station) begin_set_up(station);
  const double reading = angle(record, "BC");
  double azimuth = angle(record, "BS") + azimuth_origin_;
  if (const std::string backsight = text(record, "BP"); std::isnan(azimuth) && builder_.has_point(backsight)) {
    const Eigen::Vector3d d = builder_.point(backsight, builder_.at(line_, 1)).coordinates -
                              builder_.point(station, builder_.at(line_, 1)).coordinates;
    if (d.head<2>().norm() > 0) azimuth = wrap_to_circle(std::atan2(d.x(), d.y()));  // NaN: one is not given
  }
  if (std::isnan(azimuth)) return;
  if (reading != 0 && !std::isnan(reading)) {
    builder_.warn("line " + std::to_string(line_) + ": the backsight of " + text::quoted(station) +
                  " was not read as zero; its azimuth is not used");
    return;
  }
  builder_.survey.set_ups[builder_.current_set_up()].stated_orientation = azimuth;
}

double Rw5Reader::direction(const Record& record) {
  const auto has = [&](const char* head) { return record.fields.contains(head); };
  if (has("AR")) return angle(record, "AR");
  if (has("AL")) return -angle(record, "AL");
  if (has("DR")) return kPi + angle(record, "DR");
  if (has("DL")) return kPi - angle(record, "DL");
  if (has("AZ")) return angle(record, "AZ") + azimuth_origin_;
  if (has("BR")) return bearing(record);
  return kNotGiven;
}

double Rw5Reader::zenith_angle(const Record& record) {
  return record.fields.contains("VA") ? kPi / 2 - angle(record, "VA") : angle(record, "ZE");
}

/// A circle has no zenith angle below zero: the record holds something else, and none of its numbers is a reading.
bool Rw5Reader::refuse_negative_zenith_angle(const Record& record) {
  const auto found = record.fields.find("ZE");
  if (found == record.fields.end() || !(angle(record, "ZE") < 0)) return false;
  reject(found->second, "a zenith angle of zero or more behind ZE; the sighting is left out");
  return true;
}

void Rw5Reader::read_sighting(const Record& record) {
  const std::string station = text(record, "OP");
  Sighting sighting;
  sighting.to = text(record, "FP");
  if (sighting.to.empty() || station.empty())
    return builder_.skip(line_, 1, record.type, "a sighting with OP (occupied point) and FP (foresight point)");
  if (refuse_negative_zenith_angle(record)) return;
  sighting.source = builder_.at(line_, 1);
  sighting.direction = direction(record);
  sighting.zenith_angle = zenith_angle(record);
  sighting.slope_distance = length(record, "SD");
  sighting.horizontal_distance = length(record, "HD");
  sighting.height_difference = length(record, "CE");
  sighting.target_height = rod_height_;
  sighting.face = record.type == "BR" || record.type == "FR" ? 2 : 0;
  if (metres_ != 1.0) sighting.distance_corrections.push_back("to metres by " + text::format_shortest(metres_));
  // A backsight that was set and not measured: its record has the horizon and no distance.
  if (sighting.slope_distance == 0 && std::abs(sighting.zenith_angle - kPi / 2) < 1e-12) {
    sighting.zenith_angle = kNotGiven;
    builder_.warn("line " + std::to_string(line_) + ": ZE90 with SD0 is a sighting that was set, not measured: its " +
                  "direction alone is taken");
  }
  for (double* distance : {&sighting.slope_distance, &sighting.horizontal_distance}) {
    if (std::isnan(*distance) || (*distance >= 0 && *distance < 1e5)) continue;
    builder_.skip(line_, 1, record.type, "a distance between 0 and 100 km");
    *distance = kNotGiven;
  }
  // Azimuths and angles from the backsight differ by an orientation: they cannot share a set-up.
  const bool absolute = record.fields.contains("AZ") || record.fields.contains("BR");
  const int current = builder_.current_set_up();
  const bool same_station = current >= 0 && builder_.survey.set_ups[current].station == station;
  const bool has_sightings = builder_.survey.observations.size() > observations_at_start_;
  if (!same_station || (has_sightings && absolute != absolute_)) begin_set_up(station);
  absolute_ = absolute;
  if (absolute) builder_.survey.set_ups[builder_.current_set_up()].stated_orientation = 0;
  const double height = builder_.survey.set_ups[builder_.current_set_up()].instrument_height;
  if (!std::isnan(instrument_height_) && instrument_height_ != height) sighting.instrument_height = instrument_height_;
  if (!builder_.add(sighting)) return builder_.skip(line_, 1, record.type, "at least one measured value");
  tell_missing_height(station);
  Point& point = builder_.point(sighting.to, sighting.source);
  if (point.description.empty()) point.description = std::string(record.note);
}

void Rw5Reader::read_record(const Record& record) {
  ++records_;
  const std::string_view type = record.type;
  if (type == "JB") {
    builder_.survey.info.title = text(record, "NM");
    builder_.survey.info.date = text(record, "DT");
  } else if (type == "MO") {
    read_modes(record);
  } else if (type == "OC") {
    read_point(record, "OP");
    if (const std::string station = text(record, "OP"); !station.empty()) begin_set_up(station);
  } else if (type == "BK") {
    read_backsight(record);
  } else if (type == "LS") {
    read_heights(record);
  } else if (type == "SP") {
    read_point(record, "PN");
  } else if (type == "SS" || type == "TR" || type == "BD" || type == "BR" || type == "FD" || type == "FR") {
    read_sighting(record);
  } else {
    --records_;
    const bool is_type = type.size() >= 2 && type.size() <= 4 &&
                         type.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789") == std::string_view::npos;
    if (is_type && unread_.size() < 20)
      ++unread_[std::string(type)];
    else
      builder_.skip(line_, 1, type, "a record such as OC, LS, SS or SP");
  }
}

SurveyObservations Rw5Reader::read() {
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    line_ = line.number;
    const std::string_view text = text::trim(line.text);
    if (text.empty() || text.starts_with("--")) continue;
    const Record record = parse(line.text);
    static const std::set<std::string_view> kReadRecords = {"OC", "LS", "SP", "BK", "SS", "TR",
                                                            "BD", "BR", "FD", "FR", "MO"};
    if (record.stray.column > 0 && kReadRecords.contains(record.type))
      reject(record.stray,
             "fields that begin with their head, such as HI1.55: is there a comma in a number or a name?");
    else
      read_record(record);
  }
  if (!has_modes_ && records_ > 0) builder_.warn("the file has no MO record; feet and degrees are assumed");
  for (const auto& [type, count] : unread_)
    builder_.warn(std::to_string(count) + " records " + text::quoted(type) + " are not read");
  return builder_.finish(std::to_string(records_) + " records without coordinates or sightings",
                         records_ == 0 ? understood_formats() : "records SP, OC or SS, TR, BD, BR, FD, FR");
}

}  // namespace

SurveyObservations read_rw5(std::string_view bytes, const std::string& file) { return Rw5Reader(bytes, file).read(); }

}  // namespace plumbline::survey
