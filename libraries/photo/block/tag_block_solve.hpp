// One adjustment of a block of tags as it stands: is its datum determined, which tags stand out, and the solution.
#pragma once

#include <string>
#include <vector>

#include "photo/block/tag_block.hpp"
#include "photo/block/tag_block_model.hpp"
#include "photo/bundle/adjust.hpp"

namespace plumbline::block {

struct Solved {
  bundle::Adjusted adjusted;
  bundle::Reliability reliability;
  double variance = 1;  ///< what cofactors are multiplied by to give covariances
};

/// Throws std::runtime_error where the control leaves a motion of the block free; weak ones go to `result`. Not asked
/// of a free network.
void require_datum(const TagBlockOptions& options, const TagModel& model, TagBlockResult& result);

/// Observations of the block whose residuals stand out after a robust adjustment, which `model` is left at. The
/// yardstick is the median tag, not the a priori standard deviation: detectors' covariances may be wrong by a factor.
std::vector<int> find_blunders(const TagBlockOptions& options, const TagStart& start, TagModel& model);

/// Adjusts `model` and leaves it at its solution. Control nearly on a line (`weak_datum`) lets the block swing by
/// degrees: a failure of the iteration has this cause and no other, and is a BadInput then.
Solved solve_block(const std::vector<std::string>& weak_datum, const TagBlockOptions& options,
                   const bundle::Layout& layout, TagModel& model);

}  // namespace plumbline::block
