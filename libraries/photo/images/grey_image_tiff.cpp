#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "photo/images/grey_image_decoders.hpp"

namespace plumbline::image_decoders {
namespace {

/// What libtiff reads from and complains to.
struct TiffState {
  const Bytes* bytes = nullptr;
  std::size_t position = 0;
  std::string message;
};

TiffState& state_of(thandle_t handle) { return *static_cast<TiffState*>(handle); }

tmsize_t on_read(thandle_t handle, void* target, tmsize_t count) {
  TiffState& state = state_of(handle);
  const std::size_t left = state.bytes->size() - std::min(state.position, state.bytes->size());
  const std::size_t taken = std::min(left, static_cast<std::size_t>(count));
  if (taken > 0) std::memcpy(target, state.bytes->data() + state.position, taken);
  state.position += taken;
  return static_cast<tmsize_t>(taken);
}

tmsize_t on_write(thandle_t, void*, tmsize_t) { return 0; }

toff_t on_seek(thandle_t handle, toff_t offset, int whence) {
  TiffState& state = state_of(handle);
  if (whence == SEEK_CUR) offset += state.position;
  if (whence == SEEK_END) offset += state.bytes->size();
  state.position = offset;
  return offset;
}

int on_close(thandle_t) { return 0; }
toff_t on_size(thandle_t handle) { return state_of(handle).bytes->size(); }

int on_error(TIFF*, void* user, const char*, const char* format, std::va_list arguments) {
  char text[200];
  std::vsnprintf(text, sizeof text, format, arguments);
  auto& message = static_cast<TiffState*>(user)->message;
  if (message.empty()) message = text;
  return 1;  // said; libtiff need not print it
}

int on_warning(TIFF*, void*, const char*, const char*, std::va_list) { return 1; }

using Tiff = std::unique_ptr<TIFF, void (*)(TIFF*)>;

Tiff open(TiffState& state) {
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_error, &state);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_warning, &state);
  // "m": no memory mapping, the bytes are in memory as they are.
  return {TIFFClientOpenExt("image", "rm", &state, on_read, on_write, on_seek, on_close, on_size, nullptr, nullptr,
                            options.get()),
          [](TIFF* tiff) {
            if (tiff) TIFFClose(tiff);
          }};
}

/// Deflated, some kilobytes can claim any size, and libtiff wants four bytes a pixel beside ours.
constexpr std::size_t kMostTiffPixels = 250'000'000;

}  // namespace

GreyImage decode_tiff(const Bytes& bytes) {
  TiffState state;
  state.bytes = &bytes;
  const auto fail = [&state] { throw ImageFileError("damaged or truncated TIFF (" + state.message + ")"); };
  const Tiff tiff = open(state);
  if (!tiff) fail();
  std::uint32_t width = 0, height = 0;
  TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
  const std::size_t count = static_cast<std::size_t>(width) * height;
  if (count == 0 || count > kMostTiffPixels)
    throw ImageFileError("a TIFF that claims " + std::to_string(width) + " x " + std::to_string(height) +
                         " pixels, expected 1 to " + std::to_string(kMostTiffPixels / 1'000'000) +
                         " million; a larger photograph is read as PNG or JPEG");
  std::uint32_t kind = 0;
  if (TIFFGetField(tiff.get(), TIFFTAG_SUBFILETYPE, &kind) && (kind & FILETYPE_REDUCEDIMAGE) != 0)
    throw ImageFileError("a camera's raw file (its first image is a preview of " + std::to_string(width) + " x " +
                         std::to_string(height) + " pixels); develop it, and export it as TIFF or JPEG");
  std::uint16_t depth = 8;
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_BITSPERSAMPLE, &depth);
  // Asking for the orientation that the file has leaves the pixels where the sensor had them.
  std::uint16_t orientation = ORIENTATION_TOPLEFT;
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_ORIENTATION, &orientation);
  std::vector<std::uint32_t> rgba(count);
  if (!TIFFReadRGBAImageOriented(tiff.get(), width, height, rgba.data(), orientation, 1)) fail();
  if (!state.message.empty()) fail();
  GreyImage image{static_cast<int>(width), static_cast<int>(height), std::vector<std::uint8_t>(count)};
  std::transform(rgba.begin(), rgba.end(), image.pixels.begin(), [](std::uint32_t v) {
    const std::uint32_t luma = 299 * TIFFGetR(v) + 587 * TIFFGetG(v) + 114 * TIFFGetB(v);
    return static_cast<std::uint8_t>((luma + 500) / 1000);
  });
  if (depth == 16) require_scaled(image);
  return image;
}

}  // namespace plumbline::image_decoders
