#include "building/judgement/comparison.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "building/judgement/drift.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/spectral_coordinates.hpp"
#include "building/judgement/tested_directions.hpp"
#include "building/judgement/tolerance.hpp"
#include "geometry/statistics.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::judgement {

namespace {

void fill_verdicts(const Eigen::VectorXd& dz, const BlockCovariance& covariance, const Options& options,
                   AccuracyComparisonT& out) {
  const Eigen::VectorXd variances = covariance.diagonal();
  for (Eigen::Index i = 0; i < dz.size(); ++i) {
    const double u = covariance.size() == 0 ? nan : std::sqrt(std::max(0.0, variances[i]));
    switch (verdict_of(dz[i], u, options.tau, options.guard_factor)) {
      case ToleranceVerdict::pass:
        ++out.passed;
        break;
      case ToleranceVerdict::fail:
        ++out.failed;
        break;
      default:
        ++out.undecided;
    }
  }
}

void fill_heights(const DifferenceSet& set, const std::vector<AnchorEntry>& table, const Options& options,
                  AccuracyComparisonT& out) {
  const Eigen::VectorXd dz = set.heights();
  BlockCovariance covariance = set.covariance.heights();
  const auto n = static_cast<double>(dz.size());
  out.mean_dz = dz.mean();
  out.rmse_z = std::sqrt(dz.squaredNorm() / n);
  if (dz.size() > 1) out.deviation_dz = std::sqrt((dz.array() - out.mean_dz).square().sum() / (n - 1));
  Eigen::Index worst = 0;
  out.max_abs_dz = dz.cwiseAbs().maxCoeff(&worst);
  out.worst_anchor = table[set.anchors[worst]].id;
  fill_verdicts(dz, covariance, options, out);
  if (covariance.size() == 0) return;
  out.u_mean_dz = std::sqrt(std::max(0.0, covariance.sum())) / n;
  const PredictedRmse predicted = predicted_rmse(covariance, n, options.confidence);
  out.predicted_rmse_z = predicted.value;
  out.predicted_rmse_z_lower = predicted.lower;
  out.predicted_rmse_z_upper = predicted.upper;
  out.consistency_z = consistency(dz, std::move(covariance), options.confidence);
}

void fill_distances(const DifferenceSet& set, AccuracyComparisonT& out) {
  const auto n = static_cast<Eigen::Index>(set.size());
  out.rmse_3d = std::sqrt(set.difference.squaredNorm() / static_cast<double>(n));
  out.max_distance = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    out.max_distance = std::max(out.max_distance, set.difference.segment<3>(3 * i).norm());
  if (set.covariance.size() == 0) return;
  out.predicted_rmse_3d = std::sqrt(std::max(0.0, set.covariance.trace()) / static_cast<double>(n));
}

}  // namespace

AccuracyComparisonT compare(DifferenceSet set, const std::vector<AnchorEntry>& table, const Options& options,
                            bool with_drift) {
  AccuracyComparisonT out;
  const std::vector<int> floors = floors_of(table);
  out.anchors = static_cast<int>(set.size());
  out.drift_computed = with_drift;
  if (set.size() > 0) {
    fill_heights(set, table, options, out);
    fill_distances(set, out);
  }
  out.floors = floor_accuracy(set, table, floors, options, with_drift);
  out.slope = drift_slope(set, table, floors, options.confidence);
  out.pass_rates = pass_rates(set.heights(), options.tolerances, options.confidence);
  out.transfers = height_transfers(set, table, floors, options);
  out.columns = column_drifts(set, table, floors, options, with_drift);
  out.consistency_3d = consistency(set.difference, std::move(set.covariance), options.confidence);  // last: it takes it
  return out;
}

std::unique_ptr<AnchorDifferenceT> anchor_difference(const Eigen::Vector3d& difference,
                                                     const Eigen::MatrixXd& covariance, const Options& options) {
  auto out = std::make_unique<AnchorDifferenceT>();
  out->dx = difference.x(), out->dy = difference.y(), out->dz = difference.z();
  out->distance = difference.norm();
  if (covariance.size() != 0) {
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) out->covariance.push_back(covariance(row, column));
    out->u_dz = std::sqrt(std::max(0.0, covariance(2, 2)));
    // Along the difference; where there is none the direction is open and the largest axis stands for all.
    const Eigen::Matrix3d s = covariance;
    const double variance =
        out->distance > 0 ? difference.dot(s * difference) / difference.squaredNorm()
                          : Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(s, Eigen::EigenvaluesOnly).eigenvalues()[2];
    out->u_distance = std::sqrt(std::max(0.0, variance));
  }
  out->verdict = verdict_of(out->dz, out->u_dz, options.tau, options.guard_factor);
  out->conformance_probability = conformance_probability(out->dz, out->u_dz, options.tau);
  out->verdict_distance = verdict_of(out->distance, out->u_distance, options.tau, options.guard_factor);
  return out;
}

