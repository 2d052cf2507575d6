// dense.plane_sweep, dense.sgm, dense.import, surface.fuse, surface.panels, surface.joints, surface.orthophoto and
// surface.judge.
#include "fuse_node.hpp"
#include "import_node.hpp"
#include "joints_node.hpp"
#include "judge_node.hpp"
#include "orthophoto_node.hpp"
#include "panels_node.hpp"
#include "sgm_node.hpp"
#include "sweep_node.hpp"

PLUMBLINE_PLUGIN("surface", "0.1.0", "MIT", plumbline::surface::PlaneSweep, plumbline::surface::SemiGlobal,
                 plumbline::surface::ImportCloud, plumbline::surface::Fuse, plumbline::surface::Panels,
                 plumbline::surface::Joints, plumbline::surface::OrthophotoNode, plumbline::surface::JudgeSurfaces)
