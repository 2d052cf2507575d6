#include "tag_block_artifacts.hpp"

#include <fmt/core.h>

#include <cmath>
#include <set>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"
#include "photo/block/tag_block_model.hpp"

namespace plumbline::block {
namespace {

bool is_check(const std::string& role) { return role == "check"; }

/// The larger or the smaller of two, and nan if either is not known.
double larger(double a, double b) { return std::isnan(b) ? b : std::max(a, b); }
double smaller(double a, double b) { return std::isnan(b) ? b : std::min(a, b); }

}  // namespace

TagBlockBuilder::TagBlockBuilder(CameraT camera, PlatesT plates, PosesT poses)
    : cameras_(cameras_of(std::move(camera))), plates_(std::move(plates)), poses_(std::move(poses)) {
  block_.cameras.resize(cameras_.size());
  for (size_t c = 0; c < cameras_.size(); ++c) {
    lenses_.push_back(complete_camera_of(cameras_[c]));
    TagCamera& given = block_.cameras[c];
    if (cameras_.size() > 1) given.name = cameras_[c].id;
    given.interior = lenses_[c].nine;
    given.distance_terms = lenses_[c].distance_terms;
    given.reference_distance = lenses_[c].reference_distance;
  }
  for (const auto& plate : plates_.plates) {
    const auto [at, is_new] =
        plate_of_tag_.emplace(std::make_pair(plate->tag_family, plate->tag_id), static_cast<int>(block_.plates.size()));
    if (!is_new)
      throw std::runtime_error("tag " + plate->tag_family + ":" + std::to_string(plate->tag_id) + " stands for both " +
                               block_.plates[at->second].anchor + " and " + plate->anchor);
    block_.plates.push_back(
        {plate->anchor, {plate->tag_size, plate->tag_centre_in_plate}, plate->nominal_rotation, plate->batch});
  }
  for (const auto& pose : poses_.poses) pose_of_image_[pose->path] = pose.get();
}

void TagBlockBuilder::set_prior(bool use_prior) {
  constexpr int count = BrownCamera::parameter_count;
  if (!use_prior) return;
  for (size_t c = 0; c < cameras_.size(); ++c) {
    Eigen::MatrixXd& prior = block_.cameras[c].covariance;
    prior = interior_covariance_of(cameras_[c]);
    if (prior.size() == 0) prior = Eigen::MatrixXd::Zero(count, count);
  }
}

int TagBlockBuilder::camera_of_image(const ImageTagsT& image) const {
  if (cameras_.size() == 1) return 0;
  std::string names;
  for (size_t c = 0; c < cameras_.size(); ++c) {
    if (cameras_[c].id == image.camera) return static_cast<int>(c);
    names += (c == 0 ? "'" : ", '") + cameras_[c].id + "'";
  }
  throw std::runtime_error("image " + image.path + " is of camera '" + image.camera + "', expected one of " + names);
}

void TagBlockBuilder::add_image(const ImageTagsT& image, double corner_sigma) {
  const int index = static_cast<int>(block_.images.size());
  const auto pose = pose_of_image_.find(image.path);
  TagImage entry;
  entry.name = image.path;
  entry.camera = camera_of_image(image);
  entry.inset_sigma = std::isnan(image.corner_inset_sigma) ? 0 : image.corner_inset_sigma;
  if (pose != pose_of_image_.end()) {
    entry.cam_from_world = pose->second->cam_from_world;
    entry.principal_point = principal_point_of(lenses_[entry.camera], *pose->second);
  }
  block_.images.push_back(std::move(entry));
  std::map<int, int> times;
  for (const auto& tag : image.tags) {
    const auto plate = plate_of_tag_.find({tag->family, tag->id});
    if (plate != plate_of_tag_.end()) ++times[plate->second];
  }
  for (const auto& [plate, count] : times)
    if (count > 1)
      warnings_.push_back("the tag of " + block_.plates[plate].anchor + " occurs " + std::to_string(count) +
                          " times in " + image.path + ": left out there, because only one can be it");
  for (const auto& tag : image.tags) {
    const auto plate = plate_of_tag_.find({tag->family, tag->id});
    if (plate == plate_of_tag_.end() || times[plate->second] > 1) continue;
    if (tag->corners.size() != 4)
      throw std::runtime_error("a tag of " + image.path + " has " + std::to_string(tag->corners.size()) +
                               " corners, expected 4");
    for (const auto& corner : tag->corners)
      if (!corner.allFinite())
        throw std::runtime_error("tag " + tag->family + ":" + std::to_string(tag->id) + " in " + image.path +
                                 " has a corner that is not a number");
    TagObservation seen;
    seen.image = index;
    seen.plate = plate->second;
    for (size_t k = 0; k < 4; ++k) {
      seen.corners[k] = tag->corners[k];
      seen.covariances[k] = corner_sigma * corner_sigma * Eigen::Matrix2d::Identity();
      if (tag->corner_covariances.size() != 12) continue;
      const double* c = &tag->corner_covariances[3 * k];
      // What is not positive definite cannot weight anything; the detector's other corners keep theirs.
      if (c[0] > 0 && c[0] * c[2] - c[1] * c[1] > 0) seen.covariances[k] << c[0], c[1], c[1], c[2];
    }
    block_.observations.push_back(seen);
  }
}

void TagBlockBuilder::set_control(const PointsT& points) {
  set_fitted(points);
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(points.points.size());
  Eigen::MatrixXd covariance = unpack_symmetric(points.covariance, static_cast<size_t>(size), "the control points");
  if (covariance.size() == 0) {
    covariance = Eigen::MatrixXd::Zero(size, size);
    for (size_t i = 0; i < points.points.size(); ++i)
      covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(i)) = points.points[i]->sigma.cwiseAbs2();
  }
  std::map<std::string, int> plate_of_anchor;
  for (size_t j = 0; j < plates_.plates.size(); ++j)
    if (!is_check(plates_.plates[j]->role)) plate_of_anchor[plates_.plates[j]->anchor] = static_cast<int>(j);
  std::vector<int> rows;
  std::vector<double> positions;
  for (size_t i = 0; i < points.points.size(); ++i) {
    const PointT& point = *points.points[i];
    const auto plate = plate_of_anchor.find(point.id);
    if (plate == plate_of_anchor.end() || is_check(point.role)) continue;
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(i);
    if (!point.position.allFinite() || !covariance.diagonal().segment<3>(at).allFinite()) {
      warnings_.push_back("control point " + point.id +
                          " has no coordinates or no standard deviation in x, y or z: not used as control");
      continue;
    }
    block_.control.plates.push_back(plate->second);
    for (int c = 0; c < 3; ++c) {
      rows.push_back(static_cast<int>(at) + c);
      positions.push_back(point.position(c));
    }
  }
  block_.control.position =
      Eigen::Map<const Eigen::VectorXd>(positions.data(), static_cast<Eigen::Index>(positions.size()));
  block_.control.covariance = regular_covariance(covariance(rows, rows));
}

