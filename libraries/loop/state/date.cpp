#include "loop/state/date.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace plumbline::loop {
namespace {

/// Of "Z", "+02:00", "-0530" or "+02" [min].
std::optional<int> zone_of(const std::string& text) {
  if (text == "Z" || text == "z") return 0;
  int hours = 0, minutes = 0, used = 0;
  if (text.size() < 3 || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const char* digits = text.c_str() + 1;
  if ((std::sscanf(digits, "%2d:%2d%n", &hours, &minutes, &used) == 2 && used == 5 && text.size() == 6) ||
      (std::sscanf(digits, "%2d%2d%n", &hours, &minutes, &used) == 2 && used == 4 && text.size() == 5) ||
      (std::sscanf(digits, "%2d%n", &hours, &used) == 1 && used == 2 && text.size() == 3)) {
    if (hours > 14 || minutes > 59 || hours < 0 || minutes < 0) return std::nullopt;
    return (text[0] == '-' ? -1 : 1) * (60 * hours + (text.size() == 3 ? 0 : minutes));
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> seconds_of(const std::string& date) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, used = 0;
  if (std::sscanf(date.c_str(), "%4d-%2d-%2dT%2d:%2d:%2d%n", &year, &month, &day, &hour, &minute, &second, &used) !=
          6 ||
      used != 19)
    return std::nullopt;
  std::size_t at = 19;
  double fraction = 0;
  if (at < date.size() && date[at] == '.') {
    const std::size_t end = date.find_first_not_of("0123456789", at + 1);
    if (end == std::string::npos || end == at + 1 || end > at + 10) return std::nullopt;
    fraction = std::strtod(("0" + date.substr(at, end - at)).c_str(), nullptr);
    at = end;
  }
  const std::optional<int> zone = zone_of(date.substr(at));
  const std::chrono::year_month_day given{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                          std::chrono::day(static_cast<unsigned>(day))};
  if (!zone || !given.ok() || hour > 23 || minute > 59 || second > 60 || hour < 0 || minute < 0 || second < 0)
    return std::nullopt;
  const auto days = std::chrono::sys_days(given).time_since_epoch().count();
  return 86400.0 * static_cast<double>(days) + 3600.0 * hour + 60.0 * (minute - *zone) + second + fraction;
}

}  // namespace plumbline::loop
