// Where a tolerance comes from, as verdicts carry it in words (PanelLimit.source, JudgedAxis.source).
#pragma once

#include <string_view>

namespace plumbline::ifc {

/// What the words of a tolerance begin with that nobody asked for: the common one that is assumed.
inline constexpr std::string_view kDefaultTolerance = "default";

inline bool is_default_tolerance(std::string_view source) { return source.starts_with(kDefaultTolerance); }

}  // namespace plumbline::ifc
