#include "photo/markers/two_groups.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "geometry/median.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

constexpr double impossible = -std::numeric_limits<double>::infinity();

struct Mixture {
  Eigen::ArrayXd of_second;  ///< probability of each value to be of the second group
  Eigen::ArrayXd variance;
  double first = 0, second = 0;        ///< means
  double log_likelihood = impossible;  ///< without what is the same for all
};

double about_one_mean(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variance) {
  const double mean = (values / variance).sum() / variance.inverse().sum();
  return -0.5 * ((values - mean).square() / variance + variance.log()).sum();
}

/// From groups to begin with, `of_second` 0 or 1.
Mixture about_two_means(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variance, Eigen::ArrayXd of_second) {
  constexpr int rounds = 25;
  constexpr double rarest = 1e-3;
  Mixture mixture;
  for (int round = 0; round < rounds; ++round) {
    const Eigen::ArrayXd weight = of_second / variance, other = (1 - of_second) / variance;
    if (!(weight.sum() > 0) || !(other.sum() > 0)) return {};
    const double part = std::clamp(of_second.mean(), rarest, 1 - rarest);
    mixture.first = (other * values).sum() / other.sum(), mixture.second = (weight * values).sum() / weight.sum();
    const Eigen::ArrayXd first = std::log(1 - part) - 0.5 * (values - mixture.first).square() / variance;
    const Eigen::ArrayXd second = std::log(part) - 0.5 * (values - mixture.second).square() / variance;
    const Eigen::ArrayXd larger = first.max(second);
    const Eigen::ArrayXd both = larger + ((first - larger).exp() + (second - larger).exp()).log();
    of_second = (second - both).exp();
    mixture.log_likelihood = (both - 0.5 * variance.log()).sum();
  }
  mixture.of_second = of_second, mixture.variance = variance;
  return mixture;
}

/// The likeliest of mixtures that begin with the lowest quarter, half and three quarters as one group.
Mixture likeliest(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variance, const std::vector<int>& order) {
  Mixture best;
  for (const double part : {0.25, 0.5, 0.75}) {
    const auto n = static_cast<double>(values.size());
    const auto cut = static_cast<std::size_t>(std::clamp(std::round(part * n), 2.0, n - 2));
    Eigen::ArrayXd of_second = Eigen::ArrayXd::Zero(values.size());
    for (std::size_t k = cut; k < order.size(); ++k) of_second(order[k]) = 1;
    const Mixture one = about_two_means(values, variance, of_second);
    if (one.log_likelihood > best.log_likelihood) best = one;
  }
  return best;
}

std::optional<TwoGroups> told_apart(const Mixture& best, double log_odds) {
  constexpr double told_from = 5, apart = 4, clear = 0.9, most = 0.75;
  constexpr std::ptrdiff_t smallest = 3;
  const Eigen::ArrayXd sigma = best.variance.sqrt();
  std::vector<double> sigmas(sigma.begin(), sigma.end());
  if (!(log_odds > told_from) || !(std::abs(best.second - best.first) > apart * upper_median(sigmas)))
    return std::nullopt;
  const auto told = (best.of_second > clear || best.of_second < 1 - clear).count();
  const auto count = (best.of_second > 0.5).count(), others = best.of_second.size() - count;
  if (static_cast<double>(told) < most * static_cast<double>(best.of_second.size()) ||
      std::min(count, others) < smallest)
    return std::nullopt;
  TwoGroups groups;
  const bool second = count <= others;
  for (Eigen::Index i = 0; i < best.of_second.size(); ++i)
    if ((best.of_second(i) > 0.5) == second) groups.second.push_back(static_cast<int>(i));
  groups.by = (second ? 1 : -1) * (best.second - best.first), groups.log_odds = log_odds;
  groups.sigma =
      std::sqrt(1 / (best.of_second / best.variance).sum() + 1 / ((1 - best.of_second) / best.variance).sum());
  return groups;
}

}  // namespace

std::optional<TwoGroups> two_groups(const Eigen::VectorXd& values, const Eigen::VectorXd& sigmas) {
  constexpr int fewest = 8;
  const Eigen::ArrayXd x = values.array(), s = sigmas.array();
  const double spread = std::sqrt((x - x.mean()).square().mean());
  if (x.size() < fewest || !x.isFinite().all() || !s.isFinite().all() || !(s > 0).all() || !(spread > 0))
    return std::nullopt;
  std::vector<int> order(static_cast<std::size_t>(x.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return x(a) < x(b); });
  double one = impossible;
  Mixture two;
  for (const double multiple : {0.25, 0.35, 0.5, 0.7, 1.0, 1.4})
    for (const double own : {0.0, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.4}) {
      stop_point();
      const Eigen::ArrayXd variance = (multiple * s).square() + std::pow(own * spread, 2);
      one = std::max(one, about_one_mean(x, variance));
      const Mixture mixture = likeliest(x, variance, order);
      if (mixture.log_likelihood > two.log_likelihood) two = mixture;
    }
  if (two.of_second.size() == 0) return std::nullopt;
  return told_apart(two, two.log_likelihood - one - std::log(static_cast<double>(x.size())));
}

}  // namespace plumbline::markers
