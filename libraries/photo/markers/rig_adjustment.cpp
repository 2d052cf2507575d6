#include "photo/markers/rig_adjustment.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "geometry/median.hpp"
#include "photo/bundle/adjust.hpp"
#include "photo/markers/common_error.hpp"
#include "photo/markers/rig.hpp"
#include "photo/markers/rig_model.hpp"

namespace plumbline::markers {
namespace {

constexpr double kDisagrees = 5;  // times the median: a photograph that the rig does not explain
constexpr double kWorse = 10;     // times the calibrations of their own: these cameras are no rig

class RigAdjuster {
 public:
  RigAdjuster(const std::vector<RigCamera>& cameras, const std::vector<std::vector<std::string>>& moments,
              const CalibrationOptions& options)
      : cameras_(cameras), moments_(moments), options_(options), models_(cameras, moments, options) {}

  /// `part` 0: all exposures; 1 and 2: every other one.
  AdjustedRig adjust(const std::vector<int>& members, const std::vector<RigidTransform>& start, int part) const {
    AdjustedRig rig;
    rig.reference = members.front();
    Rig begin = models_.rig_of(members, start, part);
    leave_out_what_disagrees(begin, rig);
    if (!rig.refused.empty()) return rig;
    for (const RigFreedom freedom : {RigFreedom::all, RigFreedom::principal, RigFreedom::none}) {
      try {
        RigModel model = models_.build(begin, freedom);
        const bundle::Layout layout(model.problem);
        bundle::AdjustOptions options;
        options.minimise.max_iterations = options_.max_iterations;
        options.minimise.side = bundle::Side::images;
        options.start_is_near = true;
        const bundle::Adjusted adjusted = bundle::adjust(model.problem, layout, model.state, options);
        model.state = adjusted.state;
        read(begin, model, layout, adjusted, rig);
        if (freedom == RigFreedom::principal)
          rig.held = "k3 and what follows it of the cameras and the bend of the board";
        else if (freedom == RigFreedom::none)
          rig.held = "the interior orientations and the bend of the board";
        return rig;
      } catch (const std::runtime_error& error) {
        if (freedom == RigFreedom::none) rig.refused = std::string("the common adjustment failed: ") + error.what();
      }
    }
    return rig;
  }

  int shared_exposures(const std::vector<int>& members, int camera) const {
    std::set<std::string> others;
    for (const int c : members)
      if (c != camera) others.insert(moments_[c].begin(), moments_[c].end());
    const auto& own = moments_[camera];
    return static_cast<int>(std::count_if(own.begin(), own.end(), [&](const auto& m) { return others.count(m) > 0; }));
  }

 private:
  static std::string no_rig(int bad, int of, const std::string& camera, double together, double separate) {
    const std::string text = fmt::format(
        "(as a rig all fit to {:.1f} px in the median, each camera for itself to {:.2f} px): photographs with the same "
        "number were not taken together, the cameras moved against each other, or cameras are mixed up",
        together, separate);
    if (bad == 0) return std::string("no places of the cameras to each other explain the photographs ") + text;
    return std::to_string(bad) + " of " + std::to_string(of) + " photographs of camera " + camera +
           " do not show the board where the rig has it " + text;
  }

  /// A photograph that was not taken together with the others of its exposure does not fit; if most of a camera don't,
  /// this is no rig.
  void leave_out_what_disagrees(Rig& p, AdjustedRig& rig) const {
    double separate = 0;
    for (const int c : p.members) separate = std::max(separate, cameras_[c].calibration->rms);
    const std::vector<double> rms = models_.fit(p);
    const double limit = kDisagrees * std::max(separate, std::min(upper_median(rms), kWorse * separate));
    std::vector<RigShot> kept;
    std::vector<int> own(p.members.size(), 0), good(p.members.size(), 0);
    for (size_t s = 0; s < rms.size(); ++s) {
      const size_t c = static_cast<size_t>(p.shots[s].camera);
      ++own[c];
      if (rms[s] <= limit)
        kept.push_back(p.shots[s]), ++good[c];
      else
        rig.left_out.push_back(models_.given(p, p.shots[s]).path);
    }
    for (size_t c = 0; c < own.size() && rig.refused.empty(); ++c) {
      if (upper_median(rms) <= kWorse * separate && good[c] >= 3 && 2 * good[c] >= own[c]) continue;
      rig.refused = no_rig(own[c] - good[c], own[c], cameras_[p.members[c]].id, upper_median(rms), separate);
    }
    if (!rig.refused.empty()) return;
    p.shots = std::move(kept);
    drop_empty_exposures(p);
  }

