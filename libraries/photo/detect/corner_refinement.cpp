#include "photo/detect/corner_refinement.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "photo/detect/curve_estimate.hpp"
#include "photo/images/grey_image.hpp"

namespace plumbline::detect {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Height of point `p` over the line through a and b [px].
double height_over(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return std::abs(cross(b - a, p - a)) / (b - a).norm();
}

}  // namespace

EdgeStrip strip_of(const Quadrilateral& q, int i) {
  const std::array<Eigen::Vector2d, 4>& corner = q.corners;
  const auto &previous = corner[(i + 3) % 4], &start = corner[i], &end = corner[(i + 1) % 4],
             &next = corner[(i + 2) % 4];
  const double cell = std::min(height_over(previous, start, end), height_over(next, start, end)) / q.modules;
  const double length = (end - start).norm();
  return {start, end, std::clamp(0.12 * length, 3.0, 10.0), q.border * cell};
}

namespace {

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

using Edges = std::array<std::optional<FittedEdge>, 4>;  // edge i goes from corner i to corner i + 1

/// `grid`: what the edges say of it is added; null: is not asked for.
Edges fit_edges(const Quadrilateral& q, EdgeFitter& fitter, SamplingGridEstimate* grid) {
  Edges edges;
  fitter.set_origin(q.origin);
  for (int i = 0; i < 4; ++i) {
    if (!(edges[i] = fitter.fit(*q.part, strip_of(q, i)))) break;
    if (grid) fitter.add_to(*grid);
  }
  return edges;
}

/// All edges, fitted with the grid of `options`. Of every `stride` quadrilaterals one says what it makes of it; null:
/// none is asked.
std::vector<Edges> fit_all(const std::vector<Quadrilateral>& found, const EdgeFitOptions& options, std::size_t stride,
                           SamplingGridEstimate* estimate) {
  EdgeFitter fitter(options);
  std::vector<Edges> edges;
  for (std::size_t k = 0; k < found.size(); ++k)
    edges.push_back(fit_edges(found[k], fitter, k % stride == 0 ? estimate : nullptr));
  return edges;
}

/// Where the image's pixels lie. `even`: what the edges say that were fitted with an even grid.
SamplingGrid estimate_grid(const std::vector<Quadrilateral>& chosen, EdgeFitOptions options,
                           const SamplingGridEstimate& even) {
  constexpr int kRounds = 4;
  constexpr double kLeast = 0.065;  // by which the variance has to fall for an uneven grid, relative
  SamplingGrid grid;
  SamplingGridEstimate estimate = even;
  double lowest = even.cost() - kLeast;
  for (int round = 0; round < kRounds; ++round) {
    bool better = false;
    for (const SamplingGrid& trial : estimate.better()) {
      options.grid = trial;
      SamplingGridEstimate fitted(trial);
      fit_all(chosen, options, 1, &fitted);
      if (!(fitted.cost() < lowest)) continue;
      lowest = fitted.cost(), grid = trial, estimate = fitted, better = true;
    }
    if (!better) break;
  }
  return grid;
}

/// All edges; the grid is estimated where options.grid is nothing, and put there.
std::vector<Edges> fit_image(const std::vector<Quadrilateral>& found, EdgeFitOptions& options) {
  constexpr std::size_t kEnough = 40;  // quadrilaterals that tell the grid
  if (options.grid) return fit_all(found, options, 1, nullptr);
  options.grid = SamplingGrid{};
  const std::size_t stride = std::max<std::size_t>(1, (found.size() + kEnough - 1) / kEnough);
  SamplingGridEstimate estimate(*options.grid);
  std::vector<Edges> edges = fit_all(found, options, stride, &estimate);
  std::vector<Quadrilateral> chosen;
  for (std::size_t k = 0; k < found.size(); k += stride) chosen.push_back(found[k]);
  const SamplingGrid grid = estimate_grid(chosen, options, estimate);
  if (grid.period == 1) return edges;
  options.grid = grid;
  return fit_all(found, options, 1, nullptr);
}

bool complete(const Edges& edges) { return edges[3].has_value(); }

/// Root mean square misfit over all edges; 0 where noise explains it.
double model_error_of(const std::vector<Edges>& measured) {
  double sum = 0, count = 0, noise = 0, samples = 0;
  for (const Edges& edges : measured) {
    if (!complete(edges)) continue;
    for (const auto& edge : edges) {
      sum += edge->misfit, count += 1;
      noise += std::pow(edge->noise / edge->contrast, 2), samples += edge->samples;
    }
  }
  return count > 0 ? std::sqrt(std::max(0.0, sum / count - chance_of(noise / count, samples))) : 0;
}

/// What an error of the model does to an edge: a shift [px].
double shift_of(double model_error, const FittedEdge& edge) {
  constexpr double kMultiple = 9.0;
  constexpr double kPixelVariance = 1.0 / 12;  // of a pixel's box [px²]
  return kMultiple * model_error * std::sqrt(edge.blur * edge.blur + kPixelVariance);
}

/// Adds it to the fit's covariance, with a turn of half the variance at the edge's ends.
void add_model_error(double model_error, FittedEdge& edge) {
  const double shift = shift_of(model_error, edge);
  edge.covariance(0, 0) += shift * shift;
  edge.covariance(1, 1) += 0.5 * shift * shift;
}

/// Of a quadrilateral's edges: how many have their dark side inside, less those that have it outside.
int dark_inside(const Quadrilateral& q, const Edges& edges) {
  const Eigen::Vector2d middle = 0.25 * (q.corners[0] + q.corners[1] + q.corners[2] + q.corners[3]);
  int count = 0;
  for (const auto& edge : edges) count += edge->dark * edge->across.dot(middle - edge->centre) > 0 ? 1 : -1;
  return count;
}

/// Whether some of the image's quadrilaterals are black on white and some white on black.
bool of_both_polarities(const std::vector<Quadrilateral>& found, const std::vector<Edges>& measured) {
  bool black = false, white = false;
  for (std::size_t k = 0; k < found.size(); ++k)
    if (complete(measured[k])) (dark_inside(found[k], measured[k]) > 0 ? black : white) = true;
  return black && white;
}

/// Standard deviation of how far all edges are drawn inwards together: by the doubt about the curve, and by what the
/// model errs in, which may be the same for all of them (a halo, bloom); never less than the floor.
double inset_sigma_of(const std::vector<Edges>& measured, double model_error, double by_curve) {
  constexpr double kFloor = 0.03;  // [px]: what no profile shows
  double squares = 0, count = 0;
  for (const Edges& edges : measured)
    if (complete(edges))
      for (const auto& edge : edges) squares += std::pow(shift_of(model_error, *edge), 2), count += 1;
  return count > 0 ? std::hypot(by_curve, kFloor, std::sqrt(squares / count)) : 0;
}

std::optional<RefinedCorners> corners_of(const Edges& edges, const Quadrilateral& q) {
  RefinedCorners refined{q.corners, {}};
  for (int i = 0; i < 4; ++i)
    if (!intersect(*edges[(i + 3) % 4], *edges[i], refined.corners[i], refined.covariances[i])) return std::nullopt;
  return refined;
}

}  // namespace

