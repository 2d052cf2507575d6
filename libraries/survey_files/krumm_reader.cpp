#include <cmath>
#include <optional>

#include "survey_files/krumm.hpp"
#include "survey_files/survey_builder.hpp"
#include "text/text.hpp"

namespace plumbline::survey {
namespace {

class KrummReader {
 public:
  KrummReader(std::string_view bytes, const std::string& file)
      : decoded_(formats::decode_text(bytes)), builder_(file, "krumm") {}
  SurveyObservations read();

 private:
  void read_line(std::string_view text);
  void read_coordinates(const std::vector<std::string_view>& parts);
  void read_datum(const std::vector<std::string_view>& parts);
  void read_observation(const std::vector<std::string_view>& parts, ObservationKind kind);
  void reject(std::string_view found, const std::string& expected) {
    const std::size_t place = line_text_.find(found);
    builder_.skip(line_, place == std::string_view::npos ? 1 : static_cast<int>(place) + 1, found, expected);
  }

  formats::DecodedText decoded_;
  SurveyBuilder builder_;
  std::string section_;
  std::string_view line_text_;
  int line_ = 0;
  CoordinateRole datum_role_ = CoordinateRole::fixed;
  double sigma0_ = kNotGiven;
};

void KrummReader::read_coordinates(const std::vector<std::string_view>& parts) {
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

// "fix x51 y51 z51 x37 ...": an axis and a point in each word.
void KrummReader::read_datum(const std::vector<std::string_view>& parts) {
  for (const std::string_view part : parts) {
    const std::string word = formats::to_lower(part);
    if (word == "fix") {
      datum_role_ = CoordinateRole::fixed;
      continue;
    }
    if (word == "free" || word == "dyn" || word == "freie") {
      datum_role_ = CoordinateRole::constrained;
      continue;
    }
    const std::size_t axis = std::string_view("xyz").find(word[0]);
    const std::string id(part.substr(1));
    if (axis == std::string_view::npos || !builder_.has_point(id)) {
      reject(part, "x, y or z and the name of a point of [Coordinates], e.g. 'x51'");
      continue;
    }
    Point& point = builder_.point(id, builder_.at(line_, 1));
    if (std::isnan(point.coordinates[static_cast<Eigen::Index>(axis)])) {
      reject(part, "an axis for which [Coordinates] has a value");
      continue;
    }
    point.roles[axis] = datum_role_;
  }
}

void KrummReader::read_observation(const std::vector<std::string_view>& parts, ObservationKind kind) {
  if (parts.size() < 3) return reject(line_text_, "from, to, value [m] and perhaps its standard deviation [m]");
  Observation observation;
  observation.kind = kind;
  observation.from = std::string(parts[0]);
  observation.to = std::string(parts[1]);
  observation.source = builder_.at(line_, 1);
  const auto value = formats::parse_number(parts[2]);
  const bool is_distance = kind != ObservationKind::height_difference;
  if (!value || (is_distance && *value <= 0))
    return reject(parts[2], is_distance ? "a distance above zero [m]" : "a height difference [m]");
  if (observation.from == observation.to) return reject(parts[1], "another point than the first one");
  observation.value = *value;
  observation.sigma = sigma0_;
  if (parts.size() > 3) {
    const auto constant = formats::parse_number(parts[3]);
    const auto by_length =
        is_distance && parts.size() > 4 ? formats::parse_number(parts[4]) : std::optional<double>(0.0);
    if (!constant || !by_length || *constant < 0 || *by_length < 0 || *constant + *by_length <= 0)
      return reject(parts[3], "standard deviations that are not negative [m]");
    observation.sigma = std::sqrt(*constant * *constant + std::abs(*value) * *by_length * *by_length);
  }
  builder_.add(std::move(observation));
}

void KrummReader::read_line(std::string_view text) {
  const auto parts = formats::split_blanks(text);
  if (section_ == "coordinates") return read_coordinates(parts);
  if (section_ == "datum") return read_datum(parts);
  if (section_ == "spatialdistances") return read_observation(parts, ObservationKind::slope_distance);
  if (section_ == "horizontaldistances" || section_ == "distances")
    return read_observation(parts, ObservationKind::horizontal_distance);
  if (section_ == "heightdifferences") return read_observation(parts, ObservationKind::height_difference);
  if (section_ == "sigma0") {
    const auto value = formats::parse_number(parts[0]);
    const double unit = parts.size() > 1 && parts[1] == "mm" ? 1e-3 : parts.size() > 1 && parts[1] == "cm" ? 1e-2 : 1.0;
    if (!value || *value <= 0) return reject(parts[0], "a standard deviation above zero");
    sigma0_ = *value * unit;
    return;
  }
  if (section_ == "project") {
    if (builder_.survey.info.title.empty()) builder_.survey.info.title = std::string(text);
    return;
  }
  if (section_ == "source") {
    std::string& description = builder_.survey.info.description;
    description += (description.empty() ? "" : "\n") + std::string(text);
    return;
  }
  if (section_.empty()) reject(text, "a section such as [Coordinates] or [SpatialDistances] first");
}

SurveyObservations KrummReader::read() {
  for (const formats::Line& line : formats::split_lines(decoded_.text)) {
    line_ = line.number;
    line_text_ = line.text;
    std::string_view text = formats::trim(line.text);
    if (text.empty() || text.front() == '#' || text.front() == '%') continue;
    text = formats::trim(text.substr(0, text.find('%')));
    if (text.front() == '[') {
      section_ = formats::to_lower(text.substr(1, text.find(']') == std::string_view::npos ? 0 : text.find(']') - 1));
      static const char* const kKnown[] = {
          "coordinates",       "datum",   "sigma0", "spatialdistances", "horizontaldistances", "distances",
          "heightdifferences", "project", "source", "graphics"};
      bool known = false;
      for (const char* name : kKnown) known = known || section_ == name;
      if (!known)
        reject(text,
               "one of the sections that are understood: coordinates, datum and distances in space, "
               "plane or height");
      continue;
    }
    if (section_ != "graphics") read_line(text);
  }
  return builder_.finish("no section with coordinates or distances", understood_formats());
}

}  // namespace

SurveyObservations read_krumm(std::string_view bytes, const std::string& file) {
  return KrummReader(bytes, file).read();
}

}  // namespace plumbline::survey
