// The nodes of this family; each is described in its own header.
#include "ceres_node.hpp"
#include "image_block_node.hpp"
#include "read_aicon_node.hpp"

PLUMBLINE_PLUGIN("adjust", "0.1.0", "MIT", plumbline::adjust::AdjustCeres, plumbline::adjust::AdjustImageBlock,
                 plumbline::adjust::ReadAicon)
