// IFC GlobalIds: 128 bits in 22 characters of a base-64 alphabet of its own, and name-based UUIDs (RFC 4122, version 5)
// so that what is written twice gets the same GlobalId twice.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace plumbline::ifc {

using Uuid = std::array<std::uint8_t, 16>;

/// UUID version 5: SHA-1 of the name space and the name.
Uuid uuid_v5(const Uuid& name_space, std::string_view name);
/// From "f70dd363-bfe3-495d-84a0-2c02dcb7d4d2"; nothing if it is not 32 hex digits with hyphens in their places.
std::optional<Uuid> uuid_from_text(std::string_view text);
std::string uuid_to_text(const Uuid& uuid);

/// f70dd363-bfe3-495d-84a0-2c02dcb7d4d2 → "3t3TDZl_D9NOIWB0BSjzJI".
std::string ifc_guid(const Uuid& uuid);
/// The inverse; nothing if `guid` is not 22 characters of the alphabet, the first of them 0 to 3.
std::optional<Uuid> uuid_from_ifc_guid(std::string_view guid);

/// The GlobalId of something derived from another object: version 5 in the name space of `parent_guid` (an IFC
/// GlobalId; one that is malformed is hashed as text, since real files hold such).
std::string derived_ifc_guid(std::string_view parent_guid, std::string_view key);

}  // namespace plumbline::ifc
