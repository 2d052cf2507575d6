#include "survey/files/krumm_reader.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline::survey {
namespace {

constexpr double kSecond = std::numbers::pi / 180 / 3600;

}  // namespace

void KrummReader::read_coordinates(const Parts& parts) {
  if (parts.size() < 2 || parts.size() > 4) return reject(line_text_, "a point and one to three coordinates");
  Eigen::Vector3d at = Eigen::Vector3d::Constant(kNotGiven);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto value = text::parse_number(parts[i]);
    if (!value) return reject(parts[i], "a coordinate [m]");
    // A lone coordinate is a height.
    at[parts.size() == 2 ? 2 : static_cast<Eigen::Index>(i) - 1] = *value;
  }
  add_point(parts[0], at);
}

void KrummReader::add_point(std::string_view name, const Eigen::Vector3d& at) {
  // "Six#Mile@1": the number of the figure.
  const std::size_t mark = name.find('@');
  const bool numbered = mark != std::string_view::npos && text::parse_number(name.substr(mark + 1));
  const std::string id(numbered ? name.substr(0, mark) : name);
  builder_.give_coordinates(id, at, builder_.at(line_, 1));
  Point& point = builder_.point(id, builder_.at(line_, 1));
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::isnan(at[static_cast<Eigen::Index>(axis)])) point.roles[axis] = CoordinateRole::unused;
}

// The plane of the network: the transverse Mercator projection about a meridian. Observations are of this plane: the
// distances of Leick's networks fit it within 22 ppm, the ellipsoid within 371 ppm only.
void KrummReader::read_ellipsoid(const Parts& parts) {
  constexpr double kA = 6378137, kE2 = 0.00669438002290;  // GRS80; WGS84's differs in the eleventh digit
  const bool named = !parts.empty() && text::to_lower(parts[0]).starts_with("grs80");
  const std::size_t first = named ? 1 : 2;
  if (parts.size() != first + 2)
    return reject(line_text_, "the axis and the square of the eccentricity or grs80, a meridian and its scale");
  const auto a = named ? std::optional(kA) : text::parse_number(parts[0]);
  const auto e2 = named ? std::optional(kE2) : text::parse_number(parts[1]);
  const auto meridian = krumm_dms(parts[first]);
  const auto scale = text::parse_number(parts[first + 1]);
  if (!a || !e2 || std::abs(*a - kA) > 1e-3 || std::abs(*e2 - kE2) > 1e-10)
    return reject(line_text_, "the ellipsoid GRS80 or WGS84");
  if (!meridian || !scale || !(*scale > 0.9 && *scale < 1.1))
    return reject(parts[first], "a meridian in degrees, minutes and seconds, and the scale on it");
  plane_.emplace(*meridian, *scale);
  builder_.warn(
      "line " + std::to_string(line_) +
      ": latitudes and longitudes are drawn on the transverse Mercator plane that [Ellipsoid] says; distances "
      "and angles are taken as reduced to it");
}

void KrummReader::read_geodetic(const Parts& parts) {
  if (!plane_) return reject(line_text_, "[Ellipsoid] before latitudes and longitudes");
  if (parts.size() != 3) return reject(line_text_, "a point, its latitude and its longitude");
  const auto latitude = krumm_dms(parts[1]), longitude = krumm_dms(parts[2]);
  if (!latitude || !longitude || std::abs(*latitude) > std::numbers::pi / 2)
    return reject(parts[1],
                  "a latitude and a longitude as 44\xC2\xB0"
                  "51'42.44\"");
  const Eigen::Vector2d plan = plane_->forward({*latitude, *longitude, 0});
  add_point(parts[0], {plan.x(), plan.y(), kNotGiven});
}

// "x51": a point's axis; "51": all of its axes (-1), in a network of heights its height.
std::optional<std::pair<std::string, int>> KrummReader::component(std::string_view word) {
  if (word.size() > 1 && word.ends_with(',')) word.remove_suffix(1);
  const std::string all(word), rest(word.substr(1));
  const std::size_t axis = std::string_view("xyz").find(text::to_lower(word.substr(0, 1)));
  if (axis != std::string_view::npos && builder_.has_point(rest)) return std::pair{rest, static_cast<int>(axis)};
  if (builder_.has_point(all)) return std::pair{all, -1};
  reject(word, "x, y or z and the name of a point of [Coordinates], e.g. 'x51'");
  return std::nullopt;
}

