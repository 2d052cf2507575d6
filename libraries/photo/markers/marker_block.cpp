#include "photo/markers/marker_block.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "geometry/median.hpp"
#include "least_squares/problem/defects.hpp"
#include "photo/block/row_quality.hpp"
#include "photo/markers/marker_adjustment.hpp"
#include "photo/markers/marker_datum.hpp"
#include "photo/markers/marker_model.hpp"
#include "photo/markers/marker_truth.hpp"
#include "photo/markers/marker_words.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

using block::AdjustedBlock;
using block::ObservationRows;
using least_squares::PartitionedSystem;

void require_usable(const MarkerBlock& block) {
  if (block.views.empty()) throw std::runtime_error("no tag was found in any photograph");
  for (const Marker& marker : block.markers)
    if (!(marker.size > 0)) throw std::runtime_error("tag " + marker.name() + " has no size; give tag_size in metres");
  if (block.images.size() < 2 && !has_layout(block))
    throw std::runtime_error(
        "one photograph with tags is not enough: take at least two, better ten, from different "
        "directions");
}

/// Root mean square of the 8 whitened residuals of each view, in the order of state.views.
std::vector<double> misfits(const MarkerModel& model) {
  std::vector<double> rms;
  for (const auto& rows : model.model.linearise().observations)
    if (rows.group == group_refined || rows.group == group_unrefined)
      rms.push_back(rows.misclosure.norm() / std::sqrt(8.0));
  return rms;
}

/// The values of `state` as a start.
MarkerStart start_of(const MarkerBlock& block, const MarkerState& state, const MarkerStart& before) {
  MarkerStart start = before;
  start.cam_from_world.assign(block.images.size(), std::nullopt);
  start.world_from_tag.assign(block.markers.size(), std::nullopt);
  for (size_t c = 0; c < state.interiors.size(); ++c) start.cameras[c].set_parameters(state.interiors[c]);
  for (size_t i = 0; i < state.images.size(); ++i) {
    const Eigen::Vector3d centre(state.poses[i][0], state.poses[i][1], state.poses[i][2]);
    start.cam_from_world[static_cast<size_t>(state.images[i])] =
        RigidTransform{state.cam_from_world[i], -(state.cam_from_world[i] * centre)};
  }
  for (size_t j = 0; j < state.markers.size(); ++j)
    start.world_from_tag[static_cast<size_t>(state.markers[j])] =
        RigidTransform{state.world_from_tag[j], Eigen::Map<const Eigen::Vector3d>(state.centres[j].data())};
  return start;
}

/// Views whose tag lies behind its camera at the start cannot take part.
std::vector<bool> drop_impossible(const MarkerBlock& block, const MarkerStart& start, std::vector<bool> use) {
  for (size_t v = 0; v < block.views.size(); ++v) {
    const MarkerView& view = block.views[v];
    const auto& image = start.cam_from_world[static_cast<size_t>(view.image)];
    const auto& tag = start.world_from_tag[static_cast<size_t>(view.marker)];
    if (!use[v] || !image || !tag) continue;
    const double size = block.markers[static_cast<size_t>(view.marker)].size;
    if ((*image * tag->translation).z() < size) use[v] = false;
  }
  return use;
}

/// A start that was minimised robustly, and how well it fits.
struct Trial {
  MarkerStart start;
  std::vector<bool> use;
  double score = std::numeric_limits<double>::infinity();  ///< mean bounded misfit of all views
  double median_pixels = std::numeric_limits<double>::infinity();
};

double root_mean_square(const MarkerBlock& block, const MarkerState& state, size_t k, double misfit) {
  const MarkerView& view = block.views[static_cast<size_t>(state.views[k])];
  double variance = 0;
  for (const auto& c : view.covariances) variance += 0.125 * c.trace();
  return misfit * std::sqrt(variance);
}

