// What an artifact of a type keeps beyond being well-formed: schemas/rules/*.yaml, compiled in. The runtime knows the
// kinds of rules and no type: a nan in a position or an id that stands twice is found where it leaves a node.
#pragma once

#include <string>

#include "plumbline/plugin.h"

namespace plumbline::runtime {

/// Empty if `bytes` keep the rules of the type, or it has none; else the first that is broken, with its place:
/// "points[3] 'F04-K1': sigma holds -0.001, expected no negative number". `bytes` must be verified.
std::string broken_rule(const plumbline_type& type, plumbline_bytes bytes);

/// Why bytes that are not well-formed are not, where a required field is missing: "plumbline.Point needs 'id'
/// (points[3])"; empty if it is something else. Safe on any bytes.
std::string missing_field(const plumbline_type& type, plumbline_bytes bytes);

/// The same of bytes that FlatBuffers has verified by the type's schema: it does not look whether required texts are
/// there.
std::string missing_field_of_verified(const plumbline_type& type, plumbline_bytes bytes);

}  // namespace plumbline::runtime
