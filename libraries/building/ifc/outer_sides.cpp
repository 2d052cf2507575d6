#include "building/ifc/outer_sides.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace plumbline::ifc {
namespace {

constexpr int kPlaces = 24;          // along each direction of a side
constexpr double kBorder = 0.03;     // [m] of a side, that is left out
constexpr double kMostBorder = 0.1;  // share of a side that the border takes at most
constexpr double kAtEnds = 0.02;     // share of the places that may be something else, at either end
constexpr double kSquare = 0.98;     // cosine from which on a face is square to an axis
constexpr double kOnePlane = 0.001;  // [m] along the axis, within which faces are one side
constexpr double kNarrower = 1e-4;   // [m], by which a side is narrower than the box
constexpr double kMostOfSide = 0.5;  // share of the box's side that the faces of a side take at least

/// Newell's normal, twice as long as the polygon's area is large.
Eigen::Vector3d normal_of(const PointCloud& polygon) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < polygon.size(); ++i)
    normal += (polygon[i] - polygon[0]).cross(polygon[(i + 1) % polygon.size()] - polygon[0]);
  return normal;
}

bool is_inside(const PointCloud& polygon, int i, int j, double u, double v) {
  bool inside = false;
  for (std::size_t a = 0, b = polygon.size() - 1; a < polygon.size(); b = a++) {
    const double va = polygon[a][j], vb = polygon[b][j];
    if ((va > v) == (vb > v)) continue;
    inside ^= u < polygon[a][i] + (v - va) / (vb - va) * (polygon[b][i] - polygon[a][i]);
  }
  return inside;
}

/// What is seen of a shape from both ends of an axis: heights at places of a grid, nan where nothing is.
class Sides {
 public:
  Sides(const Eigen::AlignedBox3d& box, int axis, double border) : axis_(axis), i_((axis + 1) % 3), j_((axis + 2) % 3) {
    const Eigen::Vector3d size = box.sizes();
    for (int k : {i_, j_}) {
      const double own = std::min(border, kMostBorder * size[k]);
      low_[k] = box.min()[k] + own, step_[k] = (size[k] - 2 * own) / kPlaces;
    }
    for (auto& side : heights_) side.assign(kPlaces * kPlaces, std::numeric_limits<double>::quiet_NaN());
  }

  void add(const PointCloud& polygon) {
    if (polygon.size() < 3) return;
    const Eigen::Vector3d normal = normal_of(polygon);
    if (!(std::abs(normal[axis_]) > 0.02 * normal.norm())) return;  // seen edge on
    Eigen::AlignedBox3d box;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& point : polygon)
      box.extend(point), middle += point / static_cast<double>(polygon.size());
    for (int a = first(box.min()[i_], i_); a < kPlaces && place(a, i_) <= box.max()[i_]; ++a)
      for (int b = first(box.min()[j_], j_); b < kPlaces && place(b, j_) <= box.max()[j_]; ++b) {
        const double u = place(a, i_), v = place(b, j_);
        if (!is_inside(polygon, i_, j_, u, v)) continue;
        const double height =
            middle[axis_] - (normal[i_] * (u - middle[i_]) + normal[j_] * (v - middle[j_])) / normal[axis_];
        double &least = heights_[0][a * kPlaces + b], &most = heights_[1][a * kPlaces + b];
        if (!(height >= least)) least = height;
        if (!(height <= most)) most = height;
      }
  }

  std::vector<double> seen_from(int end) const {
    std::vector<double> seen;
    for (const double height : heights_[end])
      if (std::isfinite(height)) seen.push_back(height);
    return seen;
  }
  double filled(int end) const {
    return static_cast<double>(seen_from(end).size()) / static_cast<double>(heights_[end].size());
  }
  double sag(int end) const {
    std::vector<double> seen = seen_from(end);
    if (2 * seen.size() < heights_[end].size()) return std::numeric_limits<double>::quiet_NaN();
    std::sort(seen.begin(), seen.end());
    const auto at_end = static_cast<std::size_t>(kAtEnds * static_cast<double>(seen.size()));
    return seen[seen.size() - 1 - at_end] - seen[at_end];
  }

 private:
  double place(int number, int k) const { return low_[k] + (number + 0.5) * step_[k]; }
  int first(double from, int k) const {
    if (!(step_[k] > 0)) return kPlaces;
    return static_cast<int>(
        std::clamp(std::ceil((from - low_[k]) / step_[k] - 0.5), 0.0, static_cast<double>(kPlaces)));
  }

  int axis_, i_, j_;
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero(), step_ = Eigen::Vector3d::Zero();
  std::vector<double> heights_[2];
};

/// A face square to an axis: where it stands along it, its area, and what it takes of the side.
struct SquareFace {
  double height, area;
  Eigen::AlignedBox2d taken;
};

