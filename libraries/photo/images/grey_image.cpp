#include "photo/images/grey_image.hpp"

#include <algorithm>
#include <fstream>
#include <string>

#include "photo/images/grey_image_decoders.hpp"

namespace plumbline {
namespace {

using image_decoders::Bytes;

Bytes read_bytes(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw ImageFileError("no such image file");
  if (!std::filesystem::is_regular_file(path, error))
    throw ImageFileError("is not a file; expected a JPEG, PNG or TIFF image");
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  if (!stream) throw ImageFileError("cannot be opened for reading");
  Bytes bytes(static_cast<std::size_t>(stream.tellg()));
  stream.seekg(0);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream) throw ImageFileError("cannot be read to its end");
  return bytes;
}

bool starts_with(const Bytes& bytes, std::initializer_list<int> magic) {
  if (bytes.size() < magic.size()) return false;
  std::size_t i = 0;
  for (const int value : magic)
    if (bytes[i++] != value) return false;
  return true;
}

GreyImage decode(const Bytes& bytes) {
  if (bytes.empty()) throw ImageFileError("the file is empty");
  if (starts_with(bytes, {0xff, 0xd8, 0xff})) return image_decoders::decode_jpeg(bytes);
  if (starts_with(bytes, {0x89, 'P', 'N', 'G'})) return image_decoders::decode_png(bytes);
  if (starts_with(bytes, {'I', 'I', 42, 0}) || starts_with(bytes, {'M', 'M', 0, 42}))
    return image_decoders::decode_tiff(bytes);
  const std::string brand = bytes.size() >= 12 ? std::string(bytes.begin() + 4, bytes.begin() + 12) : "";
  if (brand.rfind("ftyp", 0) == 0 ||
      (brand.size() == 8 && starts_with(bytes, {'R', 'I', 'F', 'F'}) && brand.substr(4) == "WEBP"))
    throw ImageFileError("is " +
                         std::string(brand.substr(4) == "WEBP"     ? "WebP"
                                     : brand.substr(4, 3) == "avi" ? "AVIF"
                                     : brand.substr(4) == "crx "   ? "a camera's raw file"
                                                                   : "HEIC") +
                         ", whatever its name says; export it as JPEG from the program that has the original");
  throw ImageFileError("is neither JPEG, PNG nor TIFF; convert it to one of these");
}

}  // namespace

void image_decoders::require_scaled(const GreyImage& image) {
  constexpr int kDark = 64;  // of a sensor with 14 bits
  const int brightest = *std::max_element(image.pixels.begin(), image.pixels.end());
  if (brightest < kDark)
    throw ImageFileError("has 16 bits a value, of which the upper ones are not used (its brightest pixel is " +
                         std::to_string(brightest) +
                         " of 255): a sensor's 12 or 14 bits stored unscaled, or a photograph that is black. Multiply "
                         "its values up to 65535, or export it with 8 bits");
}

GreyImage read_grey_image(const std::filesystem::path& path) {
  try {
    return decode(read_bytes(path));
  } catch (const ImageFileError& error) {
    throw ImageFileError(path.string() + ": " + error.what());
  }
}

}  // namespace plumbline
