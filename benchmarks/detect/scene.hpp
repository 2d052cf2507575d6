// A facade drawn for speed tests: brick, the mesh of a scaffold, text, and tags of known places among them.
#pragma once

#include <cstdint>
#include <string>

#include "photo/detect/square_code.hpp"

namespace plumbline::benchmark {

struct SceneOptions {
  int width = 11656, height = 8742;  ///< [px]
  int tags = 100;
  double smallest = 24, largest = 600;  ///< sides of the tags, evenly spread over their logarithm [px]
  double noise = 3;                     ///< [grey values]
  double blur = 0.7;                    ///< standard deviation [px]
  std::uint64_t seed = 1;
};

/// Writes a JPEG of quality 93 and beside it `path`.csv: id, four corners. sRGB transfer curve.
void write_scene(const SceneOptions& options, const detect::SquareFamily& family, const std::string& path);

}  // namespace plumbline::benchmark
