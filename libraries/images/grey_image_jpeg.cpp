#include <array>
#include <csetjmp>
#include <cstdio>
#include <memory>
#include <string>

// After <cstdio>, which libjpeg's header needs but does not include.
#include <jpeglib.h>
// After jpeglib.h.
#include <jerror.h>

#include "images/grey_image_decoders.hpp"

namespace plumbline::image_decoders {
namespace {

/// What libjpeg's callbacks reach through `cinfo->client_data`. libjpeg is C: its errors leave by longjmp, so nothing
/// with a destructor may live between setjmp and the calls into it.
struct JpegState {
  jpeg_error_mgr errors{};
  std::jmp_buf leave{};
  std::array<char, JMSG_LENGTH_MAX> message{};
};

void on_error(j_common_ptr cinfo) {
  auto* state = static_cast<JpegState*>(cinfo->client_data);
  (*cinfo->err->format_message)(cinfo, state->message.data());
  std::longjmp(state->leave, 1);
}

/// libjpeg calls what it repairs by guessing a warning. All of them but these three mean that pixels are invented.
void on_message(j_common_ptr cinfo, int level) {
  if (level >= 0) return;
  const int code = cinfo->err->msg_code;
  if (code == JWRN_EXTRANEOUS_DATA || code == JWRN_JFIF_MAJOR || code == JWRN_ADOBE_XFORM) return;
  on_error(cinfo);
}

/// Decodes into `image`; false with the reason in `state.message` if the data are damaged. Only luma is decoded: half
/// the time and a third of the memory of colour.
bool decode(const Bytes& bytes, JpegState& state, jpeg_decompress_struct& cinfo, GreyImage& image) {
  if (setjmp(state.leave) != 0) return false;
  jpeg_mem_src(&cinfo, bytes.data(), static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&cinfo, TRUE);
  cinfo.out_color_space = JCS_GRAYSCALE;
  cinfo.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&cinfo);
  image.width = static_cast<int>(cinfo.output_width);
  image.height = static_cast<int>(cinfo.output_height);
  const auto pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (pixels > kMostPixels) {
    std::snprintf(state.message.data(), state.message.size(), "it claims %d x %d pixels", image.width, image.height);
    return false;
  }
  image.pixels.resize(pixels);
  while (cinfo.output_scanline < cinfo.output_height) {
    JSAMPROW row = image.pixels.data() + static_cast<std::size_t>(cinfo.output_scanline) * cinfo.output_width;
    jpeg_read_scanlines(&cinfo, &row, 1);
  }
  jpeg_finish_decompress(&cinfo);
  return true;
}

}  // namespace

GreyImage decode_jpeg(const Bytes& bytes) {
  GreyImage image;
  JpegState state;
  jpeg_decompress_struct cinfo{};
  cinfo.err = jpeg_std_error(&state.errors);
  state.errors.error_exit = on_error;
  state.errors.emit_message = on_message;
  cinfo.client_data = &state;
  jpeg_create_decompress(&cinfo);
  const std::unique_ptr<jpeg_decompress_struct, void (*)(jpeg_decompress_struct*)> release(
      &cinfo, [](auto* c) { jpeg_destroy_decompress(c); });
  if (decode(bytes, state, cinfo, image)) return image;
  if (cinfo.jpeg_color_space == JCS_CMYK || cinfo.jpeg_color_space == JCS_YCCK)
    throw ImageFileError("the JPEG is in CMYK, the colours of a printing press; export it as RGB or grey");
  throw ImageFileError("damaged or truncated JPEG (" + std::string(state.message.data()) + ")");
}

}  // namespace plumbline::image_decoders
