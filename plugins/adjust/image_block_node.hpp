// adjust.image_block: a block of circular targets as a free network with self-calibration.
#pragma once

#include "artifacts/adjusted_image_block.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/points.hpp"
#include "block/point_block.hpp"
#include "geometry/packed_symmetric.hpp"
#include "plumbline/node.hpp"

namespace plumbline::adjust {

namespace detail {

inline PointBlock from_artifact(const ImageBlockT& artifact) {
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
      throw std::runtime_error("camera " + std::to_string(entry->id) + " has " +
                               std::to_string(entry->parameters.size()) +
                               " parameters, expected Ck, xh, yh, A1, A2, A3, B1, B2, C1, C2");
    camera.id = entry->id;
    std::copy(entry->parameters.begin(), entry->parameters.end(), camera.values.begin());
    camera.balance_radius = entry->balance_radius;
    block.cameras.push_back(camera);
  }
  for (const auto& entry : artifact.images)
    block.images.push_back(
        {entry->id, index(entry->camera, block.cameras.size(), "camera"), entry->centre, entry->angles});
  for (const auto& entry : artifact.points) block.points.push_back({entry->id, entry->position});
  for (const auto& m : artifact.measurements)
    block.measurements.push_back({index(m.image(), block.images.size(), "image"),
                                  index(m.point(), block.points.size(), "point"),
                                  {m.x(), m.y()},
                                  m.sigma()});
  for (const auto& bar : artifact.scale_bars)
    block.scale_bars.push_back({bar->name, index(bar->from, block.points.size(), "point"),
                                index(bar->to, block.points.size(), "point"), bar->length, bar->sigma});
  return block;
}

inline std::unique_ptr<AdjustedSensorCameraT> describe_camera(const PointBlockResult& result, size_t c) {
  auto entry = std::make_unique<AdjustedSensorCameraT>();
  const SensorCamera& camera = result.block.cameras[c];
  const Eigen::MatrixXd& covariance = result.interior_covariance[c];
  entry->id = camera.id;
  entry->balance_radius = camera.balance_radius;
  for (int i = 0; i < SensorCamera::parameter_count; ++i) {
    auto parameter = std::make_unique<InteriorParameterT>();
    const auto at = std::find(result.free_parameters.begin(), result.free_parameters.end(), i);
    const Eigen::Index row = at - result.free_parameters.begin();
    parameter->name = SensorCamera::names[static_cast<size_t>(i)];
    parameter->value = camera.values[static_cast<size_t>(i)];
    parameter->estimated = at != result.free_parameters.end();
    parameter->sigma = parameter->estimated ? std::sqrt(covariance(row, row)) : 0;
    entry->interior_orientation.push_back(std::move(parameter));
  }
  for (Eigen::Index r = 0; r < covariance.rows(); ++r)
    for (Eigen::Index k = 0; k <= r; ++k)
      entry->correlations.push_back(covariance(r, k) / std::sqrt(covariance(r, r) * covariance(k, k)));
  return entry;
}

inline void describe_images(const PointBlockResult& result, AdjustedImageBlockT& artifact) {
  for (size_t i = 0; i < result.block.images.size(); ++i) {
    const BlockImage& image = result.block.images[i];
    auto entry = std::make_unique<AdjustedSensorImageT>();
    entry->id = image.id;
    entry->camera = result.block.cameras[static_cast<size_t>(image.camera)].id;
    entry->centre = image.centre;
    entry->centre_sigma = result.pose_covariance[i].diagonal().head<3>().cwiseSqrt();
    entry->angles = image.angles;
    entry->angles_sigma = result.angle_covariance[i].diagonal().cwiseSqrt();
    entry->rms = 0;
    artifact.images.push_back(std::move(entry));
  }
  for (size_t m = 0; m < result.block.measurements.size(); ++m) {
    const BlockMeasurement& measured = result.block.measurements[m];
    const auto& [x, y] = result.measurement_reliability[m];
    auto& image = *artifact.images[static_cast<size_t>(measured.image)];
    ++image.measurements;
    image.rms += x.residual * x.residual + y.residual * y.residual;
    const bool blunder = std::max(std::abs(x.w), std::abs(y.w)) > 3.29;
    if (!blunder && std::min(x.redundancy_number, y.redundancy_number) > 0.1) continue;
    auto finding = std::make_unique<SensorFindingT>();
    finding->image = image.id;
    finding->point = result.block.points[static_cast<size_t>(measured.point)].name;
    finding->residual = {x.residual, y.residual};
    finding->redundancy_number = {x.redundancy_number, y.redundancy_number};
    finding->w = {x.w, y.w};
    finding->kind = blunder ? "blunder" : "unchecked";
    artifact.findings.push_back(std::move(finding));
  }
  for (auto& image : artifact.images) image->rms = std::sqrt(image->rms / std::max(1, 2 * image->measurements));
}

inline AdjustedImageBlockT to_artifact(const PointBlockResult& result, double image_sigma) {
  AdjustedImageBlockT artifact;
  for (size_t c = 0; c < result.block.cameras.size(); ++c) artifact.cameras.push_back(describe_camera(result, c));
  describe_images(result, artifact);
  for (size_t i = 0; i < result.block.scale_bars.size(); ++i) {
    const ScaleBar& bar = result.block.scale_bars[i];
    auto entry = std::make_unique<AdjustedScaleBarT>();
    entry->name = bar.name;
    entry->length = bar.length;
    entry->sigma = bar.sigma;
    entry->residual = result.scale_bar_reliability[i].residual;
    entry->redundancy_number = result.scale_bar_reliability[i].redundancy_number;
    artifact.scale_bars.push_back(std::move(entry));
  }
  for (const auto& group : result.groups) {
    auto entry = std::make_unique<BlockGroupT>();
    entry->name = group.name;
    entry->observations = group.rows;
    entry->weighted_sum_of_squares = group.sum_of_squares;
    entry->redundancy = group.redundancy;
    if (group.redundancy > 1e-6) entry->variance_factor = group.factor;
    artifact.groups.push_back(std::move(entry));
  }
  artifact.statistics = std::make_unique<SensorStatisticsT>();
  artifact.statistics->sigma0 = result.sigma0;
  artifact.statistics->sigma0_a_priori = image_sigma;
  artifact.statistics->degrees_of_freedom = result.degrees_of_freedom;
  artifact.statistics->weighted_sum_of_squares = result.weighted_sum_of_squares;
  artifact.statistics->observations = result.observations;
  artifact.statistics->unknowns = result.unknowns;
  artifact.statistics->datum_defect = result.constraints;
  return artifact;
}

/// The adjusted points with their covariance, which already holds sigma0: of unit weight 1 for whoever reads them.
inline PointsT adjusted_points(const PointBlockResult& result) {
  PointsT points;
  for (size_t j = 0; j < result.block.points.size(); ++j) {
    auto entry = std::make_unique<PointT>();
    entry->id = result.block.points[j].name;
    entry->position = result.block.points[j].position;
    entry->sigma = result.point_covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(j)).cwiseSqrt();
    points.points.push_back(std::move(entry));
  }
  points.covariance = pack_symmetric(result.point_covariance);
  return points;
}

}  // namespace detail

