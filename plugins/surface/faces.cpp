#include "faces.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <stdexcept>

namespace plumbline::surface {
namespace {

/// How many of the projection centres lie before the plane, and at no flatter an angle than 15° to it, less those behind.
int looked_at(const Eigen::Vector3d& origin, const Eigen::Vector3d& out, const std::vector<Eigen::Vector3d>& seen_from) {
  int count = 0;
  for (const Eigen::Vector3d& centre : seen_from) {
    const double cosine = (centre - origin).normalized().dot(out);
    if (std::abs(cosine) > 0.26) count += cosine > 0 ? 1 : -1;
  }
  return count;
}

}  // namespace

Faces faces_of(const DesignT& design, const std::vector<Eigen::Vector3d>& seen_from) {
  Faces result;
  for (const auto& element : design.elements) {
    if (!element->is_panel) continue;
    const std::string name = element->name.empty() ? element->guid : element->name;
    const Eigen::Vector3d size = element->box_high - element->box_low;
    if (!size.allFinite() || !(size.minCoeff() >= 0)) {
      result.left_out.push_back(name + ": the design gives no shape that a face could be taken from");
      continue;
    }
    int thin = 0;
    size.minCoeff(&thin);
    const Eigen::Matrix3d turn = element->placement.rotation.toRotationMatrix();
    const Eigen::Vector3d middle = element->placement * Eigen::Vector3d(0.5 * (element->box_low + element->box_high));
    Eigen::Vector3d out = turn.col(thin);
    int votes = looked_at(middle, out, seen_from);
    if (votes == 0 && design.facade_normal.allFinite()) votes = out.dot(design.facade_normal) >= 0 ? 1 : -1;
    if (votes == 0) {
      result.left_out.push_back(name + ": no photograph looks at it and the design does not say which side is outside");
      continue;
    }
    if (votes < 0) out = -out;
    PanelFace face;
    face.id = name;
    face.plane = facade_plane(middle + 0.5 * size(thin) * out, out);
    // The box's own edges are the face's, whatever is up: a panel may stand askew.
    const int wide = (thin + 1) % 3, high = (thin + 2) % 3;
    const bool swapped = std::abs(turn.col(wide).dot(face.plane.axes.col(1))) > std::abs(turn.col(high).dot(face.plane.axes.col(1)));
    const int across = swapped ? high : wide, upwards = swapped ? wide : high;
    Eigen::Vector3d up = turn.col(upwards);
    if (up.dot(face.plane.axes.col(1)) < 0) up = -up;
    face.plane.axes << up.cross(out), up, out;
    face.width = size(across), face.height = size(upwards);
    result.faces.push_back(face);
    result.guids.push_back(element->guid);
  }
  return result;
}

Faces face_through(const PointsT& points, const std::vector<Eigen::Vector3d>& seen_from, double margin) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> places;
  for (const auto& point : points.points)
    if (point->position.allFinite()) places.push_back(point->position), mean += point->position;
  if (places.size() < 3)
    throw std::runtime_error("a plane needs three points with coordinates, 'points' has " + std::to_string(places.size()));
  mean /= static_cast<double>(places.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& place : places) scatter += (place - mean) * (place - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
  if (!(axes.eigenvalues()(1) > 1e-4 * axes.eigenvalues()(2)))
    throw std::runtime_error("the " + std::to_string(places.size()) + " points of 'points' lie on a line; connect 'design', or more points");
  Eigen::Vector3d out = axes.eigenvectors().col(0);
  if (looked_at(mean, out, seen_from) < 0) out = -out;
  PanelFace face;
  face.id = "plane of the points";
  face.plane = facade_plane(mean, out);
  Eigen::Vector2d low(1e300, 1e300), high = -low;
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Vector2d at = face.plane.local(place).head<2>();
    low = low.cwiseMin(at), high = high.cwiseMax(at);
  }
  const Eigen::Vector2d middle = 0.5 * (low + high);
  face.plane.origin = face.plane.world({middle.x(), middle.y(), 0});
  face.width = high.x() - low.x() + 2 * margin, face.height = high.y() - low.y() + 2 * margin;
  return {{face}, {""}, {}};
}

}  // namespace plumbline::surface
