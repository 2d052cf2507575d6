// dense.plane_sweep, surface.panels and surface.joints.
#include "joints_node.hpp"
#include "panels_node.hpp"
#include "sweep_node.hpp"

PLUMBLINE_PLUGIN("surface", "0.1.0", "MIT", plumbline::surface::PlaneSweep, plumbline::surface::Panels,
                 plumbline::surface::Joints)
