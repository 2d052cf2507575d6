#include "photo/detect/edge_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "geometry/median.hpp"

namespace plumbline::detect {
namespace {

constexpr double kSmallestBlur = 0.15, kLargestBlur = 6.0;  // [px]
// In units of the blur: how far the next edge's blur reaches, and how near the next edge may be at all.
constexpr double kNeighbour = 3.2, kNearest = 3.75;
constexpr std::size_t kBins = 24;      // along the edge, for telling an occluded part from the rest
constexpr std::size_t kFewest = 24;    // samples
constexpr std::size_t kStart = 300;    // samples that the first fit takes
constexpr std::size_t kSettle = 1200;  // those that the strip's width is settled with
constexpr double kFirstDamping = 1e-3;

double noise_of(double sum_of_squares, std::size_t count) {
  // Rounding to whole grey values alone has a standard deviation of 0.29.
  return std::sqrt(std::max(sum_of_squares / static_cast<double>(count - 8), 1.0 / 12));
}

/// The damped step; at the limit of the blur the others move as if it were known.
EdgeParameters bounded_step(const EdgeNormal& weighted, const EdgeParameters& right, double damping, double log_blur) {
  static const double lower = std::log(kSmallestBlur), upper = std::log(kLargestBlur);
  EdgeNormal damped = weighted;
  damped.diagonal() *= 1 + damping;
  EdgeParameters step = damped.ldlt().solve(right);
  if (log_blur + step[3] >= lower && log_blur + step[3] <= upper) return step;
  const double held = std::clamp(log_blur + step[3], lower, upper) - log_blur;
  EdgeParameters rest = right - damped.col(3) * held;
  damped.row(3).setZero(), damped.col(3).setZero();
  damped(3, 3) = 1, rest[3] = held;
  step = damped.ldlt().solve(rest);
  return step;
}

/// Whether what is left changes the edge by less than 1e-4 px, or all parameters together by less than 0.03 standard
/// deviations: sharpened edges, narrower than the model can be, do not come nearer.
bool negligible(const EdgeParameters& step, const EdgeNormal& weighted) {
  return step.head<3>().cwiseAbs().maxCoeff() < 1e-4 || step.dot(weighted * step) < 1e-3;
}

/// Gauss-Newton knows no second derivatives: on edges as sharp as the pixels it steps across the minimum to and fro.
/// Takes the part of the step that ends between, from how much of the last step it takes back.
EdgeParameters shortened(const EdgeParameters& step, const EdgeParameters& last, const EdgeNormal& weighted) {
  const EdgeParameters scaled = weighted * last;
  const double back = -step.dot(scaled) / last.dot(scaled);
  return back > 0.2 ? EdgeParameters(step / (1 + std::min(back, 1.0))) : step;
}

/// Whether the derivatives are still good after a step. They lead the iteration; where it ends, only J^T r counts.
bool small(const EdgeParameters& step) { return step.head<3>().cwiseAbs().sum() < 0.03 && std::abs(step[3]) < 0.03; }

/// The plateaus' means on either side of the expected edge; the blur is a guess.
EdgeParameters initial_parameters(const EdgeSamples& samples, double reach) {
  std::array<double, 2> sum = {}, count = {};
  for (std::size_t i = 0; i < samples.count; ++i) {
    if (std::abs(samples.d[i]) < 0.4 * reach) continue;
    const int side = samples.d[i] > 0;
    sum[side] += samples.light[i];
    count[side] += 1;
  }
  EdgeParameters p = EdgeParameters::Zero();
  p[3] = std::log(std::min(1.0, 0.4 * reach));
  p[4] = sum[0] / std::max(1.0, count[0]);
  p[6] = sum[1] / std::max(1.0, count[1]);
  return p;
}

/// Takes every so many pixels that about `most` are left, an odd number that does not beat with the rows.
std::size_t stride_for(const EdgeFrame& frame, double margin, double reach, std::size_t most) {
  const double pixels = std::max(0.0, 4 * (frame.half_length - margin) * reach);
  return pixels < static_cast<double>(most) ? 1 : (static_cast<std::size_t>(pixels) / most) | 1;
}

/// The plateaus in another curve's light.
void change_curve(const TransferCurve& from, const TransferCurve& to, EdgeParameters& p) {
  for (const int level : {4, 6}) {
    const double grey = from.to_grey(p[level]);
    p[level + 1] *= to.light_slope(grey) / from.light_slope(grey);
    p[level] = to.to_light(grey);
  }
}

}  // namespace

struct EdgeFitter::Prior {
  double curvature;  // standard deviation of c [px]
  // Sharp and defocused images lie within a factor of three of this; the prior only matters where the data say nothing,
  // as in an edge that falls exactly between two columns of pixels.
  double log_blur = std::log(0.7), log_blur_sigma = 1.0;

