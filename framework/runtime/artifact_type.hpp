// What the runtime does with artifacts without knowing any: verify, print as JSON, compare two builds of one type.
// All by reflection over the binary schema that travels with the plugin.
#pragma once

#include <string>
#include <string_view>

#include "plumbline/plugin.h"

namespace plumbline::runtime {

/// Empty if `bytes` are a well-formed artifact of the type, else what is wrong. Safe on any bytes.
std::string verify_artifact(const plumbline_type& type, plumbline_bytes bytes);

/// The artifact as JSON text, indented by two blanks. Numbers print so that they read back the same bits; nan and
/// infinities print as null; structs of numbers print as arrays ([x, y, z]; quaternions [w, x, y, z]). `bytes` must be
/// verified.
std::string artifact_to_json(const plumbline_type& type, plumbline_bytes bytes);

/// Why two builds of one type do not fit, naming the field: "plumbline.Points.position is in unit 'm' here and 'mm'
/// there". Empty if they do: equal fingerprints, or fields only added.
std::string compare_types(const plumbline_type& here, const plumbline_type& there);

}  // namespace plumbline::runtime
