// What a floor, a facade, a column or a print batch has in common: one cause in place of many bad anchors.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "building/ifc/facade_frame.hpp"
#include "building/judgement/block_covariance.hpp"

namespace plumbline::judgement {

/// A measured anchor, as far as groups go.
struct GroupMember {
  Eigen::Vector3d deviation;        ///< as-built minus design [m]
  int floor = 0, column = 0;        ///< 0: unknown
  std::string facade, batch, axis;  ///< axis: of the grid
  ifc::FacadeFrame frame;
};

/// Whether an anchor passes with another deviation than its own; empty where none can pass: then nothing is said of it.
using WouldPass = std::function<bool(std::size_t member, const Eigen::Vector3d& deviation)>;

/// Every floor, facade, floor of a facade, grid axis, column and print batch with at least four anchors: mean and
/// spread of their deviations, and whether they are shifted together, upward and along and out of their facade (x and y
/// where they are of several). The clearest shift is taken first and away from its members before the next is looked
/// for, so that a floor that hangs low is not told again as its columns. A shift is significant at 99.9 % over all
/// groups and directions together (Bonferroni), by Student's t with the group's own scatter in that direction,
/// moderated by that of the other groups (moderated_variance.hpp), and the covariance of the measurement (3n x 3n [m²],
/// if it is known); two thirds of the group follow it, and it takes at least half of `smallest_tolerance` [m]. The
/// clearest first. `remainder`: what is left of the deviations. `whole`: the building is a group, too, for a shift
/// along one direction that a test of all six motions together does not see; its row is there only where it is
/// significant.
std::vector<std::unique_ptr<GroupShiftT>> group_shifts(const std::vector<GroupMember>& members,
                                                       const judgement::BlockCovariance& covariance,
                                                       double smallest_tolerance, const WouldPass& would_pass,
                                                       std::vector<Eigen::Vector3d>* remainder = nullptr,
                                                       bool whole = false);

}  // namespace plumbline::judgement
