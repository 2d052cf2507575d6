// evaluate.errors: what a model's points are off from the truth, in a few numbers, for trials that are repeated often.
#include "build/evaluate/errors_node.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <map>

#include "base/statistics/error_modes.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Rows and columns `wanted` of the points' covariance; empty if they have none.
Eigen::MatrixXd part_of_covariance(const PointsT& model, const std::vector<std::size_t>& wanted, const char* port) {
  const auto n = static_cast<Eigen::Index>(wanted.size());
  const std::size_t all = 3 * model.points.size();
  if (model.covariance.empty()) return {};
  if (model.covariance.size() != all * (all + 1) / 2)
    throw std::runtime_error("input '" + std::string(port) + "': " + std::to_string(model.covariance.size()) +
                             " values of covariance for " + std::to_string(model.points.size()) +
                             " points, expected are " + std::to_string(all * (all + 1) / 2));
  Eigen::MatrixXd part(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const std::size_t a = wanted[i], b = wanted[j];
      const std::size_t row = std::max(a, b), column = std::min(a, b);
      part(i, j) = part(j, i) = model.covariance[row * (row + 1) / 2 + column];
    }
  return part;
}

struct Nees {
  double value = kNan, freedom = kNan;
};

/// eᵀ Σ⁻¹ e; unknown if Σ is, or is not positive definite.
Nees nees_of(const Eigen::VectorXd& errors, const Eigen::MatrixXd& covariance) {
  if (covariance.size() == 0) return {};
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) return {};
  return {errors.dot(factor.solve(errors)), static_cast<double>(errors.size())};
}

}  // namespace

void EvaluateErrors::run(Context& context) {
  const PointsT built = truth.unpack(), found = model.unpack();
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < found.points.size(); ++i) index[found.points[i]->id] = i;
  PointsT off;
  std::vector<std::size_t> heights, coordinates, true_heights, true_coordinates;
  std::vector<std::string> missing;
  std::size_t without_place = 0;
  for (std::size_t i = 0; i < built.points.size(); ++i) {
    const auto& point = built.points[i];
    if (*use != "all" && point->role != *use) continue;
    const auto place = index.find(point->id);
    if (place == index.end() || !found.points[place->second]->position.allFinite()) {
      missing.push_back(point->id);
      without_place += place != index.end();
      continue;
    }
    off.points.push_back(std::make_unique<PointT>(*point));
    off.points.back()->position = found.points[place->second]->position - point->position;
    off.points.back()->sigma = found.points[place->second]->sigma;
    for (std::size_t c = 0; c < 3; ++c) {
      coordinates.push_back(3 * place->second + c);
      true_coordinates.push_back(3 * i + c);
    }
    heights.push_back(3 * place->second + 2);
    true_heights.push_back(3 * i + 2);
  }
  const std::size_t asked = off.points.size() + missing.size();
  if (asked == 0) throw std::runtime_error("input 'truth' has no point of the role '" + *use + "'");
  if (static_cast<double>(missing.size()) > *max_missing * static_cast<double>(asked) || off.points.empty())
    throw std::runtime_error(std::to_string(missing.size()) + " of " + std::to_string(asked) +
                             " points are missing in the model, such as " + missing.front() +
                             (without_place == 0 ? ""
                              : without_place == missing.size()
                                  ? ": their coordinates are no numbers (nan)"
                                  : " (of " + std::to_string(without_place) + " the coordinates are no numbers)") +
                             "; a result on the others alone would flatter it (max_missing)");
  Eigen::MatrixXd of_heights = part_of_covariance(found, heights, "model"),
                  of_all = part_of_covariance(found, coordinates, "model");
  // A truth that was measured is one with errors of its own.
  if (of_heights.size() > 0 && !built.covariance.empty()) {
    of_heights += part_of_covariance(built, true_heights, "truth");
    of_all += part_of_covariance(built, true_coordinates, "truth");
  }
  if (of_heights.size() > 0) {
    of_heights.diagonal().array() += *mounting_sigma * *mounting_sigma;
    of_all.diagonal().array() += *mounting_sigma * *mounting_sigma;
  }
  report(context, off, of_heights, of_all);
  report_modes(context, built, off, of_all);
  context.metric("missing", static_cast<double>(missing.size()), "1");
  errors.commit(off);
}

void EvaluateErrors::report(Context& context, const PointsT& off, const Eigen::MatrixXd& of_heights,
                            const Eigen::MatrixXd& of_all) const {
  const auto n = static_cast<Eigen::Index>(off.points.size());
  Eigen::VectorXd dz(n), all(3 * n);
  double farthest = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d& error = off.points[i]->position;
    dz(i) = error.z();
    all.segment<3>(3 * i) = error;
    farthest = std::max(farthest, error.norm());
  }
  const auto count = static_cast<double>(n);
  context.metric("points", count, "1");
  context.metric("rmse_z", std::sqrt(dz.squaredNorm() / count), "m");
  context.metric("bias_z", dz.mean(), "m");
  context.metric("max_abs_z", dz.cwiseAbs().maxCoeff(), "m");
  context.metric("rmse_3d", std::sqrt(all.squaredNorm() / count), "m");
  context.metric("max_3d", farthest, "m");
  const bool known = of_heights.size() > 0;
  context.metric("predicted_rmse_z", known ? std::sqrt(of_heights.trace() / count) : kNan, "m");
  context.metric("predicted_rmse_3d", known ? std::sqrt(of_all.trace() / count) : kNan, "m");
  const Nees of_z = nees_of(dz, of_heights), of_3d = nees_of(all, of_all);
  context.metric("nees_z", of_z.value, "1");
  context.metric("freedom_z", of_z.freedom, "1");
  context.metric("nees_3d", of_3d.value, "1");
  context.metric("freedom_3d", of_3d.freedom, "1");
}

/// Of the parts that a survey asks of: NEES of all coordinates hides one bad mode among many good ones.
void EvaluateErrors::report_modes(Context& context, const PointsT& built, const PointsT& off,
                                  const Eigen::MatrixXd& of_all) {
  std::map<std::string, Eigen::Vector3d> places;
  for (const auto& point : built.points) places[point->id] = point->position;
  const auto n = static_cast<Eigen::Index>(off.points.size());
  Eigen::VectorXd positions(3 * n), errors(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& point = off.points[i];
    positions.segment<3>(3 * i) = places.at(point->id);
    errors.segment<3>(3 * i) = point->position;
  }
  for (const auto& [name, error] : statistics::error_modes(positions, errors, of_all)) {
    context.metric(name + "_found", error.found, "m");
    context.metric(name + "_predicted", error.predicted, "m");
    context.metric(name + "_nees", error.nees, "1");
    context.metric(name + "_freedom", error.freedom, "1");
  }
}

}  // namespace plumbline::judgement
