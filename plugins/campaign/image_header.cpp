#include "image_header.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <exiv2/exiv2.hpp>
#include <fstream>
#include <limits>
#include <mutex>
#include <vector>

#include "campaign_folder.hpp"

namespace plumbline::campaign {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes read_all(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  if (!stream) throw CampaignError(path, 0, "the image cannot be opened; is it there, and may it be read?");
  Bytes bytes(static_cast<std::size_t>(stream.tellg()));
  stream.seekg(0);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream) throw CampaignError(path, 0, "the image cannot be read to its end");
  return bytes;
}

std::uint32_t big_endian(const Bytes& b, std::size_t at, int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | b[at + static_cast<std::size_t>(i)];
  return value;
}

[[noreturn]] void refuse_truncated(const std::filesystem::path& path, std::size_t size, const char* kind) {
  throw CampaignError(path, 0,
                      std::string("the ") + kind + " is truncated: it stops after " + std::to_string(size) +
                          " bytes without its end mark; copy it again from the camera");
}

/// The end of entropy-coded data: the next marker that is neither a stuffed zero nor a restart.
std::size_t skip_scan(const Bytes& b, std::size_t at) {
  while (at + 1 < b.size()) {
    const void* found = std::memchr(b.data() + at, 0xff, b.size() - at - 1);
    if (!found) return b.size();
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - b.data());
    const std::uint8_t next = b[at + 1];
    if (next == 0xff) {
      ++at;
    } else if (next == 0 || (next >= 0xd0 && next <= 0xd7)) {
      at += 2;
    } else {
      return at;
    }
  }
  return b.size();
}

/// ISO/IEC 10918-1 annex B: segments up to the end-of-image marker.
void walk_jpeg(const Bytes& b, const std::filesystem::path& path, ImageHeader& header) {
  std::size_t at = 2;
  while (true) {
    while (at < b.size() && b[at] == 0xff && at + 1 < b.size() && b[at + 1] == 0xff) ++at;  // fill bytes
    if (at + 4 > b.size() && !(at + 2 <= b.size() && b[at] == 0xff && b[at + 1] == 0xd9))
      refuse_truncated(path, b.size(), "JPEG");
    if (b[at] != 0xff) {
      throw CampaignError(path, 0, "the JPEG is damaged: no marker at byte " + std::to_string(at));
    }
    const std::uint8_t marker = b[at + 1];
    if (marker == 0xd9) break;
    const std::size_t length = big_endian(b, at + 2, 2);
    if (length < 2 || at + 2 + length > b.size()) refuse_truncated(path, b.size(), "JPEG");
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame && length >= 7) {
      header.height = static_cast<int>(big_endian(b, at + 5, 2));
      header.width = static_cast<int>(big_endian(b, at + 7, 2));
    }
    at += 2 + length;
    if (marker == 0xda) at = skip_scan(b, at);
  }
  if (header.width == 0 || header.height == 0) throw CampaignError(path, 0, "the JPEG holds no image");
}

/// ISO/IEC 15948: chunks up to IEND.
void walk_png(const Bytes& b, const std::filesystem::path& path, ImageHeader& header) {
  for (std::size_t at = 8;;) {
    if (at + 12 > b.size()) refuse_truncated(path, b.size(), "PNG");
    const std::size_t length = big_endian(b, at, 4);
    if (length > b.size() || at + 12 + length > b.size()) refuse_truncated(path, b.size(), "PNG");
    if (std::memcmp(b.data() + at + 4, "IHDR", 4) == 0 && length >= 8) {
      header.width = static_cast<int>(big_endian(b, at + 8, 4));
      header.height = static_cast<int>(big_endian(b, at + 12, 4));
    }
    if (std::memcmp(b.data() + at + 4, "IEND", 4) == 0) break;
    at += 12 + length;
  }
  if (header.width <= 0 || header.height <= 0) throw CampaignError(path, 0, "the PNG holds no image");
}

std::string text_of(const Exiv2::ExifData& exif, const char* key) {
  const auto found = exif.findKey(Exiv2::ExifKey(key));
  return found == exif.end() ? std::string() : found->toString();
}

void read_exif(const Bytes& b, const std::filesystem::path& path, bool size_too, ImageHeader& header) {
  static std::mutex once_at_a_time;  // Exiv2's XMP part is not safe between threads
  const std::lock_guard lock(once_at_a_time);
  try {
    const auto image = Exiv2::ImageFactory::open(b.data(), static_cast<long>(b.size()));
    image->readMetadata();
    const Exiv2::ExifData& exif = image->exifData();
    header.make = text_of(exif, "Exif.Image.Make");
    header.model = text_of(exif, "Exif.Image.Model");
    header.taken_at = text_of(exif, "Exif.Photo.DateTimeOriginal");
    const auto focal = exif.findKey(Exiv2::ExifKey("Exif.Photo.FocalLength"));
    if (focal != exif.end() && focal->count() > 0) header.focal_length = 1e-3 * static_cast<double>(focal->toFloat());
    if (size_too) header.width = image->pixelWidth(), header.height = image->pixelHeight();
  } catch (const Exiv2::Error& error) {
    // Metadata are a courtesy, the pixels are not: a TIFF without a readable directory has no size.
    if (size_too) throw CampaignError(path, 0, std::string("the TIFF cannot be read: ") + error.what());
  }
}

}  // namespace

ImageHeader read_image_header(const std::filesystem::path& path) {
  const Bytes bytes = read_all(path);
  ImageHeader header;
  header.focal_length = std::numeric_limits<double>::quiet_NaN();
  const auto begins = [&](std::initializer_list<std::uint8_t> magic) {
    return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
  };
  const bool jpeg = begins({0xff, 0xd8, 0xff}), png = begins({0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a});
  const bool tiff = begins({'I', 'I', 42, 0}) || begins({'M', 'M', 0, 42});
  if (jpeg) {
    walk_jpeg(bytes, path, header);
  } else if (png) {
    walk_png(bytes, path, header);
  } else if (!tiff) {
    throw CampaignError(
        path, 0,
        bytes.empty() ? "the image is empty" : "this is no JPEG, PNG or TIFF; take it out of `images` or convert it");
  }
  read_exif(bytes, path, tiff, header);
  if (header.width <= 0 || header.height <= 0) throw CampaignError(path, 0, "the image has no size");
  return header;
}

}  // namespace plumbline::campaign
