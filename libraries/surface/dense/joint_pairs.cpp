#include "surface/dense/joint_pairs.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

namespace plumbline::surface {
namespace {

constexpr double kFacing = 0.05;                // that two faces face each other along, at least [m]
constexpr double kOffset = 0.05;                // by which edges of one joint lie in one plane [m]
constexpr double kOverlap = 0.1;                // a tongue is no wider; what overlaps by more lies before the other [m]
constexpr double kRow = 0.3, kNeighbour = 0.5;  // wider gaps are rather windows; or not neighbours [m]
const double kParallel = std::cos(M_PI / 18);   // of faces with a joint that is measured

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

bool within_reach(const PanelFace& a, const PanelFace& b, double apart) {
  const double reach = half_diagonal(a) + half_diagonal(b) + apart;
  return (a.plane.origin - b.plane.origin).squaredNorm() <= reach * reach;
}

/// Whether a third face lies on the way from the one to the other, so that they are no neighbours. In the way of a
/// joint lies what is flush with its panels; a sheet behind it is none of them.
bool something_between(const std::vector<PanelFace>& faces, size_t a, size_t b, const Eigen::Vector3d& from,
                       const Eigen::Vector3d& to) {
  constexpr double usual = 0.06, flush = 0.01;  // widths of joints; of thin panels in one plane [m]
  const double depth = (to - from).norm() <= usual ? flush : kOffset;
  const Eigen::Vector3d middle = 0.5 * (from + to);
  for (size_t f = 0; f < faces.size(); ++f) {
    if (f == a || f == b) continue;
    const double reach = half_diagonal(faces[f]) + 0.5 * (to - from).norm() + kOffset;
    if ((faces[f].plane.origin - middle).squaredNorm() > reach * reach) continue;
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

/// What keeps parallel neighbours from having a joint; empty where one lies before the other.
std::string why_parallel(const PanelFace& a, const PanelFace& b) {
  const Eigen::Vector3d apart = a.plane.local(b.plane.origin).cwiseAbs();
  const double gap =
      std::max(apart.x() - 0.5 * (a.width + b.width), apart.y() - 0.5 * (a.height + b.height));  // of their outlines
  if (gap < -kOverlap) return {};
  if (apart.z() > kOffset)
    return fmt::format(
        "one of its panels stands {:.0f} mm further out than the other in the design, and such joints "
        "are not measured",
        1e3 * apart.z());
  if (gap < 0)
    return fmt::format(
        "the outlines of its panels overlap by {:.0f} mm in the design (tongue and groove, shiplap, "
        "folded flanges), and where the joint that is seen should be it does not say",
        -1e3 * gap);
  return "its panels do not face each other edge to edge in the design";
}

/// Parallel faces with a gap wider than `widest` and up to `furthest` and nothing in it.
std::vector<PairWithoutJoint> wide_pairs(const std::vector<PanelFace>& faces, double widest, double furthest) {
  std::vector<PairWithoutJoint> pairs;
  for (const Joint& joint : joints_of(faces, furthest, kOffset))
    if (joint.width > widest)
      pairs.push_back({joint.face_a, joint.face_b,
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
  for (size_t i = 0; i < faces.size(); ++i)
    for (size_t j = 0; j < faces.size(); ++j) {
      if (i == j || faces[i].plane.axes.col(2).dot(faces[j].plane.axes.col(2)) < kParallel ||
          !within_reach(faces[i], faces[j], widest + offset))
        continue;
      for (int axis : {0, 1}) {
        auto joint = joint_between(faces[i], faces[j], axis, widest, offset);
        if (!joint) continue;
        const Eigen::Vector3d half = 0.5 * joint->width * joint->plane.axes.col(0);
        if (something_between(faces, i, j, joint->plane.origin - half, joint->plane.origin + half)) continue;
        joint->face_a = i, joint->face_b = j;
        joints.push_back(*joint);
      }
    }
  return joints;
}

std::vector<std::pair<size_t, size_t>> corners_between(const std::vector<PanelFace>& faces, double widest,
                                                       double offset) {
  std::set<std::pair<size_t, size_t>> joined;
  for (const Joint& joint : joints_of(faces, widest, offset)) joined.insert(std::minmax(joint.face_a, joint.face_b));
  std::vector<std::pair<size_t, size_t>> corners;
  for (size_t i = 0; i < faces.size(); ++i)
    for (size_t j = i + 1; j < faces.size(); ++j) {
      if (!within_reach(faces[i], faces[j], widest) || joined.contains({i, j})) continue;
      const Nearest nearest = nearest_edges(faces[i], faces[j]);
      if (nearest.apart <= widest && !something_between(faces, i, j, nearest.on_a, nearest.on_b))
        corners.emplace_back(i, j);
    }
  return corners;
}

std::vector<PairWithoutJoint> pairs_without_joint(const std::vector<PanelFace>& faces, double widest, double furthest) {
  std::vector<PairWithoutJoint> pairs;
  for (const auto& [i, j] : corners_between(faces, widest, kOffset)) {
    const PanelFace &a = faces[i], &b = faces[j];
    const double turn = a.plane.axes.col(2).dot(b.plane.axes.col(2));
    if (turn < std::sqrt(0.5)) continue;
    const std::string why =
        turn > kParallel ? why_parallel(a, b)
                         : "the facade is folded between its panels by more than 10°, and such joints are not measured";
    if (why.empty()) continue;
    const Nearest nearest = nearest_edges(a, b);
    const bool upright = std::abs(nearest.along.dot(a.plane.axes.col(1))) > std::sqrt(0.5);
    pairs.push_back({i, j, why, std::numeric_limits<double>::quiet_NaN(), 0.5 * (nearest.on_a + nearest.on_b),
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
  const auto pairs = pairs_without_joint(faces, widest, kRow);
  if (!pairs.empty())
    words.push_back("the joint between " + named(pairs[0].a, pairs[0].b) + more_of(pairs.size()) +
                    " is not measured: " + pairs[0].why);
  const auto gaps = wide_pairs(faces, std::max(widest, kRow), kNeighbour);
  if (!gaps.empty())
    words.push_back(named(gaps[0].a, gaps[0].b) + more_of(gaps.size()) +
                    fmt::format(" are {:.0f} mm apart in the design, with no panel between: no joint is measured or "
                                "judged there, a window may be",
                                1e3 * gaps[0].width));
  return words;
}

}  // namespace plumbline::surface
