// What a plugin offers, without loading it into this process.
//
// A child process loads the library, checks its whole table and sends a description of it as its last word. A child
// that ends without that word, crashes, or is silent for too long is the reason why the library is refused. A
// description is remembered in $XDG_CACHE_HOME/plumbline/plugins under the hash of the library, and holds as long as
// neither the libraries it was linked with nor where the loader looks for them have changed.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "runtime/plugins/plugin_table.hpp"
#include "runtime/plugins/roles.hpp"

namespace plumbline::runtime {

struct PluginScan {
  std::string problem;  ///< empty: `table` is sound
  std::unique_ptr<PluginTable> table;
  std::vector<std::string> linked_build_ids;
  std::vector<std::string> linked_files;  ///< names of the files behind those libraries: "libceres.so.2.1.0"
};

/// `sha256`: of the library's file. Never throws for what the library does. A library has $PLUMBLINE_SCAN_SECONDS
/// (else 20) to load; that one took longer is remembered too, so that it is waited for once, unless `look_again`.
PluginScan scan_plugin(const std::filesystem::path& library, const std::string& sha256, const Roles& roles,
                       bool look_again = false);

}  // namespace plumbline::runtime
