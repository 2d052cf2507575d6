// Words of the record table of survey_csv: kinds of observations and roles of coordinates.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

inline constexpr std::array<std::string_view, 7> kKindNames = {
    "direction", "zenith_angle", "slope_distance", "horizontal_distance", "height_difference", "angle", "azimuth"};

inline std::string_view name_of(ObservationKind kind) { return kKindNames[static_cast<size_t>(kind)]; }

inline std::optional<ObservationKind> kind_of(std::string_view name) {
  for (std::size_t i = 0; i < kKindNames.size(); ++i)
    if (kKindNames[i] == name) return static_cast<ObservationKind>(i);
  return std::nullopt;
}

inline bool is_angle(ObservationKind kind) {
  return kind == ObservationKind::direction || kind == ObservationKind::zenith_angle ||
         kind == ObservationKind::angle || kind == ObservationKind::azimuth;
}

inline constexpr std::string_view kRoleLetters = "-fcx";  // in the order of CoordinateRole

/// One letter for each of E, N, H; empty text means all free.
inline std::optional<std::array<CoordinateRole, 3>> roles_of(std::string_view letters) {
  std::array<CoordinateRole, 3> roles = {CoordinateRole::free, CoordinateRole::free, CoordinateRole::free};
  if (letters.empty()) return roles;
  if (letters.size() != roles.size()) return std::nullopt;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const std::size_t role = kRoleLetters.find(letters[i]);
    if (role == std::string_view::npos) return std::nullopt;
    roles[i] = static_cast<CoordinateRole>(role);
  }
  return roles;
}

inline std::string letters_of(const std::array<CoordinateRole, 3>& roles) {
  std::string letters;
  for (const CoordinateRole role : roles) letters += kRoleLetters[static_cast<size_t>(role)];
  return letters;
}

}  // namespace plumbline::survey
