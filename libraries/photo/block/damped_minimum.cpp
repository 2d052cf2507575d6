// Levenberg-Marquardt for BlockModel, poses eliminated: damping is one more row an unknown, so that the normal
// equations are those of the statistics. Sources: Marquardt (1963) for the scaling; Nielsen (1999), IMM-REP-1999-05,
// for the change of the damping; robust losses by reweighting with the root of their derivative (Förstner & Wrobel
// 2016, 4.7).
#include <algorithm>
#include <cmath>
#include <optional>

#include "photo/block/block_model.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::block {
namespace {

/// Squares of the columns: of the kept unknowns, then of each eliminated block's.
Eigen::VectorXd squares_of_columns(const PartitionedSystem& system) {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(system.unknown_count());
  for (const ObservationRows& rows : system.observations) {
    for (std::size_t c = 0; c < rows.columns.size(); ++c)
      squares(rows.columns[c]) += rows.kept.col(static_cast<Eigen::Index>(c)).squaredNorm();
    if (rows.eliminated >= 0)
      squares.segment(system.kept_count + system.eliminated_size * rows.eliminated, system.eliminated_size) +=
          rows.own.colwise().squaredNorm().transpose();
  }
  return squares;
}

/// Half the squares that the linear model loses by the step.
double predicted_decrease(const PartitionedSystem& system, std::size_t count, const PartitionedSolution& step) {
  double decrease = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const ObservationRows& rows = system.observations[i];
    Eigen::VectorXd change = Eigen::VectorXd::Zero(rows.misclosure.size());
    for (std::size_t c = 0; c < rows.columns.size(); ++c)
      change += rows.kept.col(static_cast<Eigen::Index>(c)) * step.kept(rows.columns[c]);
    if (rows.eliminated >= 0) change += rows.own * step.eliminated[static_cast<std::size_t>(rows.eliminated)];
    decrease += change.dot(rows.misclosure - 0.5 * change);
  }
  return decrease;
}

/// Rows that hold every unknown where it is, behind the observations; their weights are set by damp().
void append_damping(PartitionedSystem& system) {
  for (int k = 0; k < system.kept_count; ++k) {
    ObservationRows rows;
    rows.columns = {k};
    rows.kept = Eigen::MatrixXd::Zero(1, 1);
    rows.misclosure = Eigen::VectorXd::Zero(1);
    system.observations.push_back(std::move(rows));
  }
  for (int i = 0; i < system.eliminated_count; ++i) {
    ObservationRows rows;
    rows.eliminated = i;
    rows.own = Eigen::MatrixXd::Zero(system.eliminated_size, system.eliminated_size);
    rows.kept.resize(system.eliminated_size, 0);
    rows.misclosure = Eigen::VectorXd::Zero(system.eliminated_size);
    system.observations.push_back(std::move(rows));
  }
}

void damp(PartitionedSystem& system, std::size_t count, const Eigen::VectorXd& weights) {
  for (int k = 0; k < system.kept_count; ++k) system.observations[count++].kept(0, 0) = weights(k);
  for (int i = 0; i < system.eliminated_count; ++i)
    system.observations[count++].own =
        weights.segment(system.kept_count + system.eliminated_size * i, system.eliminated_size).asDiagonal();
}

}  // namespace

std::optional<double> BlockModel::cost(const bundle::Loss& loss) const {
  double sum = 0;
  std::vector<const double*> values;
  Eigen::VectorXd residual;
  for (const Term& term : terms_) {
    values.clear();
    for (const std::size_t p : term.parameters) values.push_back(parameters_[p].values);
    residual.resize(term.cost->residual_count());
    if (!term.cost->evaluate(values.data(), residual.data(), nullptr) || !residual.allFinite()) return std::nullopt;
    const double s = residual.squaredNorm();
    sum += 0.5 * (term.robust ? loss.value(s) : s);
  }
  return sum;
}

std::vector<double> BlockModel::values() const {
  std::vector<double> all;
  for (const Parameter& p : parameters_) all.insert(all.end(), p.values, p.values + p.size());
  return all;
}

void BlockModel::set_values(const std::vector<double>& all) {
  const double* next = all.data();
  for (const Parameter& p : parameters_) {
    std::copy(next, next + p.size(), p.values);
    next += p.size();
  }
}

BlockModel::Summary BlockModel::minimise(int max_iterations, const bundle::Loss& loss) {
  constexpr double least_decrease = 1e-12, least_step = 1e-12, least_gain = 1e-3, largest_radius = 1e16,
                   smallest_radius = 1e-32, smallest_square = 1e-6;
  Summary summary;
  const auto first = cost(loss);
  if (!first) return {false, 0, "the model has no value at the approximate values"};
  double now = *first, radius = 1e4, shrink = 2;
  Eigen::VectorXd unit;  // of the unknowns, by the columns at the start
  while (summary.iterations < max_iterations) {
    PartitionedSystem system = linearise();
    const std::size_t count = system.observations.size();
    for (std::size_t i = 0; i < count; ++i) {
      ObservationRows& rows = system.observations[i];
      if (!terms_[i].robust) continue;
      const double root = std::sqrt(loss.slope(rows.misclosure.squaredNorm()));
      rows.misclosure *= root, rows.kept *= root, rows.own *= root;
    }
    const Eigen::VectorXd squares = squares_of_columns(system);
    if (unit.size() == 0) unit = squares.cwiseSqrt().unaryExpr([](double length) { return 1 / (1 + length); });
    append_damping(system);
    for (bool accepted = false; !accepted;) {
      stop_point();
      if (summary.iterations++ >= max_iterations) return {false, summary.iterations, "it did not come to an end"};
      const Eigen::VectorXd weights =
          (squares.array() * unit.array().square()).max(smallest_square).sqrt() / (unit.array() * std::sqrt(radius));
      damp(system, count, weights);
      PartitionedSolution step;
      const std::vector<double> before = values();
      const bool solved = solve_corrections(system, reduce(system), step) && step.kept.allFinite();
      double length = 0, place = 0;
      std::optional<double> trial;
      if (solved) {
        apply(step);
        const std::vector<double> after = values();
        for (std::size_t i = 0; i < after.size(); ++i)
          length += (after[i] - before[i]) * (after[i] - before[i]), place += before[i] * before[i];
        if (std::sqrt(length) <= least_step * (std::sqrt(place) + least_step)) {
          set_values(before);
          return {true, summary.iterations, "the steps became too short to count"};
        }
        trial = cost(loss);
      }
      if (trial && std::abs(now - *trial) <= least_decrease * now) {
        if (*trial > now) set_values(before);
        return {true, summary.iterations, "the residuals became no smaller"};
      }
      const double gain = trial ? (now - *trial) / predicted_decrease(system, count, step) : -1;
      accepted = trial && gain > least_gain;
      if (!accepted) {
        set_values(before);
        radius /= shrink, shrink *= 2;
        if (radius < smallest_radius) return {false, summary.iterations, "no step made the residuals smaller"};
        continue;
      }
      radius = std::min(largest_radius, radius / std::max(1.0 / 3, 1 - std::pow(2 * gain - 1, 3)));
      shrink = 2;
      now = *trial;
    }
  }
  return {false, summary.iterations, "it did not come to an end"};
}

}  // namespace plumbline::block
