// Lists and lengths as people write them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace plumbline::text {

/// "a, b, c"; of more than `most`: "a, b and 4 more".
std::string join(const std::vector<std::string>& words, std::size_t most = static_cast<std::size_t>(-1));

/// "a", "a and b", "a, b and c".
std::string enumerate(const std::vector<std::string>& words, const char* last = " and ", const char* between = ", ");

/// "12.0 mm" of a length in metres.
std::string millimetres(double metres, int decimals = 1);

}  // namespace plumbline::text
