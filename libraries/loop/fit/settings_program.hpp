// The quadratic program of plan_settings() in millimetres, with the limits that were asked for.
#pragma once

#include <array>
#include <optional>

#include "loop/fit/plan_settings.hpp"

namespace plumbline::loop {

/// A limit that may be handed to the solver: a direction of a bracket, or a judged value.
struct Limit {
  int bracket = -1, direction = -1;
  int value = -1;
  double low = 0, high = 0;  ///< [mm]; one of them infinite for with()
  std::size_t panel = 0;     ///< that the value is judged with
};

/// Unknowns are the settings that some hook holds; the panels' twists follow from them. Beside them only what a rigid
/// panel does not follow is an equation, one for a panel on four hooks: of 1000 panels 4300 unknowns and 1000
/// equations, where twists as unknowns need 6000 and 2700. How far out a panel holds the edge of the one above it is an
/// unknown, too, with the equation that says so: without it the terms of a panel would be those of all panels below it,
/// and the squares of a column grow with the square of its height.
class SettingsProgram {
 public:
  /// A length as a sum over unknowns and a constant [mm].
  struct Term {
    std::vector<std::pair<Eigen::Index, double>> row;
    double constant = 0;
    void add(double factor, const Term& other);
    double value(const Eigen::VectorXd& x) const;
  };

  SettingsProgram(const Facade& facade, const std::vector<PanelPose>& poses, const std::vector<JudgedValue>& judged,
                  const FitWeights& weights);

  /// The program with these limits, each with an unknown of its own, the last ones, that takes up its excess. A limit
  /// has one side; the other is infinite.
  ConvexProgram with(const std::vector<Limit>& limits) const;
  /// What the limit holds.
  const Term& term_of(const Limit& limit) const;
  /// The same at `x` [mm].
  double at(const Limit& limit, const Eigen::VectorXd& x) const;
  /// Of a bracket along right, up, out [m].
  Eigen::Vector3d setting(std::size_t bracket, const Eigen::VectorXd& x) const;
  bool is_set(std::size_t bracket) const { return is_set_[bracket]; }

 private:
  void choose_settings();
  void add_hooks(std::size_t panel);
  void add_edge(std::size_t panel);
  void add_equation(const Term& term);
  void keep_independent_equations();
  void add_square(const Term& term, double weight);
  void add_squares(const std::vector<JudgedValue>& judged, const FitWeights& weights);
  Term term_of(std::size_t panel, const Eigen::Matrix<double, 1, 6>& row) const;

  const Facade& facade_;
  const std::vector<PanelPose>& poses_;
  std::vector<bool> is_set_;  ///< by bracket: still to be set
  std::vector<std::array<Term, 3>> settings_;
  std::vector<std::vector<Term>> hooks_;    ///< by panel: movement of each direction that it holds itself
  std::vector<std::optional<Term>> edges_;  ///< by panel that stands on another: how far out that one holds its edge
  std::vector<Term> values_;                ///< of what is judged
  std::vector<Eigen::Triplet<double>> squares_, equations_;
  std::vector<double> right_sides_, linear_;
  Eigen::Index unknowns_ = 0;
  double constant_ = 0;
};

/// Price of a millimetre of excess [mm²/mm]: far above what the squares can gain by it.
inline constexpr double kRangePrice = 1e4, kTolerancePrice = 1e5;
inline double price_of(const Limit& limit) { return limit.value >= 0 ? kTolerancePrice : kRangePrice; }

}  // namespace plumbline::loop
