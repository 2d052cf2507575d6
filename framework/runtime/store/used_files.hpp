// Files that a run of an executable was found to depend on, and those whose absence it depends on: a module that would
// be imported in place of another if it were there.
#pragma once

#include <ctime>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/store/file_hashes.hpp"

namespace plumbline::runtime {

/// Begins a line of the list of used files that names what was looked for and is not there.
inline constexpr std::string_view absent_mark = "absent:";

/// Stands for the hash of such a file in StoredRun::used.
inline const std::string absent_hash(64, '0');

/// The clock that files get their times from, at its next tick: what was written before it has an older time.
timespec next_tick_of_files();

/// Hash by path of what an executable that began at `started` says that it used, a line each. Throws
/// std::runtime_error for a line that is no whole path of a file, for a file that somebody else may write, and for one
/// that was written since.
std::map<std::string, std::string> hashes_of_used(const std::vector<std::string>& lines, const timespec& started,
                                                  FileHashes& hashes);

}  // namespace plumbline::runtime
