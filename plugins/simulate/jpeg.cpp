#include "jpeg.hpp"

#include <jpeglib.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exiv2/exiv2.hpp>
#include <stdexcept>
#include <vector>

namespace plumbline::simulate {
namespace {

/// The payload of the APP1 segment.
std::vector<std::uint8_t> encode_exif(const ExifFields& fields, int width, int height) {
  Exiv2::ExifData exif;
  exif["Exif.Image.Make"] = fields.make;
  exif["Exif.Image.Model"] = fields.model;
  exif["Exif.Image.Orientation"] = std::uint16_t{1};
  exif["Exif.Photo.DateTimeOriginal"] = fields.taken_at;
  exif["Exif.Photo.ExposureTime"] =
      Exiv2::Rational(1, static_cast<std::int32_t>(std::lround(1 / fields.exposure_time)));
  exif["Exif.Photo.FocalLength"] =
      Exiv2::Rational(static_cast<std::int32_t>(std::lround(fields.focal_length * 1e5)), 100);
  exif["Exif.Photo.PixelXDimension"] = static_cast<std::uint32_t>(width);
  exif["Exif.Photo.PixelYDimension"] = static_cast<std::uint32_t>(height);
  Exiv2::Blob blob;
  Exiv2::ExifParser::encode(blob, Exiv2::littleEndian, exif);
  std::vector<std::uint8_t> payload = {'E', 'x', 'i', 'f', 0, 0};
  payload.insert(payload.end(), blob.begin(), blob.end());
  return payload;
}

/// libjpeg's error_exit must not return. It may throw: the ABI demands unwind tables of C code too.
[[noreturn]] void throw_error(j_common_ptr info) {
  char message[JMSG_LENGTH_MAX];
  info->err->format_message(info, message);
  throw std::runtime_error(std::string("cannot encode JPEG: ") + message);
}

struct Compressor {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  unsigned char* buffer = nullptr;
  unsigned long size = 0;

  Compressor() {
    info.err = jpeg_std_error(&errors);
    errors.error_exit = throw_error;
    jpeg_create_compress(&info);
    jpeg_mem_dest(&info, &buffer, &size);
  }
  ~Compressor() {
    jpeg_destroy_compress(&info);
    std::free(buffer);
  }
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;
};

void configure(jpeg_compress_struct& info, const Renderer& renderer, int quality) {
  info.image_width = static_cast<JDIMENSION>(renderer.width());
  info.image_height = static_cast<JDIMENSION>(renderer.height());
  info.input_components = 3;
  info.in_color_space = JCS_YCbCr;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  info.raw_data_in = TRUE;
  info.dct_method = JDCT_ISLOW;
  info.write_JFIF_header = FALSE;  // EXIF wants its own segment to be the first
  for (int i = 0; i < 3; ++i) info.comp_info[i].h_samp_factor = info.comp_info[i].v_samp_factor = i == 0 ? 2 : 1;
}

}  // namespace

std::string encode_jpeg(const Renderer& renderer, int quality, const ExifFields& fields) {
  const std::vector<std::uint8_t> exif = encode_exif(fields, renderer.width(), renderer.height());
  Compressor compressor;
  configure(compressor.info, renderer, quality);
  jpeg_start_compress(&compressor.info, TRUE);
  jpeg_write_marker(&compressor.info, JPEG_APP0 + 1, exif.data(), static_cast<unsigned>(exif.size()));

  Renderer::Band band;
  const std::size_t stride = static_cast<std::size_t>(renderer.padded_width());
  for (int b = 0; b < renderer.bands(); ++b) {
    renderer.render(b, band);
    JSAMPROW luma[16], blue[8], red[8];
    for (std::size_t r = 0; r < 16; ++r) luma[r] = band.luma.data() + r * stride;
    for (std::size_t r = 0; r < 8; ++r) {
      blue[r] = band.blue.data() + r * stride / 2;
      red[r] = band.red.data() + r * stride / 2;
    }
    JSAMPARRAY planes[3] = {luma, blue, red};
    jpeg_write_raw_data(&compressor.info, planes, 16);
  }
  jpeg_finish_compress(&compressor.info);
  return {reinterpret_cast<const char*>(compressor.buffer), compressor.size};
}

}  // namespace plumbline::simulate
