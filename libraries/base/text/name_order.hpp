// Names in the order in which people count.
#pragma once

#include <string>

namespace plumbline::text {

/// Numbers in them by their size, capitals and small letters alike: a2 before A10. Of names that this does not tell
/// apart the order is that of their bytes.
bool before_by_name(const std::string& a, const std::string& b);

}  // namespace plumbline::text
