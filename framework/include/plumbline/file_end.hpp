// Whether a file of a photograph is there to its end, by what its own structure says: a copy that is under way, or was
// broken off, has a file of the right name and half the pixels. Library: Plumbline::folder_files.
#pragma once

#include <filesystem>

namespace plumbline {

/// True for a TIFF (revision 6.0), or a raw photograph built like one (DNG, NEF, ARW, CR2), whose directories name
/// strips, tiles, compressed pictures or values behind the end of the file. False for what is no TIFF.
bool lacks_part_of_tiff(const std::filesystem::path& path);

/// True for a file of boxes (ISO/IEC 14496-12: HEIC, AVIF, CR3) whose boxes do not fit into it. False for what has
/// none.
bool lacks_part_of_boxes(const std::filesystem::path& path);

}  // namespace plumbline
