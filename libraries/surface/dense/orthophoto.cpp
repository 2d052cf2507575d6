#include "surface/dense/orthophoto.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::surface {
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
  picture.grey.assign(static_cast<size_t>(picture.width) * picture.height, 0);
  picture.shown.assign(picture.grey.size(), Shown::unseen);
  return picture;
}

GreyImage reduced(const Orthophoto& picture, int most) {
  const int edge = std::max(1, (std::max(picture.width, picture.height) + most - 1) / most);
  GreyImage small;
  small.width = (picture.width + edge - 1) / edge, small.height = (picture.height + edge - 1) / edge;
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      int sum = 0, shown = 0, all = 0;
      for (int b = y * edge; b < std::min((y + 1) * edge, picture.height); ++b)
        for (int a = x * edge; a < std::min((x + 1) * edge, picture.width); ++a) {
          const int grey = picture.grey[static_cast<size_t>(b) * picture.width + a];
          sum += grey, shown += grey > 0, ++all;
        }
      small.pixels.push_back(2 * shown < all || shown == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(sum / shown));
    }
  return small;
}

std::vector<size_t> views_for_picture(const PanelFace& face, const std::vector<FacetView>& views) {
  struct Candidate {
    size_t number;
    bool whole;
    double ground;
    Eigen::Vector3d direction;
  };
  std::vector<Candidate> candidates;
  for (size_t k = 0; k < views.size(); ++k) {
    const auto middle = map_at(*views[k].view, face.plane, {0, 0, 0}, 2);
    if (!middle) continue;
    bool whole = true;
    for (const double a : {-0.5, 0.5})
      for (const double b : {-0.5, 0.5})
        whole = whole && map_at(*views[k].view, face.plane, {a * face.width, b * face.height, 0}, 2).has_value();
    candidates.push_back({k, whole, middle->ground_pixel(),
                          (views[k].view->cam_from_world.inverse().translation - face.plane.origin).normalized()});
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.whole != b.whole ? a.whole : a.ground < b.ground;
  });
  const double alike = std::cos(2 * M_PI / 180);
  std::vector<Candidate> apart, near;
  for (const Candidate& candidate : candidates) {
    const bool another = std::any_of(apart.begin(), apart.end(), [&](const Candidate& chosen) {
      return chosen.direction.dot(candidate.direction) > alike;
    });
    (another ? near : apart).push_back(candidate);
  }
  std::vector<size_t> numbers;
  for (const auto* list : {&apart, &near})
    for (const Candidate& candidate : *list) numbers.push_back(candidate.number);
  return numbers;
}

}  // namespace plumbline::surface
