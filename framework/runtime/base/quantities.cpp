#include "runtime/base/quantities.hpp"

#include <cctype>
#include <cmath>
#include <cstdlib>

namespace plumbline::runtime {

namespace {

/// The number at the start, and what follows it in small letters without blanks.
double split_unit(const std::string& text, std::string& unit) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  for (; *end; ++end)
    if (*end != ' ') unit += static_cast<char>(std::tolower(static_cast<unsigned char>(*end)));
  return number;
}

}  // namespace

std::optional<uint64_t> parse_bytes(const std::string& text) {
  std::string unit;
  const double number = split_unit(text, unit);
  double factor = 1;
  if (!unit.empty() && unit != "b") {
    const std::string prefixes = "kmgt", rest = unit.substr(1);
    const size_t prefix = prefixes.find(unit[0]);
    if (prefix == std::string::npos || (!rest.empty() && rest != "b" && rest != "ib")) return std::nullopt;
    factor = std::pow(rest == "b" ? 1000 : 1024, static_cast<double>(prefix + 1));
  }
  if (!(number > 0) || !(number * factor < 9e18)) return std::nullopt;
  return static_cast<uint64_t>(number * factor);
}

std::optional<double> parse_seconds(const std::string& text) {
  std::string unit;
  const double number = split_unit(text, unit);
  const double factor = unit.empty() || unit == "s" ? 1 : unit == "min" ? 60 : unit == "h" ? 3600 : 0;
  if (!(number > 0) || !(factor > 0) || !(number * factor < 1e9)) return std::nullopt;
  return number * factor;
}

}  // namespace plumbline::runtime