std::unique_ptr<StatisticsT> TagBlockBuilder::statistics(const TagBlockResult& result) const {
  auto s = std::make_unique<StatisticsT>();
  s->sigma0 = result.sigma0;
  s->degrees_of_freedom = result.degrees_of_freedom;
  s->weighted_sum_of_squares = result.weighted_sum_of_squares;
  s->observations = result.observations;
  s->unknowns = result.unknowns;
  s->datum_defect = result.datum_defect;
  return s;
}

PointsT TagBlockBuilder::points(const TagBlockResult& result) const {
  PointsT points;
  for (size_t j = 0; j < result.plates.size(); ++j) {
    const PlateT& plate = *plates_.plates[result.plates[j]];
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(j);
    auto entry = std::make_unique<PointT>();
    entry->id = plate.anchor;
    entry->position = result.anchors.segment<3>(at);
    entry->sigma.setConstant(std::nan(""));
    if (result.anchor_covariance.size() > 0)
      entry->sigma = result.anchor_covariance.diagonal().segment<3>(at).cwiseSqrt();
    entry->role = plate.role;
    points.points.push_back(std::move(entry));
  }
  if (result.anchor_covariance.size() > 0) points.covariance = pack_symmetric(result.anchor_covariance);
  points.statistics = statistics(result);
  take_datum(datum_, points);
  return points;
}

