#include "photo/markers/marker_trial.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/median.hpp"
#include "photo/bundle/adjust.hpp"

namespace plumbline::markers {
namespace {

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

}  // namespace

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

namespace {

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

double root_mean_square(const MarkerBlock& block, const MarkerModel& model, size_t k, double misfit) {
  const MarkerView& view = block.views[model.views[k]];
  double variance = 0;
  for (const auto& c : view.covariances) variance += 0.125 * c.trace();
  return misfit * std::sqrt(variance);
}

MarkerTrial minimised(const MarkerBlock& block, const MarkerOptions& options, const MarkerStart& start,
                      const std::vector<bool>& use, int iterations) {
  MarkerTrial trial{start, drop_impossible(block, start, use)};
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

}  // namespace

MarkerTrial best_start(const MarkerBlock& block, MarkerOptions options) {
  options.shape_sigma = options.twist_sigma = 0;
  const std::vector<bool> all(block.views.size(), true);
  MarkerTrial best;
  for (const auto& cameras : camera_candidates(block)) {
    const MarkerStart start = start_marker_block(block, cameras, all);
    if (start.placed == 0) continue;
    MarkerTrial trial = minimised(block, options, start, all, 30);
    // A tag that was placed turned over, or an image from one tag alone, shows now that lens and tags are better known.
    const MarkerStart improved = improve_start(block, trial.start, all);
    if (improved.placed > start.placed || improved.cost < trial.start.cost) {
      MarkerTrial again = minimised(block, options, improved, all, 30);
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

void find_blunders(const MarkerBlock& block, const MarkerOptions& options, MarkerTrial& trial, MarkerResult& result) {
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

}  // namespace plumbline::markers
