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
  /// Of coordinates: hashes of them rounded to 0.01, 0.1 and 1 mm, at a tie both ways.
  std::vector<std::string> rounded;
  std::string written;  ///< that of them as they stand, if the whole set-up is written so; empty: it is not
};

/// Of everything that is a sighting of two values or more: direction, zenith angle and distance of one pointing,
/// coordinates in the frame of a set-up, observed coordinates, vectors. A single value, such as a height difference, is
/// found twice by chance. Numbers count to 1e-7 rad and 1e-7 m, names as they stand. Angles are rounded in a unit that
/// is not known here: of pointings there is nothing rounded.
std::vector<ReadingKey> reading_keys(const SurveyObservationsT& observations);

/// What of a campaign is known already.
struct RepeatedReadings {
  std::size_t count = 0, all = 0;  ///< sightings
  std::set<std::string> set_ups;   ///< their names
  std::set<std::string> targets;   ///< points that they see
  bool fewer_digits = false;       ///< of a set-up: they are written with fewer digits than before
};

/// `known`: hashes of campaigns before, with the rounded ones, sorted. A set-up repeats if three of its sightings, or
/// all of fewer, are known: rounded numbers agree by chance once in a while. So does one of ten or more that is written
/// to 1 mm or finer, if nine of ten are those of before rounded so.
RepeatedReadings repeated_readings(const std::vector<ReadingKey>& readings, const std::vector<std::string>& known);

/// "212 of 400 readings are those of a campaign before (set-up S1): ..."; empty if none are.
std::string words_of(const RepeatedReadings& repeated);

}  // namespace plumbline::loop
