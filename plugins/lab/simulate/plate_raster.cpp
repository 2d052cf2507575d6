#include "plate_raster.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include "geometry/random.hpp"

namespace plumbline::simulate {
namespace {

constexpr int kSamples = 4;  // a pixel, each way
constexpr float kWhite = 0.82f, kBlack = 0.05f, kMetal = 0.58f;

/// What is drawn on a plate, in plate coordinates.
struct PlateDrawing {
  std::array<float, 144> modules;  // 12 × 12: the tag with its white edge, and the plate's metal around
  float module_size, inverse_module_size, tag_x, tag_y;
  float half_width, bottom, top, target_radius;
  float ink_spread, bend, inverse_half;      // bend at the tag's corners, 1 / half its edge
  std::vector<std::array<float, 3>> specks;  // u, v, radius
};

/// Specks of a plate: the same in every photograph of it.
std::vector<std::array<float, 3>> specks_of(const Anchor& anchor, const PlateOutline& outline, double mean) {
  std::vector<std::array<float, 3>> specks;
  if (!(mean > 0)) return specks;
  Random random(static_cast<std::uint64_t>(anchor.tag_id), "dirt");
  const int count = static_cast<int>(mean + random.uniform());  // one more on some: `mean` on average
  for (int i = 0; i < count; ++i)
    specks.push_back({static_cast<float>(random.uniform(-outline.half_width, outline.half_width)),
                      static_cast<float>(random.uniform(outline.bottom, outline.top)),
                      static_cast<float>(random.uniform(0.002, 0.008))});
  return specks;
}

PlateDrawing make_drawing(const Anchor& anchor, const Perturbations& flaws) {
  PlateDrawing d{};
  d.modules.fill(kMetal);
  const std::vector<float> tag = tag_modules(anchor.tag_id);
  for (std::size_t r = 0; r < 10; ++r) {
    for (std::size_t c = 0; c < 10; ++c) d.modules[(r + 1) * 12 + c + 1] = tag[r * 10 + c] > 0.5f ? kWhite : kBlack;
  }
  d.module_size = static_cast<float>(anchor.true_plate.tag_size / 8);
  d.inverse_module_size = 1 / d.module_size;
  d.tag_x = static_cast<float>(anchor.true_plate.tag_centre_in_plate.x());
  d.tag_y = static_cast<float>(anchor.true_plate.tag_centre_in_plate.y());
  const PlateOutline outline = plate_outline(anchor.true_plate);
  d.half_width = static_cast<float>(outline.half_width);
  d.bottom = static_cast<float>(outline.bottom);
  d.top = static_cast<float>(outline.top);
  d.target_radius = static_cast<float>(outline.target_radius);
  d.ink_spread = static_cast<float>(flaws.ink_spread);
  d.bend = static_cast<float>(anchor.bend);
  d.inverse_half = static_cast<float>(2 / anchor.true_plate.tag_size);
  d.specks = specks_of(anchor, outline, flaws.dirt);
  return d;
}

/// std::clamp returns references, which keeps loops from being vectorised.
inline float limit(float value, float lower, float upper) {
  const float raised = value < lower ? lower : value;
  return raised > upper ? upper : raised;
}

/// 0 below -w/2, 1 above w/2: the share of a footprint of width w that lies on the positive side of an edge.
inline float step(float distance, float inverse_width) { return limit(distance * inverse_width + 0.5f, 0.0f, 1.0f); }

/// Share of the plate in a footprint at (u, v) that is 1/inverse_width wide [m].
inline float coverage_at(const PlateDrawing& d, float u, float v, float inverse_width) {
  return step(d.half_width - std::fabs(u), inverse_width) * step(v - d.bottom, inverse_width) *
         step(d.top - v, inverse_width);
}

/// The survey target: a quadrant disc within a black ring on white.
inline float target_at(const PlateDrawing& d, float u, float v, float inverse_width) {
  const float radius = std::sqrt(u * u + v * v);
  const float right = 2 * step(u, inverse_width) - 1, up = 2 * step(v, inverse_width) - 1;
  const float quadrants = kWhite + (kBlack - kWhite) * (0.5f + 0.5f * right * up);
  const float in_disc = step(0.82f * d.target_radius - radius, inverse_width);
  const float in_ring = step(d.target_radius - radius, inverse_width) - in_disc;
  const float in_paper = step(1.12f * d.target_radius - radius, inverse_width) - in_disc - in_ring;
  return quadrants * in_disc + kBlack * in_ring + kWhite * in_paper + kMetal * (1 - in_disc - in_ring - in_paper);
}

/// The tag: modules blended across their common edges over the width of a footprint, which is the integral over it.
inline float tag_at(const PlateDrawing& d, float u, float v, float inverse_width) {
  const float column =
      limit((u - d.tag_x) * d.inverse_module_size + 5.5f, 0.0f, 10.999f);  // 0.5 less than the edge count
  const float row = limit((d.tag_y - v) * d.inverse_module_size + 5.5f, 0.0f, 10.999f);
  const int c = static_cast<int>(column), r = static_cast<int>(row);
  const float per_module = inverse_width * d.module_size;
  const float a = step(column - static_cast<float>(c) - 0.5f, per_module);
  const float b = step(row - static_cast<float>(r) - 0.5f, per_module);
  const float* m = d.modules.data() + r * 12 + c;
  const float upper = m[0] + a * (m[1] - m[0]), lower = m[12] + a * (m[13] - m[12]);
  return upper + b * (lower - upper);
}

/// The tag with its black grown at every edge: the darkest of a square of twice the spread.
inline float printed_tag_at(const PlateDrawing& d, float u, float v, float inverse_width) {
  const float g = d.ink_spread;
  if (g == 0) return tag_at(d, u, v, inverse_width);
  const float left = std::min(tag_at(d, u - g, v - g, inverse_width), tag_at(d, u - g, v + g, inverse_width));
  return std::min(left, std::min(tag_at(d, u + g, v - g, inverse_width), tag_at(d, u + g, v + g, inverse_width)));
}

/// Dirt of a middle grey over everything.
void draw_specks(const PlateDrawing& d, const float* u, const float* v, std::size_t count, float inverse_width,
                 float* weighted, const float* coverage) {
  constexpr float kDirt = 0.25f, kOpaque = 0.8f;
  for (const auto& [x, y, radius] : d.specks)
    for (std::size_t i = 0; i < count; ++i) {
      const float du = u[i] - x, dv = v[i] - y;
      const float share = kOpaque * step(radius - std::sqrt(du * du + dv * dv), inverse_width);
      weighted[i] += share * (kDirt * coverage[i] - weighted[i]);
    }
}

/// Draws samples at plate coordinates (u, v) [m]: reflectance · coverage and coverage.
void draw_samples(const PlateDrawing& d, const float* u, const float* v, std::size_t count, float inverse_width,
                  float* weighted, float* coverage) {
  for (std::size_t i = 0; i < count; ++i) {
    const float share = coverage_at(d, u[i], v[i], inverse_width);
    coverage[i] = share;
    weighted[i] = share <= 0                      ? 0
                  : v[i] < 1.3f * d.target_radius ? share * target_at(d, u[i], v[i], inverse_width)
                                                  : share * printed_tag_at(d, u[i], v[i], inverse_width);
  }
  draw_specks(d, u, v, count, inverse_width, weighted, coverage);
}

/// A quotient of linear functions at i = 0, 1, ...: where samples along a line of the image meet the plate.
struct Homogeneous {
  double u, v, w, du, dv, dw;
};
__attribute__((target_clones("avx2", "default"))) void divide_along(Homogeneous h, std::size_t count, float* u,
                                                                    float* v) {
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(static_cast<std::int32_t>(i));
    const double scale = 1.0 / (h.w + t * h.dw);
    u[i] = static_cast<float>((h.u + t * h.du) * scale);
    v[i] = static_cast<float>((h.v + t * h.dv) * scale);
  }
}

/// Weights of the samples around a pixel's centre: pixel area convolved with a normal point spread function.
std::vector<float> integration_kernel(double blur) {
  const double sigma = kSamples * blur, half = 0.5 * kSamples;
  const int reach = static_cast<int>(std::ceil(half + 3.5 * sigma));  // samples on each side of the centre
  std::vector<double> weights;
  double sum = 0;
  for (int i = -reach; i < reach; ++i) {
    const double offset = i + 0.5;
    const double w = sigma > 0 ? 0.5 * (std::erf((offset + half) / (sigma * std::sqrt(2.0))) -
                                        std::erf((offset - half) / (sigma * std::sqrt(2.0))))
                               : (std::fabs(offset) < half ? 1.0 : 0.0);
    weights.push_back(w);
    sum += w;
  }
  std::vector<float> kernel;
  for (const double w : weights) kernel.push_back(static_cast<float>(w / sum));
  return kernel;
}

/// The mapping from normalised image coordinates to the plate's plane, as a homography.
Eigen::Matrix3d plate_from_image(const Anchor& anchor, const RigidTransform& camera_from_building) {
  const RigidTransform camera_from_plate = camera_from_building * anchor.building_from_plate;
  Eigen::Matrix3d image_from_plate = camera_from_plate.rotation.toRotationMatrix();
  image_from_plate.col(2) = camera_from_plate.translation;
  return image_from_plate.inverse();
}

struct Window {
  int left, top, right, bottom;  // right and bottom are past the end
};

/// Window of the plate in the image; empty if no part of it shows.
Window find_window(const Anchor& anchor, const BrownCamera& camera, const RigidTransform& camera_from_building,
                   double margin) {
  const PlateOutline o = plate_outline(anchor.true_plate);
  double left = 1e9, top = 1e9, right = -1e9, bottom = -1e9;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) {  // points along the edges: distortion bends them
      const double t = k / 4.0;
      const double u = i == 0 ? -1 + 2 * t : i == 1 ? 1 : i == 2 ? 1 - 2 * t : -1;
      const double v = i == 0 ? 0 : i == 1 ? t : i == 2 ? 1 : 1 - t;
      const Eigen::Vector3d in_plate(u * o.half_width, o.bottom + v * (o.top - o.bottom), 0);
      const Eigen::Vector3d p = camera_from_building * (anchor.building_from_plate * in_plate);
      const double reach = std::max(camera.width, camera.height) / camera.fx;
      if (p.z() < 0.1 || p.head<2>().norm() > reach * p.z()) return {0, 0, 0, 0};  // far outside the field
      const auto pixel = project(camera, p);
      if (!pixel) return {0, 0, 0, 0};
      left = std::min(left, pixel->x()), right = std::max(right, pixel->x());
      top = std::min(top, pixel->y()), bottom = std::max(bottom, pixel->y());
    }
  }
  return {std::max(0, static_cast<int>(std::floor(left - margin))),
          std::max(0, static_cast<int>(std::floor(top - margin))),
          std::min(camera.width, static_cast<int>(std::ceil(right + margin)) + 1),
          std::min(camera.height, static_cast<int>(std::ceil(bottom + margin)) + 1)};
}

