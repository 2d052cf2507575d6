#include "target_block_artifacts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "geometry/packed_symmetric.hpp"
#include "photo/block/point_block_words.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::block {
namespace {

constexpr size_t max_findings = 1000;

/// 0 for what is held.
std::vector<double> correlations_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale =
      covariance.diagonal().unaryExpr([](double variance) { return variance > 0 ? 1 / std::sqrt(variance) : 0; });
  return pack_symmetric(Eigen::MatrixXd(scale.asDiagonal() * covariance * scale.asDiagonal()));
}

std::unique_ptr<AdjustedSensorCameraT> describe_camera(const PointBlockResult& result, size_t c) {
  auto entry = std::make_unique<AdjustedSensorCameraT>();
  const SensorCamera& camera = result.block.cameras[c];
  const Eigen::MatrixXd& covariance = result.interior_covariance[c];
  entry->id = camera.id;
  entry->model = camera.lens == bundle::Lens::correcting ? "correcting" : "balanced";
  entry->balance_radius = camera.balance_radius;
  const auto& free = result.free_parameters[c];
  for (int i = 0; i < static_cast<int>(camera.names().size()); ++i) {
    const auto at = std::find(free.begin(), free.end(), i);
    const bool by_distance = camera.names()[i][0] == 'D';  // where nobody asked: none
    if (by_distance && at == free.end() && camera.values[i] == 0) continue;
    auto parameter = std::make_unique<InteriorParameterT>();
    const Eigen::Index row = at - free.begin();
    parameter->name = camera.names()[i];
    parameter->value = camera.values[i];
    parameter->estimated = at != free.end();
    parameter->sigma = parameter->estimated ? std::sqrt(covariance(row, row)) : 0;
    entry->interior_orientation.push_back(std::move(parameter));
  }
  for (size_t i = 0; i < result.principal_points.size(); ++i)
    for (int axis = 0; axis < 2 && result.block.images[i].camera == static_cast<int>(c); ++axis) {
      auto parameter = std::make_unique<InteriorParameterT>();
      parameter->name = axis == 0 ? "x0" : "y0";
      parameter->image = std::to_string(result.block.images[i].id);
      parameter->value = result.principal_points[i](axis);
      parameter->sigma = std::sqrt(result.principal_point_covariance[i](axis, axis));
      parameter->estimated = true;
      entry->interior_orientation.push_back(std::move(parameter));
    }
  entry->correlations = correlations_of(covariance);
  return entry;
}

void describe_images(const PointBlockResult& result, TargetBlockT& targets) {
  for (size_t i = 0; i < result.block.images.size(); ++i) {
    const BlockImage& image = result.block.images[i];
    auto entry = std::make_unique<AdjustedSensorImageT>();
    entry->id = image.id;
    entry->camera = result.block.cameras[image.camera].id;
    entry->centre = image.centre;
    entry->angles = image.angles;
    const Eigen::Matrix<double, 6, 1> sigma = result.orientation_covariance[i].diagonal().cwiseSqrt();
    entry->centre_sigma = sigma.head<3>();
    entry->angles_sigma = sigma.tail<3>();
    entry->correlations = correlations_of(result.orientation_covariance[i]);
    const Eigen::MatrixXd& with_interior = result.pose_interior_correlation[i];
    entry->largest_interior_correlation =
        with_interior.size() > 0 ? with_interior.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() : 0;
    entry->rms = 0;
    targets.images.push_back(std::move(entry));
  }
}

void describe_measurements(const PointBlockResult& result, TargetBlockT& targets) {
  std::vector<std::pair<double, size_t>> conspicuous;
  double squares = 0;
  for (size_t m = 0; m < result.block.measurements.size(); ++m) {
    stop_point();
    const auto& [x, y] = result.measurement_reliability[m];
    auto& image = *targets.images[result.block.measurements[m].image];
    ++image.measurements;
    image.rms += x.residual * x.residual + y.residual * y.residual;
    squares += x.residual * x.residual + y.residual * y.residual;
    const double w = std::max(std::abs(x.w), std::abs(y.w));
    if (w > 3.29 || std::min(x.redundancy_number, y.redundancy_number) < 0.1) conspicuous.emplace_back(-w, m);
  }
  for (auto& image : targets.images) image->rms = std::sqrt(image->rms / std::max(1, 2 * image->measurements));
  targets.image_rms =
      std::sqrt(squares / std::max<double>(1.0, 2.0 * static_cast<double>(result.block.measurements.size())));
  targets.finding_count = static_cast<int>(conspicuous.size());
  std::sort(conspicuous.begin(), conspicuous.end());
  conspicuous.resize(std::min(conspicuous.size(), max_findings));
  for (const auto& [minus_w, m] : conspicuous) {
    const BlockMeasurement& measured = result.block.measurements[m];
    const auto& [x, y] = result.measurement_reliability[m];
    auto finding = std::make_unique<SensorFindingT>();
    finding->image = result.block.images[measured.image].id;
    finding->point = result.block.points[measured.point].name;
    finding->residual = {x.residual, y.residual};
    finding->redundancy_number = {x.redundancy_number, y.redundancy_number};
    finding->w = {x.w, y.w};
    finding->kind = -minus_w > 3.29 ? "blunder" : "unchecked";
    targets.findings.push_back(std::move(finding));
  }
}

