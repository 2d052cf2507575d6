// Approximate values: tags are placed from the images that see them and images from the tags they show. A single view
// of a square has two poses that fit nearly as well, so both stay candidates, and what decides is the sum over all
// images that see the tag.
#include <algorithm>
#include <cmath>
#include <limits>

#include "photo/markers/marker_model.hpp"

namespace plumbline::markers {
namespace {

constexpr size_t max_candidates = 24;  // views a candidate is taken from; more decide nothing new

class Placement {
 public:
  Placement(const MarkerBlock& block, const std::vector<BrownCamera>& cameras, const std::vector<bool>& use)
      : block_(block) {
    result.cameras = cameras;
    result.cam_from_world.resize(block.images.size());
    result.world_from_tag.resize(block.markers.size());
    views_of_image_.resize(block.images.size()), views_of_marker_.resize(block.markers.size());
    poses_.resize(block.views.size()), corners_.resize(block.views.size());
    for (size_t v = 0; v < block.views.size(); ++v) {
      if (!use[v] || !normalise(v)) continue;
      const MarkerView& view = block.views[v];
      poses_[v] = poses_of_square(corners_[v], block.markers[view.marker].size);
      if (poses_[v].empty()) continue;
      views_of_image_[view.image].push_back(v);
      views_of_marker_[view.marker].push_back(v);
    }
  }

  void run() {
    bool layout = false;
    for (size_t m = 0; m < block_.markers.size(); ++m)
      if (block_.markers[m].world_from_tag) result.world_from_tag[m] = block_.markers[m].world_from_tag, layout = true;
    fixed_ = result.world_from_tag;
    if (layout) {
      grow();
      improve();
    } else {
      grow_from_best_root();
    }
    result.cost = total_cost();
  }

  void run_from(const MarkerStart& from) {
    result.cam_from_world = from.cam_from_world, result.world_from_tag = from.world_from_tag;
    fixed_.resize(block_.markers.size());
    grow();
    improve();
    result.cost = total_cost();
  }

  MarkerStart result;

 private:
  const BrownCamera& camera_of(size_t image) const { return result.cameras[block_.images[image].camera]; }
  size_t image_of(size_t view) const { return static_cast<size_t>(block_.views[view].image); }
  size_t marker_of(size_t view) const { return static_cast<size_t>(block_.views[view].marker); }

  bool normalise(size_t v) {
    const BrownCamera& camera = camera_of(image_of(v));
    for (size_t i = 0; i < 4; ++i) {
      const auto q = unproject(camera, block_.views[v].corners[i]);
      if (!q) return false;
      corners_[v][i] = *q;
    }
    return true;
  }

  /// Bounded cost of a view, 0 … 1: half where the mean distance of the corners is one per cent of the image.
  double cost(size_t view, const RigidTransform& cam_from_world, const RigidTransform& world_from_tag) const {
    const BrownCamera& camera = camera_of(image_of(view));
    const double h = 0.5 * block_.markers[marker_of(view)].size, unit = 0.01 * std::max(camera.width, camera.height);
    const RigidTransform cam_from_tag = cam_from_world * world_from_tag;
    double squares = 0;
    for (size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d p = cam_from_tag * Eigen::Vector3d(i == 1 || i == 2 ? h : -h, i >= 2 ? h : -h, 0);
      if (!(p.z() > 1e-9)) return 1;
      squares += 0.25 * camera.fx * camera.fx * (p.hnormalized() - corners_[view][i]).squaredNorm();
    }
    const double e = squares / (unit * unit);
    return e / (1 + e);
  }

  double image_cost(size_t image, const RigidTransform& pose) const {
    double sum = 0;
    for (const size_t v : views_of_image_[image])
      if (const auto& tag = result.world_from_tag[marker_of(v)]) sum += cost(v, pose, *tag);
    return sum;
  }
  double marker_cost(size_t marker, const RigidTransform& pose) const {
    double sum = 0;
    for (const size_t v : views_of_marker_[marker])
      if (const auto& image = result.cam_from_world[image_of(v)]) sum += cost(v, *image, pose);
    return sum;
  }

  double total_cost() {
    double sum = 0;
    size_t all = 0;
    result.placed = 0;
    for (size_t v = 0; v < block_.views.size(); ++v) {
      if (poses_[v].empty()) continue;
      ++all;
      const auto& image = result.cam_from_world[image_of(v)];
      const auto& tag = result.world_from_tag[marker_of(v)];
      if (image && tag) ++result.placed;
      sum += image && tag ? cost(v, *image, *tag) : 1.0;
    }
    return all ? sum / static_cast<double>(all) : 1.0;
  }

