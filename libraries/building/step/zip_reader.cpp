#include "building/step/zip_reader.hpp"

#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace plumbline::step {
namespace {

constexpr std::uint64_t kLargest = 2ull << 30;
constexpr std::uint64_t kDensest = 1000;

[[noreturn]] void refuse(const std::string& what) { throw std::runtime_error("this ZIP archive " + what); }

/// An unsigned number, the low byte first.
std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t size) {
  if (at > bytes.size() || size > bytes.size() - at) refuse("is cut off");
  std::uint64_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

struct Entry {
  std::string name;
  std::uint64_t flags, method, crc, packed, size, offset;
};

/// The end of the central directory is the last of its kind: a comment of up to 64 kB may follow it.
std::size_t end_of_directory(std::string_view bytes) {
  const std::size_t at = bytes.rfind("PK\x05\x06");
  if (at == std::string_view::npos) refuse("is cut off: its directory is missing; was it sent in parts?");
  number(bytes, at + 20, 2);  // whole
  return at;
}

std::vector<Entry> entries_of(std::string_view bytes) {
  const std::size_t end = end_of_directory(bytes);
  if (number(bytes, end + 4, 2) != 0 || number(bytes, end + 6, 2) != 0) refuse("is one of several parts; join them");
  const std::uint64_t count = number(bytes, end + 10, 2);
  std::size_t at = number(bytes, end + 16, 4);
  if (count == 0xffff || at == 0xffffffff) refuse("is a ZIP64 archive; unpack it first");
  std::vector<Entry> entries;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (number(bytes, at, 4) != 0x02014b50) refuse("is damaged: its directory has something else in it");
    const std::size_t name = number(bytes, at + 28, 2);
    if (at + 46 + name > bytes.size()) refuse("is cut off");
    entries.push_back({std::string(bytes.substr(at + 46, name)), number(bytes, at + 8, 2), number(bytes, at + 10, 2),
                       number(bytes, at + 16, 4), number(bytes, at + 20, 4), number(bytes, at + 24, 4),
                       number(bytes, at + 42, 4)});
    at += 46 + name + number(bytes, at + 30, 2) + number(bytes, at + 32, 2);
  }
  return entries;
}

bool ends_with(std::string name, std::string_view ending) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.ends_with(ending);
}

const Entry& model_of(const std::vector<Entry>& entries) {
  std::vector<const Entry*> models;
  std::string others;
  std::vector<const Entry*> xml;
  for (const Entry& entry : entries) {
    if (entry.name.ends_with('/') || entry.name.starts_with("__MACOSX/")) continue;
    if (ends_with(entry.name, ".ifc")) models.push_back(&entry);
    if (ends_with(entry.name, ".ifcxml") || ends_with(entry.name, ".xml")) xml.push_back(&entry);
    if (others.size() < 200) others += (others.empty() ? "" : ", ") + entry.name;
  }
  if (models.empty()) models = xml;
  if (models.empty()) refuse("holds no file that ends in .ifc or .ifcxml" + (others.empty() ? "" : ", but " + others));
  if (models.size() > 1) refuse("holds several models (" + others + "): unpack it and take one");
  return *models.front();
}

std::string inflated(std::string_view packed, std::uint64_t size) {
  std::string out(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) refuse("cannot be unpacked: zlib has no memory");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int end = inflate(&stream, Z_FINISH);
  const bool whole = end == Z_STREAM_END && stream.total_out == size;
  inflateEnd(&stream);
  if (!whole) refuse("is damaged: a file in it does not unpack to the size that it states");
  return out;
}

std::string content_of(std::string_view archive, const Entry& entry) {
  if (entry.flags & 1) refuse("is encrypted: unpack " + entry.name + " first");
  if (entry.packed == 0xffffffff || entry.size == 0xffffffff) refuse("is a ZIP64 archive; unpack it first");
  if (entry.size > kLargest || entry.size > kDensest * (entry.packed + 1))
    refuse("holds " + entry.name + " with " + std::to_string(entry.size) + " bytes in " + std::to_string(entry.packed) +
           " packed ones, which nobody writes; unpack it to see what it is");
  const std::size_t begin =
      entry.offset + 30 + number(archive, entry.offset + 26, 2) + number(archive, entry.offset + 28, 2);
  if (number(archive, entry.offset, 4) != 0x04034b50)
    refuse("is damaged: " + entry.name + " is not where it should be");
  if (begin > archive.size() || entry.packed > archive.size() - begin) refuse("is cut off within " + entry.name);
  const std::string_view packed = archive.substr(begin, entry.packed);
  std::string content;
  if (entry.method == 8)
    content = inflated(packed, entry.size);
  else if (entry.method == 0 && entry.packed == entry.size)
    content = packed;
  else
    refuse("packs " + entry.name + " by method " + std::to_string(entry.method) + "; stored and deflated are read");
  if (crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())) != entry.crc)
    refuse("is damaged: the checksum of " + entry.name + " is wrong");
  return content;
}

}  // namespace

bool is_zip(std::string_view bytes) { return bytes.starts_with("PK\x03\x04"); }

ZippedIfc unzip_ifc(std::string_view archive) {
  const std::vector<Entry> entries = entries_of(archive);
  const Entry& model = model_of(entries);
  return {model.name, content_of(archive, model)};
}

std::optional<std::string> unzip_file(std::string_view archive, std::string_view name) {
  for (const Entry& entry : entries_of(archive))
    if (entry.name == name) return content_of(archive, entry);
  return std::nullopt;
}

}  // namespace plumbline::step
