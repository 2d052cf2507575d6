// Points of an artifact as the library takes them.
#pragma once

#include <string>

#include "artifacts/points.hpp"
#include "building/judgement/accuracy.hpp"

namespace plumbline::judgement {

/// Positions with their covariance: the packed lower triangle, else the standard deviations, else 0 x 0. `what` names
/// the port in messages. The artifact is read where it lies: a joint covariance of 2400 points is 207 MB, and most of
/// it may be zeros.
PointSet point_set(const Points& points, const std::string& what);

}  // namespace plumbline::judgement
