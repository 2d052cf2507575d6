// EXIF as texts and numbers by their tags, from a block of bytes (libexif) or from a TIFF's own directories (libtiff).
// Both keep no state between calls, so that photographs are read in parallel. Private to libraries/photo/images.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace plumbline::image_decoders {

/// Tags of Exif 2.32 that are read.
enum class ExifTag : std::uint16_t {
  make = 0x010f,
  model = 0x0110,
  orientation = 0x0112,
  taken_at = 0x9003,
  focal_length = 0x920a,
  width = 0xa002,
  height = 0xa003,
  focal_plane_resolution = 0xa20e,
  focal_plane_unit = 0xa210,
  focal_length_35mm = 0xa405,
  serial = 0xa431
};

struct Exif {
  std::map<ExifTag, std::string> texts;
  std::map<ExifTag, double> numbers;  ///< finite ones

  std::string text(ExifTag tag) const {
    const auto found = texts.find(tag);
    return found == texts.end() ? "" : found->second;
  }
  /// 0 where it is missing or not above zero.
  double positive(ExifTag tag) const {
    const auto found = numbers.find(tag);
    return found == numbers.end() || !(found->second > 0) ? 0 : found->second;
  }
};

/// Of a block that begins with "Exif" and two zeros; whatever of a damaged one can be read.
Exif parse_exif(const std::vector<std::uint8_t>& block);

struct TiffHeader {
  int width = 0, height = 0;
  Exif exif;
};
/// Throws std::runtime_error if there is no first directory.
TiffHeader read_tiff_header(const std::filesystem::path& path);

}  // namespace plumbline::image_decoders
