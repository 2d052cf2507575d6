#include "survey/files/survey_builder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "base/text/text.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::survey {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kSkippedCap = 200;
constexpr double kCoordinateConflict = 0.01;  // [m]

}  // namespace

std::string understood_formats() {
  return "one of the formats understood: Leica GSI-8 and GSI-16 (total stations and levels), Leica IDX, LandXML 1.2 "
         "survey "
         "and HeXML, Trimble JobXML, Zeiss and Trimble M5, R5, R4, Sokkia SDR33, Carlson RW5, Nikon RAW, Topcon GTS-7 "
         "and GTS-210, Topcon DL and Sokkia SDL levels, Geodimeter, STAR*NET, DynaML, gama-local XML, Krumm .dat, CSV "
         "of points (PENZD) or observations, CSV of "
         "per-set-up coordinates";
}

double gon_to_rad(double gon) { return gon * (kPi / 200.0); }
double degrees_to_rad(double degrees) { return degrees * (kPi / 180.0); }

double wrap_to_circle(double angle) {
  double wrapped = std::fmod(angle, 2 * kPi);
  if (wrapped < 0) wrapped += 2 * kPi;
  return wrapped >= 2 * kPi ? 0.0 : wrapped;
}

int face_of_zenith_angle(double zenith_angle) { return wrap_to_circle(zenith_angle) > kPi ? 2 : 1; }

std::optional<double> packed_degrees_to_rad(double packed) {
  if (!(std::abs(packed) < 1e6)) return std::nullopt;
  // In units of 0.0001": exact in a double, so that 0.3 minutes packed as .30 never turn into 29.99.
  const long long units = std::llround(std::abs(packed) * 1e8);
  const long long degrees = units / 100'000'000, minutes = units / 1'000'000 % 100, seconds = units % 1'000'000;
  if (minutes >= 60 || seconds >= 600'000) return std::nullopt;
  const double angle = degrees_to_rad(static_cast<double>(degrees) + static_cast<double>(minutes) / 60.0 +
                                      static_cast<double>(seconds) / (3600.0 * 1e4));
  return packed < 0 ? -angle : angle;
}

SurveyBuilder::SurveyBuilder(std::string file, std::string format) : file_(std::move(file)) {
  survey.info.format = std::move(format);
  survey.files = {file_};
}

void SurveyBuilder::skip(int line, int column, std::string_view found, const std::string& expected) {
  if (survey.skipped.size() >= kSkippedCap) {
    ++skipped_beyond_cap_;
    return;
  }
  survey.skipped.push_back({at(line, column), text::quoted(found, 60), expected});
}

void SurveyBuilder::warn(const std::string& text) {
  if (warnings_.size() < kSkippedCap && warnings_.insert(text).second) survey.warnings.push_back(text);
}

int SurveyBuilder::start_set_up(const std::string& station, double instrument_height, const SourcePosition& source) {
  int& occupations = occupations_[station];
  std::string id;
  do {
    ++occupations;
    id = occupations == 1 ? station : station + "/" + std::to_string(occupations);
  } while (!set_up_ids_.insert(id).second);
  point(station, source);
  survey.set_ups.push_back({id, station, instrument_height, source});
  return current_ = static_cast<int>(survey.set_ups.size()) - 1;
}

int SurveyBuilder::start_unnamed_set_up(double instrument_height, const SourcePosition& source) {
  std::string name;
  do {
    name = "free-station-" + std::to_string(++unnamed_);
  } while (has_point(name));
  warn("line " + std::to_string(source.line) + ": observations without the name of their station; it is called '" +
       name + "'");
  return start_set_up(name, instrument_height, source);
}

Point& SurveyBuilder::point(const std::string& id, const SourcePosition& source) {
  const auto [entry, is_new] = points_.try_emplace(id, survey.points.size());
  if (is_new) {
    Point made;
    made.id = id;
    made.source = source;
    survey.points.push_back(std::move(made));
  }
  return survey.points[entry->second];
}

void SurveyBuilder::give_coordinates(const std::string& id, const Eigen::Vector3d& coordinates,
                                     const SourcePosition& source) {
  Point& known = point(id, source);
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isnan(coordinates[axis])) continue;
    if (std::isnan(known.coordinates[axis])) {
      known.coordinates[axis] = coordinates[axis];
    } else if (std::abs(known.coordinates[axis] - coordinates[axis]) > kCoordinateConflict) {
      warn("point '" + id + "' has different coordinates in lines " + std::to_string(known.source.line) + " and " +
           std::to_string(source.line) + "; the first ones are kept");
      return;
    }
  }
}

