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
  bool is_set(std::size_t bracket) const { return is_set_[bracket]; }

 private:
  using Row = std::vector<std::pair<Eigen::Index, double>>;
  /// A setting of a bracket in one of its directions [mm]: an unknown, or what the first hook that holds it makes of its
  /// panel's twist. Fewer unknowns and equations: of 1000 panels 6000 instead of 12 100, and 2900 instead of 7000.
  struct Term {
    Row row;
    double constant = 0;
    bool is_told = false;
  };
  /// A value as a row over the unknowns and a constant [mm].
  std::pair<Row, double> row_of(const JudgedValue& value) const;
  void add_square(const Row& row, double constant, double weight);
  void choose_settings();
  void add_hook(std::size_t panel, Eigen::Index held);
  double value_of(const Term& term, const Eigen::VectorXd& x) const;
  void add_squares(const std::vector<JudgedValue>& judged, const FitWeights& weights);

  const Facade& facade_;
  const std::vector<PanelPose>& poses_;
  std::vector<Eigen::Index> twist_at_;  ///< first unknown; -1: none
  std::vector<bool> is_set_;            ///< by bracket: still to be set
  std::vector<std::array<Term, 3>> settings_;
  std::vector<Eigen::Matrix<double, 6, 1>> known_;   ///< twist of a panel that hangs already [mm]
  std::vector<std::pair<Row, double>> value_rows_;
  std::vector<Eigen::Triplet<double>> squares_, equations_;
  std::vector<double> right_sides_, linear_;
  Eigen::Index unknowns_ = 0;
  double constant_ = 0;
};

/// Price of a millimetre of excess [mm²/mm]: far above what the squares can gain by it.
inline constexpr double kRangePrice = 1e4, kTolerancePrice = 1e5;

}  // namespace plumbline::loop
