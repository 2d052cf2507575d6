// Programs that a node starts, such as COLMAP: found as a shell finds them, and told by what they are.
//
// A node declares one as a FilePath parameter whose default is a name without '/': Param<FilePath> program{"program",
// {"colmap"}, "..."}. The host looks for the name on PATH and hands the node the path. Its key then holds the content
// of the program and of the libraries that the loader gives it; and who wants another program names it by its path.
#pragma once

#include <filesystem>
#include <string>

#include "plumbline/plugin.h"
#include "runtime/store/file_hashes.hpp"

namespace plumbline::runtime {

bool names_program(const plumbline_param& param);

/// Whether a file begins with "#!".
bool is_script(const std::filesystem::path& program);

/// The absolute path of the first file of that name on PATH that may be executed; the name itself if there is none.
std::string find_program(const std::string& name);

/// "sha256:<hash> libraries:<hash>"; of a script "sha256:<hash> says:<hash>", the latter of what it prints when it is
/// called with -h and of how that ends, asked once in a process; "not installed" for a name without '/'. Throws
/// std::runtime_error if it cannot be read.
std::string program_field(const std::string& program, FileHashes& files);

}  // namespace plumbline::runtime
