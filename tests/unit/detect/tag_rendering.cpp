#include "tag_rendering.hpp"

#include <png.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tag_cells.hpp"

namespace plumbline::test {
namespace {

constexpr int kOver = 6;  // samples a pixel, each way

Eigen::Matrix3d homography(const std::array<Eigen::Vector2d, 4>& from, const std::array<Eigen::Vector2d, 4>& to) {
  Eigen::Matrix<double, 8, 8> a;
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const double x = from[i].x(), y = from[i].y(), u = to[i].x(), v = to[i].y();
    a.row(2 * i) << x, y, 1, 0, 0, 0, -u * x, -u * y;
    a.row(2 * i + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y;
    b[2 * i] = u, b[2 * i + 1] = v;
  }
  const Eigen::Matrix<double, 8, 1> h = a.fullPivLu().solve(b);
  Eigen::Matrix3d m;
  m << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  return m;
}

/// Weights of the fine samples for one pixel: the pixel's box blurred by the lens.
std::vector<float> pixel_kernel(double sigma) {
  const double s = sigma * kOver;
  const int r = static_cast<int>(std::ceil(4 * s));
  std::vector<double> kernel(static_cast<std::size_t>(kOver + 2 * r), 0.0);
  double total = 0;
  for (int k = -r; k <= r; ++k) {
    const double weight = s > 0 ? std::exp(-0.5 * k * k / (s * s)) : 1;
    total += weight * kOver;
    for (int i = 0; i < kOver; ++i) kernel[k + r + i] += weight;
  }
  std::vector<float> normalised;
  for (const double weight : kernel) normalised.push_back(static_cast<float>(weight / total));
  return normalised;
}

/// Reduces rows of `width` · kOver samples to rows of `width` pixels, and transposes.
std::vector<float> reduce(const std::vector<float>& fine, int width, int rows, const std::vector<float>& kernel) {
  const int fine_width = width * kOver, size = static_cast<int>(kernel.size()), r = (size - kOver) / 2;
  std::vector<float> out(static_cast<std::size_t>(width) * rows);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < width; ++x) {
      float sum = 0;
      for (int k = 0; k < size; ++k) {
        const int column = std::clamp(x * kOver - r + k, 0, fine_width - 1);
        sum += kernel[k] * fine[static_cast<std::size_t>(y) * fine_width + column];
      }
      out[static_cast<std::size_t>(x) * rows + y] = sum;
    }
  return out;
}

}  // namespace

double NormalNoise::uniform() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  z ^= z >> 31;
  return (static_cast<double>(z >> 11) + 0.5) * 0x1.0p-53;
}

double NormalNoise::operator()() {
  const double u = uniform(), v = uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v);
}

std::array<Eigen::Vector2d, 4> square_corners(const Eigen::Vector2d& centre, double size, double angle, double tilt) {
  std::array<Eigen::Vector2d, 4> corners;
  const double h = 0.5 * size, distance = 4 * size;
  const std::array<Eigen::Vector2d, 4> plane = {{{-h, -h}, {h, -h}, {h, h}, {-h, h}}};
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d p = Eigen::Rotation2Dd(angle) * plane[i];
    const double scale = distance / (distance + p.x() * std::sin(tilt));
    corners[i] = centre + Eigen::Vector2d(p.x() * std::cos(tilt), -p.y()) * scale;
  }
  return corners;
}

std::array<Eigen::Vector2d, 4> true_corners(const TagScene& scene) {
  auto corners = scene.corners;
  for (auto& c : corners) {
    const double x = c.x() - 0.5 * scene.width;
    c.y() += 0.5 * scene.bow * x * x;
  }
  return corners;
}

GreyImage render(const TagScene& scene) {
  const TagCells cells = cells_of(scene.family, scene.id);
  const double b = 0.5 * cells.border;
  const Eigen::Matrix3d tag_from_pixel = homography(scene.corners, {{{-b, -b}, {b, -b}, {b, b}, {-b, b}}});
  const int width = scene.width * kOver, height = scene.height * kOver;
  std::vector<float> fine(static_cast<std::size_t>(width) * height);
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      const double x = (i + 0.5) / kOver - 0.5, from_middle = x - 0.5 * scene.width;
      const double y = (j + 0.5) / kOver - 0.5 - 0.5 * scene.bow * from_middle * from_middle;
      const Eigen::Vector3d p = tag_from_pixel * Eigen::Vector3d(x, y, 1);
      const bool white = p.z() <= 0 || cells.at(p.x() / p.z(), p.y() / p.z());
      fine[static_cast<std::size_t>(j) * width + i] = static_cast<float>(white ? scene.white : scene.black);
    }
  const std::vector<float> kernel = pixel_kernel(scene.blur);
  const std::vector<float> grey = reduce(reduce(fine, scene.width, height, kernel), scene.height, scene.width, kernel);
  NormalNoise noise(scene.seed);
  GreyImage image{scene.width, scene.height, {}};
  for (const float mean : grey) {
    const double value = static_cast<double>(mean) + (scene.noise > 0 ? scene.noise * noise() : 0.0);
    image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0l, 255l)));
  }
  return image;
}

void write_png(const std::filesystem::path& path, const GreyImage& grey) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(grey.width), image.height = static_cast<png_uint_32>(grey.height);
  image.format = PNG_FORMAT_GRAY;
  if (!png_image_write_to_file(&image, path.c_str(), 0, grey.pixels.data(), 0, nullptr))
    throw std::runtime_error(path.string() + " cannot be written: " + image.message);
}

}  // namespace plumbline::test
