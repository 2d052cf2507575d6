#include "renderer.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/random.hpp"
#include "plate_raster.hpp"

namespace plumbline::simulate {
namespace {

constexpr double kWallDepth = 0.03;  // the wall stands behind the plates [m]
constexpr float kWhiteLevel = 258;   // grey level of reflectance 1 in full light; the plates' white then is about 210
constexpr float kShift = 64;         // makes coordinates positive, so that truncation rounds down

/// std::clamp returns references, which keeps loops from being vectorised.
inline float limit(float value, float lower, float upper) {
  const float raised = value < lower ? lower : value;
  return raised > upper ? upper : raised;
}

/// What the row functions need of the wall.
struct Wall {
  float width, height, storey, spacing, pixel;  // [m]; pixel: size of a pixel on the wall
  std::uint32_t seed;
};

/// Reflectance of wall, sky and ground at (x, z) [m]. Boards with joints at the grid's cells, slab edges at the
/// storeys.
__attribute__((target_clones("avx2", "default"))) void shade_wall(const float* x, const float* z, std::size_t count,
                                                                  Wall wall, float* reflectance) {
  const float inverse_pixel = 1 / wall.pixel;
  for (std::size_t i = 0; i < count; ++i) {
    const float px = x[i] + kShift, pz = z[i] + kShift;
    std::uint32_t hash = (static_cast<std::uint32_t>(static_cast<std::int32_t>(px * 400)) * 0x9e3779b1u) ^
                         (static_cast<std::uint32_t>(static_cast<std::int32_t>(pz * 400)) * 0x85ebca77u) ^ wall.seed;
    hash = (hash ^ (hash >> 15)) * 0x2c1b3c6du;
    hash = (hash ^ (hash >> 12)) * 0x297a2d39u;
    const float grain = static_cast<float>(static_cast<std::int32_t>((hash >> 16) & 0xff)) * (1.0f / 255) - 0.5f;
    // Distances to the nearest vertical joint and to the nearest storey line.
    const float across = x[i] / wall.spacing + kShift + 0.5f, up = z[i] / wall.storey + kShift + 0.5f;
    const float to_joint =
        std::fabs(across - 0.5f - static_cast<float>(static_cast<std::int32_t>(across))) * wall.spacing;
    const float to_storey = std::fabs(up - 0.5f - static_cast<float>(static_cast<std::int32_t>(up))) * wall.storey;
    const float joint = limit((to_joint - 0.006f) * inverse_pixel + 0.5f, 0.0f, 1.0f);
    const float slab = limit((0.16f - to_storey) * inverse_pixel + 0.5f, 0.0f, 1.0f);
    const float edge = limit((std::fabs(to_storey - 0.165f) - 0.006f) * inverse_pixel + 0.5f, 0.0f, 1.0f);
    const float board = (0.40f + 0.05f * grain) * (0.35f + 0.65f * joint);
    const float concrete = 0.55f + 0.09f * grain;
    const float surface = (board + slab * (concrete - board)) * (0.4f + 0.6f * edge);
    const float ground = 0.30f + 0.10f * grain;
    const bool on_wall = (x[i] > 0) & (x[i] < wall.width) & (z[i] < wall.height);
    reflectance[i] = z[i] < 0 ? ground : on_wall ? surface : 0.78f;
  }
}

/// A scaffold tube as a camera sees it in front of the wall.
struct Strip {
  float middle, half;  ///< along x for an upright, along z for a ledger [m on the wall]
};

/// Blends a round tube over a row: bright where the light meets it, dark towards its edges.
__attribute__((target_clones("avx2", "default"))) void draw_tube(const float* place, std::size_t count, Strip strip,
                                                                 float pixel, float* reflectance) {
  const float inverse_pixel = 1 / pixel, inverse_half = 1 / strip.half;
  for (std::size_t i = 0; i < count; ++i) {
    const float across = std::fabs(place[i] - strip.middle);
    const float share = limit((strip.half - across) * inverse_pixel + 0.5f, 0.0f, 1.0f);
    const float round = limit(across * inverse_half, 0.0f, 1.0f);
    reflectance[i] += share * (0.62f - 0.40f * round * round - reflectance[i]);
  }
}

/// Light to grey levels with noise of variance read² + shot · level; the sum of four bytes of a hash is nearly normal.
__attribute__((target_clones("avx2", "default"))) void expose(const float* reflectance, const float* light,
                                                              std::size_t count, std::uint32_t row_seed, float read,
                                                              float shot, std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t hash = static_cast<std::uint32_t>(i) * 0x9e3779b1u + row_seed;
    hash = (hash ^ (hash >> 16)) * 0x21f0aaadu;
    hash = (hash ^ (hash >> 15)) * 0x735a2d97u;
    hash ^= hash >> 15;
    const std::int32_t sum =
        static_cast<std::int32_t>((hash & 0xff) + ((hash >> 8) & 0xff) + ((hash >> 16) & 0xff) + (hash >> 24));
    const float normal = (static_cast<float>(sum) - 510.0f) * (1.0f / 147.8f);
    const float level = reflectance[i] * light[i];
    const float noisy = level + normal * std::sqrt(read * read + shot * level);
    out[i] = static_cast<std::uint8_t>(static_cast<std::int32_t>(limit(noisy + 0.5f, 0.0f, 255.0f)));
  }
}

/// Brick, mesh or lines of text on a share of the wall's cells of 1.5 m: figures that are no markers.
void draw_clutter(const float* x, const float* z, std::size_t count, float share, Wall wall, float* reflectance) {
  for (std::size_t i = 0; i < count; ++i) {
    if (!(x[i] > 0 && x[i] < wall.width && z[i] > 0 && z[i] < wall.height)) continue;
    const auto cell = static_cast<std::uint64_t>(std::floor(x[i] / 1.5f)) * 7919 +
                      static_cast<std::uint64_t>(std::floor(z[i] / 1.5f));
    const std::uint64_t draw = mix_bits(wall.seed ^ mix_bits(cell));
    if (static_cast<double>(draw >> 11) * 0x1.0p-53 >= static_cast<double>(share)) continue;
    const auto within = [](float value, float period) { return value - period * std::floor(value / period); };
    if (draw % 3 == 0) {  // brick of 250 x 75 mm with joints of 10 mm
      const float course = std::floor(z[i] / 0.075f), shifted = x[i] + 0.125f * within(course, 2);
      const std::uint64_t brick = mix_bits(static_cast<std::uint64_t>(course) * 104729 +
                                           static_cast<std::uint64_t>(std::floor(shifted / 0.25f)));
      const bool joint = within(z[i], 0.075f) < 0.01f || within(shifted, 0.25f) < 0.01f;
      reflectance[i] = joint ? 0.45f : 0.12f + 0.08f * static_cast<float>(brick & 255) / 255;
    } else if (draw % 3 == 1) {  // the mesh of a scaffold: 4 mm threads, 50 mm apart
      if (within(x[i] + 0.3f * z[i], 0.05f) < 0.004f || within(z[i] - 0.1f * x[i], 0.05f) < 0.004f)
        reflectance[i] = 0.75f;
    } else {  // letters of 5 x 7 dots, 60 mm high
      const float u = within(x[i], 0.06f) / 0.0086f, v = within(z[i], 0.1f) / 0.0086f;
      if (u >= 5 || v >= 7) continue;
      const std::uint64_t letter =
          mix_bits(static_cast<std::uint64_t>(x[i] / 0.06f) * 31 + static_cast<std::uint64_t>(z[i] / 0.1f));
      if (letter >> (static_cast<int>(v) * 5 + static_cast<int>(u)) & 1) reflectance[i] = 0.04f;
    }
  }
}

/// Smooth noise in [-1, 1] with cells of one metre: stains on the wall.
double stain(double x, double z, std::uint64_t seed) {
  const double fx = std::floor(x), fz = std::floor(z), a = x - fx, b = z - fz;
  const auto corner = [&](double cx, double cz) {
    const auto key = static_cast<std::uint64_t>(static_cast<std::int64_t>(cx) * 7919 + static_cast<std::int64_t>(cz));
    return static_cast<double>(mix_bits(seed ^ mix_bits(key)) >> 11) * 0x1.0p-52 - 1.0;
  };
  const double s = a * a * (3 - 2 * a), t = b * b * (3 - 2 * b);
  const double lower = corner(fx, fz) * (1 - s) + corner(fx + 1, fz) * s;
  const double upper = corner(fx, fz + 1) * (1 - s) + corner(fx + 1, fz + 1) * s;
  return lower * (1 - t) + upper * t;
}

}  // namespace

