#include "detect/edge_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "images/grey_image.hpp"

#define PLUMBLINE_CLONES __attribute__((target_clones("avx2", "default")))

namespace plumbline::detect {
namespace {

using Parameters =
    Eigen::Matrix<double, 8, 1>;  // a, b, c, log s, low at the middle, its slope, high at the middle, its slope
using Normal = Eigen::Matrix<double, 8, 8>;

constexpr double kSmallestBlur = 0.15, kLargestBlur = 6.0;  // [px]
// In units of the blur: how far the next edge's blur reaches, and how near the next edge may be at all.
constexpr double kNeighbour = 3.2, kNearest = 3.75;
constexpr int kBins = 24;  // along the edge, for telling an occluded part from the rest

constexpr std::size_t kLanes = 4;  // samples that are worked on side by side

/// Samples as columns, padded with samples of weight 0 to whole groups of kLanes.
struct Samples {
  std::vector<double> t, d;           // along [-1, 1] and across [px]
  std::vector<double> light, weight;  // recorded light, and grey values a unit of light is worth there
  std::vector<std::uint8_t> grey, bin;
  std::size_t count = 0;

  void add(double along, double across, std::uint8_t value, int bin_along) {
    t.push_back(along), d.push_back(across);
    grey.push_back(value), bin.push_back(static_cast<std::uint8_t>(bin_along));
    ++count;
  }
  /// Keeps the samples for which `wanted(i)` holds.
  template <class Wanted>
  void keep(Wanted&& wanted) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!wanted(i)) continue;
      t[kept] = t[i], d[kept] = d[i], grey[kept] = grey[i], bin[kept] = bin[i];
      ++kept;
    }
    t.resize(kept), d.resize(kept), grey.resize(kept), bin.resize(kept);
    count = kept;
  }
};

/// Grey values and light: light = ((grey + a) / (255 + a))^gamma, a growing with gamma from 0 for linear files to
/// sRGB's own curve (IEC 61966-2-1, without its toe below 10 grey values) at 2.4. Blur mixes light, so it is light that
/// the model is fitted to; a residual counts by the grey values that it is at the recorded one, where the noise is.
class Curve {
 public:
  explicit Curve(double gamma) : gamma_(gamma), offset_(255 * 0.055 * (gamma - 1) / (2.4 - 1)) {
    for (std::size_t i = 0; i < 256; ++i) {
      light_[i] = to_light(static_cast<double>(i));
      weight_[i] = 1 / light_slope(static_cast<double>(i));
    }
  }
  double to_light(double grey) const { return std::pow(share(grey), gamma_); }
  double to_grey(double light) const { return std::pow(std::max(light, 0.0), 1 / gamma_) * (255 + offset_) - offset_; }
  /// Light by grey value.
  double light_slope(double grey) const { return gamma_ * std::pow(share(grey), gamma_ - 1) / (255 + offset_); }
  void record(Samples& samples) const {
    const std::size_t padded = (samples.count + kLanes - 1) / kLanes * kLanes;
    samples.light.assign(padded, 0), samples.weight.assign(padded, 0);
    samples.t.resize(padded), samples.d.resize(padded);
    for (std::size_t i = 0; i < samples.count; ++i) {
      samples.light[i] = light_[samples.grey[i]];
      samples.weight[i] = weight_[samples.grey[i]];
    }
  }

 private:
  // A power has no slope at zero; half a grey value is below what is recorded.
  double share(double grey) const { return (gamma_ == 1 ? grey : std::max(grey, 0.5) + offset_) / (255 + offset_); }
  double gamma_, offset_;
  std::array<double, 256> light_{}, weight_{};
};

struct Frame {
  Eigen::Vector2d centre, along, across;
  double half_length;
  double box;  // width of the pixel's box across the edge [px]
};

struct Prior {
  double curvature;  // standard deviation of c [px]
  // Sharp and defocused images lie within a factor of three of this; the prior only matters where the data say nothing,
  // as in an edge that falls exactly between two columns of pixels.
  double log_blur = std::log(0.7), log_blur_sigma = 1.0;
};

