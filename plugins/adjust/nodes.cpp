// The nodes of this family; each is described in its own header.
#include "adjuster_node.hpp"
#include "colmap_adjuster_node.hpp"
#include "cost_node.hpp"
#include "crossval_node.hpp"
#include "joint_node.hpp"
#include "read_block_nodes.hpp"
#include "target_block_node.hpp"

PLUMBLINE_PLUGIN("adjust", "0.1.0", "MIT", plumbline::adjust::Adjuster<plumbline::adjust::SchurEngine>,
                 plumbline::adjust::ColmapAdjuster,
                 plumbline::adjust::JointAdjuster, plumbline::adjust::ReadAicon, plumbline::adjust::ReadPhotoModeler,
                 plumbline::adjust::ReadBal, plumbline::adjust::WriteBal, plumbline::adjust::ReadImageBlock,
                 plumbline::adjust::EvaluateCost, plumbline::adjust::EvaluateCrossval,
                 plumbline::adjust::BlockOfTargets)
