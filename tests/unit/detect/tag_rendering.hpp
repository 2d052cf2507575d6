// Renders one tag as a camera would see it: every pixel is the mean over its area (supersampling), then lens blur,
// noise and rounding. True corners are known to the resolution of double.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "photo/images/grey_image.hpp"

namespace plumbline::test {

struct TagScene {
  std::string family = "tag36h11";
  int id = 7;
  int width = 200, height = 200;  ///< of the image [px]
  std::array<Eigen::Vector2d, 4>
      corners;                     ///< where the tag's corners are: bottom left, bottom right, top right, top left [px]
  double bow = 0;                  ///< curvature that bends every line across the image's x direction [1/px]
  double blur = 0.7;               ///< of the lens, standard deviation [px]
  double black = 40, white = 190;  ///< [grey values]
  double noise = 0;                ///< standard deviation [grey values]
  std::uint64_t seed = 1;
};

/// A square of `size` px around `centre`, turned by `angle` [rad] (counter-clockwise as seen) and, if `tilt` is not
/// zero, seen at that angle [rad] from a distance of four times its size.
std::array<Eigen::Vector2d, 4> square_corners(const Eigen::Vector2d& centre, double size, double angle,
                                              double tilt = 0);

GreyImage render(const TagScene& scene);

/// Where `render` puts the corners; differs from scene.corners only with a bow.
std::array<Eigen::Vector2d, 4> true_corners(const TagScene& scene);

/// Writes the image as a grey PNG; a std::runtime_error if it cannot.
void write_png(const std::filesystem::path& path, const GreyImage& grey);

/// Deterministic normal deviates.
class NormalNoise {
 public:
  explicit NormalNoise(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ull + 1) {}
  double uniform();  ///< in (0, 1)
  double operator()();

 private:
  std::uint64_t state_;
};

}  // namespace plumbline::test
