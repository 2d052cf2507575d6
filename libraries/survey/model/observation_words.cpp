#include "survey/model/observation_words.hpp"

#include <algorithm>

namespace plumbline::survey {

std::string name_of(const Observation& o) {
  const std::string at = place(o.source);
  std::string kind = kind_name(o.kind);
  std::replace(kind.begin(), kind.end(), '_', ' ');
  return kind + " " + o.from + " -> " + o.to + (at.empty() ? "" : " (" + at + ")");
}

std::string kind_name(ObservationKind kind) {
  switch (kind) {
    case ObservationKind::direction:
      return "direction";
    case ObservationKind::zenith_angle:
      return "zenith_angle";
    case ObservationKind::slope_distance:
      return "slope_distance";
    case ObservationKind::horizontal_distance:
      return "horizontal_distance";
    case ObservationKind::height_difference:
      return "height_difference";
    case ObservationKind::angle:
      return "angle";
    case ObservationKind::azimuth:
      return "azimuth";
  }
  return "?";
}

Group group_of(ObservationKind kind) {
  switch (kind) {
    case ObservationKind::zenith_angle:
      return kZenithAngles;
    case ObservationKind::slope_distance:
    case ObservationKind::horizontal_distance:
      return kDistances;
    case ObservationKind::height_difference:
      return kHeightDifferences;
    default:
      return kDirections;
  }
}

const char* datum_name(DatumMode mode) {
  switch (mode) {
    case DatumMode::file:
      return "file";
    case DatumMode::fixed:
      return "fixed";
    case DatumMode::weighted:
      return "weighted";
    case DatumMode::inner:
      return "inner";
    default:
      return "automatic";
  }
}

}  // namespace plumbline::survey
