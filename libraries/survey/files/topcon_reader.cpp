#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "base/text/text.hpp"
#include "survey/files/field_books.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

constexpr double kLongest = 1e5;  // [m]

using Parts = std::vector<std::string_view>;

/// GTS-7: a key, blanks, values separated by commas. HV, SD and HD belong to the BS, FS or SS before them.
class Gts7Reader {
 public:
  Gts7Reader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "topcon-gts7") {}
  SurveyObservations read();

 private:
  void read_record(std::string_view key, const Parts& values);
  void read_measured(std::string_view key, const Parts& values);
  void read_place(const Parts& values);
  double number(const Parts& values, std::size_t i, const char* what);
  double length(const Parts& values, std::size_t i, const char* what) { return metres_ * number(values, i, what); }
  double angle(const Parts& values, std::size_t i, const char* what);

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  int line_ = 0;
  double metres_ = 1;
  bool gon_ = false, has_units_ = false;
  std::string place_of_;    // point that an XYZ belongs to
  bool is_target_ = false;  // it is sighted, not the station or its backsight
  bool is_station_ = false;
  std::string station_;
  Eigen::Vector3d station_at_ = Eigen::Vector3d::Constant(kNotGiven);  // known if a backsight follows [m]
  SourcePosition station_source_;
  std::set<std::string> measured_;  // targets that have readings
  std::string target_, code_;
  double target_height_ = kNotGiven;
  std::size_t records_ = 0;
};

double Gts7Reader::number(const Parts& values, std::size_t i, const char* what) {
  const std::string_view text = i < values.size() ? text::trim(values[i]) : std::string_view();
  if (text.empty()) return kNotGiven;
  if (const auto value = text::parse_number(text)) return *value;
  builder_.skip(line_, 1, text, what);
  return kNotGiven;
}

double Gts7Reader::angle(const Parts& values, std::size_t i, const char* what) {
  const double value = number(values, i, what);
  if (std::isnan(value)) return kNotGiven;
  if (std::abs(value) < 1000) {
    if (gon_) return gon_to_rad(value);
    if (const auto packed = packed_degrees_to_rad(value)) return *packed;
  }
  builder_.skip(line_, 1, values[i], gon_ ? "an angle in gon" : "an angle D.MMSSs");
  return kNotGiven;
}

void Gts7Reader::read_measured(std::string_view key, const Parts& values) {
  if (target_.empty()) return builder_.skip(line_, 1, key, "a record BS, FS or SS with the target before it");
  Sighting sighting;
  sighting.to = target_;
  sighting.target_height = target_height_;
  sighting.source = builder_.at(line_, 1);
  sighting.direction = angle(values, 0, "a circle reading");
  if (key == "HD") {
    sighting.horizontal_distance = length(values, 1, "a horizontal distance");
    sighting.height_difference = length(values, 2, "a height difference");
    sighting.distance_corrections.push_back("reduced by the instrument");
  } else {
    sighting.zenith_angle = angle(values, 1, "a zenith angle");
    if (key == "SD") sighting.slope_distance = length(values, 2, "a slope distance");
  }
  for (double* distance : {&sighting.slope_distance, &sighting.horizontal_distance})
    if (*distance < 0 || *distance > kLongest) {
      builder_.skip(line_, 1, key, "a distance between 0 and 100 km");
      *distance = kNotGiven;
    }
  if (!builder_.add(sighting)) return builder_.skip(line_, 1, key, "at least one measured value");
  measured_.insert(target_);
  Point& point = builder_.point(target_, sighting.source);
  if (point.code.empty()) point.code = code_;
}

void Gts7Reader::read_place(const Parts& values) {
  const Eigen::Vector3d at(length(values, 0, "E"), length(values, 1, "N"), length(values, 2, "H"));
  if (place_of_.empty() || at.array().isNaN().all()) return;
  // Of a backsight they were keyed in, and of the station that has one; of a target, and of a free station, they are
  // what came out.
  if (is_station_) {
    builder_.give_coordinates(place_of_, at, builder_.at(line_, 1));
    station_at_ = at, station_source_ = builder_.at(line_, 1);
  } else if (is_target_ || measured_.contains(place_of_)) {
    builder_.compute_coordinates(place_of_);
    builder_.give_coordinates(place_of_, at, builder_.at(line_, 1));
  } else {
    builder_.know_coordinates(place_of_, at, builder_.at(line_, 1));
  }
}

