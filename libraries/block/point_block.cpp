#include "block/point_block.hpp"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "block/block_model.hpp"
#include "block/defects.hpp"
#include "block/row_quality.hpp"
#include "geometry/similarity.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::adjust {
namespace {

/// Sensor coordinates [mm] of a direction in the camera frame.
template <typename T>
void image_point(const T* interior, double balance_radius, const T* direction, T* sensor) {
  const T x = interior[0] * direction[0] / direction[2];
  const T y = interior[0] * direction[1] / direction[2];
  const T r2 = x * x + y * y;
  const double b2 = balance_radius * balance_radius;
  const T radial = interior[3] * (r2 - T(b2)) + interior[4] * (r2 * r2 - T(b2 * b2)) +
                   interior[5] * (r2 * r2 * r2 - T(b2 * b2 * b2));
  const T cross = T(2) * x * y;
  sensor[0] = interior[1] + x + x * radial + interior[6] * (r2 + T(2) * x * x) + interior[7] * cross + interior[8] * x +
              interior[9] * y;
  sensor[1] = interior[2] + y + y * radial + interior[7] * (r2 + T(2) * y * y) + interior[6] * cross;
}

/// Pose values: projection centre, then a rotation vector in the camera frame on top of the rotation held here.
struct ImagePointCost {
  Eigen::Vector2d observed;
  double sigma;
  double balance_radius;
  const Eigen::Matrix3d* camera_from_block;

  template <typename T>
  bool operator()(const T* pose, const T* interior, const T* point, T* residual) const {
    const Eigen::Matrix<T, 3, 1> ray(point[0] - pose[0], point[1] - pose[1], point[2] - pose[2]);
    const Eigen::Matrix<T, 3, 1> turned = camera_from_block->cast<T>() * ray;
    T direction[3];
    ceres::AngleAxisRotatePoint(pose + 3, turned.data(), direction);
    if (!(direction[2] < T(0))) return false;  // the scene lies at negative z
    T sensor[2];
    image_point(interior, balance_radius, direction, sensor);
    residual[0] = (sensor[0] - T(observed.x())) / T(sigma);
    residual[1] = (sensor[1] - T(observed.y())) / T(sigma);
    return true;
  }
};

struct DistanceCost {
  double length, sigma;
  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    const Eigen::Matrix<T, 3, 1> d(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    residual[0] = (d.norm() - T(length)) / T(sigma);
    return true;
  }
};

struct State {
  std::vector<std::array<double, 6>> poses;
  std::vector<Eigen::Quaterniond> camera_from_block;
  std::vector<Eigen::Matrix3d> matrices;  ///< of camera_from_block, where the cost functions read them
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<double, SensorCamera::parameter_count>> interiors;