/// Narrows [from, to] to the x with |x · slope + rest| <= limit.
void narrow(double slope, double rest, double limit, double& from, double& to) {
  if (std::abs(slope) < 1e-9) {
    if (std::abs(rest) > limit) to = from - 1;
    return;
  }
  const double a = (-limit - rest) / slope, b = (limit - rest) / slope;
  from = std::max(from, std::min(a, b));
  to = std::min(to, std::max(a, b));
}

Samples collect(const GreyImage& image, const Frame& frame, const Eigen::Vector3d& shape, double margin, double reach) {
  const double t_limit = 1 - margin / frame.half_length;
  Samples samples;
  if (!(t_limit > 0)) return samples;
  const double length = frame.half_length * t_limit;
  const double width = reach + shape.cwiseAbs().sum();
  const auto expected = static_cast<std::size_t>(4 * length * width) + 16;
  samples.t.reserve(expected), samples.d.reserve(expected), samples.grey.reserve(expected);
  samples.bin.reserve(expected);
  const Eigen::Vector2d half = (frame.along * length).cwiseAbs() + (frame.across * width).cwiseAbs();
  const Eigen::Vector2d low = frame.centre - half, high = frame.centre + half;
  if (low.x() < 0 || low.y() < 0 || high.x() > image.width - 1 || high.y() > image.height - 1) return samples;
  for (int y = static_cast<int>(std::ceil(low.y())); y <= static_cast<int>(high.y()); ++y) {
    const double dy = y - frame.centre.y();
    double from = low.x() - frame.centre.x(), to = high.x() - frame.centre.x();
    narrow(frame.along.x(), frame.along.y() * dy, length, from, to);
    narrow(frame.across.x(), frame.across.y() * dy, width, from, to);
    const std::uint8_t* row = &image.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width)];
    const int last = std::min(image.width - 1, static_cast<int>(std::floor(to + frame.centre.x())));
    for (int x = std::max(0, static_cast<int>(std::ceil(from + frame.centre.x()))); x <= last; ++x) {
      const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - frame.centre;
      const double t = offset.dot(frame.along) / frame.half_length;
      if (std::abs(t) > t_limit) continue;
      const double d = offset.dot(frame.across);
      if (std::abs(d - (shape[0] + t * (shape[1] + t * shape[2]))) > reach) continue;
      samples.add(t, d, row[x], std::min(kBins - 1, static_cast<int>((t / t_limit + 1) * 0.5 * kBins)));
    }
  }
  return samples;
}

/// What one evaluation of the model leaves for each sample: residual, and derivatives by position, log blur and the two
/// plateaus [grey values].
struct Columns {
  std::vector<double> residual, position, blur, low, high;
  void resize(std::size_t n) {
    for (auto* column : {&residual, &position, &blur, &low, &high}) column->resize(n);
  }
};

/// The normal distribution function and its density. Density: exp(x) = exp(x / 64)^64, to 1e-9 where it matters;
/// function: Abramowitz and Stegun 26.2.17, to 7.5e-8. Plain arithmetic, so that loops are vectorised.
inline void normal(double z, double& value, double& density) {
  const double x = std::abs(z) < 6 ? std::abs(z) : 6.0;
  const double u = x * x * (-0.5 / 64);
  double e = 1 + u * (1 + u * (0.5 + u * (1.0 / 6 + u * (1.0 / 24 + u * (1.0 / 120 + u * (1.0 / 720))))));
  e *= e, e *= e, e *= e, e *= e, e *= e, e *= e;
  density = e * 0.3989422804014327;
  const double k = 1 / (1 + 0.2316419 * x);
  const double tail =
      density * k * (0.319381530 + k * (-0.356563782 + k * (1.781477937 + k * (-1.821255978 + k * 1.330274429))));
  value = z > 0 ? 1 - tail : tail;
}