struct Renderer::Scene {
  int width = 0, height = 0;
  Wall wall{};
  float read = 0, shot = 0;
  std::uint32_t noise_seed = 0;
  int grid_columns = 0;
  std::vector<float> x, z, light;  ///< at every 16th pixel
  std::vector<PlateRaster> plates;
  std::vector<Strip> uprights, ledgers;  ///< tubes as this camera sees them on the wall
  std::vector<HungPanel> panels;
  double panel_contrast = 1;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of the camera
  float haze = 0;
  Perturbations perturbations;
  bool real = false;             ///< exposure by RealExposure
  Eigen::Vector2d motion{0, 0};  ///< during the exposure [px]
  float gain = 1;                ///< of noise, where light is short
  std::vector<float> curve;      ///< grey values by light, at every quarter of a grey value

  /// One image row of a quantity that is known at every 16th pixel.
  void interpolate(const std::vector<float>& grid, int row, std::vector<float>& out) const {
    const std::size_t columns = static_cast<std::size_t>(grid_columns);
    const std::size_t first = static_cast<std::size_t>(row / RayGrid::step) * columns;
    const float b = static_cast<float>(row % RayGrid::step) / RayGrid::step;
    for (std::size_t c = 0; c + 1 < columns; ++c) {
      const float* upper = grid.data() + first + c;
      const float* lower = upper + columns;
      const float left = upper[0] + b * (lower[0] - upper[0]), right = upper[1] + b * (lower[1] - upper[1]);
      const float slope = (right - left) / RayGrid::step;
      for (std::size_t i = 0; i < RayGrid::step; ++i) out[c * RayGrid::step + i] = left + static_cast<float>(i) * slope;
    }
  }

