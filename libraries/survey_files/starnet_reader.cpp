#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "survey_files/starnet.hpp"
#include "survey_files/survey_builder.hpp"
#include "text/text.hpp"

namespace plumbline::survey {
namespace {

constexpr double kHeld = 1e-6;  // [m, rad] standard deviation of what '!' holds
constexpr double kSecond = std::numbers::pi / 180 / 3600;

using Parts = std::vector<std::string_view>;
using enum ObservationKind;

class StarNetReader {
 public:
  StarNetReader(std::string_view bytes, const std::string& file)
      : decoded_(formats::decode_text(bytes)), builder_(file, "starnet") {}
  SurveyObservations read();

 private:
  void read_line(std::string_view text);
  void read_option(const Parts& parts);
  void read_coordinates(const Parts& parts);
  void read_elevation(const Parts& parts);
  void read_measured(std::string_view code, const Parts& parts);
  void read_direction(std::string_view code, const Parts& parts);
  void read_traverse(std::string_view code, const Parts& parts);
  void read_levelled(const Parts& parts);
  bool names(std::string_view joined, std::size_t count, std::vector<std::string>& out);
  /// Values of `kinds`, their standard deviations, HI/HT; each becomes an observation like `like`.
  void take(const Parts& parts, std::size_t first, const std::vector<ObservationKind>& kinds, Observation like);
  std::vector<ObservationKind> polar() const;
  std::optional<double> angle(std::string_view text) const;
  std::optional<double> bearing(std::string_view text) const;
  std::optional<double> value_of(std::string_view text, ObservationKind kind) const;
  std::optional<double> sigma_of(std::string_view text, ObservationKind kind) const;
  void reject(std::string_view found, const std::string& expected) { builder_.skip(line_, 1, found, expected); }