/// Residuals and derivatives of all samples. `box`: width of the pixel's box across the edge [px].
PLUMBLINE_CLONES void evaluate(const double* __restrict t, const double* __restrict d, const double* __restrict light,
                               const double* __restrict weight, std::size_t count, const double* __restrict p,
                               double blur, double box, double* __restrict residual, double* __restrict by_position,
                               double* __restrict by_blur, double* __restrict by_low, double* __restrict by_high) {
  // The mean of Φ over the box, by its antiderivative z Φ(z) + φ(z).
  const double inverse = 1 / blur, half = 0.5 * box * inverse, by_box = 1 / box, blur_by_box = blur / box;
  const double p0 = p[0], p1 = p[1], p2 = p[2], p4 = p[4], p5 = p[5], p6 = p[6], p7 = p[7];
  for (std::size_t i = 0; i < count; ++i) {
    const double z = (d[i] - (p0 + t[i] * (p1 + t[i] * p2))) * inverse;
    const double from = z - half, to = z + half;
    double value0, value1, density0, density1;
    normal(from, value0, density0);
    normal(to, value1, density1);
    const double step = blur_by_box * (to * value1 + density1 - from * value0 - density0);
    const double slope = by_box * (value1 - value0);
    const double slope_blur = blur_by_box * (density1 - density0);
    const double low = p4 + p5 * t[i], contrast = p6 + p7 * t[i] - low, w = weight[i];
    residual[i] = w * (light[i] - low - contrast * step);
    by_position[i] = -w * contrast * slope;
    by_blur[i] = w * contrast * slope_blur;
    by_low[i] = w * (1 - step);
    by_high[i] = w * step;
  }
}

/// Sums of products of the eight derivatives and the residual, lane by lane: `sums` has 45 groups of kLanes, the lower
/// triangle of the 9 × 9 matrix row by row.
PLUMBLINE_CLONES void sum_products(const double* __restrict t, const double* __restrict residual,
                                   const double* __restrict by_position, const double* __restrict by_blur,
                                   const double* __restrict by_low, const double* __restrict by_high, std::size_t count,
                                   double* __restrict sums) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    double g[9][kLanes];
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double along = t[i + l];
      g[0][l] = by_position[i + l];
      g[1][l] = along * by_position[i + l];
      g[2][l] = along * along * by_position[i + l];
      g[3][l] = by_blur[i + l];
      g[4][l] = by_low[i + l];
      g[5][l] = along * by_low[i + l];
      g[6][l] = by_high[i + l];
      g[7][l] = along * by_high[i + l];
      g[8][l] = residual[i + l];
    }
    double* sum = sums;
#pragma GCC unroll 9
    for (std::size_t a = 0; a < 9; ++a)
#pragma GCC unroll 9
      for (std::size_t b = 0; b <= a; ++b, sum += kLanes)
        for (std::size_t l = 0; l < kLanes; ++l) sum[l] += g[a][l] * g[b][l];
  }
}

/// J^T J, J^T r and r^T r.
struct Equations {
  Normal normal = Normal::Zero();
  Parameters right = Parameters::Zero();
  double sum = 0;
};

void evaluate(const Samples& samples, const Parameters& p, double box, Columns& columns) {
  columns.resize(samples.t.size());
  evaluate(samples.t.data(), samples.d.data(), samples.light.data(), samples.weight.data(), samples.t.size(), p.data(),
           std::exp(p[3]), box, columns.residual.data(), columns.position.data(), columns.blur.data(),
           columns.low.data(), columns.high.data());
}

Equations equations(const Samples& samples, const Parameters& p, double box, Columns& columns) {
  evaluate(samples, p, box, columns);
  std::array<double, 45 * kLanes> sums{};
  sum_products(samples.t.data(), columns.residual.data(), columns.position.data(), columns.blur.data(),
               columns.low.data(), columns.high.data(), samples.t.size(), sums.data());
  Equations e;
  const double* sum = sums.data();
  for (int a = 0; a < 9; ++a)
    for (int b = 0; b <= a; ++b, sum += kLanes) {
      double total = 0;
      for (std::size_t l = 0; l < kLanes; ++l) total += sum[l];
      if (a < 8)
        e.normal(a, b) = e.normal(b, a) = total;
      else if (b < 8)
        e.right[b] = total;
      else
        e.sum = total;
    }
  return e;
}

struct Solution {
  Parameters p;
  Normal normal;     // J^T J, without priors
  double noise = 1;  // [grey values]
  bool converged = false;
};

double cost_of(const Equations& e, const Parameters& p, const Prior& prior, double noise) {
  const double bend = p[2] / prior.curvature, blur = (p[3] - prior.log_blur) / prior.log_blur_sigma;
  return e.sum / (noise * noise) + bend * bend + blur * blur;
}

