// Whether anchors have moved with others that nobody had a reason to touch: then the frame has moved under them.
#pragma once

#include <string>
#include <vector>

#include "building/judgement/epoch_movements.hpp"

namespace plumbline::judgement {

/// A group whose anchors that were in order before have moved alike.
struct GroupMotion {
  std::string name;                                ///< "the building", "floor 2", "facade south", "column 3"
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< of their movements [m]
  int witnesses = 0;
};

struct GroupMotions {
  std::vector<GroupMotion> groups;  ///< those that have moved
  std::vector<int> follows;         ///< one per pair: the first group whose motion explains its own; -1: none
};

/// A fitter resets what was out of tolerance. Where at least half of the anchors of a group that were in order have
/// moved (95 % each, at least three), and two thirds of them by one motion, that is no reset: of three to five a shift,
/// of six and more a shift and a turn. `critical`: of the statistic with which an anchor still follows it.
GroupMotions group_motions(const std::vector<MeasuredTwice>& pairs, double critical);

}  // namespace plumbline::judgement
