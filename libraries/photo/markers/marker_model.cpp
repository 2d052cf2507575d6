#include "photo/markers/marker_model.hpp"

#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plumbline::markers {
namespace {

constexpr int interior_count = BrownCamera::parameter_count;

/// The four corners of one tag in one image. Parameters: pose, centre, turn, scale, shape, interior orientation, corner
/// inset.
struct ViewCost {
  std::array<Eigen::Vector2d, 4> corners;
  std::array<Eigen::Matrix2d, 4> whitening;
  double half = 0;
  const Eigen::Matrix3d* camera_matrix;
  const Eigen::Matrix3d* tag_matrix;
  const double* sigma_factor;

  template <typename T>
  bool operator()(const T* pose, const T* centre, const T* turn, const T* scale, const T* shape, const T* interior,
                  const T* inset, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    using Pixel = Eigen::Matrix<T, 2, 1>;
    std::array<Pixel, 4> pixels;
    const std::array<Vector, 4> in_tag = shaped_corners(T(scale[0] * T(half)), shape);
    for (size_t k = 0; k < 4; ++k) {
      const Vector start = tag_matrix->cast<T>() * in_tag[k];
      Vector turned, in_camera;
      ceres::AngleAxisRotatePoint(turn, start.data(), turned.data());
      const Vector ray(centre[0] + turned[0] - pose[0], centre[1] + turned[1] - pose[1],
                       centre[2] + turned[2] - pose[2]);
      const Vector approximate = camera_matrix->cast<T>() * ray;
      ceres::AngleAxisRotatePoint(pose + 3, approximate.data(), in_camera.data());
      if (!(in_camera[2] > T(1e-9))) return false;
      project_normalised(interior, T(in_camera[0] / in_camera[2]), T(in_camera[1] / in_camera[2]), pixels[k].data());
    }
    for (size_t k = 0; k < 4; ++k) {
      // Both edges at the corner move inwards by the inset: along each edge by inset / sin(angle between them).
      const Pixel next = (pixels[(k + 1) % 4] - pixels[k]).normalized(),
                  previous = (pixels[(k + 3) % 4] - pixels[k]).normalized();
      const T sine = abs(T(next[0] * previous[1] - next[1] * previous[0]));
      if (!(sine > T(1e-6))) return false;
      const Pixel drawn = pixels[k] + (inset[0] / sine) * (next + previous);
      const T dx = drawn[0] - T(corners[k].x()), dy = drawn[1] - T(corners[k].y());
      residual[2 * k] = (whitening[k](0, 0) * dx + whitening[k](0, 1) * dy) / T(*sigma_factor);
      residual[2 * k + 1] = (whitening[k](1, 0) * dx + whitening[k](1, 1) * dy) / T(*sigma_factor);
    }
    return true;
  }
};

/// W (x − x0) of one parameter block.
class PriorCost : public block::CostFunction {
 public:
  PriorCost(Eigen::MatrixXd whitening, Eigen::VectorXd target)
      : CostFunction(static_cast<int>(whitening.rows())),
        whitening_(std::move(whitening)),
        target_(std::move(target)) {}
  bool evaluate(const double* const* parameters, double* residuals, double* const* jacobians) const override {
    const Eigen::Map<const Eigen::VectorXd> x(parameters[0], target_.size());
    Eigen::Map<Eigen::VectorXd>(residuals, whitening_.rows()) = whitening_ * (x - target_);
    if (jacobians && jacobians[0])
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[0], whitening_.rows(), whitening_.cols()) = whitening_;
    return true;
  }

 private:
  Eigen::MatrixXd whitening_;
  Eigen::VectorXd target_;
};

/// A tag's place in a layout: centre and rotation against their nominal values.
struct LayoutCost {
  Eigen::Vector3d centre;
  Eigen::Quaterniond rotation;
  const Eigen::Quaterniond* world_from_tag;
  double position_sigma, rotation_sigma;

  template <typename T>
  bool operator()(const T* at, const T* turn, T* residual) const {
    for (int k = 0; k < 3; ++k) residual[k] = (at[k] - T(centre[k])) / T(position_sigma);
    T increment[4], total[4], vector[3];
    ceres::AngleAxisToQuaternion(turn, increment);
    const Eigen::Quaterniond rest = *world_from_tag * rotation.conjugate();
    const T before[4] = {T(rest.w()), T(rest.x()), T(rest.y()), T(rest.z())};
    ceres::QuaternionProduct(increment, before, total);
    ceres::QuaternionToAngleAxis(total, vector);
    for (int k = 0; k < 3; ++k) residual[3 + k] = vector[k] / T(rotation_sigma);
    return true;
  }
};

