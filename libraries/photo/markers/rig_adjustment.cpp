#include "photo/markers/rig_adjustment.hpp"

#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <stdexcept>

#include "geometry/median.hpp"
#include "least_squares/problem/defects.hpp"
#include "photo/markers/rig.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

/// What is estimated besides the poses: everything, less of the lens, nothing.
enum class Freedom { all, principal, none };

constexpr double kDisagrees = 5;  // times the median: a photograph that the rig does not explain
constexpr double kWorse = 10;     // times the calibrations of their own: these cameras are no rig

/// Translation, and a rotation vector on top of `rotation`.
struct Pose {
  std::array<double, 6> values{};
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();

  void set(const RigidTransform& t) {
    values = {t.translation.x(), t.translation.y(), t.translation.z(), 0, 0, 0};
    rotation = t.rotation, matrix = rotation.toRotationMatrix();
  }
  void fold() {
    rotation = (quaternion_from_rotation_vector({values[3], values[4], values[5]}) * rotation).normalized();
    matrix = rotation.toRotationMatrix();
    values[3] = values[4] = values[5] = 0;
  }
  RigidTransform transform() const { return {rotation, {values[0], values[1], values[2]}}; }
};

struct RigCost {
  Eigen::Vector3d board;
  Eigen::Vector2d pixel, unit;  // `unit`: the point from −1 to 1 over the board
  double sigma;
  const Eigen::Matrix3d *exposure_matrix, *camera_matrix;

  template <typename T>
  bool operator()(const T* exposure, const T* camera, const T* interior, const T* bend, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const T z = T(board.z()) + bend[0] * T(1 - unit.x() * unit.x()) + bend[1] * T(1 - unit.y() * unit.y());
    const Vector on_board = exposure_matrix->cast<T>() * Vector(T(board.x()), T(board.y()), z);
    Vector turned, seen;
    ceres::AngleAxisRotatePoint(exposure + 3, on_board.data(), turned.data());
    const Vector in_reference =
        camera_matrix->cast<T>() * Vector(turned[0] + exposure[0], turned[1] + exposure[1], turned[2] + exposure[2]);
    ceres::AngleAxisRotatePoint(camera + 3, in_reference.data(), seen.data());
    const T depth = seen[2] + camera[2];
    if (!(depth > T(1e-9))) return false;
    T computed[2];
    project_normalised(interior, T((seen[0] + camera[0]) / depth), T((seen[1] + camera[1]) / depth), computed);
    residual[0] = (computed[0] - T(pixel.x())) / T(sigma);
    residual[1] = (computed[1] - T(pixel.y())) / T(sigma);
    return true;
  }
};

struct BendCost {
  double sigma;
  template <typename T>
  bool operator()(const T* bend, T* residual) const {
    residual[0] = bend[0] / T(sigma), residual[1] = bend[1] / T(sigma);
    return true;
  }
};

/// One photograph that takes part.
struct Shot {
  int camera = 0;  ///< index into the rig's members
  int view = 0;    ///< index into the calibration's views
  int exposure = 0;
};

/// The unknowns and the model over them; not to be copied, since the model points into it.
struct Problem {
  std::vector<int> members;  ///< indices into the given cameras, the reference first
  std::vector<std::string> exposure_names;
  std::vector<Shot> shots;
  std::vector<Pose> exposures, cameras;
  std::vector<std::array<double, BrownCamera::parameter_count>> interiors;
  std::array<double, 2> bend{};
  std::vector<std::vector<int>> camera_columns, interior_columns;
  std::vector<std::pair<int, int>> labels;  ///< shot and point by label

  void fold() {
    for (Pose& pose : exposures) pose.fold();
    for (Pose& pose : cameras) pose.fold();
  }
};

