// The non-linear side of a block adjustment: parameters, whitened cost functions, and the path from approximate values
// to the linearised block at the minimum. Levenberg-Marquardt finds the minimum (it copes with poor starting values and
// with a free datum); a few undamped Gauss-Newton steps under the inner constraints finish it, because what the
// statistics are made of has to come from the same normal equations.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "least_squares/problem/schur.hpp"
#include "photo/block/cost_function.hpp"
#include "photo/bundle/elimination.hpp"

namespace plumbline::block {

using least_squares::EliminatedBlock;
using least_squares::ObservationRows;
using least_squares::PartitionedSolution;
using least_squares::PartitionedSystem;
using least_squares::ReducedSystem;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

class BlockModel {
 public:
  /// A camera pose of 6 values that the owner keeps alive. Returns the camera's index.
  int add_pose(double* values);

  /// Unknowns that are kept; `free` tells for each value whether it is estimated. Free values get the next columns.
  /// `labels` name the values in error messages. Returns the columns, −1 for values held fixed.
  std::vector<int> add_kept(double* values, const std::vector<bool>& free, const std::vector<std::string>& labels);

  int add_group(const std::string& name);

  /// One observation: a cost function whose residuals are whitened computed minus observed, over parameters added
  /// before.
  void add_term(std::unique_ptr<CostFunction> cost, std::vector<double*> parameters, int group, int label,
                bool robust = false);

  int kept_count() const { return static_cast<int>(kept_values_.size()); }
  const std::vector<std::string>& kept_labels() const { return kept_labels_; }

  /// Rows at the current values. Throws std::runtime_error with `label` and group if a cost function cannot be
  /// evaluated.
  PartitionedSystem linearise() const;

  struct Summary {
    bool converged = false;
    int iterations = 0;
    std::string message;
  };
  /// Levenberg-Marquardt. `loss` acts on terms added as robust, on the norm of their residuals. Throws
  /// Stopped if the work is to end.
  Summary minimise(int max_iterations, const bundle::Loss& loss = {});

  /// Adds corrections to the values.
  void apply(const PartitionedSolution& solution);

 private:
  struct Parameter {
    double* values = nullptr;
    int camera = -1;           ///< for poses
    std::vector<int> columns;  ///< for kept unknowns
    int size() const { return camera >= 0 ? 6 : static_cast<int>(columns.size()); }
  };
  struct Term {
    std::unique_ptr<CostFunction> cost;
    std::vector<size_t> parameters;
    int group = 0;
    int label = 0;
    bool robust = false;
  };
  ObservationRows rows_of(const Term& term) const;
  /// Half the sum of squares, robust where terms are; nothing where a term has no value.
  std::optional<double> cost(const bundle::Loss& loss) const;
  std::vector<double> values() const;
  void set_values(const std::vector<double>& all);

  std::vector<Parameter> parameters_;
  std::vector<std::pair<double*, size_t>> index_;  ///< sorted by address
  std::vector<double*> kept_values_;               ///< by column
  std::vector<std::string> kept_labels_;
  std::vector<double*> poses_;
  std::vector<std::string> groups_;
  std::vector<Term> terms_;
};

/// The last linearisation of an adjustment, with its solution and cofactors.
struct AdjustedBlock {
  PartitionedSystem linear;
  ReducedSystem reduced;
  PartitionedSolution solution;
  int iterations = 0;
};

/// Called after every change of the values: folds rotation increments into their rotations.
using Fold = std::function<void()>;
/// Called on every linearised block: sets null space and datum for a free network.
using SetDatum = std::function<void(PartitionedSystem&)>;
/// Called on the first normal equations, before they are solved: throws what is wrong with them.
using CheckSystem = std::function<void(const PartitionedSystem&, const ReducedSystem&)>;

/// Above this number of kept unknowns (3 a target, 6 a plate) their dense normal matrix and covariance take gigabytes.
constexpr int max_kept_unknowns = 9000;

/// Runs `model` to its minimum: minimise(), then Gauss-Newton until no unknown moves by more than 1e-7 of its standard
/// deviation. Throws std::runtime_error if that is not reached, or beforehand if there are more than max_kept_unknowns.
AdjustedBlock adjust_to_convergence(BlockModel& model, int max_iterations, const Fold& fold, const SetDatum& set_datum,
                                    const CheckSystem& check);

}  // namespace plumbline::block
