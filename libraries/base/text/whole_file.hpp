// A file read at once.
#pragma once

#include <filesystem>
#include <string>

namespace plumbline::text {

/// All bytes of `file`. Throws BadInput with its name and the system's reason if it cannot be opened or read to its
/// end; a folder cannot.
std::string read_whole(const std::filesystem::path& file);

}  // namespace plumbline::text