class RigAdjuster {
 public:
  RigAdjuster(const std::vector<RigCamera>& cameras, const std::vector<std::vector<std::string>>& moments,
              const CalibrationOptions& options)
      : cameras_(cameras), moments_(moments), options_(options) {
    Eigen::AlignedBox2d box;
    for (const auto& camera : cameras)
      for (const auto& view : *camera.views)
        for (const auto& p : view.points) box.extend(p.board.head<2>());
    middle_ = box.center(), half_ = 0.5 * box.sizes().cwiseMax(1e-9);
  }

  /// `part` 0: all exposures; 1 and 2: every other one.
  AdjustedRig adjust(const std::vector<int>& members, const std::vector<RigidTransform>& start, int part) const {
    AdjustedRig rig;
    rig.reference = members.front();
    Problem problem;
    fill(members, start, part, problem);
    leave_out_what_disagrees(problem, rig);
    if (!rig.refused.empty()) return rig;
    const Problem begin = problem;
    for (const Freedom freedom : {Freedom::all, Freedom::principal, Freedom::none}) {
      problem = begin;
      try {
        block::BlockModel model;
        build(problem, freedom, model);
        const block::AdjustedBlock block = block::adjust_to_convergence(
            model, options_.max_iterations, [&] { problem.fold(); }, [](block::PartitionedSystem&) {},
            [&](const block::PartitionedSystem& linear, const block::ReducedSystem& reduced) {
              least_squares::require_full_rank(linear, reduced, problem.exposure_names, model.kept_labels());
            });
        read(problem, block, rig);
        if (freedom == Freedom::principal)
          rig.held = "k3, p1, p2 of the cameras and the bend of the board";
        else if (freedom == Freedom::none)
          rig.held = "the interior orientations and the bend of the board";
        return rig;
      } catch (const Stopped&) {
        throw;
      } catch (const std::runtime_error& error) {
        if (freedom == Freedom::none) rig.refused = std::string("the common adjustment failed: ") + error.what();
      }
    }
    return rig;
  }

  int shared_exposures(const std::vector<int>& members, int camera) const {
    std::set<std::string> others;
    for (const int c : members)
      if (c != camera) others.insert(moments_[static_cast<size_t>(c)].begin(), moments_[static_cast<size_t>(c)].end());
    const auto& own = moments_[static_cast<size_t>(camera)];
    return static_cast<int>(std::count_if(own.begin(), own.end(), [&](const auto& m) { return others.count(m) > 0; }));
  }

 private:
  const CalibratedView& calibrated(const Problem& p, const Shot& s) const {
    const size_t camera = static_cast<size_t>(p.members[static_cast<size_t>(s.camera)]);
    return cameras_[camera].calibration->views[static_cast<size_t>(s.view)];
  }
  const CalibrationView& given(const Problem& p, const Shot& s) const {
    const size_t camera = static_cast<size_t>(p.members[static_cast<size_t>(s.camera)]);
    return (*cameras_[camera].views)[static_cast<size_t>(calibrated(p, s).view)];
  }

  void fill(const std::vector<int>& members, const std::vector<RigidTransform>& start, int part, Problem& p) const {
    p.members = members;
    std::set<std::string> names;
    for (const int c : members)
      names.insert(moments_[static_cast<size_t>(c)].begin(), moments_[static_cast<size_t>(c)].end());
    std::map<std::string, int> exposure;
    int number = 0;
    for (const auto& name : names) {
      ++number;
      if (part > 0 && number % 2 != part - 1) continue;
      exposure[name] = static_cast<int>(p.exposure_names.size());
      p.exposure_names.push_back(name);
    }
    p.exposures.resize(p.exposure_names.size());
    std::vector<size_t> most(p.exposures.size(), 0);
    for (size_t m = 0; m < members.size(); ++m) {
      const size_t c = static_cast<size_t>(members[m]);
      p.cameras.emplace_back().set(start[m]);
      p.interiors.push_back(cameras_[c].calibration->camera.parameters());
      const auto& views = cameras_[c].calibration->views;
      for (size_t v = 0; v < views.size(); ++v) {
        const auto at = exposure.find(moments_[c][static_cast<size_t>(views[v].view)]);
        if (at == exposure.end() || views[v].points.size() < 4) continue;
        const size_t e = static_cast<size_t>(at->second);
        p.shots.push_back({static_cast<int>(m), static_cast<int>(v), at->second});
        if (views[v].points.size() <= most[e]) continue;
        most[e] = views[v].points.size();
        p.exposures[e].set(start[m].inverse() * views[v].cam_from_board);
      }
    }
    p.bend = {cameras_[static_cast<size_t>(members[0])].calibration->bend_x,
              cameras_[static_cast<size_t>(members[0])].calibration->bend_y};
    if (!(options_.bend_sigma > 0)) p.bend = {0, 0};
    drop_empty_exposures(p);
  }