/// Samples along one line of the window.
class SampleLine {
 public:
  /// `footprint`: width of a sample on the plate [m]; `stride`: pixels a line holds.
  SampleLine(const PlateDrawing& drawing, const Eigen::Matrix3d& plate_from_image, const RayGrid& rays,
             const Eigen::Vector3d& camera_in_plate, double footprint, std::size_t stride)
      : drawing_(drawing),
        camera_(camera_in_plate.cast<float>()),
        h_(plate_from_image),
        rays_(rays),
        inverse_width_(static_cast<float>(1.0 / footprint)),
        u_(kSamples * stride),
        v_(u_.size()),
        weighted_(u_.size()),
        coverage_(u_.size()) {}

  /// Sample i lies at pixel column first + (i + 0.5)/4 - 0.5, all at pixel row `row`. It is stored at (i mod 4) ·
  /// stride + i / 4, so that the integration runs over neighbours in memory.
  void draw(double row, int first, std::vector<float>& weighted, std::vector<float>& coverage) {
    place(row, first);
    if (drawing_.bend != 0) follow_bend();
    draw_samples(drawing_, u_.data(), v_.data(), u_.size(), inverse_width_, weighted_.data(), coverage_.data());
    const std::size_t stride = u_.size() / kSamples;
    for (std::size_t k = 0; k < kSamples; ++k) {
      for (std::size_t i = 0; i < stride; ++i) {
        weighted[k * stride + i] = weighted_[kSamples * i + k];
        coverage[k * stride + i] = coverage_[kSamples * i + k];
      }
    }
  }

