// Large File artifacts: built where they are committed from, without a copy of the content on the way.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "artifacts/file.hpp"

namespace plumbline {

/// Artifacts address their content with 32 bits.
inline constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 30;

/// The artifact with `size` bytes of content that `fill(char* to)` writes, to be committed as it is.
template <typename Fill>
flatbuffers::FlatBufferBuilder file_artifact(const std::string& name, const std::string& media_type, std::size_t size,
                                             Fill fill) {
  if (size > largest_file)
    throw std::runtime_error(name + " has " + std::to_string(size) + " bytes; files of up to 1 GiB can be taken");
  flatbuffers::FlatBufferBuilder builder(size + name.size() + media_type.size() + 256);
  std::uint8_t* to = nullptr;
  const auto content = builder.CreateUninitializedVector(size, 1, &to);
  fill(reinterpret_cast<char*>(to));
  const auto name_at = builder.CreateString(name);
  const auto type_at = media_type.empty() ? 0 : builder.CreateString(media_type);
  FileBuilder file(builder);
  file.add_name(name_at);
  if (!media_type.empty()) file.add_media_type(type_at);
  file.add_content(flatbuffers::Offset<flatbuffers::Vector<std::uint8_t>>(content));
  FinishFileBuffer(builder, file.Finish());
  return builder;
}

/// The file at `path` under its base name. Throws std::runtime_error if it cannot be read.
inline flatbuffers::FlatBufferBuilder file_artifact(const std::filesystem::path& path, const std::string& media_type) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw std::runtime_error("cannot read " + path.string() + ": " + error.message());
  return file_artifact(path.filename().string(), media_type, size, [&](char* to) {
    std::ifstream stream(path, std::ios::binary);
    stream.read(to, static_cast<std::streamsize>(size));
    if (!stream) throw std::runtime_error("cannot read " + path.string());
  });
}

}  // namespace plumbline
