#include "panels.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "geometry/random.hpp"

namespace plumbline::simulate {
namespace {

constexpr double kJointDepth = 0.06;  // of what is seen between panels, behind their faces [m]
constexpr float kJointLight = 0.08F;  // reflectance
constexpr double kPanelLight = 0.42;  // on average
constexpr double kBeside = 0.05;      // of a panel's edge: beyond it nothing of the panel is seen [m]

/// Smooth noise in [-1, 1] with cells of a size.
double grain(double u, double v, double cell, std::uint64_t seed) {
  const double x = u / cell, z = v / cell, fx = std::floor(x), fz = std::floor(z), a = x - fx, b = z - fz;
  const auto corner = [&](double cx, double cz) {
    const auto key = static_cast<std::uint64_t>(static_cast<std::int64_t>(cx)) * 0x9E3779B97F4A7C15ULL +
                     static_cast<std::uint64_t>(static_cast<std::int64_t>(cz));
    return static_cast<double>(mix_bits(seed ^ mix_bits(key)) >> 11) * 0x1.0p-52 - 1.0;
  };
  const double s = a * a * (3 - 2 * a), t = b * b * (3 - 2 * b);
  const double lower = corner(fx, fz) * (1 - s) + corner(fx + 1, fz) * s;
  const double upper = corner(fx, fz + 1) * (1 - s) + corner(fx + 1, fz + 1) * s;
  return lower * (1 - t) + upper * t;
}

/// Grains that are some pixels large from near and from far.
double texture(double u, double v, std::uint64_t seed) {
  return 0.5 * grain(u, v, 0.010, seed) + 0.3 * grain(u, v, 0.025, seed + 1) + 0.2 * grain(u, v, 0.060, seed + 2);
}

/// What a ray shows of a panel: how much of the pixel, and how light it is.
struct Shown {
  double share = 0, light = 0;
};

Shown show(const HungPanel& panel, const Eigen::Vector2d& near, const Eigen::Vector3d& centre,
           const Eigen::Vector3d& ray, double pixel, double contrast) {
  Eigen::Vector2d at = near - panel.middle;
  double reach = 1;
  // The ray meets the panel where it is, some millimetres from the design's face: steps of the relief's slope.
  for (int step = 0; step < 3; ++step) {
    reach = (PanelGrid::face - panel.height(at) - centre.y()) / ray.y();
    at = Eigen::Vector2d(centre.x() + reach * ray.x(), centre.z() + reach * ray.z()) - panel.middle;
  }
  const double inside = (panel.half - at.cwiseAbs()).minCoeff();
  Shown shown;
  shown.share = std::clamp(inside / (pixel * reach) + 0.5, 0.0, 1.0);
  if (shown.share > 0) shown.light = kPanelLight * (1 + contrast * texture(at.x(), at.y(), panel.seed));
  return shown;
}

}  // namespace

std::string panel_name(int floor, int column) { return fmt::format("F{:02}-P{:02}", floor, column); }

double HungPanel::height(const Eigen::Vector2d& from_middle) const {
  const Eigen::Vector2d at = from_middle.cwiseQuotient(half);
  return offset + tilt_right * at.x() + tilt_up * at.y() + bow_across * (1 - at.x() * at.x()) +
         bow_up * (1 - at.y() * at.y());
}

std::vector<HungPanel> hang_panels(const Building& building, double sigma, std::uint64_t seed) {
  std::vector<HungPanel> panels;
  const double pitch = building.options.spacing, storey = building.storey_height;
  for (int floor = 1; floor <= building.options.floors; ++floor)
    for (int column = 1; column < building.options.columns; ++column) {
      HungPanel panel;
      panel.name = panel_name(floor, column);
      panel.middle = {pitch * column, storey * (floor - 0.5)};
      panel.half = 0.5 * Eigen::Vector2d(pitch - PanelGrid::joint, storey - PanelGrid::joint);
      Random random(seed, "panel " + panel.name);
      panel.offset = random.normal(sigma);
      for (double* form : {&panel.tilt_right, &panel.tilt_up, &panel.bow_across, &panel.bow_up})
        *form = random.normal(0.5 * sigma);
      panel.seed = derive_seed(seed, "texture of " + panel.name);
      panels.push_back(panel);
    }
  return panels;
}

void paint_panels(const std::vector<HungPanel>& panels, const Eigen::Vector3d& centre, double wall, double pixel,
                  double contrast, const std::vector<float>& x, const std::vector<float>& z,
                  std::vector<float>& reflectance) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
  for (const HungPanel& panel : panels)
    low = low.cwiseMin(panel.middle - panel.half), high = high.cwiseMax(panel.middle + panel.half);
  for (std::size_t i = 0; i < reflectance.size(); ++i) {
    const Eigen::Vector3d ray =
        Eigen::Vector3d(static_cast<double>(x[i]), wall, static_cast<double>(z[i])) - centre;  // to the wall
    const auto met = [&](double y) {
      const double reach = (y - centre.y()) / ray.y();
      return Eigen::Vector2d(centre.x() + reach * ray.x(), centre.z() + reach * ray.z());
    };
    const auto among = [&](const Eigen::Vector2d& at, double beside) {
      return (at - low).minCoeff() > -beside && (high - at).minCoeff() > -beside;
    };
    const Eigen::Vector2d near = met(PanelGrid::face);
    if (!among(near, kBeside)) continue;
    double light = static_cast<double>(among(met(PanelGrid::face + kJointDepth), 0) ? kJointLight : reflectance[i]);
    for (const HungPanel& panel : panels) {
      if ((panel.half - (near - panel.middle).cwiseAbs()).minCoeff() < -kBeside) continue;
      const Shown shown = show(panel, near, centre, ray, pixel, contrast);
      light += shown.share * (shown.light - light);
    }
    reflectance[i] = static_cast<float>(light);
  }
}

std::string panels_truth(const std::vector<HungPanel>& panels) {
  std::string text =
      "panel,offset_mm,tilt_right_mm_per_m,tilt_up_mm_per_m,bow_across_mm,bow_up_mm\n";  // of the best plane
  for (const HungPanel& p : panels)
    text += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f}\n", p.name,
                        1e3 * (p.offset + (p.bow_across + p.bow_up) * 2 / 3), 1e3 * p.tilt_right / p.half.x(),
                        1e3 * p.tilt_up / p.half.y(), 1e3 * p.bow_across, 1e3 * p.bow_up);
  return text;
}

}  // namespace plumbline::simulate
