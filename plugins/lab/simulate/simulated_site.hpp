// The parameters that simulate.campaign and simulate.observations share.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "campaign.hpp"
#include "plumbline/node.hpp"

namespace plumbline::simulate {

struct SimulatedSite : Node {
  Param<int64_t> floors{"floors", 3, between(1, 20), "storeys of the building"};
  Param<int64_t> columns{"columns", 4, between(2, 12), "columns of control markers; two rows a floor"};
  Param<std::string> shape{
      "shape", "flat", one_of("flat", "set_back", "curved", "corner", "block", "courtyard"),
      "of the building: three facades of one direction, the middle one set back by `step`; four that bend by 15° each; "
      "two at an inner corner; four around a block or a courtyard. `columns` are those of each facade"};
  Param<double> step{"step", 1.0, "m", between(0.1, 10), "by which the middle facade of shape=set_back is set back"};
  Param<double> spacing{"spacing", 2.0, "m", between(1, 10), "of the grid, both ways; a storey is two rows high"};
  Param<double> as_built_sigma{"as_built_sigma", 0.003, "m", between(0, 0.1), "deviation of anchors from their design"};
  Param<double> tilt_sigma{"tilt_sigma", 0.025, "rad", between(0, 0.2), "rotation of plates off the facade, each axis"};
  Param<double> tag_size{"tag_size", 0.2, "m", between(0.02, 1), "edge of a tag between its detected corners"};
  Param<double> tag_scale_sigma{"tag_scale_sigma", 0.00025, "1", between(0, 0.05), "scale error of a print batch"};
  Param<int64_t> print_batches{"print_batches", 1, between(1, 20), "batches the plates were printed in"};
  Param<std::string> camera{"camera", "demo_24mp", one_of("demo_24mp", "hasselblad_100mp", "quick_6mp"),
                            "camera profile"};
  Param<int64_t> images_per_floor{"images_per_floor", 10, between(4, 100), "photographs taken from each floor"};
  Param<double> distance{"distance", 0.0, "m", between(0, 100), "of the camera from the facade; 0: the profile's"};
  Param<std::string> network{"network", "convergent", one_of("convergent", "parallel"),
                             "parallel: fronto-parallel and never rolled, weak in self-calibration"};
  Param<double> scaffold_spacing{"scaffold_spacing", 0.0, "m", between(0, 20),
                                 "between the upright tubes of a scaffold before the facade, 0.5 or more; 0: none"};
  Param<double> scaffold_distance{"scaffold_distance", 1.0, "m", between(0.2, 3), "of its tubes from the facade"};
  Param<double> lost_plates{"lost_plates", 0.0, "1", between(0, 1),
                            "probability of each plate to be gone when the photographs are taken"};

  // What real cameras, prints and plates have and ideal ones have not. A negative size is that of `optics`.
  Param<std::string> optics{"optics", "ideal", one_of("ideal", "real"),
                            "ideal: none of the perturbations that follow; real: a usual size of each"};
  Param<std::string> transfer_curve{"transfer_curve", "", one_of("", "linear", "srgb", "camera"),
                                    "from light to grey values; empty: that of optics"};
  Param<double> sharpening{"sharpening", -1.0, "1", between(-1, 3),
                           "share of the difference from the surroundings added"};
  Param<int64_t> jpeg_quality{"jpeg_quality", -1, between(-1, 100), "0: the camera profile's"};
  Param<double> motion_blur{"motion_blur", -1.0, "px", between(-1, 30), "longest movement during an exposure"};
  Param<double> rolling_shutter{"rolling_shutter", -1.0, "px", between(-1, 100),
                                "movement from the first to the last row"};
  Param<double> low_light{"low_light", -1.0, "1", between(-1, 8), "stops that light is short of: noise grows"};
  Param<double> principal_point_sigma{"principal_point_sigma", -1.0, "px", between(-1, 100), "of each image's own"};
  Param<double> distance_distortion{"distance_distortion", -1.0, "1", between(-1, 1),
                                    "relative change of k1 and k2 from image to image"};
  Param<double> depth_distortion{"depth_distortion", 0.0, "m", between(-1, 1),
                                 "k1 of what lies at the depth Z is larger by this times 1/Z - 1/distance; in observed "
                                 "corners, not in rendered photographs"};
  Param<double> ink_spread{"ink_spread", -1.0, "m", between(-1, 0.01), "growth of black at every edge"};
  Param<double> dirt{"dirt", -1.0, "1", between(-1, 1000), "specks on a plate, on average"};
  Param<double> glare{"glare", -1.0, "1", between(-1, 1), "share of plates that mirror a lamp, image by image"};
  Param<double> plate_bend{"plate_bend", -1.0, "m", between(-1, 0.1), "twist: height of a tag's corners over a plane"};
  Param<double> plate_offset_sigma{"plate_offset_sigma", -1.0, "m", between(-1, 0.1), "of a tag's place on its plate"};
  Param<double> mounting_sigma{"mounting_sigma", -1.0, "m", between(-1, 0.1), "of a plate's place on its anchor"};
  Param<double> clutter{"clutter", -1.0, "1", between(-1, 1), "share of the wall that is brick, mesh or text"};
  Param<double> cut_tags{"cut_tags", 0.0, "1", between(0, 1),
                         "share of the photographs whose border cuts through a tag, where four whole ones stay"};

