// Files that a run of an executable was found to depend on, and those whose absence it depends on: a module that would
// be imported in place of another if it were there.
#pragma once

#include <string>
#include <string_view>

namespace plumbline::runtime {

/// Begins a line of the list of used files that names what was looked for and is not there.
inline constexpr std::string_view absent_mark = "absent:";

/// Stands for the hash of such a file in StoredRun::used.
inline const std::string absent_hash(64, '0');

}  // namespace plumbline::runtime
