// The schema that a plugin brings for a type: whether it is one, and whether two builds of one type agree.
#pragma once

#include <set>
#include <string>

#include "plumbline/plugin.h"

namespace plumbline::runtime {

/// Empty if the schema is whole and is what its entry says: name, version, fingerprint. Safe on any bytes; after it,
/// verify_artifact() is safe on any artifact.
std::string check_schema(const plumbline_type& type);

/// Names of the frame parameters that the root table declares. The schema must be checked.
std::set<std::string> frame_parameters(const plumbline_type& type);

/// Why an artifact written by a plugin built with `there` must not be read by one built with `here`, slot by slot:
/// "field 3 of plumbline.Points is 'height' in unit 'm' here and 'depth' in unit 'mm' there". Empty if it may: equal
/// fingerprints, or fields only added at the end that need not be there.
std::string compare_types(const plumbline_type& here, const plumbline_type& there);

}  // namespace plumbline::runtime
