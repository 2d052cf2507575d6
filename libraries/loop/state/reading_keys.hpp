// Readings by identity: whether a campaign holds readings of a campaign before, which say nothing new.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "artifacts/survey_observations.hpp"

namespace plumbline::loop {

/// One sighting of a point.
struct ReadingKey {
  std::string hash;    ///< of station, target and all values of it, 16 hexadecimal digits
  std::string set_up;  ///< its name; empty: none
  std::string target;
};

/// Of everything that is a sighting of two values or more: direction, zenith angle and distance of one pointing,
/// coordinates in the frame of a set-up, observed coordinates, vectors. A single value, such as a height difference, is
/// found twice by chance. Numbers count to 1e-7 rad and 1e-7 m, names as they stand.
std::vector<ReadingKey> reading_keys(const SurveyObservationsT& observations);

/// What of a campaign is known already.
struct RepeatedReadings {
  std::size_t count = 0, all = 0;  ///< sightings
  std::set<std::string> set_ups;   ///< their names
  std::set<std::string> targets;   ///< points that they see
};

/// `known`: hashes of campaigns before, sorted. A set-up repeats if three of its sightings, or all of fewer, are known:
/// rounded numbers agree by chance once in a while.
RepeatedReadings repeated_readings(const std::vector<ReadingKey>& readings, const std::vector<std::string>& known);

/// "212 of 400 readings are those of a campaign before (set-up S1): ..."; empty if none are.
std::string words_of(const RepeatedReadings& repeated);

}  // namespace plumbline::loop
