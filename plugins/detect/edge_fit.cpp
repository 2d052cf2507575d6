#include "detect/edge_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "images/grey_image.hpp"

namespace plumbline::detect {
namespace {

using Parameters =
    Eigen::Matrix<double, 8, 1>;  // a, b, c, log s, low at the middle, its slope, high at the middle, its slope
using Normal = Eigen::Matrix<double, 8, 8>;

constexpr double kSmallestBlur = 0.15, kLargestBlur = 6.0;  // [px]
// In units of the blur: how far the next edge's blur reaches, and how near the next edge may be at all.
constexpr double kNeighbour = 3.2, kNearest = 3.75;
constexpr int kBins = 24;  // along the edge, for telling an occluded part from the rest

struct Sample {
  double t, d;   // along [-1, 1] and across [px]
  double value;  // [grey values]
  int bin;
};

/// The normal distribution function and its density by cubic Hermite interpolation: error 2e-10, a tenth of the time of
/// erfc.
class NormalTable {
 public:
  NormalTable() {
    for (int i = 0; i <= 2 * kSteps; ++i) {
      const double z = (i - kSteps) * kStep;
      value_[i] = 0.5 * std::erfc(-z * M_SQRT1_2);
      density_[i] = std::exp(-0.5 * z * z) * 0.3989422804014327;
    }
  }
  void operator()(double z, double& value, double& density) const {
    if (!(z > -kEnd)) return void(value = density = 0);
    if (z >= kEnd) return void((value = 1, density = 0));
    const double position = (z + kEnd) / kStep;
    const int i = std::min(static_cast<int>(position), 2 * kSteps - 1);
    const double u = position - i, rise = value_[i + 1] - value_[i];
    const double m0 = density_[i] * kStep, m1 = density_[i + 1] * kStep;
    const double c2 = 3 * rise - 2 * m0 - m1, c3 = m0 + m1 - 2 * rise;
    value = value_[i] + u * (m0 + u * (c2 + u * c3));
    density = (m0 + u * (2 * c2 + 3 * u * c3)) / kStep;
  }

