#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/text/text.hpp"
#include "survey/files/field_books.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

/// What was said of the target until now.
struct Target {
  std::string name, code;
  double height = kNotGiven;
  double circle_1 = kNotGiven, circle_2 = kNotGiven, circle = kNotGiven;  // faces 1 and 2, and without a face
  double zenith_1 = kNotGiven, zenith_2 = kNotGiven, zenith = kNotGiven;
  double slope = kNotGiven, horizontal = kNotGiven;
  SourcePosition source;
};

class GeodimeterReader {
 public:
  GeodimeterReader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "geodimeter") {}
  SurveyObservations read();

 private:
  void read_label(long long label, std::string_view value);
  void read_units(std::string_view value);
  void find_unit(const std::vector<text::Line>& lines);
  void finish_target();
  void add_face(double circle, double zenith, int face, bool with_distance);
  void finish_point();
  double length(std::string_view text, const char* what);
  double angle(std::string_view text);

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  int line_ = 0;
  double metres_ = 1, instrument_height_ = kNotGiven, signal_height_ = kNotGiven;
  char angle_unit_ = '2';  // as label 23 has it: 1 gon, 2 D.MMSS, 3 decimal degrees, 4 mil
  bool has_units_ = false, has_angles_ = false;
  Target target_;
  std::string point_;               // that coordinates belong to
  bool is_station_ = false;         // of label 2
  std::set<std::string> measured_;  // targets that have readings
  Eigen::Vector3d at_ = Eigen::Vector3d::Constant(kNotGiven);
  /// What the circle read, or was set to, at a reference object (62, 21); its azimuth follows from coordinates.
  struct Reference {
    int set_up = -1;
    std::string name;
    double reading = kNotGiven;
  };
  void finish_reference();
  void orient_set_ups();
  std::string reference_;
  double reference_reading_ = kNotGiven;
  std::vector<Reference> references_;
  std::size_t records_ = 0;
};

double GeodimeterReader::length(std::string_view text, const char* what) {
  if (const auto value = text::parse_number(text)) return *value * metres_;
  builder_.skip(line_, 1, text, what);
  return kNotGiven;
}

double GeodimeterReader::angle(std::string_view text) {
  has_angles_ = true;
  const auto value = text::parse_number(text);
  if (value && std::abs(*value) < 7000) {
    if (angle_unit_ == '1') return gon_to_rad(*value);
    if (angle_unit_ == '3') return degrees_to_rad(*value);
    if (angle_unit_ == '4') return *value * std::numbers::pi / 3200;
    if (const auto packed = packed_degrees_to_rad(*value)) return *packed;
  }
  builder_.skip(line_, 1, text, angle_unit_ == '2' ? "an angle D.MMSS" : "an angle");
  return kNotGiven;
}

void GeodimeterReader::read_units(std::string_view value) {
  if (value.size() < 2 || value[0] < '1' || value[0] > '4')
    return builder_.skip(line_, 1, value,
                         "the units of label 23, e.g. 1112: 1 gon, 2 D.MMSS, 3 degrees, 4 mil; 1 m, 2 ft");
  angle_unit_ = value[0];
  if (value[1] != '1' && value[1] != '2') builder_.skip(line_, 1, value, "1 (m) or 2 (ft) as the second digit");
  metres_ = value[1] == '2' ? kFoot : 1.0;
  has_units_ = true;
  builder_.survey.info.angles_in_degrees = angle_unit_ != '1';
}

