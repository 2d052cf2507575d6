#include "geometry/tag_pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "geometry/edge_inset.hpp"
#include "geometry/samples.hpp"
#include "geometry/similarity.hpp"
#include "geometry/statistics.hpp"
#include "geometry/tag_under_pose.hpp"

namespace plumbline {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A hypothesis from three approximate tags extrapolates their errors to the others: before refinement a tag may be
/// this much further off, as a factor on the squared distance.
constexpr double kLenience = 25;

/// Poses that are only told apart need no more digits than that; the answer itself is fitted to the last one.
constexpr double kRough = 1e-6;

/// Takes the pose by a tangent step.
RigidTransform moved(const RigidTransform& pose, const Vector6& step) {
  return {(quaternion_from_rotation_vector(step.head<3>()) * pose.rotation).normalized(),
          pose.translation + step.tail<3>()};
}

class Estimator {
 public:
  Estimator(const BrownCamera& camera, const std::vector<TagView>& views, const TagPoseOptions& options)
      : camera_(camera), views_(views), gate_(chi_squared_quantile(options.inlier_probability, 8)) {
    tags_.reserve(views.size());
    for (const TagView& view : views) tags_.emplace_back(view, options);
  }

  double gate() const { return gate_; }  ///< squared distance up to which a tag is an inlier

  /// Low is good. A tag that is far off counts by the logarithm of how far: a wrong one cannot outvote the right ones,
  /// and a rough hypothesis that needs refinement is still told from one that is plainly wrong. No tag lowers the sum,
  /// so it is given up where it reaches `limit`: then the answer is only known to be no lower than that.
  double score(const RigidTransform& pose, double limit) const {
    const MatrixPose at(pose);
    double sum = 0;
    for (std::size_t i = 0; i < tags_.size() && sum < limit; ++i) sum += penalty(tags_[i].distance(camera_, at));
    return sum;
  }
  double score(const RigidTransform& pose) {
    double sum = 0;
    for (const double distance : distances(pose)) sum += penalty(distance);
    return sum;
  }

  std::vector<bool> inliers(const RigidTransform& pose, double limit) {
    std::vector<bool> list;
    for (const double distance : distances(pose)) list.push_back(distance <= limit);
    return list;
  }

  /// One factor for each chosen tag; false if a tag falls behind the camera.
  bool weights(const std::vector<bool>& chosen, const RigidTransform& pose, std::vector<TagWeight>& list) const {
    list.resize(tags_.size());
    const MatrixPose at(pose);
    ProjectedTag tag;
    TagCovariance spread;
    for (std::size_t i = 0; i < tags_.size(); ++i)
      if (chosen[i]) {
        if (!tags_[i].project(camera_, at, tag)) return false;
        tags_[i].covariance(at, tag, spread);
        if (!list[i].compute(spread)) return false;
      }
    return true;
  }

  /// Normal equations of the chosen tags; false if one falls behind the camera.
  bool assemble(const std::vector<bool>& chosen, const std::vector<TagWeight>& weights, const RigidTransform& pose,
                PoseEquations& equations) const {
    equations = {};
    const MatrixPose at(pose);
    ProjectedTag tag;
    for (std::size_t i = 0; i < tags_.size(); ++i) {
      if (!chosen[i]) continue;
      if (!tags_[i].project(camera_, at, tag)) return false;
      equations.add(tag, weights[i]);
    }
    return true;
  }

  /// The same with the weights that belong to the pose.
  bool assemble_with_own_weights(const std::vector<bool>& chosen, const RigidTransform& pose,
                                 PoseEquations& equations) const {
    const MatrixPose at(pose);
    ProjectedTag tag;
    TagCovariance spread;
    TagWeight weight;
    for (std::size_t i = 0; i < tags_.size(); ++i) {
      if (!chosen[i]) continue;
      if (!tags_[i].project(camera_, at, tag)) return false;
      tags_[i].covariance(at, tag, spread);
      if (!weight.compute(spread)) return false;
      equations.add(tag, weight);
    }
    return true;
  }

  /// Sum of squares of the chosen tags' residuals [px²]; those behind the camera have no part in it.
  double sum_of_squares(const std::vector<bool>& chosen, const RigidTransform& pose) const {
    const MatrixPose at(pose);
    ProjectedTag tag;
    double sum = 0;
    for (std::size_t i = 0; i < tags_.size(); ++i)
      if (chosen[i] && tags_[i].project(camera_, at, tag)) sum += tag.sum_of_squares();
    return sum;
  }

