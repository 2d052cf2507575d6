// Lists of control points beside a block, in the dialect of all tables of control (control/control_table.hpp). Points
// without standard deviations (or with zeros) are held. A heading ("# id, name, X, Y, Z", also without '#') tells where
// X stands when names are numbers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "photo/block/read_block.hpp"

namespace plumbline::block {

/// Adds the control points of a list, matched by number or, where the block has none of its numbers, by name; those
/// named in `check` are compared with only. Points of the list that no image measures are told of, and left out those
/// that are others than the block's of that number: of their distances to the others most are not the block's. Throws
/// if none matches, if one occurs twice, or for a line that cannot be read.
void add_control(const std::filesystem::path& file, const std::vector<std::string>& check, ReadBlock& read);

}  // namespace plumbline::block
