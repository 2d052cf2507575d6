#include "photo/colmap/tag_block.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "control/registration/rigid_registration.hpp"
#include "geometry/similarity.hpp"
#include "photo/block/tag_block_model.hpp"
#include "photo/bundle/parts.hpp"

namespace plumbline::colmap {
namespace {

using block::TagBlock;
using block::TagBlockResult;
using block::TagModel;
using block::TagStart;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Leaves out plates that fewer than two images see, and images that then see none.
TagStart with_two_rays(const TagBlock& block, const TagStart& start, std::vector<std::string>& left_out) {
  std::vector<std::set<int>> seen_by(block.plates.size());
  for (int o : start.observations) {
    const auto& seen = block.observations[o];
    seen_by[seen.plate].insert(seen.image);
  }
  TagStart result;
  std::set<int> used;
  for (int o : start.observations) {
    const auto& seen = block.observations[o];
    if (seen_by[seen.plate].size() < 2) continue;
    result.observations.push_back(o);
    used.insert(seen.image);
  }
  for (size_t j = 0; j < start.plates.size(); ++j) {
    const size_t plate = static_cast<size_t>(start.plates[j]);
    if (seen_by[plate].size() < 2) {
      left_out.push_back(block.plates[plate].anchor + ": seen in one image only, and COLMAP knows no size of a tag");
      continue;
    }
    result.plates.push_back(start.plates[j]);
    result.world_from_plate.push_back(start.world_from_plate[j]);
  }
  for (size_t i = 0; i < start.images.size(); ++i) {
    if (!used.count(start.images[i])) {
      left_out.push_back(block.images[start.images[i]].name + ": shares no tag with another image");
      continue;
    }
    result.images.push_back(start.images[i]);
    result.cam_from_world.push_back(start.cam_from_world[i]);
  }
  if (result.images.size() < 2)
    throw std::runtime_error("a block needs at least 2 images that share tags; of " +
                             std::to_string(start.images.size()) + " images no two do");
  return result;
}

/// The tags' corners as points: four a plate, in the order of model.problem.plates.
struct Corners {
  bundle::Problem problem;
  bundle::State state;
};

double corner_sigma_of(const TagBlock& block, const TagStart& start) {
  double sum = 0;
  for (int o : start.observations)
    for (const auto& covariance : block.observations[o].covariances) sum += covariance.trace();
  return std::sqrt(sum / (8 * static_cast<double>(start.observations.size())));
}

Corners corners_of(const TagBlock& block, const TagStart& start, const TagModel& model, const BundleOptions& options) {
  Corners corners;
  bundle::Problem& problem = corners.problem;
  const bool focal = options.refine_focal_length, centre = options.refine_principal_point,
             lens = options.refine_extra_params;
  problem.cameras = model.problem.cameras;
  problem.images = model.problem.images;
  for (size_t c = 0; c < problem.cameras.size(); ++c) {
    bundle::Camera& camera = problem.cameras[c];
    camera.inverse_reference = 0;
    if (std::any_of(problem.images.begin(), problem.images.end(),
                    [&](const auto& image) { return image.camera == static_cast<int>(c); })) {
      if (camera.lens == bundle::Lens::fisheye)
        camera.free = {focal, focal, centre, centre, lens, lens, lens, lens};
      else
        camera.free = {focal, focal, centre, centre, lens, lens, false, lens, lens, false, false};
    }
  }
  problem.groups.push_back({"images"});
  corners.state.interiors = model.state.interiors;
  corners.state.images = model.state.images;
  for (size_t j = 0; j < model.problem.plates.size(); ++j) {
    const auto& plate = model.problem.plates[j];
    const bundle::Placement& at = model.state.plates[j];
    int number = 0;
    for (const Eigen::Vector3d& corner : tag_corners_in_plate(plate.shape)) {
      problem.points.push_back({"corner " + std::to_string(++number) + " of " + plate.name});
      corners.state.points.push_back(at.position + at.matrix * corner);
    }
  }
  bundle::ImagePoint point;
  point.whitening /= corner_sigma_of(block, start);
  for (const auto& tag : model.problem.image_tags)
    for (int k = 0; k < 4; ++k) {
      point.image = tag.image;
      point.point = 4 * tag.plate + k;
      point.observed = tag.corners[k];
      problem.image_points.push_back(point);
    }
  return corners;
}

void move(const SimilarityMotion& motion, bundle::State& state) {
  for (auto& image : state.images) image.set(image.rotation * motion.rotation.conjugate(), motion * image.position);
  for (auto& point : state.points) point = motion * point;
}

/// Mean length of the edges of each plate's tag.
double edge_of(const bundle::State& state, size_t plate) {
  double sum = 0;
  for (size_t k = 0; k < 4; ++k) sum += (state.points[4 * plate + k] - state.points[4 * plate + (k + 1) % 4]).norm();
  return sum / 4;
}

void scale_by_tags(const TagModel& model, bundle::State& state) {
  double printed = 0, found = 0;
  for (size_t j = 0; j < model.problem.plates.size(); ++j)
    printed += model.problem.plates[j].shape.tag_size, found += edge_of(state, j);
  SimilarityMotion motion;
  motion.scale = printed / found;
  move(motion, state);
}

/// Plates by a rigid fit to their corners.
std::vector<SimilarityMotion> plates_of(const TagModel& model, const bundle::State& state) {
  std::vector<SimilarityMotion> plates;
  for (size_t j = 0; j < model.problem.plates.size(); ++j) {
    const auto shape = tag_corners_in_plate(model.problem.plates[j].shape);
    const auto first = state.points.begin() + static_cast<std::ptrdiff_t>(4 * j);
    plates.push_back(fit_similarity({shape.begin(), shape.end()}, {first, first + 4}, false));
  }
  return plates;
}

registration::Correspondences control_of(const TagBlock& block, const TagStart& start, const TagModel& model) {
  registration::Correspondences c;
  std::vector<int> rows;
  const auto& known = model.problem.known[model.control_term];
  c.target = Eigen::Map<const Eigen::Matrix3Xd>(known.target.data(), 3, known.target.size() / 3);
  c.source.resize(3, c.target.cols());
  for (int j : model.control_plates) {
    c.ids.push_back(model.problem.plates[j].name);
    const auto& among = block.control.plates;
    const auto at = std::find(among.begin(), among.end(), start.plates[j]) - among.begin();
    for (int k = 0; k < 3; ++k) rows.push_back(3 * static_cast<int>(at) + k);
  }
  c.target_covariance = block.control.covariance(rows, rows);
  return c;
}

/// Registers the anchors on the control. The plates' offsets are in metres of the survey, so they are put on anew at
/// each scale until it stays.
registration::Registration register_on_control(const TagBlock& block, const TagStart& start, const TagModel& model,
                                               const TagBlockOptions& options, bundle::State& state) {
  registration::Correspondences points = control_of(block, start, model);
  registration::Options how;
  how.weighting = registration::Weighting::covariance;
  how.estimate_scale = options.estimate_scale;
  how.min_width_ratio = options.min_width_ratio;
  registration::Registration found;
  for (int pass = 0; pass < 20; ++pass) {
    const auto plates = plates_of(model, state);
    for (size_t k = 0; k < model.control_plates.size(); ++k)
      points.source.col(static_cast<Eigen::Index>(k)) = plates[model.control_plates[k]].translation;
    found = registration::register_points(points, how);
    move({found.to_from_from.rotation, found.to_from_from.translation, found.scale}, state);
    if (std::abs(found.scale - 1) < 1e-13) break;
  }
  return found;
}

/// Back to where the approximate values are, with the scale of the printed tags.
void move_to_start(const bundle::State& start, bundle::State& state) {
  move(fit_similarity(state.points, start.points, false), state);
}

void fill_statistics(const Corners& corners, const bundle::Layout& layout, const bundle::Elimination& elimination,
                     int defect, TagBlockResult& result) {
  result.observations = corners.problem.row_count();
  result.unknowns = layout.unknown_count();
  result.datum_defect = defect;
  result.degrees_of_freedom = result.observations - result.unknowns + defect;
  if (result.degrees_of_freedom < 1)
    throw std::runtime_error("the block has no redundancy: nothing checks its observations");
  result.weighted_sum_of_squares = elimination.sum_of_squares();
  const double redundancy = result.degrees_of_freedom;
  result.sigma0 = std::sqrt(result.weighted_sum_of_squares / redundancy);
  result.groups.push_back({"images", result.weighted_sum_of_squares / redundancy, result.weighted_sum_of_squares,
                           redundancy, result.observations});
}

void fill_tags(const TagStart& start, const Corners& corners, const bundle::Layout& layout, TagBlockResult& result) {
  bundle::Rows rows;
  for (size_t i = 0; i < start.observations.size(); ++i) {
    double sum = 0;
    for (size_t k = 0; k < 4; ++k) {
      bundle::ImagePoint point = corners.problem.image_points[4 * i + k];
      point.whitening.setIdentity();
      bundle::evaluate(corners.problem, layout, corners.state, point, false, rows);
      sum += rows.values().squaredNorm();
    }
    result.tags.push_back({start.observations[i], std::sqrt(sum / 8), unknown, unknown, unknown});
  }
}

void fill_batches(const TagModel& model, const bundle::State& state, TagBlockResult& result) {
  for (size_t b = 0; b < model.problem.batches.size(); ++b) {
    double printed = 0, found = 0;
    for (size_t j = 0; j < model.problem.plates.size(); ++j)
      if (model.problem.plates[j].batch == static_cast<int>(b))
        printed += model.problem.plates[j].shape.tag_size, found += edge_of(state, j);
    result.batches.push_back(
        {model.problem.batches[b].name, found / printed, unknown, unknown, unknown, model.problem.batches[b].name});
  }
}

void fill_control(const TagStart& start, const TagModel& model, TagBlockResult& result) {
  if (model.control_term < 0) return;
  const auto& target = model.problem.known[model.control_term].target;
  for (size_t k = 0; k < model.control_plates.size(); ++k) {
    const size_t plate = static_cast<size_t>(model.control_plates[k]);
    block::AdjustedControl control;
    control.plate = start.plates[plate];
    for (int c = 0; c < 3; ++c) {
      auto& row = control.coordinates[c];
      row = {unknown, unknown, unknown, unknown, unknown, unknown, unknown, unknown, unknown, unknown, -1};
      row.residual = result.anchors(3 * static_cast<Eigen::Index>(plate) + c) -
                     (target(3 * static_cast<Eigen::Index>(k) + c) + model.origin(c));
      control.effect_on_height[c] = unknown;
    }
    result.control.push_back(control);
  }
}

void fill_geometry(const TagBlock& block, const TagStart& start, const TagModel& model, const bundle::State& state,
                   TagBlockResult& result) {
  result.cam_from_world.resize(block.images.size());
  for (size_t i = 0; i < start.images.size(); ++i) {
    const bundle::Placement& p = state.images[i];
    result.cam_from_world[start.images[i]] = RigidTransform{p.rotation, -(p.rotation * (p.position + model.origin))};
  }
  result.plates = start.plates;
  result.anchors.resize(3 * static_cast<Eigen::Index>(start.plates.size()));
  Eigen::Index row = 0;
  for (const SimilarityMotion& plate : plates_of(model, state)) {
    result.anchors.segment<3>(row) = plate.translation + model.origin;
    result.world_from_plate.push_back(plate.rotation);
    row += 3;
  }
  result.plate_w.assign(start.plates.size(), unknown);
  result.images_per_plate.assign(start.plates.size(), 0);
  for (const auto& tag : model.problem.image_tags) ++result.images_per_plate[tag.plate];
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    block::AdjustedTagCamera camera;
    camera.interior = block.cameras[c].interior;
    std::array<double, BrownCamera::parameter_count> interior;
    std::copy_n(state.interiors[c].begin(), interior.size(), interior.begin());
    camera.interior.set_parameters(interior);
    camera.covariance = Eigen::MatrixXd::Zero(interior.size(), interior.size());
    result.cameras.push_back(camera);
  }
}

}  // namespace

