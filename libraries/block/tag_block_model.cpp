#include "block/tag_block_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "geometry/median.hpp"

namespace plumbline::adjust {
namespace {

Eigen::MatrixXd whitening_of(const Eigen::MatrixXd& covariance, const char* what) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success || !covariance.allFinite())
    throw std::runtime_error(std::string("the covariance of ") + what + " is not positive definite");
  return factor.matrixL().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

/// Which values a self-calibration may change. A prior without variance means that the calibration held the parameter:
/// so do we.
std::vector<bool> free_interior(const TagBlock& block, const TagBlockOptions& options) {
  const auto& names = bundle::value_names(bundle::Lens::brown);
  for (const auto& name : options.free_interior)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw std::runtime_error("unknown interior parameter '" + name +
                               "'; known are fx, fy, cx, cy, k1, k2, k3, p1, p2, d1, d2");
  std::vector<bool> free;
  for (size_t i = 0; i < names.size(); ++i) {
    const bool named =
        std::find(options.free_interior.begin(), options.free_interior.end(), names[i]) != options.free_interior.end();
    const Eigen::Index k = static_cast<Eigen::Index>(i);
    const bool exact = k < block.camera_covariance.rows() && !(block.camera_covariance(k, k) > 0);
    free.push_back(options.self_calibration && named && !exact);
  }
  return free;
}

/// 1 / the median depth of what the images see.
double inverse_distance(const TagBlock& block, const TagStart& start) {
  std::map<int, RigidTransform> pose, plate;
  for (size_t i = 0; i < start.images.size(); ++i) pose[start.images[i]] = start.cam_from_world[i];
  for (size_t j = 0; j < start.plates.size(); ++j) plate[start.plates[j]] = start.world_from_plate[j];
  std::vector<double> depths;
  for (int o : start.observations) {
    const TagObservation& seen = block.observations[static_cast<size_t>(o)];
    depths.push_back((pose.at(seen.image) * plate.at(seen.plate).translation).z());
  }
  const double middle = depths.empty() ? 0 : upper_median(std::move(depths));
  return middle > 0 ? 1 / middle : 0;
}

void add_interior(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  constexpr int count = BrownCamera::parameter_count;
  const int all = bundle::value_count(bundle::Lens::brown);
  const auto given = block.camera.parameters();
  const std::vector<bool> free = free_interior(block, options);
  model.problem.cameras.push_back(
      {"camera", bundle::Lens::brown, 0, free,
       block.reference_distance > 0 ? 1 / block.reference_distance : inverse_distance(block, start)});
  model.state.interiors.emplace_back();
  const auto distance_terms = std::copy(given.begin(), given.end(), model.state.interiors.back().begin());
  std::copy_n(block.distance_terms.data(), 2, distance_terms);
  std::vector<int> chosen;
  for (int i = 0; i < count; ++i)  // nobody calibrated d1 and d2
    if (free[static_cast<size_t>(i)]) chosen.push_back(i);
  if (chosen.empty()) return;
  bundle::Known term;
  term.refs = {{bundle::Kind::camera, 0}};
  term.target = Eigen::VectorXd::Zero(all);
  if (block.camera_covariance.size() > 0) {
    const Eigen::MatrixXd inverse =
        whitening_of(block.camera_covariance(chosen, chosen), "the calibration's interior orientation");
    term.whitening = Eigen::MatrixXd::Zero(inverse.rows(), all);
    term.whitening(Eigen::all, chosen) = inverse;
    term.target.head(count) = Eigen::Map<const Eigen::VectorXd>(given.data(), count);
    term.group = group_interior;
    model.problem.known.push_back(term);
  }
  if (options.fixed_aspect && free[0] && free[1]) {
    constexpr double sigma = 1e-3;  // [px]: far below what any image tells, far above rounding
    term.whitening = Eigen::MatrixXd::Zero(1, all);
    term.whitening(0) = block.camera.fy / block.camera.fx / sigma;
    term.whitening(1) = -1 / sigma;
    term.target = Eigen::VectorXd::Zero(all);
    term.group = group_aspect;
    model.problem.known.push_back(term);
  }
}

void add_prior(TagModel& model, bundle::Ref ref, double expected, double sigma, int group) {
  bundle::Known term;
  term.refs = {ref};
  term.target = Eigen::VectorXd::Constant(1, expected);
  term.whitening = Eigen::MatrixXd::Constant(1, 1, 1 / sigma);
  term.group = group;
  model.problem.known.push_back(term);
}

void add_plates(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  std::map<std::string, int> batches;
  for (size_t j = 0; j < start.plates.size(); ++j) {
    const TagPlate& plate = block.plates[static_cast<size_t>(start.plates[j])];
    const auto [at, is_new] = batches.emplace(plate.batch, static_cast<int>(batches.size()));
    if (is_new) {
      model.problem.batches.push_back({plate.batch, options.tag_scale_sigma > 0, options.corner_inset_sigma > 0});
      model.state.scales.push_back(1);
      model.state.insets.push_back(0);
    }
    model.problem.plates.push_back({plate.anchor, plate.plate, at->second});
    model.state.plates.emplace_back();
    model.state.plates.back().set(start.world_from_plate[j].rotation,
                                  start.world_from_plate[j].translation - model.origin);
  }
  for (int b = 0; b < static_cast<int>(batches.size()); ++b) {
    if (options.tag_scale_sigma > 0 && std::isfinite(options.tag_scale_sigma))
      add_prior(model, {bundle::Kind::scale, b}, 1, options.tag_scale_sigma, group_scale);
    if (options.corner_inset_sigma > 0)
      add_prior(model, {bundle::Kind::inset, b}, 0, options.corner_inset_sigma, group_inset);
  }
}

void add_images(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  for (size_t i = 0; i < start.images.size(); ++i) {
    const RigidTransform& pose = start.cam_from_world[i];
    model.problem.images.push_back({block.images[static_cast<size_t>(start.images[i])].name, 0});
    model.state.images.emplace_back();
    model.state.images.back().set(pose.rotation, pose.inverse().translation - model.origin);
  }
  const auto own = [&](int i) { return block.images[static_cast<size_t>(i)].principal_point; };
  if (std::any_of(start.images.begin(), start.images.end(), [&](int i) { return !own(i).isZero(0); }))
    for (int i : start.images) model.state.shifts.push_back(own(i));
  if (options.image_principal_point_sigma > 0)
    free_principal_points(options.image_principal_point_sigma, model.problem, model.state);
}

void add_observations(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  const auto number = [](const std::vector<int>& among, int which) {
    return static_cast<int>(std::find(among.begin(), among.end(), which) - among.begin());
  };
  for (int o : start.observations) {
    const TagObservation& seen = block.observations[static_cast<size_t>(o)];
    bundle::ImageTag term;
    term.image = number(start.images, seen.image);
    term.plate = number(start.plates, seen.plate);
    term.corners = seen.corners;
    term.group = group_images;
    term.robust = true;
    for (size_t k = 0; k < 4; ++k)
      term.whitening[k] = options.weighting == TagBlockOptions::Weighting::lambda
                              ? Eigen::Matrix2d(Eigen::Matrix2d::Identity() / options.corner_sigma)
                              : Eigen::Matrix2d(whitening_of(seen.covariances[k], "a tag corner"));
    model.problem.image_tags.push_back(term);
  }
}

void add_control(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  std::vector<int> rows;
  bundle::Known term;
  for (size_t k = 0; k < block.control.plates.size(); ++k) {
    const auto at = std::find(start.plates.begin(), start.plates.end(), block.control.plates[k]);
    if (at == start.plates.end()) continue;  // surveyed, but in no image
    model.control_plates.push_back(static_cast<int>(at - start.plates.begin()));
    term.refs.push_back({bundle::Kind::plate, model.control_plates.back()});
    for (int c = 0; c < 3; ++c) rows.push_back(3 * static_cast<int>(k) + c);
  }
  if (rows.empty()) return;
  term.target = block.control.position(rows);
  for (Eigen::Index i = 0; i < term.target.size(); ++i) term.target(i) -= model.origin(i % 3);
  if (options.weighting == TagBlockOptions::Weighting::lambda)
    term.whitening = std::sqrt(options.lambda) / options.corner_sigma *
                     Eigen::MatrixXd::Identity(term.target.size(), term.target.size());
  else
    term.whitening = whitening_of(block.control.covariance(rows, rows), "the control points");
  term.group = group_control;
  model.control_term = static_cast<int>(model.problem.known.size());
  model.problem.known.push_back(term);
}

}  // namespace

