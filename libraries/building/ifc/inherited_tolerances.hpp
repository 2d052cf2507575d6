// Tolerances that a design asks for on what holds its anchors and panels: assembly, curtain wall, storey, building,
// group.
#pragma once

#include "building/ifc/design.hpp"
#include "building/ifc/design_relations.hpp"

namespace plumbline::ifc {

/// What is asked of an assembly, a curtain wall, a storey or a group is asked of the anchors and panels in it.
/// Properties of sets about tolerances go with them, the nearest holder first, under the name of what has them; the
/// judgement says what becomes of it. `length_unit` in metres.
void inherit_tolerances(const Model& model, const Tree& tree, double length_unit, Damage& damage, Design& design);

}  // namespace plumbline::ifc
