// Photographs of tags as cameras write them, drawn by OpenCV: apart from our renderer and its simulator.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "photo/images/grey_image.hpp"

namespace plumbline::test {

using DrawnCorners = std::array<Eigen::Vector2d, 4>;  ///< bottom left, bottom right, top right, top left [px]

struct DrawnTag {
  int id = 0;  ///< of tag36h11
  DrawnCorners corners;
};

/// Light, 0 to 1, of tags before a wall. Every tag's white border hides what lies behind it, so tags stand apart.
cv::Mat light_of(const std::vector<DrawnTag>& tags, int width, int height, double blur);

/// What a camera makes of light.
struct CameraChain {
  std::string name;
  double exposure = 1;    ///< factor of the light; above one it saturates
  double bloom = 0;       ///< share of the light that is scattered, with a standard deviation of 3 px
  bool vignette = false;  ///< half the light in the corners of the image
  bool srgb = true;       ///< IEC 61966-2-1; false: linear
  double noise = 1;       ///< [grey values]
  double s_curve = 0;     ///< 0 to 1: towards 3x² - 2x³ of the grey values
  bool smoothed = false;  ///< bilateral filter, as noise is taken away
  double sharpened = 0;   ///< unsharp mask of 1.5 px: amount
  int quality = 0;        ///< of JPEG; 0: not compressed
};

GreyImage photograph_of(const cv::Mat& light, const CameraChain& camera, std::uint64_t seed);

/// Cameras whose photographs show what they do to edges, and the linear one.
std::vector<CameraChain> camera_chains();

}  // namespace plumbline::test
