// The quadratic program of plan_settings() from the side of its limits.
#pragma once

#include <Eigen/SparseLU>
#include <map>
#include <tuple>

#include "loop/fit/settings_program.hpp"

namespace plumbline::loop {

/// Of tens of thousands of limits some hundred hold at an optimum. With their multipliers as the unknowns (the dual of
/// a quadratic program: Nocedal and Wright 2006, Numerical Optimization, section 12.9) there are as many unknowns as
/// limits, and bounds alone: a limit whose excess has a price has a multiplier between 0 and that price. The program
/// without limits is factored once, and what each limit's multiplier does to all unknowns is kept.
class LimitDual {
 public:
  explicit LimitDual(const SettingsProgram& program);
  /// False where the equations of the program depend on each other: then nothing else may be asked.
  bool is_regular() const { return is_regular_; }
  /// What minimise(program.with(limits)) gives, multipliers too. Dense: its time goes with the cube of their number.
  ConvexOptimum optimum(const std::vector<Limit>& limits);

 private:
  void learn(const std::vector<Limit>& limits);
  Eigen::VectorXd multipliers(const std::vector<Limit>& limits) const;
  Eigen::Index column_of(const Limit& limit) const;

  const SettingsProgram& program_;
  const ConvexProgram base_;  ///< without limits
  Eigen::SparseLU<Eigen::SparseMatrix<double>> factor_;
  bool is_regular_ = false;
  Eigen::VectorXd free_;       ///< the optimum without limits: unknowns, then multipliers of the equations
  Eigen::MatrixXd responses_;  ///< likewise, to one unit of force along each known limit
  std::map<std::tuple<int, int, int>, Eigen::Index> columns_;  ///< by bracket, direction, value
};

}  // namespace plumbline::loop
