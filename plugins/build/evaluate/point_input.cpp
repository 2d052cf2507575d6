#include "build/evaluate/point_input.hpp"

#include <memory>
#include <span>

namespace plumbline::judgement {

PointSet point_set(const Points& points, const std::string& what) {
  PointSet set;
  std::vector<Eigen::Matrix3d> of_each;
  for (const Point* packed : *points.points()) {
    const std::unique_ptr<PointT> point(packed->UnPack());
    set.ids.push_back(point->id);
    set.positions.push_back(point->position);
    of_each.push_back(point->sigma.cwiseAbs2().asDiagonal());
  }
  if (const auto* packed = points.covariance(); packed && packed->size() > 0) {
    set.covariance = BlockCovariance::from_packed(std::span<const double>(packed->data(), packed->size()),
                                                  set.ids.size(), "input '" + what + "'");
    return set;
  }
  set.covariance = BlockCovariance::independent(of_each);
  if (!set.covariance.allFinite()) set.covariance = {};
  return set;
}

}  // namespace plumbline::judgement
