#include "surface/dense/orthophoto.hpp"

#include <algorithm>
#include <cmath>

#include "plumbline/stop.hpp"

namespace plumbline::surface {
namespace {

/// Grey value at a place of a reduced photograph, bilinear; −1 outside.
int grey_at(const GreyImage& image, double x, double y) {
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  if (left < 0 || top < 0 || left + 1 >= image.width || top + 1 >= image.height) return -1;
  const double a = x - left, b = y - top;
  const std::uint8_t* p = image.pixels.data() + static_cast<size_t>(top) * static_cast<size_t>(image.width) + left;
  const std::uint8_t* q = p + image.width;
  return static_cast<int>(std::lround((1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * q[0] + a * q[1])));
}

/// Rows and columns of the picture whose pixels may lie within `beyond` of a face.
struct Window {
  int left, right, top, bottom;
};
Window window_of(const PanelFace& face, double beyond, const Orthophoto& picture) {
  Eigen::Vector2d low(1e300, 1e300), high = -low;
  for (const double a : {-0.5, 0.5})
    for (const double b : {-0.5, 0.5}) {
      const Eigen::Vector2d at =
          picture.plane.local(face.plane.world({a * (face.width + 2 * beyond), b * (face.height + 2 * beyond), 0}))
              .head<2>();
      low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
  const auto column = [&](double u) {
    return static_cast<int>(std::floor((u - picture.area.low.x()) / picture.pixel));
  };
  const auto row = [&](double v) { return static_cast<int>(std::floor((picture.area.high.y() - v) / picture.pixel)); };
  return {std::max(0, column(low.x())), std::min(picture.width - 1, column(high.x())), std::max(0, row(high.y())),
          std::min(picture.height - 1, row(low.y()))};
}

/// Where the perpendicular of the picture's plane through a place of it meets a panel, as (u, v, h) of its face. Faces
/// of one picture lie off its plane and lean against it, so that their own perpendicular is another.
Eigen::Vector3d place_on(const PanelFace& face, const PanelSurface& surface, const Eigen::Vector3d& on_picture,
                         const Eigen::Vector3d& out) {
  const Eigen::Vector3d direction = face.plane.axes.transpose() * out;
  Eigen::Vector3d at = face.plane.local(on_picture);
  double height = 0;
  for (int step = 0; step < 3; ++step) {  // on a plane the first one is right; panels are flat to a hundredth
    at += (height - at.z()) / direction.z() * direction;
    height = surface.not_measured.empty() ? surface.base(at.x(), at.y()).dot(surface.form) : 0.0;
  }
  return {at.x(), at.y(), height};
}

}  // namespace

std::vector<std::vector<size_t>> facades_of(const std::vector<PanelFace>& faces, double offset) {
  std::vector<std::vector<size_t>> facades;
  for (size_t f = 0; f < faces.size(); ++f) {
    const auto same = [&](const std::vector<size_t>& facade) {
      const FacadePlane& first = faces[facade.front()].plane;
      return first.axes.col(2).dot(faces[f].plane.axes.col(2)) > std::cos(5 * M_PI / 180) &&
             std::abs(first.local(faces[f].plane.origin).z()) < offset;
    };
    const auto found = std::find_if(facades.begin(), facades.end(), same);
    if (found != facades.end())
      found->push_back(f);
    else
      facades.push_back({f});
  }
  return facades;
}

Orthophoto orthophoto_of(const std::vector<PanelFace>& faces, const std::vector<size_t>& facade, double pixel,
                         double margin, double most) {
  Orthophoto picture;
  picture.plane = facade_plane(faces[facade.front()].plane.origin, faces[facade.front()].plane.axes.col(2));
  picture.pixel = pixel;
  Eigen::Vector2d low(1e300, 1e300), high = -low;
  for (const size_t f : facade)
    for (const double a : {-0.5, 0.5})
      for (const double b : {-0.5, 0.5}) {
        const Eigen::Vector2d at =
            picture.plane.local(faces[f].plane.world({a * faces[f].width, b * faces[f].height, 0})).head<2>();
        low = low.cwiseMin(at), high = high.cwiseMax(at);
      }
  picture.area = {low - Eigen::Vector2d(margin, margin), high + Eigen::Vector2d(margin, margin)};
  const Eigen::Vector2d extent = picture.area.high - picture.area.low;
  picture.pixel = std::max(pixel, std::sqrt(extent.prod() / most));
  const Eigen::Vector2d size = extent / picture.pixel;
  picture.width = static_cast<int>(std::ceil(size.x() - 1e-6)),
  picture.height = static_cast<int>(std::ceil(size.y() - 1e-6));
  picture.grey.assign(static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height), 0);
  return picture;
}

int best_view(const PanelFace& face, const std::vector<FacetView>& views) {
  int best = -1;
  bool best_whole = false;
  double smallest = 0;
  for (size_t k = 0; k < views.size(); ++k) {
    const auto middle = map_at(*views[k].view, face.plane, {0, 0, 0}, 2);
    if (!middle) continue;
    bool whole = true;
    for (const double a : {-0.5, 0.5})
      for (const double b : {-0.5, 0.5})
        whole = whole && map_at(*views[k].view, face.plane, {a * face.width, b * face.height, 0}, 2).has_value();
    const double ground = middle->ground_pixel();
    if (best >= 0 && (whole != best_whole ? !whole : ground >= smallest)) continue;
    best = static_cast<int>(k), best_whole = whole, smallest = ground;
  }
  return best;
}

void paint(const PanelFace& face, const PanelSurface& surface, const FacetView& view, double beyond,
           Orthophoto& picture) {
  const auto middle = map_at(*view.view, face.plane, {0, 0, 0}, -1e6);
  if (!middle) return;
  // As many pixels of the photograph as one of the picture holds are taken together.
  int level = 0;
  while (level + 1 < Pyramid::levels && middle->ground_pixel() * (2 << level) <= picture.pixel) ++level;
  const GreyImage& image = view.image->level[level];
  const double scale = 1.0 / (1 << level), shift = 0.5 * (scale - 1);
  const Window window = window_of(face, beyond, picture);
  for (int y = window.top; y <= window.bottom; ++y) {
    stop_point();
    for (int x = window.left; x <= window.right; ++x) {
      std::uint8_t& grey =
          picture.grey[static_cast<size_t>(y) * static_cast<size_t>(picture.width) + static_cast<size_t>(x)];
      const Eigen::Vector3d on_plane = picture.plane.world(
          {picture.area.low.x() + (x + 0.5) * picture.pixel, picture.area.high.y() - (y + 0.5) * picture.pixel, 0});
      const Eigen::Vector3d at = place_on(face, surface, on_plane, picture.plane.axes.col(2));
      const double off_u = std::abs(at.x()) - 0.5 * face.width, off_v = std::abs(at.y()) - 0.5 * face.height;
      if (off_u > beyond || off_v > beyond || ((off_u > 0 || off_v > 0) && grey != 0)) continue;
      const auto seen = project(view.view->camera, view.view->cam_from_world * face.plane.world(at));
      if (!seen) continue;
      const int value = grey_at(image, seen->x() * scale + shift, seen->y() * scale + shift);
      if (value >= 0) grey = static_cast<std::uint8_t>(std::max(1, value));
    }
  }
}

}  // namespace plumbline::surface
