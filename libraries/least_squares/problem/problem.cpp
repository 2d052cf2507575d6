#include "least_squares/problem/problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plumbline::least_squares {

void ResidualBlock::set_sigmas(const Eigen::VectorXd& sigmas) {
  for (double sigma : sigmas)
    if (!(sigma > 0) || !std::isfinite(sigma))
      throw std::invalid_argument("standard deviation " + std::to_string(sigma) + " is not a positive number");
  covariance_ = sigmas.cwiseAbs2().asDiagonal();
  whitening_ = sigmas.cwiseInverse().asDiagonal();
}

void ResidualBlock::set_covariance(const Eigen::MatrixXd& covariance) {
  if (covariance.rows() != covariance.cols() || !covariance.allFinite())
    throw std::invalid_argument("covariance of observations is not a square matrix of finite numbers");
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > 1e-9 * covariance.cwiseAbs().maxCoeff())
    throw std::invalid_argument("covariance of observations is not symmetric");
  const Eigen::LLT<Eigen::MatrixXd> cholesky(covariance);
  if (cholesky.info() != Eigen::Success)
    throw std::invalid_argument("covariance of observations is not positive definite");
  covariance_ = covariance;
  whitening_ = cholesky.matrixL().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

UnknownIndex::UnknownIndex(const Problem& problem) {
  for (size_t b = 0; b < problem.parameters.size(); ++b) {
    const ParameterBlock& block = problem.parameters[b];
    first_.push_back(static_cast<int>(unknowns_.size()));
    for (int c = 0; c < block.tangent(); ++c) {
      const bool constant = !block.constant.empty() && block.constant[c];
      unknowns_.push_back(constant ? -1 : count_);
      if (constant) continue;
      block_of_.push_back(static_cast<int>(b));
      component_of_.push_back(c);
      ++count_;
    }
  }
}

Linearisation prepare_linearisation(const Problem& problem, const UnknownIndex& unknowns) {
  Linearisation lin;
  std::vector<int> columns;
  int jacobian_size = 0;
  for (const auto& residual : problem.residuals) {
    columns.clear();
    for (int p : residual->parameters)
      for (int c = 0; c < problem.parameters[p].tangent(); ++c)
        if (unknowns(p, c) >= 0) columns.push_back(unknowns(p, c));
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    const int count = static_cast<int>(columns.size());
    lin.blocks.push_back({lin.rows, residual->rows(), static_cast<int>(lin.columns.size()), count, jacobian_size});
    lin.columns.insert(lin.columns.end(), columns.begin(), columns.end());
    lin.rows += residual->rows();
    jacobian_size += residual->rows() * count;
  }
  lin.jacobian.assign(jacobian_size, 0.0);
  lin.residuals = Eigen::VectorXd::Zero(lin.rows);
  return lin;
}

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Work space of one block's evaluation, kept between blocks to spare allocations.
struct Scratch {
  std::vector<const double*> values;
  std::vector<double> raw;  // Jacobians of all parameters, one after another
  std::vector<double*> jacobians;
  Eigen::VectorXd residuals;
  RowMajor gathered;  // rows x columns of the block
};

bool evaluate_block(const Problem& problem, const ResidualBlock& residual, bool with_jacobian, Scratch& s) {
  const int rows = residual.rows();
  s.values.clear();
  s.jacobians.clear();
  size_t total = 0;
  for (int p : residual.parameters) {
    s.values.push_back(problem.parameters[p].value.data());
    total += static_cast<size_t>(rows) * static_cast<size_t>(problem.parameters[p].tangent());
  }
  s.residuals.resize(rows);
  if (with_jacobian) {
    s.raw.assign(total, 0.0);
    double* next = s.raw.data();
    for (int p : residual.parameters) {
      s.jacobians.push_back(next);
      next += rows * problem.parameters[p].tangent();
    }
  } else {
    s.jacobians.assign(residual.parameters.size(), nullptr);
  }
  return residual.evaluate(s.values.data(), s.residuals.data(), s.jacobians.data()) && s.residuals.allFinite();
}

/// Sums the partials of all parameters into the block's columns; a parameter named twice adds up.
void gather_columns(const Problem& problem, const UnknownIndex& unknowns, const ResidualBlock& residual,
                    const int* columns, int column_count, Scratch& s) {
  s.gathered.setZero(residual.rows(), column_count);
  for (size_t k = 0; k < residual.parameters.size(); ++k) {
    const int p = residual.parameters[k];
    const int tangent = problem.parameters[p].tangent();
    for (int c = 0; c < tangent; ++c) {
      const int unknown = unknowns(p, c);
      if (unknown < 0) continue;
      const auto at = std::lower_bound(columns, columns + column_count, unknown) - columns;
      for (int r = 0; r < residual.rows(); ++r) s.gathered(r, at) += s.jacobians[k][r * tangent + c];
    }
  }
}

}  // namespace

bool linearise(const Problem& problem, const UnknownIndex& unknowns, bool with_jacobian, Linearisation& lin) {
  Scratch scratch;
  for (size_t b = 0; b < problem.residuals.size(); ++b) {
    const ResidualBlock& residual = *problem.residuals[b];
    const Linearisation::Block& block = lin.blocks[b];
    if (!evaluate_block(problem, residual, with_jacobian, scratch)) return false;
    auto whitened = lin.residuals.segment(block.row, block.rows);
    whitened.noalias() = residual.whitening().triangularView<Eigen::Lower>() * scratch.residuals;
    Eigen::Map<RowMajor> jacobian(lin.jacobian.data() + block.jacobian_begin, block.rows, block.column_count);
    if (with_jacobian) {
      gather_columns(problem, unknowns, residual, lin.columns.data() + block.column_begin, block.column_count, scratch);
      jacobian.noalias() = residual.whitening().triangularView<Eigen::Lower>() * scratch.gathered;
      if (!jacobian.allFinite()) return false;
    }
    if (residual.weight_factors.empty()) continue;
    for (int r = 0; r < block.rows; ++r) {
      const double factor = std::sqrt(residual.weight_factors[r]);
      whitened[r] *= factor;
      if (with_jacobian) jacobian.row(r) *= factor;
    }
  }
  lin.sum_of_squares = lin.residuals.squaredNorm();
  return true;
}

void apply_step(Problem& problem, const UnknownIndex& unknowns, const Eigen::VectorXd& step) {
  std::vector<double> tangent, result;
  for (size_t b = 0; b < problem.parameters.size(); ++b) {
    ParameterBlock& block = problem.parameters[b];
    tangent.assign(block.tangent(), 0.0);
    for (int c = 0; c < block.tangent(); ++c) {
      const int unknown = unknowns(static_cast<int>(b), c);
      if (unknown >= 0) tangent[c] = step[unknown];
    }
    if (block.plus) {
      result.resize(block.value.size());
      block.plus(block.value.data(), tangent.data(), result.data());
      block.value = result;
    } else {
      for (int c = 0; c < block.tangent(); ++c) block.value[c] += tangent[c];
    }
  }
}

}  // namespace plumbline::least_squares
