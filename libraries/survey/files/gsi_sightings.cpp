#include <cmath>
#include <numbers>

#include "survey/files/gsi_reader.hpp"

namespace plumbline::survey {
namespace {

constexpr double kLongestDistance = 1e5;  // [m]; no instrument measures farther, so longer ones are damage

}  // namespace

void GsiReader::read_sighting(const GsiBlock& block, const std::string& target) {
  if (builder_.current_set_up() < 0 || lost_station_) {
    start_station(std::nullopt, length(block.find(88)).value_or(kNotGiven),
                  builder_.at(line_, block.words.front().column));
  }
  Sighting sighting;
  sighting.to = target;
  sighting.source = builder_.at(line_, block.words.front().column);
  if (block.find(81) && block.find(82)) builder_.compute_coordinates(target);
  sighting.target_height = target_height_;
  settle_instrument_height(sighting);
  if (const auto direction = angle(block.find(21))) {
    sighting.direction = turn_ == 0 ? *direction : wrap_to_circle(*direction + turn_);
    if (turn_ != 0)
      sighting.direction_corrections.push_back("circle turned by " +
                                               text::format_fixed(turn_ * 200 / std::numbers::pi, 4) +
                                               " gon, as word 25 of the station says");
  }
  if (const GsiWord* word = block.find(22)) read_zenith_angle(*word, sighting);
  const GsiWord* slope = block.find(31);
  const GsiWord* horizontal = block.find(32);
  const GsiWord* height = block.find(33);
  // 32 and 33 are computed from 31 where that is there: only the measured value counts.
  if (slope) {
    sighting.slope_distance = length(slope).value_or(kNotGiven);
    sighting.distance_corrections = gsi_distance_corrections(block, *slope, options_.us_survey_foot);
  } else if (horizontal || height) {
    sighting.horizontal_distance = length(horizontal).value_or(kNotGiven);
    if (!block.find(22)) sighting.height_difference = length(height).value_or(kNotGiven);
    sighting.distance_corrections =
        gsi_distance_corrections(block, horizontal ? *horizontal : *height, options_.us_survey_foot);
    sighting.distance_corrections.push_back("reduced by the instrument (curvature and refraction as set there)");
  }
  for (double* distance : {&sighting.slope_distance, &sighting.horizontal_distance}) {
    if (*distance >= 0 && *distance <= kLongestDistance) continue;
    if (!std::isnan(*distance)) reject(slope ? *slope : *horizontal, "a distance between 0 and 100 km");
    *distance = kNotGiven;
  }
  builder_.add(sighting);
  describe_point(block, target);
}

void GsiReader::read_zenith_angle(const GsiWord& word, Sighting& sighting) {
  if (options_.vertical_reference == GsiVerticalReference::percent) {
    const auto digits = gsi_digits(word);
    if (!digits) return reject(word, "a slope in percent, all characters digits");
    const double percent = (word.negative ? -1e-5 : 1e-5) * static_cast<double>(*digits);
    sighting.zenith_angle = std::atan2(100.0, percent);
    sighting.zenith_corrections.push_back("from a slope in percent; the face is not known");
    return;
  }
  const auto value = angle(&word);
  if (!value) return;
  sighting.zenith_angle = *value;
  if (options_.vertical_reference == GsiVerticalReference::horizon) {
    sighting.zenith_angle = std::numbers::pi / 2 - *value;
    sighting.zenith_corrections.push_back("counted from the horizon in the file");
  }
}

// Instruments fill a remark nobody keyed in with dashes.
void GsiReader::describe_point(const GsiBlock& block, const std::string& id) {
  Point& point = builder_.point(id, builder_.at(line_, block.words.front().column));
  for (int index = 71; index <= 79; ++index) {
    const GsiWord* word = block.find(index);
    if (!word) continue;
    const std::string text(word->text());
    if (text.find_first_not_of("-?0 ") == std::string::npos) continue;
    std::string& into = index == 71 ? point.code : point.description;
    if (into.empty()) into = text;
  }
}

std::optional<std::string> GsiReader::name(const GsiWord* word) {
  if (!word) return std::nullopt;
  if (!word->complete() || word->text().empty()) {
    reject(*word, "a name of " + std::to_string(word->digits) + " characters; the line seems cut");
    return std::nullopt;
  }
  return std::string(word->text());
}

std::optional<double> GsiReader::angle(const GsiWord* word) {
  if (!word || word->is_blank()) return std::nullopt;
  const GsiValue value = gsi_angle(*word);
  if (value.expected) {
    reject(*word, value.expected);
    return std::nullopt;
  }
  if (word->unit == '3' || word->unit == '4') builder_.survey.info.angles_in_degrees = true;
  return value.value;
}

std::optional<double> GsiReader::length(const GsiWord* word) {
  if (!word || word->is_blank()) return std::nullopt;
  const GsiValue value = gsi_length(*word, options_.us_survey_foot ? kUsSurveyFoot : kFoot);
  if (value.expected) {
    reject(*word, value.expected);
    return std::nullopt;
  }
  return value.value;
}

Eigen::Vector3d GsiReader::coordinates(const GsiBlock& block, int east) {
  Eigen::Vector3d result;
  for (int axis = 0; axis < 3; ++axis) result[axis] = length(block.find(east + axis)).value_or(kNotGiven);
  return result;
}

void GsiReader::give_coordinates(const std::string& id, const GsiBlock& block, int east) {
  const SourcePosition source = builder_.at(line_, block.words.front().column);
  const Eigen::Vector3d at = coordinates(block, east);
  Eigen::Vector3d keyed = at;
  for (int axis = 0; axis < 3; ++axis)
    if (const GsiWord* word = block.find(east + axis); !word || !word->keyed_in()) keyed[axis] = kNotGiven;
  // What is zero where nothing is set is no place.
  if (keyed[0] == 0 && keyed[1] == 0) keyed.setConstant(kNotGiven);
  builder_.give_coordinates(id, at, source);
  builder_.know_coordinates(id, keyed, source);
}

}  // namespace plumbline::survey
