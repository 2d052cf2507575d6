// One marker plate as an image sees it.
#pragma once

#include <vector>

#include "building.hpp"
#include "geometry/camera.hpp"
#include "perturbations.hpp"

namespace plumbline::simulate {

/// Normalised image coordinates, free of distortion, at every 16th pixel; between them bilinear.
struct RayGrid {
  static constexpr int step = 16;
  int columns = 0, rows = 0;
  std::vector<double> x, y;  ///< rows × columns

  /// Throws std::invalid_argument if the distortion cannot be inverted within the image.
  /// `drift`: how far the image moves between the exposures of the first and the last row [px].
  explicit RayGrid(const BrownCamera& camera, const Eigen::Vector2d& drift = {0, 0});
  std::size_t index(int column, int row) const { return static_cast<std::size_t>(row) * columns + column; }
};

/// Black and white modules of a tag36h11, 10 × 10 with the white edge, row 0 on top. Throws std::invalid_argument for
/// an id the family lacks.
std::vector<float> tag_modules(int tag_id);

/// Pixels that a plate covers: reflectance weighted with coverage, and coverage in [0, 1].
struct PlateRaster {
  int left = 0, top = 0, width = 0, height = 0;  ///< the window [px], inside the image; width 0: the plate is not in it
  std::vector<float> reflectance, coverage;      ///< height × width
};

/// `blur`: standard deviation of the point spread function [px]; of `flaws`, ink_spread and dirt are drawn.
PlateRaster raster_plate(const Anchor& anchor, const BrownCamera& camera, const RigidTransform& camera_from_building,
                         const RayGrid& rays, double blur, const Perturbations& flaws = {});

}  // namespace plumbline::simulate