  void hang(const std::vector<float>& row_x, const std::vector<float>& row_z, std::vector<float>& reflectance) const {
    if (!panels.empty())
      paint_panels(panels, centre, kWallDepth, static_cast<double>(wall.pixel), panel_contrast, row_x, row_z,
                   reflectance);
  }

  void composite(int row, std::vector<float>& reflectance) const {
    for (const PlateRaster& plate : plates) {
      if (row < plate.top || row >= plate.top + plate.height) continue;
      const std::size_t width_of_plate = static_cast<std::size_t>(plate.width);
      const std::size_t offset = static_cast<std::size_t>(row - plate.top) * width_of_plate;
      float* out = reflectance.data() + plate.left;
      for (std::size_t i = 0; i < width_of_plate; ++i) {
        out[i] = out[i] * (1 - plate.coverage[offset + i]) + plate.reflectance[offset + i];
      }
    }
  }

  /// What stands in front of wall and plates. Rays through a tube's plane meet the wall in a line again, so a tube is a
  /// strip of the wall seen from this one camera.
  void cover(const std::vector<float>& row_x, const std::vector<float>& row_z, std::vector<float>& reflectance) const {
    for (const auto& [strips, place] : {std::pair(&uprights, &row_x), std::pair(&ledgers, &row_z)})
      for (const Strip& strip : *strips) draw_tube(place->data(), place->size(), strip, wall.pixel, reflectance.data());
    if (haze > 0)
      for (float& value : reflectance) value += haze * (0.7f - value);
  }

