// File artifacts: with the bytes in them, or with the place of a file that may be large.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "artifacts/file.hpp"
#include "base/text/whole_file.hpp"

namespace plumbline {

/// Artifacts address their content with 32 bits.
inline constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 30;

/// The file at `path` under its base name, with its bytes, which are not copied on the way into the artifact. Throws
/// std::runtime_error if it cannot be read.
inline flatbuffers::FlatBufferBuilder file_artifact(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw std::runtime_error("cannot read " + path.string() + ": " + error.message());
  if (size > largest_file)
    throw std::runtime_error(name + " has " + std::to_string(size) + " bytes; files of up to 1 GiB can be taken");
  flatbuffers::FlatBufferBuilder builder(size + name.size() + 256);
  std::uint8_t* to = nullptr;
  const auto content = builder.CreateUninitializedVector(size, 1, &to);
  std::ifstream stream(path, std::ios::binary);
  stream.read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(size));
  if (!stream) throw std::runtime_error("cannot read " + path.string());
  const auto name_at = builder.CreateString(name);
  FileBuilder file(builder);
  file.add_name(name_at);
  file.add_content(flatbuffers::Offset<flatbuffers::Vector<std::uint8_t>>(content));
  FinishFileBuffer(builder, file.Finish());
  return builder;
}

/// A file that stays where `uri` says.
inline FileT file_reference(const std::string& name, const std::string& media_type, const std::string& uri,
                            const std::string& sha256) {
  FileT file;
  file.name = name, file.media_type = media_type, file.uri = uri, file.sha256 = sha256;
  return file;
}

/// The bytes, wherever they are; `resolve(uri)` gives a path. Throws std::runtime_error if they cannot be read.
template <typename Resolve>
std::string file_bytes(const FileT& file, const Resolve& resolve) {
  if (file.uri.empty()) return {file.content.begin(), file.content.end()};
  return text::read_whole(resolve(file.uri));
}

}  // namespace plumbline
