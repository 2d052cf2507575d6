// In which unit the angles of a table of sightings are, where nobody wrote it: what the readings themselves tell.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::survey {

/// "45-30-00" or 45°30'00" [rad]; nullopt for anything else.
std::optional<double> written_dms(std::string_view text);

/// The angles of one row as written; NaN where it has none.
struct UntoldSighting {
  std::string station, target;
  double direction, zenith;
  double rise = 0;      ///< instrument minus target height over the slope distance; NaN without a distance [1]
  bool heights = true;  ///< false: the row has instrument or target heights but no distance
};

struct AngleUnit {
  std::string unit;    ///< "gon", "deg", "dms" or "rad"
  std::string reason;  ///< "12 sightings in both faces close in it"
};

/// Angles beyond 360 are gon. Else the two faces of a sighting (zenith angles that add up to a full circle, directions
/// half a circle apart) and reciprocal zenith angles (half a circle) close in one unit and not in the others. nullopt:
/// nothing tells, or it leaves two units.
std::optional<AngleUnit> tell_angle_unit(const std::vector<UntoldSighting>& sightings);

}  // namespace plumbline::survey
