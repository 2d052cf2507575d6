#include "photo/images/image_walk.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "plumbline/file_end.hpp"

namespace plumbline::image_decoders {
namespace {

constexpr char kExif[] = {'E', 'x', 'i', 'f', 0, 0};
constexpr std::size_t kLargestExif = 1 << 20;  // [bytes]; of a JPEG it has 64 KiB

/// Bytes of a file by their place; a window of it is in memory.
class ByteFile {
 public:
  explicit ByteFile(const std::filesystem::path& path) : stream_(path, std::ios::binary | std::ios::ate) {
    if (!stream_) throw std::runtime_error("the image cannot be opened; is it there, and may it be read?");
    size_ = static_cast<std::size_t>(stream_.tellg());
    if (size_ == 0) throw std::runtime_error("the image is empty");
  }
  std::size_t size() const { return size_; }
  /// `at` < size().
  std::uint8_t operator[](std::size_t at) {
    if (at < first_ || at >= first_ + window_.size()) load(at, kWindow);
    return static_cast<std::uint8_t>(window_[at - first_]);
  }
  std::uint32_t big_endian(std::size_t at, int count) {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i) value = value << 8 | (*this)[at + static_cast<std::size_t>(i)];
    return value;
  }
  bool has(std::size_t at, std::string_view text) {
    if (at + text.size() > size_) return false;
    for (std::size_t i = 0; i < text.size(); ++i)
      if ((*this)[at + i] != static_cast<std::uint8_t>(text[i])) return false;
    return true;
  }
  std::vector<std::uint8_t> part(std::size_t at, std::size_t count) {
    std::vector<std::uint8_t> bytes(count);
    for (std::size_t i = 0; i < count; ++i) bytes[i] = (*this)[at + i];
    return bytes;
  }
  /// The first 0xff from `at` on, or size().
  std::size_t find_marker(std::size_t at) {
    while (at < size_) {
      if (at < first_ || at >= first_ + window_.size()) load(at, kWindow);
      const char* begin = window_.data() + (at - first_);
      const std::size_t left = window_.size() - (at - first_);
      if (const void* found = std::memchr(begin, 0xff, left))
        return at + static_cast<std::size_t>(static_cast<const char*>(found) - begin);
      at += left;
    }
    return size_;
  }

 private:
  static constexpr std::size_t kWindow = 1 << 16;
  void load(std::size_t at, std::size_t count) {
    first_ = at;
    window_.resize(std::min(count, size_ - at));
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(window_.data(), static_cast<std::streamsize>(window_.size()));
    if (!stream_) throw std::runtime_error("the image cannot be read to its end");
  }

