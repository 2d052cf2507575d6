// A least-squares problem as data: parameter blocks, and residual blocks that connect them. The library of this folder
// solves it (solver.hpp), gives its cofactors (cofactors.hpp) and tells how far each observation is
// controlled by the others (reliability.hpp). Nothing here knows what is being measured: survey networks and image
// blocks use the same code.
//
// Conventions. Residual v = f(x) - l (adjusted minus observed). Each block is whitened with its own covariance, u = W v
// with W' W = covariance^-1, so that the sum of squares is v' P v and the a-priori variance of unit weight is 1.
// "Unknown" is one scalar of the tangent space that is not held constant; unknowns are numbered in the order of the
// blocks.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

namespace plumbline::least_squares {

/// A group of parameters that residual blocks refer to as one: a point, an orientation, a camera pose.
struct ParameterBlock {
  /// Applies a tangent step to a value that is not a vector, e.g. a quaternion; null: addition.
  using Plus = void (*)(const double* value, const double* step, double* result);

  std::string name;
  std::vector<double> value;   ///< current value; the initial value when the solver starts
  std::vector<bool> constant;  ///< one per tangent component; empty: all are unknowns
  int tangent_size = 0;        ///< 0: as many as value.size()
  Plus plus = nullptr;

  int tangent() const { return tangent_size > 0 ? tangent_size : static_cast<int>(value.size()); }
};

/// Some observations with a common covariance, depending on a few parameter blocks.
class ResidualBlock {
 public:
  virtual ~ResidualBlock() = default;

  /// v = f(x) - l in the unit of the observation, rows() long; `jacobians[k]`, if not null, is the row-major
  /// rows() x tangent(k) matrix of partials by the k-th of `parameters`, zero-filled by the caller.
  /// Returns false where the functions are undefined (a step led there); the solver then takes a shorter step.
  virtual bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const = 0;

  int rows() const { return static_cast<int>(whitening_.rows()); }

  /// Uncorrelated observations; throws std::invalid_argument unless every sigma is positive and finite.
  void set_sigmas(const Eigen::VectorXd& sigmas);
  /// Correlated observations; throws std::invalid_argument unless symmetric and positive definite.
  void set_covariance(const Eigen::MatrixXd& covariance);
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// W, lower triangular, W' W = covariance^-1.
  const Eigen::MatrixXd& whitening() const { return whitening_; }

  std::vector<int> parameters;  ///< indices into Problem::parameters
  std::vector<int> groups;      ///< variance component of each row; empty: all 0
  /// Factor on the weight of each row (robust estimation); empty: 1. Only for uncorrelated blocks.
  std::vector<double> weight_factors;

 private:
  Eigen::MatrixXd covariance_, whitening_;
};

struct Problem {
  std::vector<ParameterBlock> parameters;
  std::vector<std::unique_ptr<ResidualBlock>> residuals;
};

/// Numbers of the unknowns of a problem. Stays valid while no block is added and no `constant` changes.
class UnknownIndex {
 public:
  explicit UnknownIndex(const Problem& problem);
  int count() const { return count_; }
  /// Unknown of tangent component c of block b, or -1 if it is constant.
  int operator()(int block, int component) const { return unknowns_[first_[block] + component]; }
  int block_of(int unknown) const { return block_of_[unknown]; }
  int component_of(int unknown) const { return component_of_[unknown]; }

 private:
  int count_ = 0;
  std::vector<int> first_, unknowns_, block_of_, component_of_;
};

/// All blocks linearised at the current values: whitened residuals and whitened Jacobians in flat arrays.
struct Linearisation {
  struct Block {
    int row = 0;  ///< first row in `residuals`
    int rows = 0;
    int column_begin = 0;  ///< into `columns`
    int column_count = 0;  ///< unknowns this block depends on
    int jacobian_begin = 0;
  };
  int rows = 0;
  std::vector<Block> blocks;     ///< one per residual block
  std::vector<int> columns;      ///< unknowns of each block, ascending within it
  std::vector<double> jacobian;  ///< whitened, row-major rows x column_count per block
  Eigen::VectorXd residuals;     ///< whitened
  double sum_of_squares = 0;     ///< v' P v

  auto jacobian_of(const Block& block) const {
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        jacobian.data() + block.jacobian_begin, block.rows, block.column_count);
  }
};

/// Sets up the structure (blocks, columns); values are filled by `linearise`.
Linearisation prepare_linearisation(const Problem& problem, const UnknownIndex& unknowns);

/// Fills residuals and, if asked, Jacobians at the current parameter values. False if a block is undefined there or not
/// finite.
bool linearise(const Problem& problem, const UnknownIndex& unknowns, bool with_jacobian, Linearisation& linearisation);

/// Values of all blocks after the tangent step of the unknowns.
void apply_step(Problem& problem, const UnknownIndex& unknowns, const Eigen::VectorXd& step);

}  // namespace plumbline::least_squares
