#include "photo/markers/calibration.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "geometry/median.hpp"
#include "photo/bundle/adjust.hpp"
#include "photo/markers/common_error.hpp"
#include "photo/markers/planar_pose.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::markers {
namespace {

using bundle::Kind;

struct Labelled {
  int view = 0, point = 0;
};

class Calibrator {
 public:
  Calibrator(const std::vector<CalibrationView>& views, int width, int height, const CalibrationOptions& options)
      : views_(views), width_(width), height_(height), options_(options) {
    Eigen::AlignedBox2d box;
    for (const auto& view : views)
      for (const auto& p : view.points) box.extend(p.board.head<2>());
    middle_ = box.center(), half_ = 0.5 * box.sizes().cwiseMax(1e-9);
    for (const auto& view : views) use_.emplace_back(view.points.size(), true);
  }

  Calibration run() {
    start();
    reject();
    adjust();
    return result();
  }

 private:
  double focal_length() const {
    double ab = 0, aa = 0;
    const double unit = std::max(width_, height_);
    for (const auto& view : views_) {
      std::vector<Eigen::Vector2d> plane, image;
      for (const auto& p : view.points) {
        plane.push_back((p.board.head<2>() - middle_) / half_.maxCoeff());
        image.emplace_back((p.pixel.x() - 0.5 * width_) / unit, (p.pixel.y() - 0.5 * height_) / unit);
      }
      const Eigen::Matrix3d h = plane_homography(plane, image);
      const Eigen::Vector3d h1 = h.col(0), h2 = h.col(1);
      const double scale = h1.head<2>().squaredNorm() + h2.head<2>().squaredNorm();
      const double a1 = h1.head<2>().dot(h2.head<2>()) / scale, b1 = h1.z() * h2.z() / scale;
      const double a2 = (h1.head<2>().squaredNorm() - h2.head<2>().squaredNorm()) / scale,
                   b2 = (h1.z() * h1.z() - h2.z() * h2.z()) / scale;
      ab += a1 * b1 + a2 * b2, aa += a1 * a1 + a2 * a2;
    }
    const double w = -ab / aa;
    return w > 0 && std::isfinite(w) ? unit / std::sqrt(w) : std::nan("");
  }

  LensModel lens() const { return options_.known ? options_.known->lens : options_.lens; }

  InteriorOrientation without_distortion(double f) const {
    InteriorOrientation camera;
    camera.lens = lens();
    camera.fx = camera.fy = f, camera.cx = 0.5 * (width_ - 1), camera.cy = 0.5 * (height_ - 1);
    return camera;
  }

  bool pose_all(const InteriorOrientation& camera) {
    state_ = {};
    const auto values = camera.parameters();
    std::copy(values.begin(), values.end(), state_.interiors.emplace_back().begin());
    state_.bends = {Eigen::Vector2d::Zero()};
    for (const auto& view : views_) {
      std::vector<Eigen::Vector2d> plane, image;
      for (const auto& p : view.points) {
        const auto ray = unproject(camera, p.pixel);
        if (!ray) continue;
        plane.push_back(p.board.head<2>()), image.push_back(*ray);
      }
      if (plane.size() < 4) return false;
      const auto poses = poses_of_plane(plane, image);
      if (poses.empty()) return false;
      const RigidTransform& pose = poses.front().cam_from_figure;
      state_.images.emplace_back().set(pose.rotation, pose.inverse().translation);
    }
    return true;
  }

  std::vector<bool> free_values() const {
    std::vector<bool> free(static_cast<size_t>(bundle::value_count(bundle::lens_of(lens()))), false);
    const auto place = [](LensModel model, const std::string& name) {
      const auto names = InteriorOrientation::names_of(model);
      const auto at = std::find(names.begin(), names.end(), name);
      return at == names.end() ? std::nullopt : std::optional(static_cast<size_t>(at - names.begin()));
    };
    for (const auto& name : options_.free) {
      if (!place(LensModel::brown, name) && !place(LensModel::fisheye, name))
        throw std::runtime_error("unknown interior parameter '" + name +
                                 "'; known are fx, fy, cx, cy, k1, k2, k3, p1, p2, and k4 of a fisheye");
      if (const auto at = place(lens(), name); at && !options_.known) free[*at] = true;
    }
    return free;
  }

