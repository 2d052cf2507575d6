// Flatness, bow, twist and offset of one panel against a limit.
#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "building/judgement/conformance.hpp"
#include "building/judgement/surface_verdict.hpp"
#include "building/judgement/tolerance.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {
namespace {

class PanelVerdict {
 public:
  PanelVerdict(const SurfacesT& surfaces, double risk) : surfaces_(surfaces), risk_(risk) {}

  void judge(const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    if (limit.quantity == SurfaceQuantity::flatness)
      flatness(panel, limit, verdict);
    else if (limit.quantity == SurfaceQuantity::offset)
      stands_out(panel, limit, verdict);
    else
      bend(panel, limit, verdict);
    if (verdict.verdict == ToleranceVerdict::pass && panel.coverage < kSeenEnough) {
      verdict.verdict = ToleranceVerdict::not_measured;
      verdict.not_judged = half_seen(panel);
    }
  }

 private:
  static std::string apart(const PanelSurfaceFiguresT& panel) {
    return fmt::format("they are {:.0f} mm apart, and with 'cell' of surface.panels = {:.0f} mm all cells have points",
                       1e3 * panel.spacing, 1e3 * panel.covering_cell);
  }
  static std::string half_seen(const PanelSurfaceFiguresT& panel) {
    if (std::isfinite(panel.covering_cell))
      return fmt::format("its limit is kept where points are, and they cover {:.0f} % of its cells: {}",
                         100 * panel.coverage, apart(panel));
    return fmt::format("its limit is kept where points are, and they cover {:.0f} % of it: what the rest is nobody saw",
                       100 * panel.coverage);
  }

  void flatness(const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    const auto gap = std::find_if(panel.flatness.begin(), panel.flatness.end(),
                                  [&](const auto& g) { return std::abs(g->length - limit.length) < 1e-6; });
    if (gap == panel.flatness.end()) {
      verdict.not_judged = "no straightedge of that length was laid; add it to 'straightedges' of surface.panels";
    } else if ((*gap)->positions == 0 || !std::isfinite((*gap)->gap)) {
      verdict.not_judged = std::isfinite(panel.covering_cell)
                               ? fmt::format("no straightedge of that length has points all along it: {}", apart(panel))
                               : "the panel has no place for a straightedge of that length with points all along it";
    } else {
      verdict.value = (*gap)->gap, verdict.sigma = (*gap)->sigma;
      verdict.probability = limit_probability(verdict.value, verdict.sigma, limit);
      // The largest of many noisy gaps is above the true one by up to the largest that noise makes by itself, whose
      // distribution is an extreme value's (Gumbel); without it the risk is shared among the positions.
      const double noise = (*gap)->noise_mean + gumbel_quantile() * (*gap)->noise_sigma;
      const bool beyond =
          std::isfinite(noise) ? verdict.value - limit.upper > noise : verdict.probability <= risk_ / (*gap)->positions;
      decide(verdict, verdict.probability, beyond ? 0 : 1, risk_, risk_);
      if (verdict.verdict == ToleranceVerdict::pass && std::isfinite((*gap)->with_outlying))
        doubt(**gap, limit, verdict);
      if (verdict.verdict == ToleranceVerdict::pass && verdict.value + panel.hidden > limit.upper)
        verdict.verdict = ToleranceVerdict::not_measured, verdict.not_judged = hidden_in(panel);
    }
  }

  static std::string hidden_in(const PanelSurfaceFiguresT& panel) {
    return fmt::format(
        "its limit is kept by the means of cells of {:.0f} mm, and within one its points scatter beyond their noise, "
        "or some lie behind the surface together, as on waves of {:.1f} mm from valley to crest: grooves, a dent or a "
        "corrugation smaller than the cells, or noise "
        "that neighbouring points share or that is larger than stated; with a smaller 'cell' of surface.panels it "
        "shows",
        1e3 * panel.cell, 1e3 * panel.hidden);
  }

