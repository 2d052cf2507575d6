#include "linear_block.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace plumbline::adjust {
namespace {

constexpr double singular_pose = 1e-12;

/// Columns that the observations of each camera touch, ascending.
std::vector<std::vector<int>> columns_by_camera(const LinearBlock& block) {
  std::vector<std::vector<int>> columns(static_cast<size_t>(block.camera_count));
  for (const auto& rows : block.observations)
    if (rows.camera >= 0) {
      auto& mine = columns[static_cast<size_t>(rows.camera)];
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

void eliminate(EliminatedCamera& camera, const Matrix6& own, ReducedSystem& reduced) {
  const Vector6 scale = own.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix6 scaled = scale.asDiagonal() * own * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> spectrum(scaled);
  camera.weakest_eigenvalue = own.diagonal().minCoeff() > 0 ? spectrum.eigenvalues()(0) : 0;
  if (camera.weakest_eigenvalue < singular_pose) return;
  const Matrix6 inverse = scale.asDiagonal() * spectrum.eigenvectors() *
                          spectrum.eigenvalues().cwiseInverse().asDiagonal() * spectrum.eigenvectors().transpose() *
                          scale.asDiagonal();
  camera.inverse = 0.5 * (inverse + inverse.transpose());
  const Eigen::MatrixXd weighted = camera.inverse * camera.coupling;
  const Eigen::MatrixXd loss = camera.coupling.transpose() * weighted;
  const Eigen::VectorXd right = weighted.transpose() * camera.right;
  for (size_t c = 0; c < camera.columns.size(); ++c) {
    reduced.right(camera.columns[c]) -= right(static_cast<Eigen::Index>(c));
    for (size_t r = 0; r < camera.columns.size(); ++r)
      reduced.normal(camera.columns[r], camera.columns[c]) -=
          loss(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
  }
}

Eigen::VectorXd jacobi_scale(const ReducedSystem& reduced) {
  return reduced.diagonal.unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
}

/// Reduced normal matrix in scaled unknowns, inner constraints added with unit weight per scaled constraint.
Eigen::MatrixXd scaled_normal(const LinearBlock& block, const ReducedSystem& reduced, const Eigen::VectorXd& scale) {
  Eigen::MatrixXd scaled = scale.asDiagonal() * reduced.normal * scale.asDiagonal();
  if (block.datum.cols() > 0) {
    Eigen::MatrixXd constraints = scale.asDiagonal() * block.datum;
    constraints.colwise().normalize();
    scaled += constraints * constraints.transpose();
  }
  return scaled;
}

}  // namespace

int LinearBlock::row_count() const {
  int rows = 0;
  for (const auto& observation : observations) rows += static_cast<int>(observation.misclosure.size());
  return rows;
}

ReducedSystem reduce(const LinearBlock& block) {
  ReducedSystem reduced;
  reduced.normal = Eigen::MatrixXd::Zero(block.kept_count, block.kept_count);
  reduced.right = Eigen::VectorXd::Zero(block.kept_count);
  reduced.cameras.resize(static_cast<size_t>(block.camera_count));
  auto columns = columns_by_camera(block);
  std::vector<Matrix6> own(reduced.cameras.size(), Matrix6::Zero());
  for (size_t i = 0; i < reduced.cameras.size(); ++i) {
    reduced.cameras[i].columns = std::move(columns[i]);
    reduced.cameras[i].coupling =
        Eigen::MatrixXd::Zero(6, static_cast<Eigen::Index>(reduced.cameras[i].columns.size()));
  }
  for (const auto& rows : block.observations) {
    add_kept_part(rows, reduced);
    if (rows.camera < 0) continue;
    EliminatedCamera& camera = reduced.cameras[static_cast<size_t>(rows.camera)];
    own[static_cast<size_t>(rows.camera)] += rows.pose.transpose() * rows.pose;
    camera.right += rows.pose.transpose() * rows.misclosure;
    const Eigen::MatrixXd coupling = rows.pose.transpose() * rows.kept;
    for (size_t c = 0; c < rows.columns.size(); ++c) {
      const auto at =
          std::lower_bound(camera.columns.begin(), camera.columns.end(), rows.columns[c]) - camera.columns.begin();
      camera.coupling.col(at) += coupling.col(static_cast<Eigen::Index>(c));
    }
  }
  reduced.diagonal = reduced.normal.diagonal();
  for (size_t i = 0; i < reduced.cameras.size(); ++i) eliminate(reduced.cameras[i], own[i], reduced);
  return reduced;
}

bool solve_corrections(const LinearBlock& block, const ReducedSystem& reduced, LinearSolution& solution) {
  const Eigen::VectorXd scale = jacobi_scale(reduced);
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled_normal(block, reduced, scale));
  if (factor.info() != Eigen::Success) return false;
  solution.kept = scale.asDiagonal() * factor.solve(scale.asDiagonal() * reduced.right);
  solution.poses.clear();
  for (const auto& camera : reduced.cameras) {
    Vector6 right = camera.right;
    for (size_t c = 0; c < camera.columns.size(); ++c)
      right -= camera.coupling.col(static_cast<Eigen::Index>(c)) * solution.kept(camera.columns[c]);
    solution.poses.push_back(camera.inverse * right);
  }
  return true;
}

void add_cofactors(const LinearBlock& block, const ReducedSystem& reduced, LinearSolution& solution) {
  const Eigen::VectorXd scale = jacobi_scale(reduced);
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled_normal(block, reduced, scale));
  Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(block.kept_count, block.kept_count));
  if (block.datum.cols() > 0) {
    // (N + BBᵀ)⁻¹ still holds the datum itself: G (GᵀBBᵀG)⁻¹ Gᵀ, G the null space of N. All in scaled unknowns.
    Eigen::MatrixXd constraints = scale.asDiagonal() * block.datum;
    constraints.colwise().normalize();
    const Eigen::MatrixXd null_space = scale.cwiseInverse().asDiagonal() * block.null_space;
    const Eigen::MatrixXd product = constraints.transpose() * null_space;
    const Eigen::MatrixXd basis = null_space * product.inverse();
    inverse -= basis * basis.transpose();
  }
  inverse = scale.asDiagonal() * inverse * scale.asDiagonal();
  solution.kept_cofactor = 0.5 * (inverse + inverse.transpose());
  solution.pose_cofactor.clear();
  for (const auto& camera : reduced.cameras) {
    const Eigen::MatrixXd influence = camera.inverse * camera.coupling;
    const Eigen::MatrixXd kept = solution.kept_cofactor(camera.columns, camera.columns);
    solution.pose_cofactor.push_back(camera.inverse + influence * kept * influence.transpose());
  }
}