  void build() {
    problem_ = {}, labels_.clear(), state_.points.clear();
    problem_.groups = {{"points"}, {"bend"}};
    problem_.cameras = {{"", bundle::lens_of(lens()), 0, free_values()}};
    const bool bent = options_.bend_sigma > 0;
    problem_.sheets = {{"the board", bent}};
    if (bent)
      problem_.known.push_back(
          {{{Kind::bend, 0}}, Eigen::Vector2d::Zero(), Eigen::Matrix2d::Identity() / options_.bend_sigma, 1});
    for (size_t v = 0; v < views_.size(); ++v) {
      problem_.images.push_back({views_[v].path});
      for (size_t k = 0; k < views_[v].points.size(); ++k) {
        if (!use_[v][k]) continue;
        const CalibrationPoint& p = views_[v].points[k];
        const Eigen::Vector2d unit = (p.board.head<2>() - middle_).cwiseQuotient(half_);
        problem_.points.push_back({std::to_string(k), true, 0, Eigen::Vector2d::Ones() - unit.cwiseAbs2()});
        state_.points.push_back(p.board);
        problem_.image_points.push_back({static_cast<int>(v), static_cast<int>(labels_.size()), p.pixel,
                                         Eigen::Matrix2d::Identity() / p.sigma, 0, true});
        labels_.push_back({static_cast<int>(v), static_cast<int>(k)});
      }
    }
  }

  void minimise(double scale) {
    build();
    bundle::MinimiseOptions options;
    options.max_iterations = options_.max_iterations;
    options.side = bundle::Side::images;
    options.loss = {bundle::Loss::Kind::huber, scale};
    bundle::minimise_schur(problem_, state_, options);
  }

  /// Measured minus computed [px]; `label` is an index into labels_.
  Eigen::Vector2d residual_of(size_t label) const {
    const bundle::ImagePoint& point = problem_.image_points[label];
    const bundle::Layout& layout = *layout_;
    bundle::Rows rows;
    if (!bundle::evaluate(problem_, layout, state_, point, false, rows))
      throw std::runtime_error("point " + problem_.points[label].name + " lies behind the camera of " +
                               problem_.images[point.image].name);
    return -rows.values() / point.whitening(0, 0);
  }

  /// Lengths of the whitened residuals, in the order of labels_.
  std::vector<double> misfits() {
    layout_ = std::make_unique<bundle::Layout>(problem_);
    std::vector<double> lengths;
    for (size_t k = 0; k < labels_.size(); ++k)
      lengths.push_back(residual_of(k).norm() * problem_.image_points[k].whitening(0, 0));
    return lengths;
  }

  /// The best of several principal distances, minimised robustly.
  void start() {
    const double extent = std::max(width_, height_), zhang = focal_length();
    const bool is_fisheye = lens() == LensModel::fisheye;
    std::vector<InteriorOrientation> candidates;
    if (options_.known) {
      candidates.push_back(*options_.known);
    } else {
      if (!is_fisheye && zhang > 0.3 * extent && zhang < 20 * extent) candidates.push_back(without_distortion(zhang));
      // A circle of 180 degrees within the image has 0.32 of its width, one across its diagonal 0.4.
      for (const double factor : is_fisheye ? std::vector{0.45, 0.32, 0.7, 1.2} : std::vector{1.0, 0.6, 1.8, 4.0})
        candidates.push_back(without_distortion(factor * extent));
    }
    bundle::State best;
    double lowest = std::numeric_limits<double>::infinity();
    for (const InteriorOrientation& camera : candidates) {
      if (!pose_all(camera)) continue;
      minimise(30);
      const double fit = upper_median(misfits());
      if (fit < lowest) lowest = fit, best = state_;
      const double sigma = views_.front().points.front().sigma;
      if (lowest * sigma < 1e-3 * extent) break;
    }
    if (!std::isfinite(lowest))
      throw std::runtime_error(
          "no photograph gives a pose of the board; check columns, rows and the order of its points");
    state_ = best;
  }

  void reject() {
    if (!(options_.reject_above > 0)) return;
    for (int pass = 0; pass < 2; ++pass) {
      minimise(3 * std::max(1e-3, upper_median(misfits())));
    }
    const std::vector<double> fits = misfits();
    const double unit = upper_median(fits);
    for (size_t k = 0; k < fits.size(); ++k) {
      if (fits[k] <= options_.reject_above * unit) continue;
      const auto [v, p] = labels_[k];
      use_[v][p] = false;
      rejected_.push_back(labels_[k]);
    }
  }

