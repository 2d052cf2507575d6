// The quadratic program of plan_settings() in millimetres, with the limits that were asked for.
#pragma once

#include "loop/fit/plan_settings.hpp"

namespace plumbline::loop {

/// A limit that may be handed to the solver: a direction of a bracket, or a judged value.
struct Limit {
  int bracket = -1, direction = -1;
  int value = -1;
  double low = 0, high = 0;  ///< [mm]; one of them infinite for with()
};

class SettingsProgram {
 public:
  SettingsProgram(const Facade& facade, const std::vector<PanelPose>& poses, const std::vector<JudgedValue>& judged,
                  const FitWeights& weights);

  /// The program with these limits, each with an unknown of its own, the last ones, that takes up its excess. A limit
  /// has one side; the other is infinite.
  ConvexProgram with(const std::vector<Limit>& limits) const;
  /// What the limit holds at `x` [mm].
  double at(const Limit& limit, const Eigen::VectorXd& x) const;
  /// Of a bracket along right, up, out [m].
  Eigen::Vector3d setting(std::size_t bracket, const Eigen::VectorXd& x) const;
  bool is_set(std::size_t bracket) const { return setting_at_[bracket] >= 0; }

 private:
  using Row = std::vector<std::pair<Eigen::Index, double>>;
  /// A value as a row over the unknowns and a constant [mm].
  std::pair<Row, double> row_of(const JudgedValue& value) const;
  void add_square(const Row& row, double constant, double weight);
  void add_hooks();
  void add_squares(const std::vector<JudgedValue>& judged, const FitWeights& weights);

  const Facade& facade_;
  const std::vector<PanelPose>& poses_;
  std::vector<Eigen::Index> twist_at_, setting_at_;  ///< first unknown; -1: none
  std::vector<Eigen::Matrix<double, 6, 1>> known_;   ///< twist of a panel that hangs already [mm]
  std::vector<std::pair<Row, double>> value_rows_;
  std::vector<Eigen::Triplet<double>> squares_, equations_;
  std::vector<double> right_sides_, linear_;
  Eigen::Index unknowns_ = 0;
};

/// Price of a millimetre of excess [mm²/mm]: far above what the squares can gain by it.
inline constexpr double kRangePrice = 1e4, kTolerancePrice = 1e5;

}  // namespace plumbline::loop
