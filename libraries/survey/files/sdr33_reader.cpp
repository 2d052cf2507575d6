#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "base/text/text.hpp"
#include "survey/files/sdr33.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

// First column (from 0) and width of the fields behind the tag; the two variants differ in nothing else.
struct Layout {
  std::size_t point, number;  // characters of a name, of a value
};
constexpr Layout kSdr33 = {16, 16}, kSdr2x = {4, 10};

/// What the derivation code of a record of coordinates says they are: typed in or from another program, or computed by
/// a program of the instrument; nothing of the program that handles coordinates (CO), which does both.
enum class Derivation { known, computed, open };
Derivation derivation_of(std::string_view code) {
  if (code == "KI" || code == "XD") return Derivation::known;
  static constexpr std::array programs = {"TP", "TV", "RS", "SC", "RE", "IN", "SO", "RO", "MC", "AJ"};
  return std::find(programs.begin(), programs.end(), code) != programs.end() ? Derivation::computed : Derivation::open;
}

class Sdr33Reader {
 public:
  Sdr33Reader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "sdr33") {}
  SurveyObservations read();

 private:
  struct Field {
    std::size_t column = 0;  // from 0
    std::string text;
    bool cut = false;  // the line ends inside the field
  };

  void read_record(const text::CharacterLine& line);
  void read_header(const text::CharacterLine& line);
  void read_station(const text::CharacterLine& line);
  void read_coordinates(const text::CharacterLine& line);
  void read_backsight(const text::CharacterLine& line);
  void read_observation(const text::CharacterLine& line);
  void give_coordinates(const std::string& name, const Eigen::Vector3d& at, std::string_view code);
  void select_set_up(const std::string& station, const SourcePosition& source);

  Field field(const text::CharacterLine& line, std::size_t column, std::size_t width) const {
    return {column, std::string(text::trim(line.part(column, width))), line.size() < column + width};
  }
  double number(const Field& field, const char* what);
  Eigen::Vector3d coordinates(const text::CharacterLine& line, std::size_t column);
  void reject(const Field& field, const std::string& expected) {
    builder_.skip(line_, static_cast<int>(field.column) + 1, field.text, expected);
  }

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  Layout layout_ = kSdr33;
  int line_ = 0;
  double metres_ = 1.0, radians_ = std::numbers::pi / 180, target_height_ = kNotGiven;
  bool east_first_ = false, from_horizon_ = false;
  std::string prism_note_;
  std::set<std::pair<int, std::string>> sighted_;  // set-ups and targets of readings as they were taken
  std::size_t reduced_ = 0, means_ = 0, records_ = 0;
};

double Sdr33Reader::number(const Field& field, const char* what) {
  if (field.text.empty()) return kNotGiven;
  const auto value = text::parse_number(field.text);
  if (value) return *value;
  reject(field, what);
  return kNotGiven;
}

void Sdr33Reader::read_header(const text::CharacterLine& line) {
  const std::string version = field(line, 4, 16).text;
  layout_ = version.starts_with("SDR2") ? kSdr2x : kSdr33;
  const std::string units = field(line, 40, 6).text;
  const auto digit = [&](std::size_t i) { return i < units.size() ? units[i] : '?'; };
  if (units.size() < 5) builder_.warn("the header gives no units; degrees, metres and north-east order are assumed");
  const auto is_one_of = [&](std::size_t i, std::string_view known) {
    return known.find(digit(i)) != std::string::npos;
  };
  if (units.size() >= 5 && (!is_one_of(0, "124") || !is_one_of(1, "123")))
    builder_.skip(line_, 41, units, "units such as 111121: 1 degrees, 2 gon, 4 mil; 1 metres, 2 feet, 3 US feet");
  radians_ = digit(0) == '2' ? std::numbers::pi / 200 : digit(0) == '4' ? std::numbers::pi / 3200 : radians_;
  metres_ = digit(1) == '2' ? kFoot : digit(1) == '3' ? kUsSurveyFoot : 1.0;
  east_first_ = digit(4) == '2';
  builder_.survey.info.program = version;
  builder_.survey.info.date = field(line, 24, 16).text;
  builder_.survey.info.angles_in_degrees = digit(0) != '2';
}