Measurement measure_corners(const GreyImage& image, const std::vector<Quadrilateral>& found,
                            const EdgeFitOptions& options) {
  std::vector<Quadrilateral> in_image = found;
  for (Quadrilateral& q : in_image) q.part = &image;
  return measure_corners(in_image, options);
}

Measurement measure_corners(const std::vector<Quadrilateral>& found, const EdgeFitOptions& options) {
  Measurement measurement;
  EdgeFitOptions used = options;
  CurveEstimate curve{options.gamma};
  if (options.gamma == 0) curve = estimate_curve(found, options);
  used.gamma = curve.gamma;
  std::vector<Edges> measured = fit_image(found, used);
  measurement.quality = {used.gamma, *used.grid, model_error_of(measured)};
  if (options.gamma == 0)
    measurement.quality.inset_sigma = inset_sigma_of(measured, measurement.quality.model_error, curve.inset_sigma);
  const bool both = options.gamma == 0 && of_both_polarities(found, measured);
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!complete(measured[k])) {
      measurement.corners.emplace_back();
      continue;
    }
    for (auto& edge : measured[k]) {
      add_model_error(measurement.quality.model_error, *edge);
      if (both) edge->covariance(0, 0) += std::pow(measurement.quality.inset_sigma, 2);
    }
    measurement.corners.push_back(corners_of(measured[k], found[k]));
  }
  return measurement;
}

std::optional<RefinedCorners> refine_corners(const GreyImage& image, const std::array<Eigen::Vector2d, 4>& initial,
                                             int modules, const EdgeFitOptions& options) {
  return measure_corners(image, {{initial, modules}}, options).corners.front();
}

}  // namespace plumbline::detect