std::vector<SquareFace> square_faces(const std::vector<ItemExtent>& items, int axis) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  std::vector<SquareFace> faces;
  for (const ItemExtent& item : items)
    for (const PointCloud& polygon : item.faces) {
      if (polygon.size() < 3) continue;
      const Eigen::Vector3d normal = normal_of(polygon);
      if (!(std::abs(normal[axis]) > kSquare * normal.norm())) continue;
      SquareFace face{0, 0.5 * std::abs(normal[axis]), {}};
      for (const Eigen::Vector3d& point : polygon) {
        face.height += point[axis] / static_cast<double>(polygon.size());
        face.taken.extend(Eigen::Vector2d(point[i], point[j]));
      }
      faces.push_back(face);
    }
  return faces;
}

/// Of the faces in one plane the outermost that take most of the side, with what stands before them: a rim may reach
/// further out, lugs and screws lie inside of it. `towards`: 1 or -1 along the axis. Empty: no plane does.
Eigen::AlignedBox2d outer_rectangle(std::vector<SquareFace> faces, double towards, double one_plane, double side_area) {
  std::sort(faces.begin(), faces.end(),
            [&](const SquareFace& a, const SquareFace& b) { return towards * a.height > towards * b.height; });
  double area = 0;  // of the faces from `first` to before `end`, which lie in one plane
  for (std::size_t first = 0, end = 0; first < faces.size(); area -= faces[first].area, ++first) {
    for (; end < faces.size() && std::abs(faces[end].height - faces[first].height) <= one_plane; ++end)
      area += faces[end].area;
    if (!(area >= kMostOfSide * side_area)) continue;
    Eigen::AlignedBox2d taken;
    for (std::size_t f = 0; f < end; ++f) taken.extend(faces[f].taken);
    return taken;
  }
  return {};
}

/// Of all faces; empty where an item has none, or one is nowhere.
Eigen::AlignedBox3d box_of(const std::vector<ItemExtent>& items) {
  Eigen::AlignedBox3d box;
  for (const ItemExtent& item : items) {
    if (item.faces.empty()) return {};
    for (const PointCloud& face : item.faces)
      for (const Eigen::Vector3d& point : face) box.extend(point);
  }
  return box.min().allFinite() && box.max().allFinite() ? box : Eigen::AlignedBox3d();
}

std::vector<Sides> sides_of(const std::vector<ItemExtent>& items, double metres) {
  const Eigen::AlignedBox3d box = box_of(items);
  if (box.isEmpty()) return {};
  std::vector<Sides> all;
  for (int axis = 0; axis < 3; ++axis) {
    all.emplace_back(box, axis, kBorder / metres);
    for (const ItemExtent& item : items)
      for (const PointCloud& face : item.faces) all.back().add(face);
  }
  return all;
}

}  // namespace

std::vector<double> sag_of_sides(const std::vector<ItemExtent>& items, double metres) {
  std::vector<double> sag;
  for (const Sides& sides : sides_of(items, metres)) sag.push_back(sides.sag(0)), sag.push_back(sides.sag(1));
  return sag;
}

std::vector<double> filled_sides(const std::vector<ItemExtent>& items, double metres) {
  std::vector<double> filled;
  for (const Sides& sides : sides_of(items, metres))
    filled.push_back(sides.filled(0)), filled.push_back(sides.filled(1));
  return filled;
}

std::vector<double> rectangles_of_sides(const std::vector<ItemExtent>& items, double metres) {
  const Eigen::AlignedBox3d box = box_of(items);
  if (box.isEmpty()) return {};
  std::vector<double> rectangles;
  bool narrower = false;
  for (int axis = 0; axis < 3; ++axis) {
    const double side_area = box.sizes()[(axis + 1) % 3] * box.sizes()[(axis + 2) % 3];
    for (const double towards : {-1.0, 1.0}) {
      const Eigen::AlignedBox2d taken =
          outer_rectangle(square_faces(items, axis), towards, kOnePlane / metres, side_area);
      const double unknown = std::numeric_limits<double>::quiet_NaN();
      const Eigen::Vector2d whole(box.sizes()[(axis + 1) % 3], box.sizes()[(axis + 2) % 3]);
      narrower = narrower || (!taken.isEmpty() && (whole - taken.sizes()).maxCoeff() > kNarrower / metres);
      for (const Eigen::Vector2d& corner : {taken.min(), taken.max()})
        for (int k : {0, 1}) rectangles.push_back(taken.isEmpty() ? unknown : corner[k]);
    }
  }
  return narrower ? rectangles : std::vector<double>();
}

SidesOfShape OuterSides::of(const Entity& element) {
  SidesOfShape sides;
  try {
    const auto shape = element.optional_reference("Representation");
    if (!shape) return {};
    const std::vector<ItemExtent> items = extents_.of_shape(*shape, element.id());
    sides = {sag_of_sides(items, metres_), filled_sides(items, metres_), rectangles_of_sides(items, metres_)};
  } catch (const step::Error&) {  // told where its box is read
    return {};
  }
  for (double& side : sides.sag) side *= metres_;
  for (double& edge : sides.rectangles) edge *= metres_;
  return sides;
}

}  // namespace plumbline::ifc
