// A facade as a picture without perspective: every pixel is taken where the measured surface is, from the photograph
// that shows its panel best.
#pragma once

#include <cstdint>
#include <vector>

#include "surface/dense/facet_tile.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

/// The pixel in column x and row y is the square of `pixel` [m] about area.low.x + (x + 0.5) pixel to the right and
/// area.high.y − (y + 0.5) pixel upwards on the plane.
struct Orthophoto {
  FacadePlane plane;
  Rectangle area;
  double pixel = 0.002;  ///< [m]
  int width = 0, height = 0;
  std::vector<std::uint8_t> grey;  ///< 0: nothing was seen; what was is at least 1
};

/// Faces that lie in one plane within `offset` [m] and 5°, as numbers in their order; a facade each.
std::vector<std::vector<size_t>> facades_of(const std::vector<PanelFace>& faces, double offset = 0.3);

/// The empty picture of some faces, with `margin` [m] around them. Its pixels are larger than `pixel` where it would
/// have more than `most` of them.
Orthophoto orthophoto_of(const std::vector<PanelFace>& faces, const std::vector<size_t>& facade, double pixel,
                         double margin, double most);

/// The photograph that shows a face best: of those that show all of it, else its middle, the one with the smallest
/// pixels on it. −1: none does.
int best_view(const PanelFace& face, const std::vector<FacetView>& views);

/// Fills the pixels of a face, `beyond` [m] around it where nothing is yet, from a photograph. `surface`: as the panel
/// is; one that was not measured lies where it was designed.
void paint(const PanelFace& face, const PanelSurface& surface, const FacetView& view, double beyond,
           Orthophoto& picture);

}  // namespace plumbline::surface
