// A grey image in memory, and the one function that reads it from a file.
//
// Pixels are never rotated by an EXIF orientation flag: the interior orientation of a camera belongs to the pixels as
// the sensor delivered them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "plumbline/failure.hpp"

namespace plumbline {

/// 8-bit grey values, row by row without padding; the pixel in column x and row y is pixels[y · width + x].
struct GreyImage {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  std::vector<std::uint8_t> pixels;
};

/// A file that is no image, is damaged or cut short, or is of a kind we do not read. The text names the file.
class ImageFileError : public BadInput {
 public:
  using BadInput::BadInput;
};

/// Reads a JPEG, PNG or TIFF file as grey values; the format is told by the content, not by the name. Colour is turned
/// into luma (ITU-R BT.601), 16-bit values are reduced to 8 bit. Takes width · height bytes, and for PNG and TIFF up to
/// four times that while it works. A file that is damaged or ends early is an error: decoders fill the missing part
/// with grey otherwise. Throws ImageFileError.
GreyImage read_grey_image(const std::filesystem::path& path);

}  // namespace plumbline
