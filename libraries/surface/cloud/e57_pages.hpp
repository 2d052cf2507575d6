// The pages of an E57 file: 1020 bytes and a checksum each. What is in them is read as if the checksums were not there.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "surface/cloud/cloud_stream.hpp"

namespace plumbline::cloud {

/// CRC-32C (Castagnoli) of `bytes` bytes.
std::uint32_t crc32c(const unsigned char* data, std::size_t bytes);

class E57Pages {
 public:
  /// Reads the head of the file. Throws CloudError for another version, another size of pages, and a file shorter than
  /// its head says.
  explicit E57Pages(CloudStream& stream);

  /// Moves to a place given as the file gives places: with checksums. Throws CloudError if it lies outside the file or
  /// in a checksum; `what` is looked for there.
  void seek_physical(std::uint64_t place, const char* what);
  void skip(std::uint64_t bytes) { position_ += bytes; }
  /// Reads so many bytes from page to page. Throws CloudError where a page's checksum does not fit its content, and at
  /// the end of the file.
  void read(char* to, std::uint64_t bytes, const char* what);
  std::uint64_t position() const { return position_; }  ///< without checksums
  /// Where that is in the file, for messages.
  std::uint64_t physical() const { return position_ / kContent * kPage + position_ % kContent; }
  std::uint64_t content_left() const { return content_size() - std::min(position_, content_size()); }
  /// The XML section, whole.
  std::string xml();
  CloudStream& stream() { return stream_; }

 private:
  static constexpr std::uint64_t kPage = 1024, kContent = 1020;
  std::uint64_t content_size() const { return stream_.size() / kPage * kContent; }
  void load(std::uint64_t page, const char* what);

  CloudStream& stream_;
  std::array<unsigned char, kPage> page_{};
  std::uint64_t loaded_ = ~0ULL, position_ = 0, xml_at_ = 0, xml_length_ = 0;
};

}  // namespace plumbline::cloud
