#include "block/tag_block.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "block/row_quality.hpp"
#include "block/tag_block_model.hpp"
#include "geometry/similarity.hpp"

namespace plumbline::adjust {
namespace {

void require_usable(const TagBlock& block, const TagBlockOptions& options) {
  if (block.images.size() < 2)
    throw std::runtime_error("a block needs at least 2 images, this one has " + std::to_string(block.images.size()));
  if (block.observations.empty()) throw std::runtime_error("no image shows a tag of a known plate");
  if (options.weighting == TagBlockOptions::Weighting::lambda && !(options.lambda > 0 && options.corner_sigma > 0))
    throw std::runtime_error("lambda weighting needs lambda > 0 [px^2/m^2] and corner_sigma > 0 [px]");
  for (const auto& plate : block.plates)
    if (!(plate.plate.tag_size > 0)) throw std::runtime_error("the plate of " + plate.anchor + " has no tag size");
}

bool scale_is_unknown(const TagModel& model) {
  return std::any_of(model.scale_columns.begin(), model.scale_columns.end(), [](int column) { return column >= 0; });
}

/// What control and priors say about the similarity motions of the block; images say nothing about them.
DatumAnalysis analyse_control(const TagBlock& block, const TagBlockOptions& options, const TagState& state,
                              const TagModel& model) {
  // Where the survey has them: approximate values off by a centimetre would turn a straight line of control into a
  // plane.
  TagState surveyed = state;
  for (size_t k = 0; k < block.control.plates.size(); ++k) {
    const auto at = std::find(state.plates.begin(), state.plates.end(), block.control.plates[k]);
    if (at != state.plates.end())
      surveyed.anchors[static_cast<size_t>(at - state.plates.begin())] =
          block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)) - state.origin;
  }
  const Eigen::MatrixXd motions = kept_motions(block, surveyed, model);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(motion_count, motion_count);
  for (const auto& rows : model.model.linearise().observations) {
    if (rows.group == group_images) continue;
    const Eigen::MatrixXd moved = rows.kept * motions(rows.columns, Eigen::all);
    information += moved.transpose() * moved;
  }
  std::vector<NamedPoint> anchors, fixed;
  for (size_t j = 0; j < state.anchors.size(); ++j)
    anchors.push_back({block.plates[static_cast<size_t>(state.plates[j])].anchor, surveyed.anchors[j] + state.origin});
  for (int j : model.control_plates) fixed.push_back(anchors[static_cast<size_t>(j)]);
  return analyse_datum(information, anchors, fixed, scale_is_unknown(model), options.weak_ratio);
}

void require_datum(const TagBlock& block, const TagBlockOptions& options, const TagState& state, const TagModel& model,
                   TagBlockResult& result) {
  if (options.free_network) return;
  const DatumAnalysis datum = analyse_control(block, options, state, model);
  if (!datum.undetermined.empty())
    throw std::runtime_error(
        "the control leaves " + enumerate(datum.undetermined) + " of the block undetermined: " +
        std::to_string(model.control_plates.size()) + " of " + std::to_string(state.plates.size()) +
        " anchors in the images are control; add control that is not on one line, or adjust a free network");
  result.weak_datum = datum.weak;
  result.weakest_datum_sigma = datum.weakest_sigma;
}

/// Inner constraints over all anchors. Scale is part of the datum unless a prior or a held tag size gives it.
void set_free_datum(const TagBlock& block, const TagBlockOptions& options, const TagState& state, const TagModel& model,
                    PartitionedSystem& linear) {
  if (!options.free_network) return;
  const bool free_scale = scale_is_unknown(model) && std::isinf(options.tag_scale_sigma);
  linear.null_space = kept_motions(block, state, model).leftCols(free_scale ? motion_count : motion_count - 1);
  linear.datum_unknowns.clear();
  for (int column : model.anchor_columns)
    for (int c = 0; c < 3; ++c) linear.datum_unknowns.push_back(column + c);
}

