#include "photo/images/tiff_writer.hpp"

#include <tiffio.h>

#include <memory>

namespace plumbline {

void write_grey_tiff(const std::filesystem::path& path, int width, int height, const std::uint8_t* pixels,
                     double per_metre) {
  const std::string refused = "cannot write the picture " + path.string();
  const std::unique_ptr<TIFF, void (*)(TIFF*)> tiff(TIFFOpen(path.c_str(), "w"), TIFFClose);
  if (!tiff) throw std::runtime_error(refused);
  TIFF* to = tiff.get();
  TIFFSetField(to, TIFFTAG_IMAGEWIDTH, width), TIFFSetField(to, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(to, TIFFTAG_BITSPERSAMPLE, 8), TIFFSetField(to, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(to, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK), TIFFSetField(to, TIFFTAG_ROWSPERSTRIP, 64);
  TIFFSetField(to, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE), TIFFSetField(to, TIFFTAG_PREDICTOR, 2);
  if (per_metre > 0) {
    TIFFSetField(to, TIFFTAG_RESOLUTIONUNIT, RESUNIT_CENTIMETER);
    TIFFSetField(to, TIFFTAG_XRESOLUTION, per_metre / 100), TIFFSetField(to, TIFFTAG_YRESOLUTION, per_metre / 100);
  }
  std::vector<std::uint8_t> row(static_cast<std::size_t>(width));  // the predictor works in place
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* from = pixels + static_cast<std::size_t>(y) * width;
    row.assign(from, from + width);
    if (TIFFWriteScanline(to, row.data(), static_cast<std::uint32_t>(y)) != 1) throw std::runtime_error(refused);
  }
  if (TIFFFlush(to) != 1) throw std::runtime_error(refused);
}

}  // namespace plumbline
