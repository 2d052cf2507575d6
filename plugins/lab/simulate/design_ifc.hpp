// The design of the simulated building as an IFC 4 file: storeys, slabs, curtain-wall panels, and an anchor with a
// solid at each design anchor point. Project coordinates are the building frame.
#pragma once

#include <cstdint>
#include <string>

#include "building.hpp"

namespace plumbline::simulate {

/// The text of the file. Anchors are IfcMechanicalFastener named with Anchor::id whose placement lies at the design
/// point; each panel is connected to its slab through its anchors. Equal input gives equal GlobalIds and bytes.
/// `millimetres`: the file's length unit is mm instead of m.
std::string write_design_ifc(const Building& building, std::uint64_t seed, bool millimetres);

}  // namespace plumbline::simulate
