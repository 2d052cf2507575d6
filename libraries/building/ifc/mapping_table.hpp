// The mapping table: which point is which element of the design, where names do not say it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "building/ifc/match_elements.hpp"

namespace plumbline::ifc {

/// The rows of a CSV table with columns for a point (`point`, `name` or `anchor`) and its element (`element`, `guid`,
/// `globalid` or `tag`); none of an empty text. `shown` names it in messages. Throws std::runtime_error with a line of
/// text for each row that is not complete, the first ten of them, or with what the header lacks.
std::vector<MappingRow> parse_mapping(const std::string& csv, const std::string& shown);

}  // namespace plumbline::ifc