void GeodimeterReader::add_face(double circle, double zenith, int face, bool with_distance) {
  if (std::isnan(circle) && std::isnan(zenith) && !with_distance) return;
  Sighting sighting;
  sighting.to = target_.name;
  sighting.source = target_.source;
  sighting.direction = circle;
  sighting.zenith_angle = zenith;
  sighting.face = face;
  sighting.target_height = std::isnan(target_.height) ? signal_height_ : target_.height;
  if (with_distance) {
    sighting.slope_distance = target_.slope;
    if (std::isnan(target_.slope)) {
      sighting.horizontal_distance = target_.horizontal;
      sighting.distance_corrections.push_back("reduced by the instrument");
    }
  }
  for (double* distance : {&sighting.slope_distance, &sighting.horizontal_distance})
    if (*distance < 0 || *distance > 1e5) {
      builder_.skip(target_.source.line, 1, target_.name, "a distance between 0 and 100 km");
      *distance = kNotGiven;
    }
  if (builder_.add(sighting)) measured_.insert(target_.name);
}

// The mean (7, 8) repeats what the faces have; alone it is the reading.
void GeodimeterReader::finish_target() {
  if (!target_.name.empty()) {
    const bool by_faces = !std::isnan(target_.circle_1) || !std::isnan(target_.circle_2);
    if (by_faces) {
      add_face(target_.circle_1, std::isnan(target_.zenith_1) ? target_.zenith : target_.zenith_1, 1, true);
      add_face(target_.circle_2, target_.zenith_2, 2, std::isnan(target_.circle_1));
    } else {
      add_face(target_.circle, target_.zenith, 0, true);
    }
    if (!target_.code.empty()) {
      Point& point = builder_.point(target_.name, target_.source);
      if (point.code.empty()) point.code = target_.code;
    }
  }
  target_ = {};
}

void GeodimeterReader::finish_reference() {
  if (!reference_.empty() && !std::isnan(reference_reading_) && builder_.current_set_up() >= 0)
    references_.push_back({builder_.current_set_up(), reference_, reference_reading_});
  reference_.clear();
  reference_reading_ = kNotGiven;
}

void GeodimeterReader::orient_set_ups() {
  for (const Reference& r : references_) {
    SetUp& set_up = builder_.survey.set_ups[r.set_up];
    if (!builder_.has_point(r.name)) continue;
    const Eigen::Vector3d d = builder_.point(r.name, {}).coordinates - builder_.point(set_up.station, {}).coordinates;
    if (d.head<2>().norm() > 0.1) set_up.stated_orientation = wrap_to_circle(std::atan2(d.x(), d.y()) - r.reading);
  }
}

void GeodimeterReader::finish_point() {
  // Behind readings, and of a station that may be a free one, they are what came out; alone they were keyed in.
  if (!point_.empty() && !at_.array().isNaN().all()) {
    if (is_station_ || measured_.contains(point_))
      builder_.give_coordinates(point_, at_, builder_.at(line_, 1));
    else
      builder_.know_coordinates(point_, at_, builder_.at(line_, 1));
  }
  at_.setConstant(kNotGiven);
}

void GeodimeterReader::read_label(long long label, std::string_view value) {
  ++records_;
  switch (label) {
    case 2:
      finish_target();
      finish_point();
      finish_reference();
      point_ = std::string(value), is_station_ = true;
      if (value.empty()) return builder_.skip(line_, 1, "2=", "the name of the station");
      builder_.start_set_up(point_, instrument_height_ = kNotGiven, builder_.at(line_, 1));
      return;
    case 3:
      instrument_height_ = length(value, "an instrument height");
      if (builder_.current_set_up() >= 0)
        builder_.survey.set_ups[builder_.current_set_up()].instrument_height = instrument_height_;
      return;
    case 5:
    case 62:
      finish_target();
      finish_point();
      point_ = target_.name = std::string(value), is_station_ = false;
      if (label == 62) finish_reference(), reference_ = point_;
      target_.source = builder_.at(line_, 1);
      return;
    case 4:
      target_.code = std::string(value);
      return;
    case 6:
      signal_height_ = length(value, "a signal height");
      return;
    case 7:
      target_.circle = angle(value);
      return;
    case 21:
      reference_reading_ = angle(value);
      return;
    case 24:
      target_.circle_1 = angle(value);
      return;
    case 17:
      target_.circle_2 = angle(value);
      return;
    case 8:
      target_.zenith = angle(value);
      return;
    case 25:
      target_.zenith_1 = angle(value);
      return;
    case 18:
      target_.zenith_2 = angle(value);
      return;
    case 9:
      target_.slope = length(value, "a slope distance");
      return;
    case 11:
      target_.horizontal = length(value, "a horizontal distance");
      return;
    case 37:
      at_.y() = length(value, "N");
      return;
    case 38:
      at_.x() = length(value, "E");
      return;
    case 39:
      at_.z() = length(value, "H");
      return;
    case 23:
      return read_units(value);
    case 50:
      builder_.survey.info.title = std::string(value);
      return;
    default:
      return;  // labels of the job, of differences and of what is computed
  }
}