/// Adds the priors to the weighted normal matrix (and the right-hand side).
void add_prior(const Prior& prior, const Parameters& p, Normal& normal, Parameters* right) {
  const double bend = 1 / (prior.curvature * prior.curvature), blur = 1 / (prior.log_blur_sigma * prior.log_blur_sigma);
  normal(2, 2) += bend;
  normal(3, 3) += blur;
  if (!right) return;
  (*right)[2] -= bend * p[2];
  (*right)[3] -= blur * (p[3] - prior.log_blur);
}

double noise_of(double sum_of_squares, std::size_t count) {
  // Rounding to whole grey values alone has a standard deviation of 0.29.
  return std::sqrt(std::max(sum_of_squares / static_cast<double>(count - 8), 1.0 / 12));
}

/// The damped step; at the limit of the blur the others move as if it were known.
Parameters bounded_step(const Normal& weighted, const Parameters& right, double damping, double log_blur) {
  static const double lower = std::log(kSmallestBlur), upper = std::log(kLargestBlur);
  Normal damped = weighted;
  damped.diagonal() *= 1 + damping;
  Parameters step = damped.ldlt().solve(right);
  if (log_blur + step[3] >= lower && log_blur + step[3] <= upper) return step;
  const double held = std::clamp(log_blur + step[3], lower, upper) - log_blur;
  Parameters rest = right - damped.col(3) * held;
  damped.row(3).setZero(), damped.col(3).setZero();
  damped(3, 3) = 1, rest[3] = held;
  step = damped.ldlt().solve(rest);
  return step;
}

/// Levenberg-Marquardt from `p`.
Solution solve(const Samples& samples, Parameters p, double box, const Prior& prior) {
  // The last step changes the edge by less than 1e-4 px, or all parameters together by less than 0.03 standard
  // deviations: sharpened edges, narrower than the model can be, do not come nearer.
  constexpr double kEnough = 1e-4, kEnoughOfDeviation = 1e-3;
  Solution solution{p, Normal::Zero()};
  if (samples.count < 24) return solution;
  Columns columns;
  Equations now = equations(samples, p, box, columns);
  double damping = 1e-3, noise = noise_of(now.sum, samples.count);
  for (int iteration = 0; iteration < 30 && !solution.converged; ++iteration) {
    Normal weighted = now.normal / (noise * noise);
    Parameters weighted_right = now.right / (noise * noise);
    add_prior(prior, p, weighted, &weighted_right);
    const double cost = cost_of(now, p, prior, noise);
    double step_size = 0, change = 0;
    for (int attempt = 0;; ++attempt) {
      const Parameters trial = p + bounded_step(weighted, weighted_right, damping, p[3]);
      if (trial.allFinite()) {
        const Equations then = equations(samples, trial, box, columns);
        if (cost_of(then, trial, prior, noise) <= cost * (1 + 1e-12)) {
          step_size = (trial - p).head<3>().cwiseAbs().maxCoeff();
          change = (trial - p).dot(weighted * (trial - p));
          p = trial, now = then;
          damping = std::max(1e-9, damping * 0.1);
          break;
        }
      }
      damping *= 10;
      if (attempt == 8) break;
    }
    noise = noise_of(now.sum, samples.count);
    solution = {p, now.normal, noise, step_size < kEnough || change < kEnoughOfDeviation};
  }
  return solution;
}

/// The plateaus' means on either side of the expected edge; the blur is a guess.
Parameters initial_parameters(const Samples& samples, double reach) {
  std::array<double, 2> sum = {}, count = {};
  for (std::size_t i = 0; i < samples.count; ++i) {
    if (std::abs(samples.d[i]) < 0.4 * reach) continue;
    const int side = samples.d[i] > 0;
    sum[side] += samples.light[i];
    count[side] += 1;
  }
  Parameters p = Parameters::Zero();
  p[3] = std::log(std::min(1.0, 0.4 * reach));
  p[4] = sum[0] / std::max(1.0, count[0]);
  p[6] = sum[1] / std::max(1.0, count[1]);
  return p;
}