Eigen::MatrixXd pose_kept_cofactor(const EliminatedCamera& camera, const Eigen::MatrixXd& kept_cofactor) {
  return -camera.inverse * camera.coupling * kept_cofactor(camera.columns, Eigen::all);
}

double smallest_scaled_eigenvalue(const LinearBlock& block, const ReducedSystem& reduced) {
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled_normal(block, reduced, jacobi_scale(reduced)));
  if (factor.info() != Eigen::Success) return 0;
  // A start without symmetry, so that it is orthogonal to no eigenvector that a regular layout would have.
  Eigen::VectorXd vector(block.kept_count);
  for (Eigen::Index i = 0; i < vector.size(); ++i) vector(i) = 1 + 0.5 * std::sin(1.7 * static_cast<double>(i) + 0.3);
  double eigenvalue = 0;
  for (int i = 0; i < 12; ++i) {
    vector.normalize();
    vector = factor.solve(vector);
    eigenvalue = 1 / vector.norm();
  }
  return eigenvalue;
}

ScaledSpectrum scaled_spectrum(const LinearBlock& block, const ReducedSystem& reduced) {
  const Eigen::VectorXd scale = jacobi_scale(reduced);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled_normal(block, reduced, scale));
  return {solver.eigenvalues(), scale.asDiagonal() * solver.eigenvectors()};
}

}  // namespace plumbline::adjust