/// What is known of any camera: square pixels within a per cent, a principal point near the middle, no more distortion
/// than lenses have. Weak enough to leave to the photographs what they determine, and what keeps a block of few
/// photographs from running away.
void add_interior(const MarkerCamera& camera, MarkerState& state, size_t c, MarkerModel& result) {
  std::vector<std::string> labels;
  for (const char* name : BrownCamera::parameter_names)
    labels.push_back(std::string(name) + (camera.id.empty() ? "" : " of camera " + camera.id));
  std::vector<bool> free(interior_count, !camera.held);
  const bool has_prior = camera.covariance.size() > 0;
  if (has_prior)
    for (int k = 0; k < interior_count; ++k)
      free[static_cast<size_t>(k)] = free[static_cast<size_t>(k)] && camera.covariance(k, k) > 0;
  result.interior_columns.push_back(result.model.add_kept(state.interiors[c].data(), free, labels));
  std::vector<int> chosen;
  for (int k = 0; k < interior_count; ++k)
    if (free[static_cast<size_t>(k)]) chosen.push_back(k);
  if (chosen.empty()) return;
  Eigen::VectorXd target(interior_count);
  const auto start = camera.camera.parameters();
  for (int k = 0; k < interior_count; ++k) target(k) = start[static_cast<size_t>(k)];
  Eigen::MatrixXd whitening;
  if (has_prior) {
    const Eigen::LLT<Eigen::MatrixXd> factor(camera.covariance(chosen, chosen).eval());
    if (factor.info() != Eigen::Success)
      throw std::runtime_error("the covariance of camera '" + camera.id + "' is not positive definite");
    const Eigen::Index n = static_cast<Eigen::Index>(chosen.size());
    const Eigen::MatrixXd lower = factor.matrixL();
    const Eigen::MatrixXd inverse =
        lower.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd(Eigen::MatrixXd::Identity(n, n)));
    whitening = Eigen::MatrixXd::Zero(n, interior_count);
    for (Eigen::Index k = 0; k < n; ++k) whitening.col(chosen[static_cast<size_t>(k)]) = inverse.col(k);
  } else {
    const double extent = std::max(camera.camera.width, camera.camera.height);
    whitening = Eigen::MatrixXd::Zero(8, interior_count);
    target(2) = 0.5 * (camera.camera.width - 1), target(3) = 0.5 * (camera.camera.height - 1);
    target.tail<5>().setZero();
    target(0) = target(1) = 0;
    whitening(0, 0) = 1 / (0.01 * extent), whitening(0, 1) = -whitening(0, 0);
    whitening(1, 2) = whitening(2, 3) = 1 / (0.05 * extent);
    whitening(3, 4) = 1 / 0.5, whitening(4, 5) = 1 / 1.0, whitening(5, 6) = 1 / 1.0;
    whitening(6, 7) = whitening(7, 8) = 1 / 0.01;
  }
  result.model.add_term(std::make_unique<PriorCost>(whitening, target), {state.interiors[c].data()}, group_interior, 0);
}

/// What a tag may differ from a square by, with its prior.
void add_shape(const MarkerOptions& options, const std::string& of, int j, MarkerState& state,
               block::BlockModel& model) {
  auto& shape = state.shapes[static_cast<size_t>(j)];
  const bool in_plane = options.shape_sigma > 0, twist = options.twist_sigma > 0;
  model.add_kept(shape.data(), {in_plane, in_plane, in_plane, in_plane, twist},
                 std::vector<std::string>(shape_count, "shape" + of));
  if (!in_plane && !twist) return;
  Eigen::MatrixXd whitening = Eigen::MatrixXd::Zero(shape_count, shape_count);
  for (int k = 0; k < shape_count; ++k) {
    const double sigma = k + 1 < shape_count ? options.shape_sigma : options.twist_sigma;
    if (sigma > 0) whitening(k, k) = 1 / sigma;
  }
  std::vector<Eigen::Index> used;
  for (Eigen::Index k = 0; k < shape_count; ++k)
    if (whitening(k, k) > 0) used.push_back(k);
  model.add_term(std::make_unique<PriorCost>(whitening(used, Eigen::all), Eigen::VectorXd::Zero(shape_count)),
                 {shape.data()}, group_shape, j);
}

Eigen::Matrix2d whitening_of(const Eigen::Matrix2d& covariance) {
  const Eigen::Matrix2d lower = covariance.llt().matrixL();
  return lower.inverse();
}

}  // namespace