void describe_points(const PointBlockResult& result, TargetBlockT& targets) {
  for (size_t j = 0; j < result.block.points.size(); ++j) {
    stop_point();
    auto entry = std::make_unique<AdjustedPointT>();
    const Eigen::Matrix3d& c = result.point_covariances[j];
    entry->id = result.block.points[j].name;
    entry->position = result.block.points[j].position;
    entry->sigma = c.diagonal().cwiseSqrt();
    entry->covariance = {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)};
    entry->rays = result.rays[j];
    targets.points.push_back(std::move(entry));
  }
}

void describe_control(const PointBlockResult& result, TargetBlockT& targets) {
  double squares[2] = {0, 0};
  int count[2] = {0, 0};
  for (const ControlResult& control : result.control) {
    auto entry = std::make_unique<AdjustedControlT>();
    entry->id = result.block.points[control.point].name;
    entry->use = control.check ? "check" : control.aside ? "set aside" : control.fixed ? "fixed" : "weighted";
    entry->given = control.given;
    entry->given_sigma = control.given_sigma;
    entry->residual = control.residual;
    entry->sigma = result.point_covariances[control.point].diagonal().cwiseSqrt();
    entry->w = control.w;
    entry->redundancy_number = control.redundancy_number;
    entry->rays = control.rays;
    targets.control.push_back(std::move(entry));
    if (control.aside) continue;
    squares[control.check] += control.residual.squaredNorm();
    ++count[control.check];
  }
  if (count[0] > 0) targets.control_rms = std::sqrt(squares[0] / count[0]);
  targets.check_covariance = pack_symmetric(result.check_covariance);
  if (count[1] > 0) targets.check_rms = std::sqrt(squares[1] / count[1]);
}

void describe_scale_bars(const PointBlockResult& result, TargetBlockT& targets) {
  for (size_t i = 0; i < result.block.scale_bars.size(); ++i) {
    const ScaleBar& bar = result.block.scale_bars[i];
    auto entry = std::make_unique<AdjustedScaleBarT>();
    entry->name = bar.name;
    entry->length = bar.length;
    entry->sigma = bar.sigma;
    entry->residual = result.scale_bar_reliability[i].residual;
    entry->redundancy_number = result.scale_bar_reliability[i].redundancy_number;
    targets.scale_bars.push_back(std::move(entry));
  }
}

}  // namespace

/// Programs know the standard deviation of their image coordinates to a factor of some five at best.
constexpr double worst_misfit = 5;

double image_sigma_of(const PointBlock& block) {
  for (const auto& m : block.measurements)
    if (m.sigma > 0) return m.sigma;
  return 0.0005;
}

