#include "photo/markers/calibration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "geometry/median.hpp"
#include "least_squares/problem/defects.hpp"
#include "photo/markers/calibration_cost.hpp"
#include "photo/markers/planar_pose.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

struct State {
  std::vector<std::array<double, 6>> poses;
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Matrix3d> matrices;
  std::array<double, BrownCamera::parameter_count> interior{};
  std::array<double, 2> bend{};

  void fold() {
    for (size_t i = 0; i < poses.size(); ++i) {
      rotations[i] =
          (quaternion_from_rotation_vector({poses[i][3], poses[i][4], poses[i][5]}) * rotations[i]).normalized();
      matrices[i] = rotations[i].toRotationMatrix();
      poses[i][3] = poses[i][4] = poses[i][5] = 0;
    }
  }
};

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
    block::AdjustedBlock block = adjust();
    return result(block);
  }

  /// √(Σ(dx² + dy²)/n) of all points after the adjustment [px].
  double residuals_of_all() {
    start();
    const block::AdjustedBlock block = adjust();
    double squares = 0, points = 0;
    for (const auto& rows : block.linear.observations) {
      if (rows.group != 0) continue;
      const auto [v, p] = labels_[static_cast<size_t>(rows.label)];
      squares += std::pow(views_[static_cast<size_t>(v)].points[static_cast<size_t>(p)].sigma, 2) *
                 rows.misclosure.squaredNorm();
      ++points;
    }
    return std::sqrt(squares / points);
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

  bool pose_all(double f) {
    state_ = State{};
    state_.interior = {f, f, 0.5 * (width_ - 1), 0.5 * (height_ - 1), 0, 0, 0, 0, 0};
    for (const auto& view : views_) {
      std::vector<Eigen::Vector2d> plane, image;
      for (const auto& p : view.points) {
        plane.push_back(p.board.head<2>());
        image.emplace_back((p.pixel.x() - state_.interior[2]) / f, (p.pixel.y() - state_.interior[3]) / f);
      }
      const auto poses = poses_of_plane(plane, image);
      if (poses.empty()) return false;
      const RigidTransform& pose = poses.front().cam_from_figure;
      state_.poses.push_back({pose.translation.x(), pose.translation.y(), pose.translation.z(), 0, 0, 0});
      state_.rotations.push_back(pose.rotation);
    }
    state_.matrices.resize(state_.poses.size());
    state_.fold();
    return true;
  }

  void build(block::BlockModel& model) {
    labels_.clear();
    model.add_group("points"), model.add_group("bend");
    for (auto& pose : state_.poses) model.add_pose(pose.data());
    std::vector<bool> free(BrownCamera::parameter_count, false);
    for (const auto& name : options_.free) {
      const auto at = std::find_if(BrownCamera::parameter_names.begin(), BrownCamera::parameter_names.end(),
                                   [&](const char* known) { return name == known; });
      if (at == BrownCamera::parameter_names.end())
        throw std::runtime_error("unknown interior parameter '" + name +
                                 "'; known are fx, fy, cx, cy, k1, k2, k3, p1, p2");
      free[static_cast<size_t>(at - BrownCamera::parameter_names.begin())] = true;
    }
    columns_ = model.add_kept(state_.interior.data(), free,
                              {BrownCamera::parameter_names.begin(), BrownCamera::parameter_names.end()});
    const bool bent = options_.bend_sigma > 0;
    bend_columns_ =
        model.add_kept(state_.bend.data(), {bent, bent}, {"bend of the board in x", "bend of the board in y"});
    if (bent)
      model.add_term(std::make_unique<block::DifferentiatedCost<ScaledCost, 2, 2>>(new ScaledCost{options_.bend_sigma}),
                     {state_.bend.data()}, 1, 0);
    for (size_t v = 0; v < views_.size(); ++v)
      for (size_t k = 0; k < views_[v].points.size(); ++k) {
        if (!use_[v][k]) continue;
        const CalibrationPoint& p = views_[v].points[k];
        const Eigen::Vector2d unit = (p.board.head<2>() - middle_).cwiseQuotient(half_);
        model.add_term(std::make_unique<block::DifferentiatedCost<PointCost, 2, 6, BrownCamera::parameter_count, 2>>(
                           new PointCost{p.board, p.pixel, unit, p.sigma, options_.lens, &state_.matrices[v]}),
                       {state_.poses[v].data(), state_.interior.data(), state_.bend.data()}, 0,
                       static_cast<int>(labels_.size()), true);
        labels_.push_back({static_cast<int>(v), static_cast<int>(k)});
      }
  }

  /// Lengths of the whitened residuals, in the order of labels_.
  std::vector<double> misfits(const block::BlockModel& model) const {
    std::vector<double> lengths;
    for (const auto& rows : model.linearise().observations)
      if (rows.group == 0) lengths.push_back(rows.misclosure.norm());
    return lengths;
  }

  /// The best of several principal distances, minimised robustly.
  void start() {
    const double extent = std::max(width_, height_), zhang = focal_length();
    std::vector<double> candidates;
    if (zhang > 0.3 * extent && zhang < 20 * extent) candidates.push_back(zhang);
    for (const double factor : {1.0, 0.6, 1.8, 4.0}) candidates.push_back(factor * extent);
    State best;
    double lowest = std::numeric_limits<double>::infinity();
    for (const double f : candidates) {
      if (!pose_all(f)) continue;
      block::BlockModel model;
      build(model);
      model.minimise(options_.max_iterations, {bundle::Loss::Kind::huber, 30});
      state_.fold();
      const double fit = upper_median(misfits(model));
      if (fit < lowest) lowest = fit, best = state_;
      const double sigma = views_.front().points.front().sigma;
      if (lowest * sigma < 1e-3 * extent) break;
    }
    if (!std::isfinite(lowest))
      throw std::runtime_error(
          "no photograph gives a pose of the board; check columns, rows and the order of its points");
    state_ = best;
    for (size_t i = 0; i < state_.poses.size(); ++i) state_.matrices[i] = state_.rotations[i].toRotationMatrix();
  }

  void reject() {
    if (!(options_.reject_above > 0)) return;
    double unit = 1;
    for (int pass = 0; pass < 2; ++pass) {
      block::BlockModel model;
      build(model);
      unit = std::max(1e-3, upper_median(misfits(model)));
      model.minimise(options_.max_iterations, {bundle::Loss::Kind::huber, 3 * unit});
      state_.fold();
    }
    block::BlockModel model;
    build(model);
    const std::vector<double> fits = misfits(model);
    unit = upper_median(fits);
    std::vector<Labelled> labels = labels_;
    for (size_t k = 0; k < fits.size(); ++k) {
      if (fits[k] <= options_.reject_above * unit) continue;
      const auto [v, p] = labels[k];
      use_[static_cast<size_t>(v)][static_cast<size_t>(p)] = false;
      rejected_.push_back(labels[k]);
    }
  }

  block::AdjustedBlock adjust() {
    block::BlockModel model;
    build(model);
    std::vector<std::string> names;
    for (const auto& view : views_) names.push_back(view.path);
    bool undetermined = false;
    try {
      return block::adjust_to_convergence(
          model, options_.max_iterations, [&] { state_.fold(); }, [](block::PartitionedSystem&) {},
          [&](const block::PartitionedSystem& linear, const block::ReducedSystem& reduced) {
            undetermined = true;
            least_squares::require_full_rank(linear, reduced, names, model.kept_labels());
            undetermined = false;
          });
    } catch (const Stopped&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(undetermined ? std::string(error.what()) +
                                                  "; photograph the board tilted, from several sides, and over the "
                                                  "whole image"
                                            : no_convergence());
    }
  }

  /// Angle of the board's normal against the line of sight [rad].
  double tilt_of(size_t view) const {
    const RigidTransform cam_from_board{state_.rotations[view],
                                        {state_.poses[view][0], state_.poses[view][1], state_.poses[view][2]}};
    const Eigen::Vector3d normal = state_.rotations[view] * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d sight = cam_from_board * Eigen::Vector3d(middle_.x(), middle_.y(), 0);
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
    char text[120];
    std::snprintf(text, sizeof text, "half of the photographs look at the board within %.0f degrees of straight, ",
                  tilt);
    return begin + text +
           "which does not tell the principal distance from the distance. Tilt the board by 30 to 50 degrees in half "
           "of them, in several directions";
  }

  CameraEvidence evidence(const block::AdjustedBlock& block, double factor) const {
    std::vector<Eigen::MatrixXd> effects;
    for (const auto& rows : block.linear.observations) {
      effects.emplace_back();
      if (rows.group != 0) continue;
      const auto [v, p] = labels_[static_cast<size_t>(rows.label)];
      const CalibrationPoint& point = views_[static_cast<size_t>(v)].points[static_cast<size_t>(p)];
      effects.back() = effects_at(point.pixel, height_) / point.sigma;
    }
    std::vector<int> members;
    std::vector<std::string> paths;
    for (size_t v = 0; v < views_.size(); ++v) members.push_back(static_cast<int>(v)), paths.push_back(views_[v].path);
    return evidence_of(shares_of(block.linear, effects), block.solution.kept_cofactor, factor, columns_, members,
                       paths);
  }

  CameraTruth judged(CameraEvidence evidence, const Calibration& c) const {
    std::vector<RigidTransform> poses;
    for (const int v : evidence.members) poses.push_back(c.views[static_cast<size_t>(v)].cam_from_board);
    evidence.object_is_known = true;
    return judge_camera(std::move(evidence), c.camera, poses);
  }

  Calibration result(const block::AdjustedBlock& block) const {
    Calibration c;
    c.camera.width = width_, c.camera.height = height_;
    c.camera.set_parameters(state_.interior);
    c.observations = block.linear.row_count(), c.unknowns = block.linear.unknown_count();
    c.degrees_of_freedom = block.linear.redundancy();
    if (c.degrees_of_freedom < 10)
      throw std::runtime_error("the photographs hold hardly more observations than unknowns (" +
                               std::to_string(c.degrees_of_freedom) + " to spare); take more of them");
    double weighted = 0, squares = 0, variance = 0;
    for (size_t v = 0; v < views_.size(); ++v) {
      CalibratedView view;
      view.view = static_cast<int>(v);
      view.cam_from_board = {state_.rotations[v], {state_.poses[v][0], state_.poses[v][1], state_.poses[v][2]}};
      view.tilt = tilt_of(v);
      c.views.push_back(view);
    }
    for (const auto& rows : block.linear.observations) {
      weighted += rows.misclosure.squaredNorm();
      if (rows.group != 0) continue;
      const auto [v, p] = labels_[static_cast<size_t>(rows.label)];
      const double sigma = views_[static_cast<size_t>(v)].points[static_cast<size_t>(p)].sigma;
      CalibratedView& view = c.views[static_cast<size_t>(v)];
      view.points.push_back(p);
      view.residuals.push_back(sigma * rows.misclosure.head<2>());
      view.rms += view.residuals.back().squaredNorm();
      variance += sigma * sigma;
    }
    for (auto& view : c.views) {
      squares += view.rms;
      if (!view.points.empty()) view.rms = std::sqrt(view.rms / static_cast<double>(view.points.size()));
    }
    const double points = static_cast<double>(labels_.size()), factor = weighted / c.degrees_of_freedom;
    c.rms = std::sqrt(squares / points);
    c.sigma = std::sqrt(factor * variance / points);
    const Eigen::MatrixXd& cofactor = block.solution.kept_cofactor;
    c.truth = judged(evidence(block, factor), c);
    c.formal_covariance = in_nine(c.truth.evidence, c.truth.evidence.formal);
    c.covariance = in_nine(c.truth.evidence, c.truth.empirical.written);
    c.bend_x = state_.bend[0], c.bend_y = state_.bend[1];
    if (bend_columns_[0] >= 0) c.bend_x_sigma = std::sqrt(factor * cofactor(bend_columns_[0], bend_columns_[0]));
    if (bend_columns_[1] >= 0) c.bend_y_sigma = std::sqrt(factor * cofactor(bend_columns_[1], bend_columns_[1]));
    for (const auto& [v, p] : rejected_)
      c.rejected.push_back("point " + std::to_string(p) + " in " + views_[static_cast<size_t>(v)].path +
                           ": its residual is more than 5 times that of the median point");
    return c;
  }

  const std::vector<CalibrationView>& views_;
  int width_, height_;
  const CalibrationOptions& options_;
  Eigen::Vector2d middle_, half_;
  std::vector<std::vector<bool>> use_;
  std::vector<Labelled> labels_, rejected_;
  std::vector<int> columns_, bend_columns_;
  State state_;
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
  // Photographs that are too much alike tell neither a bend from the lens nor its third radial coefficient. If it is
  // not that, the last attempt says what.
  std::vector<CalibrationOptions> attempts{options};
  const auto add = [&](bool flat, bool without_k3) {
    attempts.push_back(options);
    if (flat) attempts.back().bend_sigma = 0;
    if (without_k3) std::erase(attempts.back().free, "k3");
  };
  const bool bent = options.bend_sigma > 0;
  if (bent) add(true, false);
  if (std::find(options.free.begin(), options.free.end(), "k3") != options.free.end()) {
    if (bent) add(false, true);
    add(true, true);
  }
  for (size_t k = 0;; ++k) {
    try {
      Calibration result = Calibrator(views, width, height, attempts[k]).run();
      result.held_flat = bent && !(attempts[k].bend_sigma > 0);
      result.held_k3 = attempts[k].free.size() < options.free.size();
      return result;
    } catch (const Stopped&) {
      throw;
    } catch (const std::runtime_error&) {
      if (k + 1 == attempts.size()) throw;
    }
  }
}

