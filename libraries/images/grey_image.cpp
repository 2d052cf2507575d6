#include "images/grey_image.hpp"

#include <fstream>
#include <string>

#include "images/grey_image_decoders.hpp"

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
  throw ImageFileError("is neither JPEG, PNG nor TIFF; convert it to one of these");
}

}  // namespace

GreyImage read_grey_image(const std::filesystem::path& path) {
  try {
    return decode(read_bytes(path));
  } catch (const ImageFileError& error) {
    throw ImageFileError(path.string() + ": " + error.what());
  }
}

}  // namespace plumbline