  static Eigen::VectorXd part_of(const Eigen::VectorXd& all, const bundle::Layout& layout, bundle::Kind kind,
                                 size_t m) {
    const int block = layout.block({kind, static_cast<int>(m)});
    return all.segment(layout.offset(block), layout.size(block));
  }

  /// What the inset of each camera's photographs moves all unknowns by, zero where none is stated: one of each camera,
  /// so that those of two halves stand side by side.
  std::vector<Eigen::VectorXd> effects_of_insets(const Rig& p, const RigModel& model,
                                                 const bundle::Layout& layout) const {
    std::vector<Eigen::VectorXd> effects;
    for (size_t m = 0; m < p.members.size(); ++m) {
      bool any = false;
      std::vector<Eigen::Vector2d> moved(model.labels.size(), Eigen::Vector2d::Zero());
      for (size_t k = 0; k < moved.size(); ++k) {
        const RigShot& shot = p.shots[model.labels[k].first];
        if (shot.camera != static_cast<int>(m)) continue;
        moved[k] = models_.given(p, shot).points[model.labels[k].second].by_inset;
        any = any || !moved[k].isZero(0);
      }
      effects.push_back(any ? effect_of(model.problem, layout, model.state, moved)
                            : Eigen::VectorXd(Eigen::VectorXd::Zero(layout.unknown_count())));
    }
    return effects;
  }

  void read(const Rig& p, const RigModel& model, const bundle::Layout& layout, const bundle::Adjusted& adjusted,
            AdjustedRig& rig) const {
    double variance = 0, squares = 0;
    std::vector<double> own(p.members.size(), 0), points(p.members.size(), 0);
    for (size_t k = 0; k < model.labels.size(); ++k) {
      const size_t c = static_cast<size_t>(p.shots[model.labels[k].first].camera);
      const double square = model.residual_of(layout, k).squaredNorm();
      own[c] += square, points[c] += 1;
      squares += square, variance += std::pow(model.problem.image_points[k].whitening(0, 0), -2);
    }
    rig.exposures = static_cast<int>(p.exposures.size());
    rig.observations = adjusted.rows, rig.unknowns = adjusted.unknowns;
    rig.degrees_of_freedom = adjusted.redundancy();
    const double all = static_cast<double>(model.labels.size());
    const double factor = adjusted.sum_of_squares / rig.degrees_of_freedom;
    rig.rms = std::sqrt(squares / all), rig.sigma = std::sqrt(factor * variance / all);
    const auto cofactor = [&](bundle::Kind kind, size_t m) {
      return adjusted.cofactors->own(layout.block({kind, static_cast<int>(m)}));
    };
    const std::vector<Eigen::VectorXd> by_insets = effects_of_insets(p, model, layout);
    for (size_t m = 0; m < p.members.size(); ++m) {
      AdjustedRigCamera camera;
      camera.camera = p.members[m];
      const bundle::Placement& mount = model.state.mounts[m];
      camera.cam_from_reference = {mount.rotation, -(mount.rotation * mount.position)};
      const Calibration& separate = *cameras_[p.members[m]].calibration;
      camera.interior = separate.camera;
      std::array<double, BrownCamera::parameter_count> values;
      std::copy_n(model.state.interiors[m].begin(), values.size(), values.begin());
      camera.interior.set_parameters(values);
      camera.interior_covariance = Eigen::MatrixXd::Zero(BrownCamera::parameter_count, BrownCamera::parameter_count);
      const auto& free = layout.free_values(static_cast<int>(m));
      if (!free.empty()) {
        camera.interior_covariance(free, free) = factor * cofactor(bundle::Kind::camera, m);
        for (const Eigen::VectorXd& effect : by_insets) {
          const Eigen::VectorXd moved = part_of(effect, layout, bundle::Kind::camera, m);
          camera.interior_covariance(free, free) += moved * moved.transpose();
        }
      }
      camera.by_inset.setZero(6, std::ssize(by_insets));
      if (m > 0) {  // (C, δ) to (δ, t): t = −exp(δ) R C, dt = −R dC − [t]× δ
        Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Zero();
        jacobian.topRightCorner<3, 3>().setIdentity();
        jacobian.bottomLeftCorner<3, 3>() = -mount.matrix;
        jacobian.bottomRightCorner<3, 3>() = -skew(camera.cam_from_reference.translation);
        for (size_t k = 0; k < by_insets.size(); ++k)
          camera.by_inset.col(static_cast<Eigen::Index>(k)) =
              jacobian * part_of(by_insets[k], layout, bundle::Kind::mount, m);
        camera.covariance = factor * jacobian * cofactor(bundle::Kind::mount, m) * jacobian.transpose() +
                            camera.by_inset * camera.by_inset.transpose();
      }
      camera.rms = std::sqrt(own[m] / std::max(1.0, points[m])), camera.separate_rms = separate.rms;
      camera.shared = shared_exposures(p.members, p.members[m]);
      camera.halves = std::nan("");
      rig.cameras.push_back(camera);
    }
  }

