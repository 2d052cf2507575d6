// What the runtime does with artifacts without knowing any: verify and print as JSON. All by reflection over the binary
// schema that travels with the plugin.
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

}  // namespace plumbline::runtime
