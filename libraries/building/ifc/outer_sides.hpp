// Whether the sides of a shape are planes and rectangles: a panel that is meant to be curved is not flat, and is not to
// be, and of a rectangle about a triangle a part is its neighbours'.
#pragma once

#include <vector>

#include "building/ifc/ifc_extent.hpp"

namespace plumbline::ifc {

/// By how much each side of a shape is no plane square to an axis, seen from there: how far apart its parts lie along
/// the axis, without 2 % of them at either end and without a border of 30 mm (returns, chamfers). In the order: towards
/// smaller x, larger x, smaller y, larger y, smaller z, larger z; in the unit of the points, of which `metres` are one;
/// nan where the shape shows itself on less than half of a side. Empty where an item does not tell its faces.
std::vector<double> sag_of_sides(const std::vector<ItemExtent>& items, double metres);

/// In the same order: the share of each side's rectangle, without that border, that the shape shows itself on. Holes
/// are not told.
std::vector<double> filled_sides(const std::vector<ItemExtent>& items, double metres);

/// In the same order: the rectangle of each side, of the outermost faces square to its axis that lie in one plane and
/// take at least half of the box's side: of a sheet before a wider core the sheet's, of a cassette with chamfers the
/// face between them. Four values each: least coordinates along the two other axes, in the order x, y, z, x after the
/// side's own, then the largest; in the unit of the points, nan where no faces take that much. Empty: none is
/// narrower than the box.
std::vector<double> rectangles_of_sides(const std::vector<ItemExtent>& items, double metres);

/// What these say of an element's sides.
struct SidesOfShape {
  std::vector<double> sag, filled, rectangles;
};

/// The same of elements of a file, in metres; empty also where a shape cannot be read.
class OuterSides {
 public:
  OuterSides(const Model& model, double metres, double plane_angle)
      : metres_(metres), extents_(model, plane_angle, true) {}
  SidesOfShape of(const Entity& element);

 private:
  double metres_;
  Extents extents_;
};

}  // namespace plumbline::ifc