  double cost(double sum, const EdgeParameters& p, double noise) const {
    const double bend = p[2] / curvature, blur = (p[3] - log_blur) / log_blur_sigma;
    return sum / (noise * noise) + bend * bend + blur * blur;
  }
  /// To the weighted normal matrix (and the right-hand side).
  void add_to(EdgeNormal& normal, EdgeParameters* right, const EdgeParameters& p) const {
    const double bend = 1 / (curvature * curvature), blur = 1 / (log_blur_sigma * log_blur_sigma);
    normal(2, 2) += bend;
    normal(3, 3) += blur;
    if (!right) return;
    (*right)[2] -= bend * p[2];
    (*right)[3] -= blur * (p[3] - log_blur);
  }
};

EdgeFitter::Prior EdgeFitter::prior() const {
  return {std::max(0.5 * options_.curvature_sigma * frame_.half_length * frame_.half_length, 1e-6)};
}

/// Levenberg-Marquardt from `p`.
EdgeFitter::Solution EdgeFitter::solve(EdgeParameters p) {
  if (samples_.count < kFewest) return {p};
  const Prior prior = this->prior();
  EdgeGradient now = evaluate(samples_, p, frame_.box, columns_);
  EdgeNormal normal = normal_matrix(samples_, columns_);
  EdgeParameters last = EdgeParameters::Zero();  // step
  double damping = kFirstDamping;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const double noise = noise_of(now.sum, samples_.count);
    EdgeNormal weighted = normal / (noise * noise);
    EdgeParameters right = now.right / (noise * noise);
    prior.add_to(weighted, &right, p);
    const double cost = prior.cost(now.sum, p, noise);
    bool lower = false;
    for (int attempt = 0; attempt < 9 && !lower; ++attempt) {
      const EdgeParameters step = shortened(bounded_step(weighted, right, damping, p[3]), last, weighted);
      if (step.allFinite()) {
        if (damping <= kFirstDamping && negligible(step, weighted)) return {p + step, noise, true};
        const EdgeGradient then = evaluate(samples_, p + step, frame_.box, columns_);
        // Single precision sums repeat to 1e-7.
        lower = prior.cost(then.sum, p + step, noise) <= cost * (1 + 1e-7);
        if (lower) {
          p += step, now = then, last = step;
          if (!small(step)) normal = normal_matrix(samples_, columns_);
          if (damping > kFirstDamping && negligible(step, weighted))
            return {p, noise_of(now.sum, samples_.count), true};
        }
      }
      damping = lower ? std::max(1e-9, damping * 0.1) : damping * 10;
    }
    if (!lower) {  // as low as it gets
      now = evaluate(samples_, p, frame_.box, columns_);
      return {p, noise_of(now.sum, samples_.count), true};
    }
  }
  return {p, noise_of(now.sum, samples_.count), false};
}

/// Removes the parts of the edge that something hides: bins whose mean square residual is nine times the median bin's.
/// Returns the share of bins that stay.
double EdgeFitter::drop_disturbed_bins(double margin) {
  const double t_limit = 1 - margin / frame_.half_length, scale = 0.5 * kBins / t_limit;
  const auto bin_of = [&](std::size_t i) {
    return std::min(kBins - 1, static_cast<std::size_t>(std::max(0.0, (samples_.t[i] + t_limit) * scale)));
  };
  std::array<double, kBins> square = {}, count = {};
  for (std::size_t i = 0; i < samples_.count; ++i) {
    const double r = columns_.residual[i];
    const std::size_t bin = bin_of(i);
    square[bin] += r * r;
    count[bin] += 1;
  }
  std::vector<double> means;
  for (std::size_t i = 0; i < kBins; ++i)
    if (count[i] > 0) means.push_back(square[i] /= count[i]);
  // Short edges have a handful of pixels a bin: below a grey value or two a ratio means nothing.
  const double limit = std::max(9 * upper_median(means), 4.0);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < kBins; ++i) kept += count[i] > 0 && square[i] <= limit;
  if (kept < means.size()) samples_.keep([&](std::size_t i) { return square[bin_of(i)] <= limit; });
  return static_cast<double>(kept) / static_cast<double>(means.size());
}

/// FittedEdge::misfit: the residuals' means over half-pixel bins across the edge, squared, less what the scatter within
/// the bins explains of them.
double EdgeFitter::misfit(double contrast) const {
  constexpr int kHalf = 24, kAcross = 2 * kHalf;  // bins across, half a pixel each
  constexpr double kFitted = 4;                   // parameters that the mean profile has been fitted with
  std::array<double, kAcross> sum = {}, square = {}, count = {};
  const EdgeParameters& p = solution_.p;
  for (std::size_t i = 0; i < samples_.count; ++i) {
    const double r = columns_.residual[i], t = samples_.t[i];
    const double e = samples_.d[i] - (p[0] + t * (p[1] + t * p[2]));
    const auto bin = static_cast<std::size_t>(std::clamp(2 * e + kHalf, 0.0, kAcross - 1.0));
    sum[bin] += r, square[bin] += r * r, count[bin] += 1;
  }
  double between = 0, within = 0, freedom = 0, bins = 0;
  for (std::size_t i = 0; i < kAcross; ++i) {
    if (count[i] < 2) continue;
    const double of_mean = sum[i] * sum[i] / count[i];
    between += of_mean;
    within += square[i] - of_mean;
    freedom += count[i] - 1;
    bins += 1;
  }
  if (!(freedom > 0)) return 0;
  return (between - (bins - kFitted) * within / freedom) / static_cast<double>(samples_.count) / (contrast * contrast);
}