namespace {

Eigen::VectorXd of_cluster(const Eigen::VectorXd& difference, const BlockCovariance::Cluster& cluster,
                           Eigen::Index step) {
  Eigen::VectorXd own(cluster.matrix.rows());
  for (std::size_t k = 0; k < cluster.items.size(); ++k)
    own.segment(static_cast<Eigen::Index>(k) * step, step) = difference.segment(cluster.items[k] * step, step);
  return own;
}

/// Directions in which a difference is known to better than 0.02 mm are those where a control anchor follows its
/// survey: what is left there is rounding and the small variances that adjustments add, not errors to be tested.
constexpr double kLeastVariance = 4e-10;
double least_tested(double largest_eigenvalue) { return std::max(1e-6 * largest_eigenvalue, kLeastVariance); }

/// False where eigenvalues are needed to tell which directions are not tested.
bool test_by_factors(const Eigen::VectorXd& difference, BlockCovariance& covariance, ErrorConsistencyT& out) {
  double bound = 0;  // of the largest eigenvalue: the row sum norm
  for (const BlockCovariance::Cluster& cluster : covariance.clusters())
    bound = std::max(bound, cluster.matrix.row_sum_norm());
  const double limit = least_tested(bound);
  // Above the least one the limit follows from the largest eigenvalue itself, of which a bound only is known here.
  const bool is_known = limit == kLeastVariance;
  double statistic = 0;
  Eigen::Index number = 0;
  for (BlockCovariance::Cluster& cluster : covariance.clusters()) {
    stop_point();
    const Eigen::VectorXd own = of_cluster(difference, cluster, covariance.step());
    const auto tested = tested_directions(own, cluster.matrix.made_full(), limit, is_known);
    if (!tested) return false;
    statistic += tested->statistic, number += tested->number;
  }
  out.statistic = statistic, out.degrees_of_freedom = static_cast<int>(number);
  return true;
}

void test_known_directions(const Eigen::VectorXd& difference, BlockCovariance& covariance, ErrorConsistencyT& out) {
  std::vector<SpectralCoordinates> all;
  double largest = 0;
  for (BlockCovariance::Cluster& cluster : covariance.clusters()) {
    all.push_back(spectral_coordinates(cluster.matrix.made_full(), of_cluster(difference, cluster, covariance.step())));
    largest = std::max(largest, all.back().eigenvalues.maxCoeff());
  }
  const double limit = least_tested(largest);
  out.statistic = 0, out.degrees_of_freedom = 0;
  for (const SpectralCoordinates& own : all)
    for (Eigen::Index i = 0; i < own.along.size(); ++i) {
      if (!(own.eigenvalues[i] > limit)) continue;
      out.statistic += own.along[i] * own.along[i] / own.eigenvalues[i];
      ++out.degrees_of_freedom;
    }
}

}  // namespace

std::unique_ptr<ErrorConsistencyT> consistency(const Eigen::VectorXd& difference, BlockCovariance covariance,
                                               double confidence) {
  if (covariance.size() == 0 || difference.size() == 0) return nullptr;
  auto out = std::make_unique<ErrorConsistencyT>();
  if (!test_by_factors(difference, covariance, *out)) test_known_directions(difference, covariance, *out);
  if (out->degrees_of_freedom == 0) return nullptr;
  out->lower = chi_squared_quantile(0.5 - 0.5 * confidence, out->degrees_of_freedom);
  out->upper = chi_squared_quantile(0.5 + 0.5 * confidence, out->degrees_of_freedom);
  out->probability = chi_squared_probability(out->statistic, out->degrees_of_freedom);
  return out;
}

PredictedRmse predicted_rmse(const BlockCovariance& covariance, double n, double confidence) {
  const double trace = std::max(0.0, covariance.trace());
  const double square = covariance.squaredNorm();    // tr(S S') of a symmetric S
  if (!(square > 0 && trace > 0)) return {0, 0, 0};  // a model that is its own survey
  const double freedom = trace * trace / square;
  const double scale = square / trace;
  const auto at = [&](double probability) { return std::sqrt(scale * chi_squared_quantile(probability, freedom) / n); };
  return {std::sqrt(trace / n), at(0.5 - 0.5 * confidence), at(0.5 + 0.5 * confidence)};
}

}  // namespace plumbline::judgement