  void adjust() {
    build();
    layout_ = std::make_unique<bundle::Layout>(problem_);
    bundle::AdjustOptions options;
    options.minimise.max_iterations = options_.max_iterations;
    options.minimise.side = bundle::Side::images;
    options.start_is_near = options.is_determined = true;
    require_determined();
    try {
      adjusted_ = bundle::adjust(problem_, *layout_, state_, options);
    } catch (const std::runtime_error&) {
      throw NotConverged(no_convergence());
    }
    state_ = adjusted_.state;
  }

  void require_determined() const {
    bundle::Elimination elimination(problem_, *layout_, bundle::Side::images);
    if (!elimination.build(state_)) throw NotConverged(no_convergence());
    try {
      bundle::require_determined(problem_, *layout_, state_, elimination, {});
    } catch (const std::runtime_error& error) {
      throw BadInput(std::string(error.what()) +
                     "; photograph the board tilted, from several sides, and over the whole image");
    }
  }

  RigidTransform cam_from_board(size_t view) const {
    const bundle::Placement& image = state_.images[view];
    return {image.rotation, -(image.rotation * image.position)};
  }

  /// Angle of the board's normal against the line of sight [rad].
  double tilt_of(size_t view) const {
    const Eigen::Vector3d normal = state_.images[view].rotation * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d sight = cam_from_board(view) * Eigen::Vector3d(middle_.x(), middle_.y(), 0);
    return std::acos(std::clamp(std::abs(normal.dot(sight.normalized())), 0.0, 1.0));
  }

  std::string no_convergence() const {
    std::vector<double> tilts;
    for (size_t v = 0; v < views_.size(); ++v) tilts.push_back(tilt_of(v));
    const double tilt = upper_median(tilts) * 180 / std::numbers::pi;
    const std::string begin = "the adjustment does not converge: ";
    if (!(tilt < 15))
      return begin +
             "the photographs do not show the board that its file describes, or the lens is none of this model (a "
             "fisheye). Check type, columns, rows and lengths there";
    return begin + fmt::format("half of the photographs look at the board within {:.0f} degrees of straight, ", tilt) +
           "which does not tell the principal distance from the distance. Tilt the board by 30 to 50 degrees in half "
           "of them, in several directions";
  }

  CameraEvidence evidence(double factor) const {
    std::vector<int> members;
    std::vector<std::string> paths;
    for (size_t v = 0; v < views_.size(); ++v) members.push_back(static_cast<int>(v)), paths.push_back(views_[v].path);
    return evidence_of(shares_of(problem_, *layout_, state_, {height_}),
                       kept_cofactor(problem_, *layout_, *adjusted_.cofactors), factor,
                       interior_columns(problem_, *layout_, 0), members, paths);
  }

  CameraTruth judged(CameraEvidence evidence, const Calibration& c) const {
    std::vector<RigidTransform> poses;
    for (const int v : evidence.members) poses.push_back(c.views[v].cam_from_board);
    evidence.object_is_known = true;
    return judge_camera(std::move(evidence), c.camera, poses);
  }

  /// Calibration::by_inset.
  Eigen::VectorXd moved_by_inset() const {
    Eigen::VectorXd nine = Eigen::VectorXd::Zero(BrownCamera::parameter_count);
    std::vector<Eigen::Vector2d> moved;
    bool any = false;
    for (const auto& [v, p] : labels_) {
      moved.push_back(views_[v].points[p].by_inset);
      any = any || !moved.back().isZero(0);
    }
    const std::vector<int>& free = layout_->free_values(0);
    if (!any || free.empty()) return nine;
    const Eigen::VectorXd effect = effect_of(problem_, *layout_, state_, moved);
    nine(free) = effect.segment(layout_->offset(layout_->block({Kind::camera, 0})), std::ssize(free));
    return nine;
  }

