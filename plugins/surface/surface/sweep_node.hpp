// Heights of a facade from the photographs of an adjusted block, facet by facet in all of them at once.
#pragma once

#include "depth_node.hpp"

namespace plumbline::surface {

struct PlaneSweep : DepthNode {
  static constexpr Info info{
      "dense.plane_sweep", "depth", 4,
      "Measures the heights of panels facet by facet in all photographs that see them, with random and "
      "systematic errors"};
  Param<int64_t> max_views{"max_views", 8, between(2, 40), "the best photographs of a part that are used"};

 protected:
  void measure_face(Context& context, const Photographs& photographs, const std::vector<FacetView>& views,
                    const PanelFace& face, std::vector<FacetTile>& tiles, PartialTiles& kept) const override;
};

}  // namespace plumbline::surface
