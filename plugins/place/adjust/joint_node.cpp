// adjust.joint in a plugin of its own: it brings the network of the survey along, which the other adjusters do not
// need.
#include "joint_node.hpp"

PLUMBLINE_PLUGIN("adjust_joint", PLUMBLINE_BUILD_ID, "MIT", plumbline::block::JointAdjuster)