void MarkerState::fold() {
  for (size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d turn(poses[i][3], poses[i][4], poses[i][5]);
    cam_from_world[i] = (quaternion_from_rotation_vector(turn) * cam_from_world[i]).normalized();
    camera_matrices[i] = cam_from_world[i].toRotationMatrix();
    poses[i][3] = poses[i][4] = poses[i][5] = 0;
  }
  for (size_t j = 0; j < turns.size(); ++j) {
    const Eigen::Vector3d turn(turns[j][0], turns[j][1], turns[j][2]);
    world_from_tag[j] = (quaternion_from_rotation_vector(turn) * world_from_tag[j]).normalized();
    tag_matrices[j] = world_from_tag[j].toRotationMatrix();
    turns[j] = {0, 0, 0};
  }
}

void fill_state(const MarkerBlock& block, const MarkerStart& start, const std::vector<bool>& use, MarkerState& state) {
  state = MarkerState{};
  std::vector<int> image_views(block.images.size(), 0), marker_views(block.markers.size(), 0);
  for (size_t v = 0; v < block.views.size(); ++v) {
    const MarkerView& view = block.views[v];
    if (!use[v] || !start.cam_from_world[static_cast<size_t>(view.image)] ||
        !start.world_from_tag[static_cast<size_t>(view.marker)])
      continue;
    state.views.push_back(static_cast<int>(v));
    ++image_views[static_cast<size_t>(view.image)], ++marker_views[static_cast<size_t>(view.marker)];
  }
  for (size_t i = 0; i < block.images.size(); ++i) {
    if (!image_views[i]) continue;
    const RigidTransform& pose = *start.cam_from_world[i];
    const Eigen::Vector3d centre = pose.inverse().translation;
    state.images.push_back(static_cast<int>(i));
    state.poses.push_back({centre.x(), centre.y(), centre.z(), 0, 0, 0});
    state.cam_from_world.push_back(pose.rotation);
  }
  for (size_t m = 0; m < block.markers.size(); ++m) {
    if (!marker_views[m]) continue;
    const RigidTransform& pose = *start.world_from_tag[m];
    state.markers.push_back(static_cast<int>(m));
    state.centres.push_back({pose.translation.x(), pose.translation.y(), pose.translation.z()});
    state.world_from_tag.push_back(pose.rotation);
    state.scales.push_back(1);
    state.shapes.push_back({});
  }
  state.turns.assign(state.markers.size(), {0, 0, 0});
  state.camera_matrices.resize(state.images.size()), state.tag_matrices.resize(state.markers.size());
  for (const BrownCamera& camera : start.cameras) state.interiors.push_back(camera.parameters());
  state.insets.assign(block.cameras.size(), 0);
  state.fold();
}

Eigen::Matrix<double, 8, 8> view_root(const MarkerView& view) {
  Eigen::Matrix<double, 8, 8> root = Eigen::Matrix<double, 8, 8>::Zero();
  for (Eigen::Index k = 0; k < 4; ++k)
    root.block<2, 2>(2 * k, 2 * k) = view.covariances[static_cast<size_t>(k)].llt().matrixL();
  return root;
}

