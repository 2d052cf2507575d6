#include "photo/block/block_model.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "plumbline/stop.hpp"

namespace plumbline::block {
namespace {

/// Largest correction in units of the conditional standard deviation of its unknown.
double largest_step(const ReducedSystem& reduced, const PartitionedSolution& solution) {
  double largest = 0;
  for (Eigen::Index i = 0; i < solution.kept.size(); ++i)
    largest = std::max(largest, std::abs(solution.kept(i)) * std::sqrt(std::max(0.0, reduced.diagonal(i))));
  return largest;
}

}  // namespace

int BlockModel::add_pose(double* values) {
  Parameter parameter;
  parameter.values = values;
  parameter.camera = static_cast<int>(poses_.size());
  index_.insert(std::upper_bound(index_.begin(), index_.end(), std::make_pair(values, size_t{0})),
                {values, parameters_.size()});
  parameters_.push_back(parameter);
  poses_.push_back(values);
  return parameter.camera;
}

std::vector<int> BlockModel::add_kept(double* values, const std::vector<bool>& free,
                                      const std::vector<std::string>& labels) {
  Parameter parameter;
  parameter.values = values;
  for (size_t i = 0; i < free.size(); ++i) {
    parameter.columns.push_back(free[i] ? kept_count() : -1);
    if (!free[i]) continue;
    kept_values_.push_back(values + i);
    kept_labels_.push_back(labels.at(i));
  }
  index_.insert(std::upper_bound(index_.begin(), index_.end(), std::make_pair(values, size_t{0})),
                {values, parameters_.size()});
  parameters_.push_back(parameter);
  return parameter.columns;
}

int BlockModel::add_group(const std::string& name) {
  groups_.push_back(name);
  return static_cast<int>(groups_.size()) - 1;
}

void BlockModel::add_term(std::unique_ptr<CostFunction> cost, std::vector<double*> parameters, int group, int label,
                          bool robust) {
  Term term;
  term.cost = std::move(cost);
  term.group = group;
  term.label = label;
  term.robust = robust;
  for (double* values : parameters) {
    const auto at = std::lower_bound(index_.begin(), index_.end(), std::make_pair(values, size_t{0}));
    if (at == index_.end() || at->first != values)
      throw std::logic_error("BlockModel: a term uses a parameter that was not added");
    term.parameters.push_back(at->second);
  }
  terms_.push_back(std::move(term));
}

ObservationRows BlockModel::rows_of(const Term& term) const {
  const int count = term.cost->residual_count();
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<RowMajor> storage;
  std::vector<const double*> values;
  std::vector<double*> jacobians;
  for (size_t p : term.parameters) storage.emplace_back(count, parameters_[p].size());
  for (size_t i = 0; i < storage.size(); ++i) {
    values.push_back(parameters_[term.parameters[i]].values);
    jacobians.push_back(storage[i].data());
  }
  ObservationRows rows;
  rows.group = term.group;
  rows.label = term.label;
  Eigen::VectorXd residual(count);
  if (!term.cost->evaluate(values.data(), residual.data(), jacobians.data()) || !residual.allFinite())
    throw std::runtime_error("observation " + std::to_string(term.label) + " of group '" +
                             groups_[static_cast<size_t>(term.group)] +
                             "' cannot be computed: its point lies behind the camera or outside the camera model");
  rows.misclosure = -residual;
  for (size_t p : term.parameters)
    for (int column : parameters_[p].columns)
      if (column >= 0) rows.columns.push_back(column);
  rows.kept.resize(count, static_cast<Eigen::Index>(rows.columns.size()));
  Eigen::Index next = 0;
  for (size_t i = 0; i < storage.size(); ++i) {
    const Parameter& parameter = parameters_[term.parameters[i]];
    if (parameter.camera >= 0) {
      rows.eliminated = parameter.camera;
      rows.own = storage[i];
      continue;
    }
    for (size_t c = 0; c < parameter.columns.size(); ++c)
      if (parameter.columns[c] >= 0) rows.kept.col(next++) = storage[i].col(static_cast<Eigen::Index>(c));
  }
  return rows;
}

PartitionedSystem BlockModel::linearise() const {
  PartitionedSystem block;
  block.kept_count = kept_count();
  block.eliminated_count = static_cast<int>(poses_.size());
  block.groups = groups_;
  block.observations.reserve(terms_.size());
  for (const Term& term : terms_) block.observations.push_back(rows_of(term));
  return block;
}

void BlockModel::apply(const PartitionedSolution& solution) {
  for (size_t i = 0; i < kept_values_.size(); ++i) *kept_values_[i] += solution.kept(static_cast<Eigen::Index>(i));
  for (size_t i = 0; i < poses_.size(); ++i)
    for (int k = 0; k < 6; ++k) poses_[i][k] += solution.eliminated[i](k);
}

AdjustedBlock adjust_to_convergence(BlockModel& model, int max_iterations, const Fold& fold, const SetDatum& set_datum,
                                    const CheckSystem& check) {
  // Few photographs of wide angle leave the undamped steps to swing, each seven tenths of the last: as long as they get
  // shorter they go on.
  constexpr int max_refinements = 20, max_shrinking = 60;
  constexpr double smallest_step = 1e-7, shrinking = 0.9;
  if (model.kept_count() > max_kept_unknowns)
    throw std::runtime_error("the block has " + std::to_string(model.kept_count()) +
                             " unknowns besides the poses; the dense covariance of this adjustment takes up to " +
                             std::to_string(max_kept_unknowns) + ": divide the block or leave points out");
  AdjustedBlock result;
  const auto summary = model.minimise(max_iterations);
  fold();
  double last = std::numeric_limits<double>::infinity();
  int steps = 0;
  for (int i = 0; i < max_shrinking; ++i, ++steps) {
    stop_point();
    result.linear = model.linearise();
    set_datum(result.linear);
    result.reduced = reduce(result.linear);
    if (i == 0) check(result.linear, result.reduced);
    if (!solve_corrections(result.linear, result.reduced, result.solution) || !result.solution.kept.allFinite())
      throw std::runtime_error("the normal matrix of the block is singular after " +
                               std::to_string(summary.iterations + i) + " iterations");
    result.iterations = summary.iterations + i;
    const double size = largest_step(result.reduced, result.solution);
    if (size < smallest_step) {
      add_cofactors(result.linear, result.reduced, result.solution);
      return result;
    }
    if (i >= max_refinements && !(size < shrinking * last)) break;
    last = size;
    model.apply(result.solution);
    fold();
  }
  throw std::runtime_error("the block adjustment did not converge in " + std::to_string(summary.iterations) +
                           " damped and " + std::to_string(steps) + " undamped iterations (" + summary.message +
                           "); check the approximate poses and coordinates");
}

}  // namespace plumbline::block
