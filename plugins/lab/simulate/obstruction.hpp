// What stands between camera and markers on a real site: scaffolding in front of the facade, and plates that were
// knocked off after the survey (section 6.6: partial occlusion and reduced visibility).
#pragma once

#include <cstdint>
#include <vector>

#include "building.hpp"

namespace plumbline::simulate {

struct ObstructionOptions {
  double scaffold_spacing = 0;   ///< between the scaffold's upright tubes [m]; 0: no scaffold
  double scaffold_distance = 1;  ///< of the tubes from the facade [m]
  double lost_plates = 0;        ///< probability of each plate that it hangs no more when the photographs are taken
};

struct Obstruction {
  double plane = 0;               ///< y of the tubes' axes in the building frame [m], negative
  double radius = 0.5 * 48.3e-3;  ///< of a scaffold tube [m]
  std::vector<double> uprights;   ///< x of upright tubes [m]; empty: no scaffold
  std::vector<double> ledgers;    ///< z of horizontal tubes [m], one a lift of 2 m
  std::vector<bool> lost;         ///< by anchor of the building; empty: none
};

/// The obstruction of a seed. Where the tubes begin is drawn, so that another seed hides other plates. Throws
/// std::invalid_argument for options out of bounds.
Obstruction make_obstruction(const Building& building, const ObstructionOptions& options, std::uint64_t seed);

/// Whether a camera at `centre` [m, building frame] sees the whole tag of anchor `index`, white edge included: the
/// plate hangs, and no tube covers part of it.
bool tag_is_free(const Obstruction& obstruction, const Building& building, std::size_t index,
                 const Eigen::Vector3d& centre);

}  // namespace plumbline::simulate
