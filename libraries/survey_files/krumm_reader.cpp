#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "survey_files/krumm.hpp"
#include "survey_files/krumm_sections.hpp"
#include "survey_files/survey_builder.hpp"
#include "text/text.hpp"

namespace plumbline::survey {
namespace {

constexpr double kCondition = 1e-6;  // [m], standard deviation that holds a restriction
constexpr double kSecond = std::numbers::pi / 180 / 3600;

using Parts = std::vector<std::string_view>;

class KrummReader {
 public:
  KrummReader(std::string_view bytes, const std::string& file)
      : decoded_(formats::decode_text(bytes)), builder_(file, "krumm") {}
  SurveyObservations read();

 private:
  void read_heading(std::string_view text);
  void read_line(std::string_view text);
  void read_coordinates(const Parts& parts);
  void read_datum(const Parts& parts);
  std::optional<std::pair<std::string, int>> component(std::string_view word);
  void read_observation(const Parts& parts);
  bool read_rest(const Parts& parts, std::size_t first, Observation& observation);
  void read_levelling(const Parts& parts);
  void read_correlated(const Parts& parts);
  void read_baseline(const Parts& parts);
  void read_restriction(std::string_view text);
  void read_sigma0(const Parts& parts);
  void place(Observation observation);
  void finish_dynamic_datum();
  void finish_correlated();
  void orient_by_marks();
  std::optional<double> value_of(std::string_view word, ObservationKind kind) const;
  std::optional<double> sigma_of(std::string_view word, ObservationKind kind) const;
  std::vector<double> numbers(const Parts& parts, std::size_t first);
  void reject(std::string_view found, const std::string& expected) {
    const std::size_t place = line_text_.find(found);
    builder_.skip(line_, place == std::string_view::npos ? 1 : static_cast<int>(place) + 1, found, expected);
  }
  static bool is_angle(ObservationKind kind) {
    return kind == ObservationKind::direction || kind == ObservationKind::angle || kind == ObservationKind::azimuth ||
           kind == ObservationKind::zenith_angle;
  }

  struct DynamicRow {
    std::string point;
    int axis = 2;
    std::vector<double> values;
    SourcePosition source;
  };

  formats::DecodedText decoded_;
  SurveyBuilder builder_;
  KrummSection section_;
  bool in_section_ = false;
  std::string comment_;  // the block of comments above
  KrummDistanceSigma distance_sigma_ = KrummDistanceSigma::squares;
  std::string_view line_text_;
  int line_ = 0;
  CoordinateRole datum_role_ = CoordinateRole::fixed;
  bool dynamic_ = false;
  std::vector<DynamicRow> dynamic_rows_;
  double sigma0_ = kNotGiven;
  double first_sigma_ = kNotGiven, second_sigma_ = 0;  // that hold until others are given
  std::map<std::string, int> set_ups_;
  std::vector<int> correlated_;
  std::vector<std::vector<double>> correlated_rows_;
};

void KrummReader::read_coordinates(const Parts& parts) {
  if (parts.size() < 2 || parts.size() > 4) return reject(line_text_, "a point and one to three coordinates");
  Eigen::Vector3d at = Eigen::Vector3d::Constant(kNotGiven);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto value = formats::parse_number(parts[i]);
    if (!value) return reject(parts[i], "a coordinate [m]");
    // A lone coordinate is a height.
    at[parts.size() == 2 ? 2 : static_cast<Eigen::Index>(i) - 1] = *value;
  }
  const std::string id(parts[0]);
  builder_.give_coordinates(id, at, builder_.at(line_, 1));
  Point& point = builder_.point(id, builder_.at(line_, 1));
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::isnan(at[static_cast<Eigen::Index>(axis)])) point.roles[axis] = CoordinateRole::unused;
}

// "x51": a point's axis; "51": all of its axes (-1), in a network of heights its height.
std::optional<std::pair<std::string, int>> KrummReader::component(std::string_view word) {
  const std::string all(word), rest(word.substr(1));
  const std::size_t axis = std::string_view("xyz").find(formats::to_lower(word.substr(0, 1)));
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
    const std::string word = formats::to_lower(part);
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
      point.roles[static_cast<std::size_t>(axis)] = datum_role_;
      any = true;
    }
    if (!any) reject(part, "an axis for which [Coordinates] has a value");
  }
}

std::vector<double> KrummReader::numbers(const Parts& parts, std::size_t first) {
  std::vector<double> values;
  for (std::size_t i = first; i < parts.size(); ++i) {
    const auto value = formats::parse_number(parts[i]);
    if (!value) {
      reject(parts[i], "a number");
      return {};
    }
    values.push_back(*value);
  }
  return values;
}