/// Fits frame_, samples_ and solution_; false as fit() returns nothing.
bool EdgeFitter::fit_strip(const GreyImage& image, const EdgeStrip& strip, const TransferCurve& curve) {
  frame_ = edge_frame(strip.start, strip.end);
  if (!(frame_.half_length > strip.margin)) return false;

  // The next edge's blur reaches into this strip too. At first the blur is taken to be small; below three pixels a cell
  // nothing is plain any more.
  double reach = std::clamp(strip.plain - 1.0, 1.6, 8.0);
  const auto collect = [&](std::size_t stride) {
    samples_.collect(image, frame_, solution_.p.head<3>(), strip.margin, reach, stride,
                     options_.grid.value_or(SamplingGrid{}), origin_);
    samples_.record(curve);
  };
  solution_ = {EdgeParameters::Zero()};
  collect(stride_for(frame_, strip.margin, reach, kStart));
  if (samples_.count < kFewest) return false;
  const EdgeParameters start = initial_parameters(samples_, reach);
  if (std::abs(curve.to_grey(start[6]) - curve.to_grey(start[4])) < options_.min_contrast) return false;
  solution_ = solve(start);
  if (!solution_.converged || solution_.p.head<3>().cwiseAbs().sum() > reach) return false;

  // Again with the strip on the edge that was found, as wide as its blur asks for and the next edge's blur allows:
  // further out there is nothing to learn of the edge, but flare, dirt and the neighbour.
  std::size_t stride = 1;
  for (int pass = 0; pass < 3; ++pass) {
    const double blur = std::exp(solution_.p[3]), plain = strip.plain - kNeighbour * blur;
    if (strip.plain < kNearest * blur) return false;  // the two blurred edges run into each other
    const double wanted = std::clamp(4 * blur + 2, 1.6, std::max(1.6, plain));
    if (pass > 0 && std::abs(wanted - reach) < 0.25) break;
    reach = wanted;
    stride = stride_for(frame_, strip.margin, reach, kSettle);
    collect(stride);
    solution_ = solve(solution_.p);
    if (!solution_.converged) return false;
  }
  if (stride > 1) {
    collect(1);
    solution_ = solve(solution_.p);
    if (!solution_.converged) return false;
  }
  const std::size_t before = samples_.count;
  if (drop_disturbed_bins(strip.margin) < 0.5) return false;
  if (samples_.count < before) {
    samples_.record(curve);
    solution_ = solve(solution_.p);
  }
  return true;
}

std::optional<FittedEdge> EdgeFitter::fitted_edge(const TransferCurve& curve) const {
  const double contrast = std::abs(curve.to_grey(solution_.p[6]) - curve.to_grey(solution_.p[4]));
  if (!solution_.converged || contrast < options_.min_contrast || solution_.noise > 0.25 * contrast)
    return std::nullopt;
  EdgeNormal weighted = normal_matrix(samples_, columns_) / (solution_.noise * solution_.noise);
  prior().add_to(weighted, nullptr, solution_.p);
  const Eigen::Matrix<double, 8, 3> covariance = weighted.ldlt().solve(Eigen::Matrix<double, 8, 3>::Identity());
  FittedEdge edge{frame_.centre,
                  frame_.along,
                  frame_.across,
                  frame_.half_length,
                  solution_.p.head<3>(),
                  covariance.topRows<3>(),
                  std::exp(solution_.p[3]),
                  contrast,
                  solution_.noise,
                  static_cast<int>(samples_.count),
                  misfit(contrast),
                  solution_.p[6] < solution_.p[4] ? 1.0 : -1.0};
  if (!edge.shape.allFinite() || !(edge.covariance.diagonal().maxCoeff() < 0.25)) return std::nullopt;
  return edge;
}

void EdgeFitter::add_to(SamplingGridEstimate& estimate) const {
  EdgeNormal weighted = normal_matrix(samples_, columns_) / (solution_.noise * solution_.noise);
  prior().add_to(weighted, nullptr, solution_.p);
  estimate.add(samples_, columns_, frame_, weighted, solution_.noise, origin_);
}

std::optional<FittedEdge> EdgeFitter::fit(const GreyImage& image, const EdgeStrip& strip) {
  return fit_strip(image, strip, curve_) ? fitted_edge(curve_) : std::nullopt;
}

std::vector<FittedEdge> EdgeFitter::fit_with_curves(const GreyImage& image, const EdgeStrip& strip,
                                                    const std::vector<TransferCurve>& curves) {
  std::vector<FittedEdge> edges;
  for (const TransferCurve& curve : curves) {
    if (&curve == &curves.front()) {
      if (!fit_strip(image, strip, curve)) return {};
    } else {
      change_curve(*(&curve - 1), curve, solution_.p);
      samples_.record(curve);
      solution_ = solve(solution_.p);
    }
    const auto edge = fitted_edge(curve);
    if (!edge) return {};
    edges.push_back(*edge);
  }
  return edges;
}

}  // namespace plumbline::detect
