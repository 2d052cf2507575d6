#include "building/judgement/drift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "building/judgement/figures.hpp"
#include "building/judgement/tolerance.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::judgement {

namespace {

/// Of the differences of a set; most are zero.
using Weights = Eigen::SparseVector<double>;

/// A linear function of the vertical residuals: its value and standard uncertainty.
struct Linear {
  double value = nan, u = nan;
};

Linear apply(const Weights& weights, const Eigen::VectorXd& dz, const BlockCovariance& covariance) {
  Linear result{weights.dot(dz), nan};
  if (covariance.size() != 0) result.u = std::sqrt(std::max(0.0, covariance.quadratic(weights)));
  return result;
}

/// Weights that average the anchors of a floor, or those of a column on a floor; none where there are no anchors.
class Means {
 public:
  Means(const DifferenceSet& set, const std::vector<AnchorEntry>& table)
      : size_(static_cast<Eigen::Index>(set.size())) {
    for (std::size_t i = 0; i < set.size(); ++i) {
      const AnchorEntry& anchor = table[set.anchors[i]];
      floors_[anchor.floor].push_back(static_cast<Eigen::Index>(i));
      columns_[{anchor.floor, anchor.column}].push_back(static_cast<Eigen::Index>(i));
    }
  }
  Weights of_floor(int floor) const {
    const auto found = floors_.find(floor);
    return found == floors_.end() ? Weights(size_) : mean_of(found->second);
  }
  Weights of_column(int floor, int column) const {
    const auto found = columns_.find({floor, column});
    return found == columns_.end() ? Weights(size_) : mean_of(found->second);
  }

 private:
  Weights mean_of(const std::vector<Eigen::Index>& members) const {
    Weights weights(size_);
    weights.reserve(static_cast<Eigen::Index>(members.size()));
    for (const Eigen::Index i : members) weights.insertBack(i) = 1 / static_cast<double>(members.size());
    return weights;
  }

  Eigen::Index size_;
  std::map<int, std::vector<Eigen::Index>> floors_;
  std::map<std::pair<int, int>, std::vector<Eigen::Index>> columns_;
};

bool none(const Weights& weights) { return weights.nonZeros() == 0; }

/// Numbers of the vertical marker columns, ascending.
std::set<int> columns_of(const std::vector<AnchorEntry>& table) {
  std::set<int> columns;
  for (const AnchorEntry& anchor : table)
    if (anchor.column > 0) columns.insert(anchor.column);
  return columns;
}

int count_of(const Weights& weights) { return static_cast<int>(weights.nonZeros()); }

void fill_floor_statistics(const Eigen::VectorXd& dz, const Weights& weights, FloorAccuracyT& floor) {
  floor.rmse_z = std::sqrt(weights.dot(dz.cwiseAbs2()));
  floor.max_abs_dz = 0;
  for (Weights::InnerIterator w(weights); w; ++w)
    floor.max_abs_dz = std::max(floor.max_abs_dz, std::abs(dz[w.index()]));
}

/// Floors in ascending order, each with the weights of its mean.
using FloorWeights = std::vector<std::pair<double, Weights>>;

/// Unweighted straight line through means over their floors; null with fewer than two.
std::unique_ptr<DriftSlopeT> slope_through(const FloorWeights& means, const Eigen::VectorXd& dz,
                                           const BlockCovariance& covariance, double confidence) {
  if (means.size() < 2) return nullptr;
  const auto n = static_cast<double>(means.size());
  double centre = 0;
  for (const auto& [floor, weights] : means) centre += floor;
  centre /= n;
  double squares = 0;
  for (const auto& [floor, weights] : means) squares += (floor - centre) * (floor - centre);
  Weights slope_weights(dz.size());
  double level = 0;
  for (const auto& [floor, weights] : means) {
    slope_weights += (floor - centre) / squares * weights;
    level += weights.dot(dz) / n;
  }
  const Linear slope = apply(slope_weights, dz, covariance);
  auto result = std::make_unique<DriftSlopeT>();
  result->per_floor = slope.value, result->u_per_floor = slope.u;
  const double half = normal_quantile(0.5 + 0.5 * confidence) * slope.u;
  result->lower = slope.value - half, result->upper = slope.value + half;
  if (slope.u > 0) result->p_value = 2 * (1 - normal_probability(std::abs(slope.value) / slope.u));
  if (means.size() > 2) {
    double scatter = 0;
    for (const auto& [floor, weights] : means)
      scatter += std::pow(weights.dot(dz) - level - slope.value * (floor - centre), 2);
    result->scatter_per_floor = std::sqrt(scatter / (n - 2) / squares);
  }
  return result;
}

double smallest_tolerance_met(double drift, const std::vector<double>& tolerances) {
  double smallest = nan;
  for (const double tau : tolerances)
    if (std::abs(drift) <= tau && !(smallest <= tau)) smallest = tau;
  return smallest;
}

}  // namespace

std::vector<int> floors_of(const std::vector<AnchorEntry>& table) {
  int lowest = 0, highest = 0;
  for (const AnchorEntry& anchor : table) {
    if (anchor.floor <= 0) continue;
    lowest = lowest == 0 ? anchor.floor : std::min(lowest, anchor.floor);
    highest = std::max(highest, anchor.floor);
  }
  if (highest == 0) return {};
  std::vector<int> floors(static_cast<std::size_t>(highest - lowest) + 1);
  std::iota(floors.begin(), floors.end(), lowest);
  return floors;
}