// One number in each row: standard deviations, zero holds. More: the lower triangle or all of a covariance matrix.
void KrummReader::finish_dynamic_datum() {
  const auto n = static_cast<Eigen::Index>(dynamic_rows_.size());
  if (n == 0) return;
  const bool sigmas =
      std::all_of(dynamic_rows_.begin(), dynamic_rows_.end(), [](const DynamicRow& r) { return r.values.size() == 1; });
  CoordinateGroup group;
  group.is_control = true;
  group.source = dynamic_rows_.front().source;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const DynamicRow& row = dynamic_rows_[static_cast<std::size_t>(i)];
    const auto given = static_cast<Eigen::Index>(row.values.size());
    if (!sigmas && given != i + 1 && given != n)
      return builder_.skip(row.source.line, 1, row.point, "a row of a covariance matrix, or one standard deviation");
    if (row.values[sigmas ? 0 : static_cast<std::size_t>(i)] < 0)
      return builder_.skip(row.source.line, 1, row.point, "a standard deviation or variance that is not negative");
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double value =
          sigmas ? (i == j ? row.values[0] * row.values[0] : 0) : row.values[static_cast<std::size_t>(j)];
      covariance(i, j) = covariance(j, i) = value;
    }
  }
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < n; ++i) {
    const DynamicRow& row = dynamic_rows_[static_cast<std::size_t>(i)];
    Point& point = builder_.point(row.point, row.source);
    if (std::isnan(point.coordinates[row.axis])) continue;
    if (covariance(i, i) > 0) {
      kept.push_back(i);
      group.components.push_back({row.point, row.axis});
    } else {
      point.roles[static_cast<std::size_t>(row.axis)] = CoordinateRole::fixed;
    }
  }
  if (kept.empty()) return;
  group.values.resize(static_cast<Eigen::Index>(kept.size()));
  for (std::size_t k = 0; k < kept.size(); ++k)
    group.values[static_cast<Eigen::Index>(k)] =
        builder_.point(group.components[k].point, group.source).coordinates[group.components[k].axis];
  group.covariance = covariance(kept, kept);
  if (Eigen::LLT<Eigen::MatrixXd>(group.covariance).info() != Eigen::Success)
    return builder_.skip(group.source.line, 1, "[Datum]", "a positive definite covariance matrix");
  builder_.survey.coordinates.push_back(std::move(group));
}

std::optional<double> KrummReader::value_of(std::string_view word, ObservationKind kind) const {
  if (!is_angle(kind)) return formats::parse_number(word);
  if (section_.dms || word.find("\xC2\xB0") != std::string_view::npos) return krumm_dms(word);
  const auto gon = formats::parse_number(word);
  return gon ? std::optional(gon_to_rad(*gon)) : std::nullopt;
}