Trial minimised(const MarkerBlock& block, const MarkerOptions& options, const MarkerStart& start,
                const std::vector<bool>& use, int iterations) {
  Trial trial{start, drop_impossible(block, start, use)};
  MarkerState state;
  fill_state(block, start, trial.use, state);
  if (state.views.empty()) return trial;
  MarkerModel model;
  build_model(block, options, state, model);
  double unit = 5;
  for (int pass = 0; pass < 2; ++pass) {
    model.model.minimise(iterations, {bundle::Loss::Kind::huber, 2 * std::sqrt(8.0) * unit});
    state.fold();
    unit = std::max(1.0, upper_median(misfits(model)));
  }
  const std::vector<double> fits = misfits(model);
  std::vector<double> pixels;
  double bounded = static_cast<double>(block.views.size() - fits.size());
  const double bound = 0.005 * std::max(block.cameras.front().camera.width, block.cameras.front().camera.height);
  for (size_t k = 0; k < fits.size(); ++k) {
    pixels.push_back(root_mean_square(block, state, k, fits[k]));
    const double e = pixels.back() * pixels.back() / (bound * bound);
    bounded += e / (1 + e);
  }
  trial.score = bounded / static_cast<double>(block.views.size());
  trial.median_pixels = upper_median(pixels);
  trial.start = start_of(block, state, start);
  return trial;
}

/// Principal distances that are tried for cameras that come with none: what the tags' shapes say, and lenses from wide
/// to tele.
std::vector<std::vector<BrownCamera>> camera_candidates(const MarkerBlock& block) {
  std::vector<std::vector<BrownCamera>> candidates;
  for (const double factor : {0.0, 0.8, 1.2, 2.0, 0.55, 3.5}) {
    std::vector<BrownCamera> cameras;
    bool unknown = false;
    for (size_t c = 0; c < block.cameras.size(); ++c) {
      BrownCamera camera = block.cameras[c].camera;
      if (!(camera.fx > 0)) {
        unknown = true;
        const double extent = std::max(camera.width, camera.height);
        double f = factor > 0 ? factor * extent : focal_length_from_tags(block, static_cast<int>(c));
        if (!(f > 0.4 * extent && f < 8 * extent)) f = 1.2 * extent;
        camera.fx = camera.fy = f;
        camera.cx = 0.5 * (camera.width - 1), camera.cy = 0.5 * (camera.height - 1);
      }
      cameras.push_back(camera);
    }
    candidates.push_back(cameras);
    if (!unknown) break;
  }
  return candidates;
}

Trial best_start(const MarkerBlock& block, MarkerOptions options) {
  options.shape_sigma = options.twist_sigma = 0;
  const std::vector<bool> all(block.views.size(), true);
  Trial best;
  for (const auto& cameras : camera_candidates(block)) {
    const MarkerStart start = start_marker_block(block, cameras, all);
    if (start.placed == 0) continue;
    Trial trial = minimised(block, options, start, all, 30);
    // A tag that was placed turned over, or an image from one tag alone, shows now that lens and tags are better known.
    const MarkerStart improved = improve_start(block, trial.start, all);
    if (improved.placed > start.placed || improved.cost < trial.start.cost) {
      Trial again = minimised(block, options, improved, all, 30);
      if (again.score < trial.score) trial = again;
    }
    if (trial.score < best.score) best = trial;
    const BrownCamera& camera = cameras.front();
    if (best.score < 0.1 && best.median_pixels < 1e-3 * std::max(camera.width, camera.height)) break;
  }
  if (!std::isfinite(best.score))
    throw std::runtime_error(
        "no photograph could be connected to another: every tag is seen in one photograph only, or "
        "the corners are no squares. Take photographs that share tags");
  return best;
}

/// Everything of one adjustment that the results are read from.
struct Run {
  MarkerState state;
  MarkerModel model;
  AdjustedBlock block;
  std::vector<Eigen::MatrixXd> cofactors;
};

void find_blunders(const MarkerBlock& block, const MarkerOptions& options, Trial& trial, MarkerResult& result) {
  MarkerState state;
  fill_state(block, trial.start, trial.use, state);
  MarkerModel model;
  build_model(block, options, state, model);
  double unit = std::max(1.0, upper_median(misfits(model)));
  for (int pass = 0; pass < 2; ++pass) {
    model.model.minimise(options.max_iterations, {bundle::Loss::Kind::huber, 2 * std::sqrt(8.0) * unit});
    state.fold();
    unit = std::max(1.0, upper_median(misfits(model)));
  }
  const std::vector<double> fits = misfits(model);
  trial.start = start_of(block, state, trial.start);
  for (size_t v = 0; v < trial.use.size(); ++v)
    if (!trial.use[v]) result.rejected.push_back(static_cast<int>(v));
  for (size_t k = 0; k < fits.size(); ++k)
    if (options.reject_above > 0 && fits[k] > options.reject_above * unit) {
      trial.use[static_cast<size_t>(state.views[k])] = false;
      result.rejected.push_back(state.views[k]);
    }
  std::sort(result.rejected.begin(), result.rejected.end());
}