  /// The pose of an image on all its placed tags, outliers weighted down.
  RigidTransform refined(size_t image, const RigidTransform& start) const {
    std::vector<Eigen::Vector3d> figure;
    std::vector<Eigen::Vector2d> seen;
    std::vector<double> weights;
    for (const size_t v : views_of_image_[image]) {
      const auto& tag = result.world_from_tag[marker_of(v)];
      if (!tag) continue;
      const double h = 0.5 * block_.markers[marker_of(v)].size, c = cost(v, start, *tag);
      for (size_t i = 0; i < 4; ++i) {
        figure.push_back(*tag * Eigen::Vector3d(i == 1 || i == 2 ? h : -h, i >= 2 ? h : -h, 0));
        seen.push_back(corners_[v][i]);
        weights.push_back((1 - c) * (1 - c));
      }
    }
    return figure.empty() ? start : refine_pose(start, figure, seen, weights).cam_from_figure;
  }

  void place_image(size_t image) {
    std::optional<RigidTransform> best = result.cam_from_world[image];
    double lowest = best ? image_cost(image, *best) : std::numeric_limits<double>::infinity();
    size_t tried = 0;
    for (const size_t v : views_of_image_[image]) {
      const auto& tag = result.world_from_tag[marker_of(v)];
      if (!tag || ++tried > max_candidates) continue;
      for (const FittedPose& pose : poses_[v]) {
        const RigidTransform candidate = pose.cam_from_figure * tag->inverse();
        const double c = image_cost(image, candidate);
        if (c < lowest) best = candidate, lowest = c;
      }
    }
    if (!best) return;
    for (int pass = 0; pass < 2; ++pass) {
      const RigidTransform next = refined(image, *best);
      const double c = image_cost(image, next);
      if (c < lowest) best = next, lowest = c;
    }
    result.cam_from_world[image] = best;
  }

  void place_marker(size_t marker) {
    if (fixed_[marker]) return;
    std::optional<RigidTransform> best = result.world_from_tag[marker];
    double lowest = best ? marker_cost(marker, *best) : std::numeric_limits<double>::infinity();
    size_t tried = 0;
    for (const size_t v : views_of_marker_[marker]) {
      const auto& image = result.cam_from_world[image_of(v)];
      if (!image || ++tried > max_candidates) continue;
      for (const FittedPose& pose : poses_[v]) {
        const RigidTransform candidate = image->inverse() * pose.cam_from_figure;
        const double c = marker_cost(marker, candidate);
        if (c < lowest) best = candidate, lowest = c;
      }
    }
    result.world_from_tag[marker] = best;
  }

  /// The image with the most placed tags next, then the tags that it adds.
  void grow() {
    for (;;) {
      size_t next = block_.images.size(), most = 0;
      for (size_t i = 0; i < block_.images.size(); ++i) {
        if (result.cam_from_world[i]) continue;
        size_t count = 0;
        for (const size_t v : views_of_image_[i]) count += result.world_from_tag[marker_of(v)].has_value();
        if (count > most) most = count, next = i;
      }
      if (next == block_.images.size()) return;
      place_image(next);
      for (const size_t v : views_of_image_[next]) place_marker(marker_of(v));
    }
  }

  void improve() {
    for (int round = 0; round < 3; ++round) {
      for (size_t m = 0; m < block_.markers.size(); ++m)
        if (result.world_from_tag[m]) place_marker(m);
      for (size_t i = 0; i < block_.images.size(); ++i)
        if (result.cam_from_world[i]) place_image(i);
    }
  }

  /// Images that are connected over tags, as a number for each image.
  std::vector<int> components() const {
    std::vector<int> component(block_.images.size(), -1);
    for (size_t start = 0, count = 0; start < component.size(); ++start) {
      if (component[start] >= 0 || views_of_image_[start].empty()) continue;
      std::vector<size_t> open{start};
      component[start] = static_cast<int>(count);
      while (!open.empty()) {
        const size_t image = open.back();
        open.pop_back();
        for (const size_t v : views_of_image_[image])
          for (const size_t w : views_of_marker_[marker_of(v)])
            if (component[image_of(w)] < 0)
              component[image_of(w)] = static_cast<int>(count), open.push_back(image_of(w));
      }
      ++count;
    }
    return component;
  }

