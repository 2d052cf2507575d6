// Files that were not there before: written whole or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace plumbline::runtime {

/// Throws std::runtime_error: what, the reason, and what to do if the disk is full.
[[noreturn]] void fail_to_write(const std::string& what, int error);

/// Renames where nothing may be; where the file system cannot promise that, where nothing was just now. 0, or -1 and
/// errno.
int rename_to_absent(const std::filesystem::path& from, const std::filesystem::path& to);

/// Writes all bytes to a new file. Throws std::runtime_error with the reason; then nothing is left.
void write_new_file(const std::filesystem::path& path, const void* data, size_t size);

/// Copies a file's content to a new file, sharing its blocks where the file system can. Throws std::runtime_error.
void copy_file_content(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace plumbline::runtime
