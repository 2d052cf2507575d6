#include "instant.hpp"

#include <fmt/core.h>

#include <chrono>
#include <cstdio>

namespace plumbline::ifc {

std::optional<Instant> instant_of(const std::string& text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  char a = 0, b = 0, c = 0;
  if (std::sscanf(text.c_str(), "%4d%c%2d%c%2d%c%2d:%2d:%2d", &year, &a, &month, &b, &day, &c, &hour, &minute,
                  &second) < 5 ||
      a != b || (a != '-' && a != ':' && a != '/')) {
    hour = minute = second = 0;
    if (std::sscanf(text.c_str(), "%2d.%2d.%4d%c%2d:%2d:%2d", &day, &month, &year, &c, &hour, &minute, &second) < 3)
      return {};
  }
  if (year < 1990 || year > 2200 || month < 1 || month > 12 || day < 1 || day > 31 || hour > 23 || minute > 59 ||
      second > 60)
    return {};
  const std::chrono::sys_days days = std::chrono::year(year) / month / day;
  Instant instant;
  instant.seconds = days.time_since_epoch().count() * 86400 + hour * 3600 + minute * 60 + second;
  instant.text = fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", year, month, day, hour, minute, second);
  return instant;
}

}  // namespace plumbline::ifc
