#include "build/evaluate/bound_inputs.hpp"

#include <cmath>
#include <map>

#include "artifacts/camera_artifact.hpp"
#include "geometry/marker_plate.hpp"
#include "geometry/packed_symmetric.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::judgement {

namespace {

/// Parameters that the prior leaves free, and its covariance of them.
void set_camera(block::BoundProblem& problem, const CameraT& camera, const std::string& self_calibration) {
  problem.camera = camera_of(camera);
  const Eigen::MatrixXd prior = interior_covariance_of(camera);
  if (self_calibration == "off" || (self_calibration == "prior" && prior.size() == 0)) return;
  for (int i = 0; i < std::ssize(problem.camera.names()); ++i) {
    // Not estimated without a prior: k1 and k2 explain it.
    const bool higher_radial = i == 6 || (i == 7 && problem.camera.lens == LensModel::fisheye);
    if (self_calibration == "prior" ? prior(i, i) > 0 : !higher_radial) problem.free_parameters.push_back(i);
  }
  if (self_calibration == "prior") problem.camera_prior = prior(problem.free_parameters, problem.free_parameters);
}

}  // namespace

std::map<std::string, const PointT*> by_id(const PointsT& points) {
  std::map<std::string, const PointT*> index;
  for (const auto& point : points.points) index[point->id] = point.get();
  return index;
}

void BoundInputs::add_tags(Context& context, block::BoundProblem& problem, const PlatesT& table) const {
  std::map<std::pair<std::string, int>, std::string> anchor_of_tag;
  for (const auto& plate : table.plates) anchor_of_tag[{plate->tag_family, plate->tag_id}] = plate->anchor;
  std::map<std::string, std::size_t> plate_of_anchor;
  for (std::size_t j = 0; j < problem.plates.size(); ++j) plate_of_anchor[problem.plates[j].anchor] = j;
  std::map<std::string, RigidTransform> pose_of_image;
  for (std::size_t k = 0; k < poses.size(); ++k)
    for (const auto& pose : poses.unpack(k).poses) pose_of_image[pose->path] = pose->cam_from_world;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    const ImageTagsT image = observations.unpack(k);
    const auto pose = pose_of_image.find(image.path);
    if (pose == pose_of_image.end()) continue;  // an image that could not be oriented says nothing
    problem.cam_from_world.push_back(pose->second);
    problem.images.push_back(image.path);
    const std::size_t before = problem.tags.size();
    for (const auto& tag : image.tags) {
      const auto anchor = anchor_of_tag.find({tag->family, tag->id});
      if (anchor == anchor_of_tag.end() || !plate_of_anchor.count(anchor->second)) continue;
      block::BoundTag seen;
      seen.image = problem.cam_from_world.size() - 1;
      seen.plate = plate_of_anchor[anchor->second];
      for (std::size_t i = 0; i < 4; ++i) {
        seen.covariances[i] = Eigen::Matrix2d::Identity() * *corner_sigma * *corner_sigma;
        if (tag->corner_covariances.size() == 12) {
          const double* v = tag->corner_covariances.data() + 3 * i;
          seen.covariances[i] << v[0], v[1], v[1], v[2];
        }
      }
      problem.tags.push_back(seen);
    }
    if (problem.tags.size() - before < 3)
      context.warn("image " + image.path + " shows " + std::to_string(problem.tags.size() - before) +
                   " markers of the plate table; three are needed to orient it safely");
  }
}

