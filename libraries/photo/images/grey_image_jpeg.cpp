#include <array>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

// After <cstdio>, which libjpeg's header needs but does not include.
#include <jpeglib.h>
// After jpeglib.h.
#include <jerror.h>

#include "photo/images/grey_image_decoders.hpp"

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
  const auto pixels = static_cast<std::size_t>(image.width) * image.height;
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

void connect(JpegState& state, jpeg_decompress_struct& cinfo) {
  cinfo.err = jpeg_std_error(&state.errors);
  state.errors.error_exit = on_error;
  state.errors.emit_message = on_message;
  cinfo.client_data = &state;
}

[[noreturn]] void refuse(const JpegState& state, const jpeg_decompress_struct& cinfo) {
  if (cinfo.jpeg_color_space == JCS_CMYK || cinfo.jpeg_color_space == JCS_YCCK)
    throw ImageFileError("the JPEG is in CMYK, the colours of a printing press; export it as RGB or grey");
  throw ImageFileError("damaged or truncated JPEG (" + std::string(state.message.data()) + ")");
}

/// Decodes while it reads. No call into libjpeg has an object with a destructor between its setjmp and itself.
class JpegRows : public GreyRows {
 public:
  explicit JpegRows(const std::filesystem::path& path) : file_(std::fopen(path.c_str(), "rb"), std::fclose) {
    if (!file_) throw ImageFileError(std::string("cannot be opened for reading: ") + std::strerror(errno));
    connect(state_, cinfo_);
    jpeg_create_decompress(&cinfo_);
    if (!start()) {
      const std::unique_ptr<jpeg_decompress_struct, void (*)(jpeg_decompress_struct*)> release(
          &cinfo_, [](auto* c) { jpeg_destroy_decompress(c); });
      refuse(state_, cinfo_);
    }
    width_ = static_cast<int>(cinfo_.output_width);
    height_ = static_cast<int>(cinfo_.output_height);
  }
  ~JpegRows() override { jpeg_destroy_decompress(&cinfo_); }
  JpegRows(const JpegRows&) = delete;
  JpegRows& operator=(const JpegRows&) = delete;

  void next(std::uint8_t* row) override {
    if (!read(row)) refuse(state_, cinfo_);
  }
  void skip(int count) override {
    if (!pass(count)) refuse(state_, cinfo_);
  }

 private:
  bool start() {
    if (setjmp(state_.leave) != 0) return false;
    jpeg_stdio_src(&cinfo_, file_.get());
    jpeg_read_header(&cinfo_, TRUE);
    cinfo_.out_color_space = JCS_GRAYSCALE;
    cinfo_.dct_method = JDCT_ISLOW;
    if (static_cast<std::size_t>(cinfo_.image_width) * cinfo_.image_height > kMostPixels) {
      std::snprintf(state_.message.data(), state_.message.size(), "it claims %u x %u pixels", cinfo_.image_width,
                    cinfo_.image_height);
      return false;
    }
    jpeg_start_decompress(&cinfo_);
    return true;
  }
  bool read(std::uint8_t* row) {
    if (setjmp(state_.leave) != 0) return false;
    JSAMPROW rows = row;
    jpeg_read_scanlines(&cinfo_, &rows, 1);
    // What follows the last row may be damaged, too, and says that rows before it were guessed.
    if (cinfo_.output_scanline == cinfo_.output_height) jpeg_finish_decompress(&cinfo_);
    return true;
  }
  bool pass(int count) {
    if (setjmp(state_.leave) != 0) return false;
    jpeg_skip_scanlines(&cinfo_, static_cast<JDIMENSION>(count));
    return true;
  }

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  JpegState state_;
  jpeg_decompress_struct cinfo_{};
};

}  // namespace

bool is_jpeg(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  std::array<unsigned char, 3> magic{};
  return file && std::fread(magic.data(), 1, magic.size(), file.get()) == magic.size() &&
         magic == std::array<unsigned char, 3>{0xff, 0xd8, 0xff};
}

std::unique_ptr<GreyRows> open_jpeg(const std::filesystem::path& path) { return std::make_unique<JpegRows>(path); }

GreyImage decode_jpeg(const Bytes& bytes) {
  GreyImage image;
  JpegState state;
  jpeg_decompress_struct cinfo{};
  connect(state, cinfo);
  jpeg_create_decompress(&cinfo);
  const std::unique_ptr<jpeg_decompress_struct, void (*)(jpeg_decompress_struct*)> release(
      &cinfo, [](auto* c) { jpeg_destroy_decompress(c); });
  if (decode(bytes, state, cinfo, image)) return image;
  refuse(state, cinfo);
}

}  // namespace plumbline::image_decoders
