// A block of points as it comes from files, and what of it can be adjusted.
#pragma once

#include <string>
#include <vector>

#include "photo/block/point_block.hpp"

namespace plumbline::block {

struct ReadBlock {
  PointBlock block;
  int measurements_read = 0;
  std::vector<std::string> left_out;                   ///< what the block does not contain, with the reason
  std::vector<std::string> contradictions = {};        ///< of what is left out, that which somebody has to mend
  std::vector<std::string> files = {};                 ///< that were read, by name; empty: the one that was named
  std::vector<std::string> notes = {}, warnings = {};  ///< how a list of control was read, what was assumed of it
};

/// Leaves out what cannot be adjusted, until nothing changes: points with a single ray and no known coordinates, and
/// photos that too few points tie to the others. After add_control(): a known point needs no second ray.
void drop_unusable(ReadBlock& read);

/// All of up to five names; of more the first three and how many more there are.
std::string few_of(const std::vector<std::string>& names);

/// "1 point", "2 points".
std::string number_of(size_t count, const std::string& thing);

}  // namespace plumbline::block
