#include "detect/corner_refinement.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "images/grey_image.hpp"

namespace plumbline::detect {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Height of point `p` over the line through a and b [px].
double height_over(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return std::abs(cross(b - a, p - a)) / (b - a).norm();
}

/// Strip of the edge from corner i to the next: as wide as the cell beside it is for certain.
EdgeStrip strip_of(const std::array<Eigen::Vector2d, 4>& corner, int i, int modules) {
  const auto &previous = corner[(i + 3) % 4], &start = corner[i], &end = corner[(i + 1) % 4],
             &next = corner[(i + 2) % 4];
  const double cell = std::min(height_over(previous, start, end), height_over(next, start, end)) / modules;
  const double length = (end - start).norm();
  // The next cell's edge blurs a pixel and a half into this one; below three pixels a cell nothing is plain any more.
  const double reach = std::clamp(cell - 1.0, 1.6, 8.0);
  return {start, end, std::clamp(0.12 * length, 3.0, 10.0), reach};
}

struct EdgeValue {
  double value;              // 0 on the edge [px]
  Eigen::RowVector2d slope;  // its gradient
  double variance;           // of the value [px²]
};

EdgeValue evaluate(const FittedEdge& edge, const Eigen::Vector2d& point) {
  const Eigen::Vector2d offset = point - edge.centre;
  const double t = offset.dot(edge.along) / edge.half_length;
  const Eigen::Vector3d powers(1, t, t * t);
  const double inclination = (edge.shape[1] + 2 * edge.shape[2] * t) / edge.half_length;
  return {offset.dot(edge.across) - edge.shape.dot(powers),
          edge.across.transpose() - inclination * edge.along.transpose(), powers.dot(edge.covariance * powers)};
}

/// Newton's method from `start`; false for edges that are nearly parallel.
bool intersect(const FittedEdge& first, const FittedEdge& second, Eigen::Vector2d& point, Eigen::Matrix2d& covariance) {
  for (int iteration = 0; iteration < 10; ++iteration) {
    const EdgeValue a = evaluate(first, point), b = evaluate(second, point);
    Eigen::Matrix2d slopes;
    slopes << a.slope, b.slope;
    if (!(std::abs(slopes.determinant()) > 0.1)) return false;
    const Eigen::Matrix2d inverse = slopes.inverse();
    const Eigen::Vector2d step = -inverse * Eigen::Vector2d(a.value, b.value);
    point += step;
    covariance = inverse * Eigen::Vector2d(a.variance, b.variance).asDiagonal() * inverse.transpose();
    if (step.norm() < 1e-9) return true;
  }
  return false;
}

}  // namespace

std::optional<RefinedCorners> refine_corners(const GreyImage& image, const std::array<Eigen::Vector2d, 4>& initial,
                                             int modules, const EdgeFitOptions& options) {
  std::array<std::optional<FittedEdge>, 4> edges;  // edge i goes from corner i to corner i + 1
  for (int i = 0; i < 4; ++i) {
    edges[i] = fit_edge(image, strip_of(initial, i, modules), options);
    if (!edges[i]) return std::nullopt;
  }
  RefinedCorners refined{initial, {}};
  for (int i = 0; i < 4; ++i)
    if (!intersect(*edges[(i + 3) % 4], *edges[i], refined.corners[i], refined.covariances[i])) return std::nullopt;
  return refined;
}

}  // namespace plumbline::detect
