#include "photo/images/jpeg_writer.hpp"

#include <cstdio>
#include <cstdlib>
#include <memory>

// After <cstdio>, which it needs and does not include.
#include <jpeglib.h>

namespace plumbline {

std::string grey_jpeg(const GreyImage& image, int quality) {
  constexpr int most = 65500;
  if (image.width < 1 || image.height < 1 || image.width > most || image.height > most ||
      image.pixels.size() != static_cast<std::size_t>(image.width) * image.height)
    throw std::invalid_argument("a picture of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                                " pixels cannot be written as JPEG");
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);  // it writes to memory: nothing that its handler would end the program for
  jpeg_create_compress(&encoder);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&encoder, &bytes, &size);
  encoder.image_width = static_cast<JDIMENSION>(image.width);
  encoder.image_height = static_cast<JDIMENSION>(image.height);
  encoder.input_components = 1, encoder.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, quality, TRUE);
  jpeg_start_compress(&encoder, TRUE);
  while (encoder.next_scanline < encoder.image_height) {
    JSAMPROW row = const_cast<JSAMPROW>(image.pixels.data() + static_cast<std::size_t>(encoder.next_scanline) *
                                                                  static_cast<std::size_t>(image.width));
    jpeg_write_scanlines(&encoder, &row, 1);
  }
  jpeg_finish_compress(&encoder);
  jpeg_destroy_compress(&encoder);
  const std::unique_ptr<unsigned char, void (*)(void*)> owner(bytes, std::free);
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace plumbline