  /// Fit to the chosen tags. The weights depend on the pose, but must not take part in the minimisation: a camera that
  /// comes closer would make every tag less certain. So they are held within a fit, and a few fits follow one another.
  RigidTransform refine(const std::vector<bool>& chosen, RigidTransform pose, int rounds = 5,
                        double tolerance = 1e-10) const {
    std::vector<TagWeight> held;
    for (int round = 0; round < rounds; ++round) {
      if (!weights(chosen, pose, held)) return pose;
      const RigidTransform before = pose;
      pose = minimise(chosen, held, pose, tolerance);
      if ((pose.translation - before.translation).norm() < 1e-9 * (1 + pose.translation.norm())) break;
    }
    return pose;
  }

  /// The same from a pose that is nearly there: every step takes weights and derivatives at its own pose, so that one
  /// projection serves both. Nothing where steps do not shrink fast, or a tag falls behind the camera.
  std::optional<RigidTransform> settle(const std::vector<bool>& chosen, RigidTransform pose,
                                       double tolerance = 1e-10) const {
    constexpr double contraction = 0.1;
    double last = kInfinity;
    for (;;) {
      PoseEquations equations;
      if (!assemble_with_own_weights(chosen, pose, equations)) return std::nullopt;
      const Vector6 step = equations.normal().ldlt().solve(equations.right());
      const double size = step.norm();
      if (!(size < contraction * last)) return std::nullopt;
      pose = moved(pose, step);
      if (size < tolerance * (1 + pose.translation.norm())) return pose;
      last = size;
    }
  }

  /// Levenberg-Marquardt with fixed weights, until a step moves the camera by less than this part of its distance.
  RigidTransform minimise(const std::vector<bool>& chosen, const std::vector<TagWeight>& weights, RigidTransform pose,
                          double tolerance) const {
    double damping = 1e-4;
    PoseEquations here, there;
    if (!assemble(chosen, weights, pose, here)) return pose;
    for (int iteration = 0; iteration < 30; ++iteration) {
      bool better = false;
      Vector6 step;
      for (int attempt = 0; attempt < 10 && !better; ++attempt) {
        Matrix6 damped = here.normal();
        damped.diagonal() *= 1 + damping;
        step = damped.ldlt().solve(here.right());
        if (!step.allFinite()) return pose;
        const RigidTransform trial = moved(pose, step);
        if (step.norm() < tolerance * (1 + pose.translation.norm())) return trial;  // too short to be looked at
        // With its derivatives: most steps are taken, and then these are the next equations.
        better =
            assemble(chosen, weights, trial, there) && there.sum_of_squares() <= here.sum_of_squares() * (1 + 1e-12);
        if (better) pose = trial, std::swap(here, there);
        damping = better ? std::max(damping * 0.1, 1e-12) : damping * 10;
      }
      if (!better) return pose;
    }
    return pose;
  }

  /// Fits to the tags of the sample, then alternates between choosing the inliers and fitting to them until the choice
  /// stays. The gate closes as the pose gets better.
  RigidTransform polish(RigidTransform pose, const std::vector<int>& sample) {
    std::vector<bool> chosen(views_.size(), false);
    for (const int i : sample) chosen[i] = true;
    pose = refine(chosen, pose, 1, kRough);
    for (int round = 0; round < 12; ++round) {
      const double limit = gate_ * std::max(1.0, kLenience / ((round + 1) * (round + 1)));
      const std::vector<bool> now = inliers(pose, limit);
      if (std::count(now.begin(), now.end(), true) < 3) break;
      if (limit == gate_ && now == chosen) break;
      chosen = now;
      const auto settled = settle(chosen, pose, kRough);
      pose = settled ? *settled : refine(chosen, pose, 2, kRough);
      if (all_agree(chosen) && all_agree(inliers(pose, gate_))) break;  // closing the gate would change nothing
    }
    return pose;
  }

  static bool all_agree(const std::vector<bool>& list) {
    return std::find(list.begin(), list.end(), false) == list.end();
  }

