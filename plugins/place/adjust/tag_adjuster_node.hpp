// What the adjusters of marker plates by our own model have in common: their parameters, and what they tell.
#pragma once

#include "base/text/words.hpp"
#include "global_tests.hpp"
#include "plumbline/node.hpp"
#include "tag_block_artifacts.hpp"

namespace plumbline::block {

struct TagAdjusterNode : Node {
  Param<double> corner_sigma{"corner_sigma", 0.1, "px", between(1e-4, 100),
                             "standard deviation of a corner whose detector gives none, and with weighting lambda"};
  Param<std::string> self_calibration{
      "self_calibration", "prior", one_of("off", "prior", "free"),
      "hold the interior orientation; estimate what the camera gives a covariance for; estimate without prior"};
  Param<std::vector<std::string>> free_interior{"free_interior",
                                                {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"},
                                                "interior parameters that a self-calibration may change; d1 and d2 "
                                                "let k1 and k2 change with the distance"};
  Param<double> image_principal_point_sigma{
      "image_principal_point_sigma", 0.0, "px", between(0, 100),
      "standard deviation of each image's own principal point about the camera's; 0: they share one"};
  Param<bool> fixed_aspect{"fixed_aspect", false, "hold fy/fx"};
  Param<double> tag_scale_sigma{
      "tag_scale_sigma", 1e-3, "1", at_least(0),
      "prior standard deviation of a print batch's relative tag size; 0 makes tags carry scale"};
  Param<double> corner_inset_sigma{"corner_inset_sigma", 0.3, "px", between(0, 10),
                                   "prior standard deviation of how far the detector draws tag edges inwards, where it "
                                   "states none; 0 leaves it out"};
  Param<std::string> loss{"loss", "huber", one_of("none", "huber", "cauchy", "tukey"),
                          "robust loss on tags, to find blunders"};
  Param<double> loss_scale{"loss_scale", 2.0, "sigma", between(0.1, 100), "where the loss departs from squares"};
  Param<double> reject_above{"reject_above", 5.0, "sigma", at_least(0),
                             "tags whose rms residual is above are left out of the final least squares; 0 keeps all"};
  Param<bool> estimate_image_variance{"estimate_image_variance", true,
                                      "scale the corners' covariances so that the images' variance component is 1"};
  Param<bool> robust_control{"robust_control", true,
                             "leave out control points that contradict the photographs and the other control, by "
                             "name, at most a third; false: they stay, and are named"};
  Param<std::string> weak_datum{"weak_datum", "error", one_of("error", "warn"),
                                "what to do if control holds the block's datum only weakly"};
  Param<double> weak_ratio{
      "weak_ratio", 30.0, "1", at_least(1),
      "a motion of the block is weak if its displacement is this much less certain than the best held one"};
  Param<int64_t> max_iterations{"max_iterations", 100, between(1, 10000), "of the damped iteration"};
  Param<int64_t> threads{"threads", 1, between(1, 64), "of adjust.schur; the result is the same to the bit"};

 protected:
  /// Weighting, control and engine are the node's own.
  TagBlockOptions tag_options() const {
    TagBlockOptions o;
    o.corner_sigma = *corner_sigma;
    o.self_calibration = *self_calibration != "off";
    o.free_interior = *free_interior;
    o.image_principal_point_sigma = *self_calibration == "off" ? 0 : *image_principal_point_sigma;
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
    o.robust_control = *robust_control;
    o.weak_ratio = *weak_ratio;
    o.max_iterations = static_cast<int>(*max_iterations);
    o.threads = static_cast<int>(*threads);
    return o;
  }

  /// Tells what was left out and what stands out, and refuses a weak datum if it is to.
  void report(Context& context, const TagBlock& given, const TagBlockResult& result) const {
    for (const auto& what : result.left_out) context.warn("left out: " + what);
    for (const auto& what : result.warnings) context.warn(what);
    tell_global_tests(context, result);
    for (int o : result.rejected) {
      const TagObservation& seen = given.observations[o];
      context.warn("left out as a blunder: the tag of " + given.plates[seen.plate].anchor + " in " +
                   given.images[seen.image].name);
    }
    for (size_t j = 0; j < result.plates.size(); ++j)
      if (result.images_per_plate[j] < 2)
        context.warn(given.plates[result.plates[j]].anchor +
                     " is seen in one image only: its depth rests on the tag's size");
    context.metric("sigma0", result.sigma0, "1");
    context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
    if (result.weak_datum.empty()) return;
    const std::string text = "control holds " + text::enumerate(result.weak_datum) +
                             " of the block only weakly: its anchors may move by " +
                             std::to_string(result.weakest_datum_sigma) + " m rms (1 sigma)";
    if (*weak_datum == "error")
      throw std::runtime_error(text + "; add control that is not on one line, or set weak_datum to 'warn'");
    context.warn(text);
  }
};

}  // namespace plumbline::block
