#include "detect/target_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "detect/target_search.hpp"
#include "images/grey_image.hpp"

namespace plumbline::detect {
namespace {

enum : Eigen::Index { kX, kY, kFirst, kSecond, kBlur, kLow, kHigh, kShadeX, kShadeY, kGamma, kWidth1, kWidth2, kAll };
using Parameters = Eigen::Matrix<double, kAll, 1>;
using Normal = Eigen::Matrix<double, kAll, kAll>;

constexpr double kSmallestRadius = 5;  // [px]
constexpr double kWorstMisfit = 0.12;  // of the contrast
constexpr double kLeastAngle = 0.4;    // between the two lines [rad]
constexpr int kLags = 2;               // over which noise may be correlated [px]

std::string text_of(const char* format, double a, double b = 0) {
  char text[240];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// Grey values of a target at parameters `p`: low and high [grey values], blur as its logarithm, widths of the bars as
/// logarithms of half of them, shading as a share of the light at the rim, gamma as in EdgeFitOptions.
class Model {
 public:
  Model(TargetKind kind, const Parameters& p, double radius)
      : kind_(kind), p_(p), radius_(radius), offset_(255 * 0.055 * (p[kGamma] - 1) / (2.4 - 1)) {
    sin_ = {std::sin(p[kFirst]), std::sin(p[kSecond])}, cos_ = {std::cos(p[kFirst]), std::cos(p[kSecond])};
    scale_ = M_SQRT1_2 / std::exp(p[kBlur]);
    low_ = light_of(p[kLow]), high_ = light_of(p[kHigh]);
    width_ = {std::exp(p[kWidth1]), std::exp(p[kWidth2])};
  }

  /// The grey value; with `slopes` also its derivatives by all parameters but gamma, to which 0 is given.
  double operator()(double x, double y, double* slopes = nullptr) const {
    const double dx = x - p_[kX], dy = y - p_[kY];
    const std::array<Part, 2> part = {part_of(0, dx, dy, slopes), part_of(1, dx, dy, slopes)};
    const bool quadrants = kind_ == TargetKind::quadrants;
    const double share =
        quadrants ? 0.5 + 0.5 * part[0].value * part[1].value : 1 - (1 - part[0].value) * (1 - part[1].value);
    const double shade = std::max(1 + (p_[kShadeX] * dx + p_[kShadeY] * dy) / radius_, 0.05);
    const double plain = low_ + (high_ - low_) * share, light = std::max(plain * shade, 1e-6);
    const double grey = std::pow(light, 1 / p_[kGamma]) * (255 + offset_) - offset_;
    if (!slopes) return grey;
    const double by_light = (grey + offset_) / (p_[kGamma] * light);
    const auto by_part = [&](std::size_t i) {
      const double other = part[1 - i].value;
      return by_light * shade * (high_ - low_) * (quadrants ? 0.5 * other : 1 - other);
    };
    std::fill_n(slopes, kAll, 0.0);
    for (std::size_t i = 0; i < 2; ++i) {
      const double by_distance = by_part(i) * part[i].by_distance;
      slopes[kX] += by_distance * sin_[i], slopes[kY] -= by_distance * cos_[i];
      slopes[i == 0 ? kFirst : kSecond] = -by_distance * (dy * sin_[i] + dx * cos_[i]);
      slopes[kBlur] += by_part(i) * part[i].by_blur;
      if (!quadrants) slopes[i == 0 ? kWidth1 : kWidth2] = by_part(i) * part[i].by_width;
    }
    slopes[kLow] = by_light * shade * (1 - share) * light_slope(p_[kLow]);
    slopes[kHigh] = by_light * shade * share * light_slope(p_[kHigh]);
    slopes[kShadeX] = by_light * plain * dx / radius_, slopes[kShadeY] = by_light * plain * dy / radius_;
    slopes[kX] -= by_light * plain * p_[kShadeX] / radius_, slopes[kY] -= by_light * plain * p_[kShadeY] / radius_;
    return grey;
  }

 private:
  struct Part {
    double value, by_distance = 0, by_blur = 0, by_width = 0;
  };
  /// The edge of quadrants along line i from -1 to 1, or the bar of a crosshair from 0 to 1.
  Part part_of(std::size_t i, double dx, double dy, bool with_slopes) const {
    const double d = dy * cos_[i] - dx * sin_[i];
    const auto slope = [&](double at) { return M_2_SQRTPI * scale_ * std::exp(-at * at * scale_ * scale_); };
    if (kind_ == TargetKind::quadrants) {
      Part part{std::erf(d * scale_)};
      if (with_slopes) part.by_distance = slope(d), part.by_blur = -d * part.by_distance;
      return part;
    }
    const double w = width_[i];
    Part part{0.5 * (std::erf((d + w) * scale_) - std::erf((d - w) * scale_))};
    if (!with_slopes) return part;
    const double near = 0.5 * slope(d + w), far = 0.5 * slope(d - w);
    part.by_distance = near - far, part.by_blur = (d - w) * far - (d + w) * near, part.by_width = w * (near + far);
    return part;
  }
  double share_of(double grey) const { return std::max((grey + offset_) / (255 + offset_), 1e-6); }
  double light_of(double grey) const { return std::pow(share_of(grey), p_[kGamma]); }
  double light_slope(double grey) const {
    return p_[kGamma] * std::pow(share_of(grey), p_[kGamma] - 1) / (255 + offset_);
  }
  TargetKind kind_;
  Parameters p_;
  double radius_, offset_, scale_ = 0, low_ = 0, high_ = 0;
  std::array<double, 2> sin_{}, cos_{}, width_{};
};

struct Pixels {
  std::vector<Eigen::Vector2i> at;
  Eigen::VectorXd grey;
};

Pixels disc(const GreyImage& image, const Eigen::Vector2d& centre, double radius) {
  Pixels pixels;
  std::vector<double> grey;
  for (int y = static_cast<int>(std::ceil(centre.y() - radius)); y <= centre.y() + radius; ++y)
    for (int x = static_cast<int>(std::ceil(centre.x() - radius)); x <= centre.x() + radius; ++x) {
      if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
      if ((Eigen::Vector2d(x, y) - centre).norm() > radius) continue;
      pixels.at.emplace_back(x, y);
      grey.push_back(image.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                  static_cast<std::size_t>(x)]);
    }
  pixels.grey = Eigen::Map<Eigen::VectorXd>(grey.data(), static_cast<Eigen::Index>(grey.size()));
  return pixels;
}

bool reaches_border(const GreyImage& image, const Eigen::Vector2d& centre, double radius) {
  return centre.x() < radius || centre.y() < radius || centre.x() > image.width - 1 - radius ||
         centre.y() > image.height - 1 - radius;
}

/// What is known without the image: blur of a focused lens, a curve between linear and sRGB, even light.
struct Priors {
  Parameters value = Parameters::Zero(), weight = Parameters::Zero();
  Priors() {
    const auto set = [&](Eigen::Index k, double v, double sigma) { value[k] = v, weight[k] = 1 / (sigma * sigma); };
    set(kBlur, std::log(0.8), 1), set(kGamma, 1.8, 0.8), set(kShadeX, 0, 0.3), set(kShadeY, 0, 0.3);
  }
};

struct Fit {
  TargetKind kind = TargetKind::any;
  Parameters p = Parameters::Zero();
  double radius = 0;
  Pixels pixels;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
  Normal normal = Normal::Identity();  // with the priors, of unit weight one grey value
  bool converged = false;

