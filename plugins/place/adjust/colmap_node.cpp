// adjust.colmap in a plugin of its own: who adjusts with our engine builds nothing of what speaks with COLMAP.
#include "colmap_adjuster_node.hpp"

PLUMBLINE_PLUGIN("adjust_colmap", PLUMBLINE_BUILD_ID, "MIT", plumbline::block::ColmapAdjuster)