std::vector<std::unique_ptr<FloorAccuracyT>> floor_accuracy(const DifferenceSet& set,
                                                            const std::vector<AnchorEntry>& table,
                                                            const std::vector<int>& floors, const Options& options,
                                                            bool with_drift) {
  const Eigen::VectorXd dz = set.heights();
  const BlockCovariance covariance = set.covariance.heights();
  const Means means_of(set, table);
  std::vector<std::unique_ptr<FloorAccuracyT>> result;
  Weights sum(dz.size()), first(dz.size());  // weights of D(F) and of r_1
  bool gap = false;
  for (const int number : floors) {
    auto floor = std::make_unique<FloorAccuracyT>();
    floor->floor = number;
    const Weights weights = means_of.of_floor(number);
    gap = gap || none(weights);
    if (!none(weights)) {
      floor->anchors = count_of(weights);
      const Linear mean = apply(weights, dz, covariance);
      floor->mean_dz = mean.value, floor->u_mean_dz = mean.u;
      fill_floor_statistics(dz, weights, *floor);
      Eigen::VectorXd own(floor->anchors);
      Eigen::Index k = 0;
      for (Weights::InnerIterator w(weights); w; ++w) own[k++] = dz[w.index()];
      floor->pass_rates = pass_rates(own, options.tolerances, options.confidence);
      if (none(first)) first = weights;
      const Linear relative = apply(weights - first, dz, covariance);
      floor->relative_drift = relative.value, floor->u_relative_drift = relative.u;
      if (with_drift && !gap) {
        sum += weights;
        const Linear drift = apply(sum, dz, covariance);
        floor->drift = drift.value, floor->u_drift = drift.u;
        floor->drift_verdict = verdict_of(drift.value, drift.u, options.tau, options.guard_factor);
        floor->smallest_tolerance_met = smallest_tolerance_met(drift.value, options.tolerances);
      }
    }
    result.push_back(std::move(floor));
  }
  return result;
}

std::unique_ptr<DriftSlopeT> drift_slope(const DifferenceSet& set, const std::vector<AnchorEntry>& table,
                                         const std::vector<int>& floors, double confidence) {
  FloorWeights means;
  const Means means_of(set, table);
  for (const int floor : floors)
    if (Weights weights = means_of.of_floor(floor); !none(weights)) means.emplace_back(floor, std::move(weights));
  return slope_through(means, set.heights(), set.covariance.heights(), confidence);
}

std::vector<std::unique_ptr<HeightTransferT>> height_transfers(const DifferenceSet& set,
                                                               const std::vector<AnchorEntry>& table,
                                                               const std::vector<int>& floors, const Options& options) {
  const Eigen::VectorXd dz = set.heights();
  const BlockCovariance covariance = set.covariance.heights();
  const Means means_of(set, table);
  std::vector<std::unique_ptr<HeightTransferT>> result;
  const auto add = [&](int floor, int column, const Weights& lower, const Weights& upper) {
    if (none(lower) || none(upper)) return;
    auto transfer = std::make_unique<HeightTransferT>();
    transfer->lower_floor = floor, transfer->upper_floor = floor + 1;
    transfer->column = column;
    transfer->anchors = count_of(lower) + count_of(upper);
    const Linear difference = apply(upper - lower, dz, covariance);
    transfer->difference = difference.value, transfer->u = difference.u;
    transfer->error = std::abs(difference.value);
    transfer->verdict = verdict_of(difference.value, difference.u, options.tau, options.guard_factor);
    result.push_back(std::move(transfer));
  };
  for (const int floor : floors) add(floor, 0, means_of.of_floor(floor), means_of.of_floor(floor + 1));
  for (const int column : columns_of(table))
    for (const int floor : floors)
      add(floor, column, means_of.of_column(floor, column), means_of.of_column(floor + 1, column));
  return result;
}

std::vector<std::unique_ptr<ColumnDriftT>> column_drifts(const DifferenceSet& set,
                                                         const std::vector<AnchorEntry>& table,
                                                         const std::vector<int>& floors, const Options& options,
                                                         bool with_drift) {
  const Eigen::VectorXd dz = set.heights();
  const BlockCovariance covariance = set.covariance.heights();
  const Means means_of(set, table);
  std::vector<std::unique_ptr<ColumnDriftT>> result;
  for (const int column : columns_of(table)) {
    FloorWeights means;
    auto drift = std::make_unique<ColumnDriftT>();
    for (const int floor : floors) {
      Weights weights = means_of.of_column(floor, column);
      if (none(weights)) continue;
      if (means.empty()) drift->lowest_floor = floor;
      drift->highest_floor = floor;
      drift->anchors += count_of(weights);
      means.emplace_back(floor, std::move(weights));
    }
    if (means.size() < 2) continue;
    drift->column = column;
    const Linear relative = apply(means.back().second - means.front().second, dz, covariance);
    drift->relative_drift = relative.value, drift->u_relative_drift = relative.u;
    drift->relative_verdict = verdict_of(relative.value, relative.u, options.tau, options.guard_factor);
    if (with_drift && means.size() == floors.size()) {
      Weights all(dz.size());
      for (const auto& [floor, weights] : means) all += weights;
      const Linear sum = apply(all, dz, covariance);
      drift->drift = sum.value, drift->u_drift = sum.u;
      drift->drift_verdict = verdict_of(sum.value, sum.u, options.tau, options.guard_factor);
    }
    drift->slope = slope_through(means, dz, covariance, options.confidence);
    result.push_back(std::move(drift));
  }
  return result;
}

}  // namespace plumbline::judgement
