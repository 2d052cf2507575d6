// dense.plane_sweep, dense.sgm, dense.import, surface.fuse, surface.planes, surface.panels, surface.joints,
// surface.scan_joints, surface.orthophoto, surface.judge and write.cloud.
#include "fuse_node.hpp"
#include "import_node.hpp"
#include "joints_node.hpp"
#include "judge_node.hpp"
#include "orthophoto_node.hpp"
#include "panels_node.hpp"
#include "planes_node.hpp"
#include "scan_joints_node.hpp"
#include "sgm_node.hpp"
#include "sweep_node.hpp"
#include "write_node.hpp"

PLUMBLINE_PLUGIN("surface", PLUMBLINE_BUILD_ID, "MIT", plumbline::surface::PlaneSweep, plumbline::surface::SemiGlobal,
                 plumbline::surface::ImportCloud, plumbline::surface::Fuse, plumbline::surface::FindPlanes,
                 plumbline::surface::Panels, plumbline::surface::Joints, plumbline::surface::ScanJoints,
                 plumbline::surface::OrthophotoNode, plumbline::surface::JudgeSurfaces, plumbline::surface::WriteCloud)