  Calibration result() const {
    Calibration c;
    c.camera.lens = lens(), c.camera.width = width_, c.camera.height = height_;
    std::array<double, InteriorOrientation::parameter_count> interior;
    std::copy_n(state_.interiors[0].begin(), interior.size(), interior.begin());
    c.camera.set_parameters(interior);
    c.observations = adjusted_.rows, c.unknowns = adjusted_.unknowns;
    c.degrees_of_freedom = adjusted_.redundancy();
    if (c.degrees_of_freedom < 10)
      throw std::runtime_error("the photographs hold hardly more observations than unknowns (" +
                               std::to_string(c.degrees_of_freedom) + " to spare); take more of them");
    double squares = 0, variance = 0;
    for (size_t v = 0; v < views_.size(); ++v) {
      CalibratedView view;
      view.view = static_cast<int>(v);
      view.cam_from_board = cam_from_board(v);
      view.tilt = tilt_of(v);
      c.views.push_back(view);
    }
    for (size_t k = 0; k < labels_.size(); ++k) {
      const auto [v, p] = labels_[k];
      const double sigma = views_[v].points[p].sigma;
      CalibratedView& view = c.views[v];
      view.points.push_back(p);
      view.residuals.push_back(residual_of(k));
      view.rms += view.residuals.back().squaredNorm();
      variance += sigma * sigma;
    }
    for (auto& view : c.views) {
      squares += view.rms;
      if (!view.points.empty()) view.rms = std::sqrt(view.rms / static_cast<double>(view.points.size()));
    }
    const double points = static_cast<double>(labels_.size()), factor = adjusted_.sum_of_squares / c.degrees_of_freedom;
    c.rms = std::sqrt(squares / points);
    c.sigma = std::sqrt(factor * variance / points);
    c.truth = judged(evidence(factor), c);
    c.formal_covariance = in_nine(c.truth.evidence, c.truth.evidence.formal);
    c.by_inset = moved_by_inset();
    c.covariance = in_nine(c.truth.evidence, c.truth.empirical.written) + c.by_inset * c.by_inset.transpose();
    c.bend_x = state_.bends[0].x(), c.bend_y = state_.bends[0].y();
    if (options_.bend_sigma > 0) {
      const Eigen::Matrix2d bend = factor * adjusted_.cofactors->own(layout_->block({Kind::bend, 0}));
      c.bend_x_sigma = std::sqrt(bend(0, 0)), c.bend_y_sigma = std::sqrt(bend(1, 1));
    }
    for (const auto& [v, p] : rejected_)
      c.rejected.push_back("point " + std::to_string(p) + " in " + views_[v].path +
                           ": its residual is more than 5 times that of the median point");
    return c;
  }

  const std::vector<CalibrationView>& views_;
  int width_, height_;
  const CalibrationOptions& options_;
  Eigen::Vector2d middle_, half_;
  std::vector<std::vector<bool>> use_;
  std::vector<Labelled> labels_, rejected_;
  bundle::Problem problem_;
  std::unique_ptr<bundle::Layout> layout_;
  bundle::State state_;
  bundle::Adjusted adjusted_;
};

}  // namespace

Calibration calibrate(const std::vector<CalibrationView>& views, int width, int height,
                      const CalibrationOptions& options) {
  if (views.size() < 3)
    throw std::runtime_error("the board was found in " + std::to_string(views.size()) +
                             (views.size() == 1 ? " photograph" : " photographs") +
                             "; at least 3 are needed, 15 to 30 are good, tilted and over the whole image");
  for (const auto& view : views)
    if (view.points.size() < 4) throw std::runtime_error(view.path + " has fewer than 4 points of the board");
  // Photographs that are too much alike tell neither a bend from the lens nor its highest radial coefficient. If it is
  // not that, the last attempt says what.
  std::vector<CalibrationOptions> attempts{options};
  const std::string highest = options.lens == LensModel::fisheye ? "k4" : "k3";
  const auto add = [&](bool flat, bool without_highest) {
    attempts.push_back(options);
    if (flat) attempts.back().bend_sigma = 0;
    if (without_highest) std::erase(attempts.back().free, highest);
  };
  const bool bent = options.bend_sigma > 0;
  if (bent) add(true, false);
  if (std::find(options.free.begin(), options.free.end(), highest) != options.free.end()) {
    if (bent) add(false, true);
    add(true, true);
  }
  for (size_t k = 0;; ++k) {
    try {
      Calibration result = Calibrator(views, width, height, attempts[k]).run();
      result.held_flat = bent && !(attempts[k].bend_sigma > 0);
      result.held_highest = attempts[k].free.size() < options.free.size();
      return result;
    } catch (const std::runtime_error&) {
      if (k + 1 == attempts.size()) throw;
    }
  }
}

}  // namespace plumbline::markers
