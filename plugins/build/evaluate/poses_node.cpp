#include "build/evaluate/poses_node.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/median.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {
namespace {

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// e' C^-1 e of (rotation vector in the camera frame, translation): of six degrees of freedom where C is true.
double squared_error(const PoseT& estimate, const RigidTransform& exact) {
  const Eigen::AngleAxisd turn(exact.rotation * estimate.cam_from_world.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> error;
  error << turn.angle() * turn.axis(), exact.translation - estimate.cam_from_world.translation;
  return error.dot(
      linear_algebra::solve_symmetric(unpack_symmetric(estimate.covariance, 6, "the pose of " + estimate.path), error));
}

}  // namespace

void EvaluatePoses::run(Context& context) {
  const PosesT found = poses.unpack(), known = truth.unpack();
  std::map<std::string, const PoseT*> by_path;
  for (const auto& pose : found.poses) by_path[pose->path] = pose.get();
  if (known.poses.empty()) throw std::runtime_error("input 'truth' has no pose");
  PosesT right;
  std::vector<double> positions, rotations;
  std::size_t missing = 0;
  double squares = 0, freedom = 0;
  for (const auto& pose : known.poses) {
    const auto place = by_path.find(pose->path);
    if (place == by_path.end()) {
      ++missing;
      continue;
    }
    const RigidTransform &estimate = place->second->cam_from_world, &exact = pose->cam_from_world;
    positions.push_back((estimate.inverse().translation - exact.inverse().translation).norm());
    rotations.push_back(estimate.rotation.angularDistance(exact.rotation));
    if (place->second->covariance.size() == 21) squares += squared_error(*place->second, exact), freedom += 6;
    if (positions.back() <= *wrong_above) right.poses.push_back(std::make_unique<PoseT>(*place->second));
  }
  const auto images = static_cast<double>(known.poses.size());
  if (positions.empty() || static_cast<double>(missing) > *max_missing * images)
    throw std::runtime_error(std::to_string(missing) + " of " + std::to_string(known.poses.size()) +
                             " images have no pose; a result on the others alone would flatter it (max_missing)");
  context.metric("pose_nees", freedom > 0 ? squares / freedom : std::nan(""), "1");
  context.metric("pose_freedom", freedom, "1");
  context.metric("images", images, "1");
  context.metric("missing", static_cast<double>(missing), "1");
  context.metric("wrong", static_cast<double>(positions.size() - right.poses.size()), "1");
  context.metric("rms_position", root_mean_square(positions), "m");
  context.metric("median_position", upper_median(positions), "m");
  context.metric("max_position", *std::max_element(positions.begin(), positions.end()), "m");
  context.metric("rms_rotation", root_mean_square(rotations), "rad");
  context.metric("max_rotation", *std::max_element(rotations.begin(), rotations.end()), "rad");
  kept.commit(right);
}

}  // namespace plumbline::judgement
