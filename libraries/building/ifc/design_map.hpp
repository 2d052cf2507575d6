// The georeference of a design as its file writes it.
#pragma once

#include "building/ifc/design.hpp"
#include "building/ifc/design_relations.hpp"

namespace plumbline::ifc {

/// Reads IfcMapConversion, IfcRigidOperation or ePset_MapConversion into design.map_conversion, with a warning for
/// every sign that it may not mean what the standard says. design.length_unit and design.site_origin are known already.
void read_map_conversion(const Model& model, Damage& damage, Design& design);

}  // namespace plumbline::ifc
