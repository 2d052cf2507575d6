#include "photo/detect/curve_estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plumbline::detect {
namespace {

constexpr std::array<double, 5> kExponents = {1.0, 1.4, 1.9, 2.4, 2.9};
using OfEachExponent = std::array<double, kExponents.size()>;

/// What the edges of some quadrilaterals say of each of the exponents.
struct CurveFits {
  OfEachExponent misfit{}, position{};  // sums over the edges; position towards the dark side [px]
  double count = 0, noise = 0, samples = 0, blur = 0;
};

CurveFits fit_curves(const std::vector<Quadrilateral>& found, const EdgeFitOptions& options) {
  constexpr std::size_t kEnough = 12;  // quadrilaterals
  static const std::vector<TransferCurve> curves(kExponents.begin(), kExponents.end());
  EdgeFitter fitter(options);
  CurveFits fits;
  const std::size_t stride = std::max<std::size_t>(1, (found.size() + kEnough - 1) / kEnough);
  for (std::size_t k = 0; k < found.size(); k += stride) {
    std::array<std::vector<FittedEdge>, 4> edges;
    bool all = true;
    for (int i = 0; i < 4 && all; ++i) {
      edges[i] = fitter.fit_with_curves(*found[k].part, strip_of(found[k], i), curves);
      all = !edges[i].empty();
    }
    if (!all) continue;
    for (const auto& edge : edges) {
      for (std::size_t g = 0; g < edge.size(); ++g)
        fits.misfit[g] += edge[g].misfit, fits.position[g] += edge[g].dark * edge[g].shape[0];
      fits.noise += std::pow(edge[0].noise / edge[0].contrast, 2);
      fits.samples += edge[0].samples;
      fits.blur += edge[0].blur, fits.count += 1;
    }
  }
  return fits;
}

/// -2 log of how likely each of the exponents is. What the profiles differ from the model by decides; where noise
/// explains that, by as much as a likelihood with this noise, and where the model errs, by its logarithm. JPEG's errors
/// differ from edge to edge, so many edges say more than few, but not in proportion. `fits` hold an edge at least.
OfEachExponent costs_of(const CurveFits& fits) {
  // Photographs are sRGB or nearly so, or linear files; measured with drawings of both, JPEG 90 to 50.
  constexpr OfEachExponent prior = {2, 8, 4, 0, 2};
  constexpr double kOfAnEdge = 3;    // independent values of a profile
  constexpr double kFloor = 0.0005;  // misfit of a perfect photograph [contrast]
  const double values = kOfAnEdge * std::sqrt(fits.count);
  const double lowest = *std::min_element(fits.misfit.begin(), fits.misfit.end()) / fits.count;
  const double noise = fits.noise / fits.count;
  const double floor =
      kFloor * kFloor + values * noise / fits.samples + std::max(0.0, lowest - chance_of(noise, fits.samples));
  OfEachExponent cost = prior;
  for (std::size_t g = 0; g < cost.size(); ++g)
    cost[g] += values * std::log(fits.misfit[g] / fits.count - lowest + floor);
  return cost;
}

/// The lowest point of the costs, between the exponents (Brent's step).
double exponent_of(const OfEachExponent& cost) {
  const auto best = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  if (best == 0 || best + 1 == cost.size()) return kExponents[best];
  const double x = kExponents[best], left = x - kExponents[best - 1], right = x - kExponents[best + 1];
  const double by_left = cost[best] - cost[best - 1], by_right = cost[best] - cost[best + 1];
  return x - 0.5 * (left * left * by_right - right * right * by_left) / (left * by_right - right * by_left);
}

/// Where an edge would lie with exponent `gamma`, between those that were tried [px].
double position_at(const OfEachExponent& position, double gamma) {
  const auto above = std::upper_bound(kExponents.begin() + 1, kExponents.end() - 1, gamma) - kExponents.begin();
  const auto k = static_cast<std::size_t>(above);
  const double share = (gamma - kExponents[k - 1]) / (kExponents[k] - kExponents[k - 1]);
  return position[k - 1] + share * (position[k] - position[k - 1]);
}

}  // namespace

double chance_of(double relative_noise_squared, double samples) {
  constexpr double kFactor = 7;  // of a sum of 24 squared means: sqrt(2 · 24)
  return samples > 0 ? kFactor * relative_noise_squared / samples : 0;
}

CurveEstimate estimate_curve(const std::vector<Quadrilateral>& found, const EdgeFitOptions& options) {
  constexpr double kDrawn = 0.3;  // [px]: no lens draws as sharp; a drawing's grey values are what they are
  const CurveFits fits = fit_curves(found, options);
  if (fits.count == 0) return {};
  const OfEachExponent cost = costs_of(fits);
  const double lowest = *std::min_element(cost.begin(), cost.end());
  CurveEstimate estimate;
  if (fits.blur >= kDrawn * fits.count) estimate.gamma = exponent_of(cost);
  const double chosen = position_at(fits.position, estimate.gamma);
  double weights = 0, squares = 0;
  for (std::size_t g = 0; g < cost.size(); ++g) {
    const double weight = std::exp(0.5 * (lowest - cost[g]));
    weights += weight;
    squares += weight * std::pow((fits.position[g] - chosen) / fits.count, 2);
  }
  // The mean over the curves holds none of them by itself: one that is as likely as this is held, too
  // (chi-squared 1.5).
  constexpr double kPlausible = 0.15, kHeld = 1.5;
  for (std::size_t g = 0; g < cost.size(); ++g)
    if (std::exp(0.5 * (lowest - cost[g])) >= kPlausible * weights)
      squares = std::max(squares, weights / kHeld * std::pow((fits.position[g] - chosen) / fits.count, 2));
  estimate.inset_sigma = std::sqrt(squares / weights);
  return estimate;
}

}  // namespace plumbline::detect