// "fix x51 y51 z51 x37 ...": an axis and a point in each word; "dyn": a line each with its covariance.
void KrummReader::read_datum(const Parts& parts) {
  if (dynamic_ && parts.size() > 1) {
    const auto what = component(parts[0]);
    std::vector<double> values = numbers(parts, 1);
    if (!what || values.empty()) return;
    dynamic_rows_.push_back({what->first, what->second < 0 ? 2 : what->second, std::move(values), builder_.at(line_)});
    return;
  }
  for (const std::string_view part : parts) {
    const std::string word = text::to_lower(part);
    if (word == "fix" || word == "free" || word == "freie" || word == "fre" || word == "dyn") {
      datum_role_ = word == "fix" ? CoordinateRole::fixed : CoordinateRole::constrained;
      dynamic_ = word == "dyn";
      continue;
    }
    const auto what = component(part);
    if (!what) continue;
    Point& point = builder_.point(what->first, builder_.at(line_, 1));
    bool any = false;
    for (int axis = 0; axis < 3; ++axis) {
      if ((what->second >= 0 && axis != what->second) || std::isnan(point.coordinates[axis])) continue;
      point.roles[axis] = datum_role_;
      any = true;
    }
    if (!any) reject(part, "an axis for which [Coordinates] has a value");
  }
}

std::vector<double> KrummReader::numbers(const Parts& parts, std::size_t first) {
  std::vector<double> values;
  for (std::size_t i = first; i < parts.size(); ++i) {
    const auto value = text::parse_number(parts[i]);
    if (!value) {
      reject(parts[i], "a number");
      return {};
    }
    values.push_back(*value);
  }
  return values;
}

std::optional<double> KrummReader::value_of(std::string_view word, ObservationKind kind) const {
  if (!is_angle(kind)) return text::parse_number(word);
  if (section_.dms || word.find("\xC2\xB0") != std::string_view::npos) return krumm_dms(word);
  const auto gon = text::parse_number(word);
  return gon ? std::optional(gon_to_rad(*gon)) : std::nullopt;
}

std::optional<double> KrummReader::sigma_of(std::string_view word, ObservationKind kind) const {
  const bool seconds = word.ends_with('"') || section_.sigma_seconds;
  if (word.ends_with('"')) word.remove_suffix(1);
  const auto value = text::parse_number(word);
  if (!value || *value < 0) return std::nullopt;
  return !is_angle(kind) ? *value : seconds ? *value * kSecond : gon_to_rad(*value);
}

// Behind the value: sigma; sigma_c sigma_s; sigma, instrument height, target height; or all four.
bool KrummReader::read_rest(const Parts& parts, std::size_t first, Observation& observation) {
  const std::size_t count = parts.size() - first;
  const bool is_distance =
      observation.kind == ObservationKind::slope_distance || observation.kind == ObservationKind::horizontal_distance;
  if (count > 4 || (count == 2 && !is_distance)) {
    reject(line_text_, "at most two standard deviations and two heights behind the value");
    return false;
  }
  // What lines below take over when they give none is that of a line that was read, never of one that was refused.
  double constant = first_sigma_, second = second_sigma_;
  if (count > 0) {
    const auto given = sigma_of(parts[first], observation.kind);
    const auto other = count == 2 || count == 4 ? text::parse_number(parts[first + 1]) : std::optional(0.0);
    if (!given || !other || *other < 0) {
      reject(parts[first], "standard deviations that are not negative");
      return false;
    }
    constant = *given, second = *other;
  }
  if (count >= 3) {
    const auto instrument = text::parse_number(parts[parts.size() - 2]);
    const auto target = text::parse_number(parts[parts.size() - 1]);
    if (!instrument || !target) {
      reject(parts[parts.size() - 2], "instrument height and target height [m]");
      return false;
    }
    observation.instrument_height = *instrument;
    observation.target_height = *target;
  }
  observation.sigma = sigma_from(constant, second, observation);
  if (!std::isnan(constant) && !(observation.sigma > 0 && std::isfinite(observation.sigma))) {
    reject(line_text_, "a standard deviation above zero");
    return false;
  }
  first_sigma_ = constant, second_sigma_ = second;
  return true;
}

double KrummReader::sigma_from(double constant, double second, const Observation& observation) const {
  const bool is_distance =
      observation.kind == ObservationKind::slope_distance || observation.kind == ObservationKind::horizontal_distance;
  const double length = is_distance ? std::abs(observation.value) : 0;
  if (std::isnan(constant)) return is_angle(observation.kind) ? kNotGiven : sigma0_;
  switch (distance_sigma_) {
    case KrummDistanceSigma::squares:
      return std::sqrt(constant * constant + length * second * second);
    case KrummDistanceSigma::squares_of_km:
      return std::hypot(constant, length / 1000 * second);
    default:
      return constant + length / 1000 * second;
  }
}