  /// Points in one plane fit nearly as well from a pose whose plane is mirrored about the line of sight
  /// (Schweighofer and Pinz 2006). Of the pose and its twin, both refined on all tags, the better one.
  RigidTransform better_of_twins(const RigidTransform& pose) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const TagView& view : views_) centre += view.anchor_in_world / static_cast<double>(views_.size());
    for (const TagView& view : views_)
      scatter += (view.anchor_in_world - centre) * (view.anchor_in_world - centre).transpose();
    const Eigen::Vector3d normal =
        pose.rotation * Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>().computeDirect(scatter).eigenvectors().col(0);
    const Eigen::Vector3d place = pose * centre, sight = place.normalized();
    const Eigen::Vector3d mirrored = 2 * sight.dot(normal) * sight - normal;
    const Eigen::Quaterniond turn = shortest_rotation(normal, mirrored);
    RigidTransform twin;
    twin.rotation = (turn * pose.rotation).normalized();
    twin.translation = place - twin.rotation * centre;
    const std::vector<bool> all(views_.size(), true);
    const double rival = score(pose);
    twin = refine(all, twin, 1, 1e-3);
    const double gone_back = 0.1 * Eigen::Quaterniond::Identity().angularDistance(turn);
    if (twin.rotation.angularDistance(pose.rotation) < gone_back) return pose;
    if (!(score(twin, 2 * rival) < 2 * rival)) return pose;  // most twins are far worse
    twin = refine(all, twin);
    return score(twin, rival) < rival ? twin : pose;
  }

 private:
  double penalty(double distance) const { return std::log1p(std::min(distance, 1e12) / gate_); }

  /// Of all tags. Whoever judges a pose often judges the one that was judged last.
  const std::vector<double>& distances(const RigidTransform& pose) {
    const bool is_known =
        judged_ && judged_->rotation.coeffs() == pose.rotation.coeffs() && judged_->translation == pose.translation;
    if (is_known) return distances_;
    judged_ = pose;
    distances_.clear();
    const MatrixPose at(pose);
    for (const TagInWorld& tag : tags_) distances_.push_back(tag.distance(camera_, at));
    return distances_;
  }

  const BrownCamera& camera_;
  const std::vector<TagView>& views_;
  std::vector<TagInWorld> tags_;
  double gate_;
  std::optional<RigidTransform> judged_;
  std::vector<double> distances_;  ///< under that pose
};

struct Hypothesis {
  double score;
  RigidTransform pose;
  std::vector<int> sample;
};

/// The hypotheses with the lowest scores, best first.
class BestHypotheses {
 public:
  explicit BestHypotheses(const Estimator& estimator) : estimator_(estimator) {}

  void offer(const RigidTransform& pose, const std::vector<int>& sample) {
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite()) return;
    const bool full = list_.size() == kKept;
    const double limit = full ? list_.back().score : kInfinity, score = estimator_.score(pose, limit);
    if (full && score >= limit) return;
    if (full) list_.pop_back();
    const auto place =
        std::find_if(list_.begin(), list_.end(), [score](const Hypothesis& h) { return score < h.score; });
    list_.insert(place, {score, pose, sample});
  }
  const std::vector<Hypothesis>& list() const { return list_; }

 private:
  static constexpr std::size_t kKept = 8;
  const Estimator& estimator_;
  std::vector<Hypothesis> list_;
};

/// Samples after which one without a wrong tag has been drawn with probability 1 - 1e-6, if `right` of `all` tags are
/// right (Fischler and Bolles 1981).
double samples_needed(double right, double all, int size) {
  double clean = 1;
  for (int i = 0; i < size; ++i) clean *= std::max(0.0, (right - i) / (all - i));
  if (clean >= 1) return 1;
  return clean > 0 ? std::log(1e-6) / std::log1p(-clean) : kInfinity;
}

/// The pose with the lowest score that samples lead to. Samples are drawn until enough of them are right ones, judged
/// by the best pose so far, which is looked at after 1, 2, 4, 8 ... samples.
RigidTransform search(Estimator& estimator, const std::vector<TagView>& views, const TagPoseSolver& solver,
                      const TagPoseOptions& options) {
  BestHypotheses best(estimator);
  Samples samples(static_cast<int>(views.size()), options.sample_size, options.max_samples, options.seed);
  std::vector<int> sample;
  double looked_at = kInfinity;  // score of the hypothesis that was polished last
  double needed = kInfinity;
  for (std::size_t k = 0; static_cast<double>(k) < needed && samples.next(sample); ++k) {
    std::vector<const TagView*> tags;
    for (const int i : sample) tags.push_back(&views[i]);
    for (const RigidTransform& pose : solver(tags)) best.offer(pose, sample);
    const bool power_of_two = ((k + 1) & k) == 0;
    if (!power_of_two || best.list().empty() || best.list().front().score == looked_at) continue;
    const Hypothesis& first = best.list().front();
    looked_at = first.score;
    const RigidTransform pose = estimator.polish(first.pose, first.sample);
    const std::vector<bool> agreeing = estimator.inliers(pose, estimator.gate());
    if (views.size() > 4 && Estimator::all_agree(agreeing)) return estimator.better_of_twins(pose);
    const auto count = static_cast<double>(std::count(agreeing.begin(), agreeing.end(), true));
    needed = samples_needed(count, static_cast<double>(views.size()), options.sample_size);
  }
  if (best.list().empty())
    throw NoTagPose("the solver gives no pose for any sample of " + std::to_string(views.size()) + " tags");
  RigidTransform pose;
  double lowest = kInfinity;
  for (const Hypothesis& hypothesis : best.list()) {
    const RigidTransform polished = estimator.polish(hypothesis.pose, hypothesis.sample);
    const double score = estimator.score(polished);
    if (score < lowest) lowest = score, pose = polished;
  }
  return pose;
}

