#include "surface/dense/screens.hpp"

#include <cmath>

namespace plumbline::surface {
namespace {

/// Whether `other` may lie between `centre` and the rectangle of `face`. Its shadow on the face's plane is taken as the
/// rectangle about the shadows of its corners, so that none is missed.
bool may_hide(const PanelFace& other, const PanelFace& face, const Eigen::Vector3d& centre, double beyond) {
  const Eigen::Vector3d eye = face.plane.local(centre);
  if (!(eye.z() > Screens::kApart)) return false;
  Eigen::Vector2d low(1e300, 1e300), high = -low;
  bool before = false, beside_the_eye = false;
  for (const double a : {-0.5, 0.5})
    for (const double b : {-0.5, 0.5}) {
      const Eigen::Vector3d corner = face.plane.local(other.plane.world({a * other.width, b * other.height, 0}));
      before = before || corner.z() > Screens::kApart;
      if (corner.z() >= eye.z() - 1e-6) {  // its shadow has no end
        beside_the_eye = true;
        continue;
      }
      const Eigen::Vector3d ray = corner - eye;
      const Eigen::Vector2d shadow = (eye - ray * (eye.z() / ray.z())).head<2>();
      low = low.cwiseMin(shadow), high = high.cwiseMax(shadow);
    }
  if (!before) return false;
  if (beside_the_eye) return true;
  return low.x() <= 0.5 * face.width + beyond && high.x() >= -0.5 * face.width - beyond &&
         low.y() <= 0.5 * face.height + beyond && high.y() >= -0.5 * face.height - beyond;
}

}  // namespace

Screens::Screens(const std::vector<PanelFace>& faces, size_t of, const Eigen::Vector3d& centre, double beyond)
    : centre_(centre) {
  for (size_t f = 0; f < faces.size(); ++f)
    if (f != of && may_hide(faces[f], faces[of], centre, beyond)) faces_.push_back(&faces[f]);
}

bool Screens::hide(const Eigen::Vector3d& place) const {
  for (const PanelFace* face : faces_) {
    const Eigen::Vector3d from = face->plane.local(centre_), to = face->plane.local(place);
    if (from.z() * to.z() >= 0) continue;  // both on one side of its plane
    const double share = from.z() / (from.z() - to.z());
    if ((1 - share) * (to - from).norm() <= kApart) continue;
    const Eigen::Vector3d at = from + share * (to - from);
    if (std::abs(at.x()) <= 0.5 * face->width && std::abs(at.y()) <= 0.5 * face->height) return true;
  }
  return false;
}

}  // namespace plumbline::surface
