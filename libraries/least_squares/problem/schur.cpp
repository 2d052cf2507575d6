#include "least_squares/problem/schur.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "least_squares/problem/datum.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

constexpr double singular_block = 1e-12;

/// Kept unknowns that the observations of each block touch, ascending.
std::vector<std::vector<int>> columns_by_block(const PartitionedSystem& system) {
  std::vector<std::vector<int>> columns(static_cast<size_t>(system.eliminated_count));
  for (const auto& rows : system.observations)
    if (rows.eliminated >= 0) {
      auto& mine = columns[static_cast<size_t>(rows.eliminated)];
      mine.insert(mine.end(), rows.columns.begin(), rows.columns.end());
    }
  for (auto& mine : columns) {
    std::sort(mine.begin(), mine.end());
    mine.erase(std::unique(mine.begin(), mine.end()), mine.end());
  }
  return columns;
}

void add_kept_part(const ObservationRows& rows, ReducedSystem& reduced) {
  const Eigen::MatrixXd own = rows.kept.transpose() * rows.kept;
  const Eigen::VectorXd right = rows.kept.transpose() * rows.misclosure;
  for (Eigen::Index c = 0; c < own.cols(); ++c) {
    const int column = rows.columns[static_cast<size_t>(c)];
    reduced.right(column) += right(c);
    for (Eigen::Index r = 0; r < own.rows(); ++r)
      reduced.normal(rows.columns[static_cast<size_t>(r)], column) += own(r, c);
  }
}

void eliminate(EliminatedBlock& block, const Eigen::MatrixXd& own, ReducedSystem& reduced) {
  block.inverse = Eigen::MatrixXd::Zero(own.rows(), own.cols());
  const Eigen::VectorXd scale = own.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * own * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(scaled);
  block.weakest_eigenvalue = own.diagonal().minCoeff() > 0 ? spectrum.eigenvalues()(0) : 0;
  if (block.weakest_eigenvalue < singular_block) return;
  const Eigen::MatrixXd inverse = scale.asDiagonal() * spectrum.eigenvectors() *
                                  spectrum.eigenvalues().cwiseInverse().asDiagonal() *
                                  spectrum.eigenvectors().transpose() * scale.asDiagonal();
  block.inverse = 0.5 * (inverse + inverse.transpose());
  const Eigen::MatrixXd weighted = block.inverse * block.coupling;
  const Eigen::MatrixXd loss = block.coupling.transpose() * weighted;
  const Eigen::VectorXd right = weighted.transpose() * block.right;
  for (size_t c = 0; c < block.columns.size(); ++c) {
    reduced.right(block.columns[c]) -= right(static_cast<Eigen::Index>(c));
    for (size_t r = 0; r < block.columns.size(); ++r)
      reduced.normal(block.columns[r], block.columns[c]) -=
          loss(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
  }
}

Eigen::VectorXd jacobi_scale(const ReducedSystem& reduced) {
  return reduced.diagonal.unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
}

/// Reduced normal matrix in scaled unknowns, inner constraints added with unit weight per scaled constraint.
Eigen::MatrixXd scaled_normal(const PartitionedSystem& system, const ReducedSystem& reduced,
                              const Eigen::VectorXd& scale) {
  Eigen::MatrixXd scaled = scale.asDiagonal() * reduced.normal * scale.asDiagonal();
  if (system.defect() > 0) {
    Eigen::MatrixXd constraints = Eigen::MatrixXd::Zero(system.kept_count, system.defect());
    for (int u : system.datum_unknowns) constraints.row(u) = scale(u) * system.null_space.row(u);
    constraints.colwise().normalize();
    scaled += constraints * constraints.transpose();
  }
  return scaled;
}

/// A Cholesky factor in steps between which the work can be stopped: some hundred unknowns at a time.
class Factor {
 public:
  explicit Factor(Eigen::MatrixXd matrix) : lower_(std::move(matrix)) {
    const Eigen::Index n = lower_.rows();
    for (Eigen::Index at = 0; at < n && is_regular_; at += kStep) {
      stop_point();
      const Eigen::Index width = std::min(kStep, n - at), rest = n - at - width;
      auto corner = lower_.block(at, at, width, width);
      const Eigen::LLT<Eigen::MatrixXd> factor(corner);
      is_regular_ = factor.info() == Eigen::Success;
      corner = factor.matrixLLT();
      if (rest == 0 || !is_regular_) continue;
      auto below = lower_.block(at + width, at, rest, width);
      corner.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
      lower_.bottomRightCorner(rest, rest).selfadjointView<Eigen::Lower>().rankUpdate(below, -1);
    }
  }
  bool is_regular() const { return is_regular_; }
  Eigen::VectorXd solve(Eigen::VectorXd right) const {
    lower_.triangularView<Eigen::Lower>().solveInPlace(right);
    lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(right);
    return right;
  }
  Eigen::MatrixXd inverse() const {
    const Eigen::Index n = lower_.rows();
    Eigen::MatrixXd result = Eigen::MatrixXd::Identity(n, n);
    for (Eigen::Index at = 0; at < n; at += kStep) {
      stop_point();
      auto columns = result.middleCols(at, std::min(kStep, n - at));
      lower_.triangularView<Eigen::Lower>().solveInPlace(columns);
      lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(columns);
    }
    return result;
  }

 private:
  static constexpr Eigen::Index kStep = 128;
  Eigen::MatrixXd lower_;
  bool is_regular_ = true;
};

/// Joint cofactors of one eliminated block and the kept unknowns it depends on; the block first.
Eigen::MatrixXd joint_cofactor(const EliminatedBlock& block, const Eigen::MatrixXd& kept_cofactor,
                               const Eigen::MatrixXd& own) {
  const Eigen::Index size = own.rows(), count = static_cast<Eigen::Index>(block.columns.size());
  const Eigen::MatrixXd kept = kept_cofactor(block.columns, block.columns);
  Eigen::MatrixXd joint(size + count, size + count);
  joint.topLeftCorner(size, size) = own;
  joint.bottomRightCorner(count, count) = kept;
  joint.topRightCorner(size, count) = -block.inverse * block.coupling * kept;
  joint.bottomLeftCorner(count, size) = joint.topRightCorner(size, count).transpose();
  return joint;
}

/// Columns of `rows` as indices into the joint matrix of its block: the block's own unknowns, then the kept ones.
std::vector<int> joint_columns(const ObservationRows& rows, const EliminatedBlock& block) {
  const int size = static_cast<int>(block.inverse.rows());
  std::vector<int> columns(static_cast<size_t>(size));
  std::iota(columns.begin(), columns.end(), 0);
  for (int column : rows.columns) {
    const auto at = std::lower_bound(block.columns.begin(), block.columns.end(), column) - block.columns.begin();
    columns.push_back(size + static_cast<int>(at));
  }
  return columns;
}

}  // namespace