  void fold() {
    for (size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Vector3d turn(poses[i][3], poses[i][4], poses[i][5]);
      camera_from_block[i] = (quaternion_from_rotation_vector(turn) * camera_from_block[i]).normalized();
      matrices[i] = camera_from_block[i].toRotationMatrix();
      poses[i][3] = poses[i][4] = poses[i][5] = 0;
    }
  }
};

State initial_state(const PointBlock& block) {
  State state;
  for (const auto& image : block.images) {
    state.poses.push_back({image.centre.x(), image.centre.y(), image.centre.z(), 0, 0, 0});
    state.camera_from_block.emplace_back(rotation_from_angles(image.angles).transpose());
    state.matrices.push_back(state.camera_from_block.back().toRotationMatrix());
  }
  for (const auto& point : block.points) state.points.push_back(point.position);
  for (const auto& camera : block.cameras) state.interiors.push_back(camera.values);
  return state;
}

std::vector<int> parameter_indices(const std::vector<std::string>& names) {
  std::vector<int> indices;
  for (int i = 0; i < SensorCamera::parameter_count; ++i)
    if (std::find(names.begin(), names.end(), SensorCamera::names[static_cast<size_t>(i)]) != names.end())
      indices.push_back(i);
  for (const auto& name : names)
    if (std::find(SensorCamera::names.begin(), SensorCamera::names.end(), name) == SensorCamera::names.end())
      throw std::runtime_error("unknown interior parameter '" + name +
                               "'; known are Ck, xh, yh, A1, A2, A3, B1, B2, C1, C2");
  return indices;
}

void require_enough_observations(const PointBlock& block) {
  if (block.images.size() < 2)
    throw std::runtime_error("a block needs at least 2 images, this one has " + std::to_string(block.images.size()));
  std::vector<int> rays(block.points.size()), seen(block.images.size());
  for (const auto& m : block.measurements) {
    ++rays[static_cast<size_t>(m.point)];
    ++seen[static_cast<size_t>(m.image)];
  }
  std::vector<std::string> few;
  for (size_t i = 0; i < rays.size(); ++i)
    if (rays[i] < 2) few.push_back(block.points[i].name);
  if (!few.empty())
    throw std::runtime_error("object point" + std::string(few.size() > 1 ? "s " : " ") + enumerate(few) +
                             " measured in fewer than 2 images: no position follows from that; leave the point out");
  for (size_t i = 0; i < seen.size(); ++i)
    if (seen[i] < 3) few.push_back(std::to_string(block.images[i].id) + " (" + std::to_string(seen[i]) + ")");
  if (!few.empty())
    throw std::runtime_error("image" + std::string(few.size() > 1 ? "s " : " ") + enumerate(few) +
                             " with fewer than 3 measured points: the pose is undetermined; leave the image out");
}

double sigma_of(const BlockMeasurement& measurement, const PointBlockOptions& options) {
  return measurement.sigma > 0 ? measurement.sigma : options.image_sigma;
}

BlockModel build_model(const PointBlock& block, const PointBlockOptions& options, const std::vector<int>& free,
                       State& state) {
  BlockModel model;
  std::vector<bool> is_free(SensorCamera::parameter_count, false);
  for (int i : free) is_free[static_cast<size_t>(i)] = true;
  for (size_t j = 0; j < block.points.size(); ++j) {
    const std::string name = "point " + block.points[j].name;
    model.add_kept(state.points[j].data(), {true, true, true}, {name + " x", name + " y", name + " z"});
  }
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    std::vector<std::string> labels;
    for (const char* name : SensorCamera::names)
      labels.push_back(std::string(name) + " of camera " + std::to_string(block.cameras[c].id));
    model.add_kept(state.interiors[c].data(), is_free, labels);
  }
  for (auto& pose : state.poses) model.add_pose(pose.data());
  const int images = model.add_group("image coordinates"), bars = model.add_group("scale bars");
  for (size_t i = 0; i < block.measurements.size(); ++i) {
    const auto& m = block.measurements[i];
    const size_t image = static_cast<size_t>(m.image), camera = static_cast<size_t>(block.images[image].camera);
    auto* cost = new ImagePointCost{m.position, sigma_of(m, options), block.cameras[camera].balance_radius,
                                    &state.matrices[image]};
    model.add_term(
        std::make_unique<ceres::AutoDiffCostFunction<ImagePointCost, 2, 6, 10, 3>>(cost),
        {state.poses[image].data(), state.interiors[camera].data(), state.points[static_cast<size_t>(m.point)].data()},
        images, static_cast<int>(i));
  }
  for (size_t i = 0; i < block.scale_bars.size(); ++i) {
    const auto& bar = block.scale_bars[i];
    model.add_term(
        std::make_unique<ceres::AutoDiffCostFunction<DistanceCost, 1, 3, 3>>(new DistanceCost{bar.length, bar.sigma}),
        {state.points[static_cast<size_t>(bar.from)].data(), state.points[static_cast<size_t>(bar.to)].data()}, bars,
        static_cast<int>(i));
  }
  return model;
}

std::vector<NamedPoint> named_points(const PointBlock& block, const std::vector<Eigen::Vector3d>& positions) {
  std::vector<NamedPoint> named;
  for (size_t i = 0; i < positions.size(); ++i) named.push_back({"point " + block.points[i].name, positions[i]});
  return named;
}

