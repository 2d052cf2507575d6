// Reads the exchange files of AICON's bundle adjustment: image coordinates (.phc), object coordinates (.obc), exterior
// (.eor) and interior (.ior) orientation, distances (.scale). Blank-separated text, millimetres and radians.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "photo/block/point_block.hpp"

namespace plumbline::block {

struct AiconBlock {
  PointBlock block;  ///< object space in metres
  int measurements_read = 0;
  /// What the files hold but the block does not, with the reason: "8 measurements of point 1087: not in example.obc".
  std::vector<std::string> left_out;
};

/// Reads the one file of each kind in `folder`; .scale may be missing. Object points that are switched off (column 9 of
/// .obc is 0) and measurements that are switched off (column 10 of .phc is 0) or belong to no point or image are left
/// out. Throws std::runtime_error with file, line, what was found and what was expected.
AiconBlock read_aicon_folder(const std::filesystem::path& folder);

}  // namespace plumbline::block
