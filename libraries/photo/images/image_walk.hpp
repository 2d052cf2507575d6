// The segments and chunks of a photograph's file without its pixels. Private to libraries/photo/images.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace plumbline::image_decoders {

struct WalkedImage {
  int width = 0, height = 0;  ///< [px]; 0 for a TIFF, whose directory has it
  bool is_tiff = false;
  int jpeg_quality = 0;            ///< as PhotographHeader::jpeg_quality
  std::vector<std::uint8_t> exif;  ///< "Exif", two zeros and a TIFF structure; empty without
};

/// Size and EXIF block of a JPEG or PNG; only the kind of a TIFF. `to_the_end` goes on to the mark of the end (of a
/// TIFF to all that its directories name), so that a truncated file is found. Throws std::runtime_error with the
/// reason, without the path.
WalkedImage walk_image(const std::filesystem::path& path, bool to_the_end);

}  // namespace plumbline::image_decoders
