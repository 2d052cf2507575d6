// Floor by floor and axis by axis: how the anchors of a facade stand against the design on the whole.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"

namespace plumbline::judgement {

/// Anchors of one facade on one floor, or at one axis of the grid.
struct PlaceStatistics {
  std::string facade;     ///< empty: they face nowhere that is known
  bool confirmed = true;  ///< which way it faces; else right and out may be left and in
  std::string kind;       ///< "floor" or "axis"
  std::string name;       ///< "2", "4"
  int anchors = 0, measured = 0, passed = 0, undecided = 0, failed = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();    ///< as-built minus design: right, up, out [m]; nan: none measured
  Eigen::Vector3d spread = Eigen::Vector3d::Zero();  ///< standard deviation about it [m]; nan below two
};

/// Facades in their order, of each first the floors from below, then the axes in the order in which they stand from
/// left to right. `axis_of` gives the tag of an anchor's axis, empty: none. Anchors of facades whose direction is
/// unknown count along x, z and −y of the design.
std::vector<PlaceStatistics> place_statistics(const DeviationT& deviation,
                                              const std::function<std::string(const AnchorDeviationT&)>& axis_of);

}  // namespace plumbline::judgement
