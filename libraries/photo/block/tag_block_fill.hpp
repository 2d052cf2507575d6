// What an adjusted block of tags says: statistics, poses, cameras, anchors, tags and control with their covariances.
#pragma once

#include "photo/block/tag_block_solve.hpp"

namespace plumbline::block {

/// Fills all of `result` but what the tests of control and groups say. `block` is what was adjusted, `model` and
/// `solved` its solution. Throws std::runtime_error where nothing checks the observations.
void fill_result(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, const TagModel& model,
                 const bundle::Layout& layout, Solved& solved, TagBlockResult& result);

}  // namespace plumbline::block