void build_model(const MarkerBlock& block, const MarkerOptions& options, MarkerState& state, MarkerModel& result) {
  result = MarkerModel{};
  block::BlockModel& model = result.model;
  for (const char* name : {"corners", "corners that were not refined", "layout", "tag size", "tag shape",
                           "interior orientation", "corner inset"})
    model.add_group(name);
  for (auto& pose : state.poses) model.add_pose(pose.data());
  std::vector<bool> camera_used(block.cameras.size(), false);
  for (const int i : state.images) camera_used[static_cast<size_t>(block.images[static_cast<size_t>(i)].camera)] = true;
  std::vector<int> image_index(block.images.size(), -1), marker_index(block.markers.size(), -1);
  for (size_t i = 0; i < state.images.size(); ++i)
    image_index[static_cast<size_t>(state.images[i])] = static_cast<int>(i);
  for (size_t j = 0; j < state.markers.size(); ++j) {
    const Marker& marker = block.markers[static_cast<size_t>(state.markers[j])];
    marker_index[static_cast<size_t>(state.markers[j])] = static_cast<int>(j);
    const std::string of = " of tag " + marker.name();
    const std::vector<bool> free(3, true);
    result.centre_columns.push_back(
        model.add_kept(state.centres[j].data(), free, {"x" + of, "y" + of, "z" + of}).front());
    result.turn_columns.push_back(
        model.add_kept(state.turns[j].data(), free, {"rotation" + of, "rotation" + of, "rotation" + of}).front());
    result.scale_columns.push_back(model.add_kept(&state.scales[j], {options.size_sigma > 0}, {"size" + of}).front());
    if (options.size_sigma > 0)
      model.add_term(std::make_unique<PriorCost>(Eigen::MatrixXd::Constant(1, 1, 1 / options.size_sigma),
                                                 Eigen::VectorXd::Ones(1)),
                     {&state.scales[j]}, group_size, static_cast<int>(j));
    add_shape(options, of, static_cast<int>(j), state, model);
    if (!marker.world_from_tag) continue;
    auto* cost = new block::DifferentiatedCost<LayoutCost, 6, 3, 3>(
        new LayoutCost{marker.world_from_tag->translation, marker.world_from_tag->rotation, &state.world_from_tag[j],
                       options.layout_position_sigma, options.layout_rotation_sigma});
    model.add_term(std::unique_ptr<block::CostFunction>(cost), {state.centres[j].data(), state.turns[j].data()},
                   group_layout, static_cast<int>(j));
  }
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    MarkerCamera camera = block.cameras[c];
    camera.held = camera.held || !camera_used[c];
    add_interior(camera, state, c, result);
    const bool inset = options.inset_sigma > 0 && camera_used[c];
    result.inset_columns.push_back(
        model.add_kept(&state.insets[c], {inset}, {"corner inset of camera " + camera.id}).front());
    if (inset)
      model.add_term(std::make_unique<PriorCost>(Eigen::MatrixXd::Constant(1, 1, 1 / options.inset_sigma),
                                                 Eigen::VectorXd::Zero(1)),
                     {&state.insets[c]}, group_inset, static_cast<int>(c));
  }
  for (size_t k = 0; k < state.views.size(); ++k) {
    const MarkerView& view = block.views[static_cast<size_t>(state.views[k])];
    const size_t i = static_cast<size_t>(image_index[static_cast<size_t>(view.image)]),
                 j = static_cast<size_t>(marker_index[static_cast<size_t>(view.marker)]),
                 c = static_cast<size_t>(block.images[static_cast<size_t>(view.image)].camera);
    auto cost = std::make_unique<ViewCost>();
    cost->corners = view.corners;
    for (size_t q = 0; q < 4; ++q) cost->whitening[q] = whitening_of(view.covariances[q]);
    cost->half = 0.5 * block.markers[static_cast<size_t>(view.marker)].size;
    cost->camera_matrix = &state.camera_matrices[i], cost->tag_matrix = &state.tag_matrices[j];
    cost->sigma_factor = &state.sigma_factors[view.refined ? 0 : 1];
    model.add_term(
        std::make_unique<block::DifferentiatedCost<ViewCost, 8, 6, 3, 3, 1, shape_count, 9, 1>>(cost.release()),
        {state.poses[i].data(), state.centres[j].data(), state.turns[j].data(), &state.scales[j],
         state.shapes[j].data(), state.interiors[c].data(), &state.insets[c]},
        view.refined ? group_refined : group_unrefined, static_cast<int>(k), true);
  }
}

bool in_one_line(const MarkerBlock& block, const MarkerState& state) {
  const Eigen::Index count = static_cast<Eigen::Index>(state.centres.size());
  Eigen::MatrixXd centres(3, count);
  double size = 0;
  for (Eigen::Index j = 0; j < count; ++j) {
    centres.col(j) = Eigen::Map<const Eigen::Vector3d>(state.centres[static_cast<size_t>(j)].data());
    size = std::max(size, block.markers[static_cast<size_t>(state.markers[static_cast<size_t>(j)])].size);
  }
  const Eigen::MatrixXd offsets = centres.colwise() - centres.rowwise().mean();
  const Eigen::Matrix3d scatter = offsets * offsets.transpose() / static_cast<double>(count);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(scatter);
  return std::sqrt(std::max(0.0, spread.eigenvalues()(1))) < 0.1 * size;
}

std::vector<int> datum_columns(const MarkerBlock& block, const MarkerState& state, const MarkerModel& model) {
  std::vector<int> columns;
  const auto add = [&](const std::vector<int>& firsts) {
    for (const int first : firsts)
      for (int c = 0; c < 3; ++c) columns.push_back(first + c);
  };
  add(model.centre_columns);
  if (in_one_line(block, state)) add(model.turn_columns);
  return columns;
}

Eigen::MatrixXd free_motions(const MarkerState& state, const MarkerModel& model) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& c : state.centres)
    middle += Eigen::Map<const Eigen::Vector3d>(c.data()) / static_cast<double>(state.centres.size());
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(model.model.kept_count(), 6);
  for (size_t j = 0; j < state.centres.size(); ++j) {
    const Eigen::Vector3d offset = Eigen::Map<const Eigen::Vector3d>(state.centres[j].data()) - middle;
    motions.block<3, 3>(model.centre_columns[j], 0).setIdentity();
    motions.block<3, 3>(model.centre_columns[j], 3) = -skew(offset);
    motions.block<3, 3>(model.turn_columns[j], 3).setIdentity();
  }
  return motions;
}

}  // namespace plumbline::markers
