// adjust.ceres: the blocks of adjust.schur with their minimum found by Ceres, in a plugin of its own.
// Its version names that of Ceres, which may be linked statically, where no file name does.
#include <ceres/version.h>

#include "adjuster_node.hpp"
#include "ceres_engine.hpp"

PLUMBLINE_PLUGIN("adjust_ceres", PLUMBLINE_BUILD_ID " with Ceres " CERES_VERSION_STRING,
                 "MIT; GPL-2.0-or-later as linked", plumbline::block::Adjuster<plumbline::block::CeresEngine>)