void run_adjustment(const MarkerBlock& block, const MarkerOptions& options, const Trial& trial, Run& run,
                    MarkerResult& result) {
  constexpr int max_variance_steps = 6;
  const bool free_network = !has_layout(block);
  fill_state(block, trial.start, trial.use, run.state);
  build_model(block, options, run.state, run.model);
  std::vector<std::string> names;
  for (const int i : run.state.images) names.push_back(block.images[static_cast<size_t>(i)].path);
  std::vector<least_squares::VarianceComponent> groups;
  for (int step = 0; step < max_variance_steps; ++step) {
    run.block = block::adjust_to_convergence(
        run.model.model, options.max_iterations, [&] { run.state.fold(); },
        [&](PartitionedSystem& linear) {
          if (!free_network) return;
          linear.null_space = free_motions(run.state, run.model);
          linear.datum_unknowns = datum_columns(block, run.state, run.model);
        },
        [&](const PartitionedSystem& linear, const least_squares::ReducedSystem& reduced) {
          least_squares::require_full_rank(linear, reduced, names, run.model.model.kept_labels());
        });
    run.cofactors = residual_cofactors(run.block.linear, run.block.reduced, run.block.solution);
    groups = variance_components(run.block.linear, run.cofactors);
    if (step + 1 == max_variance_steps) break;
    double change = 0;
    for (const size_t g : {size_t{0}, size_t{1}}) {
      if (groups[g].rows == 0 || !(groups[g].redundancy > 1) || !(groups[g].factor > 0)) continue;
      const double before = run.state.sigma_factors[g];
      run.state.sigma_factors[g] = std::clamp(before * std::sqrt(groups[g].factor), 0.05, 1000.0);
      change = std::max(change, std::abs(run.state.sigma_factors[g] / before - 1));
    }
    if (change < 0.005) break;
  }
  result.observations = run.block.linear.row_count();
  result.unknowns = run.block.linear.unknown_count();
  result.datum_defect = run.block.linear.defect();
  result.degrees_of_freedom = run.block.linear.redundancy();
  if (result.degrees_of_freedom < 1)
    throw std::runtime_error(
        "the block has no redundancy: nothing checks its observations. Take more photographs that "
        "share tags");
  for (const auto& group : groups) result.weighted_sum_of_squares += group.sum_of_squares;
  result.sigma0 = std::sqrt(result.weighted_sum_of_squares / result.degrees_of_freedom);
  for (const size_t g : {size_t{0}, size_t{1}}) groups[g].factor *= std::pow(run.state.sigma_factors[g], 2);
  std::erase_if(groups, [](const auto& group) { return group.rows == 0; });
  result.groups = groups;
}

/// The adjustment, whose failure says what these photographs lack.
void run_or_explain(const MarkerBlock& block, const MarkerOptions& options, const Trial& trial, Run& run,
                    MarkerResult& result) {
  try {
    run_adjustment(block, options, trial, run, result);
  } catch (const Stopped&) {
    throw;
  } catch (const std::runtime_error& error) {
    const bool self_calibration = std::any_of(block.cameras.begin(), block.cameras.end(), [](const MarkerCamera& c) {
      return !c.held && c.covariance.size() == 0;
    });
    if (!self_calibration) throw;
    throw std::runtime_error(
        std::to_string(block.images.size()) + " photographs with " + std::to_string(block.markers.size()) +
        (block.markers.size() == 1 ? " tag" : " tags") + ", " +
        text::format_fixed(static_cast<double>(block.views.size()) / static_cast<double>(block.images.size()), 1) +
        " in each on the average, do not calibrate " + std::to_string(block.cameras.size()) +
        (block.cameras.size() == 1 ? " camera" : " cameras") +
        ". Photograph several tags together, from several directions, tilted; or calibrate the camera on a board "
        "(calibrate_camera) and orient with marker_field; if several cameras are in one folder, cameras=by_name tells "
        "them by the names of their files; fixed cameras before one moving tag: a layout of that tag alone for "
        "marker_field. In detail: " +
        error.what());
  }
}

