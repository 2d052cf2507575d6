// A place that cannot be that of its item, and what would explain it.
#pragma once

#include <Eigen/Core>
#include <string>

namespace plumbline::loop {

/// Empty if `reported` lies within `reach` of `expected` [m]; else how far it is off, and what would bring it there:
/// feet, US survey feet, millimetres, centimetres, east and north exchanged, a sign, heights and plan exchanged.
std::string place_doubt(const Eigen::Vector3d& reported, const Eigen::Vector3d& expected, double reach);

}  // namespace plumbline::loop