Eigen::Vector3d Sdr33Reader::coordinates(const text::CharacterLine& line, std::size_t column) {
  Eigen::Vector3d at;
  for (int i = 0; i < 3; ++i) {
    const Field part = field(line, column + static_cast<std::size_t>(i) * layout_.number, layout_.number);
    at[i] = metres_ * number(part, "a coordinate");
    if (part.cut && !part.text.empty() && i < 2) {
      reject(part, "a whole coordinate; the line seems cut");
      at[i] = kNotGiven;
    }
  }
  if (!east_first_) std::swap(at[0], at[1]);
  return at;
}

void Sdr33Reader::give_coordinates(const std::string& name, const Eigen::Vector3d& at, std::string_view code) {
  const Derivation derivation = derivation_of(code);
  if (derivation == Derivation::computed) builder_.compute_coordinates(name);
  builder_.give_coordinates(name, at, builder_.at(line_, 1));
  if (derivation == Derivation::known) builder_.know_coordinates(name, at, builder_.at(line_, 1));
}

void Sdr33Reader::read_station(const text::CharacterLine& line) {
  const Field name = field(line, 4, layout_.point);
  if (name.text.empty()) return reject(name, "the name of the station");
  const std::size_t values = 4 + layout_.point;
  const double height =
      metres_ * number(field(line, values + 3 * layout_.number, layout_.number), "an instrument height");
  const SourcePosition source = builder_.at(line_, 1);
  builder_.start_set_up(name.text, height, source);
  const Eigen::Vector3d at = coordinates(line, values);
  if (!at.array().isNaN().all()) give_coordinates(name.text, at, line.part(2, 2));
}

// 07: station, backsight, its azimuth, the circle's reading to it.
void Sdr33Reader::read_backsight(const text::CharacterLine& line) {
  const Field from = field(line, 4, layout_.point);
  const std::size_t values = 4 + 2 * layout_.point;
  const double azimuth = number(field(line, values, layout_.number), "the azimuth of the backsight");
  const double reading = number(field(line, values + layout_.number, layout_.number), "the circle's reading to it");
  const int current = builder_.current_set_up();
  if (current < 0 || std::isnan(azimuth) || std::isnan(reading)) return;
  SetUp& set_up = builder_.survey.set_ups[current];
  if (set_up.station == from.text) set_up.stated_orientation = wrap_to_circle((azimuth - reading) * radians_);
}

void Sdr33Reader::read_coordinates(const text::CharacterLine& line) {
  const Field name = field(line, 4, layout_.point);
  if (name.text.empty()) return reject(name, "the name of the point");
  const std::size_t values = 4 + layout_.point;
  const Eigen::Vector3d at = coordinates(line, values);
  if (at.array().isNaN().all()) return;
  give_coordinates(name.text, at, line.part(2, 2));
  const std::string code = field(line, values + 3 * layout_.number, 16).text;
  Point& point = builder_.point(name.text, builder_.at(line_, 1));
  if (point.code.empty()) point.code = code;
}

void Sdr33Reader::select_set_up(const std::string& station, const SourcePosition& source) {
  const int current = builder_.current_set_up();
  if (current >= 0 && builder_.survey.set_ups[current].station == station) return;
  builder_.warn("line " + std::to_string(source.line) + ": observations from " + text::quoted(station) +
                " without a station record (02) for it; its instrument height is unknown");
  builder_.start_set_up(station, kNotGiven, source);
}

