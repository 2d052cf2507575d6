// Buildings of many shapes: straight wings that face a way each.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "building/ifc/facade_frame.hpp"

namespace plumbline::test {

inline constexpr double kDegree = std::numbers::pi / 180;

/// A straight row of anchors in two storeys, with panels 0.2 m before them.
struct Wing {
  Eigen::Vector2d start;  ///< left end as one stands before it [m]
  double azimuth;         ///< [deg]
  int columns = 4;
};

struct Shape {
  const char* name;
  std::vector<Wing> wings;
  Eigen::Vector3d building;  ///< centre of the slabs
};

enum Cut { everything, no_slabs, anchors_only, podium, no_panels, podium_no_panels, beyond };

/// Thirteen buildings.
inline std::vector<Shape> shapes() {
  using ifc::facing;
  std::vector<Shape> all = {
      {"flat", {{{0, 0}, 180}}, {4, 3, 0}},
      {"column", {{{0, 0}, 180, 1}}, {1, 3, 0}},
      {"two", {{{0, 0}, 180}, {{8, 0}, 90}}, {4, 4, 0}},
      {"four", {{{0, 0}, 180}, {{8, 0}, 90}, {{8, 8}, 0}, {{0, 8}, 270}}, {4, 4, 0}},
      {"set back", {{{0, 0}, 180}, {{8, 1.2}, 180}, {{16, 0}, 180}}, {12, 5, 0}},
      {"a little set back", {{{0, 0}, 180}, {{8, 0.3}, 180}}, {8, 5, 0}},
      {"court", {{{0, 20}, 180}, {{12, 8}, 270}, {{-4, 20}, 90}, {{8, 0}, 0}}, {4, 10, 0}},
      {"L", {{{0, 0}, 180, 8}, {{16, 0}, 90}, {{16, 8}, 0}, {{8, 8}, 90}, {{8, 16}, 0}, {{0, 16}, 270, 8}}, {6, 6, 0}},
      {"outside and court",
       {{{0, 0}, 180, 12},
        {{24, 0}, 90, 12},
        {{24, 24}, 0, 12},
        {{0, 24}, 270, 12},
        {{8, 16}, 180},
        {{16, 16}, 270},
        {{16, 8}, 0},
        {{8, 8}, 90}},
       {12, 12, 0}},
      {"half a metre set back", {{{0, 0}, 180}, {{8, 0.6}, 180, 2}, {{12, 0}, 180}}, {8, 5, 0}},
      {"a metre set back", {{{0, 0}, 180}, {{8, 1.0}, 180}}, {8, 5, 0}},
      {"folded", {{{0, 0}, 180}, {{8, 0}, 150}, {{8 + 8 * std::cos(30 * kDegree), 4}, 120}}, {8, 12, 0}},
  };
  Shape curve{"curved", {}, {0, 0, 0}};
  for (int i = 0; i < 9; ++i) {
    const double azimuth = 120 + 15 * i;
    const Eigen::Vector3d out = facing(azimuth * kDegree), right = Eigen::Vector3d::UnitZ().cross(out);
    const Eigen::Vector3d start = 7.6 * out - right;
    curve.wings.push_back({start.head<2>(), azimuth, 1});
  }
  all.push_back(curve);
  return all;
}

/// The design as the same building stands elsewhere: turned about the vertical, and mirrored in x before that.
inline Shape moved(Shape shape, double turn, bool mirrored) {
  const Eigen::Rotation2Dd by(-turn * kDegree);  // azimuths go clockwise
  for (Wing& wing : shape.wings) {
    if (mirrored) {  // the left end becomes the right one
      const Eigen::Vector3d out = ifc::facing(wing.azimuth * kDegree), right = Eigen::Vector3d::UnitZ().cross(out);
      wing.start += 2.0 * wing.columns * right.head<2>();
      wing.start.x() = -wing.start.x(), wing.azimuth = 360 - wing.azimuth;
    }
    wing.start = by * wing.start, wing.azimuth += turn;
  }
  if (mirrored) shape.building.x() = -shape.building.x();
  shape.building.head<2>() = by * shape.building.head<2>().eval();
  return shape;
}

}  // namespace plumbline::test