struct AdjustImageBlock : Node {
  static constexpr Info info{"adjust.image_block", "", 1,
                             "Adjusts a block of circular targets as a free network with self-calibration"};
  In<ImageBlock> block{"block", frame("frame=?F"),
                       "measurements with approximate values, whose coordinates are the datum"};
  Param<double> image_sigma{"image_sigma", 0.0005, "mm", between(1e-7, 1),
                            "a priori standard deviation of a sensor coordinate"};
  Param<std::vector<std::string>> free{
      "free", {"Ck", "xh", "yh", "A1", "A2", "B1", "B2"}, "interior parameters to estimate"};
  Param<int64_t> max_iterations{"max_iterations", 100, between(1, 10000), "of the damped iteration"};
  Out<AdjustedImageBlock> adjusted{"block", frame("frame=?F"), "coordinates, orientations, statistics"};
  Out<Points> points{"points", frame("frame=?F"), "the targets with their full covariance"};

  void run(Context& context) override {
    const ImageBlockT given = block.unpack();
    PointBlockOptions options;
    options.image_sigma = *image_sigma;
    options.free_parameters = *free;
    options.max_iterations = static_cast<int>(*max_iterations);
    const PointBlockResult result = adjust_point_block(detail::from_artifact(given), options);
    PointsT list = detail::adjusted_points(result);
    AdjustedImageBlockT artifact = detail::to_artifact(result, *image_sigma);
    artifact.left_out = given.left_out;
    for (const auto& point : list.points) artifact.points.push_back(std::make_unique<PointT>(*point));
    context.metric("sigma0", result.sigma0, "mm");
    context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
    adjusted.commit(artifact);
    points.commit(list);
  }
};

}  // namespace plumbline::adjust
