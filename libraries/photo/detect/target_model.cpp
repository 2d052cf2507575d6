#include "photo/detect/target_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "photo/images/grey_image.hpp"

namespace plumbline::detect {

using namespace target;

namespace {

/// Grey values of a target at parameters `p`: low and high [grey values], blur as its logarithm, widths of the bars as
/// logarithms of half of them, shading as a share of the light at the rim, gamma as in EdgeFitOptions.
class Model {
 public:
  Model(TargetKind kind, const TargetParameters& p, double radius)
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
  TargetParameters p_;
  double radius_, offset_, scale_ = 0, low_ = 0, high_ = 0;
  std::array<double, 2> sin_{}, cos_{}, width_{};
};

/// What is known without the image: blur of a focused lens, a curve between linear and sRGB, even light.
struct Priors {
  TargetParameters value = TargetParameters::Zero(), weight = TargetParameters::Zero();
  Priors() {
    const auto set = [&](Eigen::Index k, double v, double sigma) { value[k] = v, weight[k] = 1 / (sigma * sigma); };
    set(kBlur, std::log(0.8), 1), set(kGamma, 1.8, 0.8), set(kShadeX, 0, 0.3), set(kShadeY, 0, 0.3);
  }
};

/// The model's grey values with the derivatives; that by gamma, which all of the curve hangs on, as a difference.
Eigen::VectorXd evaluate(TargetKind kind, const TargetParameters& p, double radius, const TargetPixels& pixels,
                         Eigen::MatrixXd& jacobian) {
  constexpr double step = 1e-5;
  TargetParameters next = p;
  next[kGamma] += step;
  const Model model(kind, p, radius), other(kind, next, radius);
  Eigen::VectorXd grey(pixels.grey.size());
  TargetParameters slopes;
  for (Eigen::Index i = 0; i < grey.size(); ++i) {
    const auto& at = pixels.at[i];
    grey[i] = model(at.x(), at.y(), slopes.data());
    slopes[kGamma] = (other(at.x(), at.y()) - grey[i]) / step;
    jacobian.row(i) = slopes.transpose();
  }
  return grey;
}

void bound(TargetParameters& p, double radius) {
  p[kBlur] = std::clamp(p[kBlur], std::log(0.2), std::log(0.5 * radius));
  p[kGamma] = std::clamp(p[kGamma], 1.0, 3.0);
  for (const auto k : {kLow, kHigh}) p[k] = std::clamp(p[k], 0.0, 400.0);
  for (const auto k : {kShadeX, kShadeY}) p[k] = std::clamp(p[k], -0.6, 0.6);
  for (const auto k : {kWidth1, kWidth2}) p[k] = std::clamp(p[k], std::log(0.3), std::log(radius));
}

}  // namespace

TargetPixels disc(const GreyImage& image, const Eigen::Vector2d& centre, double radius) {
  TargetPixels pixels;
  std::vector<double> grey;
  for (int y = static_cast<int>(std::ceil(centre.y() - radius)); y <= centre.y() + radius; ++y)
    for (int x = static_cast<int>(std::ceil(centre.x() - radius)); x <= centre.x() + radius; ++x) {
      if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
      if ((Eigen::Vector2d(x, y) - centre).norm() > radius) continue;
      pixels.at.emplace_back(x, y);
      grey.push_back(image.pixels[static_cast<std::size_t>(y) * image.width + x]);
    }
  pixels.grey = Eigen::Map<Eigen::VectorXd>(grey.data(), static_cast<Eigen::Index>(grey.size()));
  return pixels;
}

Eigen::VectorXd model_at(TargetKind kind, const TargetParameters& p, double radius, const TargetPixels& pixels) {
  const Model model(kind, p, radius);
  Eigen::VectorXd grey(pixels.grey.size());
  for (Eigen::Index i = 0; i < grey.size(); ++i) {
    const auto& at = pixels.at[i];
    grey[i] = model(at.x(), at.y());
  }
  return grey;
}

TargetFit minimise(const GreyImage& image, TargetKind kind, TargetParameters p, double radius) {
  static const Priors priors;
  TargetFit fit;
  fit.kind = kind, fit.radius = radius;
  fit.pixels = disc(image, p.head<2>(), radius);
  const Eigen::Index n = fit.pixels.grey.size(), used = kind == TargetKind::crosshair ? kAll : kWidth1;
  if (n < 3 * kAll) return fit;
  const auto cost_of = [&](const Eigen::VectorXd& r, const TargetParameters& at, double noise2) {
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
    const TargetParameters right =
        fit.jacobian.transpose() * fit.residuals - noise2 * priors.weight.cwiseProduct(p - priors.value);
    const double cost = cost_of(fit.residuals, p, noise2);
    bool better = false;
    for (int trial = 0; trial < 8 && !better; ++trial) {
      TargetNormal damped = fit.normal;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-9;
      TargetParameters next = p + damped.ldlt().solve(right);
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

}  // namespace plumbline::detect