// Without label 23 the readings themselves must show it: D.MMSS has no 60 minutes, a full circle no 390 degrees, and
// zenith angles of both faces add up to one.
void GeodimeterReader::find_unit(const std::vector<text::Line>& lines) {
  bool packed = true, beyond_degrees = false, any = false;
  double zenith = kNotGiven, gon = 0, degrees = 0;
  for (const text::Line& line : lines) {
    const std::size_t equals = line.text.find('=');
    if (equals == std::string_view::npos) continue;
    const auto label = text::parse_integer(text::trim(line.text.substr(0, equals)));
    const auto value = text::parse_number(text::trim(line.text.substr(equals + 1)));
    if (label == 23) return;
    const bool circle = label == 7 || label == 17 || label == 24, vertical = label == 8 || label == 18 || label == 25;
    if (!value || (!circle && !vertical)) continue;
    any = true;
    packed &= packed_degrees_to_rad(*value).has_value();
    beyond_degrees |= *value >= 360;
    if (label == 25) zenith = *value;
    if (label == 18) gon += std::abs(zenith + *value - 400) < 1, degrees += std::abs(zenith + *value - 360) < 1;
  }
  if (!any || (packed && !beyond_degrees)) return;
  if (!beyond_degrees && gon == degrees)
    throw SurveyReadError(builder_.at(1), "angles that are no D.MMSS, without their unit",
                          "label 23, e.g. 23=1112 (1 gon, 2 D.MMSS, 3 degrees, 4 mil; 1 m, 2 ft) in front");
  angle_unit_ = beyond_degrees || gon > degrees ? '1' : '3';
  has_units_ = true;
  builder_.survey.info.angles_in_degrees = angle_unit_ != '1';
  builder_.warn(std::string("the file has no label 23; its angles can only be in ") +
                (angle_unit_ == '1' ? "gon" : "degrees") + ", metres are assumed");
}

SurveyObservations GeodimeterReader::read() {
  const std::vector<text::Line> lines = text::split_lines(decoded_.text);
  find_unit(lines);
  for (const text::Line& line : lines) {
    line_ = line.number;
    const std::string_view text = text::trim(line.text);
    if (text.empty() || text == "?") continue;
    const std::size_t equals = text.find('=');
    const auto label = text::parse_integer(text.substr(0, equals));
    if (equals == std::string_view::npos || !label || *label < 0 || *label > 999)
      builder_.skip(line_, 1, text, "a label and a value, as in 5=P1");
    else
      read_label(*label, text::trim(text.substr(equals + 1)));
  }
  finish_target();
  finish_point();
  finish_reference();
  orient_set_ups();
  if (has_angles_ && !has_units_) builder_.warn("the file has no label 23; D.MMSS and metres are assumed");
  return builder_.finish(std::to_string(records_) + " labels without sightings or coordinates",
                         records_ == 0 ? understood_formats() : "labels 5 and 7, 8, 9 or 37, 38, 39");
}

}  // namespace

SurveyObservations read_geodimeter(std::string_view bytes, const std::string& file) {
  return GeodimeterReader(bytes, file).read();
}

}  // namespace plumbline::survey