  const std::vector<RigCamera>& cameras_;
  const std::vector<std::vector<std::string>>& moments_;
  const CalibrationOptions& options_;
  RigModels models_;
};

/// Cameras that shared moments connect, with their poses against the first of them.
struct Component {
  std::vector<int> members;
  std::vector<RigidTransform> from_first;
};

std::vector<Component> components_of(const std::vector<RigCamera>& cameras,
                                     const std::vector<std::vector<std::string>>& moments) {
  std::vector<std::vector<RigView>> views(cameras.size());
  for (size_t c = 0; c < cameras.size(); ++c)
    for (const auto& view : cameras[c].calibration->views)
      views[c].push_back({moments[c][view.view], view.cam_from_board});
  std::vector<Component> components;
  std::vector<std::pair<size_t, size_t>> place(cameras.size(), {0, 0});  // component and index in it, both from 1
  for (const RigPose& pose : rig_of(views)) {
    auto& reference = place[pose.reference];
    if (reference.first == 0) {
      components.push_back({{pose.reference}, {RigidTransform{}}});
      reference = {components.size(), 1};
    }
    Component& own = components[reference.first - 1];
    own.members.push_back(pose.camera);
    own.from_first.push_back(pose.cam_from_reference * own.from_first[reference.second - 1]);
    place[pose.camera] = {reference.first, own.members.size()};
  }
  return components;
}

void compare_halves(const RigAdjuster& adjuster, const Component& component, AdjustedRig& rig) {
  std::vector<RigidTransform> start;
  for (const auto& camera : rig.cameras) start.push_back(camera.cam_from_reference);
  AdjustedRig half[2];
  for (int k = 0; k < 2; ++k) half[k] = adjuster.adjust(component.members, start, k + 1);
  if (!half[0].refused.empty() || !half[1].refused.empty()) return;  // half may be too few
  for (size_t m = 1; m < rig.cameras.size(); ++m) {
    const AdjustedRigCamera &a = half[0].cameras[m], &b = half[1].cameras[m];
    const Eigen::AngleAxisd turn(a.cam_from_reference.rotation * b.cam_from_reference.rotation.conjugate());
    Eigen::Matrix<double, 6, 1> difference;
    difference << turn.angle() * turn.axis(), a.cam_from_reference.translation - b.cam_from_reference.translation;
    // Both halves are of the same cameras, which draw edges in alike.
    const Eigen::Matrix<double, 6, Eigen::Dynamic> apart = a.by_inset - b.by_inset;
    const Eigen::Matrix<double, 6, 6> covariance = a.covariance - a.by_inset * a.by_inset.transpose() + b.covariance -
                                                   b.by_inset * b.by_inset.transpose() + apart * apart.transpose();
    rig.cameras[m].halves = difference.dot(covariance.ldlt().solve(difference)) / 6;
  }
}

}  // namespace

std::vector<AdjustedRig> adjust_rigs(const std::vector<RigCamera>& cameras,
                                     const std::vector<std::vector<std::string>>& moments,
                                     const CalibrationOptions& options) {
  const RigAdjuster adjuster(cameras, moments, options);
  std::vector<AdjustedRig> rigs;
  for (const Component& component : components_of(cameras, moments)) {
    rigs.push_back(adjuster.adjust(component.members, component.from_first, 0));
    if (rigs.back().refused.empty()) compare_halves(adjuster, component, rigs.back());
  }
  return rigs;
}

}  // namespace plumbline::markers