int PartitionedSystem::row_count() const {
  int rows = 0;
  for (const auto& observation : observations) rows += static_cast<int>(observation.misclosure.size());
  return rows;
}

ReducedSystem reduce(const PartitionedSystem& system) {
  ReducedSystem reduced;
  reduced.normal = Eigen::MatrixXd::Zero(system.kept_count, system.kept_count);
  reduced.right = Eigen::VectorXd::Zero(system.kept_count);
  reduced.eliminated.resize(static_cast<size_t>(system.eliminated_count));
  auto columns = columns_by_block(system);
  const Eigen::Index size = system.eliminated_size;
  std::vector<Eigen::MatrixXd> own(reduced.eliminated.size(), Eigen::MatrixXd::Zero(size, size));
  for (size_t i = 0; i < reduced.eliminated.size(); ++i) {
    reduced.eliminated[i].columns = std::move(columns[i]);
    reduced.eliminated[i].right = Eigen::VectorXd::Zero(size);
    reduced.eliminated[i].coupling =
        Eigen::MatrixXd::Zero(size, static_cast<Eigen::Index>(reduced.eliminated[i].columns.size()));
  }
  for (const auto& rows : system.observations) {
    stop_point();
    add_kept_part(rows, reduced);
    if (rows.eliminated < 0) continue;
    EliminatedBlock& block = reduced.eliminated[static_cast<size_t>(rows.eliminated)];
    own[static_cast<size_t>(rows.eliminated)] += rows.own.transpose() * rows.own;
    block.right += rows.own.transpose() * rows.misclosure;
    const Eigen::MatrixXd coupling = rows.own.transpose() * rows.kept;
    for (size_t c = 0; c < rows.columns.size(); ++c) {
      const auto at =
          std::lower_bound(block.columns.begin(), block.columns.end(), rows.columns[c]) - block.columns.begin();
      block.coupling.col(at) += coupling.col(static_cast<Eigen::Index>(c));
    }
  }
  reduced.diagonal = reduced.normal.diagonal();
  for (size_t i = 0; i < reduced.eliminated.size(); ++i)
    stop_point(), eliminate(reduced.eliminated[i], own[i], reduced);
  return reduced;
}

bool solve_corrections(const PartitionedSystem& system, const ReducedSystem& reduced, PartitionedSolution& solution) {
  const Eigen::VectorXd scale = jacobi_scale(reduced);
  const Factor factor(scaled_normal(system, reduced, scale));
  if (!factor.is_regular()) return false;
  solution.kept = scale.asDiagonal() * factor.solve(scale.asDiagonal() * reduced.right);
  solution.eliminated.clear();
  for (const auto& block : reduced.eliminated) {
    Eigen::VectorXd right = block.right;
    for (size_t c = 0; c < block.columns.size(); ++c)
      right -= block.coupling.col(static_cast<Eigen::Index>(c)) * solution.kept(block.columns[c]);
    solution.eliminated.push_back(block.inverse * right);
  }
  return true;
}