  static void drop_empty_exposures(Problem& p) {
    std::vector<int> photographs(p.exposures.size(), 0), now(p.exposures.size(), -1);
    for (const Shot& s : p.shots) ++photographs[static_cast<size_t>(s.exposure)];
    Problem kept;
    for (size_t e = 0; e < photographs.size(); ++e) {
      if (photographs[e] == 0) continue;
      now[e] = static_cast<int>(kept.exposures.size());
      kept.exposures.push_back(p.exposures[e]), kept.exposure_names.push_back(p.exposure_names[e]);
    }
    for (Shot& s : p.shots) s.exposure = now[static_cast<size_t>(s.exposure)];
    p.exposures = std::move(kept.exposures), p.exposure_names = std::move(kept.exposure_names);
  }

  void build(Problem& p, Freedom freedom, block::BlockModel& model) const {
    p.camera_columns.clear(), p.interior_columns.clear(), p.labels.clear();
    model.add_group("points"), model.add_group("bend");
    for (Pose& pose : p.exposures) model.add_pose(pose.values.data());
    for (size_t m = 0; m < p.members.size(); ++m) {
      const std::string of = " of camera " + cameras_[static_cast<size_t>(p.members[m])].id;
      std::vector<std::string> labels(3, "place in the rig" + of), names;
      labels.resize(6, "rotation in the rig" + of);
      p.camera_columns.push_back(model.add_kept(p.cameras[m].values.data(), std::vector<bool>(6, m > 0), labels));
      const Calibration& own = *cameras_[static_cast<size_t>(p.members[m])].calibration;
      std::vector<bool> free;
      for (Eigen::Index k = 0; k < BrownCamera::parameter_count; ++k) {
        const bool estimated = own.covariance.size() == 0 || own.covariance(k, k) > 0;
        free.push_back(estimated && freedom != Freedom::none && (freedom == Freedom::all || k < 6));
        names.push_back(BrownCamera::parameter_names[static_cast<size_t>(k)] + of);
      }
      p.interior_columns.push_back(model.add_kept(p.interiors[m].data(), free, names));
    }
    const bool bent = options_.bend_sigma > 0 && freedom == Freedom::all;
    model.add_kept(p.bend.data(), {bent, bent}, {"bend of the board in x", "bend of the board in y"});
    if (bent)
      model.add_term(std::make_unique<block::DifferentiatedCost<BendCost, 2, 2>>(new BendCost{options_.bend_sigma}),
                     {p.bend.data()}, 1, 0);
    for (size_t s = 0; s < p.shots.size(); ++s) {
      const Shot& shot = p.shots[s];
      const size_t c = static_cast<size_t>(shot.camera), e = static_cast<size_t>(shot.exposure);
      for (const int k : calibrated(p, shot).points) {
        const CalibrationPoint& point = given(p, shot).points[static_cast<size_t>(k)];
        const Eigen::Vector2d unit = (point.board.head<2>() - middle_).cwiseQuotient(half_);
        auto* cost =
            new RigCost{point.board, point.pixel, unit, point.sigma, &p.exposures[e].matrix, &p.cameras[c].matrix};
        model.add_term(
            std::make_unique<block::DifferentiatedCost<RigCost, 2, 6, 6, BrownCamera::parameter_count, 2>>(cost),
            {p.exposures[e].values.data(), p.cameras[c].values.data(), p.interiors[c].data(), p.bend.data()}, 0,
            static_cast<int>(p.labels.size()), true);
        p.labels.emplace_back(static_cast<int>(s), k);
      }
    }
  }

