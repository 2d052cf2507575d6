#include "plumbline/file_end.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <set>
#include <string>
#include <vector>

namespace plumbline {
namespace {

/// Numbers of a file by their place; what lies behind its end is noticed and counts as zero.
class Numbers {
 public:
  explicit Numbers(const std::filesystem::path& path) : stream_(path, std::ios::binary | std::ios::ate) {
    if (stream_) size_ = static_cast<std::uint64_t>(stream_.tellg());
  }
  std::uint64_t size() const { return size_; }
  bool ended() const { return ended_; }
  void need(std::uint64_t end) { ended_ = ended_ || end > size_; }
  std::string text(std::uint64_t at, std::size_t count) {
    need(at + count);
    if (at >= size_ || at + count > size_) return std::string(count, '\0');
    std::string bytes(count, '\0');
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(bytes.data(), static_cast<std::streamsize>(count));
    return bytes;
  }
  std::uint64_t number(std::uint64_t at, std::size_t count, bool little) {
    std::string bytes = text(at, count);
    if (little) std::reverse(bytes.begin(), bytes.end());
    std::uint64_t value = 0;
    for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
    return value;
  }

 private:
  std::ifstream stream_;
  std::uint64_t size_ = 0;
  bool ended_ = false;
};

/// Directories of a TIFF and what they name.
class TiffWalk {
 public:
  explicit TiffWalk(Numbers& file) : file_(file), little_(file.text(0, 1) == "I") {}

  void walk() {
    todo_ = {file_.number(4, 4, little_)};
    constexpr std::size_t most = 1000;  // directories; a file that is damaged may name itself in a ring
    while (!todo_.empty() && seen_.size() < most && !file_.ended()) {
      const std::uint64_t at = todo_.back();
      todo_.pop_back();
      if (at != 0 && seen_.insert(at).second) directory(at);
    }
  }

 private:
  enum Tag : std::uint64_t {
    strip_offsets = 273,
    strip_bytes = 279,
    tile_offsets = 324,
    tile_bytes = 325,
    sub_directories = 330,
    jpeg_offset = 513,
    jpeg_bytes = 514
  };

  void directory(std::uint64_t at) {
    const std::uint64_t entries = file_.number(at, 2, little_);
    std::vector<std::uint64_t> offsets, bytes;
    for (std::uint64_t i = 0; i < entries && !file_.ended(); ++i) {
      const std::uint64_t entry = at + 2 + 12 * i, tag = file_.number(entry, 2, little_);
      const std::vector<std::uint64_t> values = values_of(entry, tag);
      const auto add = [&](std::vector<std::uint64_t>& list) { list.insert(list.end(), values.begin(), values.end()); };
      if (tag == strip_offsets || tag == tile_offsets || tag == jpeg_offset) add(offsets);
      if (tag == strip_bytes || tag == tile_bytes || tag == jpeg_bytes) add(bytes);
      if (tag == sub_directories) add(todo_);
    }
    todo_.push_back(file_.number(at + 2 + 12 * entries, 4, little_));
    // Programs that write byte counts wrongly are read all the same: then only where pixels begin is known.
    for (std::size_t i = 0; i < offsets.size(); ++i)
      file_.need(offsets[i] + (offsets.size() == bytes.size() ? bytes[i] : 0));
  }

  /// Whole numbers of an entry whose tag is looked at; none of others.
  std::vector<std::uint64_t> values_of(std::uint64_t entry, std::uint64_t tag) {
    static constexpr std::size_t bytes_of_type[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4};
    const std::uint64_t type = file_.number(entry + 2, 2, little_), count = file_.number(entry + 4, 4, little_);
    if (type >= std::size(bytes_of_type)) return {};
    const std::uint64_t size = bytes_of_type[type], whole = size * count;
    const std::uint64_t at = whole > 4 ? file_.number(entry + 8, 4, little_) : entry + 8;
    const bool looked_at = tag == strip_offsets || tag == strip_bytes || tag == tile_offsets || tag == tile_bytes ||
                           tag == sub_directories || tag == jpeg_offset || tag == jpeg_bytes;
    if (!looked_at) return {};  // a wrong entry that nobody reads is passed over by readers, too
    file_.need(at + whole);
    if (file_.ended() || (size != 2 && size != 4)) return {};
    std::vector<std::uint64_t> values;
    for (std::uint64_t i = 0; i < count; ++i) values.push_back(file_.number(at + size * i, size, little_));
    return values;
  }

  Numbers& file_;
  bool little_;
  std::vector<std::uint64_t> todo_;
  std::set<std::uint64_t> seen_;
};

}  // namespace

bool lacks_part_of_tiff(const std::filesystem::path& path) {
  Numbers file(path);
  const std::string mark = file.text(0, 4);
  if (file.ended() || (mark != std::string("II*\0", 4) && mark != std::string("MM\0*", 4))) return false;
  TiffWalk(file).walk();
  return file.ended();
}

bool lacks_part_of_boxes(const std::filesystem::path& path) {
  Numbers file(path);
  if (file.text(4, 4) != "ftyp") return false;
  for (std::uint64_t at = 0; at < file.size() && !file.ended();) {
    std::uint64_t size = file.number(at, 4, false);
    if (size == 0) return false;  // the last box, which ends with the file
    if (size == 1) size = file.number(at + 8, 8, false);
    if (size < 8 || size > file.size() - at) return true;
    at += size;
  }
  return file.ended();
}

}  // namespace plumbline
