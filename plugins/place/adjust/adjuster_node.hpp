// adjust.schur, adjust.ceres (ceres_engine.hpp): bundle adjustment of marker plates, equations (4) and (5), or of
// measured targets. One node over every engine: they differ in how the minimum is found, and in nothing that is said
// about it.
#pragma once

#include "adjustment_memory.hpp"
#include "artifacts/block.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "check_points.hpp"
#include "photo/block/point_block_robust.hpp"
#include "photo/block/point_block_words.hpp"
#include "plumbline/failure.hpp"
#include "plumbline/node.hpp"
#include "tag_adjuster_node.hpp"
#include "target_block_artifacts.hpp"

namespace plumbline::block {

struct SchurEngine {
  static constexpr bool refines_robust = true;
  static constexpr Info info{"adjust.schur", "adjuster", 4,
                             "Bundle adjustment with our own solver, free (4) or with control (5)"};
  static bundle::MinimiseSummary minimise(const bundle::Problem& problem, bundle::State& state,
                                          const bundle::MinimiseOptions& options) {
    return bundle::minimise_schur(problem, state, options);
  }
};

/// Who finds the minima of tags.
template <typename Engine>
void choose_engine(TagBlockOptions& options) {
  options.minimiser = Engine::minimise;
  options.refine_robust = Engine::refines_robust;
}

template <typename Engine>
struct Adjuster : TagAdjusterNode {
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
  Param<double> image_sigma{"image_sigma", 0.0, "mm", between(0, 1),
                            "targets: a priori standard deviation of each sensor coordinate, in place of the files'; "
                            "0: as these have it, else "
                            "0.0005 mm"};
  Param<std::vector<std::string>> free{
      "free",
      {"auto"},
      "targets: interior parameters to estimate; auto: Ck, xh, yh, A1, A2, B1, B2 of a balanced camera, "
      "none of a correcting one, which comes calibrated"};
  Param<double> principal_point_sigma{
      "principal_point_sigma", 0.0, "mm", between(0, 10),
      "targets: standard deviation of each image's own principal point about its camera's; 0: they share one"};
  Param<std::string> free_datum{"free_datum", "inner", one_of("inner", "first_image"),
                                "targets without control: inner constraints over all points, or the first image held"};

  Param<std::string> solver{"solver", "factor", one_of("factor", "gradients"),
                            "targets: how the reduced normal equations are solved; gradients: conjugate gradients, for "
                            "blocks whose factor has "
                            "no room in memory, which give coordinates and residuals and no standard deviation"};
  Param<bool> joint_orientations{"joint_orientations", false,
                                 "give the poses their joint covariance with the cameras, which surfaces that are "
                                 "measured in the photographs need; 8 values an image, so for some hundred images"};

  Out<Points> points{"points", frame("frame=?F"), "adjusted anchors with their full marginal covariance"};
  Out<Camera> adjusted_camera{"camera", "interior orientation after the adjustment"};
  Out<Poses> adjusted_poses{"poses", frame("frame=?F"), "exterior orientations with covariance"};
  Out<Block> block{"block", frame("frame=?F"), "statistics, residuals and reliability"};

  TagBlockOptions options() const {
    TagBlockOptions o = tag_options();
    o.weighting = *weighting == "lambda" ? TagBlockOptions::Weighting::lambda : TagBlockOptions::Weighting::covariance;
    o.lambda = *lambda;
    o.free_network = !control;
    o.joint_orientations = *joint_orientations;
    choose_engine<Engine>(o);
    return o;
  }

  void run(Context& context) override {
    if (targets) return run_targets(context);
    if (*solver == "gradients")
      throw BadInput(
          "solver=gradients is for blocks of measured targets ('block'): anchors are judged by their standard "
          "deviations, which conjugate gradients do not give");
    if (!poses || !camera || !plates)
      throw std::runtime_error(
          "connect either 'observations', 'poses', 'camera' and 'plates' (marker plates) or 'block' (measured "
          "targets)");
    TagBlockBuilder builder(camera.unpack(), plates.unpack(), poses.unpack());
    builder.set_prior(*self_calibration == "prior");
    for (size_t i = 0; i < observations.size(); ++i) builder.add_image(observations.unpack(i), *corner_sigma);
    if (control)
      builder.set_control(control.unpack());
    else
      builder.set_fitted("adjusted without control, and stands where its approximate poses have the anchors",
                         std::nan(""));
    for (const auto& warning : builder.warnings()) context.warn(warning);
    TagBlockOptions chosen = options();
    if (control && *weighting == "lambda")
      context.warn("control is not tested with weighting=lambda: λ states no standard deviation of the survey");
    if (*lambda != default_lambda && *weighting != "lambda")
      context.warn("parameter 'lambda' has no effect with weighting=covariance; set weighting=lambda, or leave it out");
    const TagBlock& given = builder.block();
    chosen.announce = announcer(context, given.observations.size(), 4000, given.plates.size());
    const TagBlockResult result = adjust_tag_block(given, chosen);
    report(context, builder.block(), result);
    points.commit(builder.points(result));
    adjusted_camera.commit(builder.camera(result));
    adjusted_poses.commit(builder.poses(result));
    BlockT artifact = builder.describe(result, chosen);
    artifact.adjuster = info.kind;
    for (size_t k = result.warnings.size(); k < artifact.warnings.size(); ++k) context.warn(artifact.warnings[k]);
    block.commit(artifact);
  }

