#include "photo/markers/rig.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/median.hpp"

namespace plumbline::markers {
namespace {

struct Moment {
  std::string name;
  RigidTransform cam_from_reference;
};

std::vector<Moment> shared(const std::vector<RigView>& camera, const std::vector<RigView>& reference) {
  std::map<std::string, const RigView*> by_moment;
  for (const auto& view : reference) by_moment[view.moment] = &view;
  std::vector<Moment> moments;
  for (const auto& view : camera)
    if (const auto other = by_moment.find(view.moment); other != by_moment.end())
      moments.push_back({view.moment, view.cam_from_board * other->second->cam_from_board.inverse()});
  return moments;
}

/// Mean rotation: the largest eigenvector of Σ q qᵀ (Markley et al. 2007, Averaging quaternions).
RigidTransform mean_of(const std::vector<Moment>& moments) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  for (const auto& m : moments) {
    const Eigen::Vector4d q = m.cam_from_reference.rotation.coeffs();
    sum += q * q.transpose();
    translation += m.cam_from_reference.translation / static_cast<double>(moments.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sum);
  RigidTransform mean;
  mean.rotation.coeffs() = solver.eigenvectors().col(3);
  if (mean.rotation.w() < 0) mean.rotation.coeffs() *= -1;
  mean.translation = translation;
  return mean;
}

Eigen::Vector3d turn_between(const RigidTransform& a, const RigidTransform& b) {
  const Eigen::AngleAxisd turn(a.rotation * b.rotation.conjugate());
  return turn.angle() * turn.axis();
}

/// The moment that most others agree with: a start that blunders do not draw.
RigidTransform middle_of(const std::vector<Moment>& moments) {
  double lowest = 1e300;
  RigidTransform best;
  for (const auto& m : moments) {
    std::vector<double> distances;
    for (const auto& other : moments)
      distances.push_back(
          (m.cam_from_reference.inverse().translation - other.cam_from_reference.inverse().translation).norm());
    const double typical = upper_median(distances);
    if (typical < lowest) lowest = typical, best = m.cam_from_reference;
  }
  return best;
}

RigPose pose_of(const std::vector<Moment>& moments) {
  RigPose pose;
  const RigidTransform start = middle_of(moments);
  std::vector<double> turns, shifts;
  for (const auto& m : moments) {
    turns.push_back(turn_between(m.cam_from_reference, start).norm());
    shifts.push_back((m.cam_from_reference.inverse().translation - start.inverse().translation).norm());
  }
  const double most_turn = 5 * std::max(upper_median(turns), 1e-4),
               most_shift = 5 * std::max(upper_median(shifts), 1e-5);
  std::vector<Moment> good;
  for (size_t i = 0; i < moments.size(); ++i)
    if (turns[i] <= most_turn && shifts[i] <= most_shift)
      good.push_back(moments[i]), pose.moments.push_back(moments[i].name);
    else
      pose.left_out.push_back(moments[i].name);
  pose.cam_from_reference = mean_of(good);
  Eigen::Vector3d turn = Eigen::Vector3d::Zero(), shift = Eigen::Vector3d::Zero();
  for (const auto& m : good) {
    turn += turn_between(m.cam_from_reference, pose.cam_from_reference).cwiseAbs2();
    shift += (m.cam_from_reference.translation - pose.cam_from_reference.translation).cwiseAbs2();
  }
  const double n = static_cast<double>(good.size());
  pose.rotation_scatter = std::sqrt(turn.sum() / n), pose.translation_scatter = std::sqrt(shift.sum() / n);
  pose.rotation_sigma = (turn / (n * std::max(1.0, n - 1))).cwiseSqrt();
  pose.translation_sigma = (shift / (n * std::max(1.0, n - 1))).cwiseSqrt();
  return pose;
}

}  // namespace

std::vector<RigPose> rig_of(const std::vector<std::vector<RigView>>& cameras) {
  constexpr size_t enough = 3;
  std::vector<RigPose> rig;
  for (size_t k = 1; k < cameras.size(); ++k) {
    std::vector<Moment> most;
    size_t reference = 0;
    for (size_t other = 0; other < k; ++other)
      if (auto moments = shared(cameras[k], cameras[other]); moments.size() > most.size())
        most = std::move(moments), reference = other;
    if (most.size() < enough) continue;
    rig.push_back(pose_of(most));
    rig.back().camera = static_cast<int>(k), rig.back().reference = static_cast<int>(reference);
  }
  return rig;
}

}  // namespace plumbline::markers
