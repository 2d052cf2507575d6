// The decoders behind read_grey_image(), one a file format. Each throws ImageFileError without the file's name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "photo/images/grey_image.hpp"
#include "photo/images/grey_rows.hpp"

namespace plumbline::image_decoders {

using Bytes = std::vector<std::uint8_t>;

/// Above what any camera delivers; a damaged header must not make us ask for gigabytes.
constexpr std::size_t kMostPixels = 1'000'000'000;

/// For files of 16 bits a value, reduced to 8: those of sensors with 12 bits, stored unscaled, would look dark.
void require_scaled(const GreyImage& image);

GreyImage decode_jpeg(const Bytes& bytes);
/// Whether the file begins like a JPEG; false if it cannot be read.
bool is_jpeg(const std::filesystem::path& path);
std::unique_ptr<GreyRows> open_jpeg(const std::filesystem::path& path);
GreyImage decode_png(const Bytes& bytes);
GreyImage decode_tiff(const Bytes& bytes);

}  // namespace plumbline::image_decoders
