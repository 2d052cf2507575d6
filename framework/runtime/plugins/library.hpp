// A plugin's library, opened.
#pragma once

#include <filesystem>
#include <string>

#include "plumbline/plugin.h"

namespace plumbline::runtime {

/// Loads the library into this process and calls its one function. Throws std::runtime_error with the loader's words
/// and the mend. What it returns is not looked at.
const plumbline_plugin_table* open_table(const std::filesystem::path& library);

/// Which file lies at a path now: another text when its content changes.
std::string file_identity(const std::filesystem::path& path);

}  // namespace plumbline::runtime
