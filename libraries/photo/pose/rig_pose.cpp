#include "photo/pose/rig_pose.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "geometry/edge_inset.hpp"
#include "geometry/samples.hpp"
#include "geometry/statistics.hpp"
#include "geometry/tag_under_pose.hpp"

namespace plumbline::pose {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kKept = 8;  ///< hypotheses that are refined
constexpr double kLenience = 25;  ///< on squared distances of a pose that is not refined yet
constexpr int kRounds = 8;        ///< of choosing inliers and fitting to them

struct Equations {
  Matrix6 normal = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  double sum_of_squares = 0;
};

class Estimator {
 public:
  Estimator(const std::vector<RigView>& views, const std::vector<RigTag>& tags, const TagPoseOptions& options)
      : views_(views), given_(tags), gate_(chi_squared_quantile(options.inlier_probability, 8)) {
    for (const RigTag& tag : tags) tags_.emplace_back(tag.tag, options);
  }

  double gate() const { return gate_; }

  /// Low is good; a tag that is far off counts by the logarithm of how far.
  double score(const RigidTransform& pose) const {
    double sum = 0;
    for (std::size_t i = 0; i < tags_.size(); ++i) sum += std::log1p(std::min(distance(i, pose), 1e12) / gate_);
    return sum;
  }

  std::vector<bool> inliers(const RigidTransform& pose, double limit) const {
    std::vector<bool> list;
    for (std::size_t i = 0; i < tags_.size(); ++i) list.push_back(distance(i, pose) <= limit);
    return list;
  }

  /// Fits to the chosen tags. Weights depend on the pose and are held within a fit; a few fits follow one another.
  RigidTransform refine(const std::vector<bool>& chosen, RigidTransform pose) const {
    for (int round = 0; round < 5; ++round) {
      std::vector<TagWeight> held;
      if (!weights(chosen, pose, held)) return pose;
      const RigidTransform before = pose;
      pose = minimise(chosen, held, pose);
      if ((pose.translation - before.translation).norm() < 1e-9 * (1 + pose.translation.norm())) break;
    }
    return pose;
  }

  /// Fits to the tags of the sample, then to those that agree, as the gate closes.
  RigidTransform polish(RigidTransform pose, const std::vector<int>& sample) const {
    std::vector<bool> chosen(tags_.size(), false);
    for (const int i : sample) chosen[i] = true;
    pose = refine(chosen, pose);
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<bool> now = inliers(pose, gate_ * std::max(1.0, kLenience / ((round + 1) * (round + 1))));
      if (std::count(now.begin(), now.end(), true) < 3) break;
      pose = refine(now, pose);
    }
    return pose;
  }

  /// Throws NoTagPose if the pose leads behind a tag.
  Matrix6 covariance(const std::vector<bool>& chosen, const RigidTransform& pose) const {
    std::vector<TagWeight> own;
    Equations equations;
    if (!weights(chosen, pose, own) || !assemble(chosen, own, pose, equations))
      throw NoTagPose("the pose leads behind a tag");
    return equations.normal.ldlt().solve(Matrix6::Identity());
  }

  /// Right side of the normal equations there. Throws as covariance().
  Vector6 pull(const std::vector<bool>& chosen, const RigidTransform& pose) const {
    std::vector<TagWeight> own;
    Equations equations;
    if (!weights(chosen, pose, own) || !assemble(chosen, own, pose, equations))
      throw NoTagPose("the pose leads behind a tag");
    return equations.right;
  }

  double sum_of_squares(std::size_t i, const RigidTransform& pose) const {
    ProjectedTag tag;
    return project(i, pose, tag) ? tag.sum_of_squares() : 0;
  }

 private:
  MatrixPose in_camera(std::size_t i, const RigidTransform& pose) const {
    return MatrixPose(views_[given_[i].view].cam_from_rig * pose);
  }
  double distance(std::size_t i, const RigidTransform& pose) const {
    return tags_[i].distance(views_[given_[i].view].camera, in_camera(i, pose));
  }
  bool project(std::size_t i, const RigidTransform& pose, ProjectedTag& tag) const {
    return tags_[i].project(views_[given_[i].view].camera, in_camera(i, pose), tag);
  }