/// Removes the parts of the edge that something hides: bins whose mean square residual is nine times the median bin's.
/// Returns the share of bins that stay.
double drop_disturbed_bins(Samples& samples, const Parameters& p, double box) {
  std::array<double, kBins> square = {}, count = {};
  Columns columns;
  evaluate(samples, p, box, columns);
  for (std::size_t i = 0; i < samples.count; ++i) {
    square[samples.bin[i]] += columns.residual[i] * columns.residual[i];
    count[samples.bin[i]] += 1;
  }
  std::vector<double> means;
  for (int i = 0; i < kBins; ++i)
    if (count[i] > 0) means.push_back(square[i] /= count[i]);
  std::nth_element(means.begin(), means.begin() + static_cast<std::ptrdiff_t>(means.size() / 2), means.end());
  // Short edges have a handful of pixels a bin: below a grey value or two a ratio means nothing.
  const double limit = std::max(9 * means[means.size() / 2], 4.0);
  int kept = 0;
  for (int i = 0; i < kBins; ++i) kept += count[i] > 0 && square[i] <= limit;
  samples.keep([&](std::size_t i) { return square[samples.bin[i]] <= limit; });
  return kept / static_cast<double>(means.size());
}

/// FittedEdge::misfit: the residuals' means over half-pixel bins across the edge, squared, less what the scatter within
/// the bins explains of them.
double misfit_of(const Samples& samples, const Parameters& p, double box, double contrast) {
  constexpr int kHalf = 24, kAcross = 2 * kHalf;  // bins across, half a pixel each
  constexpr double kFitted = 4;                   // parameters that the mean profile has been fitted with
  std::array<double, kAcross> sum = {}, square = {}, count = {};
  Columns columns;
  evaluate(samples, p, box, columns);
  for (std::size_t i = 0; i < samples.count; ++i) {
    const double r = columns.residual[i], t = samples.t[i];
    const double e = samples.d[i] - (p[0] + t * (p[1] + t * p[2]));
    const int bin = std::clamp(static_cast<int>(std::floor(2 * e)) + kHalf, 0, kAcross - 1);
    sum[bin] += r, square[bin] += r * r, count[bin] += 1;
  }
  double between = 0, within = 0, freedom = 0, bins = 0;
  for (int i = 0; i < kAcross; ++i) {
    if (count[i] < 2) continue;
    const double of_mean = sum[i] * sum[i] / count[i];
    between += of_mean;
    within += square[i] - of_mean;
    freedom += count[i] - 1;
    bins += 1;
  }
  if (!(freedom > 0)) return 0;
  return (between - (bins - kFitted) * within / freedom) / static_cast<double>(samples.count) / (contrast * contrast);
}

Frame frame_of(const EdgeStrip& strip) {
  Frame frame;
  const Eigen::Vector2d span = strip.end - strip.start;
  frame.half_length = 0.5 * span.norm();
  frame.centre = 0.5 * (strip.start + strip.end);
  frame.along = span.normalized();
  frame.across = {-frame.along.y(), frame.along.x()};
  frame.box = frame.across.cwiseAbs().maxCoeff();
  return frame;
}

/// One edge's samples and the fit to them, so that it can be fitted again with another transfer curve.
struct Fit {
  Frame frame;
  Prior prior;
  Samples samples;
  Solution solution;
};

/// At most about `most` samples, evenly taken: the start needs no more.
void thin(Samples& samples, std::size_t most) {
  const std::size_t stride = samples.count / most | 1;  // odd, so that it does not beat with the rows
  if (stride > 1) samples.keep([&](std::size_t i) { return i % stride == 0; });
}