std::optional<double> KrummReader::sigma_of(std::string_view word, ObservationKind kind) const {
  const bool seconds = word.ends_with('"') || section_.sigma_seconds;
  if (word.ends_with('"')) word.remove_suffix(1);
  const auto value = formats::parse_number(word);
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
  if (count > 0) {
    const auto constant = sigma_of(parts[first], observation.kind);
    const auto second = count == 2 || count == 4 ? formats::parse_number(parts[first + 1]) : std::optional(0.0);
    if (!constant || !second || *second < 0 || *constant + *second <= 0) {
      reject(parts[first], "standard deviations that are not negative");
      return false;
    }
    first_sigma_ = *constant;
    second_sigma_ = *second;
  }
  if (count >= 3) {
    const auto instrument = formats::parse_number(parts[parts.size() - 2]);
    const auto target = formats::parse_number(parts[parts.size() - 1]);
    if (!instrument || !target) {
      reject(parts[parts.size() - 2], "instrument height and target height [m]");
      return false;
    }
    observation.instrument_height = *instrument;
    observation.target_height = *target;
  }
  const double length = is_distance ? std::abs(observation.value) : 0;
  observation.sigma = first_sigma_;
  if (std::isnan(first_sigma_)) {
    observation.sigma = is_angle(observation.kind) ? kNotGiven : sigma0_;
  } else if (distance_sigma_ == KrummDistanceSigma::squares) {
    observation.sigma = std::sqrt(first_sigma_ * first_sigma_ + length * second_sigma_ * second_sigma_);
  } else if (distance_sigma_ == KrummDistanceSigma::squares_of_km) {
    observation.sigma = std::hypot(first_sigma_, length / 1000 * second_sigma_);
  } else {
    observation.sigma = first_sigma_ + length / 1000 * second_sigma_;
  }
  return true;
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

void KrummReader::read_levelling(const Parts& parts) {
  if (parts.size() < 4 || parts.size() > 5)
    return reject(line_text_, "from, to, height difference, length of the line [m], standard deviation of 1 km [m]");
  Observation o;
  o.kind = ObservationKind::height_difference;
  o.from = std::string(parts[0]);
  o.to = std::string(parts[1]);
  o.source = builder_.at(line_, 1);
  const auto value = formats::parse_number(parts[2]), length = formats::parse_number(parts[3]);
  if (!value || !length || *length <= 0) return reject(parts[value ? 3 : 2], "a height difference and a length [m]");
  if (o.from == o.to) return reject(parts[1], "another point than the first one");
  if (parts.size() == 5) {
    const auto sigma = sigma_of(parts[4], o.kind);
    if (!sigma || *sigma <= 0) return reject(parts[4], "the standard deviation of a line of 1 km [m]");
    first_sigma_ = *sigma;
  }
  o.value = *value;
  o.levelling_length = *length;
  const double per_km = std::isnan(first_sigma_) ? sigma0_ : first_sigma_;
  o.sigma = per_km * std::sqrt(*length / 1000);
  builder_.add(std::move(o));
}

// "C H 1771.42 0.00072 0.0009": behind the distance its row of the covariance matrix, lower triangle.
void KrummReader::read_correlated(const Parts& parts) {
  const std::vector<double> values = numbers(parts, 2);
  if (values.size() != correlated_.size() + 2 || values[0] <= 0)
    return reject(line_text_, "from, to, distance and a row of the covariance matrix [m^2]");
  Observation o;
  o.kind = ObservationKind::horizontal_distance;
  o.from = std::string(parts[0]);
  o.to = std::string(parts[1]);
  if (o.from == o.to) return reject(parts[1], "another point than the first one");
  o.value = values[0];
  o.source = builder_.at(line_, 1);
  if (!(values.back() > 0)) return reject(parts.back(), "a variance above zero [m^2]");
  o.sigma = std::sqrt(values.back());
  correlated_.push_back(static_cast<int>(builder_.survey.observations.size()));
  correlated_rows_.push_back({values.begin() + 1, values.end()});
  builder_.add(std::move(o));
}

void KrummReader::finish_correlated() {
  const auto n = static_cast<Eigen::Index>(correlated_.size());
  if (n < 2) return;
  ObservationCovariance c;
  c.indices = correlated_;
  c.covariance.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      c.covariance(i, j) = c.covariance(j, i) =
          correlated_rows_[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  if (Eigen::LLT<Eigen::MatrixXd>(c.covariance).info() != Eigen::Success)
    return builder_.skip(line_, 1, "[CorrelatedDistances]", "a positive definite covariance matrix");
  builder_.survey.covariances.push_back(std::move(c));
}

// dx, dy, dz, then three standard deviations or the upper triangle of the covariance matrix, then perhaps two heights.
void KrummReader::read_baseline(const Parts& parts) {
  std::vector<double> v = numbers(parts, 2);
  if (parts.size() < 2 || (v.size() != 6 && v.size() != 9 && v.size() != 11))
    return reject(line_text_, "from, to, dx, dy, dz [m] and three standard deviations or six covariances");
  VectorGroup group;
  const bool heights = v.size() == 11;
  group.vectors.push_back({std::string(parts[0]), std::string(parts[1]), heights ? v[9] : 0, heights ? v[10] : 0});
  group.values = Eigen::Vector3d(v[0], v[1], v[2]);
  Eigen::Matrix3d covariance = Eigen::Vector3d(v[3] * v[3], v[4] * v[4], v[5] * v[5]).asDiagonal();
  if (v.size() > 6) covariance << v[3], v[4], v[5], v[4], v[6], v[7], v[5], v[7], v[8];
  group.covariance = covariance;
  group.source = builder_.at(line_, 1);
  if (parts[0] == parts[1] || Eigen::LLT<Eigen::MatrixXd>(group.covariance).info() != Eigen::Success)
    return reject(line_text_, "two points and a positive definite covariance matrix");
  for (const std::string_view id : {parts[0], parts[1]}) builder_.point(std::string(id), group.source);
  builder_.survey.vectors.push_back(std::move(group));
}

void KrummReader::read_restriction(std::string_view text) {
  const auto condition = krumm_distance_condition(text);
  if (!condition || !builder_.has_point(condition->from) ||
      (!condition->to.empty() && !builder_.has_point(condition->to)))
    return reject(text, "a distance held between two points, (xA-xB)^2+(yA-yB)^2-d^2, or of one from the origin");
  Observation o;
  o.kind = ObservationKind::horizontal_distance;
  o.from = condition->from;
  o.to = condition->to;
  o.source = builder_.at(line_, 1);
  if (o.to.empty()) {
    o.to = "origin";
    while (builder_.has_point(o.to)) o.to += "_";
    builder_.give_coordinates(o.to, {0, 0, kNotGiven}, o.source);
    builder_.point(o.to, o.source).roles = {CoordinateRole::fixed, CoordinateRole::fixed, CoordinateRole::unused};
  }
  o.value = condition->distance;
  o.sigma = kCondition;
  o.corrections.push_back("a restriction, held to 1 micrometre");
  builder_.add(std::move(o));
}

void KrummReader::read_sigma0(const Parts& parts) {
  const auto value = formats::parse_number(parts[0]);
  const std::string_view unit = parts.size() > 1 ? parts[1] : std::string_view();
  if (!value || *value <= 0) return reject(parts[0], "a standard deviation above zero");
  if (unit == "gon" || unit == "mgon") return;  // says nothing of lengths
  sigma0_ = *value * (unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1.0);
}

// An angle whose arm is a mark known by its azimuth alone is an azimuth of its other arm.
void KrummReader::orient_by_marks() {
  if (!correlated_.empty()) return;  // their indices must stay
  std::map<std::string, std::set<std::string>> seen_from;
  std::map<std::string, double> azimuths;
  for (const Observation& o : builder_.survey.observations) {
    seen_from[o.to].insert(o.from);
    if (!o.second_to.empty()) seen_from[o.second_to].insert(o.from);
    seen_from[o.from].insert("");  // a station is no mark
    const bool angular = o.kind == ObservationKind::angle || o.kind == ObservationKind::azimuth;
    if (!angular) seen_from[o.to].insert("");
    if (o.kind == ObservationKind::azimuth) azimuths.try_emplace(o.to, o.value);
  }
  std::erase_if(azimuths, [&](const auto& mark) {
    return seen_from[mark.first].size() != 1 || !builder_.point(mark.first, {}).coordinates.array().isNaN().all();
  });
  if (azimuths.empty()) return;
  std::erase_if(builder_.survey.observations,
                [&](const Observation& o) { return o.kind == ObservationKind::azimuth && azimuths.contains(o.to); });
  for (Observation& o : builder_.survey.observations) {
    if (o.kind != ObservationKind::angle) continue;
    const auto left = azimuths.find(o.to), right = azimuths.find(o.second_to);
    if ((left == azimuths.end()) == (right == azimuths.end())) continue;
    const bool by_left = left != azimuths.end();
    const std::string mark = by_left ? o.to : o.second_to;
    o.kind = ObservationKind::azimuth;
    o.value = wrap_to_circle(by_left ? left->second + o.value : right->second - o.value);
    if (by_left) o.to = o.second_to;
    o.second_to.clear();
    o.corrections.push_back("angle to the mark " + mark + ", whose azimuth is given, made an azimuth");
  }
  std::erase_if(builder_.survey.points, [&](const Point& p) { return azimuths.contains(p.id); });
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
           "coordinates and observations of a local plane or space: ellipsoidal coordinates and angles in an "
           "inclined plane are not adjusted here");
  else if (section->content == KrummContent::unknown_scale)
    builder_.warn("line " + std::to_string(line_) + ": " + std::string(text) +
                  " asks for an unknown of the distances; give the adjustment scale_sigma or additive_constant_sigma");
}

void KrummReader::read_line(std::string_view text) {
  const auto parts = formats::split_blanks(text);
  if (!in_section_) return reject(text, "a section such as [Coordinates] or [SpatialDistances] first");
  NetworkInfo& info = builder_.survey.info;
  switch (section_.content) {
    case KrummContent::coordinates:
      return read_coordinates(parts);
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
  for (const formats::Line& line : formats::split_lines(decoded_.text)) {
    line_ = line.number;
    line_text_ = line.text;
    std::string_view text = formats::trim(line.text);
    if (text.empty() || text.front() == '#' || text.front() == '%') {
      comment_ += std::string(text) + ' ';
      continue;
    }
    // '#' is part of names, and begins a comment between blanks only.
    text = text.substr(0, std::min(text.find('%'), text.find(" #")));
    text = formats::trim(text);
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

}  // namespace

SurveyObservations read_krumm(std::string_view bytes, const std::string& file) {
  return KrummReader(bytes, file).read();
}

}  // namespace plumbline::survey
