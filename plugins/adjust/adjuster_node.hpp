// adjust.schur, adjust.ceres: bundle adjustment of marker plates, equations (4) and (5), or of measured
// targets. One node over every engine: they differ in how the minimum is found, and in nothing that is said about it.
#pragma once

#include "artifacts/block.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "global_tests.hpp"
#include "plumbline/node.hpp"
#include "tag_block_artifacts.hpp"
#include "target_block_artifacts.hpp"

namespace plumbline::adjust {

struct SchurEngine {
  static constexpr Info info{"adjust.schur", "adjuster", 1,
                             "Bundle adjustment with our own solver, free (4) or with control (5)"};
  static bundle::MinimiseSummary minimise(const bundle::Problem& problem, bundle::State& state,
                                          const bundle::MinimiseOptions& options) {
    return bundle::minimise_schur(problem, state, options);
  }
};

struct CeresEngine {
  static constexpr Info info{"adjust.ceres", "adjuster", 2,
                             "Bundle adjustment with Ceres (DENSE_SCHUR), free (4) or with control (5)"};
  static bundle::MinimiseSummary minimise(const bundle::Problem& problem, bundle::State& state,
                                          const bundle::MinimiseOptions& options) {
    return bundle::minimise_ceres(problem, state, options);
  }
};

template <typename Engine>
struct Adjuster : Node {
  static constexpr Info info = Engine::info;
  List<ImageTags> observations{"observations", "tags of every image"};
  Optional<Poses> poses{"poses", frame("frame=?F"),
                        "approximate poses; images without one are oriented from plates they share"};
  Optional<Camera> camera{"camera", "interior orientation; its covariance is the prior of a self-calibration"};
  Optional<Plates> plates{"plates", frame("frame=?F"), "which tag stands for which anchor, control and check anchors"};
  Optional<Points> control{"control", frame("frame=?F"), "surveyed anchors; without it the network is free"};
  Optional<ImageBlock> targets{"block", frame("frame=?F"),
                               "measured targets with approximate values and control, in place of all the others"};

