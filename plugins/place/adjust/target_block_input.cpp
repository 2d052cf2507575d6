// The block of an artifact as the adjustment has it, and back: before it is adjusted.
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"
#include "plumbline/stop.hpp"
#include "target_block_artifacts.hpp"

namespace plumbline::block {
namespace {

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

}  // namespace plumbline::block
