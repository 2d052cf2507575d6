#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/text/text.hpp"
#include "survey/files/field_books.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

using Parts = std::vector<std::string_view>;

class NikonReader {
 public:
  NikonReader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "nikon") {}
  SurveyObservations read();

 private:
  enum class AngleUnit { dms, gon, degrees, mil };
  enum class VerticalZero { zenith, horizon, compass };

  void read_comment(std::string_view text);
  void read_station(const Parts& parts);
  void read_sighting(const Parts& parts, int face);
  double height_of_target(std::string_view text, int face, const std::string& to);
  void read_coordinates(const Parts& parts);
  void begin(const std::string& station, double orientation);
  std::string_view part(const Parts& parts, std::size_t i) const {
    return i < parts.size() ? text::trim(parts[i]) : std::string_view();
  }
  double number(std::string_view text, const char* what);
  double length(std::string_view text, const char* what) { return metres_ * number(text, what); }
  double angle(std::string_view text, const char* what);

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  int line_ = 0;
  double metres_ = 1, instrument_height_ = kNotGiven;
  AngleUnit unit_ = AngleUnit::dms;
  VerticalZero zero_ = VerticalZero::zenith;
  bool east_first_ = false, has_units_ = false;
  std::string station_, backsight_;
  double azimuth_ = kNotGiven, circle_ = kNotGiven;  // of the backsight
  double azimuth_origin_ = 0;                        // half a circle where azimuths count from the south
  std::string last_target_;
  double last_height_ = kNotGiven;   // of it [m]
  double current_zero_ = kNotGiven;  // orientation of the set-up that sightings go to now
  std::size_t passed_over_ = 0, records_ = 0;
};

double NikonReader::number(std::string_view text, const char* what) {
  if (text.empty()) return kNotGiven;
  if (const auto value = text::parse_number(text)) return *value;
  builder_.skip(line_, 1, text, what);
  return kNotGiven;
}

double NikonReader::angle(std::string_view text, const char* what) {
  const double value = number(text, what);
  if (std::isnan(value)) return kNotGiven;
  if (std::abs(value) < 7000) {
    if (unit_ == AngleUnit::gon) return gon_to_rad(value);
    if (unit_ == AngleUnit::degrees) return degrees_to_rad(value);
    if (unit_ == AngleUnit::mil) return value * std::numbers::pi / 3200;
    if (const auto packed = packed_degrees_to_rad(value)) return *packed;
  }
  builder_.skip(line_, 1, text, what);
  return kNotGiven;
}

// "Angle Units: Gons": the units are said in words.
void NikonReader::read_comment(std::string_view text) {
  const std::string all = text::to_lower(text);
  const auto value_of = [&](const char* key) {
    const std::size_t at = all.find(key);
    return at == std::string::npos ? std::string() : all.substr(at + std::string_view(key).size());
  };
  if (const std::string v = value_of("dist units:"); !v.empty()) {
    has_units_ = true;
    if (v.find("f") == std::string::npos && v.find("met") == std::string::npos)
      builder_.skip(line_, 1, text, "the unit Metres, Feet or US Feet");
    metres_ = v.find("us") != std::string::npos && v.find("f") != std::string::npos ? kUsSurveyFoot
              : v.find("f") != std::string::npos                                    ? kFoot
                                                                                    : 1.0;
  }
  if (const std::string v = value_of("angle units:"); !v.empty()) {
    const auto is_one_of = [&](auto... names) { return ((v.find(names) != std::string::npos) || ...); };
    if (!is_one_of("gon", "dec", "mil", "ddd", "dms", "deg"))
      builder_.skip(line_, 1, text, "the unit Gons, DecDeg, MIL or DDDMMSS");
    unit_ = v.find("gon") != std::string::npos   ? AngleUnit::gon
            : v.find("dec") != std::string::npos ? AngleUnit::degrees
            : v.find("mil") != std::string::npos ? AngleUnit::mil
                                                 : AngleUnit::dms;
    builder_.survey.info.angles_in_degrees = unit_ != AngleUnit::gon;
  }
  for (const char* key : {"zero va:", "co,va:", " va:"})
    if (const std::string v = value_of(key); !v.empty() && all.find("tilt") == std::string::npos)
      zero_ = v.find("hor") != std::string::npos   ? VerticalZero::horizon
              : v.find("com") != std::string::npos ? VerticalZero::compass
                                                   : VerticalZero::zenith;
  if (const std::string v = value_of("zero azimuth:"); !v.empty()) {
    const auto origin = text::trim(v);
    azimuth_origin_ = origin.starts_with("s") ? std::numbers::pi : 0;
    if (!origin.starts_with("s") && !origin.starts_with("n")) builder_.skip(line_, 1, text, "North or South");
  }
  if (const std::string v = value_of("coord order:"); !v.empty()) east_first_ = text::trim(v).starts_with("enz");
  if (const std::string v = value_of("instrument:"); !v.empty() && builder_.survey.info.instrument.empty())
    builder_.survey.info.instrument = std::string(text::trim(text.substr(text.find(':') + 1)));
}

void NikonReader::begin(const std::string& station, double orientation) {
  builder_.start_set_up(station, instrument_height_, builder_.at(line_, 1));
  builder_.survey.set_ups.back().stated_orientation = orientation;
  current_zero_ = orientation;
}

// ST,station,,backsight,,instrument height,azimuth of the backsight,circle's reading to it
void NikonReader::read_station(const Parts& parts) {
  station_ = std::string(part(parts, 1));
  if (station_.empty()) return builder_.skip(line_, 1, "ST", "the name of the station");
  backsight_ = std::string(part(parts, 3));
  instrument_height_ = length(part(parts, 5), "an instrument height");
  azimuth_ = angle(part(parts, 6), "an azimuth") + azimuth_origin_;
  circle_ = angle(part(parts, 7), "a circle reading");
  // Without a backsight the zero is where somebody set it.
  begin(station_, backsight_.empty() ? kNotGiven : wrap_to_circle(azimuth_ - circle_));
}

