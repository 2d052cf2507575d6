#include "survey/network/held_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "geometry/linear_algebra/decompositions.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;

/// Readings of a held point, were its held coordinates unknown too: with C their partials by these,
///   gradient C'Pv, own C'PC, network A'PC by unknown.
struct Freed {
  int point = -1;         ///< of the model
  std::vector<int> axes;  ///< that are held
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  std::map<int, Eigen::Vector3d> network;
};

/// By parameter block.
std::map<int, Freed> held_blocks(const NetworkModel& model, const NetworkProblem& problem) {
  std::map<int, Freed> held;
  for (std::size_t i = 0; i < model.ids.size(); ++i) {
    Freed freed;
    freed.point = static_cast<int>(i);
    for (int axis = 0; axis < 3; ++axis)
      if (model.roles[i][axis] == CoordinateRole::fixed) freed.axes.push_back(axis);
    if (!freed.axes.empty()) held.emplace(problem.point_blocks[i], std::move(freed));
  }
  return held;
}

/// Whitened partials of a residual block by the held coordinates of its parameter `k`: rows x 3, unused ones 0.
Eigen::MatrixXd partials_of(const least_squares::Problem& problem, const least_squares::ResidualBlock& block,
                            std::size_t k, const std::vector<int>& axes) {
  std::vector<const double*> values;
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  for (const int p : block.parameters) {
    values.push_back(problem.parameters[p].value.data());
    storage.emplace_back(static_cast<std::size_t>(block.rows()) * problem.parameters[p].tangent(), 0.0);
  }
  for (auto& s : storage) jacobians.push_back(s.data());
  Eigen::VectorXd residuals(block.rows());
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(block.rows(), 3);
  if (!block.evaluate(values.data(), residuals.data(), jacobians.data())) return c;
  const int tangent = problem.parameters[block.parameters[k]].tangent();
  for (std::size_t a = 0; a < axes.size(); ++a)
    for (Index r = 0; r < c.rows(); ++r) c(r, static_cast<Index>(a)) = storage[k][r * tangent + axes[a]];
  return block.whitening() * c;
}

void add_readings(const NetworkProblem& problem, const least_squares::Linearisation& lin, std::map<int, Freed>& held) {
  for (std::size_t b = 0; b < lin.blocks.size(); ++b) {
    const least_squares::ResidualBlock& block = *problem.problem.residuals[b];
    const auto& rows = lin.blocks[b];
    for (std::size_t k = 0; k < block.parameters.size(); ++k) {
      const auto at = held.find(block.parameters[k]);
      if (at == held.end()) continue;
      Freed& freed = at->second;
      const Eigen::MatrixXd c = partials_of(problem.problem, block, k, freed.axes);
      freed.gradient += c.transpose() * lin.residuals.segment(rows.row, rows.rows);
      freed.own += c.transpose() * c;
      const Eigen::MatrixXd network = lin.jacobian_of(rows).transpose() * c;  // columns x 3
      for (int column = 0; column < rows.column_count; ++column)
        freed.network.try_emplace(lin.columns[rows.column_begin + column], Eigen::Vector3d::Zero()).first->second +=
            network.row(column).transpose();
    }
  }
}

/// f'Qf of the three columns of `network`, and of their sums by pairs, from which the products follow.
void add_functionals(const Freed& freed, std::vector<least_squares::Functional>& functionals) {
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) {
      least_squares::Functional f;
      for (const auto& [unknown, c] : freed.network)
        if (const double value = a == b ? c[a] : c[a] + c[b]; value != 0) f.emplace_back(unknown, value);
      functionals.push_back(std::move(f));
    }
}

Eigen::Matrix3d product_of(const Eigen::VectorXd& variances, Index first) {
  Eigen::Matrix3d q;
  Index k = first;
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) q(a, b) = variances[k++];
  for (int a = 0; a < 3; ++a)
    for (int b = a + 1; b < 3; ++b) q(a, b) = q(b, a) = 0.5 * (q(a, b) - q(a, a) - q(b, b));
  return q;
}

/// With M = C'P Qvv P C the readings put the point d = -M^-1 C'Pv from where it is held, with the covariance M^-1: over
/// the directions in which anything but the point itself says so.
KnownPoint tested(const std::string& id, const Freed& freed, const Eigen::Matrix3d& network, double rounding) {
  // Of its own readings' weight: below that it is the noise of linearisation and of weak ties.
  constexpr double kTestable = 1e-6;
  KnownPoint result;
  result.id = id;
  const auto n = static_cast<Index>(freed.axes.size());
  const linear_algebra::SymmetricEigen eigen(Eigen::MatrixXd((freed.own - network).topLeftCorner(n, n)));
  const double own = freed.own.topLeftCorner(n, n).trace();
  Eigen::VectorXd d = Eigen::VectorXd::Zero(n);
  for (Index k = 0; k < n; ++k) {
    const double weight = eigen.eigenvalues()[k];
    if (!(weight > kTestable * own)) continue;
    const double along = -eigen.eigenvectors().col(k).dot(freed.gradient.head(n)) / weight;
    d += eigen.eigenvectors().col(k) * along;
    result.statistic += along * along / (1 / weight + rounding);
    result.explained += along * along * weight;
    ++result.rank;
  }
  for (Index k = 0; k < n; ++k) {
    result.difference[freed.axes[static_cast<std::size_t>(k)]] = d[k];
    result.sigma[freed.axes[static_cast<std::size_t>(k)]] = 0;
  }
  return result;
}

}  // namespace

double rounding_variance(const std::vector<double>& coordinates) {
  constexpr double kHalf = 0.0005, kNoise = 1e-7;  // [m]
  const bool whole = std::all_of(coordinates.begin(), coordinates.end(), [&](double value) {
    return std::abs(value - std::round(1e3 * value) / 1e3) < kNoise;
  });
  return whole ? kHalf * kHalf / 3 : 0;
}

std::vector<KnownPoint> test_held_points(const NetworkModel& model, const NetworkProblem& problem,
                                         const least_squares::Solution& solution,
                                         const least_squares::Cofactors& cofactors) {
  std::map<int, Freed> held = held_blocks(model, problem);
  if (held.empty()) return {};
  add_readings(problem, solution.linearisation, held);
  std::vector<least_squares::Functional> functionals;
  for (const auto& [block, freed] : held) add_functionals(freed, functionals);
  const Eigen::VectorXd variances = cofactors.variances(functionals);
  std::vector<double> written;
  for (const auto& [block, freed] : held)
    for (const int axis : freed.axes) written.push_back(model.initial[freed.point][axis]);
  const double rounding = 2 * rounding_variance(written);  // its own, and as much again of its neighbours
  std::vector<KnownPoint> result;
  Index first = 0;
  for (const auto& [block, freed] : held) {
    if (!freed.own.isZero(0))
      result.push_back(tested(model.ids[freed.point], freed, product_of(variances, first), rounding));
    first += 6;
  }
  return result;
}

}  // namespace plumbline::survey
