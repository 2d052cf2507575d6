// The sections of Krumm's files and how their values are written.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

enum class KrummContent {
  coordinates,
  datum,
  sigma0,
  observations,
  levelling,  ///< from, to, height difference, length of the line, standard deviation of 1 km
  correlated_distances,
  baselines,
  restrictions,
  title,
  source,
  passed_over,  ///< graphics, approximate values of what is computed anyway
  unknown_scale,
  ellipsoid,  ///< semi-major axis, square of the eccentricity, meridian, its scale: what coordinates are drawn on
  refused
};

struct KrummSection {
  KrummContent content = KrummContent::refused;
  ObservationKind kind = ObservationKind::direction;
  bool dms = false;            ///< values in degrees, minutes, seconds; else gon or metres
  bool sigma_seconds = false;  ///< standard deviations in arc seconds
  bool from_horizon = false;   ///< vertical angles count from the horizon
  bool geodetic = false;       ///< coordinates are latitude and longitude in degrees, minutes, seconds
};

/// Of the text between the brackets, units included, e.g. "Angles,dms,s". nullopt: no section that is known.
std::optional<KrummSection> krumm_section(std::string_view text);

/// How the standard deviation of a distance grows, by the comment above its section. `sum` is per kilometre where the
/// comment says metres, too: the one network that has both words (Leick's) means that, and 5 % of a length is none.
enum class KrummDistanceSigma { squares, squares_of_km, sum };
KrummDistanceSigma krumm_distance_sigma(std::string_view comment);

/// [rad] of "185°22'14.5\"", "68°15'" or "-0°6'"; nullopt if it is none, or minutes or seconds reach 60.
std::optional<double> krumm_dms(std::string_view text);

/// A condition (xA-xB)^2+(yA-yB)^2-d^2 = 0 or xA^2+yA^2-d^2 = 0 (`to` empty: to the origin).
struct KrummDistanceCondition {
  std::string from, to;
  double distance = 0;  ///< [m]
};
std::optional<KrummDistanceCondition> krumm_distance_condition(std::string_view text);

}  // namespace plumbline::survey
