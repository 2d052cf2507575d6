#include "photo/block/tag_block_fill.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/median.hpp"
#include "photo/block/tag_block_orientations.hpp"

namespace plumbline::block {
namespace {

using bundle::Kind;

void fill_statistics(const TagBlockOptions& options, const TagModel& model, Solved& solved, TagBlockResult& result) {
  result.observations = solved.adjusted.rows;
  result.unknowns = solved.adjusted.unknowns;
  result.datum_defect = solved.adjusted.defect;
  result.degrees_of_freedom = solved.adjusted.redundancy();
  result.iterations = solved.adjusted.iterations;
  result.groups = solved.reliability.groups;
  for (const auto& group : result.groups) result.weighted_sum_of_squares += group.sum_of_squares;
  if (result.degrees_of_freedom < 1)
    throw std::runtime_error("the block has no redundancy: nothing checks its observations");
  const double factor = result.weighted_sum_of_squares / result.degrees_of_freedom;
  result.sigma0 = std::sqrt(factor);
  std::erase_if(result.groups, [](const least_squares::VarianceComponent& group) { return group.rows == 0; });
  const double sigma = model.problem.groups[group_images].sigma_factor;
  result.image_variance_factor = sigma * sigma;
  if (options.weighting == TagBlockOptions::Weighting::lambda && options.estimate_image_variance) {
    solved.variance = factor;  // λ fixes the ratio of the two groups: only their common variance can be estimated
    result.image_variance_factor = factor;
  }
}

void fill_poses(const TagBlock& block, const TagStart& start, const TagModel& model, const bundle::Layout& layout,
                const Solved& solved, TagBlockResult& result) {
  result.cam_from_world.resize(block.images.size());
  result.pose_covariance.assign(block.images.size(), Matrix6::Zero());
  if (!model.state.shifts.empty()) result.principal_points.resize(block.images.size());
  for (size_t i = 0; i < start.images.size(); ++i) {
    const size_t image = static_cast<size_t>(start.images[i]);
    const RigidTransform pose = pose_of(model, i);
    result.cam_from_world[image] = pose;
    if (!model.state.shifts.empty()) result.principal_points[image].shift = model.state.shifts[i];
    if (model.problem.images[i].shift_free)
      result.principal_points[image].covariance =
          solved.variance * solved.adjusted.cofactors->own(layout.block({Kind::shift, static_cast<int>(i)}));
    const Matrix6 jacobian = pose_by_unknowns(model, i);
    result.pose_covariance[image] = solved.variance * jacobian *
                                    solved.adjusted.cofactors->own(layout.block({Kind::image, static_cast<int>(i)})) *
                                    jacobian.transpose();
  }
}

std::vector<int> plate_blocks(const TagModel& model, const bundle::Layout& layout) {
  std::vector<int> blocks;
  for (size_t j = 0; j < model.problem.plates.size(); ++j)
    blocks.push_back(layout.block({Kind::plate, static_cast<int>(j)}));
  return blocks;
}

void fill_cameras(const TagBlock& block, const TagModel& model, const bundle::Layout& layout, const Solved& solved,
                  TagBlockResult& result) {
  constexpr int nine = BrownCamera::parameter_count, all = nine + 2;
  std::vector<int> blocks, rows;
  for (int c = 0; c < static_cast<int>(block.cameras.size()); ++c) {
    for (int value : layout.free_values(c)) rows.push_back(all * c + value);
    if (!layout.free_values(c).empty()) blocks.push_back(layout.block({Kind::camera, c}));
  }
  const Eigen::Index size = all * static_cast<Eigen::Index>(block.cameras.size());
  result.interior_covariance = Eigen::MatrixXd::Zero(size, size);
  if (!blocks.empty())
    result.interior_covariance(rows, rows) = solved.variance * solved.adjusted.cofactors->joint(blocks);
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    AdjustedTagCamera camera;
    const auto& values = model.state.interiors[c];
    const bundle::Camera& adjusted = model.problem.cameras[c];
    std::array<double, nine> interior;
    std::copy_n(values.begin(), interior.size(), interior.begin());
    camera.interior = block.cameras[c].interior;
    camera.interior.set_parameters(interior);
    const Eigen::Index at = all * static_cast<Eigen::Index>(c);
    camera.covariance = result.interior_covariance.block<nine, nine>(at, at);
    if ((adjusted.lens == bundle::Lens::brown && (adjusted.free[nine] || adjusted.free[nine + 1])) ||
        !block.cameras[c].distance_terms.isZero(0)) {
      camera.distance_terms = Eigen::Map<const Eigen::Vector2d>(values.data() + nine);
      camera.reference_distance = 1 / adjusted.inverse_reference;
    }
    result.cameras.push_back(camera);
  }
}

void fill_unknowns(const TagStart& start, const TagModel& model, const bundle::Layout& layout, const Solved& solved,
                   TagBlockResult& result) {
  const bundle::Cofactors& cofactors = *solved.adjusted.cofactors;
  result.plates = start.plates;
  std::vector<Eigen::Index> rows;
  result.anchors.resize(3 * static_cast<Eigen::Index>(start.plates.size()));
  for (size_t j = 0; j < start.plates.size(); ++j) {
    result.world_from_plate.push_back(model.state.plates[j].rotation);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(6 * static_cast<Eigen::Index>(j) + c);
    result.anchors.segment<3>(3 * static_cast<Eigen::Index>(j)) = model.state.plates[j].position + model.origin;
  }
  result.anchor_covariance = solved.variance * cofactors.joint(plate_blocks(model, layout))(rows, rows);
  // Batches as they were printed, then the same of each further camera that has insets of its own.
  int last = 0;
  for (const auto& plate : model.problem.plates) last = std::max(last, plate.batch);
  const auto printed = static_cast<size_t>(last) + 1;
  for (size_t b = 0; b < model.problem.batches.size(); ++b) {
    const auto sigma = [&](Kind kind) {
      const int id = layout.block({kind, static_cast<int>(b)});
      return layout.size(id) > 0 ? std::sqrt(solved.variance * cofactors.own(id)(0, 0)) : 0.0;
    };
    result.batches.push_back({model.problem.batches[b].name, model.state.scales[b], sigma(Kind::scale),
                              model.state.insets[b], sigma(Kind::inset), model.problem.batches[b % printed].name,
                              static_cast<int>(b / printed)});
  }
  result.images_per_plate.assign(start.plates.size(), 0);
  for (const auto& term : model.problem.image_tags) ++result.images_per_plate[term.plate];
}

void fill_tags(const TagStart& start, const TagModel& model, const Solved& solved, TagBlockResult& result) {
  const double root = std::sqrt(solved.variance);
  std::vector<std::vector<double>> w_of_plate(start.plates.size());
  for (size_t i = 0; i < model.problem.image_tags.size(); ++i) {
    AdjustedTag tag;
    tag.observation = start.observations[i];
    tag.smallest_redundancy = 1;
    double sum = 0;
    for (const auto& row : solved.reliability.tags[i]) {
      sum += row.residual * row.residual;
      tag.largest_normalised = std::max(tag.largest_normalised, std::abs(row.w) / root);
      tag.smallest_redundancy = std::min(tag.smallest_redundancy, row.redundancy_number);
      tag.largest_detectable_error = std::max(tag.largest_detectable_error, row.mdb * root);
    }
    tag.rms = std::sqrt(sum / 8);
    w_of_plate[model.problem.image_tags[i].plate].push_back(tag.largest_normalised);
    result.tags.push_back(tag);
  }
  for (const auto& w : w_of_plate) result.plate_w.push_back(w.empty() ? 0 : upper_median(w));
}

void fill_control(const TagStart& start, const TagModel& model, const bundle::Layout& layout, const Solved& solved,
                  TagBlockResult& result) {
  if (model.control_term < 0) return;
  const size_t term = static_cast<size_t>(model.control_term);
  const auto& known = model.problem.known[term];
  const bundle::KnownRows rows = bundle::evaluate(model.problem, layout, solved.adjusted.state, known);
  // Change of all heights per unit of error in one control coordinate: Q Aᵀ P e, with whitened rows A' = W A.
  std::vector<Eigen::Index> heights, coordinates;
  for (size_t j = 0; j < start.plates.size(); ++j) heights.push_back(3 * static_cast<Eigen::Index>(j) + 2);
  for (int plate : model.control_plates)
    for (Eigen::Index c = 0; c < 3; ++c) coordinates.push_back(3 * static_cast<Eigen::Index>(plate) + c);
  const Eigen::MatrixXd of_heights = result.anchor_covariance(heights, coordinates) / solved.variance;
  const Eigen::MatrixXd influence = of_heights * rows.jacobian.transpose() * known.whitening;
  const double root = std::sqrt(solved.variance);
  for (size_t k = 0; k < model.control_plates.size(); ++k) {
    AdjustedControl control;
    const size_t plate = static_cast<size_t>(model.control_plates[k]);
    control.plate = start.plates[plate];
    for (size_t c = 0; c < 3; ++c) {
      control.coordinates[c] = solved.reliability.known[term][3 * k + c];
      control.coordinates[c].w /= root;
      control.coordinates[c].mdb *= root;
      control.effect_on_height[c] =
          influence.col(static_cast<Eigen::Index>(3 * k + c)).cwiseAbs().maxCoeff() * control.coordinates[c].mdb;
      result.plate_w[plate] = std::max(result.plate_w[plate], std::abs(control.coordinates[c].w));
    }
    result.control.push_back(control);
  }
}

}  // namespace

void fill_result(const TagBlock& block, const TagBlockOptions& options, const TagStart& start, const TagModel& model,
                 const bundle::Layout& layout, Solved& solved, TagBlockResult& result) {
  fill_statistics(options, model, solved, result);
  fill_poses(block, start, model, layout, solved, result);
  if (options.joint_orientations)
    result.orientation_covariance =
        solved.variance * joint_orientations(start.images, static_cast<int>(block.cameras.size()), model, layout,
                                             *solved.adjusted.cofactors);
  fill_unknowns(start, model, layout, solved, result);
  fill_cameras(block, model, layout, solved, result);
  fill_tags(start, model, solved, result);
  fill_control(start, model, layout, solved, result);
}

}  // namespace plumbline::block
