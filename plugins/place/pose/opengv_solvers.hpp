// Solvers of OpenGV behind the interface of geometry/tag_pose.hpp.
// OpenGV: L. Kneip and P. Furgale (2014), OpenGV: A unified and generalized approach to real-time calibrated geometric
// vision.
#pragma once

#include <string>
#include <vector>

#include "geometry/tag_pose.hpp"
#include "photo/pose/rig_pose.hpp"

namespace plumbline::pose {

/// p3p_kneip, p3p_gao, epnp, upnp. gp3p and gpnp are for rigs, below: with one projection centre their equations are
/// degenerate.
const std::vector<std::string>& opengv_solver_names();

/// p3p_kneip: Kneip, Scaramuzza and Siegwart (2011); p3p_gao: Gao et al. (2003); both use one corner of each tag of the
/// sample. epnp: Lepetit, Moreno-Noguer and Fua (2009); upnp: Kneip, Li and Seo (2014); both use all corners. Throws
/// std::runtime_error that lists the names if `name` is none of them.
TagPoseSolver make_opengv_solver(const std::string& name);

/// gp3p: Kneip, Furgale and Siegwart (2013), on one corner of each tag of the sample; gpnp: the same, on all corners;
/// upnp: Kneip, Li and Seo (2014), likewise. A sample that one camera shows alone goes to p3p_kneip, epnp or upnp.
/// Throws std::runtime_error that lists the names if `name` is none of them.
RigPoseSolver make_opengv_rig_solver(const std::string& name);

}  // namespace plumbline::pose
