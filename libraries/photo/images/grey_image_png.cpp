#include <png.h>

#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "photo/images/grey_image_decoders.hpp"

namespace plumbline::image_decoders {
namespace {

struct PngState {
  const Bytes* bytes = nullptr;
  std::size_t position = 0;
  std::array<char, 200> message{};
  int depth = 8;  // bits a value
};

void on_error(png_structp png, png_const_charp text) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  std::snprintf(state->message.data(), state->message.size(), "%s", text);
  png_longjmp(png, 1);
}

/// libpng warns of odd chunks around the pixels, never of the pixels themselves: those are errors (CRC, zlib, missing
/// data).
void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep target, std::size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  if (count > state->bytes->size() - state->position) png_error(png, "the file ends early");
  std::memcpy(target, state->bytes->data() + state->position, count);
  state->position += count;
}

/// Grey of 8 bit whatever the file holds: 16 bit scaled, palettes expanded, colour to luma, transparency dropped. No
/// gamma is applied. False with the reason in `state` if the data are damaged; libpng leaves by longjmp, so no
/// destructors in here.
bool decode(png_structp png, png_infop info, PngState& state, GreyImage& image, std::vector<png_bytep>& rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, &state, on_read);
  png_read_info(png, info);
  state.depth = png_get_bit_depth(png, info);
  png_set_expand(png);
  png_set_scale_16(png);
  png_set_strip_alpha(png);
  if (png_get_color_type(png, info) & PNG_COLOR_MASK_COLOR)
    png_set_rgb_to_gray(png, PNG_ERROR_ACTION_NONE, 0.299, 0.587);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  image.width = static_cast<int>(png_get_image_width(png, info));
  image.height = static_cast<int>(png_get_image_height(png, info));
  const std::size_t width = png_get_rowbytes(png, info);
  if (width != static_cast<std::size_t>(image.width)) png_error(png, "cannot be turned into grey values");
  if (width * static_cast<std::size_t>(image.height) > kMostPixels) png_error(png, "it claims too many pixels");
  image.pixels.resize(width * static_cast<std::size_t>(image.height));
  rows.resize(image.height);
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = image.pixels.data() + y * width;
  png_read_image(png, rows.data());
  png_read_end(png, nullptr);
  return true;
}

struct Reader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};

}  // namespace

GreyImage decode_png(const Bytes& bytes) {
  PngState state;
  state.bytes = &bytes;
  Reader reader;
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, on_error, on_warning);
  if (reader.png) reader.info = png_create_info_struct(reader.png);
  if (!reader.info) throw ImageFileError("libpng does not start");
  GreyImage image;
  std::vector<png_bytep> rows;
  if (!decode(reader.png, reader.info, state, image, rows))
    throw ImageFileError("damaged or truncated PNG (" + std::string(state.message.data()) + ")");
  if (state.depth == 16) require_scaled(image);
  return image;
}

}  // namespace plumbline::image_decoders
