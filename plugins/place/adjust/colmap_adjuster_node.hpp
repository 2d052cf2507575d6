// adjust.colmap: a block of marker plates adjusted by Debian's `colmap` program.
#pragma once

#include <map>
#include <set>

#include "artifacts/block.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "global_tests.hpp"
#include "photo/colmap/tag_block.hpp"
#include "plumbline/node.hpp"
#include "tag_block_artifacts.hpp"

namespace plumbline::block {

struct ColmapAdjuster : Node {
  static constexpr Info info{
      "adjust.colmap",
      "adjuster",
      1,
      "Adjustment by the program colmap (apt install colmap), then registration to control (6). COLMAP knows no "
      "control, no plates, no tag size, no prior, no weights and no robust loss, and gives no covariance",
      true,
      "covariance"};
  List<ImageTags> observations{"observations", "tags of every image"};
  Optional<Poses> poses{"poses", frame("frame=?F"),
                        "approximate poses; images without one are oriented from plates they share"};
  Optional<Camera> camera{"camera", "interior orientation; what is refined starts from it, without a prior"};
  Optional<Plates> plates{"plates", frame("frame=?F"), "which tag stands for which anchor, control and check anchors"};
  Optional<Points> control{"control", frame("frame=?F"),
                           "surveyed anchors, on which COLMAP's block is registered; without them it is free"};
  Optional<ImageBlock> targets{"block", frame("frame=?F"),
                               "measured targets: refused, COLMAP has no camera in the sensor plane"};

  Param<double> corner_sigma{"corner_sigma", 0.1, "px", between(1e-4, 100),
                             "standard deviation of a corner whose detector gives none; for sigma0, not for weights"};
  Param<bool> refine_focal_length{"refine_focal_length", true, "COLMAP estimates fx and fy"};
  Param<bool> refine_principal_point{"refine_principal_point", false, "COLMAP estimates cx and cy"};
  Param<bool> refine_extra_params{"refine_extra_params", true,
                                  "COLMAP estimates k1, k2, p1 and p2; held with a warning if the camera has k3"};
  Param<std::string> scale{"scale", "estimated", one_of("fixed", "estimated"),
                           "of the registration: that of the printed tags, or estimated from the control"};
  Param<double> min_width_ratio{"min_width_ratio", 0.01, "1", between(0, 1),
                                "control narrower than this against its length is refused as a line"};
  Param<int64_t> max_iterations{"max_iterations", 100, between(1, 10000), "of COLMAP's bundle_adjuster"};
  Param<double> time_limit{"time_limit", 600.0, "s", between(1e-3, 1e6), "after which the program is ended"};
  Param<FilePath> program{"program",
                          {colmap::usual_program},
                          "COLMAP: a name on PATH, or a path; what it and its libraries are is part of the key"};

  Out<Points> points{"points", frame("frame=?F"), "adjusted anchors, without standard deviations"};
  Out<Camera> adjusted_camera{"camera", "interior orientation after the adjustment"};
  Out<Poses> adjusted_poses{"poses", frame("frame=?F"), "exterior orientations, without covariance"};
  Out<Block> block{"block", frame("frame=?F"), "statistics and residuals; what needs a covariance is nan"};

  void run(Context& context) override {
    if (targets)
      throw std::runtime_error(
          "adjust.colmap takes photographs of marker plates; COLMAP has no camera model in the sensor plane, as "
          "measured "
          "targets have: use adjust.schur or adjust.ceres");
    if (!poses || !camera || !plates)
      throw std::runtime_error("connect 'observations', 'poses', 'camera' and 'plates'");
    TagBlockBuilder builder(camera.unpack(), plates.unpack(), poses.unpack());
    for (size_t i = 0; i < observations.size(); ++i) builder.add_image(observations.unpack(i), *corner_sigma);
    if (control) {
      builder.set_control(control.unpack());
      if (builder.block().control.plates.empty())
        throw std::runtime_error("no point of 'control' is an anchor that may be control");
    }
    for (const auto& warning : builder.warnings()) context.warn(warning);
    colmap::TagBlockOptions how;
    how.bundle = {*refine_focal_length, *refine_principal_point,
                  *refine_extra_params, static_cast<int>(*max_iterations),
                  *time_limit,          program->path};
    context.info("program: " + colmap::version_of(program->path) + ", " + program->path);
    how.estimate_scale = *scale == "estimated";
    how.min_width_ratio = *min_width_ratio;
    const TagBlockResult result = colmap::adjust_plates(builder.block(), how);
    for (const auto& what : result.left_out) context.warn("left out: " + what);
    for (const auto& what : result.warnings) context.warn(what);
    tell_global_tests(context, result);
    context.metric("sigma0", result.sigma0, "1");
    context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
    TagBlockOptions described;
    described.free_network = !control;
    points.commit(builder.points(result));
    CameraT refined = builder.camera(result);
    refined.covariance.clear();
    adjusted_camera.commit(refined);
    adjusted_poses.commit(builder.poses(result));
    BlockT artifact = builder.describe(result, described);
    artifact.adjuster = info.kind;
    artifact.weighting = "equal";
    describe_interior(artifact);
    block.commit(artifact);
  }

 private:
  /// What COLMAP estimated, without a standard deviation that nobody knows.
  void describe_interior(BlockT& artifact) const {
    const std::map<std::string, bool> estimated = {{"fx", *refine_focal_length},    {"fy", *refine_focal_length},
                                                   {"cx", *refine_principal_point}, {"cy", *refine_principal_point},
                                                   {"k1", *refine_extra_params},    {"k2", *refine_extra_params},
                                                   {"k3", *refine_extra_params},    {"k4", *refine_extra_params},
                                                   {"p1", *refine_extra_params},    {"p2", *refine_extra_params}};
    std::set<std::string> fisheyes;
    for (const auto& parameter : artifact.interior_orientation)
      if (parameter->name == "k4") fisheyes.insert(parameter->camera);
    for (auto& parameter : artifact.interior_orientation) {
      const auto at = estimated.find(parameter->name);
      // k3 is a fisheye's; with Brown's, COLMAP's model has it held.
      const bool has = parameter->name != "k3" || fisheyes.count(parameter->camera) > 0;
      parameter->estimated = has && at != estimated.end() && at->second;
      if (parameter->estimated) parameter->sigma = std::nan("");
    }
  }
};

}  // namespace plumbline::block