  Param<std::string> weighting{"weighting", "covariance", one_of("covariance", "lambda"),
                               "weights by the covariances of corners and control, or (5) with a scalar λ as printed"};
  static constexpr double default_lambda = 1e4;
  Param<double> lambda{"lambda", default_lambda, "px^2/m^2", between(1e-12, 1e18),
                       "λ of (5), (σ_px/σ_S)²; for weighting lambda"};
  Param<double> corner_sigma{"corner_sigma", 0.1, "px", between(1e-4, 100),
                             "standard deviation of a corner whose detector gives none, and with weighting lambda"};
  Param<std::string> self_calibration{
      "self_calibration", "prior", one_of("off", "prior", "free"),
      "hold the interior orientation; estimate what the camera gives a covariance for; estimate without prior"};
  Param<std::vector<std::string>> free_interior{"free_interior",
                                                {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"},
                                                "interior parameters that a self-calibration may change"};
  Param<bool> fixed_aspect{"fixed_aspect", false, "hold fy/fx"};
  Param<double> tag_scale_sigma{
      "tag_scale_sigma", 1e-3, "1", at_least(0),
      "prior standard deviation of a print batch's relative tag size; 0 makes tags carry scale"};
  Param<double> corner_inset_sigma{
      "corner_inset_sigma", 0.0, "px", between(0, 10),
      "prior standard deviation of how far the detector draws tag edges inwards; 0 leaves it out"};
  Param<std::string> loss{"loss", "huber", one_of("none", "huber", "cauchy", "tukey"),
                          "robust loss on tags, to find blunders"};
  Param<double> loss_scale{"loss_scale", 2.0, "sigma", between(0.1, 100), "where the loss departs from squares"};
  Param<double> reject_above{"reject_above", 5.0, "sigma", at_least(0),
                             "tags whose rms residual is above are left out of the final least squares; 0 keeps all"};
  Param<bool> estimate_image_variance{"estimate_image_variance", true,
                                      "scale the corners' covariances so that the images' variance component is 1"};
  Param<std::string> weak_datum{"weak_datum", "error", one_of("error", "warn"),
                                "what to do if control holds the block's datum only weakly"};
  Param<double> weak_ratio{
      "weak_ratio", 30.0, "1", at_least(1),
      "a motion of the block is weak if its displacement is this much less certain than the best held one"};
  Param<int64_t> max_iterations{"max_iterations", 100, between(1, 10000), "of the damped iteration"};
  Param<int64_t> threads{"threads", 1, between(1, 64), "of adjust.schur; the result is the same to the bit"};
  Param<double> image_sigma{
      "image_sigma", 0.0, "mm", between(0, 1),
      "targets: a priori standard deviation of a sensor coordinate; 0: as the files have it, else "
      "0.0005 mm"};
  Param<std::vector<std::string>> free{
      "free",
      {"auto"},
      "targets: interior parameters to estimate; auto: Ck, xh, yh, A1, A2, B1, B2 of a balanced camera, "
      "none of a correcting one, which comes calibrated"};
  Param<std::string> free_datum{"free_datum", "inner", one_of("inner", "first_image"),
                                "targets without control: inner constraints over all points, or the first image held"};

  Out<Points> points{"points", frame("frame=?F"), "adjusted anchors with their full marginal covariance"};
  Out<Camera> adjusted_camera{"camera", "interior orientation after the adjustment"};
  Out<Poses> adjusted_poses{"poses", frame("frame=?F"), "exterior orientations with covariance"};
  Out<Block> block{"block", frame("frame=?F"), "statistics, residuals and reliability"};

  TagBlockOptions options() const {
    TagBlockOptions o;
    o.weighting = *weighting == "lambda" ? TagBlockOptions::Weighting::lambda : TagBlockOptions::Weighting::covariance;
    o.lambda = *lambda;
    o.corner_sigma = *corner_sigma;
    o.free_network = !control;
    o.self_calibration = *self_calibration != "off";
    o.free_interior = *free_interior;
    o.fixed_aspect = *fixed_aspect;
    o.tag_scale_sigma = *tag_scale_sigma;
    o.corner_inset_sigma = *corner_inset_sigma;
    o.loss = *loss == "huber"    ? RobustLoss::huber
             : *loss == "cauchy" ? RobustLoss::cauchy
             : *loss == "tukey"  ? RobustLoss::tukey
                                 : RobustLoss::none;
    o.loss_scale = *loss_scale;
    o.reject_above = *reject_above;
    o.estimate_image_variance = *estimate_image_variance;
    o.weak_ratio = *weak_ratio;
    o.max_iterations = static_cast<int>(*max_iterations);
    o.threads = static_cast<int>(*threads);
    o.minimiser = Engine::minimise;
    return o;
  }

  void run(Context& context) override {
    if (targets) return run_targets(context);
    if (!poses || !camera || !plates)
      throw std::runtime_error(
          "connect either 'observations', 'poses', 'camera' and 'plates' (marker plates) or 'block' (measured "
          "targets)");
    TagBlockBuilder builder(camera.unpack(), plates.unpack(), poses.unpack());
    builder.set_prior(*self_calibration == "prior");
    for (size_t i = 0; i < observations.size(); ++i) builder.add_image(observations.unpack(i), *corner_sigma);
    if (control) builder.set_control(control.unpack());
    for (const auto& warning : builder.warnings()) context.warn(warning);
    const TagBlockOptions chosen = options();
    if (*lambda != default_lambda && *weighting != "lambda")
      context.warn("parameter 'lambda' has no effect with weighting=covariance; set weighting=lambda, or leave it out");
    const TagBlockResult result = adjust_tag_block(builder.block(), chosen);
    report(context, builder.block(), result);
    points.commit(builder.points(result));
    adjusted_camera.commit(builder.camera(result));
    adjusted_poses.commit(builder.poses(result));
    BlockT artifact = builder.describe(result, chosen);
    artifact.adjuster = info.kind;
    block.commit(artifact);
  }

  void run_targets(Context& context) {
    const ImageBlockT given = targets.unpack();
    const PointBlock measured = target_block_of(given);
    PointBlockOptions o;
    o.image_sigma = *image_sigma > 0 ? *image_sigma : image_sigma_of(measured);
    o.free_parameters = *free;
    o.free_datum =
        *free_datum == "inner" ? PointBlockOptions::FreeDatum::inner : PointBlockOptions::FreeDatum::first_image;
    o.max_iterations = static_cast<int>(*max_iterations);
    o.threads = static_cast<int>(*threads);
    o.minimiser = Engine::minimise;
    const PointBlockResult result = adjust_point_block(measured, o);
    context.metric("sigma0", result.sigma0 / o.image_sigma, "1");
    context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
    BlockT artifact = describe_targets(result, o);
    artifact.adjuster = info.kind;
    artifact.left_out = given.left_out;
    for (const auto& what : artifact.warnings) context.warn(what);
    points.commit(target_points(result));
    adjusted_camera.commit(target_camera(result));
    adjusted_poses.commit(target_poses(result));
    block.commit(artifact);
  }

  void report(Context& context, const TagBlock& given, const TagBlockResult& result) const {
    for (const auto& what : result.left_out) context.warn("left out: " + what);
    for (const auto& what : result.warnings) context.warn(what);
    tell_global_tests(context, result);
    for (int o : result.rejected) {
      const TagObservation& seen = given.observations[static_cast<size_t>(o)];
      context.warn("left out as a blunder: the tag of " + given.plates[static_cast<size_t>(seen.plate)].anchor +
                   " in " + given.images[static_cast<size_t>(seen.image)].name);
    }
    for (size_t j = 0; j < result.plates.size(); ++j)
      if (result.images_per_plate[j] < 2)
        context.warn(given.plates[static_cast<size_t>(result.plates[j])].anchor +
                     " is seen in one image only: its depth rests on the tag's size");
    context.metric("sigma0", result.sigma0, "1");
    context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
    if (result.weak_datum.empty()) return;
    const std::string text = "control holds " + enumerate(result.weak_datum) +
                             " of the block only weakly: its anchors may move by " +
                             std::to_string(result.weakest_datum_sigma) + " m rms (1 sigma)";
    if (*weak_datum == "error")
      throw std::runtime_error(text + "; add control that is not on one line, or set weak_datum to 'warn'");
    context.warn(text);
  }
};

}  // namespace plumbline::adjust
