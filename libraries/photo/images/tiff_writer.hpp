// Grey pictures as TIFF files.
#pragma once

#include <filesystem>

#include "photo/images/grey_image.hpp"

namespace plumbline {

/// Writes a TIFF of 8-bit grey values, deflated, with `per_metre` pixels a metre as its resolution (0: none). The same
/// input gives the same bytes. Throws std::runtime_error if the disk refuses.
void write_grey_tiff(const std::filesystem::path& path, int width, int height, const std::uint8_t* pixels,
                     double per_metre = 0);

}  // namespace plumbline