  /// Light of one row, without noise [grey values of a linear camera]; x and z are where it meets the wall.
  void light_row(int row, std::vector<float>& row_x, std::vector<float>& row_z, std::vector<float>& out) const {
    std::vector<float> illumination(row_x.size());
    interpolate(x, row, row_x);
    interpolate(z, row, row_z);
    interpolate(light, row, illumination);
    out.resize(row_x.size());
    shade_wall(row_x.data(), row_z.data(), out.size(), wall, out.data());
    if (perturbations.clutter > 0)
      draw_clutter(row_x.data(), row_z.data(), out.size(), static_cast<float>(perturbations.clutter), wall, out.data());
    hang(row_x, row_z, out);
    composite(row, out);
    cover(row_x, row_z, out);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] *= illumination[i];
  }

  float developed(float level) const {
    const float at = limit(4 * level, 0.0f, static_cast<float>(curve.size() - 2));
    const auto i = static_cast<std::size_t>(at);
    return curve[i] + (at - static_cast<float>(i)) * (curve[i + 1] - curve[i]);
  }

  /// Rows first ... first + count - 1 with movement, noise, curve and sharpening, as grey values of `line` pixels each.
  void expose_real(int first, int count, std::size_t line, std::vector<std::uint8_t>& out) const {
    constexpr int kAround = 1;  // rows that sharpening looks at, each way
    const int taps = std::max(1, static_cast<int>(std::ceil(motion.norm())) * 2 + 1);
    const int reach = static_cast<int>(std::ceil(0.5 * std::abs(motion.y()))) + 1;
    const auto inside = [&](int row) { return std::clamp(row, 0, height - 1); };
    std::vector<std::vector<float>> lit(static_cast<std::size_t>(count + 2 * (kAround + reach)));
    std::vector<float> row_x(line), row_z(line);
    for (std::size_t k = 0; k < lit.size(); ++k)
      light_row(inside(first - kAround - reach + static_cast<int>(k)), row_x, row_z, lit[k]);
    std::vector<std::vector<float>> grey(static_cast<std::size_t>(count + 2 * kAround), std::vector<float>(line));
    for (std::size_t k = 0; k < grey.size(); ++k) {
      std::vector<float> moved(line, 0.0f);
      for (int t = 0; t < taps; ++t) {
        const double share = taps > 1 ? static_cast<double>(t) / (taps - 1) - 0.5 : 0.0;
        add_shifted(lit, static_cast<double>(k) + reach + share * motion.y(), share * motion.x(),
                    1.0f / static_cast<float>(taps), moved);
      }
      const int row = inside(first - kAround + static_cast<int>(k));
      Random noise(noise_seed, "row", static_cast<std::uint64_t>(row));
      for (std::size_t i = 0; i < line; ++i) {
        const float level = moved[i];
        const float sigma = gain * std::sqrt(read * read + shot * level);
        grey[k][i] = developed(level + sigma * static_cast<float>(noise.normal()));
      }
    }
    out.resize(static_cast<std::size_t>(count) * line);
    const auto amount = static_cast<float>(perturbations.sharpening);
    for (int r = 0; r < count; ++r)
      for (std::size_t i = 0; i < line; ++i) {
        const std::size_t left = i > 0 ? i - 1 : 0, right = std::min(i + 1, line - 1), k = static_cast<std::size_t>(r);
        float mean = 0;
        for (std::size_t dy = 0; dy < 3; ++dy) {
          const std::vector<float>& g = grey[k + dy];
          mean += (dy == 1 ? 2.0f : 1.0f) * (g[left] + 2 * g[i] + g[right]);
        }
        const float own = grey[k + 1][i], value = own + 4 * amount * (own - mean / 16);
        out[k * line + i] = static_cast<std::uint8_t>(limit(value + 0.5f, 0.0f, 255.0f));
      }
  }

  /// Adds `weight` times the rows at a shifted place, bilinear.
  static void add_shifted(const std::vector<std::vector<float>>& rows, double row, double shift, float weight,
                          std::vector<float>& out) {
    const auto j = static_cast<std::size_t>(row);
    const float v = static_cast<float>(row - static_cast<double>(j));
    const double whole = std::floor(shift);
    const auto offset = static_cast<std::ptrdiff_t>(whole), last = static_cast<std::ptrdiff_t>(out.size()) - 1;
    const float u = static_cast<float>(shift - whole);
    const std::vector<float>&a = rows[j], &b = rows[std::min(j + 1, rows.size() - 1)];
    for (std::ptrdiff_t i = 0; i <= last; ++i) {
      const auto p = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i + offset, 0, last));
      const auto q = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i + offset + 1, 0, last));
      const float upper = a[p] + u * (a[q] - a[p]), lower = b[p] + u * (b[q] - b[p]);
      out[i] += weight * (upper + v * (lower - upper));
    }
  }

  void colour(int row, const std::vector<float>& row_x, const std::vector<float>& row_z, std::uint8_t* blue,
              std::uint8_t* red) const {
    for (std::size_t i = 0; 2 * i + 1 < row_x.size(); ++i) {
      const float px = row_x[2 * i], pz = row_z[2 * i];
      const bool on_wall = px > 0 && px < wall.width && pz < wall.height;
      blue[i] = pz < 0 ? 118 : on_wall ? 123 : 142;
      red[i] = pz < 0 ? 133 : on_wall ? 132 : 119;
    }
    for (const PlateRaster& plate : plates) {  // metal, paper and ink have no hue
      if (row < plate.top || row >= plate.top + plate.height) continue;
      const std::size_t offset = static_cast<std::size_t>(row - plate.top) * plate.width;
      for (int column = plate.left; column < plate.left + plate.width; ++column) {
        if (plate.coverage[offset + static_cast<std::size_t>(column - plate.left)] < 0.5f) continue;
        blue[column / 2] = red[column / 2] = 128;
      }
    }
  }
};

