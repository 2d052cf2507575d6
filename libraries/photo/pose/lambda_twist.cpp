#include "photo/pose/lambda_twist.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace plumbline::pose {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The equations between pairs of depths: (0, 1), (0, 2), (1, 2).
struct Pairs {
  std::array<double, 3> squared_distance;  ///< of the points
  std::array<double, 3> cosine;            ///< between the bearings
};
constexpr std::array<std::array<Eigen::Index, 2>, 3> kPairs = {{{0, 1}, {0, 2}, {1, 2}}};

/// λᵀ M λ is the squared distance of the two points at those depths.
Matrix3d form(const Pairs& pairs, std::size_t k) {
  Matrix3d m = Matrix3d::Zero();
  const auto [i, j] = kPairs[k];
  m(i, i) = m(j, j) = 1;
  m(i, j) = m(j, i) = -pairs.cosine[k];
  return m;
}

double mixed(const Matrix3d& a, const Matrix3d& b) {  // sum of det(a) with one column after the other from b
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    Matrix3d m = a;
    m.col(k) = b.col(k);
    sum += m.determinant();
  }
  return sum;
}

/// A real root of x³ + b x² + c x + d, polished by Newton's method.
double root_of_cubic(double b, double c, double d) {
  const double shift = b / 3, p = c - b * b / 3, q = 2 * b * b * b / 27 - b * c / 3 + d;
  const double discriminant = q * q / 4 + p * p * p / 27;
  double x = 0;
  if (discriminant >= 0) {
    const double root = std::sqrt(discriminant), u = std::cbrt(q < 0 ? -q / 2 + root : -q / 2 - root);
    x = u == 0 ? 0 : u - p / (3 * u);
  } else {
    x = 2 * std::sqrt(-p / 3) * std::cos(std::acos(std::clamp(1.5 * q / (p * std::sqrt(-p / 3)), -1.0, 1.0)) / 3);
  }
  x -= shift;
  for (int k = 0; k < 3; ++k) {
    const double slope = (3 * x + 2 * b) * x + c;
    if (slope == 0) break;
    x -= (((x + b) * x + c) * x + d) / slope;
  }
  return x;
}

/// Depths that make the three distances right, from nearly right ones.
Vector3d polished(const Pairs& pairs, Vector3d depths) {
  for (int round = 0; round < 5; ++round) {
    Vector3d misfit;
    Matrix3d slope = Matrix3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [i, j] = kPairs[k];
      const double a = depths(i), b = depths(j), c = pairs.cosine[k];
      misfit(static_cast<Eigen::Index>(k)) = a * a + b * b - 2 * c * a * b - pairs.squared_distance[k];
      slope(static_cast<Eigen::Index>(k), i) = 2 * (a - c * b);
      slope(static_cast<Eigen::Index>(k), j) = 2 * (b - c * a);
    }
    const Vector3d step = slope.partialPivLu().solve(misfit);
    if (!step.allFinite()) break;
    depths -= step;
    if (step.norm() < 1e-14 * depths.norm()) break;
  }
  return depths;
}

/// Depths in the plane normal · λ = 0 that hold both conics.
void depths_in_plane(const Pairs& pairs, const Vector3d& normal, const Matrix3d& conic, std::vector<Vector3d>& found) {
  const Vector3d u = normal.unitOrthogonal(), v = normal.normalized().cross(u);
  // conic of cos t u + sin t v: as a quadratic in the ratio of the larger coefficient.
  const double uu = u.dot(conic * u), uv = u.dot(conic * v), vv = v.dot(conic * v);
  const double square = uv * uv - uu * vv;
  if (square < -1e-9 * (uv * uv + std::abs(uu * vv))) return;
  const double root = std::sqrt(std::max(0.0, square));
  for (const double sign : {-1.0, 1.0}) {
    const double half = -uv + sign * root;
    // uu p² + 2 uv p q + vv q² = 0: (p : q) = (half : uu) = (vv : half of the other sign)
    Vector3d direction = half * u + uu * v;
    if (std::abs(half) + std::abs(uu) < 1e-12 * (std::abs(uu) + std::abs(vv)))
      direction = vv * u + (-uv - sign * root) * v;
    if (direction.sum() < 0) direction = -direction;
    if (!(direction.minCoeff() > 0)) continue;
    std::size_t longest = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (pairs.squared_distance[k] > pairs.squared_distance[longest]) longest = k;
    const double length = direction.dot(form(pairs, longest) * direction);
    if (!(length > 0)) continue;
    found.push_back(polished(pairs, direction * std::sqrt(pairs.squared_distance[longest] / length)));
  }
}

}  // namespace

PoseHypotheses lambda_twist(const std::array<Vector3d, 3>& points, const std::array<Vector3d, 3>& bearings) {
  const Vector3d d01 = points[0] - points[1], d02 = points[0] - points[2], across = d01.cross(d02);
  if (!(across.norm() > 1e-9 * d01.norm() * d02.norm())) return {};
  const Pairs pairs{{d01.squaredNorm(), d02.squaredNorm(), (points[1] - points[2]).squaredNorm()},
                    {bearings[0].dot(bearings[1]), bearings[0].dot(bearings[2]), bearings[1].dot(bearings[2])}};
  const auto& a = pairs.squared_distance;
  const Matrix3d first = a[2] * form(pairs, 0) - a[0] * form(pairs, 2),
                 second = a[2] * form(pairs, 1) - a[1] * form(pairs, 2);
  const double cubed = second.determinant();
  if (cubed == 0) return {};
  const double root =
      root_of_cubic(mixed(second, first) / cubed, mixed(first, second) / cubed, first.determinant() / cubed);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(first + root * second);
  // One eigenvalue is zero, the others have opposite signs: the conic is a pair of planes.
  const double low = eigen.eigenvalues()(0), high = eigen.eigenvalues()(2);
  if (!(low < 0 && high > 0)) return {};
  std::vector<Vector3d> depths;
  for (const double sign : {-1.0, 1.0})
    depths_in_plane(
        pairs, std::sqrt(high) * eigen.eigenvectors().col(2) + sign * std::sqrt(-low) * eigen.eigenvectors().col(0),
        second, depths);
  Matrix3d of_points;
  of_points << d01, d02, across;
  const Matrix3d inverse = of_points.inverse();
  PoseHypotheses poses;
  for (const Vector3d& depth : depths) {
    if (!depth.allFinite() || !(depth.minCoeff() > 0)) continue;
    const Vector3d p0 = depth(0) * bearings[0], c01 = p0 - depth(1) * bearings[1], c02 = p0 - depth(2) * bearings[2];
    Matrix3d in_camera;
    in_camera << c01, c02, c01.cross(c02);
    const Eigen::Quaterniond rotation = Eigen::Quaterniond(Matrix3d(in_camera * inverse)).normalized();
    poses.push_back({rotation, p0 - rotation * points[0]});
  }
  return poses;
}

PoseHypotheses lambda_twist_of_tags(const std::vector<const TagView*>& sample) {
  PoseHypotheses poses;
  for (const std::size_t first : {0, 2}) {
    std::array<Vector3d, 3> points, bearings;
    for (std::size_t k = 0; k < 3; ++k) {
      const TagView& tag = *sample[k % sample.size()];
      const std::size_t corner = (first + k) % 4;
      points[k] = tag.corner_in_world(static_cast<int>(corner));
      bearings[k] = tag.bearings[corner];
    }
    const PoseHypotheses found = lambda_twist(points, bearings);
    poses.insert(poses.end(), found.begin(), found.end());
  }
  return poses;
}

}  // namespace plumbline::pose