/// Inner constraints over all object points: translation, rotation, and scale where no scale bar gives it.
void set_inner_constraints(const PointBlock& block, const State& state, PartitionedSystem& linear) {
  const auto points = named_points(block, state.points);
  const Eigen::Index count = block.scale_bars.empty() ? motion_count : motion_count - 1;
  const Eigen::MatrixXd motions = motion_basis(points, centre_of(points));
  linear.null_space = Eigen::MatrixXd::Zero(linear.kept_count, count);
  linear.null_space.topRows(motions.rows()) = motions.leftCols(count);
  linear.datum_unknowns.resize(3 * points.size());
  std::iota(linear.datum_unknowns.begin(), linear.datum_unknowns.end(), 0);  // points come first
}

/// Moves the block so that its points lie, by rotation and translation (and scale without a scale bar), as closely as
/// possible to where they started: the datum that inner constraints against the approximate coordinates define,
/// whatever way the iteration took.
void restore_datum(const PointBlock& block, State& state) {
  std::vector<Eigen::Vector3d> start;
  for (const auto& point : block.points) start.push_back(point.position);
  const SimilarityMotion move = fit_similarity(state.points, start, block.scale_bars.empty());
  for (auto& point : state.points) point = move * point;
  for (size_t i = 0; i < state.poses.size(); ++i) {
    const Eigen::Vector3d centre = move * Eigen::Vector3d(state.poses[i][0], state.poses[i][1], state.poses[i][2]);
    std::copy(centre.data(), centre.data() + 3, state.poses[i].begin());
    state.camera_from_block[i] = (state.camera_from_block[i] * move.rotation.conjugate()).normalized();
    state.matrices[i] = state.camera_from_block[i].toRotationMatrix();
  }
}

/// d(ω, φ, κ)/d(rotation vector in the camera frame), by central differences: exact to 1e-10, and no table of cases.
Eigen::Matrix3d angles_by_turn(const Eigen::Quaterniond& camera_from_block) {
  constexpr double step = 1e-5;
  Eigen::Matrix3d derivative;
  for (int k = 0; k < 3; ++k) {
    Eigen::Vector3d difference = Eigen::Vector3d::Zero();
    for (int sign : {1, -1}) {
      const Eigen::Quaterniond turned =
          quaternion_from_rotation_vector(sign * step * Eigen::Vector3d::Unit(k)) * camera_from_block;
      difference += sign * angles_from_rotation(turned.toRotationMatrix().transpose());
    }
    for (double& d : difference) d -= 2 * M_PI * std::round(d / (2 * M_PI));
    derivative.col(k) = difference / (2 * step);
  }
  return derivative;
}

void fill_reliability(const PointBlock& block, const PointBlockOptions& options, const AdjustedBlock& adjusted,
                      const std::vector<Eigen::MatrixXd>& cofactors, double factor, PointBlockResult& result) {
  result.measurement_reliability.resize(block.measurements.size());
  result.scale_bar_reliability.resize(block.scale_bars.size());
  for (size_t i = 0; i < adjusted.linear.observations.size(); ++i) {
    const ObservationRows& rows = adjusted.linear.observations[i];
    const size_t label = static_cast<size_t>(rows.label);
    const double sigma = rows.group == 0 ? sigma_of(block.measurements[label], options) : block.scale_bars[label].sigma;
    const Eigen::Index count = rows.misclosure.size();
    auto quality = row_quality(sigma * Eigen::MatrixXd::Identity(count, count), rows, cofactors[i]);
    for (auto& q : quality) {
      q.w /= std::sqrt(factor);
      q.mdb *= std::sqrt(factor);
    }
    if (rows.group == 0)
      result.measurement_reliability[label] = {quality[0], quality[1]};
    else
      result.scale_bar_reliability[label] = quality[0];
  }
}