  formats::DecodedText decoded_;
  SurveyBuilder builder_;
  int line_ = 0;
  double metres_ = 1;
  enum class AngleUnit { dms, gon, degrees } unit_ = AngleUnit::dms;
  bool east_first_ = false, has_order_ = false, from_at_to_ = false, three_ = true, has_dimension_ = false,
       delta_ = false;
  std::string at_, backsight_;  // of the direction set or traverse
  Observation pending_like_;    // of the traverse line that waits for its foresight
  std::string pending_, line_text_;
  char separator_ = '-';  // between the names of stations
  std::size_t records_ = 0;
  bool used_order_ = false, used_angles_ = false;
};

bool is_angle_kind(ObservationKind kind) {
  return kind == direction || kind == zenith_angle || kind == ObservationKind::angle || kind == azimuth;
}

std::optional<double> StarNetReader::angle(std::string_view text) const {
  if (unit_ == AngleUnit::gon) {
    const auto value = formats::parse_number(text);
    return value ? std::optional(gon_to_rad(*value)) : std::nullopt;
  }
  const auto parts = formats::split(text, '-');
  if (parts.size() == 3 && !parts[0].empty()) {
    const auto d = formats::parse_number(parts[0]), m = formats::parse_number(parts[1]),
               s = formats::parse_number(parts[2]);
    if (!d || !m || !s || *d < 0 || *m < 0 || *m >= 60 || *s < 0 || *s >= 60 || *d > 1e4) return std::nullopt;
    return degrees_to_rad(*d + *m / 60 + *s / 3600);
  }
  const auto value = formats::parse_number(text);
  if (!value) return std::nullopt;
  return unit_ == AngleUnit::degrees ? std::optional(degrees_to_rad(*value)) : packed_degrees_to_rad(*value);
}

// N12-34-56E, or an azimuth.
std::optional<double> StarNetReader::bearing(std::string_view text) const {
  if (text.size() < 3) return angle(text);
  const std::string ends = formats::to_lower(std::string{text.front(), text.back()});
  if (ends[0] != 'n' && ends[0] != 's') return angle(text);
  const auto size = angle(text.substr(1, text.size() - 2));
  if (!size || (ends[1] != 'e' && ends[1] != 'w')) return std::nullopt;
  const double from_north = ends[0] == 'n' ? *size : std::numbers::pi - *size;
  return wrap_to_circle(ends[1] == 'e' ? from_north : -from_north);
}

std::optional<double> StarNetReader::value_of(std::string_view text, ObservationKind kind) const {
  if (kind == azimuth) return bearing(text);
  if (is_angle_kind(kind)) return angle(text);
  const auto value = formats::parse_number(text);
  return value ? std::optional(*value * metres_) : std::nullopt;
}

std::optional<double> StarNetReader::sigma_of(std::string_view text, ObservationKind kind) const {
  if (text == "&") return kNotGiven;
  if (text == "!") return kHeld;
  if (text == "*") return 0.0;  // free: it takes no part
  const auto value = formats::parse_number(text);
  if (!value || *value <= 0) return std::nullopt;
  if (!is_angle_kind(kind)) return *value * metres_;
  return unit_ == AngleUnit::gon ? gon_to_rad(*value / 1000) : *value * kSecond;  // mgon or seconds
}

bool StarNetReader::names(std::string_view joined, std::size_t count, std::vector<std::string>& out) {
  out.clear();
  for (const auto part : formats::split(joined, separator_)) out.emplace_back(formats::trim(part));
  if (out.size() == count && std::none_of(out.begin(), out.end(), [](const auto& n) { return n.empty(); })) return true;
  reject(joined, std::to_string(count) + " station names joined by '" + separator_ + "'");
  return false;
}

// Slope distance and zenith angle, or horizontal distance and height difference.
std::vector<ObservationKind> StarNetReader::polar() const {
  if (!three_) return {horizontal_distance};
  return delta_ ? std::vector{horizontal_distance, height_difference} : std::vector{slope_distance, zenith_angle};
}

void StarNetReader::take(const Parts& parts, std::size_t first, const std::vector<ObservationKind>& kinds,
                         Observation like) {
  const std::size_t n = kinds.size();
  if (parts.size() < first + n) return reject(parts[0], std::to_string(n) + " values behind the stations");
  std::size_t end = parts.size();
  if (end > first + n && parts[end - 1].find('/') != std::string_view::npos) {
    const auto heights = formats::split(parts[--end], '/');
    const auto hi = formats::parse_number(heights[0]), ht = formats::parse_number(heights.back());
    if (heights.size() != 2 || !hi || !ht) return reject(parts[end], "HI/HT, the heights of instrument and target");
    like.instrument_height = *hi * metres_;
    like.target_height = *ht * metres_;
  }
  if (end > first + 2 * n) return reject(parts[first + 2 * n], "a standard deviation for each value, then HI/HT");
  std::vector<Observation> made;
  for (std::size_t i = 0; i < n; ++i) {
    Observation o = like;
    o.kind = kinds[i];
    if (o.kind != ObservationKind::angle) o.second_to.clear();
    const std::string_view text = parts[first + i];
    if (text == "?" || text == "*") continue;  // not measured
    const auto value = value_of(text, o.kind);
    const bool is_distance = o.kind == slope_distance || o.kind == horizontal_distance;
    if (!value || (is_distance && (*value <= 0 || *value > 1e6)))
      return reject(text, is_distance             ? "a distance above zero"
                          : is_angle_kind(o.kind) ? "an angle as 123-45-56.7"
                                                  : "a number");
    o.value = *value;
    if (first + n + i < end) {
      const auto sigma = sigma_of(parts[first + n + i], o.kind);
      if (!sigma) return reject(parts[first + n + i], "a standard deviation above zero, '&', '!' or '*'");
      if (*sigma == 0) continue;
      o.sigma = *sigma;
    }
    made.push_back(std::move(o));
  }
  for (Observation& o : made) {
    if (o.kind == ObservationKind::angle) {
      // From at, left arm, right arm. The rest of the line goes to the right arm.
      builder_.add(std::move(o));
      continue;
    }
    if (!like.second_to.empty()) o.to = like.second_to;
    builder_.add(std::move(o));
  }
}

void StarNetReader::read_option(const Parts& parts) {
  const std::string option = formats::to_lower(parts[0]);
  const auto is_option = [&](const char* name) { return std::string(name).starts_with(option) && option.size() >= 2; };
  std::vector<std::string> words;
  for (std::size_t i = 1; i < parts.size(); ++i) words.push_back(formats::to_lower(parts[i]));
  const auto has = [&](const char* word) { return std::find(words.begin(), words.end(), word) != words.end(); };
  if (option == ".3d" || option == ".2d") {
    three_ = option == ".3d";
    has_dimension_ = true;
  } else if (is_option(".units")) {
    if (has("meters") || has("metres")) metres_ = 1;
    if (has("feet") || has("feetinternational") || has("ifeet")) metres_ = kFoot;
    if (has("ussurveyfeet") || has("usfeet") || has("feetussurvey")) metres_ = kUsSurveyFoot;
    if (has("gons") || has("gon")) unit_ = AngleUnit::gon;
    if (has("dms")) unit_ = AngleUnit::dms;
    if (has("dd") || has("degrees")) unit_ = AngleUnit::degrees;
  } else if (is_option(".order")) {
    has_order_ = true;
    if (has("en")) east_first_ = true;
    if (has("ne")) east_first_ = false;
    if (has("fromatto")) from_at_to_ = true;
    if (has("atfromto")) from_at_to_ = false;
  } else if (is_option(".separator")) {
    if (parts.size() < 2 || parts[1].size() != 1) return reject(parts[0], ".SEPARATOR and one sign");
    separator_ = parts[1].front();
  } else if (is_option(".delta")) {
    delta_ = !has("off");
  } else if (is_option(".scale") || is_option(".mapmode") || is_option(".grid")) {
    builder_.warn("line " + std::to_string(line_) + ": the option " + std::string(parts[0]) + " is not applied");
  }
}

// C name N E [H] [sigmas]: '!' is fixed, '*' approximate.
void StarNetReader::read_coordinates(const Parts& parts) {
  std::vector<double> values;
  std::size_t i = 2;
  for (; i < parts.size() && values.size() < 3; ++i) {
    const auto value = formats::parse_number(parts[i]);
    if (!value) break;
    values.push_back(*value * metres_);
  }
  if (parts.size() < 4 || values.size() < 2) return reject(parts[0], "C, a name, two or three coordinates");
  used_order_ = true;
  // "C P 100 200 ! !" is of the plane; "C P 100 200 5 0.01 0.01 0.01" of space.
  const bool has_height = values.size() == 3;
  if (!has_dimension_ && !has_height) three_ = false;
  const Eigen::Vector3d at(values[east_first_ ? 0 : 1], values[east_first_ ? 1 : 0],
                           has_height ? values[2] : kNotGiven);
  const SourcePosition source = builder_.at(line_, 1);
  const std::string id(parts[1]);
  builder_.give_coordinates(id, at, source);
  CoordinateGroup group;
  std::vector<double> sigmas;
  for (std::size_t k = 0; k < values.size() && i + k < parts.size(); ++k) {
    const int axis = k == 2 ? 2 : east_first_ ? static_cast<int>(k) : 1 - static_cast<int>(k);
    const auto sigma = sigma_of(parts[i + k], height_difference);
    if (!sigma) return reject(parts[i + k], "a standard deviation, '!' or '*'");
    if (*sigma == kHeld) builder_.point(id, source).roles[static_cast<std::size_t>(axis)] = CoordinateRole::fixed;
    if (std::isnan(*sigma) || *sigma == 0 || *sigma == kHeld) continue;
    group.components.push_back({id, axis});
    sigmas.push_back(*sigma);
  }
  if (sigmas.empty()) return;
  const auto n = static_cast<Eigen::Index>(sigmas.size());
  group.values.resize(n);
  group.covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    group.values[k] = at[group.components[static_cast<std::size_t>(k)].axis];
    group.covariance(k, k) = sigmas[static_cast<std::size_t>(k)] * sigmas[static_cast<std::size_t>(k)];
  }
  group.is_control = true;
  group.source = source;
  builder_.survey.coordinates.push_back(std::move(group));
}

void StarNetReader::read_elevation(const Parts& parts) {
  const auto value = parts.size() > 2 ? formats::parse_number(parts[2]) : std::nullopt;
  if (!value) return reject(parts[0], "E, a name, a height");
  const std::string id(parts[1]);
  const SourcePosition source = builder_.at(line_, 1);
  builder_.give_coordinates(id, {kNotGiven, kNotGiven, *value * metres_}, source);
  if (parts.size() > 3 && parts[3] == "!") builder_.point(id, source).roles[2] = CoordinateRole::fixed;
}

void StarNetReader::read_measured(std::string_view code, const Parts& parts) {
  const bool three_names = code == "A" || code == "M" || code == "SS";
  std::vector<std::string> ids;
  if (parts.size() < 3) return reject(parts[0], "stations and values");
  if (!names(parts[1], three_names ? 3 : 2, ids)) return;
  Observation like;
  like.source = builder_.at(line_, 1);
  if (three_names) {
    used_angles_ = true;
    like.from = ids[from_at_to_ ? 1 : 0];
    like.to = ids[from_at_to_ ? 0 : 1];
    like.second_to = ids[2];
    if (like.from == like.to || like.from == ids[2] || like.to == ids[2]) return reject(parts[1], "three stations");
  } else {
    like.from = ids[0];
    like.to = ids[1];
    if (like.from == like.to) return reject(parts[1], "two stations");
  }
  std::vector<ObservationKind> kinds;
  const auto vertical = delta_ ? height_difference : zenith_angle;
  if (code == "A") kinds = {ObservationKind::angle};
  if (code == "D") kinds = {three_ && !delta_ ? slope_distance : horizontal_distance};
  if (code == "V") kinds = {vertical};
  if (code == "B") kinds = {azimuth};
  if (code == "DV") kinds = polar();
  if (code == "BM" || code == "M" || code == "SS") {
    kinds = polar();
    kinds.insert(kinds.begin(), code == "BM" ? azimuth : ObservationKind::angle);
  }
  take(parts, 2, kinds, std::move(like));
}

// DB at; DN to direction; DM to direction distance zenith; DE
void StarNetReader::read_direction(std::string_view code, const Parts& parts) {
  if (code == "DE") return at_.clear();
  if (parts.size() < 2) return reject(parts[0], "a station");
  if (code == "DB") {
    at_ = std::string(parts[1]);
    builder_.start_set_up(at_, kNotGiven, builder_.at(line_, 1));
    return;
  }
  if (at_.empty()) return reject(parts[0], "DB with the occupied station before it");
  Observation like;
  like.from = at_;
  like.to = std::string(parts[1]);
  like.set_up = builder_.current_set_up();
  like.source = builder_.at(line_, 1);
  if (like.to == at_) return reject(parts[1], "another point than the station");
  std::vector<ObservationKind> kinds = {direction};
  if (code == "DM")
    for (const ObservationKind kind : polar()) kinds.push_back(kind);
  take(parts, 2, kinds, std::move(like));
}

// TB backsight; T station angle distance zenith, each to the station of the next line; TE station [angle closing].
void StarNetReader::read_traverse(std::string_view code, const Parts& parts) {
  if (parts.size() < 2) return reject(parts[0], "a station");
  const std::string station(parts[1]);
  if (code == "TB") {
    backsight_ = station;
    at_.clear();
    pending_.clear();
    return;
  }
  if (!pending_.empty()) {
    Observation like = pending_like_;
    like.second_to = station;
    const Parts of_line = formats::split_blanks(pending_);
    const int here = line_;
    line_ = like.source.line;
    auto kinds = polar();
    kinds.insert(kinds.begin(), ObservationKind::angle);
    take(of_line, 2, kinds, like);
    line_ = here;
    pending_.clear();
  }
  if (!at_.empty()) backsight_ = at_;
  at_ = station;
  pending_like_ = {};
  pending_like_.from = at_;
  pending_like_.to = backsight_;
  pending_like_.source = builder_.at(line_, 1);
  if (code == "T") {
    if (backsight_.empty() || backsight_ == at_) return reject(parts[0], "TB with the backsight before it");
    pending_ = line_text_;
    return;
  }
  if (parts.size() >= 4 && !backsight_.empty()) {  // TE: the closing angle
    pending_like_.second_to = std::string(parts[3]);
    const Parts closing = {parts[0], parts[1], parts[2]};
    if (pending_like_.second_to != at_ && pending_like_.second_to != backsight_)
      take(closing, 2, {ObservationKind::angle}, pending_like_);
  }
  at_.clear();
  backsight_.clear();
}

// L from-to difference [length or standard deviation]: STAR*NET reads the last as a length unless '.LWEIGHT' says
// otherwise; a number below a metre is no length.
void StarNetReader::read_levelled(const Parts& parts) {
  std::vector<std::string> ids;
  if (parts.size() < 3 || !names(parts[1], 2, ids)) return;
  Observation o;
  o.kind = height_difference;
  o.from = ids[0];
  o.to = ids[1];
  o.source = builder_.at(line_, 1);
  const auto value = formats::parse_number(parts[2]);
  if (!value || o.from == o.to) return reject(parts[2], "a height difference");
  o.value = *value * metres_;
  if (parts.size() > 3) {
    const auto last = formats::parse_number(parts[3]);
    if (!last || *last <= 0) return reject(parts[3], "the length of the line");
    (*last * metres_ < 1 ? o.sigma : o.levelling_length) = *last * metres_;
  }
  builder_.add(std::move(o));
}

void StarNetReader::read_line(std::string_view text) {
  const Parts parts = formats::split_blanks(text);
  ++records_;
  if (parts[0].front() == '.') return read_option(parts);
  std::string code;
  for (const char c : parts[0]) code += c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
  line_text_ = std::string(text);
  if (code == "C") return read_coordinates(parts);
  if (code == "E") return read_elevation(parts);
  if (code == "L") return read_levelled(parts);
  if (code == "DB" || code == "DN" || code == "DM" || code == "DE") return read_direction(code, parts);
  if (code == "TB" || code == "T" || code == "TE") return read_traverse(code, parts);
  for (const char* known : {"A", "D", "V", "DV", "B", "M", "BM", "SS"})
    if (code == known) return read_measured(code, parts);
  --records_;
  reject(parts[0],
         "a data type such as C, M, A, D, V, B, DB, DN, L, T (GPS vectors and geodetic positions are not read)");
}

SurveyObservations StarNetReader::read() {
  std::string joined;
  for (const formats::Line& line : formats::split_lines(decoded_.text)) {
    std::string_view text = line.text;
    text = text.substr(0, std::min(text.find('#'), text.find('\'')));
    text = formats::trim(text);
    if (text.empty()) continue;
    if (joined.empty()) line_ = line.number;
    joined += (joined.empty() ? "" : " ") + std::string(text);
    if (joined.back() == '&' && joined.size() > 1 && joined[joined.size() - 2] == ' ' && joined.size() < 4096 &&
        text.size() > 1) {
      // A lone '&' is a standard deviation; at the end of a line it continues it if the line is no data line yet.
      const auto parts = formats::split_blanks(joined);
      if (parts.size() <= 3) {
        joined.pop_back();
        continue;
      }
    }
    read_line(joined);
    joined.clear();
  }
  if (used_order_ && !has_order_)
    builder_.warn("the file has no .ORDER: coordinates are taken as N, E; say .ORDER EN if they are E, N");
  if (used_angles_ && !has_order_) builder_.warn("the file has no .ORDER: angles are taken as At-From-To");
  return builder_.finish(std::to_string(records_) + " lines without coordinates or measurements",
                         records_ == 0 ? understood_formats() : "data lines such as C, M, A, D");
}

}  // namespace

SurveyObservations read_starnet(std::string_view bytes, const std::string& file) {
  return StarNetReader(bytes, file).read();
}

}  // namespace plumbline::survey