  /// Root mean square residual of every photograph [px], after a robust minimisation over the poses alone.
  std::vector<double> fit(Problem& p) const {
    std::vector<double> squares(p.shots.size(), 0), points(p.shots.size(), 0);
    block::BlockModel model;
    build(p, Freedom::none, model);
    double unit = 10;
    for (int pass = 0; pass < 3; ++pass) {
      model.minimise(options_.max_iterations, {bundle::Loss::Kind::cauchy, 3 * unit});
      p.fold();
      std::vector<double> lengths;
      for (const auto& rows : model.linearise().observations)
        if (rows.group == 0) lengths.push_back(rows.misclosure.norm());
      unit = std::clamp(upper_median(lengths), 1e-3, unit);
    }
    for (const auto& rows : model.linearise().observations) {
      if (rows.group != 0) continue;
      const auto [s, k] = p.labels[static_cast<size_t>(rows.label)];
      const double sigma = given(p, p.shots[static_cast<size_t>(s)]).points[static_cast<size_t>(k)].sigma;
      squares[static_cast<size_t>(s)] += sigma * sigma * rows.misclosure.squaredNorm();
      points[static_cast<size_t>(s)] += 1;
    }
    for (size_t s = 0; s < squares.size(); ++s) squares[s] = std::sqrt(squares[s] / points[s]);
    return squares;
  }

  static std::string no_rig(int bad, int of, const std::string& camera, double together, double separate) {
    char text[400];
    std::snprintf(
        text, sizeof text,
        "(as a rig all fit to %.1f px in the median, each camera for itself to %.2f px): photographs with the "
        "same number were not taken together, the cameras moved against each other, or cameras are mixed up",
        together, separate);
    if (bad == 0) return std::string("no places of the cameras to each other explain the photographs ") + text;
    return std::to_string(bad) + " of " + std::to_string(of) + " photographs of camera " + camera +
           " do not show the board where the rig has it " + text;
  }

  /// A photograph that was not taken together with the others of its exposure does not fit; if most of a camera don't,
  /// this is no rig.
  void leave_out_what_disagrees(Problem& p, AdjustedRig& rig) const {
    double separate = 0;
    for (const int c : p.members) separate = std::max(separate, cameras_[static_cast<size_t>(c)].calibration->rms);
    const std::vector<double> rms = fit(p);
    const double limit = kDisagrees * std::max(separate, std::min(upper_median(rms), kWorse * separate));
    std::vector<Shot> kept;
    std::vector<int> own(p.members.size(), 0), good(p.members.size(), 0);
    for (size_t s = 0; s < rms.size(); ++s) {
      const size_t c = static_cast<size_t>(p.shots[s].camera);
      ++own[c];
      if (rms[s] <= limit)
        kept.push_back(p.shots[s]), ++good[c];
      else
        rig.left_out.push_back(given(p, p.shots[s]).path);
    }
    for (size_t c = 0; c < own.size() && rig.refused.empty(); ++c) {
      if (upper_median(rms) <= kWorse * separate && good[c] >= 3 && 2 * good[c] >= own[c]) continue;
      rig.refused =
          no_rig(own[c] - good[c], own[c], cameras_[static_cast<size_t>(p.members[c])].id, upper_median(rms), separate);
    }
    if (!rig.refused.empty()) return;
    p.shots = std::move(kept);
    drop_empty_exposures(p);
  }

