#include "surface/dense/patch.hpp"

#include <cmath>
#include <cstddef>

namespace plumbline::surface {
namespace {

float bilinear(const GreyImage& image, double x, double y) {
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const float a = static_cast<float>(x - left), b = static_cast<float>(y - top);
  const std::uint8_t* p = image.pixels.data() + static_cast<size_t>(top) * image.width + left;
  const std::uint8_t* q = p + image.width;
  const float upper = static_cast<float>(p[0]) + a * static_cast<float>(p[1] - p[0]);
  const float lower = static_cast<float>(q[0]) + a * static_cast<float>(q[1] - q[0]);
  return upper + b * (lower - upper);
}

void weights(float t, float* w) {  // of the pixels −1, 0, 1, 2 for a place t behind pixel 0
  const float t2 = t * t, t3 = t2 * t;
  w[0] = -0.5f * t + t2 - 0.5f * t3;
  w[1] = 1 - 2.5f * t2 + 1.5f * t3;
  w[2] = 0.5f * t + 2 * t2 - 1.5f * t3;
  w[3] = -0.5f * t2 + 0.5f * t3;
}

float by_cubic(const GreyImage& image, double x, double y) {
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  float wx[4], wy[4];
  weights(static_cast<float>(x - left), wx);
  weights(static_cast<float>(y - top), wy);
  const std::uint8_t* p = image.pixels.data() + static_cast<std::ptrdiff_t>(top - 1) * image.width + left - 1;
  float sum = 0;
  for (int r = 0; r < 4; ++r, p += image.width)
    sum += wy[r] * (wx[0] * static_cast<float>(p[0]) + wx[1] * static_cast<float>(p[1]) +
                    wx[2] * static_cast<float>(p[2]) + wx[3] * static_cast<float>(p[3]));
  return sum;
}

}  // namespace

bool sample_patch(const GreyImage& image, const Eigen::Vector2d& pixel, const Eigen::Vector2d& by_i,
                  const Eigen::Vector2d& by_j, int half, bool cubic, Patch& patch) {
  const Eigen::Vector2d reach = half * (by_i.cwiseAbs() + by_j.cwiseAbs());
  const double border = cubic ? 1.0 : 0.0;
  if (!(pixel.x() - reach.x() >= border && pixel.y() - reach.y() >= border &&
        pixel.x() + reach.x() < image.width - 1 - border && pixel.y() + reach.y() < image.height - 1 - border))
    return false;
  const int n = 2 * half + 1;
  patch.values.resize(n * n);
  float* out = patch.values.data();
  for (int j = -half; j <= half; ++j) {
    Eigen::Vector2d at = pixel + j * by_j - half * by_i;
    for (int i = 0; i < n; ++i, at += by_i)
      *out++ = cubic ? by_cubic(image, at.x(), at.y()) : bilinear(image, at.x(), at.y());
  }
  return true;
}

void normalise(Patch& patch) {
  patch.mean = patch.values.mean();
  patch.values -= static_cast<float>(patch.mean);
  patch.contrast = std::sqrt(patch.values.square().mean());
  if (patch.contrast > 0) patch.values /= static_cast<float>(patch.contrast);
}

}  // namespace plumbline::surface