int SurveyBuilder::instrument(const std::string& name) {
  const auto at = std::find(survey.instruments.begin(), survey.instruments.end(), name);
  const auto index = static_cast<int>(at - survey.instruments.begin());
  if (at == survey.instruments.end()) survey.instruments.push_back(name);
  return index;
}

void SurveyBuilder::use_instrument(const std::string& name) {
  std::string& first = survey.info.instrument;
  if (name.empty() || (instrument_ < 0 && (first.empty() || first == name))) {
    if (first.empty()) first = name;
    return;
  }
  if (instrument_ < 0) {
    const int of_first = instrument(first);
    for (Observation& o : survey.observations) o.instrument = of_first;
  }
  instrument_ = instrument(name);
}

void SurveyBuilder::know_coordinates(const std::string& id, const Eigen::Vector3d& coordinates,
                                     const SourcePosition& source) {
  give_coordinates(id, coordinates, source);
  if (computed_.contains(id)) return;
  Point& known = point(id, source);
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isnan(coordinates[axis]) && std::abs(known.coordinates[axis] - coordinates[axis]) < kCoordinateConflict)
      known.known[axis] = true;
}

void SurveyBuilder::compute_coordinates(const std::string& id) {
  if (const auto at = points_.find(id);
      at != points_.end() && !survey.points[at->second].coordinates.array().isNaN().all())
    return;
  computed_.insert(id);
}

void SurveyBuilder::add_kind(const Sighting& sighting, ObservationKind kind, double value, int face,
                             const std::vector<std::string>& corrections) {
  Observation observation;
  observation.kind = kind;
  observation.instrument = instrument_;
  observation.set_up = current_;
  observation.pointing = pointings_;
  observation.from = survey.set_ups[current_].station;
  observation.to = sighting.to;
  observation.value = value;
  observation.instrument_height = sighting.instrument_height;
  observation.target_height = sighting.target_height;
  observation.face = face;
  observation.source = sighting.source;
  observation.corrections = corrections;
  survey.observations.push_back(std::move(observation));
}

bool SurveyBuilder::add(const Sighting& sighting) {
  stop_point();
  const bool has_slope = sighting.slope_distance > 0, has_horizontal = sighting.horizontal_distance > 0;
  const bool has_direction = !std::isnan(sighting.direction), has_zenith = !std::isnan(sighting.zenith_angle);
  const bool has_height = !std::isnan(sighting.height_difference);
  if (!has_slope && !has_horizontal && !has_direction && !has_zenith && !has_height) return false;
  if (current_ < 0) start_unnamed_set_up(kNotGiven, sighting.source);
  point(sighting.to, sighting.source);
  int face = sighting.face;
  if (has_zenith) {
    const int shown = face_of_zenith_angle(sighting.zenith_angle);
    if (face == 2 && shown == 1) {
      warn("line " + std::to_string(sighting.source.line) +
           ": face 2 with a zenith angle of face 1; such sightings are taken as already reduced to face 1");
      face = 0;
    } else {
      face = shown;
    }
  }
  if (has_direction)
    add_kind(sighting, ObservationKind::direction, wrap_to_circle(sighting.direction), face,
             sighting.direction_corrections);
  if (has_zenith)
    add_kind(sighting, ObservationKind::zenith_angle, wrap_to_circle(sighting.zenith_angle), face,
             sighting.zenith_corrections);
  if (has_slope)
    add_kind(sighting, ObservationKind::slope_distance, sighting.slope_distance, face, sighting.distance_corrections);
  if (has_horizontal)
    add_kind(sighting, ObservationKind::horizontal_distance, sighting.horizontal_distance, face,
             sighting.distance_corrections);
  if (has_height)
    add_kind(sighting, ObservationKind::height_difference, sighting.height_difference, face,
             sighting.distance_corrections);
  ++pointings_;
  return true;
}