  void read(const Problem& p, const block::AdjustedBlock& block, AdjustedRig& rig) const {
    double weighted = 0, variance = 0, squares = 0;
    std::vector<double> own(p.members.size(), 0), points(p.members.size(), 0);
    for (const auto& rows : block.linear.observations) {
      weighted += rows.misclosure.squaredNorm();
      if (rows.group != 0) continue;
      const auto [s, k] = p.labels[static_cast<size_t>(rows.label)];
      const Shot& shot = p.shots[static_cast<size_t>(s)];
      const double sigma = given(p, shot).points[static_cast<size_t>(k)].sigma;
      const double square = sigma * sigma * rows.misclosure.squaredNorm();
      own[static_cast<size_t>(shot.camera)] += square, points[static_cast<size_t>(shot.camera)] += 1;
      squares += square, variance += sigma * sigma;
    }
    rig.exposures = static_cast<int>(p.exposures.size());
    rig.observations = block.linear.row_count(), rig.unknowns = block.linear.unknown_count();
    rig.degrees_of_freedom = block.linear.redundancy();
    const double all = static_cast<double>(p.labels.size()), factor = weighted / rig.degrees_of_freedom;
    rig.rms = std::sqrt(squares / all), rig.sigma = std::sqrt(factor * variance / all);
    const Eigen::MatrixXd& cofactor = block.solution.kept_cofactor;
    const std::array<size_t, 6> turn_first = {3, 4, 5, 0, 1, 2};
    for (size_t m = 0; m < p.members.size(); ++m) {
      AdjustedRigCamera camera;
      camera.camera = p.members[m];
      camera.cam_from_reference = p.cameras[m].transform();
      const Calibration& separate = *cameras_[static_cast<size_t>(p.members[m])].calibration;
      camera.interior = separate.camera;
      camera.interior.set_parameters(p.interiors[m]);
      camera.interior_covariance = Eigen::MatrixXd::Zero(BrownCamera::parameter_count, BrownCamera::parameter_count);
      for (Eigen::Index i = 0; i < BrownCamera::parameter_count; ++i)
        for (Eigen::Index j = 0; j < BrownCamera::parameter_count; ++j) {
          const int row = p.interior_columns[m][static_cast<size_t>(i)],
                    column = p.interior_columns[m][static_cast<size_t>(j)];
          if (row >= 0 && column >= 0) camera.interior_covariance(i, j) = factor * cofactor(row, column);
        }
      for (Eigen::Index i = 0; i < 6 && m > 0; ++i)
        for (Eigen::Index j = 0; j < 6; ++j)
          camera.covariance(i, j) = factor * cofactor(p.camera_columns[m][turn_first[static_cast<size_t>(i)]],
                                                      p.camera_columns[m][turn_first[static_cast<size_t>(j)]]);
      camera.rms = std::sqrt(own[m] / std::max(1.0, points[m])), camera.separate_rms = separate.rms;
      camera.shared = shared_exposures(p.members, p.members[m]);
      camera.halves = std::nan("");
      rig.cameras.push_back(camera);
    }
  }

  const std::vector<RigCamera>& cameras_;
  const std::vector<std::vector<std::string>>& moments_;
  const CalibrationOptions& options_;
  Eigen::Vector2d middle_, half_;
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
      views[c].push_back({moments[c][static_cast<size_t>(view.view)], view.cam_from_board});
  std::vector<Component> components;
  std::vector<std::pair<size_t, size_t>> place(cameras.size(), {0, 0});  // component and index in it, both from 1
  for (const RigPose& pose : rig_of(views)) {
    auto& reference = place[static_cast<size_t>(pose.reference)];
    if (reference.first == 0) {
      components.push_back({{pose.reference}, {RigidTransform{}}});
      reference = {components.size(), 1};
    }
    Component& own = components[reference.first - 1];
    own.members.push_back(pose.camera);
    own.from_first.push_back(pose.cam_from_reference * own.from_first[reference.second - 1]);
    place[static_cast<size_t>(pose.camera)] = {reference.first, own.members.size()};
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
    const block::Matrix6 covariance = a.covariance + b.covariance;
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
