#include "survey/files/starnet_reader.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "survey/files/starnet.hpp"

namespace plumbline::survey {
namespace {

constexpr double kHeld = 1e-6;       // [m] standard deviation of what '!' holds
constexpr double kHeldAngle = 5e-9;  // [rad], a thousandth of a second
constexpr double kSecond = std::numbers::pi / 180 / 3600;

}  // namespace

using enum ObservationKind;

bool is_angle_kind(ObservationKind kind) {
  return kind == direction || kind == zenith_angle || kind == ObservationKind::angle || kind == azimuth;
}

std::optional<double> StarNetReader::angle(std::string_view text) const {
  if (unit_ == AngleUnit::gon) {
    const auto value = text::parse_number(text);
    return value ? std::optional(gon_to_rad(*value)) : std::nullopt;
  }
  if (text.size() > 1 && text.front() == '-') {  // counted against the clock
    const auto size = angle(text.substr(1));
    return size && *size >= 0 ? std::optional(-*size) : std::nullopt;
  }
  const auto parts = text::split(text, '-');
  if (parts.size() == 3 && !parts[0].empty()) {
    const auto d = text::parse_number(parts[0]), m = text::parse_number(parts[1]), s = text::parse_number(parts[2]);
    if (!d || !m || !s || *d < 0 || *m < 0 || *m >= 60 || *s < 0 || *s >= 60 || *d > 1e4) return std::nullopt;
    return degrees_to_rad(*d + *m / 60 + *s / 3600);
  }
  const auto value = text::parse_number(text);
  if (!value) return std::nullopt;
  return unit_ == AngleUnit::degrees ? std::optional(degrees_to_rad(*value)) : packed_degrees_to_rad(*value);
}

// N12-34-56E, or an azimuth.
std::optional<double> StarNetReader::bearing(std::string_view text) const {
  if (text.size() < 3) return angle(text);
  const std::string ends = text::to_lower(std::string{text.front(), text.back()});
  if (ends[0] != 'n' && ends[0] != 's') return angle(text);
  const auto size = angle(text.substr(1, text.size() - 2));
  if (!size || (ends[1] != 'e' && ends[1] != 'w')) return std::nullopt;
  const double from_north = ends[0] == 'n' ? *size : std::numbers::pi - *size;
  return wrap_to_circle(ends[1] == 'e' ? from_north : -from_north);
}

std::optional<double> StarNetReader::value_of(std::string_view text, ObservationKind kind) const {
  if (kind == azimuth) return bearing(text);
  if (is_angle_kind(kind)) {
    const auto value = angle(text);
    if (!value || *value >= 0) return value;
    return kind == zenith_angle ? std::nullopt : std::optional(wrap_to_circle(*value));
  }
  const auto value = text::parse_number(text);
  return value ? std::optional(*value * metres_) : std::nullopt;
}

std::optional<double> StarNetReader::sigma_of(std::string_view text, ObservationKind kind) const {
  if (text == "&") return kNotGiven;
  if (text == "!") return is_angle_kind(kind) ? kHeldAngle : kHeld;
  if (text == "*") return 0.0;  // free: it takes no part
  const auto value = text::parse_number(text);
  if (!value || *value <= 0) return std::nullopt;
  if (!is_angle_kind(kind)) return *value * metres_;
  return unit_ == AngleUnit::gon ? gon_to_rad(*value / 1000) : *value * kSecond;  // mgon or seconds
}

// An option that changes what numbers mean and is not known here is refused: what follows it would be read wrongly.
void StarNetReader::read_option(const Parts& parts) {
  const std::string option = text::to_lower(parts[0]);
  const auto is_option = [&](const char* name) { return std::string(name).starts_with(option) && option.size() >= 2; };
  std::vector<std::string> words;
  for (std::size_t i = 1; i < parts.size(); ++i)
    for (const auto word : text::split(parts[i], ','))
      if (!word.empty()) words.push_back(text::to_lower(word));
  const auto has = [&](const char* word) { return std::find(words.begin(), words.end(), word) != words.end(); };
  if (option == ".3d" || option == ".2d") {
    if (!ends_at(parts, 1, ".2D and .3D stand alone")) return;
    three_ = option == ".3d";
    has_dimension_ = true;
  } else if (is_option(".units")) {
    read_units(words);
  } else if (is_option(".order")) {
    for (const std::string& word : words)
      if (word != "en" && word != "ne" && word != "fromatto" && word != "atfromto")
        return reject(word, ".ORDER with EN or NE, and AtFromTo or FromAtTo");
    has_order_ = true;
    if (has("en")) east_first_ = true;
    if (has("ne")) east_first_ = false;
    if (has("fromatto")) from_at_to_ = true;
    if (has("atfromto")) from_at_to_ = false;
  } else if (is_option(".separator")) {
    if (parts.size() < 2 || parts[1].size() != 1) return reject(parts[0], ".SEPARATOR and one sign");
    separator_ = parts[1].front();
  } else if (is_option(".delta")) {
    if (words.size() > 1 || (words.size() == 1 && !has("on") && !has("off")))
      return reject(words.back(), ".DELTA ON or .DELTA OFF");
    delta_ = !has("off");
  } else if (is_option(".data")) {
    if (has("on") == has("off")) return reject(line_text_, ".DATA ON or .DATA OFF");
    if (has("off")) off_since_ = line_;
  } else if (is_option(".lweight")) {
    read_level_weight(parts);
  } else if (option.starts_with(".add") && is_option(".addcentering")) {
    // OFF is the rule: a standard deviation that is written counts as it stands.
    if (words.size() > 1 || (words.size() == 1 && !has("on") && !has("off")))
      return reject(line_text_, ".ADDCENTERING ON or .ADDCENTERING OFF");
    add_centring_ = !has("off");
  } else if (option == ".gps") {
    finish_vector();
    read_gps_option(parts);
  } else if (is_option(".instrument")) {
    if (parts.size() > 2) return reject(parts[2], "the end of the line: .INST has one name");
    instrument_ = parts.size() == 2 ? builder_.instrument(std::string(parts[1])) : -1;
  } else {
    for (const char* of_the_listing :
         {".note", ".title", ".relative", ".ptolerance", ".ellipse", ".loststations", ".copycoordinates"})
      if (is_option(of_the_listing)) return;
    reject(parts[0],
           "one of the options that are applied: .2D, .3D, .UNITS, .ORDER, .SEPARATOR, .DELTA, .DATA, .INST, .LWEIGHT, "
           ".ADDCENTERING");
  }
}

void StarNetReader::read_units(const std::vector<std::string>& words) {
  static const std::map<std::string, double, std::less<>> lengths = {{"meters", 1},
                                                                     {"metres", 1},
                                                                     {"feet", kFoot},
                                                                     {"ifeet", kFoot},
                                                                     {"feetinternational", kFoot},
                                                                     {"internationalfeet", kFoot},
                                                                     {"ussurveyfeet", kUsSurveyFoot},
                                                                     {"usfeet", kUsSurveyFoot},
                                                                     {"feetus", kUsSurveyFoot},
                                                                     {"feetussurvey", kUsSurveyFoot}};
  static const std::map<std::string, AngleUnit, std::less<>> angles = {{"gons", AngleUnit::gon},
                                                                       {"gon", AngleUnit::gon},
                                                                       {"dms", AngleUnit::dms},
                                                                       {"dd", AngleUnit::degrees},
                                                                       {"degrees", AngleUnit::degrees}};
  has_units_ = true;
  if (words.empty())
    return reject(
        line_text_,
        "units: alone it says those of the project, which this file does not have; such as .UNITS FeetUS DMS");
  for (const std::string& word : words) {
    if (const auto length = lengths.find(word); length != lengths.end())
      metres_ = length->second;
    else if (const auto angle = angles.find(word); angle != angles.end())
      unit_ = angle->second;
    else
      reject(word, "a unit: Meters, Feet, FeetInternational, FeetUS; DMS, DD, Gons");
  }
}

// A word that nothing reads may be a standard deviation or a height that somebody meant: it is an error.
bool StarNetReader::ends_at(const Parts& parts, std::size_t most, const char* has) {
  if (parts.size() <= most) return true;
  reject(parts[most], std::string("the end of the line: ") + has);
  return false;
}

// Two in the plane, three in space, two of space where a flag follows them. Without .2D or .3D the numbers decide, but
// four of them may be N, E, H and a standard deviation, or N, E and two.
std::optional<std::size_t> StarNetReader::coordinates_of(const Parts& parts) {
  std::size_t numbers = 0;
  while (2 + numbers < parts.size() && text::parse_number(parts[2 + numbers])) ++numbers;
  const char* expected = three_ ? "C, a name, two or three coordinates" : "C, a name, two coordinates, as .2D says";
  if (numbers < 2) {
    reject(parts[0], expected);
    return std::nullopt;
  }
  if (has_dimension_) return three_ ? std::min<std::size_t>(numbers, 3) : 2;
  if (numbers == 4 && parts.size() == 6) {
    reject(parts[5], "'.2D' or '.3D' above: four numbers are N, E, H and a standard deviation, or N, E and two");
    return std::nullopt;
  }
  return std::min<std::size_t>(numbers, 3);
}

// C name N E [H] [sigmas]: '!' is fixed, '*' approximate. "C P 100 200 ! !" is of the plane; "C P 100 200 5 0.01 0.01
// 0.01" of space.
void StarNetReader::read_coordinates(const Parts& parts) {
  const auto count = coordinates_of(parts);
  if (!count || !ends_at(parts, 2 + 2 * *count, "C has a name, coordinates and a standard deviation for each")) return;
  std::vector<double> values;
  std::size_t i = 2;
  for (; values.size() < *count; ++i) values.push_back(*text::parse_number(parts[i]) * metres_);
  used_order_ = true;
  const bool has_height = values.size() == 3;
  if (!has_dimension_ && !has_height) three_ = false;
  const Eigen::Vector3d at(values[east_first_ ? 0 : 1], values[east_first_ ? 1 : 0],
                           has_height ? values[2] : kNotGiven);
  std::vector<int> axes, fixed;
  std::vector<double> sigmas;
  for (std::size_t k = 0; k < values.size() && i + k < parts.size(); ++k) {
    const int axis = k == 2 ? 2 : east_first_ ? static_cast<int>(k) : 1 - static_cast<int>(k);
    const auto sigma = sigma_of(parts[i + k], height_difference);
    if (!sigma) return reject(parts[i + k], "a standard deviation, '!' or '*'");
    if (*sigma == kHeld) fixed.push_back(axis);
    if (std::isnan(*sigma) || *sigma == 0 || *sigma == kHeld) continue;
    axes.push_back(axis);
    sigmas.push_back(*sigma);
  }
  const SourcePosition source = builder_.at(line_, 1);
  const std::string id(parts[1]);
  builder_.give_coordinates(id, at, source);
  Point& point = builder_.point(id, source);
  for (const int axis : fixed)  // not where the line contradicts an earlier one, which keeps its coordinates
    if (!std::isnan(point.coordinates[axis])) point.roles[axis] = CoordinateRole::fixed;
  if (axes.empty()) return;
  Eigen::VectorXd controlled(static_cast<Eigen::Index>(axes.size()));
  for (std::size_t k = 0; k < axes.size(); ++k) controlled[static_cast<Eigen::Index>(k)] = at[axes[k]];
  add_control(id, axes, controlled, sigmas);
}

void StarNetReader::add_control(const std::string& id, const std::vector<int>& axes, const Eigen::VectorXd& values,
                                const std::vector<double>& sigmas) {
  CoordinateGroup group;
  for (const int axis : axes) group.components.push_back({id, axis});
  group.values = values;
  const Eigen::Map<const Eigen::VectorXd> sigma(sigmas.data(), values.size());
  group.covariance = sigma.cwiseAbs2().asDiagonal();
  group.is_control = true;
  group.source = builder_.at(line_, 1);
  builder_.survey.coordinates.push_back(std::move(group));
}

void StarNetReader::read_elevation(const Parts& parts) {
  const auto value = parts.size() > 2 ? text::parse_number(parts[2]) : std::nullopt;
  if (!value) return reject(parts[0], "E, a name, a height");
  if (!ends_at(parts, 4, "E has a name, a height and its standard deviation")) return;
  const auto sigma = parts.size() > 3 ? sigma_of(parts[3], height_difference) : std::optional(0.0);
  if (!sigma) return reject(parts[3], "a standard deviation, '!' or '*'");
  const std::string id(parts[1]);
  const SourcePosition source = builder_.at(line_, 1);
  builder_.give_coordinates(id, {kNotGiven, kNotGiven, *value * metres_}, source);
  if (*sigma == kHeld) builder_.point(id, source).roles[2] = CoordinateRole::fixed;
  if (*sigma > 0 && *sigma != kHeld) add_control(id, {2}, Eigen::VectorXd::Constant(1, *value * metres_), {*sigma});
}

// "!!*" are three flags: a word of nothing else is one for each of its signs.
static StarNetReader::Parts words_of(std::string_view text) {
  StarNetReader::Parts parts;
  for (const std::string_view word : text::split_blanks(text)) {
    const bool flags = word.size() > 1 && word.size() <= 3 && word.find_first_not_of("!&*") == std::string_view::npos;
    if (!flags) parts.push_back(word);
    for (std::size_t i = 0; flags && i < word.size(); ++i) parts.push_back(word.substr(i, 1));
  }
  return parts;
}

void StarNetReader::read_line(std::string_view text) {
  const Parts parts = words_of(text);
  ++records_;
  line_text_ = std::string(text);
  if (off_since_ > 0) {
    if (text::to_lower(line_text_).starts_with(".da") && text::to_lower(parts.back()) == "on") {
      builder_.warn("lines " + std::to_string(off_since_) + " to " + std::to_string(line_) + " are off by .DATA OFF");
      off_since_ = 0;
    }
    return;
  }
  if (parts[0].front() == '.') return read_option(parts);
  std::string code;
  for (const char c : parts[0]) code += c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
  if (code == "G0" || code == "G1" || code == "G2" || code == "G3") return read_vector(code, parts);
  finish_vector();
  if (code == "C") return read_coordinates(parts);
  if (code == "E") return read_elevation(parts);
  if (code == "L") return read_levelled(parts);
  if (code == "DB" || code == "DN" || code == "DM" || code == "DE") return read_direction(code, parts);
  if (code == "TB" || code == "T" || code == "TE") return read_traverse(code, parts);
  for (const char* known : {"A", "D", "V", "DV", "B", "M", "BM", "SS"})
    if (code == known) return read_measured(code, parts);
  --records_;
  reject(parts[0], "a data type such as C, M, A, D, V, B, DB, DN, L, T, G1 (geodetic positions are not read)");
}

SurveyObservations StarNetReader::read() {
  std::string joined;
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    std::string_view text = line.text;
    text = text.substr(0, std::min(text.find('#'), text.find('\'')));
    text = text::trim(text);
    if (text.empty()) continue;
    if (joined.empty()) line_ = line.number;
    joined += (joined.empty() ? "" : " ") + std::string(text);
    if (joined.back() == '&' && joined.size() > 1 && joined[joined.size() - 2] == ' ' && joined.size() < 4096 &&
        text.size() > 1) {
      // A lone '&' is a standard deviation; at the end of a line it continues it if the line is no data line yet.
      const auto parts = text::split_blanks(joined);
      if (parts.size() <= 3) {
        joined.pop_back();
        continue;
      }
    }
    read_line(joined);
    joined.clear();
  }
  finish_vector();
  leave_out_side_shots();
  if (freed_ > 0)
    builder_.warn(
        std::to_string(freed_) +
        " values are freed by '*' and take no part, not in approximate coordinates either: where the network "
        "cannot be adjusted without them, give these, or let the values take part with a large standard deviation");
  if (off_since_ > 0) builder_.warn("from line " + std::to_string(off_since_) + " on the file is off by .DATA OFF");
  if (!has_units_ && (used_order_ || used_angles_))
    builder_.warn(
        "the file has no .UNITS: metres and degrees-minutes-seconds are taken; say such as .UNITS FeetUS DMS if the "
        "project had others");
  if (used_order_ && !has_order_)
    builder_.warn("the file has no .ORDER: coordinates are taken as N, E; say .ORDER EN if they are E, N");
  if (used_angles_ && !has_order_) builder_.warn("the file has no .ORDER: angles are taken as At-From-To");
  return builder_.finish(std::to_string(records_) + " lines without coordinates or measurements",
                         records_ == 0 ? understood_formats() : "data lines such as C, M, A, D");
}

SurveyObservations read_starnet(std::string_view bytes, const std::string& file) {
  return StarNetReader(bytes, file).read();
}

}  // namespace plumbline::survey
