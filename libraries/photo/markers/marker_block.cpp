#include "photo/markers/marker_block.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "base/text/text.hpp"
#include "geometry/median.hpp"
#include "photo/bundle/adjust.hpp"
#include "photo/markers/marker_adjustment.hpp"
#include "photo/markers/marker_datum.hpp"
#include "photo/markers/marker_model.hpp"
#include "photo/markers/marker_truth.hpp"
#include "photo/markers/marker_words.hpp"
#include "photo/markers/tag_places.hpp"

namespace plumbline::markers {
namespace {

void require_usable(const MarkerBlock& block) {
  if (block.views.empty()) throw std::runtime_error("no tag was found in any photograph");
  for (const Marker& marker : block.markers)
    if (!(marker.size > 0)) throw std::runtime_error("tag " + marker.name() + " has no size; give tag_size in metres");
  if (block.images.size() < 2 && !has_layout(block))
    throw std::runtime_error(
        "one photograph with tags is not enough: take at least two, better ten, from different "
        "directions");
}

/// Root mean square of the 8 whitened residuals of each view, in the order of model.views.
std::vector<double> misfits(const MarkerModel& model) {
  const bundle::Layout layout(model.problem);
  std::vector<double> rms;
  bundle::Rows rows;
  for (const bundle::ImageTag& tag : model.problem.image_tags) {
    if (!bundle::evaluate(model.problem, layout, model.state, tag, false, rows))
      throw std::runtime_error(model.problem.plates[tag.plate].name + " lies behind the camera of " +
                               model.problem.images[tag.image].name);
    rms.push_back(rows.values().norm() / std::sqrt(8.0));
  }
  return rms;
}

/// Minimised robustly, twice: with the scale of the residuals that there were, and that there are then. Returns that
/// scale after both.
double minimise_robustly(MarkerModel& model, int iterations, double scale) {
  for (int pass = 0; pass < 2; ++pass) {
    bundle::MinimiseOptions options;
    options.max_iterations = iterations;
    options.loss = {bundle::Loss::Kind::huber, 2 * std::sqrt(8.0) * scale};
    bundle::minimise_schur(model.problem, model.state, options);
    scale = std::max(1.0, upper_median(misfits(model)));
  }
  return scale;
}

BrownCamera camera_of(const MarkerBlock& block, const MarkerModel& model, size_t c) {
  BrownCamera camera = block.cameras[c].camera;
  std::array<double, BrownCamera::parameter_count> values;
  std::copy_n(model.state.interiors[c].begin(), values.size(), values.begin());
  camera.set_parameters(values);
  return camera;
}

RigidTransform cam_from_world(const bundle::Placement& image) {
  return {image.rotation, -(image.rotation * image.position)};
}

/// The values of `model` as a start.
MarkerStart start_of(const MarkerBlock& block, const MarkerModel& model, const MarkerStart& before) {
  MarkerStart start = before;
  start.cam_from_world.assign(block.images.size(), std::nullopt);
  start.world_from_tag.assign(block.markers.size(), std::nullopt);
  for (size_t c = 0; c < block.cameras.size(); ++c)
    start.cameras[c].set_parameters(camera_of(block, model, c).parameters());
  for (size_t i = 0; i < model.images.size(); ++i)
    start.cam_from_world[model.images[i]] = cam_from_world(model.state.images[i]);
  for (size_t j = 0; j < model.markers.size(); ++j)
    start.world_from_tag[model.markers[j]] =
        RigidTransform{model.state.plates[j].rotation, model.state.plates[j].position};
  return start;
}

/// Views whose tag lies behind its camera at the start cannot take part.
std::vector<bool> drop_impossible(const MarkerBlock& block, const MarkerStart& start, std::vector<bool> use) {
  for (size_t v = 0; v < block.views.size(); ++v) {
    const MarkerView& view = block.views[v];
    const auto& image = start.cam_from_world[view.image];
    const auto& tag = start.world_from_tag[view.marker];
    if (!use[v] || !image || !tag) continue;
    const double size = block.markers[view.marker].size;
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

double root_mean_square(const MarkerBlock& block, const MarkerModel& model, size_t k, double misfit) {
  const MarkerView& view = block.views[model.views[k]];
  double variance = 0;
  for (const auto& c : view.covariances) variance += 0.125 * c.trace();
  return misfit * std::sqrt(variance);
}

Trial minimised(const MarkerBlock& block, const MarkerOptions& options, const MarkerStart& start,
                const std::vector<bool>& use, int iterations) {
  Trial trial{start, drop_impossible(block, start, use)};
  MarkerModel model = build_model(block, options, start, trial.use);
  if (model.views.empty()) return trial;
  minimise_robustly(model, iterations, 5);
  const std::vector<double> fits = misfits(model);
  std::vector<double> pixels;
  double bounded = static_cast<double>(block.views.size() - fits.size());
  const double bound = 0.005 * std::max(block.cameras.front().camera.width, block.cameras.front().camera.height);
  for (size_t k = 0; k < fits.size(); ++k) {
    pixels.push_back(root_mean_square(block, model, k, fits[k]));
    const double e = pixels.back() * pixels.back() / (bound * bound);
    bounded += e / (1 + e);
  }
  trial.score = bounded / static_cast<double>(block.views.size());
  trial.median_pixels = upper_median(pixels);
  trial.start = start_of(block, model, start);
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
        if (camera.lens == LensModel::fisheye) f = 0.4 * extent * (factor > 0 ? factor : 1.0);
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

/// Everything of one adjustment that the results are read from; not to be moved, since the parts point to each other.
struct Run {
  MarkerModel model;
  std::unique_ptr<bundle::Layout> layout;
  bundle::Adjusted adjusted;
  bundle::Reliability reliability;
  Eigen::MatrixXd cofactor(bundle::Ref ref) const { return adjusted.cofactors->own(layout->block(ref)); }
};

void find_blunders(const MarkerBlock& block, const MarkerOptions& options, Trial& trial, MarkerResult& result) {
  MarkerModel model = build_model(block, options, trial.start, trial.use);
  const double unit = minimise_robustly(model, options.max_iterations, std::max(1.0, upper_median(misfits(model))));
  const std::vector<double> fits = misfits(model);
  trial.start = start_of(block, model, trial.start);
  for (size_t v = 0; v < trial.use.size(); ++v)
    if (!trial.use[v]) result.rejected.push_back(static_cast<int>(v));
  for (size_t k = 0; k < fits.size(); ++k)
    if (options.reject_above > 0 && fits[k] > options.reject_above * unit) {
      trial.use[model.views[k]] = false;
      result.rejected.push_back(model.views[k]);
    }
  std::sort(result.rejected.begin(), result.rejected.end());
}

/// The covariance of all that is kept is dense.
void require_moderate(const MarkerModel& model, const bundle::Layout& layout) {
  constexpr int most = 9000;
  const int kept = layout.unknown_count() - 6 * static_cast<int>(model.images.size());
  if (kept > most)
    throw std::runtime_error("the block has " + std::to_string(kept) +
                             " unknowns besides the poses; the dense covariance of this adjustment takes up to " +
                             std::to_string(most) + ": divide the block or leave tags out");
}

void run_adjustment(const MarkerBlock& block, const MarkerOptions& options, const Trial& trial, Run& run,
                    MarkerResult& result) {
  constexpr int max_variance_steps = 6;
  run.model = build_model(block, options, trial.start, trial.use);
  bundle::Problem& problem = run.model.problem;
  run.layout = std::make_unique<bundle::Layout>(problem);
  require_moderate(run.model, *run.layout);
  bundle::AdjustOptions how;
  how.minimise.max_iterations = options.max_iterations;
  how.start_is_near = true;
  for (int step = 0; step < max_variance_steps; ++step) {
    how.datum = datum_of(block, run.model, *run.layout);
    run.adjusted = bundle::adjust(problem, *run.layout, run.model.state, how);
    run.model.state = run.adjusted.state;
    run.reliability = bundle::reliability_of(problem, run.adjusted);
    how.is_determined = true;
    if (step + 1 == max_variance_steps) break;
    double change = 0;
    std::array<double, 2> next;
    for (const size_t g : {size_t{group_refined}, size_t{group_unrefined}}) {
      const auto& component = run.reliability.groups[g];
      const double before = next[g] = problem.groups[g].sigma_factor;
      if (component.rows == 0 || !(component.redundancy > 1) || !(component.factor > 0)) continue;
      next[g] = std::clamp(before * std::sqrt(component.factor), 0.05, 1000.0);
      change = std::max(change, std::abs(next[g] / before - 1));
    }
    if (change < 0.005) break;
    for (size_t g = 0; g < next.size(); ++g) problem.groups[g].sigma_factor = next[g];
  }
  result.observations = run.adjusted.rows;
  result.unknowns = run.adjusted.unknowns;
  result.datum_defect = run.adjusted.defect;
  result.degrees_of_freedom = run.adjusted.redundancy();
  if (result.degrees_of_freedom < 1)
    throw std::runtime_error(
        "the block has no redundancy: nothing checks its observations. Take more photographs that "
        "share tags");
  std::vector<least_squares::VarianceComponent> groups = run.reliability.groups;
  for (const auto& group : groups) result.weighted_sum_of_squares += group.sum_of_squares;
  result.sigma0 = std::sqrt(result.weighted_sum_of_squares / result.degrees_of_freedom);
  for (const size_t g : {size_t{group_refined}, size_t{group_unrefined}})
    groups[g].factor *= std::pow(problem.groups[g].sigma_factor, 2);
  std::erase_if(groups, [](const auto& group) { return group.rows == 0; });
  result.groups = groups;
}

/// The adjustment, whose failure says what these photographs lack.
void run_or_explain(const MarkerBlock& block, const MarkerOptions& options, const Trial& trial, Run& run,
                    MarkerResult& result) {
  try {
    run_adjustment(block, options, trial, run, result);
  } catch (const std::runtime_error& error) {
    const bool self_calibration = std::any_of(block.cameras.begin(), block.cameras.end(), [](const MarkerCamera& c) {
      return !c.held && c.covariance.size() == 0;
    });
    if (!self_calibration) throw;
    throw Failure(
        kind_of(error),
        std::to_string(block.images.size()) + " photographs with " + std::to_string(block.markers.size()) +
            (block.markers.size() == 1 ? " tag" : " tags") + ", " +
            text::format_fixed(static_cast<double>(block.views.size()) / static_cast<double>(block.images.size()), 1) +
            " in each on the average, do not calibrate " + std::to_string(block.cameras.size()) +
            (block.cameras.size() == 1 ? " camera" : " cameras") +
            ". Photograph several tags together, from several directions, tilted; or calibrate the camera on a board "
            "(calibrate_camera) and orient with marker_field; if several cameras are in one folder, cameras=by_name "
            "tells "
            "them by the names of their files; fixed cameras before one moving tag: a layout of that tag alone for "
            "marker_field. In detail: " +
            error.what());
  }
}

/// An inset that is not significant is set to zero, but its uncertainty stays in all covariances: with one distance it
/// cannot be told from the size of the tags, and half a millimetre in ten metres hangs on 0.01 px of it. Not where a
/// detector states how far it may draw edges inwards: then the estimate is the best there is, and zero would err by up
/// to three of the standard deviations that are stated.
void drop_insignificant_insets(const MarkerBlock& block, const MarkerOptions& options, const Trial& trial, Run& run) {
  if (std::any_of(block.images.begin(), block.images.end(), [](const MarkerImage& i) { return i.inset_sigma > 0; }))
    return;
  constexpr double always_significant = 0.1;  // [px]
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    const bundle::Ref ref{bundle::Kind::inset, run.model.inset_batch(c)};
    if (!run.model.problem.batches[ref.index].inset_free) continue;
    const double sigma = std::sqrt(run.cofactor(ref)(0, 0));
    if (std::abs(run.model.state.insets[ref.index]) > std::min(3 * sigma, always_significant)) return;
  }
  if (!(options.inset_sigma > 0)) return;
  MarkerOptions without = options;
  without.inset_sigma = 0;
  Run held;
  MarkerResult unused;
  Trial from = trial;
  from.start = start_of(block, run.model, trial.start);
  run_adjustment(block, without, from, held, unused);
  run.model.state = run.adjusted.state = held.model.state;
  run.reliability = bundle::reliability_of(run.model.problem, run.adjusted);
}

void fill_cameras(const MarkerBlock& block, const Run& run, MarkerResult& result) {
  constexpr int count = BrownCamera::parameter_count;
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    AdjustedMarkerCamera camera;
    camera.camera = camera_of(block, run.model, c);
    camera.covariance = Eigen::MatrixXd::Zero(count, count);
    const auto& free = run.layout->free_values(static_cast<int>(c));
    if (!free.empty()) camera.covariance(free, free) = run.cofactor({bundle::Kind::camera, static_cast<int>(c)});
    const int batch = run.model.inset_batch(c);
    camera.inset = run.model.state.insets[batch];
    if (run.model.problem.batches[batch].inset_free)
      camera.inset_sigma = std::sqrt(run.cofactor({bundle::Kind::inset, batch})(0, 0));
    for (const bundle::Image& image : run.model.problem.images) camera.images += image.camera == static_cast<int>(c);
    result.cameras.push_back(camera);
  }
}

void fill_markers(const MarkerBlock& block, const Run& run, MarkerResult& result) {
  std::vector<int> plates, centres, images(run.model.markers.size(), 0);
  for (const bundle::ImageTag& tag : run.model.problem.image_tags) ++images[tag.plate];
  for (int j = 0; j < static_cast<int>(run.model.markers.size()); ++j) {
    plates.push_back(run.layout->block({bundle::Kind::plate, j}));
    for (int c = 0; c < 3; ++c) centres.push_back(6 * j + c);
  }
  const Eigen::MatrixXd cofactor = run.adjusted.cofactors->joint(plates);
  result.centre_covariance = cofactor(centres, centres);
  for (size_t j = 0; j < run.model.markers.size(); ++j) {
    AdjustedMarker marker;
    marker.marker = run.model.markers[j];
    marker.world_from_tag = {run.model.state.plates[j].rotation, run.model.state.plates[j].position};
    marker.scale = run.model.state.scales[j];
    if (run.model.problem.batches[j].scale_free)
      marker.scale_sigma = std::sqrt(run.cofactor({bundle::Kind::scale, static_cast<int>(j)})(0, 0));
    marker.shape = run.model.state.forms[j];
    const double half = 0.5 * block.markers[marker.marker].size * marker.scale;
    marker.corners = shaped_corners(half, marker.shape);
    for (Eigen::Vector3d& corner : marker.corners) corner = marker.world_from_tag * corner;
    const Eigen::Index at = 6 * static_cast<Eigen::Index>(j);
    marker.centre_covariance = cofactor.block<3, 3>(at, at);
    marker.rotation_covariance = cofactor.block<3, 3>(at + 3, at + 3);
    marker.images = images[j];
    result.markers.push_back(marker);
  }
}

void fill_images(const MarkerBlock& block, const Run& run, MarkerResult& result) {
  result.images.resize(block.images.size());
  for (size_t i = 0; i < result.images.size(); ++i) result.images[i].image = static_cast<int>(i);
  for (size_t i = 0; i < run.model.images.size(); ++i) {
    AdjustedMarkerImage& image = result.images[run.model.images[i]];
    image.oriented = true;
    image.centre = run.model.state.images[i].position;
    image.cam_from_world = cam_from_world(run.model.state.images[i]);
    image.covariance = run.cofactor({bundle::Kind::image, static_cast<int>(i)});
  }
}

void fill_views(const MarkerBlock& block, const Run& run, MarkerResult& result) {
  std::vector<double> camera_squares(block.cameras.size(), 0);
  double squares = 0;
  for (size_t k = 0; k < run.model.views.size(); ++k) {
    AdjustedMarkerView seen;
    seen.view = run.model.views[k];
    const MarkerView& view = block.views[seen.view];
    const auto& quality = run.reliability.tags[k];
    double sum = 0;
    for (size_t r = 0; r < 8; ++r) {
      seen.residuals[r / 2](static_cast<Eigen::Index>(r % 2)) = -quality[r].residual;
      sum += quality[r].residual * quality[r].residual;
      seen.largest_w = std::max(seen.largest_w, std::abs(quality[r].w));
      seen.smallest_redundancy = std::min(seen.smallest_redundancy, quality[r].redundancy_number);
    }
    seen.rms = std::sqrt(sum / 8);
    squares += sum;
    AdjustedMarkerImage& image = result.images[view.image];
    ++image.tags, image.rms += sum / 8;
    const size_t c = static_cast<size_t>(block.images[view.image].camera);
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

std::array<Eigen::Vector3d, 4> shaped_corners(double half, const TagShape& shape) {
  std::array<Eigen::Vector3d, 4> corners;
  for (size_t k = 0; k < 4; ++k) {
    const double u = k == 1 || k == 2 ? 1 : -1, v = k >= 2 ? 1 : -1;
    corners[k] = half * Eigen::Vector3d(u + shape[0] * u + shape[1] * v + shape[2] * (u * v),
                                        v - shape[0] * v + shape[1] * u + shape[3] * (u * v), shape[4] * (u * v));
  }
  return corners;
}

namespace {

/// Of each such tag the larger part of its photographs takes part again, and no other.
void keep_one_place(const MarkerBlock& block, const std::vector<TagAtTwoPlaces>& found, Trial& trial) {
  for (const TagAtTwoPlaces& tag : found) {
    for (const MarkerView& view : block.views)
      if (view.marker == tag.marker) trial.use[static_cast<size_t>(&view - block.views.data())] = false;
    for (const int v : tag.views[tag.larger()]) trial.use[v] = true;
    const MarkerView& first = block.views[tag.views[tag.larger()].front()];
    auto& place = trial.start.world_from_tag[tag.marker];
    const auto poses = poses_of_view(block, first, trial.start.cameras[block.images[first.image].camera]);
    if (!place && !poses.empty())
      place = trial.start.cam_from_world[first.image]->inverse() * poses.front().cam_from_figure;
    if (place) place->translation = tag.places[tag.larger()];
  }
}

/// A tag that was moved during the photographs is adjusted where most of them have it, and named. What cannot be
/// adjusted so stays as it was.
std::vector<TagAtTwoPlaces> adjust_tags_at_one_place(const MarkerBlock& block, const MarkerOptions& options,
                                                     Trial& trial, std::unique_ptr<Run>& run, MarkerResult& result) {
  Trial mended = trial;
  mended.start = start_of(block, run->model, trial.start);
  std::vector<TagAtTwoPlaces> found = tags_at_two_places(block, mended.start, mended.use);
  if (found.empty() || !(options.reject_above > 0)) return {};
  keep_one_place(block, found, mended);
  MarkerResult again;
  auto second = std::make_unique<Run>();
  try {
    run_adjustment(block, options, mended, *second, again);
  } catch (const std::runtime_error&) {
    return {};
  }
  for (size_t v = 0; v < mended.use.size(); ++v)
    if (!mended.use[v]) again.rejected.push_back(static_cast<int>(v));
  trial = std::move(mended), run = std::move(second), result = std::move(again);
  return found;
}

}  // namespace

MarkerResult adjust_as_given(const MarkerBlock& block, const MarkerOptions& options) {
  require_usable(block);
  MarkerResult result;
  Trial trial = best_start(block, options);
  find_blunders(block, options, trial, result);
  auto owned = std::make_unique<Run>();
  run_or_explain(block, options, trial, *owned, result);
  const std::vector<TagAtTwoPlaces> moved = adjust_tags_at_one_place(block, options, trial, owned, result);
  Run& run = *owned;
  drop_insignificant_insets(block, options, trial, run);
  fill_cameras(block, run, result);
  judge_cameras(block, run.model, *run.layout, run.adjusted, result);
  fill_markers(block, run, result);
  fill_images(block, run, result);
  fill_views(block, run, result);
  if (options.distance) scale_by_distance(block, *options.distance, result);
  if (has_layout(block)) {
    result.datum = "the layout's places of the tags, with their standard deviations";
  } else {
    to_first_tag(block, in_one_line(block, run.model), result);
    state_scale(block, options, result);
  }
  for (const auto& words : {words_of(block, moved), words_of_rejected(block, result, moved)})
    result.warnings.insert(result.warnings.end(), words.begin(), words.end());
  warn_about_variance(result);
  explain_images(block, result);
  explain_single_tags(block, result);
  warn_about_calibrations(block, result);
  warn_about_weak(block, result);
  return result;
}

}  // namespace plumbline::markers
