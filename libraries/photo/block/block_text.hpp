// Lines and words of the text files that blocks come in.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumbline::block {

/// Without their ends (LF, CR or both) and in UTF-8, whatever the file is in. Throws std::runtime_error for a file that
/// cannot be read or is larger than 512 MB.
std::vector<std::string> lines_of(const std::filesystem::path& file);

/// Separated by blanks, tabs, semicolons and, if wanted, commas; no empty ones.
std::vector<std::string> words_of(const std::string& line, bool commas);

}  // namespace plumbline::block
