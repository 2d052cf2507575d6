// Heights of a facade from rectified pairs of photographs by semi-global matching.
#pragma once

#include "depth_node.hpp"

namespace plumbline::surface {

struct SemiGlobal : DepthNode {
  static constexpr Info info{"dense.sgm", "depth", 3,
                             "Measures the heights of panels in rectified pairs of photographs by semi-global matching "
                             "(OpenCV's StereoSGBM), where pairs of three photographs agree"};
  Param<int64_t> block{"block", 5, between(3, 11), "edge of what the matcher compares, odd"};
  Param<int64_t> each{"each", 2, between(1, 8), "pairs that a photograph takes part in"};
  Param<int64_t> pairs{"pairs", 10, between(2, 60), "pairs of a face"};
  Param<bool> refine{
      "refine", true,
      "bring both photographs together at each cell by least squares; without it heights are drawn towards whole "
      "disparities, a panel's all alike, and matching_sigma has to be 0.12 px or more"};
  Param<double> matching_sigma{"matching_sigma", 0.02, "px", between(0.0, 2),
                               "of a disparity: what the matcher is off by beside the photographs' noise"};

 protected:
  void measure_face(Context& context, const Photographs& photographs, const std::vector<FacetView>& views,
                    const PanelFace& face, std::vector<FacetTile>& tiles, PartialTiles& kept) const override;
};

}  // namespace plumbline::surface
