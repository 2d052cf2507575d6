// The day of a campaign as people write it.
#pragma once

#include <optional>
#include <string>

namespace plumbline::campaign {

struct Day {
  std::string iso;         ///< "2026-05-04", and the time of day behind it as it was written: "2026-05-04T10:30"
  bool day_first = false;  ///< it was written with points, day.month.year
  bool doubtful = false;   ///< somebody might take its day for the month
};

/// "2026-05-04" (also with ':' or '/' between year, month and day, as EXIF and Japan write it) or "4.5.2026", with or
/// without a time. Nothing for anything else, and for days that no calendar has: 05/04/2026 is May in Chicago and April
/// in London.
std::optional<Day> day_of(const std::string& text);

}  // namespace plumbline::campaign