void SurveyBuilder::add(Observation observation) {
  stop_point();
  for (const std::string* id : {&observation.from, &observation.to, &observation.second_to})
    if (!id->empty()) point(*id, observation.source);
  survey.observations.push_back(std::move(observation));
}

// The n-th sighting of a target in the same face from the same set-up belongs to set n.
void SurveyBuilder::number_sets() {
  std::map<std::tuple<int, int, ObservationKind, std::string>, int> seen;
  for (Observation& observation : survey.observations) {
    if (observation.set_up < 0 || observation.pointing < 0 || observation.set_number != 0) continue;
    observation.set_number = ++seen[{observation.set_up, observation.face, observation.kind, observation.to}];
  }
}

// A set-up without sightings would only add an orientation nobody can determine.
void SurveyBuilder::drop_empty_set_ups() {
  std::vector<int> new_index(survey.set_ups.size(), -1);
  for (const Observation& observation : survey.observations)
    if (observation.set_up >= 0) new_index[observation.set_up] = 0;
  for (const LocalCoordinate& local : survey.local_coordinates)
    if (local.set_up >= 0) new_index[local.set_up] = 0;
  std::vector<SetUp> kept;
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] < 0) continue;
    new_index[i] = static_cast<int>(kept.size());
    kept.push_back(std::move(survey.set_ups[i]));
  }
  survey.set_ups = std::move(kept);
  for (Observation& observation : survey.observations)
    if (observation.set_up >= 0) observation.set_up = new_index[observation.set_up];
  for (LocalCoordinate& local : survey.local_coordinates)
    if (local.set_up >= 0) local.set_up = new_index[local.set_up];
}

// Levels begin a line at 0 where nobody keys in a height: one such bench mark is as good a datum as any, of two at
// least one is none.
void SurveyBuilder::distrust_zero_heights() {
  std::string names;
  int zeros = 0;
  const auto is_zero = [](const Point& p) { return p.known[2] && p.coordinates.z() == 0; };
  for (const Point& p : survey.points)
    if (is_zero(p)) names += (zeros++ > 0 ? ", " : "") + text::quoted(p.id, 60);
  if (zeros < 2) return;
  for (Point& p : survey.points)
    if (is_zero(p)) p.known[2] = false;
  warn("lines begin at height 0 at " + names +
       ": taken as heights that nobody keyed in, so that these points are not known; give control if they are");
}

SurveyObservations SurveyBuilder::finish(const std::string& found_nothing, const std::string& expected) {
  if (skipped_beyond_cap_ > 0)
    warn("another " + std::to_string(skipped_beyond_cap_) + " places of the file were skipped; only the first " +
         std::to_string(kSkippedCap) + " are listed");
  bool has_content = !survey.observations.empty() || !survey.coordinates.empty() || !survey.vectors.empty() ||
                     !survey.local_coordinates.empty();
  for (const Point& p : survey.points) has_content = has_content || !p.coordinates.array().isNaN().all();
  if (!has_content) {
    if (survey.skipped.empty()) throw SurveyReadError(at(0), found_nothing, expected);
    const SkippedLine& first = survey.skipped.front();
    throw SurveyReadError(first.source, first.found,
                          first.expected + "; nothing else in the file could be used (" + found_nothing +
                              "), it should hold " + expected);
  }
  drop_empty_set_ups();
  distrust_zero_heights();
  number_sets();
  return std::move(survey);
}

}  // namespace plumbline::survey
