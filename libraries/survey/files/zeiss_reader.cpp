#include <cmath>
#include <numbers>
#include <optional>

#include "base/text/text.hpp"
#include "survey/files/levelling.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/zeiss.hpp"

namespace plumbline::survey {
namespace {

struct Value {
  std::string type, unit;
  double number = kNotGiven;
};

struct Record {
  bool is_text = false;   ///< TI, TO, TR: a message
  bool is_level = false;  ///< KD1, KD2
  std::string info;
  std::string point, code;
  std::vector<Value> values;
  const Value* find(std::string_view type) const {
    for (const Value& v : values)
      if (v.type == type) return &v;
    return nullptr;
  }
};

class ZeissReader {
 public:
  ZeissReader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "zeiss"), level_(builder_) {}
  SurveyObservations read();

 private:
  std::optional<Record> parse(std::string_view line);
  void name_point(std::string_view info, bool short_record, Record& record) const;
  void read_record(const Record& record);
  void read_message(const Record& record);
  void read_level(const Record& record);
  void read_station(const Record& record);
  void read_polar(const Record& record);
  bool read_coordinates(const Record& record, const std::string& id, bool keyed);
  double length(const Record& record, std::string_view type);
  double angle(const Record& record, std::string_view type);
  SetUp* current() {
    const int index = builder_.current_set_up();
    return index < 0 ? nullptr : &builder_.survey.set_ups[index];
  }

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  LevelRun level_;
  int line_ = 0;
  double instrument_height_ = kNotGiven, target_height_ = kNotGiven;
  std::vector<std::pair<Record, int>> before_station_;  // backsights read before the station is named, with their lines
  bool orienting_ = false;                              // between the station and POLAR
  bool station_given_ = false;                          // of that orientation
  bool free_station_ = true;                            // its coordinates may be computed from its sights
  std::size_t records_ = 0;
  bool line_is_read_ = false;  // a staff of this levelling line
};

// "For M5|Adr 00002|PI1  ...|Hz  110.0849 DMS |...": R4 has no address.
std::optional<Record> ZeissReader::parse(std::string_view line) {
  auto fields = text::split(line, '|');
  if (fields.size() < 3) return std::nullopt;
  const bool short_record =
      fields[0].find("R4") != std::string_view::npos || fields[0].find("R5") != std::string_view::npos;
  fields.erase(fields.begin());
  if (text::trim(fields[0]).starts_with("Adr")) fields.erase(fields.begin());
  if (fields.empty() || fields[0].size() < 2) return std::nullopt;
  Record record;
  const std::string_view mark = text::trim(fields[0].substr(0, 3));
  record.is_text = mark.starts_with("T");
  record.is_level = mark.starts_with("KD");
  record.info = std::string(text::trim(fields[0].substr(std::min<std::size_t>(3, fields[0].size()))));
  if (!record.is_text) name_point(fields[0].substr(std::min<std::size_t>(3, fields[0].size())), short_record, record);
  for (std::size_t i = 1; i < fields.size(); ++i) {
    const auto words = text::split_blanks(fields[i]);
    if (words.size() < 2) continue;
    const auto number = text::parse_number(words[1]);
    if (!number) continue;
    record.values.push_back({std::string(words[0]), words.size() > 2 ? text::to_lower(words[2]) : "", *number});
  }
  return record;
}

// R4, R5: three characters of code, then the number. M5: words; a level's point comes first, another's last.
void ZeissReader::name_point(std::string_view info, bool short_record, Record& record) const {
  if (short_record) {
    record.code = std::string(text::trim(info.substr(0, std::min<std::size_t>(3, info.size()))));
    record.point = info.size() > 3 ? std::string(text::trim(info.substr(3))) : "";
    return;
  }
  const auto words = text::split_blanks(info);
  if (words.empty()) return;
  if (record.is_level) {
    record.point = std::string(words.front());
    return;
  }
  record.point = std::string(words.back());
  if (words.size() > 1) {
    record.code = std::string(words.front());
    return;
  }
  // "1100CONTR", "0S": the number's column ends where the code's begins.
  const std::size_t letters = record.point.find_first_not_of("0123456789");
  if (letters != std::string::npos && letters > 0) {
    record.code = record.point.substr(letters);
    record.point.resize(letters);
  }
}

double ZeissReader::length(const Record& record, std::string_view type) {
  const Value* v = record.find(type);
  if (!v) return kNotGiven;
  if (v->unit.empty() || v->unit == "m") return v->number;
  if (v->unit == "ft") return v->number * kFoot;
  if (v->unit == "mm") return v->number / 1000;
  builder_.skip(line_, 1, v->unit, "a length in m, mm or ft");
  return kNotGiven;
}

double ZeissReader::angle(const Record& record, std::string_view type) {
  const Value* v = record.find(type);
  if (!v) return kNotGiven;
  if (std::abs(v->number) < 7000) {
    builder_.survey.info.angles_in_degrees = v->unit == "dms" || v->unit == "deg";
    if (v->unit == "grd" || v->unit == "gon" || v->unit.empty()) return gon_to_rad(v->number);
    if (v->unit == "deg") return degrees_to_rad(v->number);
    if (v->unit == "mil") return v->number * std::numbers::pi / 3200;
    if (v->unit == "dms")
      if (const auto packed = packed_degrees_to_rad(v->number)) return *packed;
  }
  builder_.skip(line_, 1, v->unit, "an angle in grd, deg, DMS or mil");
  return kNotGiven;
}

bool ZeissReader::read_coordinates(const Record& record, const std::string& id, bool keyed) {
  const bool mathematical = record.find("E") || record.find("N");
  const Eigen::Vector3d at(length(record, mathematical ? "E" : "Y"), length(record, mathematical ? "N" : "X"),
                           length(record, "Z"));
  if (at.array().isNaN().all() || id.empty()) return false;
  // Of a station that was computed from its sights they are no more than that.
  if (keyed)
    builder_.know_coordinates(id, at, builder_.at(line_, 1));
  else
    builder_.give_coordinates(id, at, builder_.at(line_, 1));
  return true;
}

void ZeissReader::read_message(const Record& record) {
  const std::string text = text::to_lower(record.info);
  const auto has = [&](const char* part) { return text.find(part) != std::string::npos; };
  const double th = length(record, "th"), ih = length(record, "ih");
  if (!std::isnan(th)) target_height_ = th;
  if (!std::isnan(ih)) instrument_height_ = ih;
  if (has("start-line") || has("cont-line") || has("linienanfang") || has("linienbeginn")) {
    const bool two = has("bffb") || has("bbff") || has("bfbf") || has("fbbf") || has("rvvr") || has("rrvv");
    level_.begin_line(two ? 2 : has("bf") || has("rv") ? 1 : 0);
    line_is_read_ = has("cont-line");
  } else if (has("end-line") || has("linienende")) {
    level_.begin_line(0);
  } else if (has("measurement repeated") || has("messung wiederholt")) {
    level_.drop_last();
  } else if (has("station repeated") || has("standpunkt wiederholt")) {
    level_.drop_position();
  } else if (text.find("stat") != std::string::npos || has("or.coor") || has("or.")) {
    if (has("stat")) station_given_ = false, free_station_ = !has("kn stat") && !has("kn.stat") && !has("bek");
    orienting_ = true;
  }
  if (const double om = angle(record, "Om"); !std::isnan(om) && current()) {
    current()->stated_orientation = wrap_to_circle(om);
    orienting_ = true;
  }
  if (has("polar") && orienting_ && current()) {
    // From here on the circle reads azimuths.
    orienting_ = false;
    builder_.start_set_up(std::string(current()->station), instrument_height_, builder_.at(line_, 1));
    current()->stated_orientation = 0;
  }
}

void ZeissReader::read_level(const Record& record) {
  static constexpr std::pair<std::string_view, StaffReading::Kind> kReadings[] = {
      {"Rb", StaffReading::Kind::back},         {"Lr", StaffReading::Kind::back},
      {"Rf", StaffReading::Kind::ahead},        {"Lv", StaffReading::Kind::ahead},
      {"Rz", StaffReading::Kind::intermediate}, {"Lz", StaffReading::Kind::intermediate}};
  if (record.info.find("###") != std::string::npos) return;  // what was repeated
  for (const auto& [type, kind] : kReadings) {
    if (!record.find(type)) continue;
    StaffReading reading;
    reading.kind = kind;
    reading.point = record.point;
    reading.value = length(record, type);
    reading.distance = length(record, record.find("HD") ? "HD" : "E");
    reading.source = builder_.at(line_, 1);
    if (std::isnan(reading.value) || std::abs(reading.value) > 10 || reading.point.empty())
      return builder_.skip(line_, 1, record.info, "a point and a staff reading of at most 10 m");
    level_.add(std::move(reading));
    line_is_read_ = true;
    return;
  }
  const bool sums = record.find("Sh") || record.find("dz") || record.find("Db") || record.find("Df");
  if (sums || !record.find("Z") || record.point.empty()) return;
  level_.finish_position();
  const Eigen::Vector3d at(kNotGiven, kNotGiven, length(record, "Z"));
  if (line_is_read_) {
    level_.compare_height(record.point, at.z(), line_);
    builder_.compute_coordinates(record.point);
  } else {  // the height that a line begins with was keyed in
    level_.start_from(record.point, at.z());
    builder_.know_coordinates(record.point, at, builder_.at(line_, 1));
  }
  builder_.give_coordinates(record.point, at, builder_.at(line_, 1));
}

void ZeissReader::read_station(const Record& record) {
  if (const SetUp* set_up = current(); set_up && set_up->station == record.point && !record.find("Hz")) {
    read_coordinates(record, record.point, !free_station_);  // its height, given behind its position
    return;
  }
  builder_.start_set_up(record.point, kNotGiven, builder_.at(line_, 1));
  orienting_ = station_given_ = true;
  read_coordinates(record, record.point, !free_station_);
  for (const auto& [sight, line] : before_station_) {
    const int here = line_;
    line_ = line;
    read_polar(sight);
    line_ = here;
  }
  before_station_.clear();
}

void ZeissReader::read_polar(const Record& record) {
  Sighting sighting;
  sighting.to = record.point;
  sighting.source = builder_.at(line_, 1);
  sighting.direction = angle(record, "Hz");
  sighting.zenith_angle = angle(record, "V1");
  if (const Value* v = record.find("V2"); v && !record.find("V1"))
    builder_.skip(line_, 1, v->type, "zenith angles V1: what V2 counts from depends on the instrument");
  sighting.slope_distance = length(record, record.find("SD") ? "SD" : "D");
  if (std::isnan(sighting.slope_distance))
    sighting.horizontal_distance = length(record, record.find("HD") ? "HD" : "E");
  sighting.target_height = target_height_;
  for (double* distance : {&sighting.slope_distance, &sighting.horizontal_distance})
    if (*distance < 0 || *distance > 1e5) {
      builder_.skip(line_, 1, record.point, "a distance between 0 and 100 km");
      *distance = kNotGiven;
    }
  if (SetUp* set_up = current(); set_up && !std::isnan(instrument_height_)) {
    if (std::isnan(set_up->instrument_height))
      set_up->instrument_height = instrument_height_;
    else if (set_up->instrument_height != instrument_height_)
      sighting.instrument_height = instrument_height_;
  }
  if (sighting.to.empty() || !builder_.add(sighting))
    return builder_.skip(line_, 1, record.info, "a point with at least one measured value");
  Point& point = builder_.point(sighting.to, sighting.source);
  if (point.code.empty() && record.code.size() > 1) point.code = record.code;
}

void ZeissReader::read_record(const Record& record) {
  ++records_;
  if (record.is_text) return read_message(record);
  if (record.is_level) return read_level(record);
  const bool measured = record.find("Hz") || record.find("SD") || record.find("V1");
  if (record.code == "S" && !measured) return read_station(record);
  // A backsight may stand before its station or behind it.
  if (record.code == "A" && measured && orienting_ && !station_given_) {
    before_station_.push_back({record, line_});
    return;
  }
  if (measured) return read_polar(record);
  // Coordinates behind a polar point were computed from it.
  if (builder_.has_point(record.point) && current()) return;
  if (!read_coordinates(record, record.point, true) && !record.values.empty() && !record.find("Z"))
    builder_.warn("line " + std::to_string(line_) + ": a record of " + record.values.front().type + " is not read");
}

SurveyObservations ZeissReader::read() {
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    line_ = line.number;
    const std::string_view text = text::trim(line.text);
    if (text.empty() || text == "END" || text.starts_with("----")) continue;
    const auto record = text.starts_with("For ") ? parse(text) : std::nullopt;
    if (record)
      read_record(*record);
    else
      builder_.skip(line_, 1, text, "a record 'For M5|...', 'For R5|...' or 'For R4|...'");
  }
  level_.finish();
  for (const auto& [sight, line] : before_station_)
    builder_.skip(line, 1, sight.info, "a station (code S) behind the backsights of its orientation");
  return builder_.finish(std::to_string(records_) + " records without sightings, staff readings or coordinates",
                         records_ == 0 ? understood_formats() : "records with Hz, V1, SD, with Rb and Rf, or Y, X, Z");
}

}  // namespace

SurveyObservations read_zeiss(std::string_view bytes, const std::string& file) {
  return ZeissReader(bytes, file).read();
}

}  // namespace plumbline::survey
