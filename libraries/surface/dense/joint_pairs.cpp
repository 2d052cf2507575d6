#include "surface/dense/joint_pairs.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace plumbline::surface {
namespace {

constexpr double kFacing = 0.05;  // that two faces face each other along, at least [m]
constexpr double kOffset = 0.05;  // by which edges of one joint lie in one plane [m]
constexpr double kOverlap = 0.1;  // a tongue is no wider; what overlaps by more lies before the other [m]
constexpr double kRow = 0.15, kNeighbour = 0.5;  // wider gaps are rather no joints; or not neighbours [m]
const double kParallel = std::cos(M_PI / 18);    // of faces with a joint that is measured

struct Edge {
  Eigen::Vector3d from, along;  ///< along: unit vector
  double length;
};

std::array<Edge, 4> edges_of(const PanelFace& face) {
  const Eigen::Vector3d right = face.plane.axes.col(0), up = face.plane.axes.col(1);
  const Eigen::Vector3d low = face.plane.origin - 0.5 * (face.width * right + face.height * up);
  return {Edge{low, right, face.width}, Edge{low + face.height * up, right, face.width}, Edge{low, up, face.height},
          Edge{low + face.width * right, up, face.height}};
}

/// The shortest way between the edges that two faces turn to each other.
struct Nearest {
  Eigen::Vector3d on_a, on_b, along;
  double apart = std::numeric_limits<double>::infinity();
};

void take_if_nearer(const Edge& a, const Edge& b, Nearest& nearest) {
  const double cosine = a.along.dot(b.along);
  if (std::abs(cosine) < kParallel) return;
  const Eigen::Vector3d middle = b.from + 0.5 * b.length * b.along - a.from;
  const double at = middle.dot(a.along), half = 0.5 * b.length * std::abs(cosine);
  const double low = std::max(0.0, at - half), high = std::min(a.length, at + half);
  const double apart = (middle - at * a.along).norm();
  if (high - low < kFacing || apart >= nearest.apart) return;
  nearest.apart = apart, nearest.along = a.along;
  nearest.on_a = a.from + 0.5 * (low + high) * a.along;
  nearest.on_b = nearest.on_a + middle - at * a.along;
}

Nearest nearest_edges(const PanelFace& a, const PanelFace& b) {
  Nearest nearest;
  for (const Edge& of_a : edges_of(a))
    for (const Edge& of_b : edges_of(b)) take_if_nearer(of_a, of_b, nearest);
  return nearest;
}

double half_diagonal(const PanelFace& face) { return 0.5 * std::hypot(face.width, face.height); }

/// Which faces come near to each other, found by a grid over their origins: facades of 10 000 panels have 10⁸ pairs.
class Neighbours {
 public:
  /// `apart`: of faces that are neighbours, at most [m].
  Neighbours(const std::vector<PanelFace>& faces, double apart) : faces_(faces), apart_(apart) {
    for (const PanelFace& face : faces) radius_.push_back(half_diagonal(face));
    for (const double radius : radius_) largest_ = std::max(largest_, radius);
    for (size_t f = 0; f < faces.size(); ++f) cells_[cell_of(faces[f].plane.origin)].push_back(f);
  }