 private:
  /// From the plane to the twisted plate, z = bend · u v / h² about the tag's centre: two steps towards the camera.
  void follow_bend() {
    for (std::size_t i = 0; i < u_.size(); ++i) {
      float u = u_[i], v = v_[i];
      for (int pass = 0; pass < 2; ++pass) {
        const float z =
            drawing_.bend * (u - drawing_.tag_x) * (v - drawing_.tag_y) * drawing_.inverse_half * drawing_.inverse_half;
        const float share = z / camera_.z();
        u = u_[i] + (camera_.x() - u_[i]) * share, v = v_[i] + (camera_.y() - v_[i]) * share;
      }
      u_[i] = u, v_[i] = v;
    }
  }

  /// Plate coordinates of all samples, cell by cell of the grid of rays: within one, a ray is linear along the row.
  void place(double row, int first) {
    const int cell_row = std::clamp(static_cast<int>(std::floor(row / RayGrid::step)), 0, rays_.rows - 2);
    const double b = row / RayGrid::step - cell_row;
    const double spacing = 1.0 / (kSamples * RayGrid::step);  // of the samples, in cells
    const double start = (first + 0.5 / kSamples - 0.5) / RayGrid::step;
    std::size_t done = 0;
    while (done < u_.size()) {
      const double at = start + static_cast<double>(done) * spacing;
      const int cell = std::clamp(static_cast<int>(std::floor(at)), 0, rays_.columns - 2);
      const double left_in_cell = cell == rays_.columns - 2 ? 1e9 : std::ceil((cell + 1 - at) / spacing);
      const std::size_t count = std::min(u_.size() - done, static_cast<std::size_t>(std::max(1.0, left_in_cell)));
      const std::size_t n = rays_.index(cell, cell_row), m = rays_.index(cell, cell_row + 1);
      const auto blend = [&](const std::vector<double>& grid, std::size_t k) {
        return grid[n + k] + b * (grid[m + k] - grid[n + k]);
      };
      const Eigen::Vector3d left(blend(rays_.x, 0), blend(rays_.y, 0), 1);
      const Eigen::Vector3d along(blend(rays_.x, 1) - left.x(), blend(rays_.y, 1) - left.y(), 0);
      const Eigen::Vector3d origin = h_ * (left + (at - cell) * along), slope = h_ * (spacing * along);
      divide_along({origin.x(), origin.y(), origin.z(), slope.x(), slope.y(), slope.z()}, count, u_.data() + done,
                   v_.data() + done);
      done += count;
    }
  }