  bool weights(const std::vector<bool>& chosen, const RigidTransform& pose, std::vector<TagWeight>& list) const {
    list.resize(tags_.size());
    for (std::size_t i = 0; i < tags_.size(); ++i) {
      if (!chosen[i]) continue;
      ProjectedTag tag;
      TagCovariance spread;
      if (!project(i, pose, tag)) return false;
      tags_[i].covariance(in_camera(i, pose), tag, spread);
      if (!list[i].compute(spread)) return false;
    }
    return true;
  }

  /// A step (w, d) of the rig is (C w, C d) in the frame of a camera that is turned by C against it.
  bool assemble(const std::vector<bool>& chosen, const std::vector<TagWeight>& weights, const RigidTransform& pose,
                Equations& sum) const {
    sum = {};
    for (std::size_t i = 0; i < tags_.size(); ++i) {
      if (!chosen[i]) continue;
      ProjectedTag tag;
      if (!project(i, pose, tag)) return false;
      PoseEquations own;
      own.add(tag, weights[i]);
      Matrix6 cam_from_rig = Matrix6::Zero();
      cam_from_rig.topLeftCorner<3, 3>() = views_[given_[i].view].cam_from_rig.rotation.toRotationMatrix();
      cam_from_rig.bottomRightCorner<3, 3>() = cam_from_rig.topLeftCorner<3, 3>();
      sum.normal += cam_from_rig.transpose() * own.normal() * cam_from_rig;
      sum.right += cam_from_rig.transpose() * own.right();
      sum.sum_of_squares += own.sum_of_squares();
    }
    return true;
  }

  /// Levenberg-Marquardt with fixed weights.
  RigidTransform minimise(const std::vector<bool>& chosen, const std::vector<TagWeight>& weights,
                          RigidTransform pose) const {
    double damping = 1e-4;
    Equations here, there;
    if (!assemble(chosen, weights, pose, here)) return pose;
    for (int attempt = 0; attempt < 60; ++attempt) {
      Matrix6 damped = here.normal;
      damped.diagonal() *= 1 + damping;
      const Vector6 step = damped.ldlt().solve(here.right);
      if (!step.allFinite()) return pose;
      const RigidTransform trial{(quaternion_from_rotation_vector(step.head<3>()) * pose.rotation).normalized(),
                                 pose.translation + step.tail<3>()};
      if (step.norm() < 1e-10 * (1 + pose.translation.norm())) return trial;
      const bool better =
          assemble(chosen, weights, trial, there) && there.sum_of_squares <= here.sum_of_squares * (1 + 1e-12);
      if (better) pose = trial, std::swap(here, there);
      damping = better ? std::max(0.1 * damping, 1e-12) : 10 * damping;
    }
    return pose;
  }

  const std::vector<RigView>& views_;
  const std::vector<RigTag>& given_;
  std::vector<TagInWorld> tags_;
  double gate_;
};

/// Standard deviations [rad, m] of the pose, with sign, by what the edges of all tags in one view are drawn in
/// together.
Vector6 pose_moved_by_inset(const std::vector<RigView>& views, const std::vector<RigTag>& tags, std::size_t view,
                            const TagPoseOptions& options, const RigPose& found, const Estimator& estimator) {
  std::vector<RigTag> displaced = tags;
  for (RigTag& tag : displaced) {
    if (tag.view != view) continue;
    const std::array<Eigen::Vector2d, 4> moved = moved_by_inset(tag.tag.pixels);
    for (std::size_t k = 0; k < 4; ++k) tag.tag.pixels[k] += views[view].inset_sigma * moved[k];
  }
  const Vector6 here = estimator.pull(found.inliers, found.rig_from_world);
  const Estimator other(views, displaced, options);
  return found.covariance * (other.pull(found.inliers, found.rig_from_world) - here);
}

struct Hypothesis {
  double score;
  RigidTransform pose;
  std::vector<int> sample;
};

