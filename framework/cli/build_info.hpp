// What this program was built of, for records that somebody wants to repeat.
#pragma once

#include <string>
#include <vector>

namespace plumbline::cli {

std::string build_commit();    ///< of the tree, "-dirty" if something was not committed; "unknown" without git
std::string build_compiler();  ///< "GNU 12.2.0, Release"

/// Shared libraries that are loaded now, by the names of their files, which have the versions ("libceres.so.2.1.0").
std::vector<std::string> loaded_libraries();

}  // namespace plumbline::cli
