#include "building/step/zip_writer.hpp"

#include <zlib.h>

#include <stdexcept>

namespace plumbline::step {
namespace {

void put(std::string& to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to += static_cast<char>(value >> (8 * i) & 0xFF);
}

/// What local and central headers share: version 2.0, UTF-8 names, stored, 1 January 1980.
void put_common(std::string& to, std::uint32_t crc, std::uint32_t size, std::size_t name) {
  put(to, 20, 2), put(to, 0x0800, 2), put(to, 0, 2), put(to, 0, 2), put(to, 0x21, 2);
  put(to, crc, 4), put(to, size, 4), put(to, size, 4), put(to, name, 2), put(to, 0, 2);
}

}  // namespace

void ZipWriter::add(const std::string& name, std::string_view content) {
  const auto crc = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())));
  entries_.push_back(
      {name, crc, static_cast<std::uint32_t>(content.size()), static_cast<std::uint32_t>(bytes_.size())});
  put(bytes_, 0x04034b50, 4);
  put_common(bytes_, crc, static_cast<std::uint32_t>(content.size()), name.size());
  bytes_.append(name).append(content);
}

std::string ZipWriter::finish() {
  const std::size_t begin = bytes_.size();
  // Beyond these the counts of the format wrap around, and readers find something else.
  if (entries_.size() > kMostEntries || begin > 0xFFFFFFFFu)
    throw std::runtime_error("the ZIP has " + std::to_string(entries_.size()) + " entries of " + std::to_string(begin) +
                             " bytes together, and the format holds 65535 of 4 GB at most; write less into one file");
  for (const Entry& entry : entries_) {
    put(bytes_, 0x02014b50, 4), put(bytes_, 20, 2);
    put_common(bytes_, entry.crc, entry.size, entry.name.size());
    put(bytes_, 0, 2), put(bytes_, 0, 2), put(bytes_, 0, 2), put(bytes_, 0, 4), put(bytes_, entry.offset, 4);
    bytes_ += entry.name;
  }
  const std::size_t size = bytes_.size() - begin;
  put(bytes_, 0x06054b50, 4), put(bytes_, 0, 4);
  put(bytes_, entries_.size(), 2), put(bytes_, entries_.size(), 2), put(bytes_, size, 4), put(bytes_, begin, 4);
  put(bytes_, 0, 2);
  return std::move(bytes_);
}

}  // namespace plumbline::step