std::vector<Hypothesis> best_hypotheses(const Estimator& estimator, const std::vector<RigView>& views,
                                        const std::vector<RigTag>& tags, const RigPoseSolver& solver,
                                        const TagPoseOptions& options) {
  std::vector<Hypothesis> list;
  Samples samples(static_cast<int>(tags.size()), options.sample_size, options.max_samples, options.seed);
  for (std::vector<int> sample; samples.next(sample);) {
    std::vector<const RigTag*> chosen;
    for (const int i : sample) chosen.push_back(&tags[i]);
    for (const RigidTransform& pose : solver(views, chosen)) {
      if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite()) continue;
      const double score = estimator.score(pose);
      const auto place = std::find_if(list.begin(), list.end(), [&](const Hypothesis& h) { return score < h.score; });
      list.insert(place, {score, pose, sample});
      if (list.size() > kKept) list.pop_back();
    }
  }
  return list;
}

RigPose estimate_centred(const std::vector<RigView>& views, const std::vector<RigTag>& tags,
                         const RigPoseSolver& solver, const TagPoseOptions& options) {
  const std::string count = std::to_string(tags.size());
  if (static_cast<int>(tags.size()) < options.sample_size)
    throw NoTagPose("a pose needs " + std::to_string(options.sample_size) + " tags, there are " + count);
  const Estimator estimator(views, tags, options);
  RigPose result;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Hypothesis& hypothesis : best_hypotheses(estimator, views, tags, solver, options)) {
    const RigidTransform pose = estimator.polish(hypothesis.pose, hypothesis.sample);
    const double score = estimator.score(pose);
    if (score < lowest) lowest = score, result.rig_from_world = pose;
  }
  if (!(lowest < std::numeric_limits<double>::infinity()))
    throw NoTagPose("the solver gives no pose for any sample of " + count + " tags");
  result.inliers = estimator.inliers(result.rig_from_world, estimator.gate());
  result.inlier_count = static_cast<int>(std::count(result.inliers.begin(), result.inliers.end(), true));
  if (result.inlier_count < 3)
    throw NoTagPose("no pose agrees with three tags: the best one agrees with " + std::to_string(result.inlier_count) +
                    " of " + count);
  result.rig_from_world = estimator.refine(result.inliers, result.rig_from_world);
  result.covariance = estimator.covariance(result.inliers, result.rig_from_world);
  // Each camera draws edges in its own way, as in blocks.
  Matrix6 of_insets = Matrix6::Zero();
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!(views[v].inset_sigma > 0)) continue;
    const Vector6 together = pose_moved_by_inset(views, tags, v, options, result, estimator);
    of_insets += together * together.transpose();
  }
  result.covariance += of_insets;
  return result;
}

}  // namespace

RigPose estimate_rig_pose(const std::vector<RigView>& views, const std::vector<RigTag>& tags,
                          const RigPoseSolver& solver, const TagPoseOptions& options) {
  // National coordinates have millions of metres: a rotation about their origin could not be told from a translation.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const RigTag& tag : tags) centre += tag.tag.anchor_in_world / static_cast<double>(tags.size());
  std::vector<RigTag> local = tags;
  for (RigTag& tag : local) {
    tag.tag.anchor_in_world -= centre;
    tag.tag.world_from_tag.translation -= centre;
  }
  RigPose result = estimate_centred(views, local, solver, options);
  const Eigen::Vector3d shift = result.rig_from_world.rotation * centre;
  result.rig_from_world.translation -= shift;
  Matrix6 step_from_local = Matrix6::Identity();
  step_from_local.bottomLeftCorner<3, 3>() = skew(shift);
  result.covariance = step_from_local * result.covariance * step_from_local.transpose();
  return result;
}

double rms_in_view(const std::vector<RigView>& views, const std::vector<RigTag>& tags, const RigPose& pose,
                   std::size_t view, double plate_rotation_sigma) {
  TagPoseOptions options;
  options.plate_rotation_sigma = plate_rotation_sigma;
  const Estimator estimator(views, tags, options);
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < tags.size(); ++i)
    if (tags[i].view == view && pose.inliers[i]) sum += estimator.sum_of_squares(i, pose.rig_from_world), ++count;
  return std::sqrt(sum / (8.0 * count));
}

}  // namespace plumbline::pose
