#include "panelled_facade.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "geometry/random.hpp"

namespace plumbline::simulate {
namespace {

constexpr double kMirrored = 4.0;  // what glass shows lies so far behind it [m]

double lattice(double x, double y, std::uint64_t seed) {
  const auto key = static_cast<std::uint64_t>(static_cast<std::int64_t>(x)) * 0x9e3779b97f4a7c15ULL ^
                   static_cast<std::uint64_t>(static_cast<std::int64_t>(y));
  return static_cast<double>(mix_bits(seed ^ mix_bits(key)) >> 11) * 0x1.0p-53;
}

/// From 0 to 1, in four octaves from `finest` on.
double grain(double u, double v, double finest, std::uint64_t seed) {
  double sum = 0, size = finest;
  for (int octave = 0; octave < 4; ++octave, size *= 2) {
    const double x = u / size, y = v / size, fx = std::floor(x), fy = std::floor(y);
    double a = x - fx, b = y - fy;
    a = a * a * (3 - 2 * a), b = b * b * (3 - 2 * b);
    const std::uint64_t s = seed + static_cast<std::uint64_t>(octave) * 7919;
    sum += (lattice(fx, fy, s) * (1 - a) + lattice(fx + 1, fy, s) * a) * (1 - b) +
           (lattice(fx, fy + 1, s) * (1 - a) + lattice(fx + 1, fy + 1, s) * a) * b;
  }
  return sum / 4;
}

struct Ray {
  Eigen::Vector3d from, along;  ///< in the facade's frame
  Eigen::Vector3d at(double h) const { return from + along * ((h - from.z()) / along.z()); }
};

/// Where a ray meets the panel's face, if it does.
std::optional<Eigen::Vector3d> meets(const RaisedPanel& panel, const Ray& ray) {
  Eigen::Vector3d at = ray.at(panel.offset);
  if (std::abs(at.x() - panel.u) > 0.5 * panel.width + 0.1 || std::abs(at.y() - panel.v) > 0.5 * panel.height + 0.1)
    return std::nullopt;
  for (int step = 0; step < 3; ++step) at = ray.at(panel.at(at.x(), at.y()));
  if (std::abs(at.x() - panel.u) > 0.5 * panel.width || std::abs(at.y() - panel.v) > 0.5 * panel.height)
    return std::nullopt;
  return at;
}

double reflectance(const PanelledFacade& facade, const Ray& ray) {
  const RaisedPanel* hit = nullptr;
  Eigen::Vector3d place = ray.at(-facade.recess);
  for (const RaisedPanel& panel : facade.panels)
    if (const auto at = meets(panel, ray); at && (!hit || at->z() > place.z())) hit = &panel, place = *at;
  if (!hit) return 0.06 + 0.02 * grain(place.x(), place.y(), facade.finest, 3);
  switch (hit->skin) {
    case Skin::plain:
      return 0.55;
    case Skin::glass: {
      Ray back{place, ray.along};
      back.along.z() *= -1;  // mirrored: what lies before the facade
      const Eigen::Vector3d world = back.at(kMirrored);
      return 0.2 + 0.4 * grain(world.x(), world.y(), 8 * facade.finest, 11);
    }
    case Skin::plaster:
      break;
  }
  return 0.4 + 0.5 * (grain(place.x() - hit->u, place.y() - hit->v, facade.finest, hit->grain) - 0.25);
}

}  // namespace

const char* to_string(Skin skin) { return skin == Skin::plaster ? "plaster" : skin == Skin::plain ? "plain" : "glass"; }

double RaisedPanel::at(double place_u, double place_v) const {
  const double x = place_u - u, y = place_v - v, a = 2 * x / width, b = 2 * y / height;
  // A bow's best plane lies two thirds up: what is planted as offset is the best plane's.
  return offset + tilt_u * x + tilt_v * y + bow_u * (1 - a * a - 2.0 / 3) + bow_v * (1 - b * b - 2.0 / 3);
}

std::vector<std::uint8_t> photograph(const PanelledFacade& facade, const BrownCamera& camera,
                                     const RigidTransform& cam_from_world, const Exposure& exposure) {
  const RigidTransform facade_from_cam = facade.world_from_facade.inverse() * cam_from_world.inverse();
  const Eigen::Matrix3d turn = facade_from_cam.rotation.toRotationMatrix();
  std::vector<std::uint8_t> grey(static_cast<size_t>(camera.width) * camera.height);
  tbb::parallel_for(0, camera.height, [&](int y) {
    Random noise(derive_seed(exposure.seed, "row", static_cast<std::uint64_t>(y)));
    const int n = exposure.supersampling;
    for (int x = 0; x < camera.width; ++x) {
      double sum = 0;
      for (int b = 0; b < n; ++b)
        for (int a = 0; a < n; ++a) {
          const auto bearing = unproject(camera, {x + (a + 0.5) / n - 0.5, y + (b + 0.5) / n - 0.5});
          if (!bearing) throw std::runtime_error("the distortion cannot be inverted within the image");
          sum +=
              reflectance(facade, {facade_from_cam.translation, turn * Eigen::Vector3d(bearing->x(), bearing->y(), 1)});
        }
      const double level = 20 + 220 * sum / (n * n) + exposure.noise * noise.normal();
      grey[static_cast<size_t>(y) * camera.width + x] =
          static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
    }
  });
  return grey;
}

void write_png(const std::string& path, int width, int height, const std::vector<std::uint8_t>& grey) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width), image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_GRAY;
  if (!png_image_write_to_file(&image, path.c_str(), 0, grey.data(), 0, nullptr))
    throw std::runtime_error("cannot write " + path + ": " + image.message);
}

}  // namespace plumbline::simulate
