#include "building/judgement/check_anchors.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/statistics.hpp"

namespace plumbline::judgement {

namespace {

constexpr double kLevel = 0.999;

/// dᵀ Σ⁻¹ d of the survey difference; nan where it is not known.
double nees_of(const AnchorAccuracyT& anchor) {
  if (!anchor.survey || anchor.survey->covariance.size() != 9) return std::nan("");
  const Eigen::Vector3d d(anchor.survey->dx, anchor.survey->dy, anchor.survey->dz);
  const Eigen::Matrix3d covariance = Eigen::Map<const Eigen::Matrix3d>(anchor.survey->covariance.data());
  return d.dot(covariance.ldlt().solve(d));
}

}  // namespace

std::vector<const AnchorAccuracyT*> contradicting_checks(const AccuracyT& accuracy) {
  std::vector<const AnchorAccuracyT*> checks, wrong;
  for (const auto& anchor : accuracy.anchors)
    if (anchor->use == AnchorUse::check && std::isfinite(nees_of(*anchor))) checks.push_back(anchor.get());
  if (checks.empty()) return wrong;
  const double limit = chi_squared_quantile(std::pow(kLevel, 1 / static_cast<double>(checks.size())), 3);
  std::copy_if(checks.begin(), checks.end(), std::back_inserter(wrong),
               [&](const AnchorAccuracyT* anchor) { return nees_of(*anchor) > limit; });
  return wrong;
}

std::vector<std::string> words_of_contradicting(const AccuracyT& accuracy) {
  const auto checks = std::count_if(accuracy.anchors.begin(), accuracy.anchors.end(), [](const auto& anchor) {
    return anchor->use == AnchorUse::check && anchor->survey;
  });
  const std::vector<const AnchorAccuracyT*> wrong = contradicting_checks(accuracy);
  std::vector<std::string> words;
  if (3 * static_cast<std::ptrdiff_t>(wrong.size()) > checks) return words;
  for (const AnchorAccuracyT* anchor : wrong)
    words.push_back(fmt::format(
        "The check anchor {} contradicts the model: it is off by {:.1f} mm, {:.1f} mm, {:.1f} mm, {:.0f} times "
        "what the uncertainties of model and survey allow (1 sigma). Check its survey, its name and its "
        "plate.",
        anchor->id, 1e3 * anchor->survey->dx, 1e3 * anchor->survey->dy, 1e3 * anchor->survey->dz,
        std::sqrt(nees_of(*anchor) / 3)));
  return words;
}

bool check_anchors_hold(const AccuracyT& accuracy) {
  if (!contradicting_checks(accuracy).empty()) return false;
  return std::none_of(accuracy.comparisons.begin(), accuracy.comparisons.end(), [](const auto& comparison) {
    const ErrorConsistencyT* test = comparison->consistency_3d.get();
    return comparison->evidence && comparison->reference == AccuracyReference::survey && test &&
           test->statistic > chi_squared_quantile(kLevel, test->degrees_of_freedom);
  });
}

}  // namespace plumbline::judgement