/// Carries a free network back to where its tags were first placed; see fit_similarity().
void restore_free_datum(const TagBlock& block, const TagBlockOptions& options, TagState& state) {
  if (!options.free_network || state.plates.size() < 3) return;
  std::vector<Eigen::Vector3d> tags;
  for (size_t j = 0; j < state.plates.size(); ++j) tags.push_back(state.tag_centre(block, j));
  const bool free_scale = std::isinf(options.tag_scale_sigma);
  const SimilarityMotion motion = fit_similarity(tags, state.start, free_scale);
  for (size_t j = 0; j < state.plates.size(); ++j) {
    state.local_from_plate[j] = (motion.rotation * state.local_from_plate[j]).normalized();
    state.plate_matrices[j] = state.local_from_plate[j].toRotationMatrix();
    const auto& centre = block.plates[static_cast<size_t>(state.plates[j])].plate.tag_centre_in_plate;
    state.anchors[j] = motion * tags[j] - state.plate_matrices[j] * centre;
  }
  for (size_t i = 0; i < state.poses.size(); ++i) {
    const Eigen::Vector3d centre = motion * Eigen::Vector3d(state.poses[i][0], state.poses[i][1], state.poses[i][2]);
    std::copy(centre.data(), centre.data() + 3, state.poses[i].begin());
    state.cam_from_local[i] = (state.cam_from_local[i] * motion.rotation.conjugate()).normalized();
    state.camera_matrices[i] = state.cam_from_local[i].toRotationMatrix();
  }
  for (double& scale : state.scales) scale *= motion.scale;
}