CameraT TagBlockBuilder::adjusted_camera(const TagBlockResult& result, size_t index) const {
  CameraT adjusted = cameras_[index];
  const AdjustedTagCamera& found = result.cameras[index];
  adjusted.beyond.clear();
  adjusted.distance_terms.clear();
  adjusted.reference_distance = std::nan("");
  const bool estimated = found.covariance.diagonal().maxCoeff() > 0;
  set_interior(found.interior, estimated ? found.covariance : Eigen::MatrixXd(), adjusted);
  if (estimated) adjusted.source = "self-calibration";
  if (!found.distance_terms.isZero(0)) {
    adjusted.beyond = "distance-dependent distortion (d1, d2)";
    adjusted.distance_terms = {found.distance_terms.x(), found.distance_terms.y()};
    adjusted.reference_distance = found.reference_distance;
  }
  adjusted.image_principal_points = !result.principal_points.empty();
  if (!result.principal_points.empty())
    adjusted.beyond += std::string(adjusted.beyond.empty() ? "" : " and ") + "principal points of single images";
  return adjusted;
}

CameraT TagBlockBuilder::camera(const TagBlockResult& result) const {
  std::vector<CameraT> adjusted;
  for (size_t c = 0; c < cameras_.size(); ++c) adjusted.push_back(adjusted_camera(result, c));
  return joined_cameras(adjusted);
}

PosesT TagBlockBuilder::poses(const TagBlockResult& result) const {
  PosesT poses;
  if (!result.pose_covariance.empty()) {
    poses.calibration = CalibrationErrors::carried;
    for (size_t c = 0; c < cameras_.size(); ++c)  // a held one has none
      if (adjusted_camera(result, c).covariance.empty()) poses.calibration = CalibrationErrors::taken_as_exact;
  }
  std::vector<double> squares(block_.images.size());
  std::vector<int> corners(block_.images.size()), offered(block_.images.size());
  for (const auto& seen : block_.observations) offered[seen.image] += 4;
  for (const auto& tag : result.tags) {
    const size_t image = static_cast<size_t>(block_.observations[tag.observation].image);
    squares[image] += 8 * tag.rms * tag.rms;
    corners[image] += 4;
  }
  for (size_t i = 0; i < block_.images.size(); ++i) {
    if (!result.cam_from_world[i]) continue;
    auto entry = std::make_unique<PoseT>();
    entry->path = block_.images[i].name;
    entry->cam_from_world = *result.cam_from_world[i];
    if (!result.principal_points.empty())
      entry->principal_point = {result.principal_points[i].shift.x(), result.principal_points[i].shift.y()};
    if (!result.pose_covariance.empty()) entry->covariance = pack_symmetric(result.pose_covariance[i]);
    entry->inliers = corners[i];
    entry->correspondences = offered[i];
    entry->rms = std::sqrt(squares[i] / std::max(1, 2 * corners[i]));
    poses.poses.push_back(std::move(entry));
  }
  if (result.orientation_covariance.size() > 0) {
    poses.joint_covariance = pack_symmetric(result.orientation_covariance);
    for (const CameraT& camera : cameras_) poses.cameras.push_back(camera.id);
  }
  return poses;
}

void TagBlockBuilder::describe_images(const TagBlockResult& result, BlockT& artifact) const {
  std::map<int, BlockImageT> images;
  for (const auto& tag : result.tags) {
    BlockImageT& image = images[block_.observations[tag.observation].image];
    if (image.tags == 0)
      image.largest_w = image.rms = image.largest_minimal_detectable_error = 0, image.smallest_redundancy_number = 1;
    ++image.tags;
    image.rms += tag.rms * tag.rms;
    image.largest_w = larger(image.largest_w, tag.largest_normalised);
    image.smallest_redundancy_number = smaller(image.smallest_redundancy_number, tag.smallest_redundancy);
    image.largest_minimal_detectable_error =
        larger(image.largest_minimal_detectable_error, tag.largest_detectable_error);
  }
  for (auto& [index, image] : images) {
    image.path = block_.images[index].name;
    image.rms = std::sqrt(image.rms / image.tags);
    artifact.images.push_back(std::make_unique<BlockImageT>(image));
  }
}

