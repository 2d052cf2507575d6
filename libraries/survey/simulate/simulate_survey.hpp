// Readings of a survey that nobody made: exact sights of a layout with the noise of an instrument, and the mistakes
// that are made in the field, planted one at a time, so that the adjustment's answers can be compared with what is
// true. Frame: E, N, H [m]. The same seed gives the same readings on every machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "survey/model/instrument_profile.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

struct SimulatedPoint {
  std::string id;
  Eigen::Vector3d position;  ///< E, N, H [m]
};

struct SimulatedSetUp {
  std::string id;
  std::string station;                 ///< one of the points; the instrument stands above it
  double instrument_height = 0;        ///< of the tilting axis above the station [m]
  double orientation = 0;              ///< azimuth of the circle's zero [rad]
  std::vector<std::string> sees = {};  ///< in the order of reading; empty: every point that is no station
};

struct SurveyLayout {
  std::vector<SimulatedPoint> points;  ///< markers and stations
  std::vector<SimulatedSetUp> set_ups;
};

struct SimulationOptions {
  InstrumentProfile profile;
  int sets = 1;              ///< in both faces; readings are their means
  double noise = 1;          ///< factor on the standard deviations of the profile; 0: exact
  bool coordinates = false;  ///< the points carry their true coordinates as approximate ones
  bool sigmas = true;        ///< readings carry their standard deviation; false: the adjustment's profile decides
};

/// Direction, zenith angle (with earth curvature and k = 0.13) and slope distance of every sight. Throws
/// std::invalid_argument if a set-up names a point that is not there or stands on what it sights.
SurveyObservations simulate_survey(const SurveyLayout& layout, const SimulationOptions& options, std::uint64_t seed);

/// A facade of `markers` in rows of 2 m by 3 m with free stations before it, seen from a few metres to both sides; each
/// set-up misses a tenth of the markers (which ones: by the seed) and sights the marks of the other stations.
SurveyLayout facade_layout(int markers, int set_ups, std::uint64_t seed);

/// What goes wrong in the field. Lengths in m, angles in rad.
struct SurveyMistake {
  enum class Kind {
    reading,            ///< one reading (`observation`) is wrong by `size`
    swapped_names,      ///< `first` and `second` of one set-up have each other's name
    wrong_name,         ///< what was read to `first` is noted under the name of `second`, which the set-up does not see
    turned_circle,      ///< all directions from the n-th sight on (`from_sight`) are too large by `size`
    prism,              ///< all distances of a set-up are too long by `size`
    scale,              ///< all distances of a set-up are too long by the share `size`
    instrument_height,  ///< noted too large by `size`
    unit,               ///< all distances of a set-up are in a unit of `size` metres (0.3048: feet)
    moved_instrument    ///< from the n-th sight on the instrument stands elsewhere, `size` to the east
  } kind = Kind::reading;
  int set_up = 0;
  double size = 0;
  int observation = -1;
  int from_sight = 0;
  std::string first, second;
};

/// Plants a mistake and returns the numbers of the observations that are wrong now (none for an instrument height).
/// `layout` is what the survey was simulated from. Throws std::invalid_argument if it does not fit the survey.
std::vector<int> plant(const SurveyMistake& mistake, const SurveyLayout& layout, SurveyObservations& survey);

}  // namespace plumbline::survey