  std::ifstream stream_;
  std::size_t size_ = 0, first_ = 0;
  std::vector<char> window_;
};

[[noreturn]] void refuse_truncated(const ByteFile& file, const char* kind) {
  throw std::runtime_error(std::string("the ") + kind + " is truncated: it stops after " + std::to_string(file.size()) +
                           " bytes without its end mark");
}

/// The end of entropy-coded data: the next marker that is neither a stuffed zero nor a restart.
std::size_t skip_scan(ByteFile& file, std::size_t at) {
  while (true) {
    at = file.find_marker(at);
    if (at + 1 >= file.size()) return file.size();
    const std::uint8_t next = file[at + 1];
    if (next == 0xff)
      ++at;
    else if (next == 0 || (next >= 0xd0 && next <= 0xd7))
      at += 2;
    else
      return at;
  }
}

/// The quality of 1 to 100 whose first table, that of brightness, has the sum of this one; 0 for a damaged segment.
/// Source: table K.1 of ISO/IEC 10918-1, whose sum is 3688, and the scale of the Independent JPEG Group
/// (jpeg_quality_scaling), after which most programs count.
int quality_of(ByteFile& file, std::size_t at, std::size_t end) {
  constexpr double of_standard = 3688;
  constexpr std::size_t values = 64;
  while (at < end) {
    const std::size_t bytes = file[at] >> 4 ? 2 : 1;
    if (at + 1 + bytes * values > end) return 0;
    if ((file[at] & 15) == 0) {
      double sum = 0;
      for (std::size_t k = 0; k < values; ++k) sum += file.big_endian(at + 1 + bytes * k, static_cast<int>(bytes));
      const double scale = 100 * sum / of_standard;  // [%]
      return std::clamp(static_cast<int>(std::lround(scale <= 100 ? 100 - 0.5 * scale : 5000 / scale)), 1, 100);
    }
    at += 1 + bytes * values;
  }
  return 0;
}

/// ISO/IEC 10918-1 annex B: segments up to the end-of-image marker, or to the first scan.
void walk_jpeg(ByteFile& file, bool to_the_end, WalkedImage& image) {
  std::size_t at = 2;
  while (true) {
    while (at + 1 < file.size() && file[at] == 0xff && file[at + 1] == 0xff) ++at;  // fill bytes
    const bool ends = at + 2 <= file.size() && file[at] == 0xff && file[at + 1] == 0xd9;
    if (at + 4 > file.size() && !ends) refuse_truncated(file, "JPEG");
    if (file[at] != 0xff) throw std::runtime_error("the JPEG is damaged: no marker at byte " + std::to_string(at));
    const std::uint8_t marker = file[at + 1];
    if (marker == 0xd9) break;
    const std::size_t length = file.big_endian(at + 2, 2);
    if (length < 2 || at + 2 + length > file.size()) refuse_truncated(file, "JPEG");
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame && length >= 7) {
      image.height = static_cast<int>(file.big_endian(at + 5, 2));
      image.width = static_cast<int>(file.big_endian(at + 7, 2));
    }
    if (marker == 0xe1 && image.exif.empty() && file.has(at + 4, {kExif, sizeof kExif}))
      image.exif = file.part(at + 4, length - 2);
    if (marker == 0xdb && image.jpeg_quality == 0) image.jpeg_quality = quality_of(file, at + 4, at + 2 + length);
    at += 2 + length;
    if (marker != 0xda) continue;
    if (!to_the_end) break;
    at = skip_scan(file, at);
  }
  if (image.width == 0 || image.height == 0) throw std::runtime_error("the JPEG holds no image");
}

/// ISO/IEC 15948: chunks up to IEND, or to the first pixels.
void walk_png(ByteFile& file, bool to_the_end, WalkedImage& image) {
  for (std::size_t at = 8;;) {
    if (at + 12 > file.size()) refuse_truncated(file, "PNG");
    const std::size_t length = file.big_endian(at, 4);
    if (length > file.size() || at + 12 + length > file.size()) refuse_truncated(file, "PNG");
    if (file.has(at + 4, "IHDR") && length >= 8) {
      image.width = static_cast<int>(file.big_endian(at + 8, 4));
      image.height = static_cast<int>(file.big_endian(at + 12, 4));
    }
    if (file.has(at + 4, "eXIf") && length < kLargestExif) {
      image.exif.assign(kExif, kExif + sizeof kExif);
      const auto block = file.part(at + 8, length);
      image.exif.insert(image.exif.end(), block.begin(), block.end());
    }
    if (file.has(at + 4, "IEND") || (!to_the_end && file.has(at + 4, "IDAT"))) break;
    at += 12 + length;
  }
  if (image.width <= 0 || image.height <= 0) throw std::runtime_error("the PNG holds no image");
}

/// TIFF 6.0: its directory may stand anywhere, and the pixels behind it.
void walk_tiff(const std::filesystem::path& path, const ByteFile& file, bool to_the_end, WalkedImage& image) {
  image.is_tiff = true;
  if (to_the_end && lacks_part_of_tiff(path))
    throw std::runtime_error("the TIFF is truncated: its directory names pixels behind its " +
                             std::to_string(file.size()) + " bytes");
}

}  // namespace

WalkedImage walk_image(const std::filesystem::path& path, bool to_the_end) {
  ByteFile file(path);
  WalkedImage image;
  using namespace std::string_view_literals;
  if (file.has(0, "\xff\xd8\xff"sv))
    walk_jpeg(file, to_the_end, image);
  else if (file.has(0, "\x89PNG\r\n\x1a\n"sv))
    walk_png(file, to_the_end, image);
  else if (file.has(0, "II*\0"sv) || file.has(0, "MM\0*"sv))
    walk_tiff(path, file, to_the_end, image);
  else
    throw std::runtime_error("this is no JPEG, PNG or TIFF; take it out of `images` or convert it");
  return image;
}

}  // namespace plumbline::image_decoders