  /// Parameters of marker plates that somebody set though a block of measured targets is adjusted.
  std::string without_effect() const {
    std::string names;
    for (const auto& [name, is_set] : {std::pair{"weighting", *weighting != "covariance"},
                                       {"lambda", *lambda != default_lambda},
                                       {"joint_orientations", *joint_orientations},
                                       {"corner_sigma", *corner_sigma != 0.1},
                                       {"self_calibration", *self_calibration != "prior"},
                                       {"image_principal_point_sigma", *image_principal_point_sigma != 0},
                                       {"fixed_aspect", *fixed_aspect},
                                       {"tag_scale_sigma", *tag_scale_sigma != 1e-3},
                                       {"corner_inset_sigma", *corner_inset_sigma != 0.3},
                                       {"loss", *loss != "huber"},
                                       {"loss_scale", *loss_scale != 2},
                                       {"reject_above", *reject_above != 5},
                                       {"weak_datum", *weak_datum != "error"},
                                       {"weak_ratio", *weak_ratio != 30}})
      if (is_set) names += (names.empty() ? "" : ", ") + std::string(name);
    return names;
  }

  /// What contradicts the block, known points that hold it or check it, or scale bars: exit code 3. As far as nobody
  /// knows what the images are worth (estimate_image_variance=false) control that contradicts them is told alone.
  static void judge_known(Context& context, const PointBlockOptions& options, const PointBlockResult& result) {
    const bool checks = tell_check_points(context, result);
    const bool control = !options.estimate_image_variance || control_against_images(result).empty();
    if (!checks && !control)
      context.warn(
          "the control contradicts the images, so what check points are off may be its error and not theirs: mend the "
          "control first");
    const bool holds = checks && control && scale_bars_against_images(result).empty();
    if (!result.control.empty() || !result.block.scale_bars.empty()) context.metric("invalid", holds ? 0 : 1, "1");
  }

  void run_targets(Context& context) {
    if (const std::string names = without_effect(); !names.empty())
      context.warn("without effect on a block of measured targets: " + names + "; leave them out");
    const ImageBlockT given = targets.unpack();
    PointBlock measured = target_block_of(given);
    PointBlockOptions o;
    o.image_sigma = *image_sigma > 0 ? *image_sigma : image_sigma_of(measured);
    if (*image_sigma > 0)
      for (BlockMeasurement& m : measured.measurements) m.sigma = 0;  // whatever the files say
    o.estimate_image_variance = *estimate_image_variance;
    o.free_parameters = *free;
    o.principal_point_sigma = *principal_point_sigma;
    o.free_datum =
        *free_datum == "inner" ? PointBlockOptions::FreeDatum::inner : PointBlockOptions::FreeDatum::first_image;
    o.max_iterations = static_cast<int>(*max_iterations);
    o.threads = static_cast<int>(*threads);
    o.minimiser = Engine::minimise;
    o.by_gradients = *solver == "gradients";
    const auto& checks = measured.control.is_check;
    if (o.by_gradients && std::find(checks.begin(), checks.end(), true) != checks.end())
      throw BadInput(
          "check points are judged by the block's standard deviations, and solver=gradients gives none: leave them out "
          "of the control list, or give the memory that solver=factor asks for");
    const std::size_t count = measured.points.size();
    const bool joint = count <= max_joint_points && !o.by_gradients;
    o.announce = announcer(context, measured.measurements.size(), 1000, joint ? count : 0);
    const PointBlockResult result = (*robust_control ? adjust_without_wrong_control : adjust_point_block)(measured, o);
    context.metric("sigma0", result.sigma0 / o.image_sigma, "1");
    context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
    BlockT artifact = describe_targets(measured, result, o);
    artifact.adjuster = info.kind;
    artifact.left_out = given.left_out;
    for (const auto& what : set_aside_in_words(result)) {
      context.warn("left out: " + what);
      artifact.left_out.push_back(what);
    }
    for (const auto& what : artifact.warnings) context.warn(what);
    if (!o.by_gradients) judge_known(context, o, result);
    points.commit(target_points(result));
    adjusted_camera.commit(target_camera(result));
    adjusted_poses.commit(target_poses(result));
    block.commit(artifact);
  }
};

}  // namespace plumbline::block
