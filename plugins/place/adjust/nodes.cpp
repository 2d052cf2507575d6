// The nodes of this family; each is described in its own header.
#include "adjuster_node.hpp"
#include "cost_node.hpp"
#include "crossval_node.hpp"
#include "read_block_nodes.hpp"
#include "target_block_node.hpp"

PLUMBLINE_PLUGIN("adjust", PLUMBLINE_BUILD_ID, "MIT", plumbline::block::Adjuster<plumbline::block::SchurEngine>,
                 plumbline::block::ReadAicon, plumbline::block::ReadPhotoModeler, plumbline::block::ReadBal,
                 plumbline::block::WriteBal, plumbline::block::ReadImageBlock, plumbline::block::EvaluateCost,
                 plumbline::block::EvaluateCrossval, plumbline::block::BlockOfTargets)
