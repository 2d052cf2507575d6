// Solvers of OpenCV behind the interface of geometry/tag_pose.hpp.
// Not offered: EPnP, DLS and UPnP, because OpenCV 4.6 runs its EPnP for all three, and that is wrong by tens of degrees
// on points that lie in a plane, as those of a facade do.
#pragma once

#include <string>
#include <vector>

#include "geometry/tag_pose.hpp"

namespace plumbline::pose {

/// sqpnp, ippe_square, p3p, ap3p, iterative.
const std::vector<std::string>& opencv_solver_names();

/// sqpnp: Terzakis and Lourakis (2020); iterative: Levenberg-Marquardt from a linear start; both on all corners of the
/// sample. p3p: Gao et al. (2003), ap3p: Ke and Roumeliotis (2017), on one corner of each tag. ippe_square: Collins and
/// Bartoli (2014), two solutions for each tag by itself; the tags' centres in the camera frame are then aligned with
/// those in the world, for every combination of solutions, so the nominal rotation of a plate is not used. Throws
/// std::runtime_error that lists the names if `name` is none of them.
TagPoseSolver make_opencv_solver(const std::string& name);

}  // namespace plumbline::pose
