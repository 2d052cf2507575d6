#include "building/judgement/epoch_movements.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/median.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::judgement {
namespace {

/// Error of the first kind of all movements together.
constexpr double kAlpha = 0.05;

double statistic_of(const Eigen::Vector3d& d, const Eigen::Matrix3d& covariance) {
  const Eigen::LLT<Eigen::Matrix3d> llt(covariance);
  if (!covariance.allFinite() || llt.info() != Eigen::Success) return std::numeric_limits<double>::quiet_NaN();
  return d.dot(llt.solve(d));
}

Eigen::Vector3d median_of(const std::vector<MeasuredTwice>& pairs) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const MeasuredTwice& pair : pairs) values.push_back(pair.d[axis]);
    median[axis] = upper_median(std::move(values));
  }
  return median;
}

std::ptrdiff_t moving(const std::vector<MeasuredTwice>& pairs, const Eigen::Vector3d& together, double critical) {
  return std::count_if(pairs.begin(), pairs.end(), [&](const MeasuredTwice& pair) {
    return statistic_of(pair.d - together, pair.covariance) > critical;
  });
}

std::string shift_in_words(const Eigen::Vector3d& d) {
  return fmt::format("{:+.1f}, {:+.1f}, {:+.1f} mm (x, y, z)", 1e3 * d.x(), 1e3 * d.y(), 1e3 * d.z());
}

}  // namespace

void test_movements(const std::vector<MeasuredTwice>& pairs, AsBuiltChangesT& out) {
  out.measured_twice = static_cast<int>(pairs.size());
  out.together = Eigen::Vector3d::Zero();
  if (pairs.empty()) return;
  const auto n = static_cast<double>(pairs.size());
  out.critical = chi_squared_quantile(1 - kAlpha / n, 3);
  const Eigen::Vector3d median = median_of(pairs);
  const auto alone = moving(pairs, Eigen::Vector3d::Zero(), out.critical);
  const auto alike = std::count_if(pairs.begin(), pairs.end(), [&](const MeasuredTwice& pair) {
    return statistic_of(pair.d, pair.covariance) > out.critical &&
           !(statistic_of(pair.d - median, pair.covariance) > out.critical);
  });
  // A shift common to nearly all says something of the frame and nothing of the anchors.
  if (pairs.size() >= 4 && 2 * static_cast<double>(alone) > n &&
      10 * static_cast<double>(moving(pairs, median, out.critical)) <= n) {
    out.together = median;
    out.warnings.push_back(
        std::to_string(alike) + " of " + std::to_string(pairs.size()) + " anchors seem to have moved by the same, " +
        shift_in_words(median) +
        ": rather the control or the frame differs between the campaigns than the building; movements "
        "are given without it");
  }
  std::size_t unknown = 0;
  for (const MeasuredTwice& pair : pairs) {
    const Eigen::Vector3d d = pair.d - out.together;
    pair.change->movement = d, pair.change->statistic = statistic_of(d, pair.covariance);
    pair.change->moved = pair.change->statistic > out.critical;
    unknown += std::isnan(pair.change->statistic);
    if (d.norm() > 0) pair.change->u = std::sqrt(d.dot(pair.covariance * d)) / d.norm();
  }
  if (unknown > 0)
    out.warnings.push_back("whether " + std::to_string(unknown) +
                           " anchors have moved is not tested: their covariance is not known in both campaigns");
}

}  // namespace plumbline::judgement