  /// A dent that is deep beside the noise looks like something in front of the panel: it does not pass by being left
  /// out.
  void doubt(const SurfaceGapT& gap, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    if (verdict_of(limit_probability(gap.with_outlying, gap.sigma, limit), risk_) == ToleranceVerdict::pass) return;
    const std::string text = fmt::format(
        "places on it lie off the surface together, a dent or something in front of it: the largest gap is {:.1f} mm "
        "without them and {:.1f} mm with them",
        1e3 * gap.gap, 1e3 * gap.with_outlying);
    verdict.verdict = ToleranceVerdict::not_measured, verdict.not_judged = text;
  }

  /// Of the probability 1 - risk, in standard deviations from the mean.
  double gumbel_quantile() const {
    constexpr double euler = 0.5772156649015329;
    return -std::sqrt(6.0) / M_PI * (euler + std::log(-std::log(1 - risk_)));
  }

  /// Both bows at once, or the twist, from the covariance of the panel's form.
  void bend(const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    Eigen::MatrixXd covariance = unpack_symmetric(panel.coefficients_random, 6, "panel '" + panel.face->id + "'");
    if (covariance.size() == 0 || panel.coefficients_factor.size() != 6 * static_cast<size_t>(surfaces_.rank))
      throw std::runtime_error("the figures of panel '" + panel.face->id + "' lack their covariance");
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> factor(
        panel.coefficients_factor.data(), 6, surfaces_.rank);
    covariance += factor * factor.transpose();
    const bool twist = limit.quantity == SurfaceQuantity::twist;
    const Eigen::VectorXd form = twist ? Eigen::VectorXd(panel.form.tail<1>()) : Eigen::VectorXd(panel.form.head<2>());
    const Eigen::MatrixXd own =
        twist ? Eigen::MatrixXd(covariance.block(5, 5, 1, 1)) : Eigen::MatrixXd(covariance.block(3, 3, 2, 2));
    std::vector<Limited> quantities;
    for (Eigen::Index i = 0; i < form.size(); ++i) {
      Limited one;
      one.rows = Eigen::MatrixXd::Identity(form.size(), form.size()).row(i), one.above = one.below = limit.upper;
      quantities.push_back(one);
    }
    Eigen::Index larger = 0;
    form.cwiseAbs().maxCoeff(&larger);
    verdict.value = form(larger), verdict.sigma = std::sqrt(own(larger, larger));
    verdict.probability = conformance(form, own, quantities, risk_, limit.upper).probability;
    decide(verdict, verdict.probability, verdict.probability, risk_, risk_);
  }

  /// The four corners of the best plane at once, by its covariance with what the whole measurement's place is off by.
  void stands_out(const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    if (surfaces_.rank == 0) {
      verdict.not_judged =
          "nobody said how well the place of the points as a whole is known: a scan needs a 'registration' or "
          "'place_sigma', photographs the joint covariance of their orientations";
      return;
    }
    const Eigen::MatrixXd covariance = unpack_symmetric(panel.covariance, 3, "panel '" + panel.face->id + "'");
    if (covariance.size() == 0)
      throw std::runtime_error("the figures of panel '" + panel.face->id + "' lack their covariance");
    const Eigen::Vector3d plane(panel.offset, panel.tilt.x(), panel.tilt.y());
    std::vector<Limited> corners;
    double least = std::numeric_limits<double>::infinity();
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5}) {
        const Eigen::RowVector3d row(1, x * panel.face->width, y * panel.face->height);
        corners.push_back({row, limit.upper, -limit.lower});
        const double value = row.dot(plane), sigma = std::sqrt((row * covariance * row.transpose())(0));
        const double probability = limit_probability(value, sigma, limit);
        // Where all are as sure, the furthest.
        if (probability > least || (probability == least && std::abs(value) <= std::abs(verdict.value))) continue;
        least = probability, verdict.value = value, verdict.sigma = sigma;
      }
    verdict.probability = conformance(plane, covariance, corners, risk_, limit.upper).probability;
    decide(verdict, verdict.probability, verdict.probability, risk_, risk_);
  }

  const SurfacesT& surfaces_;
  double risk_;
};

}  // namespace

void judge_panel(const SurfacesT& surfaces, const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, double risk,
                 SurfaceVerdictT& verdict) {
  PanelVerdict(surfaces, risk).judge(panel, limit, verdict);
}

}  // namespace plumbline::judgement
