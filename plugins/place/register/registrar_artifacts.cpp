#include "registrar_artifacts.hpp"

#include <cmath>

#include "artifacts/fitted_datum.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::registration {
namespace {

/// Index of every point by its id. Throws for an id that stands twice.
std::map<std::string, int> index_of(const PointsT& points, const char* port) {
  std::map<std::string, int> index;
  for (size_t i = 0; i < points.points.size(); ++i)
    if (!index.emplace(points.points[i]->id, static_cast<int>(i)).second)
      throw std::runtime_error(std::string("'") + port + "' has two points named " + points.points[i]->id);
  return index;
}

/// The full covariance if it is there, else that of the sigmas, else an empty matrix.
Eigen::MatrixXd covariance_of(const PointsT& points, const char* port) {
  const std::size_t n = 3 * points.points.size();
  if (!points.covariance.empty()) return unpack_symmetric(points.covariance, n, std::string("'") + port + "'");
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(n, n);
  for (size_t i = 0; i < points.points.size(); ++i) {
    const Eigen::Vector3d& sigma = points.points[i]->sigma;
    if (!sigma.allFinite()) return {};
    c.diagonal().segment<3>(static_cast<Eigen::Index>(3 * i)) = sigma.cwiseAbs2();
  }
  return c;
}

Eigen::Matrix3Xd positions_of(const PointsT& points) {
  Eigen::Matrix3Xd p(3, static_cast<Eigen::Index>(points.points.size()));
  for (size_t i = 0; i < points.points.size(); ++i) p.col(static_cast<Eigen::Index>(i)) = points.points[i]->position;
  return p;
}

Eigen::MatrixXd part(const Eigen::MatrixXd& c, const std::vector<int>& chosen) {
  if (c.size() == 0) return {};
  const auto n = static_cast<Eigen::Index>(chosen.size());
  Eigen::MatrixXd out(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) out.block<3, 3>(3 * i, 3 * j) = c.block<3, 3>(3 * chosen[i], 3 * chosen[j]);
  return out;
}

std::vector<double> upper_of(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

}  // namespace

Matched match(const PointsT& from, const PointsT& to) {
  const auto index = index_of(from, "source");
  index_of(to, "target");
  Matched matched;
  for (size_t k = 0; k < to.points.size(); ++k) {
    const PointT& point = *to.points[k];
    const auto other = index.find(point.id);
    if (other == index.end() || point.role == "check" || from.points[other->second]->role == "check") continue;
    matched.points.ids.push_back(point.id);
    matched.from.push_back(other->second);
    matched.to.push_back(static_cast<int>(k));
  }
  if (matched.points.ids.size() < 3)
    throw DegenerateRegistration(
        "a registration needs at least 3 points that both 'source' (" + std::to_string(from.points.size()) +
        " points) and 'target' (" + std::to_string(to.points.size()) +
        " points) have and that are not check points; found " + std::to_string(matched.points.ids.size()));
  matched.points.source = positions_of(from)(Eigen::all, matched.from);
  matched.points.target = positions_of(to)(Eigen::all, matched.to);
  matched.from_covariance = covariance_of(from, "source");
  matched.points.source_covariance = part(matched.from_covariance, matched.from);
  matched.points.target_covariance = part(covariance_of(to, "target"), matched.to);
  return matched;
}

TransformT transform_artifact(const Matched& matched, const RobustRegistration& result, const std::string& estimator,
                              double scale_w) {
  const Registration& found = result.fit;
  TransformT t;
  t.estimator = estimator;
  t.scale_w = scale_w;
  t.to_from_from = found.to_from_from;
  t.scale = found.scale;
  t.covariance = pack_symmetric(found.covariance);
  for (size_t i = 0; i < matched.points.ids.size(); ++i) {
    auto residual = std::make_unique<RegistrationResidualT>();
    residual->id = matched.points.ids[i];
    residual->residual = result.residuals.col(static_cast<Eigen::Index>(i));
    residual->weight = result.weights(static_cast<Eigen::Index>(i));
    residual->w = result.w.col(static_cast<Eigen::Index>(i));
    t.residuals.push_back(std::move(residual));
  }
  t.residual_covariance = upper_of(found.residual_covariance);
  t.residual_covariance_unbiased = upper_of(found.residual_covariance_unbiased);
  t.statistics = std::make_unique<StatisticsT>();
  t.statistics->sigma0 = found.sigma0;
  t.statistics->degrees_of_freedom = found.degrees_of_freedom;
  t.statistics->weighted_sum_of_squares = found.weighted_sum_of_squares;
  t.statistics->observations = static_cast<int64_t>(3 * result.used.size());
  t.statistics->unknowns = found.unknowns;
  return t;
}

PointsT points_artifact(const PointsT& from, const PointsT& to, const Matched& matched,
                        const RobustRegistration& result) {
  std::vector<int> fitted;
  for (int i : result.used) fitted.push_back(matched.from[i]);
  const MovedPoints moved = move_points(result.fit, positions_of(from), matched.from_covariance, fitted,
                                        part(matched.points.target_covariance, result.used));
  std::map<std::string, std::string> roles;
  for (const auto& point : to.points) roles[point->id] = point->role;
  PointsT points;
  for (size_t i = 0; i < from.points.size(); ++i) {
    auto point = std::make_unique<PointT>(*from.points[i]);
    const auto k = static_cast<Eigen::Index>(i);
    point->position = moved.positions.col(k);
    point->sigma.setConstant(std::nan(""));
    if (moved.covariance.size() > 0)
      point->sigma = moved.covariance.diagonal().segment<3>(3 * k).cwiseMax(0).cwiseSqrt();
    if (point->role.empty() && roles.count(point->id)) point->role = roles[point->id];
    points.points.push_back(std::move(point));
  }
  points.covariance = pack_symmetric(moved.covariance);
  take_datum(to, points);
  return points;
}

}  // namespace plumbline::registration