  struct Size {
    const char* name;
    double given;
    double Perturbations::*size;
    bool rendered;  ///< in rendered photographs only
  };
  std::vector<Size> sizes() const {
    using P = Perturbations;
    return {{"sharpening", *sharpening, &P::sharpening, true},
            {"motion_blur", *motion_blur, &P::motion_blur, true},
            {"rolling_shutter", *rolling_shutter, &P::rolling_shutter, true},
            {"low_light", *low_light, &P::low_light, true},
            {"principal_point_sigma", *principal_point_sigma, &P::principal_point_sigma, false},
            {"distance_distortion", *distance_distortion, &P::distance_distortion, false},
            {"ink_spread", *ink_spread, &P::ink_spread, true},
            {"dirt", *dirt, &P::dirt, true},
            {"glare", *glare, &P::glare, true},
            {"plate_bend", *plate_bend, &P::plate_bend, false},
            {"plate_offset_sigma", *plate_offset_sigma, &P::plate_offset_sigma, false},
            {"mounting_sigma", *mounting_sigma, &P::mounting_sigma, false},
            {"clutter", *clutter, &P::clutter, true}};
  }

  Perturbations perturbations() const {
    Perturbations p = optics_of(*optics);
    if (!transfer_curve->empty()) p.transfer = *transfer_curve;
    p.depth_distortion = *depth_distortion;
    if (*jpeg_quality >= 0) p.jpeg_quality = static_cast<int>(*jpeg_quality);
    for (const Size& asked : sizes()) {
      if (asked.given < 0 && asked.given != -1)
        throw std::runtime_error(std::string(asked.name) + " is " + std::to_string(asked.given) +
                                 ": a size is 0 or more; -1 takes that of optics");
      if (asked.given >= 0) p.*asked.size = asked.given;
    }
    return p;
  }

  /// What was asked for by name and corners that are only observed cannot have.
  void refuse_what_is_rendered_only() const {
    std::string names;
    const auto add = [&](const std::string& name) { names += (names.empty() ? "" : ", ") + name; };
    for (const Size& asked : sizes())
      if (asked.rendered && asked.given > 0) add(asked.name);
    if (*jpeg_quality > 0) add("jpeg_quality");
    if (!transfer_curve->empty() && *transfer_curve != "linear") add("transfer_curve");
    if (!names.empty())
      throw std::runtime_error(names +
                               ": in rendered photographs only, and here corners are observed without any; take "
                               "simulate.campaign with photographs=rendered, or leave it out");
  }

  CampaignOptions site_options() const {
    CampaignOptions o;
    o.perturbations = perturbations();
    o.building.flaws = o.perturbations;
    o.shape = *shape, o.step = *step;
    o.building.floors = static_cast<int>(*floors);
    o.building.columns = static_cast<int>(*columns);
    o.building.spacing = *spacing;
    o.building.as_built_sigma = *as_built_sigma;
    o.building.plate_tilt_sigma = *tilt_sigma;
    o.building.tag_size = *tag_size;
    o.building.tag_scale_sigma = *tag_scale_sigma;
    o.building.print_batches = static_cast<int>(*print_batches);
    o.camera = *camera;
    o.cameras.images_per_floor = static_cast<int>(*images_per_floor);
    o.cameras.distance = *distance;
    o.cameras.convergent = *network == "convergent";
    o.cameras.cut_tags = *cut_tags;
    o.obstruction = {*scaffold_spacing, *scaffold_distance, *lost_plates};
    return o;
  }
};

}  // namespace plumbline::simulate