void TagBlockBuilder::describe_interior(const TagBlockResult& result, BlockT& artifact) const {
  constexpr int all = BrownCamera::parameter_count + 2;
  std::vector<int> estimated;
  const auto add = [&](const std::string& name, double value, double sigma) -> InteriorParameterT& {
    auto parameter = std::make_unique<InteriorParameterT>();
    parameter->name = name;
    parameter->value = value;
    parameter->sigma = sigma;
    parameter->estimated = sigma > 0;
    artifact.interior_orientation.push_back(std::move(parameter));
    return *artifact.interior_orientation.back();
  };
  for (int c = 0; c < static_cast<int>(result.cameras.size()); ++c) {
    const AdjustedTagCamera& camera = result.cameras[c];
    const std::string of = result.cameras.size() > 1 ? cameras_[c].id : "";
    const auto values = camera.interior.parameters();
    const auto names = camera.interior.names();
    for (int i = 0; i < std::ssize(names); ++i) {
      const size_t at = static_cast<size_t>(i);
      add(names[at], values[at], std::sqrt(camera.covariance(i, i))).camera = of;
      if (camera.covariance(i, i) > 0) estimated.push_back(all * c + i);
    }
    for (int k = 0; k < 2 && camera.reference_distance > 0; ++k) {
      const int i = all * c + BrownCamera::parameter_count + k;
      add(k == 0 ? "d1" : "d2", camera.distance_terms(k), std::sqrt(result.interior_covariance(i, i))).camera = of;
      if (result.interior_covariance(i, i) > 0) estimated.push_back(i);
    }
    if (camera.reference_distance > 0) add("Z0", camera.reference_distance, 0).camera = of;
  }
  for (size_t i = 0; i < result.principal_points.size(); ++i) {
    if (!result.cam_from_world[i]) continue;
    const ImagePrincipalPoint& own = result.principal_points[i];
    add("x0", own.shift.x(), std::sqrt(own.covariance(0, 0))).image = block_.images[i].name;
    add("y0", own.shift.y(), std::sqrt(own.covariance(1, 1))).image = block_.images[i].name;
  }
  if (result.interior_covariance.size() == 0) return;
  const Eigen::MatrixXd covariance = result.interior_covariance(estimated, estimated);
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  artifact.interior_correlations =
      pack_symmetric(Eigen::MatrixXd(scale.asDiagonal() * covariance * scale.asDiagonal()));
}

void TagBlockBuilder::describe_lambda(const TagBlockResult& result, const TagBlockOptions& options,
                                      BlockT& artifact) const {
  constexpr double much = 2;
  const double corner = options.corner_sigma * std::sqrt(result.image_variance_factor);
  artifact.lambda = options.lambda;
  artifact.lambda_control_sigma = corner / std::sqrt(options.lambda);
  if (options.free_network || block_.control.covariance.size() == 0) return;
  const double stated = std::sqrt(block_.control.covariance.diagonal().mean());
  const double ratio = artifact.lambda_control_sigma / stated;
  if (ratio < much && ratio > 1 / much) return;
  artifact.warnings.push_back(fmt::format(
      "λ of {:.4g} px²/m² believes a standard deviation of {:.3g} mm of a surveyed coordinate (corners of {:.3g} px, "
      "as their residuals show), the survey states {:.3g} mm: λ of {:.2g} would be right, or weighting=covariance",
      options.lambda, 1e3 * artifact.lambda_control_sigma, corner, 1e3 * stated,
      (corner / stated) * (corner / stated)));
}

namespace {

void describe_groups(const TagBlockResult& result, BlockT& artifact) {
  for (const auto& group : result.groups) {
    auto entry = std::make_unique<BlockGroupT>();
    entry->name = group.name;
    entry->observations = group.rows;
    entry->weighted_sum_of_squares = group.sum_of_squares;
    entry->redundancy = group.redundancy;
    if (group.redundancy > 1e-6) entry->variance_factor = group.factor;
    artifact.groups.push_back(std::move(entry));
  }
}

void describe_tests(const TagBlockResult& result, BlockT& artifact) {
  for (const auto* tests : {&result.tests, &result.models})
    for (const auto& test : *tests) {
      auto entry = std::make_unique<BlockTestT>();
      entry->group = test.group;
      entry->kind = test.kind == GroupTest::Kind::principal_points ? BlockTestKind::principal_points
                    : test.kind == GroupTest::Kind::distances      ? BlockTestKind::distances
                                                                   : BlockTestKind::observations;
      entry->variance_factor = test.factor;
      entry->limit = test.limit;
      entry->passed = test.passed;
      entry->words = test.words;
      entry->shift = test.shift;
      entry->points_factor = test.points_factor;
      artifact.tests.push_back(std::move(entry));
    }
}

}  // namespace