 private:
  static constexpr int kSteps = 320;
  static constexpr double kEnd = 5, kStep = kEnd / kSteps;
  std::array<double, 2 * kSteps + 1> value_{}, density_{};
};

struct Frame {
  Eigen::Vector2d centre, along, across;
  double half_length;
  double box;  // width of the pixel's box across the edge [px]
};

/// How light becomes grey values.
struct Imaging {
  double box;    // width of the pixel's box across the edge [px]
  double gamma;  // of the transfer curve
};

struct Prior {
  double curvature;  // standard deviation of c [px]
  // Sharp and defocused images lie within a factor of three of this; the prior only matters where the data say nothing,
  // as in an edge that falls exactly between two columns of pixels.
  double log_blur = std::log(0.7), log_blur_sigma = 1.0;
};

std::vector<Sample> collect(const GreyImage& image, const Frame& frame, const Eigen::Vector3d& shape, double margin,
                            double reach) {
  const double t_limit = 1 - margin / frame.half_length;
  std::vector<Sample> samples;
  if (!(t_limit > 0)) return samples;
  const double length = frame.half_length * t_limit;
  const double width = reach + shape.cwiseAbs().sum();
  const Eigen::Vector2d half = (frame.along * length).cwiseAbs() + (frame.across * width).cwiseAbs();
  const Eigen::Vector2d low = frame.centre - half, high = frame.centre + half;
  if (low.x() < 0 || low.y() < 0 || high.x() > image.width - 1 || high.y() > image.height - 1) return samples;
  for (int y = static_cast<int>(std::ceil(low.y())); y <= static_cast<int>(high.y()); ++y)
    for (int x = static_cast<int>(std::ceil(low.x())); x <= static_cast<int>(high.x()); ++x) {
      const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - frame.centre;
      const double t = offset.dot(frame.along) / frame.half_length;
      if (std::abs(t) > t_limit) continue;
      const double d = offset.dot(frame.across);
      if (std::abs(d - (shape[0] + t * (shape[1] + t * shape[2]))) > reach) continue;
      const int bin = std::min(kBins - 1, static_cast<int>((t / t_limit + 1) * 0.5 * kBins));
      samples.push_back({t, d, static_cast<double>(image.pixels[static_cast<std::size_t>(y) * image.width + x]), bin});
    }
  return samples;
}

/// Grey values and light: light = ((grey + a) / (255 + a))^gamma, a growing with gamma from 0 for linear files to
/// sRGB's own curve (IEC 61966-2-1, without its toe below 10 grey values) at 2.4. Blur mixes light: the plateaus are
/// taken back to light, mixed there, and the mixture is recorded.
struct Mixture {
  double value;                     // recorded [grey values]
  double by_step, by_low, by_high;  // its derivatives
};

Mixture mix(double low, double high, double step, double gamma) {
  if (gamma == 1) return {low + (high - low) * step, high - low, 1 - step, step};
  const double offset = 255 * 0.055 * (gamma - 1) / (2.4 - 1);
  constexpr double kDarkest = 0.5;  // a power has no slope at zero; half a grey value is below what is recorded
  const double l = std::max(low, kDarkest) + offset, h = std::max(high, kDarkest) + offset;
  const double light_low = std::pow(l, gamma), light_high = std::pow(h, gamma);
  const double light = light_low + (light_high - light_low) * step;
  const double root = std::pow(light, 1 / gamma), slope = root / (gamma * light);
  return {root - offset, slope * (light_high - light_low), slope * (1 - step) * gamma * light_low / l,
          slope * step * gamma * light_high / h};
}

/// Residual and gradient of the model at one sample.
double residual_of(const Sample& sample, const Parameters& p, const Imaging& imaging, Parameters& gradient) {
  const double box = imaging.box;
  static const NormalTable normal;
  static constexpr std::array<double, 3> node = {-0.3872983346207417, 0,
                                                 0.3872983346207417};  // Gauss-Legendre on the pixel
  static constexpr std::array<double, 3> weight = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  const double s = std::exp(p[3]), t = sample.t;
  const double e = sample.d - (p[0] + t * (p[1] + t * p[2]));
  double step = 0, slope = 0, slope_z = 0;
  for (int k = 0; k < 3; ++k) {
    const double z = (e + node[k] * box) / s;
    double value, density;
    normal(z, value, density);
    step += weight[k] * value;
    slope += weight[k] * density;
    slope_z += weight[k] * density * z;
  }
  const Mixture m = mix(p[4] + p[5] * t, p[6] + p[7] * t, step, imaging.gamma);
  const double by_position = -m.by_step * slope / s;
  gradient << by_position, t * by_position, t * t * by_position, -m.by_step * slope_z, m.by_low, t * m.by_low,
      m.by_high, t * m.by_high;
  return sample.value - m.value;
}

struct Solution {
  Parameters p;
  Normal normal;     // J^T J, without priors
  double noise = 1;  // [grey values]
  bool converged = false;
};

double cost_of(const std::vector<Sample>& samples, const Parameters& p, const Imaging& imaging, const Prior& prior,
               double noise, Normal* normal, Parameters* right, double* sum_of_squares) {
  double sum = 0;
  Parameters gradient;
  if (normal) normal->setZero(), right->setZero();
  for (const Sample& sample : samples) {
    const double r = residual_of(sample, p, imaging, gradient);
    sum += r * r;
    if (!normal) continue;
    normal->selfadjointView<Eigen::Lower>().rankUpdate(gradient);
    *right += r * gradient;
  }
  if (normal) *normal = normal->selfadjointView<Eigen::Lower>();
  *sum_of_squares = sum;
  const double bend = p[2] / prior.curvature, blur = (p[3] - prior.log_blur) / prior.log_blur_sigma;
  return sum / (noise * noise) + bend * bend + blur * blur;
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

/// Levenberg-Marquardt from `p`.
Solution solve(const std::vector<Sample>& samples, Parameters p, const Imaging& imaging, const Prior& prior) {
  Solution solution{p, Normal::Zero()};
  if (samples.size() < 24) return solution;
  double damping = 1e-3, sum = 0;
  Parameters right;
  cost_of(samples, p, imaging, prior, 1, nullptr, nullptr, &sum);
  double noise = noise_of(sum, samples.size());
  for (int iteration = 0; iteration < 30; ++iteration) {
    Normal normal;
    const double cost = cost_of(samples, p, imaging, prior, noise, &normal, &right, &sum);
    solution = {p, normal, noise};
    Normal weighted = normal / (noise * noise);
    Parameters weighted_right = right / (noise * noise);
    add_prior(prior, p, weighted, &weighted_right);
    double step_size = 0;
    for (int attempt = 0;; ++attempt) {
      Normal damped = weighted;
      damped.diagonal() *= 1 + damping;
      Parameters trial = p + damped.ldlt().solve(weighted_right);
      trial[3] = std::clamp(trial[3], std::log(kSmallestBlur), std::log(kLargestBlur));
      double trial_sum = 0;
      if (trial.allFinite() &&
          cost_of(samples, trial, imaging, prior, noise, nullptr, nullptr, &trial_sum) <= cost * (1 + 1e-12)) {
        step_size = (trial - p).head<3>().cwiseAbs().maxCoeff();
        p = trial, sum = trial_sum;
        damping = std::max(1e-9, damping * 0.1);
        break;
      }
      damping *= 10;
      if (attempt == 8) break;
    }
    noise = noise_of(sum, samples.size());
    if (step_size < 1e-5) {
      solution.converged = true;
      solution.p = p;
      solution.noise = noise;
      break;
    }
  }
  return solution;
}

/// The plateaus' means on either side of the expected edge; the blur is a guess.
Parameters initial_parameters(const std::vector<Sample>& samples, double reach) {
  std::array<double, 2> sum = {}, count = {};
  for (const Sample& sample : samples) {
    if (std::abs(sample.d) < 0.4 * reach) continue;
    const int side = sample.d > 0;
    sum[side] += sample.value;
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
double drop_disturbed_bins(std::vector<Sample>& samples, const Parameters& p, const Imaging& imaging) {
  std::array<double, kBins> square = {}, count = {};
  Parameters unused;
  for (const Sample& sample : samples) {
    const double r = residual_of(sample, p, imaging, unused);
    square[sample.bin] += r * r;
    count[sample.bin] += 1;
  }
  std::vector<double> means;
  for (int i = 0; i < kBins; ++i)
    if (count[i] > 0) means.push_back(square[i] /= count[i]);
  std::nth_element(means.begin(), means.begin() + static_cast<std::ptrdiff_t>(means.size() / 2), means.end());
  // Short edges have a handful of pixels a bin: below a grey value or two a ratio means nothing.
  const double limit = std::max(9 * means[means.size() / 2], 4.0);
  int kept = 0;
  for (int i = 0; i < kBins; ++i) kept += count[i] > 0 && square[i] <= limit;
  std::erase_if(samples, [&](const Sample& sample) { return square[sample.bin] > limit; });
  return kept / static_cast<double>(means.size());
}

/// FittedEdge::misfit: the residuals' means over half-pixel bins across the edge, squared, less what the scatter within
/// the bins explains of them.
double misfit_of(const std::vector<Sample>& samples, const Parameters& p, const Imaging& imaging) {
  constexpr int kHalf = 24, kAcross = 2 * kHalf;  // bins across, half a pixel each
  constexpr double kFitted = 4;                   // parameters that the mean profile has been fitted with
  std::array<double, kAcross> sum = {}, square = {}, count = {};
  Parameters unused;
  for (const Sample& sample : samples) {
    const double r = residual_of(sample, p, imaging, unused);
    const double e = sample.d - (p[0] + sample.t * (p[1] + sample.t * p[2]));
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
  const double contrast = p[6] - p[4];
  return (between - (bins - kFitted) * within / freedom) / static_cast<double>(samples.size()) / (contrast * contrast);
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

}  // namespace

std::optional<FittedEdge> fit_edge(const GreyImage& image, const EdgeStrip& strip, const EdgeFitOptions& options) {
  const Frame frame = frame_of(strip);
  if (!(frame.half_length > strip.margin)) return std::nullopt;
  const Imaging imaging{frame.box, options.gamma};
  const Prior prior{std::max(0.5 * options.curvature_sigma * frame.half_length * frame.half_length, 1e-6)};

  // The next edge's blur reaches into this strip too. At first the blur is taken to be small; below three pixels a cell
  // nothing is plain any more.
  double reach = std::clamp(strip.plain - 1.0, 1.6, 8.0);
  std::vector<Sample> samples = collect(image, frame, Eigen::Vector3d::Zero(), strip.margin, reach);
  if (samples.size() < 24) return std::nullopt;
  const Parameters start = initial_parameters(samples, reach);
  if (std::abs(start[6] - start[4]) < options.min_contrast) return std::nullopt;
  Solution solution = solve(samples, start, imaging, prior);
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
    solution = solve(samples, solution.p, imaging, prior);
    if (!solution.converged) return std::nullopt;
  }
  const std::size_t before = samples.size();
  if (drop_disturbed_bins(samples, solution.p, imaging) < 0.5) return std::nullopt;
  if (samples.size() < before) solution = solve(samples, solution.p, imaging, prior);

  const double contrast = std::abs(solution.p[6] - solution.p[4]);
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
                  static_cast<int>(samples.size()),
                  misfit_of(samples, solution.p, imaging)};
  if (!edge.shape.allFinite() || !(edge.covariance.diagonal().maxCoeff() < 0.25)) return std::nullopt;
  return edge;
}

}  // namespace plumbline::detect