void Gts7Reader::read_record(std::string_view key, const Parts& values) {
  const auto name = [&] { return std::string(values.empty() ? std::string_view() : text::trim(values[0])); };
  ++records_;
  if (key == "UNITS") {
    has_units_ = true;
    const std::string length_unit = name();
    if (length_unit != "M" && length_unit != "F" && length_unit != "U" && length_unit != "I")
      builder_.skip(line_, 1, length_unit, "the unit M, F, U or I of lengths");
    const std::string angle_unit(values.size() > 1 ? text::trim(values[1]) : std::string_view());
    if (angle_unit != "G" && angle_unit != "D" && !angle_unit.empty())
      builder_.skip(line_, 1, angle_unit, "the unit G (gon) or D (D.MMSS) of angles");
    metres_ = length_unit == "F" ? kFoot : length_unit == "U" || length_unit == "I" ? kUsSurveyFoot : 1.0;
    gon_ = values.size() > 1 && text::trim(values[1]) == "G";
    builder_.survey.info.angles_in_degrees = !gon_;
  } else if (key == "STN") {
    place_of_ = station_ = name(), is_target_ = false, is_station_ = true;
    station_at_.setConstant(kNotGiven);
    if (place_of_.empty()) return builder_.skip(line_, 1, key, "the name of the station");
    builder_.start_set_up(place_of_, length(values, 1, "an instrument height"), builder_.at(line_, 1));
    target_.clear();
  } else if (key == "BKB") {
    if (!station_at_.array().isNaN().all() && !measured_.contains(station_))
      builder_.know_coordinates(station_, station_at_, station_source_);
    place_of_ = name(), is_target_ = is_station_ = false;
    const double azimuth = angle(values, 1, "an azimuth"), reading = angle(values, 2, "a circle reading");
    if (builder_.current_set_up() >= 0 && !std::isnan(azimuth) && !std::isnan(reading))
      builder_.survey.set_ups[builder_.current_set_up()].stated_orientation = wrap_to_circle(azimuth - reading);
  } else if (key == "BS" || key == "FS" || key == "SS") {
    place_of_ = target_ = name(), is_target_ = true, is_station_ = false;
    target_height_ = length(values, 1, "a target height");
    code_ = values.size() > 2 ? std::string(text::trim(values[2])) : "";
    if (target_.empty()) builder_.skip(line_, 1, key, "the name of the target");
  } else if (key == "SD" || key == "HV" || key == "HD") {
    read_measured(key, values);
  } else if (key == "XYZ") {
    read_place(values);
  } else if (key == "JOB") {
    builder_.survey.info.title = name();
  } else if (key == "INST") {
    builder_.survey.info.instrument = name();
  } else if (key == "SCALE" || key == "OFFSET" || key == "PTL_OFF") {
    if (key != "SCALE" || number(values, 0, "a scale") != 1)
      builder_.warn("line " + std::to_string(line_) + ": " + std::string(key) + " is not applied");
  } else if (key != "DATE" && key != "TEMP" && key != "CTL" && key != "NOTE" && key != "TIME") {
    --records_;
    if (!key.starts_with("TopSURV"))
      builder_.skip(line_, 1, key, "a record such as STN, XYZ, BKB, BS, SS, SD, HV or HD");
  }
}

SurveyObservations Gts7Reader::read() {
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    line_ = line.number;
    const std::string_view text = text::trim(line.text);
    if (text.empty()) continue;
    const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
    read_record(text.substr(0, end), text::split(text::trim(text.substr(end)), ','));
  }
  if (!has_units_ && records_ > 0) builder_.warn("the file has no UNITS record; metres and D.MMSS are assumed");
  return builder_.finish(std::to_string(records_) + " records without coordinates or sightings",
                         records_ == 0 ? understood_formats() : "records XYZ, or SD, HV, HD");
}

/// GTS-210: a stream cut by "_'" (station), "_+" (target) and "_*" (code and target height of the sighting before).
class Gts210Reader {
 public:
  Gts210Reader(std::string_view bytes, const std::string& file) : builder_(file, "topcon-gts210") {
    join(text::decode_text(bytes).text);
  }
  SurveyObservations read();

 private:
  void join(const std::string& text);
  void read_station(std::string_view record);
  bool read_sighting(std::string_view record);
  /// All may stand in one line: the column tells readings apart.
  SourcePosition position_of(std::string_view record) const;

  SurveyBuilder builder_;
  bool framed_ = false;
  std::string stream_;
  std::vector<std::size_t> line_ends_;  // in stream_
  std::size_t records_ = 0;
};

// Lines end in a block number and three digits of check sum if there are several.
void Gts210Reader::join(const std::string& text) {
  const auto lines = text::split_lines(text);
  std::size_t filled = 0;
  for (const text::Line& line : lines) filled += text::trim(line.text).empty() ? 0 : 1;
  framed_ = !lines.empty() && lines.front().text.starts_with('?');  // each line between STX and ETX
  for (const text::Line& line : lines) {
    std::string_view part = line.text;
    if (framed_ && part.starts_with('?')) part.remove_prefix(1);
    if (framed_ && part.ends_with('?')) part.remove_suffix(1);
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    if (filled > 1 && part.size() > 4 && std::all_of(part.end() - 4, part.end(), is_digit)) part.remove_suffix(4);
    stream_ += part;
    line_ends_.push_back(stream_.size());
  }
}

