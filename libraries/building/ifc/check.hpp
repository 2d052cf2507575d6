// Rules that an IFC file has to keep: those WHERE and UNIQUE rules of the EXPRESS schemas and those rule families of
// buildingSMART's validation service that touch what we add (roots, property sets, placements, containment, groups,
// shapes, styles).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "building/step/step.hpp"

namespace plumbline::ifc {

struct Violation {
  std::string rule;            ///< "UniquePropertySetNames", "PSE001 reserved names", …
  std::uint64_t instance = 0;  ///< number in the file; 0: of the file as a whole
  std::string words;           ///< found, expected
};

/// All violations, in the order of the rules, then of the instances. `first` limits them to what instances with numbers
/// from it on (additions to a file) break, by themselves or against what was there before; the rules about the number
/// of schemas and projects always hold. Throws step::Error for a schema we do not read.
std::vector<Violation> check_ifc(const step::File& file, std::uint64_t first = 0);

}  // namespace plumbline::ifc
