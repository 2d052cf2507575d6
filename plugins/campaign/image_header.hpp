// What a photograph's file says of itself without decoding its pixels.
#pragma once

#include <filesystem>
#include <string>

namespace plumbline::campaign {

struct ImageHeader {
  int width = 0, height = 0;  ///< [px]
  std::string make, model, taken_at;
  double focal_length = 0;  ///< [m]; nan if absent
};

/// Reads size and EXIF of a JPEG, PNG or TIFF and walks a JPEG or PNG to its end mark, so that a truncated file is
/// found before anyone decodes it. Throws CampaignError.
ImageHeader read_image_header(const std::filesystem::path& path);

}  // namespace plumbline::campaign