  const PlateDrawing& drawing_;
  const Eigen::Vector3f camera_;
  const Eigen::Matrix3d h_;
  const RayGrid& rays_;
  float inverse_width_;
  std::vector<float> u_, v_, weighted_, coverage_;
};

/// out += weight · line
__attribute__((target_clones("avx2", "default"))) void add_line(const float* line, float weight, std::size_t count,
                                                                float* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] += weight * line[i];
}

/// out[i] = Σ kernel[k] · sample(4 i + k + skip), with the samples stored as SampleLine::draw does.
void integrate_line(const std::vector<float>& samples, const std::vector<float>& kernel, std::size_t skip,
                    std::vector<float>& out) {
  const std::size_t stride = samples.size() / kSamples;
  std::fill(out.begin(), out.end(), 0.0f);
  for (std::size_t k = 0; k < kernel.size(); ++k) {
    const std::size_t i = k + skip;
    add_line(samples.data() + (i % kSamples) * stride + i / kSamples, kernel[k], out.size(), out.data());
  }
}

}  // namespace

RayGrid::RayGrid(const BrownCamera& camera, const Eigen::Vector2d& drift)
    : columns((camera.width + step - 1) / step + 1), rows((camera.height + step - 1) / step + 1) {
  x.reserve(static_cast<std::size_t>(columns) * rows);
  y.reserve(x.capacity());
  for (int r = 0; r < rows; ++r) {
    const Eigen::Vector2d moved = drift * (static_cast<double>(r * step) / camera.height - 0.5);
    for (int c = 0; c < columns; ++c) {
      const auto ray = unproject(camera, Eigen::Vector2d(c * step, r * step) + moved);
      if (!ray) throw std::invalid_argument("the camera's distortion cannot be inverted within the image");
      x.push_back(ray->x());
      y.push_back(ray->y());
    }
  }
}

