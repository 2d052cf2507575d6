#include "jpeg.hpp"

#include <jpeglib.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <vector>

namespace plumbline::simulate {
namespace {

/// Directories of a TIFF structure, little-endian (Exif 2.32, 4.6.2): entries of 12 bytes by rising tag, what does not
/// fit into four bytes behind them.
class ExifDirectory {
 public:
  void add_text(std::uint16_t tag, const std::string& text) {
    std::vector<std::uint8_t> value(text.begin(), text.end());
    value.push_back(0);
    entries_.push_back({tag, 2, static_cast<std::uint32_t>(value.size()), value});
  }
  void add_short(std::uint16_t tag, std::uint16_t value) { entries_.push_back({tag, 3, 1, little_endian(value, 2)}); }
  void add_long(std::uint16_t tag, std::uint32_t value) { entries_.push_back({tag, 4, 1, little_endian(value, 4)}); }
  void add_rational(std::uint16_t tag, std::uint32_t numerator, std::uint32_t denominator) {
    std::vector<std::uint8_t> value = little_endian(numerator, 4), below = little_endian(denominator, 4);
    value.insert(value.end(), below.begin(), below.end());
    entries_.push_back({tag, 5, 1, value});
  }
  std::size_t size() const { return bytes_at(0).size(); }
  /// The directory with its values, if it begins at `offset`.
  std::vector<std::uint8_t> bytes_at(std::size_t offset) const {
    std::vector<std::uint8_t> bytes = little_endian(static_cast<std::uint32_t>(entries_.size()), 2), behind;
    const std::size_t behind_at = offset + 2 + 12 * entries_.size() + 4;
    const auto append = [&bytes](const std::vector<std::uint8_t>& more) {
      bytes.insert(bytes.end(), more.begin(), more.end());
    };
    for (const Entry& entry : entries_) {
      append(little_endian(entry.tag, 2)), append(little_endian(entry.type, 2)), append(little_endian(entry.count, 4));
      std::vector<std::uint8_t> value = entry.value;
      if (value.size() > 4) {
        append(little_endian(static_cast<std::uint32_t>(behind_at + behind.size()), 4));
        value.resize(value.size() + value.size() % 2);
        behind.insert(behind.end(), value.begin(), value.end());
      } else {
        value.resize(4);
        append(value);
      }
    }
    append(little_endian(0, 4));  // no further directory
    append(behind);
    return bytes;
  }

 private:
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count;
    std::vector<std::uint8_t> value;
  };
  static std::vector<std::uint8_t> little_endian(std::uint32_t value, int count) {
    std::vector<std::uint8_t> bytes;
    for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return bytes;
  }
  std::vector<Entry> entries_;
};

/// The payload of the APP1 segment.
std::vector<std::uint8_t> encode_exif(const ExifFields& fields, int width, int height) {
  constexpr std::size_t first = 8;  // behind the structure's head
  ExifDirectory photo;
  photo.add_rational(0x829a, 1, static_cast<std::uint32_t>(std::lround(1 / fields.exposure_time)));
  photo.add_text(0x9003, fields.taken_at);
  photo.add_rational(0x920a, static_cast<std::uint32_t>(std::lround(fields.focal_length * 1e5)), 100);
  photo.add_long(0xa002, static_cast<std::uint32_t>(width));
  photo.add_long(0xa003, static_cast<std::uint32_t>(height));
  const auto image_with = [&](std::size_t photo_at) {
    ExifDirectory image;
    image.add_text(0x010f, fields.make);
    image.add_text(0x0110, fields.model);
    image.add_short(0x0112, 1);
    image.add_long(0x8769, static_cast<std::uint32_t>(photo_at));
    return image;
  };
  const std::size_t photo_at = first + image_with(0).size();
  std::vector<std::uint8_t> payload = {'E', 'x', 'i', 'f', 0, 0, 'I', 'I', 42, 0, first, 0, 0, 0};
  for (const auto& part : {image_with(photo_at).bytes_at(first), photo.bytes_at(photo_at)})
    payload.insert(payload.end(), part.begin(), part.end());
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
