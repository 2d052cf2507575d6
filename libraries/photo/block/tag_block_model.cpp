#include "photo/block/tag_block_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/median.hpp"

namespace plumbline::block {
namespace {

Eigen::MatrixXd whitening_of(const Eigen::MatrixXd& covariance, const char* what) {
  const auto refuse = [what] {
    throw std::runtime_error(std::string("the covariance of ") + what + " is not positive definite");
  };
  if (covariance.isDiagonal(0)) {  // uncorrelated, as most are
    if (!(covariance.diagonal().array() > 0).all() || !covariance.allFinite()) refuse();
    return covariance.diagonal().cwiseSqrt().cwiseInverse().asDiagonal();
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success || !covariance.allFinite()) refuse();
  return factor.matrixL().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

/// The same of a tag's corner: L⁻¹ of two rows.
Eigen::Matrix2d whitening_of_corner(const Eigen::Matrix2d& covariance) {
  const double pivot = covariance(0, 0), slope = covariance(1, 0) / pivot;
  const double left = covariance(1, 1) - slope * covariance(1, 0);
  if (!(pivot > 0) || !(left > 0) || !covariance.allFinite())
    throw std::runtime_error("the covariance of a tag corner is not positive definite");
  Eigen::Matrix2d whitening;
  whitening << 1, 0, -slope, 1;
  whitening.row(0) /= std::sqrt(pivot);
  whitening.row(1) /= std::sqrt(left);
  return whitening;
}

/// Which values a self-calibration may change. A prior without variance means that the calibration held the parameter:
/// so do we.
std::vector<bool> free_interior(const TagCamera& camera, const TagBlockOptions& options) {
  const auto has = [](bundle::Lens lens, const std::string& name) {
    const auto& names = bundle::value_names(lens);
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const auto& name : options.free_interior)
    if (!has(bundle::Lens::brown, name) && !has(bundle::Lens::fisheye, name))
      throw std::runtime_error("unknown interior parameter '" + name +
                               "'; known are fx, fy, cx, cy, k1, k2, k3, p1, p2, d1, d2, and k4 of a fisheye");
  const auto& names = bundle::value_names(bundle::lens_of(camera.interior.lens));
  std::vector<bool> free;
  for (size_t i = 0; i < names.size(); ++i) {
    const bool named =
        std::find(options.free_interior.begin(), options.free_interior.end(), names[i]) != options.free_interior.end();
    const Eigen::Index k = static_cast<Eigen::Index>(i);
    const bool exact = k < camera.covariance.rows() && !(camera.covariance(k, k) > 0);
    free.push_back(options.self_calibration && named && !exact);
  }
  return free;
}

/// 1 / the median depth of what the images of a camera see; 0 without any.
double inverse_distance(const TagBlock& block, const TagStart& start, int camera) {
  std::map<int, RigidTransform> pose, plate;
  for (size_t i = 0; i < start.images.size(); ++i) pose[start.images[i]] = start.cam_from_world[i];
  for (size_t j = 0; j < start.plates.size(); ++j) plate[start.plates[j]] = start.world_from_plate[j];
  std::vector<double> depths;
  for (int o : start.observations) {
    const TagObservation& seen = block.observations[o];
    if (block.images[seen.image].camera != camera) continue;
    depths.push_back((pose.at(seen.image) * plate.at(seen.plate).translation).z());
  }
  const double middle = depths.empty() ? 0 : upper_median(std::move(depths));
  return middle > 0 ? 1 / middle : 0;
}

/// Its own group if there are several cameras, so that a wrong calibration is told from a sound one.
int interior_group(const TagBlock& block, const TagCamera& camera, TagModel& model) {
  if (block.cameras.size() == 1) return group_interior;
  model.problem.groups.push_back({"interior prior of " + camera.name});
  return static_cast<int>(model.problem.groups.size()) - 1;
}

void add_interior_terms(const TagBlock& block, const TagCamera& camera, const TagBlockOptions& options,
                        const std::vector<bool>& free, TagModel& model) {
  const int count = static_cast<int>(camera.interior.names().size());
  const int all = bundle::value_count(bundle::lens_of(camera.interior.lens));
  std::vector<int> chosen;
  for (int i = 0; i < count; ++i)  // nobody calibrated d1 and d2
    if (free[i]) chosen.push_back(i);
  if (chosen.empty()) return;
  bundle::Known term;
  term.refs = {{bundle::Kind::camera, static_cast<int>(model.problem.cameras.size()) - 1}};
  term.target = Eigen::VectorXd::Zero(all);
  if (camera.covariance.size() > 0) {
    const Eigen::MatrixXd inverse =
        whitening_of(camera.covariance(chosen, chosen), "the calibration's interior orientation");
    const auto given = camera.interior.parameters();
    term.whitening = Eigen::MatrixXd::Zero(inverse.rows(), all);
    term.whitening(Eigen::all, chosen) = inverse;
    term.target.head(count) = Eigen::Map<const Eigen::VectorXd>(given.data(), count);
    term.group = interior_group(block, camera, model);
    model.problem.known.push_back(term);
  }
  if (options.fixed_aspect && free[0] && free[1]) {
    constexpr double sigma = 1e-3;  // [px]: far below what any image tells, far above rounding
    term.whitening = Eigen::MatrixXd::Zero(1, all);
    term.whitening(0) = camera.interior.fy / camera.interior.fx / sigma;
    term.whitening(1) = -1 / sigma;
    term.target = Eigen::VectorXd::Zero(all);
    term.group = group_aspect;
    model.problem.known.push_back(term);
  }
}

/// A camera none of whose images takes part is held as it is given.
void add_cameras(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    const TagCamera& camera = block.cameras[c];
    const bool used = std::any_of(start.images.begin(), start.images.end(),
                                  [&](int i) { return block.images[i].camera == static_cast<int>(c); });
    std::vector<bool> free = free_interior(camera, options);
    if (!used) std::fill(free.begin(), free.end(), false);
    model.problem.cameras.push_back({camera.name, bundle::lens_of(camera.interior.lens), 0, free,
                                     camera.reference_distance > 0
                                         ? 1 / camera.reference_distance
                                         : inverse_distance(block, start, static_cast<int>(c))});
    model.state.interiors.emplace_back();
    const auto given = camera.interior.parameters();
    const auto distance_terms = std::copy(given.begin(), given.end(), model.state.interiors.back().begin());
    std::copy_n(camera.distance_terms.data(), 2, distance_terms);
    add_interior_terms(block, camera, options, free, model);
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

/// What is drawn inwards depends on a camera's blur and grey values: batches without tags, one of each batch and
/// further camera, hold its inset.
void add_insets_of_cameras(const TagBlock& block, TagModel& model) {
  const size_t printed = model.problem.batches.size();
  for (size_t c = 1; c < block.cameras.size(); ++c)
    for (size_t b = 0; b < printed; ++b) {
      const std::string& name = model.problem.batches[b].name;
      model.problem.batches.push_back({name + (name.empty() ? "in " : " in ") + block.cameras[c].name, false, true});
      model.state.scales.push_back(1);
      model.state.insets.push_back(0);
    }
}

/// Prior of a camera's insets: what its detector states, as a root mean square over its images, because what it errs by
/// is much the same in all of them.
double inset_prior(const TagBlock& block, const TagBlockOptions& options, int camera) {
  double squares = 0, count = 0;
  for (const TagImage& image : block.images)
    if (image.camera == camera && image.inset_sigma > 0) squares += image.inset_sigma * image.inset_sigma, count += 1;
  return count > 0 ? std::sqrt(squares / count) : options.corner_inset_sigma;
}

void add_plates(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  std::map<std::string, int> batches;
  for (size_t j = 0; j < start.plates.size(); ++j) {
    const TagPlate& plate = block.plates[start.plates[j]];
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
  const int printed = static_cast<int>(model.problem.batches.size());
  if (options.corner_inset_sigma > 0) add_insets_of_cameras(block, model);
  for (int b = 0; b < static_cast<int>(model.problem.batches.size()); ++b) {
    if (model.problem.batches[b].scale_free && std::isfinite(options.tag_scale_sigma))
      add_prior(model, {bundle::Kind::scale, b}, 1, options.tag_scale_sigma, group_scale);
    if (options.corner_inset_sigma > 0)
      add_prior(model, {bundle::Kind::inset, b}, 0, inset_prior(block, options, b / printed), group_inset);
  }
}

void add_images(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  for (size_t i = 0; i < start.images.size(); ++i) {
    const RigidTransform& pose = start.cam_from_world[i];
    const TagImage& image = block.images[start.images[i]];
    model.problem.images.push_back({image.name, image.camera});
    model.state.images.emplace_back();
    model.state.images.back().set(pose.rotation, pose.inverse().translation - model.origin);
  }
  const auto own = [&](int i) { return block.images[i].principal_point; };
  if (std::any_of(start.images.begin(), start.images.end(), [&](int i) { return !own(i).isZero(0); }))
    for (int i : start.images) model.state.shifts.push_back(own(i));
  if (options.image_principal_point_sigma > 0)
    free_principal_points(options.image_principal_point_sigma, model.problem, model.state);
}

void add_observations(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  const auto number = [](const std::vector<int>& among, int which) {
    return static_cast<int>(std::find(among.begin(), among.end(), which) - among.begin());
  };
  // Of each camera's insets there are as many as print batches: those of the first stand with the batches themselves.
  const size_t printed = options.corner_inset_sigma > 0 ? model.problem.batches.size() / block.cameras.size() : 0;
  for (int o : start.observations) {
    const TagObservation& seen = block.observations[o];
    bundle::ImageTag term;
    term.image = number(start.images, seen.image);
    term.plate = number(start.plates, seen.plate);
    if (const int camera = block.images[seen.image].camera; printed > 0 && camera > 0)
      term.inset = camera * static_cast<int>(printed) + model.problem.plates[term.plate].batch;
    term.corners = seen.corners;
    term.group = group_images;
    term.robust = true;
    for (size_t k = 0; k < 4; ++k)
      term.whitening[k] = options.weighting == TagBlockOptions::Weighting::lambda
                              ? Eigen::Matrix2d(Eigen::Matrix2d::Identity() / options.corner_sigma)
                              : whitening_of_corner(seen.covariances[k]);
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
  const double smallest = covariance.isDiagonal(0)
                              ? covariance.diagonal().minCoeff()
                              : linear_algebra::SymmetricEigen(covariance, Eigen::EigenvaluesOnly).eigenvalues()(0);
  if (smallest < exact * exact) covariance.diagonal().array() += added * added;
  return covariance;
}

void free_principal_points(double sigma, bundle::Problem& problem, bundle::State& state) {
  state.shifts.resize(problem.images.size(), Eigen::Vector2d::Zero());
  for (int i = 0; i < static_cast<int>(problem.images.size()); ++i) {
    problem.images[i].shift_free = true;
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
  add_cameras(block, options, start, model);
  add_plates(block, options, start, model);
  add_images(block, options, start, model);
  add_observations(block, options, start, model);
  if (!options.free_network) add_control(block, options, start, model);
  return model;
}

}  // namespace plumbline::block