/// An inset that is not significant is set to zero, but its uncertainty stays in all covariances: with one distance it
/// cannot be told from the size of the tags, and half a millimetre in ten metres hangs on 0.01 px of it.
void drop_insignificant_insets(const MarkerBlock& block, const MarkerOptions& options, const Trial& trial, Run& run) {
  constexpr double always_significant = 0.1;  // [px]
  for (size_t c = 0; c < run.model.inset_columns.size(); ++c) {
    const int column = run.model.inset_columns[c];
    if (column < 0) continue;
    const double sigma = std::sqrt(run.block.solution.kept_cofactor(column, column));
    if (std::abs(run.state.insets[c]) > std::min(3 * sigma, always_significant)) return;
  }
  if (!(options.inset_sigma > 0)) return;
  MarkerOptions without = options;
  without.inset_sigma = 0;
  Run held;
  MarkerResult unused;
  Trial from = trial;
  from.start = start_of(block, run.state, trial.start);
  run_adjustment(block, without, from, held, unused);
  run.state.poses = held.state.poses, run.state.cam_from_world = held.state.cam_from_world;
  run.state.camera_matrices = held.state.camera_matrices;
  run.state.centres = held.state.centres, run.state.turns = held.state.turns;
  run.state.world_from_tag = held.state.world_from_tag, run.state.tag_matrices = held.state.tag_matrices;
  run.state.scales = held.state.scales, run.state.shapes = held.state.shapes,
  run.state.interiors = held.state.interiors, run.state.insets = held.state.insets;
  run.block.linear.observations = run.model.model.linearise().observations;
}

void fill_cameras(const MarkerBlock& block, const Run& run, MarkerResult& result) {
  const Eigen::MatrixXd& cofactor = run.block.solution.kept_cofactor;
  constexpr int count = BrownCamera::parameter_count;
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    AdjustedMarkerCamera camera;
    camera.camera = block.cameras[c].camera;
    camera.camera.set_parameters(run.state.interiors[c]);
    camera.covariance = Eigen::MatrixXd::Zero(count, count);
    const auto& columns = run.model.interior_columns[c];
    for (int r = 0; r < count; ++r)
      for (int k = 0; k < count; ++k)
        if (columns[static_cast<size_t>(r)] >= 0 && columns[static_cast<size_t>(k)] >= 0)
          camera.covariance(r, k) = cofactor(columns[static_cast<size_t>(r)], columns[static_cast<size_t>(k)]);
    camera.inset = run.state.insets[c];
    if (const int column = run.model.inset_columns[c]; column >= 0)
      camera.inset_sigma = std::sqrt(cofactor(column, column));
    for (const int i : run.state.images)
      camera.images += block.images[static_cast<size_t>(i)].camera == static_cast<int>(c);
    result.cameras.push_back(camera);
  }
}

void fill_markers(const MarkerBlock& block, const Run& run, MarkerResult& result) {
  const Eigen::MatrixXd& cofactor = run.block.solution.kept_cofactor;
  std::vector<int> columns;
  std::vector<int> images(block.markers.size(), 0);
  for (const int v : run.state.views) ++images[static_cast<size_t>(block.views[static_cast<size_t>(v)].marker)];
  for (size_t j = 0; j < run.state.markers.size(); ++j) {
    AdjustedMarker marker;
    marker.marker = run.state.markers[j];
    marker.world_from_tag = {run.state.world_from_tag[j],
                             Eigen::Map<const Eigen::Vector3d>(run.state.centres[j].data())};
    marker.scale = run.state.scales[j];
    if (const int column = run.model.scale_columns[j]; column >= 0)
      marker.scale_sigma = std::sqrt(cofactor(column, column));
    marker.shape = run.state.shapes[j];
    const double half = 0.5 * block.markers[static_cast<size_t>(marker.marker)].size * marker.scale;
    marker.corners = shaped_corners(half, marker.shape.data());
    for (Eigen::Vector3d& corner : marker.corners) corner = marker.world_from_tag * corner;
    marker.centre_covariance = cofactor.block<3, 3>(run.model.centre_columns[j], run.model.centre_columns[j]);
    marker.rotation_covariance = cofactor.block<3, 3>(run.model.turn_columns[j], run.model.turn_columns[j]);
    marker.images = images[static_cast<size_t>(marker.marker)];
    for (int c = 0; c < 3; ++c) columns.push_back(run.model.centre_columns[j] + c);
    result.markers.push_back(marker);
  }
  result.centre_covariance = cofactor(columns, columns);
}