namespace {

/// `camera`: the camera's place on the tubes' axis; `enlargement`: distance to the wall over distance to the tubes.
void project_tubes(const std::vector<double>& tubes, double radius, double camera, double enlargement,
                   std::vector<Strip>& out) {
  for (const double at : tubes)
    out.push_back({static_cast<float>(camera + enlargement * (at - camera)), static_cast<float>(enlargement * radius)});
}

/// Grey values by light at every quarter of a grey value, up to light that is clipped.
std::vector<float> transfer_curve(const std::string& name) {
  if (name != "linear" && name != "srgb" && name != "camera")
    throw std::invalid_argument("transfer curve is '" + name + "'; possible are linear, srgb and camera");
  std::vector<float> curve;
  for (int i = 0; i <= 4 * 255 + 1; ++i) {
    const double light = std::min(1.0, i / 1020.0);
    double value = light;
    if (name != "linear") value = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
    // A camera's own rendering: contrast of the middle raised over sRGB, toe and shoulder flat.
    if (name == "camera") value += 0.12 * (value * value * (3 - 2 * value) - value) * 2;
    curve.push_back(static_cast<float>(255 * value));
  }
  return curve;
}

/// A lamp that a plate mirrors: light added around a place on it.
void add_glare(PlateRaster& plate, Random& random) {
  const double size = std::max(plate.width, plate.height);
  const double x = random.uniform(0, plate.width), y = random.uniform(0, plate.height),
               radius = size * random.uniform(0.1, 0.35);
  const double strength = random.uniform(0.3, 0.9);
  for (int row = 0; row < plate.height; ++row)
    for (int column = 0; column < plate.width; ++column) {
      const auto i = static_cast<std::size_t>(row) * plate.width + column;
      const double d2 = std::pow((column - x) / radius, 2) + std::pow((row - y) / radius, 2);
      plate.reflectance[i] += plate.coverage[i] * static_cast<float>(strength * std::exp(-0.5 * d2));
    }
}

Eigen::Vector2d direction(Random& random) {
  const double angle = random.uniform(0, 2 * M_PI);
  return {std::cos(angle), std::sin(angle)};
}

}  // namespace

