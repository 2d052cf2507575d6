#include "campaign_day.hpp"

#include <fmt/core.h>

#include <chrono>
#include <cstdio>

namespace plumbline::campaign {
namespace {

/// "", "10:30", "10:30:15.5", and a zone behind it.
bool is_time(const std::string& text) {
  if (text.empty()) return true;
  int hour = 0, minute = 0, second = 0, end = 0;
  if (std::sscanf(text.c_str(), "%2d:%2d%n", &hour, &minute, &end) != 2) return false;
  std::string rest = text.substr(static_cast<std::size_t>(end));
  if (std::sscanf(rest.c_str(), ":%2d%n", &second, &end) == 1) rest = rest.substr(static_cast<std::size_t>(end));
  const bool zone = rest.empty() || rest.find_first_not_of("0123456789.,:+-Z ") == std::string::npos;
  return zone && hour >= 0 && hour <= 23 && minute >= 0 && minute <= 59 && second >= 0 && second <= 60;
}

}  // namespace

std::optional<Day> day_of(const std::string& text) {
  int year = 0, month = 0, day = 0, end = 0;
  char first = 0, second = 0;
  Day result;
  const char* const written = text.c_str();
  const bool year_first = std::sscanf(written, "%4d%c%2d%c%2d%n", &year, &first, &month, &second, &day, &end) == 5 &&
                          first == second && (first == '-' || first == ':' || first == '/');
  if (!year_first) {
    if (std::sscanf(written, "%2d.%2d.%4d%n", &day, &month, &year, &end) != 3) return {};
    result.day_first = true;
    result.doubtful = day <= 12 && day != month;
  }
  const std::chrono::year_month_day date = std::chrono::year(year) / month / day;
  if (year < 1900 || year > 2200 || month < 1 || day < 1 || !date.ok()) return {};
  std::string time = text.substr(static_cast<std::size_t>(end));
  if (!time.empty() && time[0] != 'T' && time[0] != ' ') return {};
  if (!time.empty()) time = time.substr(1);
  if (!is_time(time)) return {};
  result.iso = fmt::format("{:04}-{:02}-{:02}{}{}", year, month, day, time.empty() ? "" : "T", time);
  return result;
}

}  // namespace plumbline::campaign