/// Root mean square of the 8 whitened residuals of each of state.observations.
std::vector<double> tag_misfits(const TagModel& model) {
  std::vector<double> rms;
  for (const auto& rows : model.model.linearise().observations)
    if (rows.group == group_images) rms.push_back(rows.misclosure.norm() / std::sqrt(8.0));
  return rms;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Finds blunders: a robust adjustment, then every tag whose residuals stand out. The yardstick is the median tag, not
/// the a priori standard deviation: detectors' covariances may be wrong by a factor.
std::vector<int> find_blunders(const TagBlockOptions& options, TagState& state, TagModel& model) {
  std::vector<int> blunders;
  if (options.loss == RobustLoss::none) return blunders;
  double unit = 1;
  for (int pass = 0; pass < 2; ++pass) {
    model.model.minimise(options.max_iterations, options.loss, options.loss_scale * std::sqrt(8.0) * unit);
    state.fold();
    unit = std::max(1.0, median(tag_misfits(model)));
  }
  const std::vector<double> misfits = tag_misfits(model);
  for (size_t i = 0; i < misfits.size(); ++i)
    if (options.reject_above > 0 && misfits[i] > options.reject_above * unit) blunders.push_back(state.observations[i]);
  return blunders;
}

/// The block with the poses of `state` as approximate ones.
TagBlock with_poses(const TagBlock& block, const TagState& state) {
  TagBlock result = block;
  for (size_t i = 0; i < state.images.size(); ++i) {
    const Eigen::Vector3d centre =
        Eigen::Vector3d(state.poses[i][0], state.poses[i][1], state.poses[i][2]) + state.origin;
    result.images[static_cast<size_t>(state.images[i])].cam_from_world =
        RigidTransform{state.cam_from_local[i], -(state.cam_from_local[i] * centre)};
  }
  return result;
}

struct Adjusted {
  AdjustedBlock block;
  std::vector<Eigen::MatrixXd> cofactors;
  double variance = 1;  ///< what cofactors are multiplied by to give covariances
};

Adjusted run(const TagBlock& block, const TagBlockOptions& options, TagState& state, TagModel& model,
             TagBlockResult& result) {
  constexpr int max_variance_steps = 5;
  std::vector<std::string> names;
  for (int i : state.images) names.push_back(block.images[static_cast<size_t>(i)].name);
  const bool by_lambda = options.weighting == TagBlockOptions::Weighting::lambda;
  Adjusted adjusted;
  for (int step = 0; step < max_variance_steps; ++step) {
    adjusted.block = adjust_to_convergence(
        model.model, options.max_iterations,
        [&] {
          state.fold();
          restore_free_datum(block, options, state);
        },
        [&](PartitionedSystem& linear) { set_free_datum(block, options, state, model, linear); },
        [&](const PartitionedSystem& linear, const ReducedSystem& reduced) {
          require_full_rank(linear, reduced, names, model.model.kept_labels());
        });
    adjusted.cofactors = residual_cofactors(adjusted.block.linear, adjusted.block.reduced, adjusted.block.solution);
    result.groups = variance_components(adjusted.block.linear, adjusted.cofactors);
    const double factor = result.groups[group_images].factor;
    if (!options.estimate_image_variance || by_lambda || !(factor > 0) || std::abs(factor - 1) < 0.01) break;
    // No detector is 20 times better or 1000 times worse than it says; without this, a block without noise would run
    // away.
    const double next = std::clamp(state.image_sigma_factor * std::sqrt(factor), 0.05, 1000.0);
    if (next == state.image_sigma_factor || step + 1 == max_variance_steps) break;
    state.image_sigma_factor = next;
  }
  return adjusted;
}

void fill_statistics(const TagBlockOptions& options, const TagState& state, Adjusted& adjusted,
                     TagBlockResult& result) {
  const PartitionedSystem& linear = adjusted.block.linear;
  result.observations = linear.row_count();
  result.unknowns = linear.unknown_count();
  result.datum_defect = linear.defect();
  result.degrees_of_freedom = linear.redundancy();
  result.iterations = adjusted.block.iterations;
  for (const auto& group : result.groups) result.weighted_sum_of_squares += group.sum_of_squares;
  if (result.degrees_of_freedom < 1)
    throw std::runtime_error("the block has no redundancy: nothing checks its observations");
  const double factor = result.weighted_sum_of_squares / result.degrees_of_freedom;
  result.sigma0 = std::sqrt(factor);
  std::erase_if(result.groups, [](const adjustment::VarianceComponent& group) { return group.rows == 0; });
  result.image_variance_factor = state.image_sigma_factor * state.image_sigma_factor;
  if (options.weighting == TagBlockOptions::Weighting::lambda && options.estimate_image_variance) {
    adjusted.variance = factor;  // λ fixes the ratio of the two groups: only their common variance can be estimated
    result.image_variance_factor = factor;
  }
}

void fill_poses(const TagBlock& block, const TagState& state, const Adjusted& adjusted, TagBlockResult& result) {
  result.cam_from_world.resize(block.images.size());
  result.pose_covariance.assign(block.images.size(), Matrix6::Zero());
  const TagBlock posed = with_poses(block, state);
  for (size_t i = 0; i < state.images.size(); ++i) {
    const size_t image = static_cast<size_t>(state.images[i]);
    const RigidTransform& pose = *(result.cam_from_world[image] = posed.images[image].cam_from_world);
    // Unknowns are (projection centre C, rotation vector δ), t = −exp(δ) R C: dt = −R dC − [t]× δ.
    Matrix6 jacobian = Matrix6::Zero();
    jacobian.topRightCorner<3, 3>().setIdentity();
    jacobian.bottomLeftCorner<3, 3>() = -state.camera_matrices[i];
    jacobian.bottomRightCorner<3, 3>() = -skew(pose.translation);
    result.pose_covariance[image] =
        adjusted.variance * jacobian * adjusted.block.solution.eliminated_cofactor[i] * jacobian.transpose();
  }
}

void fill_unknowns(const TagBlock& block, const TagState& state, const TagModel& model, const Adjusted& adjusted,
                   TagBlockResult& result) {
  const Eigen::MatrixXd covariance = adjusted.variance * adjusted.block.solution.kept_cofactor;
  result.plates = state.plates;
  result.world_from_plate = state.local_from_plate;
  std::vector<int> columns;
  result.anchors.resize(3 * static_cast<Eigen::Index>(state.plates.size()));
  for (size_t j = 0; j < state.plates.size(); ++j) {
    for (int c = 0; c < 3; ++c) columns.push_back(model.anchor_columns[j] + c);
    result.anchors.segment<3>(3 * static_cast<Eigen::Index>(j)) = state.anchors[j] + state.origin;
  }
  result.anchor_covariance = covariance(columns, columns);
  result.camera = block.camera;
  result.camera.set_parameters(state.interior);
  result.camera_covariance = Eigen::MatrixXd::Zero(BrownCamera::parameter_count, BrownCamera::parameter_count);
  for (int r = 0; r < BrownCamera::parameter_count; ++r)
    for (int c = 0; c < BrownCamera::parameter_count; ++c) {
      const int row = model.interior_columns[static_cast<size_t>(r)],
                column = model.interior_columns[static_cast<size_t>(c)];
      if (row >= 0 && column >= 0) result.camera_covariance(r, c) = covariance(row, column);
    }
  const auto sigma = [&](int column) { return column >= 0 ? std::sqrt(covariance(column, column)) : 0.0; };
  for (size_t b = 0; b < state.scales.size(); ++b)
    result.batches.push_back({state.batch_names[b], state.scales[b], sigma(model.scale_columns[b]), state.insets[b],
                              sigma(model.inset_columns[b])});
  result.images_per_plate.assign(state.plates.size(), 0);
  for (int o : state.observations) {
    const auto at =
        std::find(state.plates.begin(), state.plates.end(), block.observations[static_cast<size_t>(o)].plate);
    ++result.images_per_plate[static_cast<size_t>(at - state.plates.begin())];
  }
}

AdjustedTag describe_tag(const TagBlock& block, const TagBlockOptions& options, const TagState& state,
                         const ObservationRows& rows, const Eigen::MatrixXd& cofactor, double variance) {
  AdjustedTag tag;
  tag.observation = state.observations[static_cast<size_t>(rows.label)];
  const Eigen::MatrixXd root =
      state.image_sigma_factor * corner_root(block.observations[static_cast<size_t>(tag.observation)], options);
  tag.smallest_redundancy = 1;
  double sum = 0;
  for (const auto& r : row_quality(root, rows, cofactor)) {
    sum += r.residual * r.residual;
    tag.largest_normalised = std::max(tag.largest_normalised, std::abs(r.w) / std::sqrt(variance));
    tag.smallest_redundancy = std::min(tag.smallest_redundancy, r.redundancy_number);
    tag.largest_detectable_error = std::max(tag.largest_detectable_error, r.mdb * std::sqrt(variance));
  }
  tag.rms = std::sqrt(sum / 8);
  return tag;
}

void describe_control(const TagState& state, const TagModel& model, const Adjusted& adjusted,
                      const ObservationRows& rows, const Eigen::MatrixXd& cofactor, TagBlockResult& result) {
  const auto quality = row_quality(model.control_root, rows, cofactor);
  // Change of all unknowns per unit of error in one control coordinate: Q Aᵀ P e, with whitened rows Q A'ᵀ L⁻¹.
  const Eigen::MatrixXd inverse = model.control_root.triangularView<Eigen::Lower>().solve(
      Eigen::MatrixXd::Identity(model.control_root.rows(), model.control_root.cols()));
  const Eigen::MatrixXd influence =
      adjusted.block.solution.kept_cofactor(Eigen::all, rows.columns) * rows.kept.transpose() * inverse;
  for (size_t k = 0; k < model.control_plates.size(); ++k) {
    AdjustedControl control;
    control.plate = state.plates[static_cast<size_t>(model.control_plates[k])];
    for (size_t c = 0; c < 3; ++c) {
      control.coordinates[c] = quality[3 * k + c];
      control.coordinates[c].w /= std::sqrt(adjusted.variance);
      control.coordinates[c].mdb *= std::sqrt(adjusted.variance);
      double largest = 0;
      for (int column : model.anchor_columns)
        largest = std::max(largest, std::abs(influence(column + 2, static_cast<Eigen::Index>(3 * k + c))));
      control.effect_on_height[c] = largest * control.coordinates[c].mdb;
    }
    result.control.push_back(control);
  }
}

void fill_reliability(const TagBlock& block, const TagBlockOptions& options, const TagState& state,
                      const TagModel& model, const Adjusted& adjusted, TagBlockResult& result) {
  for (size_t i = 0; i < adjusted.block.linear.observations.size(); ++i) {
    const ObservationRows& rows = adjusted.block.linear.observations[i];
    if (rows.group == group_images)
      result.tags.push_back(describe_tag(block, options, state, rows, adjusted.cofactors[i], adjusted.variance));
    if (rows.group == group_control) describe_control(state, model, adjusted, rows, adjusted.cofactors[i], result);
  }
}

}  // namespace

TagBlockResult adjust_tag_block(const TagBlock& given, const TagBlockOptions& options) {
  require_usable(given, options);
  TagBlockResult result;
  std::vector<bool> use(given.observations.size(), true);
  TagBlock block = given;
  std::vector<std::string> left_out;
  TagState state = start_tag_block(block, use, left_out);
  TagModel model = build_tag_model(block, options, state);
  require_datum(block, options, state, model, result);
  result.rejected = find_blunders(options, state, model);
  if (!result.rejected.empty()) {
    for (int o : result.rejected) use[static_cast<size_t>(o)] = false;
    block = with_poses(block, state);
    left_out.clear();
    state = start_tag_block(block, use, left_out);
    model = build_tag_model(block, options, state);
    require_datum(block, options, state, model, result);
  }
  result.left_out = left_out;
  Adjusted adjusted = run(block, options, state, model, result);
  fill_statistics(options, state, adjusted, result);
  fill_poses(block, state, adjusted, result);
  fill_unknowns(block, state, model, adjusted, result);
  fill_reliability(block, options, state, model, adjusted, result);
  return result;
}

}  // namespace plumbline::adjust