SourcePosition Gts210Reader::position_of(std::string_view record) const {
  const auto at = static_cast<std::size_t>(record.data() - stream_.data());
  const auto line = std::upper_bound(line_ends_.begin(), line_ends_.end(), at);
  const std::size_t begin = line == line_ends_.begin() ? 0 : *(line - 1);
  return builder_.at(static_cast<int>(line - line_ends_.begin()) + 1, static_cast<int>(at - begin) + 1 + framed_);
}

// "110_(code_)1.390_"
void Gts210Reader::read_station(std::string_view record) {
  const std::size_t open = record.find("_("), close = record.find("_)");
  const std::string name(text::trim(record.substr(0, open)));
  const std::string_view height = close == std::string_view::npos
                                      ? std::string_view()
                                      : record.substr(close + 2, record.find('_', close + 2) - close - 2);
  const auto value = text::parse_number(height);
  const SourcePosition source = position_of(record);
  const double instrument_height = value ? *value : kNotGiven;
  if (name.empty())
    builder_.start_unnamed_set_up(instrument_height, source);
  else
    builder_.start_set_up(name, instrument_height, source);
}

// "111_ ?+00041951m0860312+1035120d+00041852t60+00+00103_*code_,1.500_"
bool Gts210Reader::read_sighting(std::string_view record) {
  Sighting sighting;
  sighting.source = position_of(record);
  const std::size_t mode = record.find("_ ");
  if (mode == std::string_view::npos || record.size() < mode + 30) return false;
  sighting.to = std::string(text::trim(record.substr(0, mode)));
  const std::string_view data = record.substr(mode + 2);
  if (data[0] != '?' || sighting.to.empty()) return false;  // other modes hold reduced values
  // ?, sign and 8 digits, unit of length, 7 digits of zenith angle, sign and 7 of circle, unit of angle
  const auto length = text::parse_integer(data.substr(2, 8)), zenith = text::parse_integer(data.substr(11, 7)),
             circle = text::parse_integer(data.substr(19, 7));
  const char length_unit = data[10], angle_unit = data[26];
  if (!length || !zenith || !circle || *length < 0 || *zenith < 0 || *circle < 0) return false;
  if ((length_unit != 'm' && length_unit != 'f') || (angle_unit != 'd' && angle_unit != 'g')) return false;
  const auto angle = [&](long long value) -> std::optional<double> {
    if (angle_unit == 'g') return gon_to_rad(static_cast<double>(value) / 1e4);
    return packed_degrees_to_rad(static_cast<double>(value) / 1e4);
  };
  const auto v = angle(*zenith), h = angle(*circle);
  if (!v || !h) return false;
  sighting.slope_distance = static_cast<double>(*length) / 1e3 * (length_unit == 'f' ? kFoot : 1.0);
  sighting.zenith_angle = *v;
  sighting.direction = *h;
  builder_.survey.info.angles_in_degrees = angle_unit == 'd';
  const std::size_t code = data.find("_*");
  if (code != std::string_view::npos) {
    const std::size_t comma = data.find("_,", code);
    const std::string_view name = data.substr(code + 2, std::min(comma, data.size()) - code - 2);
    if (comma != std::string_view::npos) {
      const std::string_view height = data.substr(comma + 2, data.find('_', comma + 2) - comma - 2);
      if (const auto value = text::parse_number(height)) sighting.target_height = *value;
    }
    Point& point = builder_.point(sighting.to, sighting.source);
    if (point.code.empty()) point.code = std::string(text::trim(name));
  }
  return builder_.add(sighting);
}

SurveyObservations Gts210Reader::read() {
  const std::string_view all = stream_;
  // Where the next record of a station or target begins; a target's mark is no part of its numbers ("+00").
  const auto next = [&](std::size_t from) {
    std::size_t at = from;
    while ((at = all.find('_', at)) != std::string_view::npos && at + 1 < all.size() && all[at + 1] != '\'' &&
           all[at + 1] != '+')
      ++at;
    return at == std::string_view::npos || at + 1 >= all.size() ? all.size() : at;
  };
  for (std::size_t at = next(0); at < all.size();) {
    const std::size_t end = next(at + 2);
    const std::string_view record = all.substr(at + 2, end - at - 2);
    ++records_;
    if (all[at + 1] == '\'')
      read_station(record);
    else if (!read_sighting(record))
      builder_.skip(position_of(record).line, position_of(record).column, record.substr(0, 40),
                    "target, '?', slope distance, zenith angle and circle");
    at = end;
  }
  return builder_.finish(std::to_string(records_) + " records without sightings",
                         records_ == 0 ? understood_formats() : "records _+ with slope distances");
}

}  // namespace

SurveyObservations read_topcon_gts7(std::string_view bytes, const std::string& file) {
  return Gts7Reader(bytes, file).read();
}

SurveyObservations read_topcon_gts210(std::string_view bytes, const std::string& file) {
  return Gts210Reader(bytes, file).read();
}

}  // namespace plumbline::survey
