// Dates as survey files and people write them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace plumbline::ifc {

struct Instant {
  std::int64_t seconds = 0;  ///< since 1970
  std::string text;          ///< ISO 8601
};

/// "2026-05-12", "2026:05:12 10:11:12", "12.05.2026": year, month, day, and a time if there is one. Nothing for
/// anything else: a date that may be wrong is worse than none.
std::optional<Instant> instant_of(const std::string& text);

}  // namespace plumbline::ifc
