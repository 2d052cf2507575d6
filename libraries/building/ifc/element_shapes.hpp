// Where elements of a design are: their boxes, and the point of each that is measured against.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "building/ifc/design.hpp"
#include "building/ifc/design_relations.hpp"
#include "building/ifc/ifc_extent.hpp"

namespace plumbline::ifc {

/// Slack of "the placement lies within the shape" [m]: bim practice puts origins on surfaces, and surfaces are rounded.
inline constexpr double kPlacementSlack = 0.005;

class ElementShapes {
 public:
  /// `metres`: of the file's unit of length. What cannot be read is counted in `damage`.
  ElementShapes(const Model& model, double metres, double plane_angle, Damage& damage)
      : metres_(metres), extents_(model, plane_angle), damage_(damage) {}

  /// The rule of the reference point: the placement if it lies within the element's own shape, else a point of the
  /// shape.
  void read(const Entity& entity, Element& element);
  /// Elements whose shapes are of a kind that is not read, as warnings.
  void tell_unread(Design& design) const;

 private:
  double metres_;
  Extents extents_;
  Damage& damage_;
  std::map<std::string, std::pair<int, std::string>> unread_;
};

/// Aggregates without a shape of their own (curtain walls, assemblies) lie where their parts are.
void place_aggregates(const Tree& tree, Design& design);

}  // namespace plumbline::ifc