TagBlockResult adjust_plates(const TagBlock& block, const TagBlockOptions& given) {
  block::require_usable(block);
  if (std::any_of(block.cameras.begin(), block.cameras.end(),
                  [](const auto& c) { return !c.distance_terms.isZero(0); }) ||
      std::any_of(block.images.begin(), block.images.end(), [](const auto& i) { return !i.principal_point.isZero(0); }))
    throw std::runtime_error(
        "COLMAP has neither distortion that changes with the distance nor principal points of single images, as this "
        "camera has; use adjust.schur, or a camera adjusted without");
  TagBlockOptions options = given;
  TagBlockResult result;
  if (options.bundle.refine_extra_params && std::any_of(block.cameras.begin(), block.cameras.end(), [](const auto& c) {
        return c.interior.lens == LensModel::brown && c.interior.k3 != 0;
      })) {
    options.bundle.refine_extra_params = false;
    result.warnings.push_back(
        "the lens' distortion is held: with k3, COLMAP would estimate a rational model, which no other camera here is");
  }
  const bool free = block.control.plates.empty();
  TagStart start = block::start_tag_block(block, std::vector<bool>(block.observations.size(), true), result.left_out);
  if (!free) block::move_to_control(block, start, result.warnings);
  start = with_two_rays(block, start, result.left_out);
  block::TagBlockOptions how;
  how.free_network = free;
  how.self_calibration = false;
  how.tag_scale_sigma = 0;
  const TagModel model = block::build_tag_model(block, how, start);
  if (const std::string parts = bundle::words_of_parts(model.problem); !parts.empty()) throw std::runtime_error(parts);
  if (!free && model.control_term < 0)
    throw std::runtime_error("no control point is in two images: nothing to register COLMAP's block on");

  Corners corners = corners_of(block, start, model, options.bundle);
  const bundle::State begin = corners.state;
  const BundleSummary summary = adjust_by_colmap(corners.problem, corners.state, options.bundle);
  result.iterations = summary.iterations;
  // COLMAP says "convergence" of what the images do not determine, too.
  const bundle::Layout layout(corners.problem);
  bundle::Elimination elimination(corners.problem, layout);
  if (!elimination.build(corners.state))
    throw std::runtime_error(elimination.undefined() + " cannot be computed from COLMAP's answer");
  const bundle::Datum datum = bundle::inner_datum(corners.problem, layout, bundle::free_motions(corners.problem));
  bundle::require_determined(corners.problem, layout, corners.state, elimination, datum);

  scale_by_tags(model, corners.state);
  if (free)
    move_to_start(begin, corners.state);
  else
    register_on_control(block, start, model, options, corners.state);
  fill_geometry(block, start, model, corners.state, result);
  fill_statistics(corners, layout, elimination, datum.count, result);
  fill_tags(start, corners, layout, result);
  fill_batches(model, corners.state, result);
  fill_control(start, model, result);
  result.weakest_datum_sigma = unknown;
  block::test_groups(block, result);
  return result;
}

}  // namespace plumbline::colmap