BlockT describe_targets(const PointBlock& given, const PointBlockResult& result, const PointBlockOptions& options) {
  BlockT artifact;
  const bool free = result.constraints > 0;
  artifact.datum = !free                                                             ? "control"
                   : options.free_datum == PointBlockOptions::FreeDatum::first_image ? "first image"
                                                                                     : "free";
  artifact.weighting = "covariance";
  artifact.image_variance_factor = result.image_variance_factor;
  artifact.targets = std::make_unique<TargetBlockT>();
  TargetBlockT& targets = *artifact.targets;
  targets.image_sigma_a_priori = options.image_sigma;
  targets.image_sigma = result.sigma0;
  const SensorCamera& camera = result.block.cameras.at(0);
  if (camera.width > 0 && camera.sensor_width > 0)
    targets.image_sigma_px = result.sigma0 * camera.width / camera.sensor_width;
  for (size_t c = 0; c < result.block.cameras.size(); ++c) targets.cameras.push_back(describe_camera(result, c));
  describe_images(result, targets);
  describe_measurements(result, targets);
  describe_points(result, targets);
  describe_control(result, targets);
  describe_scale_bars(result, targets);
  for (const auto& group : result.groups) {
    auto entry = std::make_unique<BlockGroupT>();
    entry->name = group.name;
    entry->observations = group.rows;
    entry->weighted_sum_of_squares = group.sum_of_squares;
    entry->redundancy = group.redundancy;
    if (group.redundancy > 1e-6) entry->variance_factor = group.factor;
    artifact.groups.push_back(std::move(entry));
  }
  artifact.statistics = std::make_unique<StatisticsT>();
  artifact.statistics->sigma0 = result.sigma0 / options.image_sigma;
  artifact.statistics->degrees_of_freedom = result.degrees_of_freedom;
  artifact.statistics->weighted_sum_of_squares =
      result.weighted_sum_of_squares / (options.image_sigma * options.image_sigma);
  artifact.statistics->observations = result.observations;
  artifact.statistics->unknowns = result.unknowns;
  artifact.statistics->datum_defect = result.constraints;
  if (result.sigma0 > worst_misfit * options.image_sigma) {
    artifact.warnings.push_back(fmt::format(
        "the images contradict what they are adjusted with: image coordinates fit {:.0f} times worse than their "
        "standard deviation ({:.3g} mm{}). The camera is not calibrated{}, points are mixed up, or control is wrong; "
        "no coordinate here is to be trusted",
        result.sigma0 / options.image_sigma, result.sigma0,
        std::isfinite(targets.image_sigma_px) && targets.image_sigma_px > 0
            ? (", " + std::to_string(targets.image_sigma_px).substr(0, 5) + " px").c_str()
            : "",  // Cameras of other models are estimated unless somebody said otherwise.
        camera.lens == bundle::Lens::correcting ? " (block.with.free=[c, xp, yp, K1, K2] estimates it)" : ""));
  }
  if (options.by_gradients)
    artifact.warnings.emplace_back(
        "solver=gradients: the normal equations were not factorised. There are no standard deviations, redundancy "
        "numbers or tests for blunders, and it was not looked whether the observations determine all unknowns together "
        "(only each image, camera and point by itself)");
  for (const std::string& words : {control_against_images(result), scale_bars_against_images(result),
                                   blunders_in_words(result), turned_images(given, result)})
    if (!words.empty()) artifact.warnings.push_back(words);
  return artifact;
}

PointsT target_points(const PointBlockResult& result) {
  PointsT points;
  for (size_t j = 0; j < result.block.points.size(); ++j) {
    auto entry = std::make_unique<PointT>();
    entry->id = result.block.points[j].name;
    entry->position = result.block.points[j].position;
    entry->sigma = result.point_covariances[j].diagonal().cwiseSqrt();
    points.points.push_back(std::move(entry));
  }
  points.covariance = pack_symmetric(result.point_covariance);
  return points;
}

PosesT target_poses(const PointBlockResult& result) {
  PosesT poses;
  // Camera frame of Poses: y down, z forward; the sensor's: y up, the scene at negative z. Half a turn about x.
  const Eigen::Quaterniond half_turn(0, 1, 0, 0);
  const Eigen::Matrix3d turned = half_turn.toRotationMatrix();
  for (size_t i = 0; i < result.block.images.size(); ++i) {
    const BlockImage& image = result.block.images[i];
    auto entry = std::make_unique<PoseT>();
    entry->path = std::to_string(image.id);
    const Eigen::Quaterniond rotation =
        (half_turn * Eigen::Quaterniond(rotation_from_angles(image.angles).transpose())).normalized();
    entry->cam_from_world = {rotation, -(rotation * image.centre)};
    Matrix6 jacobian = Matrix6::Zero();
    jacobian.topRightCorner<3, 3>() = turned;
    jacobian.bottomLeftCorner<3, 3>() = -rotation.toRotationMatrix();
    jacobian.bottomRightCorner<3, 3>() = -skew(entry->cam_from_world.translation) * turned;
    if (result.pose_covariance[i].allFinite())
      entry->covariance = pack_symmetric(Matrix6(jacobian * result.pose_covariance[i] * jacobian.transpose()));
    poses.poses.push_back(std::move(entry));
  }
  std::vector<double> squares(poses.poses.size());
  for (size_t m = 0; m < result.block.measurements.size(); ++m) {
    const size_t image = static_cast<size_t>(result.block.measurements[m].image);
    const SensorCamera& camera = result.block.cameras[result.block.images[image].camera];
    const double px = camera.width > 0 ? camera.width / camera.sensor_width : std::nan("");
    for (const auto& row : result.measurement_reliability[m]) squares[image] += std::pow(row.residual * px, 2);
    ++poses.poses[image]->correspondences;
  }
  for (size_t i = 0; i < squares.size(); ++i) {
    poses.poses[i]->inliers = poses.poses[i]->correspondences;
    poses.poses[i]->rms = std::sqrt(squares[i] / std::max(1, 2 * poses.poses[i]->correspondences));
  }
  return poses;
}

CameraT target_camera(const PointBlockResult& result) {
  CameraT camera;
  const SensorCamera& first = result.block.cameras.at(0);
  camera.id = std::to_string(first.id);
  camera.width = first.width;
  camera.height = first.height;
  if (first.width > 0) camera.pixel_pitch = 1e-3 * first.sensor_width / first.width;
  camera.source = "image block: parameters of another model, see Block.targets";
  return camera;
}

}  // namespace plumbline::block