std::vector<float> tag_modules(int tag_id) {
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tag36h11_create(), tag36h11_destroy);
  if (tag_id < 0 || static_cast<std::uint32_t>(tag_id) >= family->ncodes) {
    throw std::invalid_argument("tag36h11 has no tag " + std::to_string(tag_id) + ", its ids are 0 to " +
                                std::to_string(family->ncodes - 1));
  }
  // A white edge, within it a black border, within that the bits of the code, the first being the highest.
  const std::size_t width = static_cast<std::size_t>(family->total_width);
  const std::size_t edge = (width - static_cast<std::size_t>(family->width_at_border)) / 2;
  std::vector<float> modules(width * width, 1.0f);
  for (std::size_t r = edge; r < width - edge; ++r) {
    for (std::size_t c = edge; c < width - edge; ++c) modules[r * width + c] = 0.0f;
  }
  const std::uint64_t code = family->codes[tag_id];
  for (std::uint32_t i = 0; i < family->nbits; ++i) {
    if ((code >> (family->nbits - 1 - i)) & 1) {
      modules[(family->bit_y[i] + edge) * width + family->bit_x[i] + edge] = 1.0f;
    }
  }
  return modules;
}

PlateRaster raster_plate(const Anchor& anchor, const BrownCamera& camera, const RigidTransform& camera_from_building,
                         const RayGrid& rays, double blur, const Perturbations& flaws) {
  const std::vector<float> kernel = integration_kernel(blur);
  const int reach = static_cast<int>(kernel.size()) / 2;  // samples
  const int margin = (reach + kSamples - 1) / kSamples;   // pixels
  const Window w = find_window(anchor, camera, camera_from_building, margin + 1 + flaws.rolling_shutter);
  PlateRaster out;
  if (w.right <= w.left || w.bottom <= w.top) return out;
  out.left = w.left, out.top = w.top, out.width = w.right - w.left, out.height = w.bottom - w.top;
  const std::size_t width = static_cast<std::size_t>(out.width), height = static_cast<std::size_t>(out.height);
  out.reflectance.assign(width * height, 0);
  out.coverage.assign(width * height, 0);

  const PlateDrawing drawing = make_drawing(anchor, flaws);

  // Lines of samples are integrated along the row first, then each adds to the rows of pixels it lies near. Tap k of
  // pixel i is sample 4 i + k - lead; drawing starts whole pixels before the window, `skip` samples before the first
  // that is needed.
  const int taps = static_cast<int>(kernel.size()), lead = reach - kSamples / 2;
  const int pixels_before = (lead + kSamples - 1) / kSamples;
  const std::size_t skip = static_cast<std::size_t>(kSamples * pixels_before - lead);
  const std::size_t stride = width + static_cast<std::size_t>(2 * pixels_before + 1);
  std::vector<float> weighted(kSamples * stride), coverage(kSamples * stride), row_weighted(width), row_coverage(width);
  const double footprint = (camera_from_building * anchor.built).z() / camera.fx / kSamples;
  const Eigen::Vector3d camera_in_plate =
      (camera_from_building * anchor.building_from_plate).inverse() * Eigen::Vector3d::Zero();
  SampleLine line(drawing, plate_from_image(anchor, camera_from_building), rays, camera_in_plate, footprint, stride);
  for (int s = -lead; s < kSamples * out.height + lead; ++s) {
    const double row = w.top + (s + 0.5) / kSamples - 0.5;
    line.draw(row, w.left - pixels_before, weighted, coverage);
    integrate_line(weighted, kernel, skip, row_weighted);
    integrate_line(coverage, kernel, skip, row_coverage);
    for (int k = 0; k < taps; ++k) {
      const int first_sample = s + lead - k;  // of the pixel for which this line is tap k
      if (first_sample < 0 || first_sample % kSamples != 0 || first_sample / kSamples >= out.height) continue;
      const std::size_t offset = static_cast<std::size_t>(first_sample / kSamples) * width;
      add_line(row_weighted.data(), kernel[k], width, out.reflectance.data() + offset);
      add_line(row_coverage.data(), kernel[k], width, out.coverage.data() + offset);
    }
  }
  return out;
}

}  // namespace plumbline::simulate