void add_cofactors(const PartitionedSystem& system, const ReducedSystem& reduced, PartitionedSolution& solution) {
  const Eigen::VectorXd scale = jacobi_scale(reduced);
  Eigen::MatrixXd inverse = Factor(scaled_normal(system, reduced, scale)).inverse();
  inverse = scale.asDiagonal() * inverse * scale.asDiagonal();
  // (N + B B')⁻¹ belongs to no datum yet: it still holds a part G (...) G', which the S-transformation takes away.
  if (system.defect() > 0) inverse = s_transform(inverse, system.null_space, system.datum_unknowns);
  solution.kept_cofactor = 0.5 * (inverse + inverse.transpose());
  solution.eliminated_cofactor.clear();
  for (const auto& block : reduced.eliminated) {
    const Eigen::MatrixXd influence = block.inverse * block.coupling;
    const Eigen::MatrixXd kept = solution.kept_cofactor(block.columns, block.columns);
    solution.eliminated_cofactor.push_back(block.inverse + influence * kept * influence.transpose());
  }
}

Eigen::MatrixXd cross_cofactor(const EliminatedBlock& block, const Eigen::MatrixXd& kept_cofactor) {
  return -block.inverse * block.coupling * kept_cofactor(block.columns, Eigen::all);
}

std::vector<Eigen::MatrixXd> residual_cofactors(const PartitionedSystem& system, const ReducedSystem& reduced,
                                                const PartitionedSolution& solution) {
  std::vector<Eigen::MatrixXd> joint(reduced.eliminated.size());
  for (size_t i = 0; i < joint.size(); ++i)
    stop_point(),
        joint[i] = joint_cofactor(reduced.eliminated[i], solution.kept_cofactor, solution.eliminated_cofactor[i]);
  std::vector<Eigen::MatrixXd> result;
  result.reserve(system.observations.size());
  for (const auto& rows : system.observations) {
    stop_point();
    const Eigen::Index m = rows.misclosure.size();
    Eigen::MatrixXd fitted;
    if (rows.eliminated < 0) {
      fitted = rows.kept * solution.kept_cofactor(rows.columns, rows.columns) * rows.kept.transpose();
    } else {
      const size_t i = static_cast<size_t>(rows.eliminated);
      const std::vector<int> columns = joint_columns(rows, reduced.eliminated[i]);
      Eigen::MatrixXd design(m, static_cast<Eigen::Index>(columns.size()));
      design << rows.own, rows.kept;
      fitted = design * joint[i](columns, columns) * design.transpose();
    }
    result.push_back(Eigen::MatrixXd::Identity(m, m) - 0.5 * (fitted + fitted.transpose()));
  }
  return result;
}

std::vector<VarianceComponent> variance_components(const PartitionedSystem& system,
                                                   const std::vector<Eigen::MatrixXd>& cofactors) {
  std::vector<VarianceComponent> components(system.groups.size());
  for (size_t g = 0; g < components.size(); ++g) components[g].name = system.groups[g];
  for (size_t i = 0; i < system.observations.size(); ++i) {
    VarianceComponent& component = components[static_cast<size_t>(system.observations[i].group)];
    component.rows += static_cast<int>(system.observations[i].misclosure.size());
    component.sum_of_squares += system.observations[i].misclosure.squaredNorm();
    component.redundancy += cofactors[i].trace();
  }
  for (auto& component : components)
    if (component.redundancy > kUncontrolled) component.factor = component.sum_of_squares / component.redundancy;
  return components;
}

double smallest_scaled_eigenvalue(const PartitionedSystem& system, const ReducedSystem& reduced) {
  const Factor factor(scaled_normal(system, reduced, jacobi_scale(reduced)));
  if (!factor.is_regular()) return 0;
  // A start without symmetry, so that it is orthogonal to no eigenvector that a regular layout would have.
  Eigen::VectorXd vector(system.kept_count);
  for (Eigen::Index i = 0; i < vector.size(); ++i) vector(i) = 1 + 0.5 * std::sin(1.7 * static_cast<double>(i) + 0.3);
  double eigenvalue = 0;
  for (int i = 0; i < 12; ++i) {
    vector.normalize();
    vector = factor.solve(vector);
    eigenvalue = 1 / vector.norm();
  }
  return eigenvalue;
}

ScaledSpectrum scaled_spectrum(const PartitionedSystem& system, const ReducedSystem& reduced) {
  const Eigen::VectorXd scale = jacobi_scale(reduced);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled_normal(system, reduced, scale));
  return {solver.eigenvalues(), scale.asDiagonal() * solver.eigenvectors()};
}

}  // namespace plumbline::least_squares
