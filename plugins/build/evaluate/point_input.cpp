#include "build/evaluate/point_input.hpp"

namespace plumbline::judgement {

namespace {

BlockCovariance covariance_of(const PointsT& points, const std::string& what) {
  if (!points.covariance.empty())
    return BlockCovariance::from_packed(points.covariance, points.points.size(), "input '" + what + "'");
  std::vector<Eigen::Matrix3d> of_each;
  for (const auto& point : points.points) of_each.push_back(point->sigma.cwiseAbs2().asDiagonal());
  BlockCovariance all = BlockCovariance::independent(of_each);
  return all.allFinite() ? all : BlockCovariance();
}

}  // namespace

PointSet point_set(const PointsT& points, const std::string& what) {
  PointSet set;
  for (const auto& point : points.points) {
    set.ids.push_back(point->id);
    set.positions.push_back(point->position);
  }
  set.covariance = covariance_of(points, what);
  return set;
}

}  // namespace plumbline::judgement
