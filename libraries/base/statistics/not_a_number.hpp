// What stands for a figure that is not known.
#pragma once

#include <limits>

namespace plumbline::statistics {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace plumbline::statistics
