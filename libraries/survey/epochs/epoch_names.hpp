// Points are followed through epochs by their names. A point that is written otherwise from some epoch on (P3, then
// p3), or is no longer measured, is compared with nothing: what it did since is not seen, and "nothing has moved" is
// not said of it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// An epoch and the names of its marks.
struct NamedEpoch {
  std::string name;
  std::vector<std::string> ids;
};

/// In words, without a full stop: pairs of names that are one to a person and never in one epoch; points that the last
/// epoch does not have, with the epoch that saw them last where there are more than two.
std::vector<std::string> names_not_followed(const std::vector<NamedEpoch>& epochs);

/// One reading as epochs are compared by it: what it was of, and its value [rad, m].
struct EpochReading {
  std::string of;
  double value = 0;
  auto operator<=>(const EpochReading&) const = default;
};

std::vector<EpochReading> readings_of(const SurveyObservations& survey);

/// Both have the same readings to the last digit, and enough of them that this is no chance: one measurement, no two.
bool are_one_measurement(std::vector<EpochReading> first, std::vector<EpochReading> second);
/// The first two of many that are, earlier one first: each epoch is put in order once, not held against all others.
std::optional<std::pair<size_t, size_t>> find_one_measurement(std::vector<std::vector<EpochReading>> epochs);
/// What is said of two such epochs.
std::string one_measurement_in_words(const std::string& first, const std::string& second);

}  // namespace plumbline::survey