block::BoundProblem BoundInputs::problem(Context& context) const {
  block::BoundProblem problem;
  set_camera(problem, camera.unpack(), *self_calibration);
  problem.batch_scale_sigma = *tag_scale_sigma;
  const PlatesT table = plates.unpack();
  const PointsT anchors = points.unpack(), surveyed = control.unpack();
  const auto place = by_id(anchors);
  std::map<std::string, int> batches;
  std::map<std::string, std::size_t> index;
  std::map<std::string, std::string> roles;
  for (const auto& plate : table.plates) {
    const auto point = place.find(plate->anchor);
    if (point == place.end() || !point->second->position.allFinite()) continue;
    block::BoundPlate entry;
    entry.anchor = plate->anchor;
    entry.position = point->second->position;
    entry.world_from_plate = plate->nominal_rotation.normalized();
    entry.tag_centre_in_plate = plate->tag_centre_in_plate;
    entry.corners_in_plate = tag_corners_in_plate({plate->tag_size, plate->tag_centre_in_plate});
    entry.batch = batches.emplace(plate->batch, static_cast<int>(batches.size())).first->second;
    index[entry.anchor] = problem.plates.size();
    roles[entry.anchor] = plate->role;
    problem.plates.push_back(std::move(entry));
  }
  problem.batches = static_cast<int>(batches.size());
  const Eigen::MatrixXd covariance =
      unpack_symmetric(surveyed.covariance, 3 * surveyed.points.size(), "input 'control'");
  std::vector<Eigen::Index> rows;
  std::vector<double> variances;
  for (std::size_t i = 0; i < surveyed.points.size(); ++i) {
    const PointT& point = *surveyed.points[i];
    if (point.role == "check" || !index.count(point.id) || roles[point.id] == "check") continue;
    problem.control.push_back(index[point.id]);
    for (int c = 0; c < 3; ++c) {
      rows.push_back(static_cast<Eigen::Index>(3 * i) + c);
      variances.push_back(point.sigma(c) * point.sigma(c));
    }
  }
  if (covariance.size() > 0)
    problem.control_covariance = covariance(rows, rows);
  else
    problem.control_covariance =
        Eigen::Map<const Eigen::VectorXd>(variances.data(), static_cast<Eigen::Index>(variances.size())).asDiagonal();
  add_tags(context, problem, table);
  return problem;
}

Prospects BoundInputs::prospects(const block::BoundProblem& given, const Eigen::MatrixXd& covariance,
                                 const std::vector<std::size_t>& wanted) const {
  std::map<std::string, int> floor_of;
  for (const auto& plate : plates.unpack().plates) floor_of[plate->anchor] = plate->floor;
  std::map<int, std::vector<Eigen::Index>> rows;  // of the heights, by floor
  for (const std::size_t j : wanted)
    rows[floor_of[given.plates[j].anchor]].push_back(static_cast<Eigen::Index>(3 * j + 2));
  Prospects result;
  Eigen::VectorXd drift = Eigen::VectorXd::Zero(covariance.rows()), relative = drift;
  std::vector<Eigen::Index> all;
  for (const auto& [floor, heights] : rows)
    for (const Eigen::Index row : heights) {
      const double share = 1 / static_cast<double>(heights.size());
      drift(row) = share;
      if (floor == rows.rbegin()->first) relative(row) += share;
      if (floor == rows.begin()->first) relative(row) -= share;
      result.height_sigmas.push_back(std::sqrt(covariance(row, row)));
      all.push_back(row);
    }
  // Only rows that count: those of anchors in no image are infinite.
  const Eigen::MatrixXd of_heights = covariance(all, all);
  const auto sigma = [&](const Eigen::VectorXd& of) {
    return std::sqrt(std::max(0.0, of(all).dot(of_heights * of(all))));
  };
  result.drift = sigma(drift);
  result.relative_drift = sigma(relative);
  return result;
}

double Prospects::within(double tolerance) const {
  double sum = 0;
  for (const double sigma : height_sigmas) sum += 2 * normal_probability(tolerance / sigma) - 1;
  return sum / static_cast<double>(height_sigmas.size());
}

std::vector<std::size_t> BoundInputs::check_anchors(const block::BoundProblem& given,
                                                    const Eigen::MatrixXd& covariance) const {
  const PointsT anchors = points.unpack();
  const auto place = by_id(anchors);
  std::vector<std::size_t> result;
  for (std::size_t j = 0; j < given.plates.size(); ++j)
    if (place.at(given.plates[j].anchor)->role == "check" &&
        covariance.diagonal().segment<3>(static_cast<Eigen::Index>(3 * j)).allFinite())
      result.push_back(j);
  return result;
}

}  // namespace plumbline::judgement
