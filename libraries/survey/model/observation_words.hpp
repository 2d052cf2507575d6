// What kinds of observations are called, and which of them are weighed together.
#pragma once

#include <string>

#include "survey/model/adjust_options.hpp"

namespace plumbline::survey {

/// Groups of variance components, in this order.
inline constexpr const char* kGroupNames[] = {"directions",         "zenith angles",     "distances",
                                              "height differences", "local coordinates", "given"};
enum Group { kDirections, kZenithAngles, kDistances, kHeightDifferences, kLocalCoordinates, kGiven, kGroups };

/// "direction A -> B (file:line:column)", for messages.
std::string name_of(const Observation& observation);
std::string kind_name(ObservationKind kind);
Group group_of(ObservationKind kind);
const char* datum_name(DatumMode mode);

}  // namespace plumbline::survey
