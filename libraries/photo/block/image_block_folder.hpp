// Any block of points that lies in a folder, whatever program exported it.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "photo/block/read_block.hpp"

namespace plumbline::block {

/// An AICON folder, a PhotoModeler export or a problem of bal_files.hpp, whichever `folder` holds (also in folders
/// below it). Exports are known by their name or by how they begin. `project` chooses one of several by the beginning
/// of its name or path; `control` is a list of control points, in the folder or a path of its own; empty: none. Throws
/// std::runtime_error that names what was found.
ReadBlock read_image_block(const std::filesystem::path& folder, const std::string& project, const std::string& control,
                           const std::vector<std::string>& check, const std::array<int, 2>& image_size = {0, 0});

}  // namespace plumbline::block