void Sdr33Reader::read_observation(const text::CharacterLine& line) {
  const std::string_view kind = line.part(2, 2);
  const Field from = field(line, 4, layout_.point), to = field(line, 4 + layout_.point, layout_.point);
  if (from.text.empty() || to.text.empty()) return reject(from, "the names of station and target");
  std::size_t column = 4 + 2 * layout_.point;
  double values[3];
  std::size_t decimals = std::string::npos;
  for (double& value : values) {
    const Field part = field(line, column, layout_.number);
    column += layout_.number;
    value = number(part, "a measured value");
    const std::size_t dot = part.text.find('.');
    const std::size_t own = dot == std::string::npos ? 0 : part.text.size() - dot - 1;
    // Values of a record have equally many decimals; a shorter last one at the end of the line was cut.
    if (part.cut && !part.text.empty() && own != decimals) {
      reject(part, "a whole value with as many decimals as the others; the line seems cut");
      value = kNotGiven;
    }
    if (!part.text.empty()) decimals = own;
  }
  if (values[0] < 0 || values[0] * metres_ > 1e5) {
    reject(field(line, 4 + 2 * layout_.point, layout_.number), "a distance between 0 and 100 km");
    values[0] = kNotGiven;
  }
  Sighting sighting;
  sighting.to = to.text;
  sighting.source = builder_.at(line_, 1);
  sighting.slope_distance = values[0] * metres_;
  sighting.zenith_angle = from_horizon_ ? std::numbers::pi / 2 - values[1] * radians_ : values[1] * radians_;
  sighting.direction = values[2] * radians_;
  sighting.face = kind == "F1" ? 1 : kind == "F2" ? 2 : 0;
  sighting.target_height = target_height_;
  if (from_horizon_) sighting.zenith_corrections.push_back("counted from the horizon in the file");
  if (!prism_note_.empty()) sighting.distance_corrections.push_back("noted in the file: " + prism_note_);
  if (kind == "MC") sighting.distance_corrections.push_back("corrected by the instrument (record MC)");
  select_set_up(from.text, sighting.source);
  const std::pair pointing(builder_.current_set_up(), to.text);
  if (kind == "MC" && sighted_.contains(pointing)) {
    ++means_;
    return;
  }
  if (kind != "MC") sighted_.insert(pointing);
  if (!builder_.add(sighting)) reject(to, "a distance, vertical or horizontal angle");
}

void Sdr33Reader::read_record(const text::CharacterLine& line) {
  const std::string_view type = line.part(0, 2);
  ++records_;
  if (type == "00") return read_header(line);
  if (type == "07") return read_backsight(line);
  if (type == "02") return read_station(line);
  if (type == "08") return read_coordinates(line);
  if (type == "09") return read_observation(line);
  if (type == "03") {
    const Field height = field(line, 4, layout_.number);
    const double value = metres_ * number(height, "a target height");
    if (!std::isnan(value)) target_height_ = value;
  } else if (type == "01") {
    NetworkInfo& info = builder_.survey.info;
    builder_.use_instrument(field(line, 5, 16).text);
    info.instrument_serial = field(line, 21, 6).text;
    from_horizon_ = line.size() > 50 && line.at(50) == '2';
  } else if (type == "10") {
    builder_.survey.info.title = field(line, 4, 16).text;
  } else if (type == "06") {
    const double scale = number(field(line, 4, layout_.number), "a scale factor");
    if (!std::isnan(scale) && scale != 1.0)
      builder_.warn("the scale factor " + text::format_shortest(scale) + " (line " + std::to_string(line_) +
                    ") is not applied");
  } else if (type == "11") {
    ++reduced_;
  } else if (line.part(0, 4) == "13PC") {
    prism_note_ = std::string(text::trim(line.part(4)));
  }
}

SurveyObservations Sdr33Reader::read() {
  for (const text::Line& source : text::split_lines(decoded_.text)) {
    line_ = source.number;
    const std::string_view text = source.text;
    if (text::trim(text).empty()) continue;
    // Sent over a cable, a file is framed by STX and ETX (decoded as '?'), and a record 0000 with a check sum ends it.
    const std::string_view whole = text::trim(text);
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    if (whole == "?") continue;
    if (whole.substr(0, 4) == "0000") break;
    if (whole.front() == '?' && whole.size() <= 6 && std::all_of(whole.begin() + 1, whole.end(), is_digit)) break;
    if (text.size() >= 4 && is_digit(text[0]) && is_digit(text[1]))
      read_record(text::CharacterLine(text));
    else
      builder_.skip(line_, 1, text, "a record: two digits, two letters, then fields of fixed width");
  }
  if (decoded_.encoding != text::Encoding::utf8)
    builder_.warn(std::string("text encoding taken as ") + text::name_of(decoded_.encoding));
  if (means_ > 0)
    builder_.warn(
        std::to_string(means_) +
        " corrected observations (09MC) of what was read as well were left out; the single sightings are read");
  if (reduced_ > 0) builder_.warn(std::to_string(reduced_) + " reduced observations (records 11) were left out");
  return builder_.finish(std::to_string(records_) + " records without coordinates or observations",
                         records_ == 0 ? understood_formats() : "records 08 (coordinates) or 09 (observations)");
}

}  // namespace

SurveyObservations read_sdr33(std::string_view bytes, const std::string& file) {
  return Sdr33Reader(bytes, file).read();
}

}  // namespace plumbline::survey