  double contrast() const { return std::abs(p[kHigh] - p[kLow]); }
  double rms() const {
    return std::sqrt(residuals.squaredNorm() / std::max(1.0, static_cast<double>(residuals.size())));
  }
};

Eigen::VectorXd model_at(TargetKind kind, const Parameters& p, double radius, const Pixels& pixels) {
  const Model model(kind, p, radius);
  Eigen::VectorXd grey(pixels.grey.size());
  for (Eigen::Index i = 0; i < grey.size(); ++i) {
    const auto& at = pixels.at[static_cast<std::size_t>(i)];
    grey[i] = model(at.x(), at.y());
  }
  return grey;
}

/// The same with the derivatives; that by gamma, which all of the curve hangs on, as a difference.
Eigen::VectorXd evaluate(TargetKind kind, const Parameters& p, double radius, const Pixels& pixels,
                         Eigen::MatrixXd& jacobian) {
  constexpr double step = 1e-5;
  Parameters next = p;
  next[kGamma] += step;
  const Model model(kind, p, radius), other(kind, next, radius);
  Eigen::VectorXd grey(pixels.grey.size());
  Parameters slopes;
  for (Eigen::Index i = 0; i < grey.size(); ++i) {
    const auto& at = pixels.at[static_cast<std::size_t>(i)];
    grey[i] = model(at.x(), at.y(), slopes.data());
    slopes[kGamma] = (other(at.x(), at.y()) - grey[i]) / step;
    jacobian.row(i) = slopes.transpose();
  }
  return grey;
}

void bound(Parameters& p, double radius) {
  p[kBlur] = std::clamp(p[kBlur], std::log(0.2), std::log(0.5 * radius));
  p[kGamma] = std::clamp(p[kGamma], 1.0, 3.0);
  for (const auto k : {kLow, kHigh}) p[k] = std::clamp(p[k], 0.0, 400.0);
  for (const auto k : {kShadeX, kShadeY}) p[k] = std::clamp(p[k], -0.6, 0.6);
  for (const auto k : {kWidth1, kWidth2}) p[k] = std::clamp(p[k], std::log(0.3), std::log(radius));
}

/// Levenberg and Marquardt's method over the disc about the centre that it starts from.
Fit minimise(const GreyImage& image, TargetKind kind, Parameters p, double radius) {
  static const Priors priors;
  Fit fit;
  fit.kind = kind, fit.radius = radius;
  fit.pixels = disc(image, p.head<2>(), radius);
  const Eigen::Index n = fit.pixels.grey.size(), used = kind == TargetKind::crosshair ? kAll : kWidth1;
  if (n < 3 * kAll) return fit;
  const auto cost_of = [&](const Eigen::VectorXd& r, const Parameters& at, double noise2) {
    return r.squaredNorm() + noise2 * priors.weight.dot((at - priors.value).cwiseAbs2());
  };
  bound(p, radius);
  fit.jacobian.resize(n, kAll);
  double damping = 1e-3;
  for (int iteration = 0; iteration < 40 && !fit.converged; ++iteration) {
    const Eigen::VectorXd value = evaluate(kind, p, radius, fit.pixels, fit.jacobian);
    fit.residuals = fit.pixels.grey - value;
    const double noise2 = std::max(0.1, fit.residuals.squaredNorm() / static_cast<double>(n));
    fit.normal = fit.jacobian.transpose() * fit.jacobian;
    fit.normal.diagonal() += noise2 * priors.weight;
    fit.normal.diagonal().tail(kAll - used).array() += 1;
    const Parameters right =
        fit.jacobian.transpose() * fit.residuals - noise2 * priors.weight.cwiseProduct(p - priors.value);
    const double cost = cost_of(fit.residuals, p, noise2);
    bool better = false;
    for (int trial = 0; trial < 8 && !better; ++trial) {
      Normal damped = fit.normal;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-9;
      Parameters next = p + damped.ldlt().solve(right);
      bound(next, radius);
      const double moved = (next - p).head<2>().norm();
      better = cost_of(fit.pixels.grey - model_at(kind, next, radius, fit.pixels), next, noise2) <= cost;
      if (moved < 1e-5) fit.converged = better = true;
      if (better && next.allFinite()) p = next;
      damping = std::clamp(better ? damping * 0.2 : damping * 8, 1e-9, 1e9);
    }
    if (!better) fit.converged = true;  // no direction leads further down
  }
  fit.p = p;
  return fit;
}

Parameters start_of(const TargetCandidate& c, const Pixels& pixels) {
  Parameters p = Parameters::Zero();
  p[kX] = c.centre.x(), p[kY] = c.centre.y();
  p[kFirst] = c.first, p[kSecond] = c.second;
  p[kBlur] = std::log(1.0), p[kGamma] = 1.8;
  std::vector<double> sorted(pixels.grey.data(), pixels.grey.data() + pixels.grey.size());
  std::sort(sorted.begin(), sorted.end());
  const double dark = sorted[sorted.size() / 8], bright = sorted[sorted.size() - 1 - sorted.size() / 8];
  p[kLow] = c.likeness > 0 ? dark : bright, p[kHigh] = c.likeness > 0 ? bright : dark;
  p[kWidth1] = p[kWidth2] = std::log(std::max(0.5, c.half_width));
  return p;
}

double angle_between(const Parameters& p) {
  const double turn = std::fmod(std::abs(p[kFirst] - p[kSecond]), M_PI);
  return std::min(turn, M_PI - turn);
}

/// Why a fit is no target; empty if it is one.
std::string fault_of(const Fit& fit, const TargetFitOptions& options) {
  const double blur = std::exp(fit.p[kBlur]);
  if (fit.contrast() < options.min_contrast)
    return text_of("its contrast is %.0f grey values, at least %.0f are wanted", fit.contrast(), options.min_contrast);
  if (blur > 0.35 * fit.radius) return text_of("too blurred: %.1f px over the %.0f px that show it", blur, fit.radius);
  if (angle_between(fit.p) < kLeastAngle) return "its two lines run nearly parallel, as those of a bar do";
  if (fit.rms() > kWorstMisfit * fit.contrast())
    return text_of(
        "it differs from a crosshair and from quadrants by %.0f %% of its contrast (at most %.0f %%): "
        "partly covered, dirty, or another thing",
        100 * fit.rms() / fit.contrast(), 100 * kWorstMisfit);
  if (fit.kind == TargetKind::crosshair && std::exp(std::max(fit.p[kWidth1], fit.p[kWidth2])) > 0.6 * fit.radius)
    return "its bars fill what is seen of it";
  return "";
}

/// The ring between two radii looks as the fit foretells.
bool continues(const GreyImage& image, const Fit& fit, double radius) {
  const Pixels pixels = disc(image, fit.p.head<2>(), radius);
  const Eigen::VectorXd r = pixels.grey - model_at(fit.kind, fit.p, fit.radius, pixels);
  double sum = 0, count = 0;
  for (Eigen::Index i = 0; i < r.size(); ++i)
    if ((pixels.at[static_cast<std::size_t>(i)].cast<double>() - fit.p.head<2>()).norm() > fit.radius)
      sum += r[i] * r[i], ++count;
  return count > 0 && std::sqrt(sum / count) < std::max(0.09 * fit.contrast(), 2 * fit.rms());
}

/// Fits at the candidate's size, about the centre that comes out.
Fit fit_candidate(const GreyImage& image, const TargetCandidate& candidate) {
  const double radius = std::max(kSmallestRadius, candidate.radius);
  Fit fit = minimise(image, candidate.kind, start_of(candidate, disc(image, candidate.centre, radius)), radius);
  for (int pass = 0; pass < 3 && fit.converged; ++pass) {
    const Eigen::Vector2d before = fit.p.head<2>();
    fit = minimise(image, candidate.kind, fit.p, radius);
    if ((fit.p.head<2>() - before).norm() < 0.01) break;
  }
  return fit;
}

/// The fit over more of the image, as long as that goes on looking like the target.
Fit grown(const GreyImage& image, Fit fit, const TargetFitOptions& options) {
  while (true) {
    const double wider = std::min(options.max_radius, 1.25 * fit.radius);
    if (wider < fit.radius + 0.5 || reaches_border(image, fit.p.head<2>(), wider + kLags + 1)) return fit;
    if (!continues(image, fit, wider)) return fit;
    Fit next = minimise(image, fit.kind, fit.p, wider);
    if (!next.converged || !fault_of(next, options).empty()) return fit;
    fit = std::move(next);
  }
}

/// Residuals on the grid, nan outside the disc.
struct Grid {
  Eigen::Vector2i corner;
  Eigen::ArrayXXd value;
  Grid(const Pixels& pixels, const Eigen::VectorXd& values) {
    Eigen::Vector2i low = pixels.at.front(), high = low;
    for (const auto& p : pixels.at) low = low.cwiseMin(p), high = high.cwiseMax(p);
    corner = low;
    value = Eigen::ArrayXXd::Constant(high.x() - low.x() + 1, high.y() - low.y() + 1, std::nan(""));
    for (std::size_t i = 0; i < pixels.at.size(); ++i)
      value(pixels.at[i].x() - low.x(), pixels.at[i].y() - low.y()) = values[static_cast<Eigen::Index>(i)];
  }
  double operator()(int x, int y) const {
    x -= corner.x(), y -= corner.y();
    return x < 0 || y < 0 || x >= value.rows() || y >= value.cols() ? std::nan("") : value(x, y);
  }
};

constexpr int kWindow = 2 * kLags + 1;
using Lags = Eigen::Array<double, kWindow, kWindow>;  // by the lag in x and in y, the middle is none

/// Autocovariance of the noise from the odd part of the residuals: r(c + d) − r(c − d), where the second is
/// interpolated between four pixels. White noise n gives C_d = C + C * k with the autocorrelation k of those four
/// weights, and is unfolded from it.
Lags autocovariance(const Fit& fit) {
  const Grid grid(fit.pixels, fit.residuals);
  const Eigen::Vector2d twice = 2 * fit.p.head<2>();
  const Eigen::Vector2d fraction = twice.array() - twice.array().floor();
  Eigen::VectorXd difference = Eigen::VectorXd::Constant(fit.residuals.size(), std::nan(""));
  for (Eigen::Index i = 0; i < difference.size(); ++i) {
    const auto& at = fit.pixels.at[static_cast<std::size_t>(i)];
    const int x = static_cast<int>(std::floor(twice.x())) - at.x(),
              y = static_cast<int>(std::floor(twice.y())) - at.y();
    const double u = fraction.x(), v = fraction.y();
    difference[i] = fit.residuals[i] - ((1 - v) * ((1 - u) * grid(x, y) + u * grid(x + 1, y)) +
                                        v * ((1 - u) * grid(x, y + 1) + u * grid(x + 1, y + 1)));
  }
  const Grid odd(fit.pixels, difference);
  const Grid weight(fit.pixels, fit.jacobian.leftCols<2>().rowwise().norm());
  Lags measured;
  for (int h = -kLags; h <= kLags; ++h)
    for (int k = -kLags; k <= kLags; ++k) {
      double sum = 0, weights = 0;
      for (const auto& p : fit.pixels.at) {
        const double product = odd(p.x(), p.y()) * odd(p.x() + h, p.y() + k);
        if (std::isnan(product)) continue;
        const double w = weight(p.x(), p.y()) * weight(p.x() + h, p.y() + k);
        sum += w * product, weights += w;
      }
      measured(h + kLags, k + kLags) = weights > 0 ? sum / weights : 0;
    }
  const auto interpolation = [](double f, int lag) {
    return lag == 0 ? (1 - f) * (1 - f) + f * f : std::abs(lag) == 1 ? f * (1 - f) : 0.0;
  };
  Lags c = 0.6 * measured;
  for (int iteration = 0; iteration < 40; ++iteration) {
    Lags folded = c;
    for (int h = -kLags; h <= kLags; ++h)
      for (int k = -kLags; k <= kLags; ++k)
        for (int a = -1; a <= 1; ++a)
          for (int b = -1; b <= 1; ++b)
            if (std::abs(h - a) <= kLags && std::abs(k - b) <= kLags)
              folded(h + kLags, k + kLags) +=
                  interpolation(fraction.x(), a) * interpolation(fraction.y(), b) * c(h - a + kLags, k - b + kLags);
    c += 0.6 * (measured - folded);
  }
  c(kLags, kLags) = std::max(c(kLags, kLags), 1.0 / 12);  // of rounding
  return c;
}

/// Covariance of the centre. Noise that is correlated between pixels counts where it makes the centre worse.
Eigen::Matrix2d covariance_of(const Fit& fit) {
  const Lags c = autocovariance(fit);
  const Normal inverse = fit.normal.ldlt().solve(Normal::Identity());
  const Eigen::MatrixXd influence = fit.jacobian * inverse.leftCols<2>();  // of a pixel on the centre
  const Grid by_x(fit.pixels, influence.col(0)), by_y(fit.pixels, influence.col(1));
  Eigen::Matrix2d white = c(kLags, kLags) * influence.transpose() * influence, correlated = Eigen::Matrix2d::Zero();
  for (Eigen::Index i = 0; i < influence.rows(); ++i) {
    const auto& at = fit.pixels.at[static_cast<std::size_t>(i)];
    for (int h = -kLags; h <= kLags; ++h)
      for (int k = -kLags; k <= kLags; ++k) {
        const Eigen::RowVector2d other(by_x(at.x() + h, at.y() + k), by_y(at.x() + h, at.y() + k));
        if (!std::isnan(other.x())) correlated += c(h + kLags, k + kLags) * influence.row(i).transpose() * other;
      }
  }
  const Eigen::Matrix2d root = white.llt().matrixL(), inverse_root = root.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> ratio(
      inverse_root * 0.5 * (correlated + correlated.transpose()) * inverse_root.transpose());
  return root * ratio.eigenvectors() * ratio.eigenvalues().cwiseMax(1).asDiagonal() * ratio.eigenvectors().transpose() *
         root.transpose();
}

struct Choice {
  std::optional<Fit> best;
  std::string problem;
};

Choice choose(const GreyImage& image, const Eigen::Vector2d& predicted, const TargetSearch& search,
              const TargetFitOptions& options) {
  Choice choice;
  std::vector<Fit> sound;
  for (const TargetCandidate& candidate : search.candidates) {
    const Fit fit = fit_candidate(image, candidate);
    const double away = (fit.p.head<2>() - predicted).norm();
    const std::string fault = !fit.converged          ? "its fit does not converge"
                              : away > options.search ? text_of(
                                                            "it is %.1f px off the prediction, and "
                                                            "search is %.1f px",
                                                            away, options.search)
                                                      : fault_of(fit, options);
    if (!fault.empty() && choice.problem.empty()) choice.problem = "what is most like a target there is none: " + fault;
    if (fault.empty()) sound.push_back(fit);
  }
  if (sound.empty()) return choice;
  const auto quality = [](const Fit& fit) { return fit.rms() / (fit.contrast() * fit.radius); };
  choice.best = grown(image,
                      *std::min_element(sound.begin(), sound.end(),
                                        [&](const Fit& a, const Fit& b) { return quality(a) < quality(b); }),
                      options);
  for (const Fit& fit : sound) {
    // What lies within the best one is explained by it.
    const double apart = (fit.p.head<2>() - choice.best->p.head<2>()).norm();
    if (apart < std::max(2.0, choice.best->radius)) continue;
    choice.problem = text_of(
        "two targets lie within %.1f px of the prediction, %.1f px apart; a smaller search tells "
        "which is meant",
        options.search, apart);
    choice.best.reset();
    break;
  }
  return choice;
}

}  // namespace

MeasuredTarget measure_target(const GreyImage& image, const Eigen::Vector2d& predicted,
                              const TargetFitOptions& options) {
  MeasuredTarget target;
  if (!predicted.allFinite() || reaches_border(image, predicted, kSmallestRadius + 1)) {
    target.problem = "the prediction lies outside the photograph or within 6 px of its border";
    return target;
  }
  const TargetSearch search = search_targets(image, predicted, options);
  if (search.candidates.empty()) {
    target.problem = search.contrast_seen
                         ? "nothing there looks like a crosshair or like quadrants"
                         : text_of("nothing there has a contrast of %.0f grey values", options.min_contrast);
    return target;
  }
  const Choice choice = choose(image, predicted, search, options);
  target.problem = choice.best ? "" : choice.problem;
  if (!choice.best) return target;
  const Fit& fit = *choice.best;
  target.kind = fit.kind, target.centre = fit.p.head<2>(), target.radius = fit.radius;
  target.blur = std::exp(fit.p[kBlur]), target.misfit = fit.rms() / fit.contrast();
  target.covariance = covariance_of(fit) + Eigen::Matrix2d::Identity() * options.sigma_floor * options.sigma_floor;
  if (!(target.covariance.trace() < 0.5))
    target.problem = text_of("its centre is uncertain by %.1f px", std::sqrt(0.5 * target.covariance.trace()));
  return target;
}

}  // namespace plumbline::detect
