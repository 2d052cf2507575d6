// A facade as a picture without perspective: every pixel is taken where the measured surface is, from the photograph
// that shows its panel best.
#pragma once

#include <cstdint>
#include <vector>

#include "surface/dense/facet_tile.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

/// How a pixel of the picture came about.
enum class Shown : std::uint8_t {
  unseen = 0,         ///< no photograph shows the place, or something else of the building hides it in all that would
  contradicted = 85,  ///< photographs show different things there: something stands before the panel in some of them
  unchecked = 170,    ///< from one photograph: no other shows it, or where the panel's surface lies is not known
  agreed = 255,       ///< most of the photographs that show it show the same
};

/// The pixel in column x and row y is the square of `pixel` [m] about area.low.x + (x + 0.5) pixel to the right and
/// area.high.y − (y + 0.5) pixel upwards on the plane.
struct Orthophoto {
  FacadePlane plane;
  Rectangle area;
  double pixel = 0.002;  ///< [m]
  int width = 0, height = 0;
  std::vector<std::uint8_t> grey;  ///< 0: unseen or contradicted; what was seen is at least 1
  std::vector<Shown> shown;
};

/// Faces that lie in one plane within `offset` [m] and 5°, as numbers in their order; a facade each.
std::vector<std::vector<size_t>> facades_of(const std::vector<PanelFace>& faces, double offset = 0.3);

/// The empty picture of some faces, with `margin` [m] around them. Its pixels are larger than `pixel` where it would
/// have more than `most` of them.
Orthophoto orthophoto_of(const std::vector<PanelFace>& faces, const std::vector<size_t>& facade, double pixel,
                         double margin, double most);

/// The picture with at most `most` pixels each way, each the mean of what is shown; 0 where less than half is.
GreyImage reduced(const Orthophoto& picture, int most);

/// Photographs of a face, the best first: those that show all of it before those that show its middle, and the ones
/// with smaller pixels on it first; one that looks from where another does (within 2°) only behind all that do not,
/// because what stands before the face would lie at the same place in both. Numbers into `views`.
std::vector<size_t> views_for_picture(const PanelFace& face, const std::vector<FacetView>& views);

}  // namespace plumbline::surface