void KrummReader::read_observation(const Parts& parts) {
  const ObservationKind kind = section_.kind;
  const bool is_three = kind == ObservationKind::angle;
  const std::size_t at = is_three ? 3 : 2;
  if (parts.size() <= at)
    return reject(line_text_, is_three ? "station, left, right, angle and perhaps its standard deviation"
                                       : "from, to, value and perhaps its standard deviation");
  Observation o;
  o.kind = kind;
  o.from = std::string(parts[0]);
  o.to = std::string(parts[1]);
  if (is_three) o.second_to = std::string(parts[2]);
  o.source = builder_.at(line_, 1);
  auto value = value_of(parts[at], kind);
  const bool is_distance = kind == ObservationKind::slope_distance || kind == ObservationKind::horizontal_distance;
  if (value && section_.from_horizon) value = std::numbers::pi / 2 - *value;
  if (!value || (is_distance && *value <= 0))
    return reject(parts[at], is_distance      ? "a distance above zero [m]"
                             : is_angle(kind) ? (section_.dms ? "an angle as 185\xC2\xB0"
                                                                "22'14\""
                                                              : "an angle [gon]")
                                              : "a height difference [m]");
  if (o.from == o.to || o.from == o.second_to || o.to == o.second_to)
    return reject(parts[1], "another point than the first one");
  o.value = *value;
  if (read_rest(parts, at + 1, o)) place(std::move(o));
}

// Directions of one station share its orientation; all else stands alone.
void KrummReader::place(Observation o) {
  if (o.kind == ObservationKind::direction) {
    const auto [known, is_new] = set_ups_.try_emplace(o.from, -1);
    if (is_new) known->second = builder_.start_set_up(o.from, kNotGiven, o.source);
    o.set_up = known->second;
  }
  builder_.add(std::move(o));
}

void KrummReader::read_sigma0(const Parts& parts) {
  const auto value = text::parse_number(parts[0]);
  const std::string_view unit = parts.size() > 1 ? parts[1] : std::string_view();
  if (!value || *value <= 0) return reject(parts[0], "a standard deviation above zero");
  if (unit == "gon" || unit == "mgon") return;  // says nothing of lengths
  sigma0_ = *value * (unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1.0);
}

void KrummReader::read_heading(std::string_view text) {
  const std::size_t close = text.find(']');
  const auto section = close == std::string_view::npos ? std::nullopt : krumm_section(text.substr(1, close - 1));
  in_section_ = true;
  section_ = section.value_or(KrummSection{});
  first_sigma_ = kNotGiven;
  second_sigma_ = 0;
  distance_sigma_ = krumm_distance_sigma(comment_);
  if (!section)
    reject(text, "one of the sections that are understood: coordinates, datum, and observations");
  else if (section->content == KrummContent::refused)
    reject(text,
           "coordinates and observations of a local plane or space, or latitude and longitude in degrees, minutes and "
           "seconds: other coordinates of an ellipsoid and angles in an inclined plane are not adjusted here");
  else if (section->content == KrummContent::unknown_scale)
    builder_.warn("line " + std::to_string(line_) + ": " + std::string(text) +
                  " asks for an unknown of the distances; give the adjustment scale_sigma or additive_constant_sigma");
}

void KrummReader::read_line(std::string_view text) {
  const auto parts = text::split_blanks(text);
  if (!in_section_) return reject(text, "a section such as [Coordinates] or [SpatialDistances] first");
  NetworkInfo& info = builder_.survey.info;
  switch (section_.content) {
    case KrummContent::coordinates:
      return section_.geodetic ? read_geodetic(parts) : read_coordinates(parts);
    case KrummContent::ellipsoid:
      return read_ellipsoid(parts);
    case KrummContent::datum:
      return read_datum(parts);
    case KrummContent::sigma0:
      return read_sigma0(parts);
    case KrummContent::observations:
      return read_observation(parts);
    case KrummContent::levelling:
      return read_levelling(parts);
    case KrummContent::correlated_distances:
      return read_correlated(parts);
    case KrummContent::baselines:
      return read_baseline(parts);
    case KrummContent::restrictions:
      return read_restriction(text);
    case KrummContent::title:
      if (info.title.empty()) info.title = std::string(text);
      return;
    case KrummContent::source:
      info.description += (info.description.empty() ? "" : "\n") + std::string(text);
      return;
    case KrummContent::passed_over:
    case KrummContent::unknown_scale:
    case KrummContent::refused:
      return;
  }
}

SurveyObservations KrummReader::read() {
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    line_ = line.number;
    line_text_ = line.text;
    std::string_view text = text::trim(line.text);
    if (text.empty() || text.front() == '#' || text.front() == '%') {
      comment_ += std::string(text) + ' ';
      continue;
    }
    // '#' is part of names, and begins a comment between blanks only.
    text = text.substr(0, std::min(text.find('%'), text.find(" #")));
    text = text::trim(text);
    if (text.front() == '[')
      read_heading(text);
    else
      read_line(text);
    comment_.clear();
  }
  finish_dynamic_datum();
  finish_correlated();
  orient_by_marks();
  return builder_.finish("no section with coordinates or distances", understood_formats());
}

SurveyObservations read_krumm(std::string_view bytes, const std::string& file) {
  return KrummReader(bytes, file).read();
}

}  // namespace plumbline::survey
