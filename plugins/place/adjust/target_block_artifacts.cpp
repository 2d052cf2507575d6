#include "target_block_artifacts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

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

void read_control(const ImageBlockT& artifact, PointBlock& block) {
  std::map<std::string, int> index;
  for (size_t j = 0; j < block.points.size(); ++j) index.emplace(block.points[j].name, static_cast<int>(j));
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(artifact.control.size());
  block.control.position.resize(size);
  block.control.covariance =
      unpack_symmetric(artifact.control_covariance, static_cast<size_t>(size), "the control points");
  const bool by_sigma = block.control.covariance.size() == 0;
  if (by_sigma) block.control.covariance = Eigen::MatrixXd::Zero(size, size);
  for (size_t k = 0; k < artifact.control.size(); ++k) {
    const PointT& point = *artifact.control[k];
    const auto at = index.find(point.id);
    if (at == index.end()) throw std::runtime_error("control point " + point.id + " is no point of the block");
    if (!point.position.allFinite() || !point.sigma.allFinite())
      throw std::runtime_error("control point " + point.id +
                               " has a coordinate or standard deviation that is not a number");
    block.control.points.push_back(at->second);
    block.control.is_check.push_back(point.role == "check");
    block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)) = point.position;
    if (by_sigma)
      block.control.covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)) = point.sigma.cwiseAbs2();
  }
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
    entry->use = control.check ? "check" : control.fixed ? "fixed" : "weighted";
    entry->given = control.given;
    entry->given_sigma = control.given_sigma;
    entry->residual = control.residual;
    entry->sigma = result.point_covariances[control.point].diagonal().cwiseSqrt();
    entry->w = control.w;
    entry->redundancy_number = control.redundancy_number;
    entry->rays = control.rays;
    squares[control.check] += control.residual.squaredNorm();
    ++count[control.check];
    targets.control.push_back(std::move(entry));
  }
  if (count[0] > 0) targets.control_rms = std::sqrt(squares[0] / count[0]);
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

PointBlock target_block_of(const ImageBlockT& artifact) {
  PointBlock block;
  const auto index = [](int value, size_t size, const char* what) {
    if (value < 0 || static_cast<size_t>(value) >= size)
      throw std::runtime_error(std::string("the block refers to ") + what + " " + std::to_string(value) + " of " +
                               std::to_string(size));
    return value;
  };
  for (const auto& entry : artifact.cameras) {
    SensorCamera camera;
    if (entry->parameters.size() != camera.values.size())
      throw std::runtime_error(
          "camera " + std::to_string(entry->id) + " has " + std::to_string(entry->parameters.size()) +
          " parameters, expected 10: Ck, xh, yh, A1, A2, A3, B1, B2, C1, C2, or c, xp, yp, K1, K2, K3, P1, P2, b1, b2");
    camera.id = entry->id;
    if (!entry->model.empty() && entry->model != "balanced" && entry->model != "correcting")
      throw std::runtime_error("camera " + std::to_string(entry->id) + " has the model '" + entry->model +
                               "'; known are balanced and correcting");
    camera.lens = entry->model == "correcting" ? bundle::Lens::correcting : bundle::Lens::balanced;
    camera.sensor_width = entry->sensor_width;
    camera.sensor_height = entry->sensor_height;
    camera.width = entry->width;
    camera.height = entry->height;
    std::copy(entry->parameters.begin(), entry->parameters.end(), camera.values.begin());
    camera.balance_radius = entry->balance_radius;
    camera.estimated = entry->estimated;
    block.cameras.push_back(camera);
  }
  for (const auto& entry : artifact.images)
    block.images.push_back(
        {entry->id, index(entry->camera, block.cameras.size(), "camera"), entry->centre, entry->angles});
  for (const auto& entry : artifact.points) block.points.push_back({entry->id, entry->position});
  for (const auto& m : artifact.measurements)
    stop_point(), block.measurements.push_back({index(m.image(), block.images.size(), "image"),
                                                index(m.point(), block.points.size(), "point"),
                                                {m.x(), m.y()},
                                                m.sigma()});
  for (const auto& bar : artifact.scale_bars)
    block.scale_bars.push_back({bar->name, index(bar->from, block.points.size(), "point"),
                                index(bar->to, block.points.size(), "point"), bar->length, bar->sigma});
  if (!artifact.control.empty()) read_control(artifact, block);
  return block;
}

ImageBlockT target_block_artifact(const ReadBlock& read) {
  ImageBlockT artifact;
  for (const auto& camera : read.block.cameras) {
    auto entry = std::make_unique<SensorCameraT>();
    entry->id = camera.id;
    entry->parameters.assign(camera.values.begin(), camera.values.end());
    entry->model = camera.lens == bundle::Lens::correcting ? "correcting" : "balanced";
    entry->balance_radius = camera.balance_radius;
    entry->sensor_width = camera.sensor_width;
    entry->sensor_height = camera.sensor_height;
    entry->width = camera.width;
    entry->height = camera.height;
    entry->estimated = camera.estimated;
    artifact.cameras.push_back(std::move(entry));
  }
  for (const auto& image : read.block.images) {
    auto entry = std::make_unique<SensorImageT>();
    entry->id = image.id;
    entry->camera = image.camera;
    entry->centre = image.centre;
    entry->angles = image.angles;
    artifact.images.push_back(std::move(entry));
  }
  for (const auto& point : read.block.points) {
    auto entry = std::make_unique<PointT>();
    entry->id = point.name;
    entry->position = point.position;
    entry->sigma.setConstant(std::nan(""));
    artifact.points.push_back(std::move(entry));
  }
  for (const auto& m : read.block.measurements)
    stop_point(), artifact.measurements.emplace_back(m.image, m.point, m.position.x(), m.position.y(), m.sigma);
  for (const auto& bar : read.block.scale_bars) {
    auto entry = std::make_unique<ScaleBarT>();
    entry->name = bar.name;
    entry->from = bar.from;
    entry->to = bar.to;
    entry->length = bar.length;
    entry->sigma = bar.sigma;
    artifact.scale_bars.push_back(std::move(entry));
  }
  const BlockControl& control = read.block.control;
  for (size_t k = 0; k < control.points.size(); ++k) {
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(k);
    auto entry = std::make_unique<PointT>();
    entry->id = read.block.points[control.points[k]].name;
    entry->position = control.position.segment<3>(at);
    entry->sigma = control.covariance.diagonal().segment<3>(at).cwiseSqrt();
    entry->role = control.is_check[k] ? "check" : "control";
    artifact.control.push_back(std::move(entry));
  }
  Eigen::MatrixXd beside = control.covariance;
  for (Eigen::Index i = 0; i < beside.rows(); ++i) beside(i, i) = 0;
  if (beside.size() > 0 && !beside.isZero(0)) artifact.control_covariance = pack_symmetric(control.covariance);
  artifact.measurements_read = read.measurements_read;
  artifact.left_out = read.left_out;
  return artifact;
}

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
  artifact.image_variance_factor = 1;
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
  for (const std::string& words :
       {control_against_images(result), blunders_in_words(result), turned_images(given, result)})
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