Eigen::MatrixXd regular_covariance(Eigen::MatrixXd covariance) {
  constexpr double exact = 1e-6, added = 1e-5;  // [m]
  if (covariance.size() == 0) return covariance;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance, Eigen::EigenvaluesOnly);
  if (solver.eigenvalues()(0) < exact * exact) covariance.diagonal().array() += added * added;
  return covariance;
}

void free_principal_points(double sigma, bundle::Problem& problem, bundle::State& state) {
  state.shifts.resize(problem.images.size(), Eigen::Vector2d::Zero());
  for (int i = 0; i < static_cast<int>(problem.images.size()); ++i) {
    problem.images[static_cast<size_t>(i)].shift_free = true;
    problem.known.push_back({{{bundle::Kind::shift, i}},
                             Eigen::Vector2d::Zero(),
                             Eigen::Matrix2d::Identity() / sigma,
                             group_principal_points});
  }
}

TagModel build_tag_model(const TagBlock& block, const TagBlockOptions& options, const TagStart& start) {
  TagModel model;
  for (const char* name : {"images", "control", "interior prior", "tag scale prior", "corner inset prior",
                           "aspect condition", "principal points of images"})
    model.problem.groups.push_back({name});
  for (const auto& plate : start.world_from_plate)
    model.origin += plate.translation / static_cast<double>(start.plates.size());
  // Whole metres: subtracting them from the coordinates of control loses no digit.
  model.origin = model.origin.array().round().matrix();
  add_interior(block, options, start, model);
  add_plates(block, options, start, model);
  add_images(block, options, start, model);
  add_observations(block, options, start, model);
  if (!options.free_network) add_control(block, options, start, model);
  return model;
}

}  // namespace plumbline::adjust
