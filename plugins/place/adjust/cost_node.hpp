// evaluate.cost: what an adjustment minimises, of any start and any result.
#pragma once

#include <fmt/core.h>

#include "artifacts/file.hpp"
#include "photo/block/tag_cost.hpp"
#include "tag_block_artifacts.hpp"

namespace plumbline::block {

struct EvaluateCost : Node {
  static constexpr Info info{"evaluate.cost", "", 3,
                             "Cost of poses, anchors and camera against the images and the survey, whatever made them"};
  List<ImageTags> observations{"observations", "tags of every image"};
  In<Poses> poses{"poses", frame("frame=?F"), "exterior orientations to be judged"};
  In<Camera> camera{"camera", "interior orientation to be judged"};
  In<Plates> plates{"plates", frame("frame=?F"), "which tag stands for which anchor"};
  Optional<Points> points{"points", frame("frame=?F"),
                          "anchors to be judged; plates may turn about them as fits best. Without them: the cost where "
                          "every adjuster starts from the poses"};
  Optional<Points> control{"control", frame("frame=?F"), "surveyed anchors; their misfit is part of the cost"};
  Param<double> corner_sigma{"corner_sigma", 0.1, "px", between(1e-4, 100),
                             "standard deviation of a corner whose detector gives none"};
  Optional<Camera> calibration{"calibration",
                               "calibration that an adjustment started from; how far the camera is from it "
                               "is part of the cost, by its covariance"};
  Param<double> tag_scale_sigma{
      "tag_scale_sigma", 1e-3, "1", at_least(0),
      "standard deviation of a print batch's relative tag size, which goes where it fits best; "
      "0: tags have the printed size"};
  Param<double> corner_inset_sigma{
      "corner_inset_sigma", 0.3, "px", between(0, 10),
      "standard deviation of how far edges are drawn inwards, where the detector states none; 0: they are not"};
  Param<double> image_principal_point_sigma{"image_principal_point_sigma", 0.0, "px", between(0, 100),
                                            "standard deviation of an image's own principal point; 0: as it is given"};
  Param<std::string> self_calibration{"self_calibration", "prior", one_of("off", "prior", "free"),
                                      "prior: the calibration counts"};
  Param<std::vector<std::string>> free_interior{
      "free_interior", std::vector<std::string>{"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"},
      "interior parameters that an adjustment freed, which the calibration is compared in"};
  Out<File> cost{"cost", "sums of squared weighted residuals of images and control, as JSON"};

  void run(Context& context) override {
    TagBlockBuilder builder(camera.unpack(), plates.unpack(), poses.unpack());
    for (size_t i = 0; i < observations.size(); ++i) builder.add_image(observations.unpack(i), *corner_sigma);
    if (control) builder.set_control(control.unpack());
    for (const auto& warning : builder.warnings()) context.warn(warning);
    const TagCost found = points ? cost_of_tag_block(builder.block(), anchors_of(points.unpack()), priors())
                                 : start_cost_of_tag_block(builder.block(), priors());
    if (found.left_out > 0)
      context.warn(std::to_string(found.left_out) +
                   " tags are not in the cost: their image has no pose or their anchor no coordinates");
    context.metric("cost", found.total(), "1");
    context.metric("cost_images", found.images, "1");
    context.metric("cost_control", found.control, "1");
    context.metric("cost_priors", found.priors, "1");
    const std::string text = fmt::format(
        "{{\"cost\": {:.17g}, \"images\": {:.17g}, \"control\": {:.17g}, \"priors\": {:.17g}, \"corner_coordinates\": "
        "{}, \"control_coordinates\": {}, \"tags_left_out\": {}}}\n",
        found.total(), found.images, found.control, found.priors, found.corner_rows, found.control_rows,
        found.left_out);
    FileT file;
    file.name = "cost.json";
    file.media_type = "application/json";
    file.content.assign(text.begin(), text.end());
    cost.commit(file);
  }

 private:
  TagCostPriors priors() {
    TagCostPriors assumed;
    assumed.tag_scale_sigma = *tag_scale_sigma;
    assumed.corner_inset_sigma = *corner_inset_sigma;
    assumed.image_principal_point_sigma = *self_calibration == "off" ? 0 : *image_principal_point_sigma;
    assumed.free_interior = *free_interior;
    if (!calibration || *self_calibration != "prior") return assumed;
    TagBlockBuilder given(calibration.unpack(), plates.unpack(), PosesT{});
    given.set_prior(true);
    assumed.calibration = given.block().cameras;
    return assumed;
  }

  static std::map<std::string, Eigen::Vector3d> anchors_of(const PointsT& judged) {
    std::map<std::string, Eigen::Vector3d> anchors;
    for (const auto& point : judged.points)
      if (point->position.allFinite()) anchors[point->id] = point->position;
    return anchors;
  }
};

}  // namespace plumbline::block