Renderer::Renderer(const Building& building, const SimulatedCamera& camera, const RigidTransform& camera_from_building,
                   const RenderOptions& options, const Obstruction& obstruction)
    : scene_(std::make_unique<Scene>()) {
  Scene& s = *scene_;
  const BrownCamera& c = camera.truth;
  s.width = c.width, s.height = c.height;
  const RigidTransform building_from_camera = camera_from_building.inverse();
  const Eigen::Vector3d centre = building_from_camera.translation;
  const double distance = kWallDepth - centre.y();
  s.wall = {static_cast<float>(building.width),         static_cast<float>(building.height),
            static_cast<float>(building.storey_height), static_cast<float>(building.options.spacing),
            static_cast<float>(distance / c.fx),        static_cast<std::uint32_t>(derive_seed(options.seed, "wall"))};
  s.read = static_cast<float>(options.noise_scale * camera.profile.read_noise);
  s.shot = static_cast<float>(options.noise_scale * options.noise_scale * camera.profile.shot_noise);
  s.noise_seed = static_cast<std::uint32_t>(derive_seed(options.seed, "noise"));

  const Perturbations& p = options.perturbations;
  s.perturbations = p;
  s.real = p.transfer != "linear" || p.sharpening > 0 || p.motion_blur > 0 || p.low_light > 0 || p.clutter > 0;
  s.curve = transfer_curve(p.transfer);
  s.gain = static_cast<float>(std::exp2(0.5 * p.low_light));
  Random drawn(options.seed, "perturbations");
  s.motion = direction(drawn) * p.motion_blur * drawn.uniform();
  const RayGrid rays(c, direction(drawn) * p.rolling_shutter);
  s.grid_columns = rays.columns;
  const Eigen::Matrix3d rotation = building_from_camera.rotation.toRotationMatrix();
  const double corner2 = std::pow(0.5 * c.width / c.fx, 2) + std::pow(0.5 * c.height / c.fy, 2);
  for (std::size_t i = 0; i < rays.x.size(); ++i) {
    const Eigen::Vector3d ray = rotation * Eigen::Vector3d(rays.x[i], rays.y[i], 1);
    // Rays that rise above the horizon of the wall's plane end far away; the sky and the ground go on there.
    const double reach = ray.y() > 0.02 ? distance / ray.y() : 50 * distance;
    const Eigen::Vector3d on_wall = centre + reach * ray;
    const double x = std::clamp(on_wall.x(), -60.0, 500.0), z = std::clamp(on_wall.z(), -60.0, 500.0);
    const double vignetting = 1 - camera.profile.vignetting * (rays.x[i] * rays.x[i] + rays.y[i] * rays.y[i]) / corner2;
    const double across = std::clamp(x / building.width - 0.5, -1.0, 1.0);
    const double gradient = 1 + options.light_gradient * (0.6 * across + 0.4 * std::sin(0.21 * z));
    s.x.push_back(static_cast<float>(x));
    s.z.push_back(static_cast<float>(z));
    s.light.push_back(static_cast<float>(options.exposure * kWhiteLevel * vignetting * gradient *
                                         (1 + 0.05 * stain(x, z, options.seed))));
  }

  s.panels = options.panels, s.panel_contrast = options.panel_contrast, s.centre = centre;
  s.haze = static_cast<float>(options.haze);
  if (centre.y() < obstruction.plane) {  // else the tubes stand behind the camera
    const double enlargement = distance / (obstruction.plane - centre.y());
    project_tubes(obstruction.uprights, obstruction.radius, centre.x(), enlargement, s.uprights);
    project_tubes(obstruction.ledgers, obstruction.radius, centre.z(), enlargement, s.ledgers);
  }
  const double blur = options.blur >= 0 ? options.blur : camera.profile.blur;
  for (std::size_t i = 0; i < building.anchors.size(); ++i) {
    if (!obstruction.lost.empty() && obstruction.lost[i]) continue;
    PlateRaster plate = raster_plate(building.anchors[i], c, camera_from_building, rays, blur, p);
    if (plate.width > 0 && drawn.uniform() < p.glare) add_glare(plate, drawn);
    if (plate.width > 0) s.plates.push_back(std::move(plate));
  }
}

Renderer::~Renderer() = default;
int Renderer::width() const { return scene_->width; }
int Renderer::height() const { return scene_->height; }

void Renderer::render(int band, Band& out) const {
  const Scene& s = *scene_;
  const std::size_t padded = static_cast<std::size_t>(padded_width());
  const std::size_t line = static_cast<std::size_t>(s.grid_columns - 1) * RayGrid::step;  // at least the image's width
  out.luma.resize(band_rows * padded);
  out.blue.resize(band_rows / 2 * padded / 2);
  out.red.resize(out.blue.size());
  std::vector<float> x(line), z(line), light(line), reflectance(line);
  std::vector<std::uint8_t> grey(line), blue(line / 2), red(line / 2), exposed;
  if (s.real) s.expose_real(band * band_rows, band_rows, line, exposed);
  for (int r = 0; r < band_rows; ++r) {
    const int row = std::min(band * band_rows + r, s.height - 1);  // a JPEG block that hangs over repeats the last row
    s.interpolate(s.x, row, x);
    s.interpolate(s.z, row, z);
    if (s.real) {
      std::copy_n(exposed.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(r) * line), line,
                  grey.begin());
    } else {
      s.interpolate(s.light, row, light);
      shade_wall(x.data(), z.data(), line, s.wall, reflectance.data());
      s.hang(x, z, reflectance);
      s.composite(row, reflectance);
      s.cover(x, z, reflectance);
      expose(reflectance.data(), light.data(), line, s.noise_seed + static_cast<std::uint32_t>(row) * 0x85ebca77u,
             s.read, s.shot, grey.data());
    }
    std::copy_n(grey.begin(), padded,
                out.luma.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(r) * padded));
    if (r % 2 == 0) {
      s.colour(row, x, z, blue.data(), red.data());
      const auto offset = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(r / 2) * padded / 2);
      std::copy_n(blue.begin(), padded / 2, out.blue.begin() + offset);
      std::copy_n(red.begin(), padded / 2, out.red.begin() + offset);
    }
  }
}

}  // namespace plumbline::simulate
