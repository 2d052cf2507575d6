// The little of ELF that the host needs: a plugin's identity note, read from the file without running it, and the build
// ids of the libraries that a loaded plugin hangs on.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::runtime {

inline constexpr std::string_view kNoPartOfKeys = " (no part of keys)";

/// Descriptor of the first note of `owner` and `type` in an ELF-64 little-endian shared library for this machine.
/// Throws std::runtime_error that says what the file is instead.
std::string read_elf_note(const std::filesystem::path& library, const std::string& owner, uint32_t type);

/// "soname:build-id" of every library that the object containing `address` needs, directly or through others; sorted.
/// For one without a build id "soname:sha256-<hash of its file>". One that is only reached through a library that
/// fetches or shows (libcurl, libX11), and that library unless the object itself needs it, ends with kNoPartOfKeys:
/// another build of it changes no number. So do the parts of the C library, in whose place stand its release ("C
/// library:glibc 2.36") and what libm computes here ("results of libm:<hash>"). Throws std::runtime_error if a file
/// cannot be read.
std::vector<std::string> linked_build_ids(const void* address);

/// The loader that an ELF program asks for (its PT_INTERP); empty for what is no such program, a script say.
std::filesystem::path elf_interpreter(const std::filesystem::path& program);

/// The build id of a library's file, "sha256-<hash>" for one without. Throws std::runtime_error if it cannot be read.
std::string id_of_library(const std::filesystem::path& library);

}  // namespace plumbline::runtime
