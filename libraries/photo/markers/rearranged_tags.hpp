// Tags that stand elsewhere from photograph to photograph: no block, whatever adjusts it.
#pragma once

#include <string>

#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {

/// Compares the distances between tags, each from its own pose, from photograph to photograph: a quarter of the
/// distance and the size of a tag is more than a pose by one tag is wrong by. Where half of the pairs that are seen
/// together in several photographs differ by more, says so, with an example and the tags that stand in most such pairs;
/// where those that differ have one tag in common, and most of its own do, names that; else empty.
std::string rearranged_tags(const MarkerBlock& block);

}  // namespace plumbline::markers
