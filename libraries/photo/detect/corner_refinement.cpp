#include "photo/detect/corner_refinement.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "photo/images/grey_image.hpp"

namespace plumbline::detect {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Height of point `p` over the line through a and b [px].
double height_over(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return std::abs(cross(b - a, p - a)) / (b - a).norm();
}

/// Strip of the edge from corner i to the next.
EdgeStrip strip_of(const Quadrilateral& q, int i) {
  const std::array<Eigen::Vector2d, 4>& corner = q.corners;
  const auto &previous = corner[(i + 3) % 4], &start = corner[i], &end = corner[(i + 1) % 4],
             &next = corner[(i + 2) % 4];
  const double cell = std::min(height_over(previous, start, end), height_over(next, start, end)) / q.modules;
  const double length = (end - start).norm();
  return {start, end, std::clamp(0.12 * length, 3.0, 10.0), q.border * cell};
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

/// Standard deviation of the mean misfit that chance alone gives, from the edges' noise, contrast and pixels.
double chance_of(double relative_noise_squared, double samples) {
  constexpr double kFactor = 7;  // of a sum of 24 squared means: sqrt(2 · 24)
  return samples > 0 ? kFactor * relative_noise_squared / samples : 0;
}

/// Exponent of the transfer curve that explains the image's edges best, over the exponents that cameras have. What the
/// profiles differ from the model by decides; noise averages away over an image, an error of the model does not. A
/// curve is corrected only where the edges show it: where blur is too small, noise too large or the image sharpened,
/// the exponent stays near 1, and what remains is an inset common to the image's corners.
double estimate_gamma(const std::vector<Quadrilateral>& found, const EdgeFitOptions& options) {
  constexpr std::array<double, 5> exponent = {1.0, 1.4, 1.9, 2.4, 2.9};
  constexpr double kPrior = 3;         // exponential above 1: a curve must pay for itself
  constexpr double kValues = 6;        // independent values of a profile
  constexpr double kFloor = 0.0005;    // misfit of a perfect photograph [contrast]
  constexpr double kFewest = 12;       // edges: chance fools a tag or two
  constexpr std::size_t kEnough = 12;  // quadrilaterals
  static const std::vector<TransferCurve> curves(exponent.begin(), exponent.end());
  EdgeFitter fitter(options);
  std::array<double, 5> misfit = {};
  double count = 0, noise = 0, samples = 0;
  const std::size_t stride = (found.size() + kEnough - 1) / kEnough;
  for (std::size_t k = 0; k < found.size(); k += std::max<std::size_t>(1, stride)) {
    std::array<double, 5> own = {};
    double own_noise = 0, own_samples = 0;
    bool all = true;
    for (int i = 0; i < 4 && all; ++i) {
      const auto edges = fitter.fit_with_curves(*found[k].part, strip_of(found[k], i), curves);
      all = !edges.empty();
      for (std::size_t g = 0; g < edges.size(); ++g) own[g] += edges[g].misfit;
      if (!all) continue;
      own_noise += std::pow(edges[0].noise / edges[0].contrast, 2);
      own_samples += edges[0].samples;
    }
    if (!all) continue;
    for (std::size_t g = 0; g < exponent.size(); ++g) misfit[g] += own[g];
    count += 4;
    noise += own_noise;
    samples += own_samples;
  }
  if (count < kFewest) return 1;
  const double floor = kFloor * kFloor + 4 * chance_of(noise / count, samples);
  std::array<double, 5> cost = {};
  for (std::size_t g = 0; g < exponent.size(); ++g)
    cost[g] = kValues * std::log(std::max(0.0, misfit[g] / count) + floor) + kPrior * (exponent[g] - 1);
  const std::size_t best = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  if (best == 0 || best + 1 == exponent.size()) return exponent[best];
  // Vertex of the parabola through the three costs (Brent's step).
  const double x = exponent[best], left = x - exponent[best - 1], right = x - exponent[best + 1];
  const double by_left = cost[best] - cost[best - 1], by_right = cost[best] - cost[best + 1];
  return x - 0.5 * (left * left * by_right - right * right * by_left) / (left * by_right - right * by_left);
}

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

/// Adds to the fit's covariance what an error of the model does to an edge: a shift, and a turn of half the variance at
/// its ends.
void add_model_error(double model_error, FittedEdge& edge) {
  constexpr double kMultiple = 9.0;
  constexpr double kPixelVariance = 1.0 / 12;  // of a pixel's box [px²]
  const double shift = kMultiple * model_error * std::sqrt(edge.blur * edge.blur + kPixelVariance);
  edge.covariance(0, 0) += shift * shift;
  edge.covariance(1, 1) += 0.5 * shift * shift;
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
  if (options.gamma == 0) used.gamma = estimate_gamma(found, options);
  std::vector<Edges> measured = fit_image(found, used);
  measurement.quality = {used.gamma, *used.grid, model_error_of(measured)};
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!complete(measured[k])) {
      measurement.corners.emplace_back();
      continue;
    }
    for (auto& edge : measured[k]) add_model_error(measurement.quality.model_error, *edge);
    measurement.corners.push_back(corners_of(measured[k], found[k]));
  }
  return measurement;
}

std::optional<RefinedCorners> refine_corners(const GreyImage& image, const std::array<Eigen::Vector2d, 4>& initial,
                                             int modules, const EdgeFitOptions& options) {
  return measure_corners(image, {{initial, modules}}, options).corners.front();
}

}  // namespace plumbline::detect