  /// Of face `of` the others whose circles come within `apart` of its own, in order.
  std::vector<size_t> near(size_t of) const {
    const double side = edge();
    const auto [x, y, z] = cell_of(faces_[of].plane.origin);
    const auto cells = static_cast<int64_t>(std::ceil((radius_[of] + largest_ + apart_) / side));
    std::vector<size_t> found;
    for (int64_t i = x - cells; i <= x + cells; ++i)
      for (int64_t j = y - cells; j <= y + cells; ++j)
        for (int64_t k = z - cells; k <= z + cells; ++k)
          if (const auto cell = cells_.find({i, j, k}); cell != cells_.end())
            for (const size_t f : cell->second)
              if (f != of && reaches(of, f)) found.push_back(f);
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  using Cell = std::array<int64_t, 3>;
  double edge() const { return 2 * largest_ + apart_ + 1e-3; }
  Cell cell_of(const Eigen::Vector3d& place) const {
    Cell cell{};
    for (int k : {0, 1, 2}) cell[k] = static_cast<int64_t>(std::floor(place[k] / edge()));
    return cell;
  }
  bool reaches(size_t a, size_t b) const {
    const double reach = radius_[a] + radius_[b] + apart_;
    return (faces_[a].plane.origin - faces_[b].plane.origin).squaredNorm() <= reach * reach;
  }

  const std::vector<PanelFace>& faces_;
  double apart_, largest_ = 0;
  std::vector<double> radius_;
  std::map<Cell, std::vector<size_t>> cells_;
};

/// Whether a third face lies on the way from face a to b, so that they are no neighbours. In the way of a joint lies
/// what is flush with its panels; a sheet behind it is none of them. `near`: the faces around a.
bool something_between(const std::vector<PanelFace>& faces, const std::vector<size_t>& near, size_t b,
                       const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  constexpr double usual = 0.06, flush = 0.01;  // widths of joints; of thin panels in one plane [m]
  const double depth = (to - from).norm() <= usual ? flush : kOffset;
  for (const size_t f : near) {
    if (f == b) continue;
    for (const double part : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      const Eigen::Vector3d at = faces[f].plane.local(from + part * (to - from));
      if (std::abs(at.x()) < 0.5 * faces[f].width && std::abs(at.y()) < 0.5 * faces[f].height &&
          std::abs(at.z()) <= depth)
        return true;
    }
  }
  return false;
}

/// The joint where `b` follows `a` along axis 0 (right) or 1 (up) of `a`, if it does.
std::optional<Joint> joint_between(const PanelFace& a, const PanelFace& b, int axis, double widest, double offset) {
  const auto half = [](const PanelFace& face, int of) { return 0.5 * (of == 0 ? face.width : face.height); };
  const int other = 1 - axis;
  const Eigen::Vector3d apart = a.plane.local(b.plane.origin);
  // Of the edges that face each other: panels at an angle stand out of each other's planes elsewhere.
  const Eigen::Vector3d edge_b = a.plane.local(b.plane.origin - half(b, axis) * b.plane.axes.col(axis));
  const double gap = edge_b(axis) - half(a, axis);  // only where b lies at the positive side, so each once
  if (apart(axis) < 0 || gap < -0.002 || gap > widest || std::abs(edge_b.z()) > offset) return std::nullopt;
  const double low = std::max(-half(a, other), apart(other) - half(b, other)),
               high = std::min(half(a, other), apart(other) + half(b, other));
  if (high - low < kFacing) return std::nullopt;
  Eigen::Vector3d on_a, on_b = edge_b;
  on_a(axis) = half(a, axis), on_a(other) = on_b(other) = 0.5 * (low + high), on_a.z() = 0;
  Joint joint;
  joint.a = a.id, joint.b = b.id, joint.length = high - low, joint.upright = axis == 0;
  joint.plane.origin = a.plane.world(0.5 * (on_a + on_b));
  const Eigen::Vector3d out = (a.plane.axes.col(2) + b.plane.axes.col(2)).normalized();
  Eigen::Vector3d right = a.plane.axes.col(axis) + b.plane.axes.col(axis);
  right = (right - right.dot(out) * out).normalized();
  // A joint that runs across: its right is the facade's up, so its up is the facade's left.
  joint.plane.axes << right, out.cross(right), out;
  const Eigen::Vector3d way = joint.plane.axes.transpose() * (a.plane.axes * (on_b - on_a));
  joint.width = way.x(), joint.step = way.z();
  return joint;
}

using Why = std::pair<WhyNoJoint, std::string>;

/// What keeps parallel neighbours from having a joint; without words where one lies before the other.
Why why_parallel(const PanelFace& a, const PanelFace& b) {
  const Eigen::Vector3d apart = a.plane.local(b.plane.origin).cwiseAbs();
  const double gap =
      std::max(apart.x() - 0.5 * (a.width + b.width), apart.y() - 0.5 * (a.height + b.height));  // of their outlines
  if (gap < -kOverlap) return {};
  if (apart.z() > kOffset)
    return {WhyNoJoint::stands_out,
            fmt::format("one of its panels stands {:.0f} mm further out than the other in the design, and such joints "
                        "are not measured",
                        1e3 * apart.z())};
  if (gap < 0)
    return {WhyNoJoint::overlap,
            fmt::format("the outlines of its panels overlap by {:.0f} mm in the design (tongue and groove, shiplap, "
                        "folded flanges), and where the joint that is seen should be it does not say",
                        -1e3 * gap)};
  return {WhyNoJoint::not_facing, "its panels do not face each other edge to edge in the design"};
}

/// Parallel faces with a gap wider than `widest` and up to `furthest` and nothing in it.
std::vector<PairWithoutJoint> wide_pairs(const std::vector<PanelFace>& faces, double widest, double furthest) {
  std::vector<PairWithoutJoint> pairs;
  for (const Joint& joint : joints_of(faces, furthest, kOffset))
    if (joint.width > widest)
      pairs.push_back({joint.face_a, joint.face_b, WhyNoJoint::wide,
                       fmt::format("its designed width of {:.0f} mm is above 'widest' ({:.0f} mm): joints as wide are "
                                   "not measured, unless 'widest' is set above it",
                                   1e3 * joint.width, 1e3 * widest),
                       joint.width, joint.plane.origin, joint.plane.axes.col(1), joint.upright});
  return pairs;
}

std::string more_of(size_t count) {
  return count > 1 ? fmt::format(" (and {} more such pair{})", count - 1, count > 2 ? "s" : "") : "";
}

}  // namespace

std::vector<Joint> joints_of(const std::vector<PanelFace>& faces, double widest, double offset) {
  std::vector<Joint> joints;
  const Neighbours neighbours(faces, widest + offset + kOffset);  // what lies between two may stand off by kOffset
  for (size_t i = 0; i < faces.size(); ++i) {
    const std::vector<size_t> near = neighbours.near(i);
    for (const size_t j : near) {
      if (faces[i].plane.axes.col(2).dot(faces[j].plane.axes.col(2)) < kParallel) continue;
      for (int axis : {0, 1}) {
        auto joint = joint_between(faces[i], faces[j], axis, widest, offset);
        if (!joint) continue;
        const Eigen::Vector3d half = 0.5 * joint->width * joint->plane.axes.col(0);
        if (something_between(faces, near, j, joint->plane.origin - half, joint->plane.origin + half)) continue;
        joint->face_a = i, joint->face_b = j;
        joints.push_back(*joint);
      }
    }
  }
  return joints;
}

std::vector<std::pair<size_t, size_t>> corners_between(const std::vector<PanelFace>& faces, double widest,
                                                       double offset) {
  std::set<std::pair<size_t, size_t>> joined;
  for (const Joint& joint : joints_of(faces, widest, offset)) joined.insert(std::minmax(joint.face_a, joint.face_b));
  std::vector<std::pair<size_t, size_t>> corners;
  const Neighbours neighbours(faces, widest + kOffset);
  for (size_t i = 0; i < faces.size(); ++i) {
    const std::vector<size_t> near = neighbours.near(i);
    for (const size_t j : near) {
      if (j < i || joined.contains({i, j})) continue;
      const Nearest nearest = nearest_edges(faces[i], faces[j]);
      if (nearest.apart <= widest && !something_between(faces, near, j, nearest.on_a, nearest.on_b))
        corners.emplace_back(i, j);
    }
  }
  return corners;
}

std::vector<PairWithoutJoint> pairs_without_joint(const std::vector<PanelFace>& faces, double widest, double furthest) {
  std::vector<PairWithoutJoint> pairs;
  for (const auto& [i, j] : corners_between(faces, widest, kOffset)) {
    const PanelFace &a = faces[i], &b = faces[j];
    const double turn = a.plane.axes.col(2).dot(b.plane.axes.col(2));
    if (turn < std::sqrt(0.5)) continue;
    const auto [kind, why] =
        turn > kParallel
            ? why_parallel(a, b)
            : Why{WhyNoJoint::folded,
                  "the facade is folded between its panels by more than 10°, and such joints are not measured"};
    if (why.empty()) continue;
    const Nearest nearest = nearest_edges(a, b);
    const bool upright = std::abs(nearest.along.dot(a.plane.axes.col(1))) > std::sqrt(0.5);
    pairs.push_back({i, j, kind, why, std::numeric_limits<double>::quiet_NaN(), 0.5 * (nearest.on_a + nearest.on_b),
                     nearest.along, upright});
  }
  for (PairWithoutJoint& pair : wide_pairs(faces, widest, furthest)) pairs.push_back(std::move(pair));
  return pairs;
}

std::vector<std::string> words_of_pairs(const std::vector<PanelFace>& faces, double widest) {
  std::vector<std::string> words;
  const auto named = [&](size_t a, size_t b) { return "panels " + faces[a].id + " and " + faces[b].id; };
  auto corners = corners_between(faces, widest, kOffset);
  std::erase_if(corners, [&](const auto& pair) {
    return faces[pair.first].plane.axes.col(2).dot(faces[pair.second].plane.axes.col(2)) >= std::sqrt(0.5);
  });
  if (!corners.empty())
    words.push_back(named(corners[0].first, corners[0].second) + more_of(corners.size()) +
                    " meet at a corner of the building: no joint is measured or judged between them");
  std::map<WhyNoJoint, std::vector<PairWithoutJoint>> of_kind;
  for (const PairWithoutJoint& pair : pairs_without_joint(faces, widest, kRow)) of_kind[pair.kind].push_back(pair);
  for (const auto& [kind, pairs] : of_kind)
    words.push_back("the joint between " + named(pairs[0].a, pairs[0].b) + more_of(pairs.size()) +
                    " is not measured: " + pairs[0].why);
  const auto gaps = wide_pairs(faces, std::max(widest, kRow), kNeighbour);
  if (!gaps.empty())
    words.push_back(
        named(gaps[0].a, gaps[0].b) + more_of(gaps.size()) +
        fmt::format(
            " are {:.0f} mm apart in the design, with no panel between that was looked at: no joint is measured or "
            "judged there, a window or a pilaster may be",
            1e3 * gaps[0].width));
  return words;
}

}  // namespace plumbline::surface