// The second face of a set repeats the target, not always its height.
double NikonReader::height_of_target(std::string_view text, int face, const std::string& to) {
  const double height = length(text, "a target height");
  if (std::isnan(height) && face == 2 && to == last_target_) return last_height_;
  last_target_ = to;
  return last_height_ = height;
}

// pt,target height,slope distance,circle,vertical angle,time,code
void NikonReader::read_sighting(const Parts& parts, int face) {
  Sighting sighting;
  sighting.to = std::string(part(parts, 1));
  sighting.source = builder_.at(line_, 1);
  sighting.target_height = height_of_target(part(parts, 2), face, sighting.to);
  sighting.slope_distance = length(part(parts, 3), "a slope distance");
  sighting.direction = angle(part(parts, 4), "a circle reading");
  const double vertical = angle(part(parts, 5), "a vertical angle");
  sighting.zenith_angle = zero_ == VerticalZero::zenith ? vertical : std::numbers::pi / 2 - vertical;
  if (zero_ != VerticalZero::zenith) sighting.zenith_corrections.push_back("counted from the horizon in the file");
  sighting.face = face;
  if (sighting.to.empty() && face > 0) sighting.to = backsight_;
  if (sighting.to.empty()) {
    if (face == 0) builder_.skip(line_, 1, "SS", "the name of the target");
    return;  // the pointing with which a nameless backsight was set
  }
  // The backsight may have been read before its azimuth was set on the circle.
  const bool of_backsight = face > 0 && !backsight_.empty() && sighting.to == backsight_ && !std::isnan(azimuth_);
  if (of_backsight) {
    const double zero = azimuth_ - sighting.direction + (face == 2 ? std::numbers::pi : 0);
    const double off = std::remainder(zero - current_zero_, 2 * std::numbers::pi);
    if (std::abs(off) > 1e-3) begin(station_, wrap_to_circle(zero));
  } else if (!station_.empty() && !backsight_.empty() &&
             std::abs(std::remainder(azimuth_ - circle_ - current_zero_, 2 * std::numbers::pi)) > 1e-9) {
    begin(station_, wrap_to_circle(azimuth_ - circle_));
  }
  if (sighting.slope_distance < 0 || sighting.slope_distance > 1e5) {
    builder_.skip(line_, 1, part(parts, 3), "a distance between 0 and 100 km");
    sighting.slope_distance = kNotGiven;
  }
  if (!builder_.add(sighting)) return builder_.skip(line_, 1, parts[0], "at least one measured value");
  Point& point = builder_.point(sighting.to, sighting.source);
  if (point.code.empty() && parts.size() > 7) point.code = std::string(part(parts, 7));
}

// pt,,c1,c2,c3,code
void NikonReader::read_coordinates(const Parts& parts) {
  const std::string id(part(parts, 1));
  if (id.empty() || parts.size() < 5) return builder_.skip(line_, 1, parts[0], "a point and its coordinates");
  Eigen::Vector3d at(length(part(parts, 3), "a coordinate"), length(part(parts, 4), "a coordinate"),
                     length(part(parts, 5), "a height"));
  if (!east_first_) std::swap(at[0], at[1]);
  if (at.array().isNaN().all()) return;
  builder_.give_coordinates(id, at, builder_.at(line_, 1));
  if (parts[0] == "MP" || parts[0] == "UP") builder_.know_coordinates(id, at, builder_.at(line_, 1));
  Point& point = builder_.point(id, builder_.at(line_, 1));
  if (point.code.empty()) point.code = std::string(part(parts, 6));
}

SurveyObservations NikonReader::read() {
  static constexpr std::array<std::string_view, 5> kCoordinates = {"MP", "MC", "UP", "CC", "RE"};
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    line_ = line.number;
    const std::string_view text = text::trim(line.text);
    if (text.empty() || text == "?") continue;
    const Parts parts = text::split(text, ',');
    const std::string_view type = part(parts, 0);
    ++records_;
    if (type == "CO") {
      read_comment(text);
    } else if (type == "ST") {
      read_station(parts);
    } else if (type == "SS" || type == "F1" || type == "F2") {
      read_sighting(parts, type == "F1" ? 1 : type == "F2" ? 2 : 0);
    } else if (type == "CP") {  // a second name behind the first, then as SS
      Parts as_sighting = parts;
      if (as_sighting.size() > 2) as_sighting.erase(as_sighting.begin() + 2);
      read_sighting(as_sighting, 0);
    } else if (std::find(kCoordinates.begin(), kCoordinates.end(), type) != kCoordinates.end()) {
      read_coordinates(parts);
    } else if (type == "SO" || type.starts_with('*')) {
      ++passed_over_;
    } else {
      --records_;
      builder_.skip(line_, 1, type, "a record CO, ST, F1, F2, SS, CP, SO, MP, MC, UP, CC or RE");
    }
  }
  if (!has_units_ && records_ > 0) builder_.warn("the file does not say its units; metres and D.MMSS are assumed");
  if (passed_over_ > 0)
    builder_.warn(std::to_string(passed_over_) +
                  " records of staked-out (SO) or deleted (*) sightings were passed over");
  return builder_.finish(std::to_string(records_) + " records without coordinates or sightings",
                         records_ == 0 ? understood_formats() : "records SS, F1, F2 or MP, MC, UP");
}

}  // namespace

SurveyObservations read_nikon(std::string_view bytes, const std::string& file) {
  return NikonReader(bytes, file).read();
}

}  // namespace plumbline::survey