/// The views as they would be if all edges were drawn inwards by `inset` [px].
std::vector<TagView> drawn_inwards(std::vector<TagView> views, double inset) {
  for (TagView& view : views) {
    const std::array<Eigen::Vector2d, 4> moved = moved_by_inset(view.pixels);
    for (std::size_t k = 0; k < 4; ++k) view.pixels[k] += inset * moved[k];
  }
  return views;
}

/// Standard deviations [rad, m] of the pose, with sign, by an inset that all of its tags have in common.
Vector6 pose_moved_by_inset(const BrownCamera& camera, const std::vector<TagView>& views, const TagPoseOptions& options,
                            const TagPose& found, const PoseEquations& equations) {
  const Estimator displaced(camera, drawn_inwards(views, options.inset_sigma), options);
  PoseEquations other;
  if (!displaced.assemble_with_own_weights(found.inliers, found.cam_from_world, other)) return Vector6::Zero();
  return equations.normal().ldlt().solve(other.right() - equations.right());
}

/// The estimate for views whose coordinates are small.
TagPose estimate_centred(const BrownCamera& camera, const std::vector<TagView>& views, const TagPoseSolver& solver,
                         const TagPoseOptions& options) {
  const std::string of = " of " + std::to_string(views.size());
  if (static_cast<int>(views.size()) < options.sample_size)
    throw NoTagPose("a pose needs " + std::to_string(options.sample_size) + " tags, there are " +
                    std::to_string(views.size()));
  Estimator estimator(camera, views, options);
  const RigidTransform pose = search(estimator, views, solver, options);
  TagPose result;
  result.inliers = estimator.inliers(pose, estimator.gate());
  result.inlier_count = static_cast<int>(std::count(result.inliers.begin(), result.inliers.end(), true));
  if (result.inlier_count < 3)
    throw NoTagPose("no pose agrees with three tags: the best one agrees with " + std::to_string(result.inlier_count) +
                    of);

  const auto settled = estimator.settle(result.inliers, pose);
  result.cam_from_world = settled ? *settled : estimator.refine(result.inliers, pose);
  PoseEquations equations;
  if (!estimator.assemble_with_own_weights(result.inliers, result.cam_from_world, equations))
    throw NoTagPose("the pose leads behind a tag");
  result.covariance = equations.normal().ldlt().solve(Matrix6::Identity());
  if (options.inset_sigma > 0) {
    const Vector6 together = pose_moved_by_inset(camera, views, options, result, equations);
    result.covariance += together * together.transpose();
  }
  result.rms = std::sqrt(estimator.sum_of_squares(result.inliers, result.cam_from_world) / (8.0 * result.inlier_count));
  return result;
}

}  // namespace

TagPose estimate_tag_pose(const BrownCamera& camera, const std::vector<TagView>& views, const TagPoseSolver& solver,
                          const TagPoseOptions& options) {
  // National coordinates have millions of metres: a rotation about their origin could not be told from a translation.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const TagView& view : views) centre += view.anchor_in_world / static_cast<double>(views.size());
  std::vector<TagView> local = views;
  for (TagView& view : local) {
    view.anchor_in_world -= centre;
    view.world_from_tag.translation -= centre;
  }
  TagPose result = estimate_centred(camera, local, solver, options);
  const Eigen::Vector3d shift = result.cam_from_world.rotation * centre;
  result.cam_from_world.translation -= shift;
  Matrix6 step_from_local = Matrix6::Identity();
  step_from_local.bottomLeftCorner<3, 3>() = skew(shift);
  result.covariance = step_from_local * result.covariance * step_from_local.transpose();
  return result;
}

}  // namespace plumbline
