// What lies behind the anchors of an elevation: the panels as they are, in colours, and the facade's picture.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "artifacts/surfaces.hpp"
#include "show/report/markup.hpp"

namespace plumbline::report {

constexpr int kHeatCells = 8;  ///< of a panel, each way

bool is_measured(const PanelSurfaceFiguresT& panel);
/// Height of a panel over its design at x and y from −1 to 1 [m].
double surface_height(const PanelSurfaceFiguresT& panel, double x, double y);
/// What the colours end at: all panels share it [m].
double heat_range(const SurfacesT& surfaces);
/// Blue behind the design, white on it, red before it: also apart for eyes that do not tell red from green.
std::string heat_colour(double height, double range);
void draw_heat_bar(Markup& html, double range);

/// A picture of a facade without perspective, as surface.orthophoto makes it.
struct FacadePicture {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(), right = origin, up = origin;  ///< of the facade's plane [m]
  double low_u = 0, low_v = 0, high_u = 0, high_v = 0;                            ///< of the picture on it [m]
  std::string jpeg;                                                               ///< the file's bytes
  Eigen::Vector3d place(double u, double v) const { return origin + u * right + v * up; }
  Eigen::Vector3d out() const { return right.cross(up); }
};

/// Where a place of the world lies in a drawing [px].
using Drawn = std::function<Eigen::Vector2d(const Eigen::Vector3d&)>;

/// The drawing as one looks at it: which way, and a place on the facade that it shows. What faces another way by more
/// than 10° or lies more than 1.5 m before or behind is of another facade.
struct LookedAt {
  Eigen::Vector3d out = Eigen::Vector3d::Zero(), place = out;
  bool shows(const Eigen::Vector3d& other_out, const Eigen::Vector3d& other_place) const;
};

/// Draws the pictures of the facade; false if there are none of it.
bool draw_pictures(Markup& svg, const std::vector<FacadePicture>& pictures, const LookedAt& at, const Drawn& drawn);
/// Draws the facade's panels in colours, those that were not measured in grey; false if there are none of it.
bool draw_heat(Markup& svg, const SurfacesT& surfaces, const LookedAt& at, const Drawn& drawn);
/// An <image> of a JPEG within the page.
void draw_jpeg(Markup& svg, const std::string& jpeg, double x, double y, double width, double height);

/// The listing facades.csv and a world file of surface.orthophoto with the pictures; `bytes_of` gives a file of the
/// folder. Throws std::runtime_error for a folder that is none of it.
std::vector<FacadePicture> facade_pictures(const std::function<std::string(const std::string& name)>& bytes_of);

}  // namespace plumbline::report