void fill_covariances(const State& state, const AdjustedBlock& adjusted, double factor, PointBlockResult& result) {
  const PartitionedSolution& solution = adjusted.solution;
  const Eigen::Index points = 3 * static_cast<Eigen::Index>(state.points.size());
  const Eigen::Index free = static_cast<Eigen::Index>(result.free_parameters.size());
  result.point_covariance = factor * solution.kept_cofactor.topLeftCorner(points, points);
  for (size_t c = 0; c < state.interiors.size(); ++c) {
    const Eigen::Index first = points + free * static_cast<Eigen::Index>(c);
    result.interior_covariance.push_back(factor * solution.kept_cofactor.block(first, first, free, free));
  }
  for (size_t i = 0; i < state.poses.size(); ++i) {
    const Matrix6 covariance = factor * solution.eliminated_cofactor[i];
    result.pose_covariance.push_back(covariance);
    const Eigen::Matrix3d turn = angles_by_turn(state.camera_from_block[i]);
    result.angle_covariance.push_back(turn * covariance.bottomRightCorner<3, 3>() * turn.transpose());
    const size_t camera = static_cast<size_t>(result.block.images[i].camera);
    const Eigen::Index first = points + free * static_cast<Eigen::Index>(camera);
    const EliminatedBlock& eliminated = adjusted.reduced.eliminated[i];
    Eigen::MatrixXd correlation = factor * cross_cofactor(eliminated, solution.kept_cofactor).middleCols(first, free);
    correlation = covariance.diagonal().cwiseSqrt().cwiseInverse().asDiagonal() * correlation *
                  result.interior_covariance[camera].diagonal().cwiseSqrt().cwiseInverse().asDiagonal();
    result.pose_interior_correlation.push_back(correlation);
  }
}

void store_values(const State& state, PointBlock& block) {
  for (size_t j = 0; j < state.points.size(); ++j) block.points[j].position = state.points[j];
  for (size_t c = 0; c < state.interiors.size(); ++c) block.cameras[c].values = state.interiors[c];
  for (size_t i = 0; i < state.poses.size(); ++i) {
    block.images[i].centre = {state.poses[i][0], state.poses[i][1], state.poses[i][2]};
    block.images[i].angles = angles_from_rotation(state.matrices[i].transpose());
  }
}

}  // namespace

Eigen::Matrix3d rotation_from_angles(const Eigen::Vector3d& angles) {
  return (Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(angles.z(), Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

Eigen::Vector3d angles_from_rotation(const Eigen::Matrix3d& r) {
  return {std::atan2(-r(1, 2), r(2, 2)), std::asin(std::clamp(r(0, 2), -1.0, 1.0)), std::atan2(-r(0, 1), r(0, 0))};
}

PointBlockResult adjust_point_block(const PointBlock& block, const PointBlockOptions& options) {
  require_enough_observations(block);
  PointBlockResult result;
  result.free_parameters = parameter_indices(options.free_parameters);
  result.block = block;
  State state = initial_state(block);
  BlockModel model = build_model(block, options, result.free_parameters, state);
  std::vector<std::string> images;
  for (const auto& image : block.images) images.push_back("image " + std::to_string(image.id));
  const AdjustedBlock adjusted = adjust_to_convergence(
      model, options.max_iterations,
      [&] {
        state.fold();
        restore_datum(block, state);
      },
      [&](PartitionedSystem& linear) { set_inner_constraints(block, state, linear); },
      [&](const PartitionedSystem& linear, const ReducedSystem& reduced) {
        require_full_rank(linear, reduced, images, model.kept_labels());
      });
  const auto cofactors = residual_cofactors(adjusted.linear, adjusted.reduced, adjusted.solution);
  result.groups = variance_components(adjusted.linear, cofactors);
  double sum = 0;
  for (const auto& group : result.groups) sum += group.sum_of_squares;
  result.observations = adjusted.linear.row_count();
  result.unknowns = adjusted.linear.unknown_count();
  result.constraints = adjusted.linear.defect();
  result.degrees_of_freedom = adjusted.linear.redundancy();
  result.iterations = adjusted.iterations;
  if (result.degrees_of_freedom < 1)
    throw std::runtime_error("the block has no redundancy: nothing checks its observations");
  const double factor = sum / result.degrees_of_freedom;
  result.sigma0 = options.image_sigma * std::sqrt(factor);
  result.weighted_sum_of_squares = options.image_sigma * options.image_sigma * sum;
  store_values(state, result.block);
  fill_covariances(state, adjusted, factor, result);
  fill_reliability(block, options, adjusted, cofactors, factor, result);
  return result;
}

}  // namespace plumbline::adjust