  /// From the image with the most tags of the largest component; both poses of its best seen tag are tried.
  void grow_from_best_root() {
    const std::vector<int> component = components();
    std::vector<size_t> size(component.size() + 1, 0);
    for (size_t i = 0; i < component.size(); ++i)
      if (component[i] >= 0) size[component[i]] += views_of_image_[i].size();
    const int largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
    size_t root = block_.images.size(), best_links = 0;
    for (size_t i = 0; i < component.size(); ++i) {
      if (component[i] != largest) continue;
      size_t links = 0;
      for (const size_t v : views_of_image_[i]) links += views_of_marker_[marker_of(v)].size();
      if (links > best_links) best_links = links, root = i;
    }
    if (root == block_.images.size()) return;
    size_t view = views_of_image_[root].front();
    for (const size_t v : views_of_image_[root])
      if (views_of_marker_[marker_of(v)].size() > views_of_marker_[marker_of(view)].size()) view = v;
    const MarkerStart empty = result;
    MarkerStart best;
    double lowest = std::numeric_limits<double>::infinity();
    for (const FittedPose& pose : poses_[view]) {
      result = empty;
      result.world_from_tag[marker_of(view)] = RigidTransform{};
      result.cam_from_world[root] = pose.cam_from_figure;
      for (const size_t v : views_of_image_[root]) place_marker(marker_of(v));
      grow();
      improve();
      const double c = total_cost();
      if (c < lowest) lowest = c, best = result;
    }
    result = best;
  }

  const MarkerBlock& block_;
  std::vector<std::vector<size_t>> views_of_image_, views_of_marker_;
  std::vector<std::array<Eigen::Vector2d, 4>> corners_;
  std::vector<std::vector<FittedPose>> poses_;  // both poses of every view, better first; empty if it has none
  std::vector<std::optional<RigidTransform>> fixed_;
};

}  // namespace

bool has_layout(const MarkerBlock& block) {
  return std::any_of(block.markers.begin(), block.markers.end(), [](const Marker& m) { return m.world_from_tag; });
}

MarkerStart start_marker_block(const MarkerBlock& block, const std::vector<BrownCamera>& cameras,
                               const std::vector<bool>& use) {
  Placement placement(block, cameras, use);
  placement.run();
  return placement.result;
}

MarkerStart improve_start(const MarkerBlock& block, const MarkerStart& from, const std::vector<bool>& use) {
  Placement placement(block, from.cameras, use);
  placement.run_from(from);
  return placement.result;
}

std::vector<FittedPose> poses_of_view(const MarkerBlock& block, const MarkerView& view, const BrownCamera& camera) {
  std::array<Eigen::Vector2d, 4> corners;
  for (size_t i = 0; i < 4; ++i) {
    const auto q = unproject(camera, view.corners[i]);
    if (!q) return {};
    corners[i] = *q;
  }
  return poses_of_square(corners, block.markers[view.marker].size);
}

double focal_length_from_tags(const MarkerBlock& block, int camera) {
  // With ω = diag(w, w, 1), w = 1/f²: h1ᵀωh2 = 0 and h1ᵀωh1 = h2ᵀωh2 give a w + b = 0 for every view.
  double ab = 0, aa = 0;
  for (const MarkerView& view : block.views) {
    const int c = block.images[view.image].camera;
    if (c != camera) continue;
    const BrownCamera& brown = block.cameras[c].camera;
    const double unit = std::max(brown.width, brown.height);
    std::vector<Eigen::Vector2d> image;
    for (const auto& corner : view.corners)
      image.emplace_back((corner.x() - 0.5 * brown.width) / unit, (corner.y() - 0.5 * brown.height) / unit);
    const Eigen::Matrix3d h = plane_homography({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}, image);
    const Eigen::Vector3d h1 = h.col(0), h2 = h.col(1);
    const double scale = h1.head<2>().squaredNorm() + h2.head<2>().squaredNorm();
    const double a1 = h1.head<2>().dot(h2.head<2>()) / scale, b1 = h1.z() * h2.z() / scale,
                 a2 = (h1.head<2>().squaredNorm() - h2.head<2>().squaredNorm()) / scale,
                 b2 = (h1.z() * h1.z() - h2.z() * h2.z()) / scale;
    // The noise is in the perspective terms b: least squares of a w + b over all views.
    ab += a1 * b1 + a2 * b2, aa += a1 * a1 + a2 * a2;
  }
  const double w = -ab / aa;
  const BrownCamera& brown = block.cameras[camera].camera;
  return w > 0 && std::isfinite(w) ? std::max(brown.width, brown.height) / std::sqrt(w) : std::nan("");
}

}  // namespace plumbline::markers
