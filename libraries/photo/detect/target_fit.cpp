#include "photo/detect/target_fit.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "photo/detect/target_covariance.hpp"
#include "photo/detect/target_model.hpp"
#include "photo/detect/target_search.hpp"
#include "photo/images/grey_image.hpp"

namespace plumbline::detect {

using namespace target;

namespace {

constexpr double kSmallestRadius = 5;  // [px]
constexpr double kWorstMisfit = 0.12;  // of the contrast
constexpr double kLeastAngle = 0.4;    // between the two lines [rad]

bool reaches_border(const GreyImage& image, const Eigen::Vector2d& centre, double radius) {
  return centre.x() < radius || centre.y() < radius || centre.x() > image.width - 1 - radius ||
         centre.y() > image.height - 1 - radius;
}

TargetParameters start_of(const TargetCandidate& c, const TargetPixels& pixels) {
  TargetParameters p = TargetParameters::Zero();
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

double angle_between(const TargetParameters& p) {
  const double turn = std::fmod(std::abs(p[kFirst] - p[kSecond]), M_PI);
  return std::min(turn, M_PI - turn);
}

/// Why a fit is no target; empty if it is one.
std::string fault_of(const TargetFit& fit, const TargetFitOptions& options) {
  const double blur = std::exp(fit.p[kBlur]);
  if (fit.contrast() < options.min_contrast)
    return fmt::format("its contrast is {:.0f} grey values, at least {:.0f} are wanted", fit.contrast(),
                       options.min_contrast);
  if (blur > 0.35 * fit.radius)
    return fmt::format("too blurred: {:.1f} px over the {:.0f} px that show it", blur, fit.radius);
  if (angle_between(fit.p) < kLeastAngle) return "its two lines run nearly parallel, as those of a bar do";
  if (fit.rms() > kWorstMisfit * fit.contrast())
    return fmt::format(
        "it differs from a crosshair and from quadrants by {:.0f} % of its contrast (at most {:.0f} %): partly "
        "covered, dirty, or another thing",
        100 * fit.rms() / fit.contrast(), 100 * kWorstMisfit);
  if (fit.kind == TargetKind::crosshair && std::exp(std::max(fit.p[kWidth1], fit.p[kWidth2])) > 0.6 * fit.radius)
    return "its bars fill what is seen of it";
  return "";
}

/// The ring between two radii looks as the fit foretells.
bool continues(const GreyImage& image, const TargetFit& fit, double radius) {
  const TargetPixels pixels = disc(image, fit.p.head<2>(), radius);
  const Eigen::VectorXd r = pixels.grey - model_at(fit.kind, fit.p, fit.radius, pixels);
  double sum = 0, count = 0;
  for (Eigen::Index i = 0; i < r.size(); ++i)
    if ((pixels.at[i].cast<double>() - fit.p.head<2>()).norm() > fit.radius) sum += r[i] * r[i], ++count;
  return count > 0 && std::sqrt(sum / count) < std::max(0.09 * fit.contrast(), 2 * fit.rms());
}

/// Fits at the candidate's size, about the centre that comes out.
TargetFit fit_candidate(const GreyImage& image, const TargetCandidate& candidate) {
  const double radius = std::max(kSmallestRadius, candidate.radius);
  TargetFit fit = minimise(image, candidate.kind, start_of(candidate, disc(image, candidate.centre, radius)), radius);
  for (int pass = 0; pass < 3 && fit.converged; ++pass) {
    const Eigen::Vector2d before = fit.p.head<2>();
    fit = minimise(image, candidate.kind, fit.p, radius);
    if ((fit.p.head<2>() - before).norm() < 0.01) break;
  }
  return fit;
}

/// The fit over more of the image, as long as that goes on looking like the target.
TargetFit grown(const GreyImage& image, TargetFit fit, const TargetFitOptions& options) {
  while (true) {
    const double wider = std::min(options.max_radius, 1.25 * fit.radius);
    if (wider < fit.radius + 0.5 || reaches_border(image, fit.p.head<2>(), wider + kTargetLags + 1)) return fit;
    if (!continues(image, fit, wider)) return fit;
    TargetFit next = minimise(image, fit.kind, fit.p, wider);
    if (!next.converged || !fault_of(next, options).empty()) return fit;
    fit = std::move(next);
  }
}

struct Choice {
  std::optional<TargetFit> best;
  std::string problem;
};

Choice choose(const GreyImage& image, const Eigen::Vector2d& predicted, const TargetSearch& search,
              const TargetFitOptions& options) {
  Choice choice;
  std::vector<TargetFit> sound;
  for (const TargetCandidate& candidate : search.candidates) {
    const TargetFit fit = fit_candidate(image, candidate);
    const double away = (fit.p.head<2>() - predicted).norm();
    const std::string fault =
        !fit.converged ? "its fit does not converge"
        : away > options.search
            ? fmt::format("it is {:.1f} px off the prediction, and search is {:.1f} px", away, options.search)
            : fault_of(fit, options);
    if (!fault.empty() && choice.problem.empty()) choice.problem = "what is most like a target there is none: " + fault;
    if (fault.empty()) sound.push_back(fit);
  }
  if (sound.empty()) return choice;
  const auto quality = [](const TargetFit& fit) { return fit.rms() / (fit.contrast() * fit.radius); };
  choice.best =
      grown(image,
            *std::min_element(sound.begin(), sound.end(),
                              [&](const TargetFit& a, const TargetFit& b) { return quality(a) < quality(b); }),
            options);
  for (const TargetFit& fit : sound) {
    // What lies within the best one is explained by it.
    const double apart = (fit.p.head<2>() - choice.best->p.head<2>()).norm();
    if (apart < std::max(2.0, choice.best->radius)) continue;
    choice.problem = fmt::format(
        "two targets lie within {:.1f} px of the prediction, {:.1f} px apart; a smaller search tells which is meant",
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
                         : fmt::format("nothing there has a contrast of {:.0f} grey values", options.min_contrast);
    return target;
  }
  const Choice choice = choose(image, predicted, search, options);
  target.problem = choice.best ? "" : choice.problem;
  if (!choice.best) return target;
  const TargetFit& fit = *choice.best;
  target.kind = fit.kind, target.centre = fit.p.head<2>(), target.radius = fit.radius;
  target.blur = std::exp(fit.p[kBlur]), target.misfit = fit.rms() / fit.contrast();
  target.covariance = centre_covariance(fit) + Eigen::Matrix2d::Identity() * options.sigma_floor * options.sigma_floor;
  if (!(target.covariance.trace() < 0.5))
    target.problem = fmt::format("its centre is uncertain by {:.1f} px", std::sqrt(0.5 * target.covariance.trace()));
  return target;
}

}  // namespace plumbline::detect