void fill_images(const MarkerBlock& block, const Run& run, MarkerResult& result) {
  result.images.resize(block.images.size());
  for (size_t i = 0; i < result.images.size(); ++i) result.images[i].image = static_cast<int>(i);
  for (size_t i = 0; i < run.state.images.size(); ++i) {
    AdjustedMarkerImage& image = result.images[static_cast<size_t>(run.state.images[i])];
    image.oriented = true;
    image.centre = {run.state.poses[i][0], run.state.poses[i][1], run.state.poses[i][2]};
    image.cam_from_world = {run.state.cam_from_world[i], -(run.state.cam_from_world[i] * image.centre)};
    image.covariance = run.block.solution.eliminated_cofactor[i];
  }
}

void fill_views(const MarkerBlock& block, const Run& run, MarkerResult& result) {
  std::vector<double> camera_squares(block.cameras.size(), 0);
  double squares = 0;
  for (size_t k = 0; k < run.block.linear.observations.size(); ++k) {
    const ObservationRows& rows = run.block.linear.observations[k];
    if (rows.group != group_refined && rows.group != group_unrefined) continue;
    AdjustedMarkerView seen;
    seen.view = run.state.views[static_cast<size_t>(rows.label)];
    const MarkerView& view = block.views[static_cast<size_t>(seen.view)];
    const Eigen::MatrixXd root = run.state.sigma_factors[view.refined ? 0 : 1] * view_root(view);
    const auto quality = block::row_quality(root, rows, run.cofactors[k]);
    double sum = 0;
    for (size_t r = 0; r < 8; ++r) {
      seen.residuals[r / 2](static_cast<Eigen::Index>(r % 2)) = -quality[r].residual;
      sum += quality[r].residual * quality[r].residual;
      seen.largest_w = std::max(seen.largest_w, std::abs(quality[r].w));
      seen.smallest_redundancy = std::min(seen.smallest_redundancy, quality[r].redundancy_number);
    }
    seen.rms = std::sqrt(sum / 8);
    squares += sum;
    AdjustedMarkerImage& image = result.images[static_cast<size_t>(view.image)];
    ++image.tags, image.rms += sum / 8;
    const size_t c = static_cast<size_t>(block.images[static_cast<size_t>(view.image)].camera);
    ++result.cameras[c].views, camera_squares[c] += sum / 8;
    result.views.push_back(seen);
  }
  for (auto& image : result.images)
    if (image.tags) image.rms = std::sqrt(image.rms / image.tags);
  for (size_t c = 0; c < camera_squares.size(); ++c)
    if (result.cameras[c].views) result.cameras[c].rms = std::sqrt(camera_squares[c] / result.cameras[c].views);
  result.rms = std::sqrt(squares / (8.0 * static_cast<double>(std::max<size_t>(1, result.views.size()))));
}

}  // namespace

MarkerResult adjust_as_given(const MarkerBlock& block, const MarkerOptions& options) {
  require_usable(block);
  MarkerResult result;
  Trial trial = best_start(block, options);
  find_blunders(block, options, trial, result);
  Run run;
  run_or_explain(block, options, trial, run, result);
  drop_insignificant_insets(block, options, trial, run);
  fill_cameras(block, run, result);
  judge_cameras(block, run.state, run.model, run.block, result);
  fill_markers(block, run, result);
  fill_images(block, run, result);
  fill_views(block, run, result);
  if (options.distance) scale_by_distance(block, *options.distance, result);
  if (has_layout(block)) {
    result.datum = "the layout's places of the tags, with their standard deviations";
  } else {
    to_first_tag(block, in_one_line(block, run.state), result);
    state_scale(block, options, result);
  }
  warn_about_variance(result);
  explain_images(block, result);
  explain_single_tags(block, result);
  warn_about_calibrations(block, result);
  warn_about_weak(block, result);
  return result;
}

}  // namespace plumbline::markers
