// Photographs as JPEG files with EXIF.
#pragma once

#include <string>

#include "renderer.hpp"

namespace plumbline::simulate {

struct ExifFields {
  std::string make, model, taken_at;  ///< taken_at: "2026:05:04 09:00:00"
  double focal_length = 0;            ///< [m]
  double exposure_time = 1.0 / 250;   ///< [s]
};

/// Renders band by band into a baseline JPEG, 4:2:0. Throws std::runtime_error if libjpeg refuses.
std::string encode_jpeg(const Renderer& renderer, int quality, const ExifFields& exif);

}  // namespace plumbline::simulate
