// Where the set-ups of a GSI file begin if its station blocks alone do not say. Leica instruments write the coordinates
// that they computed into the measuring blocks (81, 82, 83): coordinates minus reading is where the instrument took
// itself to stand. And a free station is computed after its targets were measured: its block stands behind them.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "survey/files/gsi.hpp"
#include "survey/files/gsi_words.hpp"

namespace plumbline::survey {

/// A set-up that begins before a block though the block does not say so.
struct GsiStart {
  std::string station;                                                 ///< empty: the file names none there
  Eigen::Vector3d coordinates = Eigen::Vector3d::Constant(kNotGiven);  ///< [m], where nothing else in the file has them
  double instrument_height = kNotGiven;                                ///< [m]
  double orientation = kNotGiven;                                      ///< azimuth of the circle's zero [rad]
  double turn = 0;     ///< [rad], added to its directions up to the station block, where the circle was set to azimuths
  std::string reason;  ///< in words, for the warning
};

struct GsiStations {
  std::map<std::size_t, GsiStart> starts;           ///< by the block that they begin before
  std::map<std::size_t, double> instrument_height;  ///< [m], from this block on, where 83 shows that it changed
  std::set<std::size_t> oriented;                   ///< sightings whose circle reads azimuths
  std::map<std::size_t, std::string> renamed;       ///< sightings whose number was used before, for another place
  std::set<std::size_t> continued;                  ///< station blocks whose set-up began before them
  /// Sightings beside the point that was meant, a tree's middle or a pillar's: from what was sighted to the coordinates
  /// of their block [m]; NaN: not to be told.
  std::map<std::size_t, Eigen::Vector3d> offsets;
};

/// Plans the set-ups of `blocks`, which are those of the whole file in order. `foot`: as gsi_length.
GsiStations plan_gsi_stations(const std::vector<GsiBlock>& blocks, const GsiOptions& options, double foot);

}  // namespace plumbline::survey
