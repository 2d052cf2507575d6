// Units of a file: what IfcUnitAssignment of the project says. Units that merely stand in the file do not count.
#pragma once

#include <string>
#include <vector>

#include "building/ifc/ifc_model.hpp"

namespace plumbline::ifc {

struct Units {
  double length = 1;                  ///< metres in one length unit
  double plane_angle = 1;             ///< radians in one plane angle unit
  std::string length_name = "METRE";  ///< "MILLIMETRE", or the name of a conversion-based unit
};

/// Appends to `warnings` where a default had to stand in. Throws step::Error for a length unit that is not positive and
/// finite.
Units read_units(const Model& model, const Entity& project, std::vector<std::string>& warnings);

/// Metres in one unit for the number of an IfcNamedUnit, radians for one of plane angle.
double unit_factor(const Model& model, std::uint64_t unit);

}  // namespace plumbline::ifc