LensComparison compare_lenses(const std::vector<CalibrationView>& views, const CalibrationOptions& options,
                              const Calibration& all) {
  constexpr double wide = 35 * std::numbers::pi / 180;
  LensComparison lenses;
  for (const CalibratedView& view : all.views)
    for (const CalibrationPoint& point : views[static_cast<size_t>(view.view)].points) {
      const Eigen::Vector3d ray = view.cam_from_board * point.board;
      lenses.widest = std::max(lenses.widest, std::atan2(ray.head<2>().norm(), ray.z()));
    }
  if (lenses.widest < wide) return lenses;
  CalibrationOptions keep = options, fisheye = options;
  keep.reject_above = 0, fisheye.reject_above = 0;
  fisheye.lens = LensModel::fisheye, fisheye.free = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "p1"};  // p1 is k4 there
  try {
    lenses.brown = Calibrator(views, all.camera.width, all.camera.height, keep).residuals_of_all();
    lenses.fisheye = Calibrator(views, all.camera.width, all.camera.height, fisheye).residuals_of_all();
  } catch (const Stopped&) {
    throw;
  } catch (const std::runtime_error&) {
    lenses.brown = lenses.fisheye = 0;  // one of them fits nothing
  }
  return lenses;
}

}  // namespace plumbline::markers
