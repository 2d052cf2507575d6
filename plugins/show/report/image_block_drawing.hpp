// Drawings of an image block: cameras and points in space, residuals over the image, crops of single tags.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "show/report/markup.hpp"

namespace plumbline {
struct GreyImage;
}

namespace plumbline::report {

struct DrawnCamera {
  std::string name;
  Eigen::Vector3d centre, forward;  ///< `forward` is a unit vector
};

struct DrawnPoint {
  std::string name;
  Eigen::Vector3d position;
};

/// Two parallel projections side by side: along the points' normal, and from above it.
void draw_scene(Markup& html, const std::vector<DrawnCamera>& cameras, const std::vector<DrawnPoint>& points);

/// A view that can be turned, where scripts run; nothing else shows only there.
void draw_space(Markup& html, const std::vector<DrawnCamera>& cameras, const std::vector<DrawnPoint>& points);

struct DrawnResidual {
  Eigen::Vector2d at, residual;  ///< [px]
};

/// Residuals as arrows over a frame of width × height pixels, with the scale of the arrows in words.
void draw_residuals(Markup& html, int width, int height, const std::vector<DrawnResidual>& residuals);

/// The photograph around four corners, with the measured corners; nothing if they lie outside.
void draw_crop(Markup& html, const GreyImage& image, const std::vector<Eigen::Vector2d>& corners);

/// The surroundings of one corner, 16 px or more, with where it was measured (a ring) and where the adjustment puts it
/// (a cross).
void draw_corner(Markup& html, const GreyImage& image, const Eigen::Vector2d& measured,
                 const Eigen::Vector2d& computed);

}  // namespace plumbline::report