void TagBlockBuilder::describe_batches(const TagBlockResult& result, BlockT& artifact) const {
  for (const auto& batch : result.batches) {
    auto entry = std::make_unique<BlockBatchT>();
    entry->name = batch.name;
    entry->batch = batch.batch;
    if (batch.camera > 0) entry->camera = block_.cameras[batch.camera].name;
    entry->tag_scale = batch.scale;
    entry->tag_scale_sigma = batch.scale_sigma;
    entry->corner_inset = batch.inset;
    entry->corner_inset_sigma = batch.inset_sigma;
    artifact.batches.push_back(std::move(entry));
  }
}

void TagBlockBuilder::describe_control(const TagBlockResult& result, BlockT& artifact) const {
  for (const auto& control : result.control) {
    auto entry = std::make_unique<BlockControlT>();
    entry->anchor = block_.plates[control.plate].anchor;
    for (size_t c = 0; c < 3; ++c) {
      auto coordinate = std::make_unique<ControlCoordinateT>();
      coordinate->residual = control.coordinates[c].residual;
      coordinate->redundancy_number = control.coordinates[c].redundancy_number;
      coordinate->w = control.coordinates[c].w;
      coordinate->minimal_detectable_error = control.coordinates[c].mdb;
      coordinate->effect_on_height = control.effect_on_height[c];
      entry->coordinates.push_back(std::move(coordinate));
    }
    artifact.control.push_back(std::move(entry));
  }
  for (const RejectedControl& rejected : result.rejected_control) {  // no part of the datum: all of its error shows
    auto entry = std::make_unique<BlockControlT>();
    entry->anchor = block_.plates[rejected.plate].anchor;
    for (int c = 0; c < 3; ++c) {
      auto coordinate = std::make_unique<ControlCoordinateT>();
      coordinate->residual = -rejected.off(c);
      coordinate->redundancy_number = 1;
      coordinate->w = coordinate->residual / rejected.sigma(c);
      coordinate->effect_on_height = 0;
      entry->coordinates.push_back(std::move(coordinate));
    }
    entry->left_out = true;
    artifact.control.push_back(std::move(entry));
  }
}

void TagBlockBuilder::describe_plates(const TagBlockResult& result, BlockT& artifact) const {
  for (size_t j = 0; j < result.plates.size(); ++j) {
    auto entry = std::make_unique<BlockAnchorT>();
    entry->anchor = block_.plates[result.plates[j]].anchor;
    entry->images = result.images_per_plate[j];
    entry->largest_w = result.plate_w[j];
    entry->rotation = result.world_from_plate[j];
    artifact.anchors.push_back(std::move(entry));
  }
  for (int o : result.rejected) {
    const TagObservation& seen = block_.observations[o];
    auto entry = std::make_unique<BlockRejectionT>();
    entry->path = block_.images[seen.image].name;
    entry->anchor = block_.plates[seen.plate].anchor;
    artifact.rejected.push_back(std::move(entry));
  }
}

BlockT TagBlockBuilder::describe(const TagBlockResult& result, const TagBlockOptions& options) const {
  BlockT artifact;
  const bool by_lambda = options.weighting == TagBlockOptions::Weighting::lambda;
  artifact.datum = options.free_network ? "free" : "control";
  artifact.weighting = by_lambda ? "lambda" : "covariance";
  artifact.statistics = statistics(result);
  artifact.image_variance_factor = result.image_variance_factor;
  describe_groups(result, artifact);
  describe_interior(result, artifact);
  describe_batches(result, artifact);
  describe_control(result, artifact);
  describe_images(result, artifact);
  describe_plates(result, artifact);
  describe_tests(result, artifact);
  artifact.warnings = result.warnings;
  if (by_lambda) describe_lambda(result, options, artifact);
  artifact.left_out = result.left_out;
  artifact.weak_datum = result.weak_datum;
  if (!options.free_network) artifact.weakest_datum_sigma = result.weakest_datum_sigma;
  return artifact;
}

}  // namespace plumbline::block
