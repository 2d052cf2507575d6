#include "show/report/script_data.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cmath>

namespace plumbline::report {

std::string script_number(double value, int decimals) {
  if (!std::isfinite(value)) return "null";
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  return end.ec == std::errc() ? std::string(buffer, end.ptr) : "null";
}

std::string script_exact(double value) {
  if (std::isinf(value)) return value > 0 ? "1e300" : "-1e300";
  if (std::isnan(value)) return "null";
  char buffer[64];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

std::string script_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte >= 0x7F || c == '"' || c == '\\' || c == '<' || c == '>' || c == '&') {
      out += fmt::format("\\u{:04x}", byte);
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string script_vector(const Eigen::Vector3d& v, int decimals) {
  return "[" + script_number(v.x(), decimals) + "," + script_number(v.y(), decimals) + "," +
         script_number(v.z(), decimals) + "]";
}

}  // namespace plumbline::report