std::optional<Fit> fit_strip(const GreyImage& image, const EdgeStrip& strip, const EdgeFitOptions& options,
                             const Curve& curve) {
  Fit fit{frame_of(strip), {}, {}, {}};
  const Frame& frame = fit.frame;
  if (!(frame.half_length > strip.margin)) return std::nullopt;
  fit.prior.curvature = std::max(0.5 * options.curvature_sigma * frame.half_length * frame.half_length, 1e-6);

  // The next edge's blur reaches into this strip too. At first the blur is taken to be small; below three pixels a cell
  // nothing is plain any more.
  double reach = std::clamp(strip.plain - 1.0, 1.6, 8.0);
  Samples& samples = fit.samples;
  samples = collect(image, frame, Eigen::Vector3d::Zero(), strip.margin, reach);
  if (samples.count < 24) return std::nullopt;
  thin(samples, 300);
  curve.record(samples);
  const Parameters start = initial_parameters(samples, reach);
  if (std::abs(curve.to_grey(start[6]) - curve.to_grey(start[4])) < options.min_contrast) return std::nullopt;
  Solution& solution = fit.solution;
  solution = solve(samples, start, frame.box, fit.prior);
  if (!solution.converged || solution.p.head<3>().cwiseAbs().sum() > reach) return std::nullopt;

  // Again with the strip on the edge that was found, as wide as its blur asks for and the next edge's blur allows:
  // further out there is nothing to learn of the edge, but flare, dirt and the neighbour.
  for (int pass = 0; pass < 3; ++pass) {
    const double blur = std::exp(solution.p[3]), plain = strip.plain - kNeighbour * blur;
    if (strip.plain < kNearest * blur) return std::nullopt;  // the two blurred edges run into each other
    const double wanted = std::clamp(4 * blur + 2, 1.6, std::max(1.6, plain));
    if (pass > 0 && std::abs(wanted - reach) < 0.25) break;
    reach = wanted;
    samples = collect(image, frame, solution.p.head<3>(), strip.margin, reach);
    curve.record(samples);
    solution = solve(samples, solution.p, frame.box, fit.prior);
    if (!solution.converged) return std::nullopt;
  }
  const std::size_t before = samples.count;
  if (drop_disturbed_bins(samples, solution.p, frame.box) < 0.5) return std::nullopt;
  curve.record(samples);
  if (samples.count < before) solution = solve(samples, solution.p, frame.box, fit.prior);
  return fit;
}

std::optional<FittedEdge> edge_of(const Fit& fit, const EdgeFitOptions& options, const Curve& curve) {
  const auto& [frame, prior, samples, solution] = fit;
  const double contrast = std::abs(curve.to_grey(solution.p[6]) - curve.to_grey(solution.p[4]));
  if (!solution.converged || contrast < options.min_contrast || solution.noise > 0.25 * contrast) return std::nullopt;
  Normal weighted = solution.normal / (solution.noise * solution.noise);
  add_prior(prior, solution.p, weighted, nullptr);
  const Normal covariance = weighted.ldlt().solve(Normal::Identity());
  FittedEdge edge{frame.centre,
                  frame.along,
                  frame.across,
                  frame.half_length,
                  solution.p.head<3>(),
                  covariance.topLeftCorner<3, 3>(),
                  std::exp(solution.p[3]),
                  contrast,
                  solution.noise,
                  static_cast<int>(samples.count),
                  misfit_of(samples, solution.p, frame.box, contrast)};
  if (!edge.shape.allFinite() || !(edge.covariance.diagonal().maxCoeff() < 0.25)) return std::nullopt;
  return edge;
}

/// The plateaus in another curve's light.
void change_curve(const Curve& from, const Curve& to, Parameters& p) {
  for (const int level : {4, 6}) {
    const double grey = from.to_grey(p[level]);
    p[level + 1] *= to.light_slope(grey) / from.light_slope(grey);
    p[level] = to.to_light(grey);
  }
}

}  // namespace

std::optional<FittedEdge> fit_edge(const GreyImage& image, const EdgeStrip& strip, const EdgeFitOptions& options) {
  const Curve curve(options.gamma);
  const auto fit = fit_strip(image, strip, options, curve);
  return fit ? edge_of(*fit, options, curve) : std::nullopt;
}

std::vector<FittedEdge> fit_edge_with_curves(const GreyImage& image, const EdgeStrip& strip,
                                             const EdgeFitOptions& options, const std::vector<double>& gammas) {
  std::vector<FittedEdge> edges;
  std::optional<Fit> fit;
  std::optional<Curve> curve;
  for (const double gamma : gammas) {
    const Curve next(gamma);
    if (!fit) {
      fit = fit_strip(image, strip, options, next);
      if (!fit) return {};
    } else {
      change_curve(*curve, next, fit->solution.p);
      next.record(fit->samples);
      fit->solution = solve(fit->samples, fit->solution.p, fit->frame.box, fit->prior);
    }
    curve = next;
    const auto edge = edge_of(*fit, options, next);
    if (!edge) return {};
    edges.push_back(*edge);
  }
  return edges;
}

}  // namespace plumbline::detect
