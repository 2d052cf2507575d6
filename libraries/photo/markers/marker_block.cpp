#include "photo/markers/marker_block.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "base/text/text.hpp"
#include "photo/markers/marker_adjustment.hpp"
#include "photo/markers/marker_datum.hpp"
#include "photo/markers/marker_run.hpp"
#include "photo/markers/marker_trial.hpp"
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

/// The covariance of all that is kept is dense.
void require_moderate(const MarkerModel& model, const bundle::Layout& layout) {
  constexpr int most = 9000;
  const int kept = layout.unknown_count() - 6 * static_cast<int>(model.images.size());
  if (kept > most)
    throw std::runtime_error("the block has " + std::to_string(kept) +
                             " unknowns besides the poses; the dense covariance of this adjustment takes up to " +
                             std::to_string(most) + ": divide the block or leave tags out");
}

void run_adjustment(const MarkerBlock& block, const MarkerOptions& options, const MarkerTrial& trial, MarkerRun& run,
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
void run_or_explain(const MarkerBlock& block, const MarkerOptions& options, const MarkerTrial& trial, MarkerRun& run,
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
void drop_insignificant_insets(const MarkerBlock& block, const MarkerOptions& options, const MarkerTrial& trial,
                               MarkerRun& run) {
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
  MarkerRun held;
  MarkerResult unused;
  MarkerTrial from = trial;
  from.start = start_of(block, run.model, trial.start);
  run_adjustment(block, without, from, held, unused);
  run.model.state = run.adjusted.state = held.model.state;
  run.reliability = bundle::reliability_of(run.model.problem, run.adjusted);
}

/// Of each such tag the larger part of its photographs takes part again, and no other.
void keep_one_place(const MarkerBlock& block, const std::vector<TagAtTwoPlaces>& found, MarkerTrial& trial) {
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
                                                     MarkerTrial& trial, std::unique_ptr<MarkerRun>& run,
                                                     MarkerResult& result) {
  MarkerTrial mended = trial;
  mended.start = start_of(block, run->model, trial.start);
  std::vector<TagAtTwoPlaces> found = tags_at_two_places(block, mended.start, mended.use);
  if (found.empty() || !(options.reject_above > 0)) return {};
  keep_one_place(block, found, mended);
  MarkerResult again;
  auto second = std::make_unique<MarkerRun>();
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
  MarkerTrial trial = best_start(block, options);
  find_blunders(block, options, trial, result);
  auto owned = std::make_unique<MarkerRun>();
  run_or_explain(block, options, trial, *owned, result);
  const std::vector<TagAtTwoPlaces> moved = adjust_tags_at_one_place(block, options, trial, owned, result);
  MarkerRun& run = *owned;
  drop_insignificant_insets(block, options, trial, run);
  fill_cameras(block, run, result);
  fill_markers(block, run, result);
  fill_images(block, run, result);
  judge_cameras(block, run.model, *run.layout, run.adjusted, result);
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
