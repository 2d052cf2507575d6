#include "show/report/script_data.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cmath>

#include "show/report/catalogue.hpp"
#include "show/report/language.hpp"

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

const std::vector<std::string>& script_texts() {
  static const std::vector<std::string> texts = {"pass",
                                                 "undecided",
                                                 "fail",
                                                 "not measured",
                                                 "unknown",
                                                 "in force",
                                                 "Anchor",
                                                 "Panel",
                                                 "Show all {0} rows",
                                                 "{0} found",
                                                 "{0}: anchors {1}",
                                                 "; panels {0}",
                                                 "; \u03b7 = {0} of {1} check anchors ({2})",
                                                 "{0}, floor {1}: {2}; as-built minus design {3} {4} (x, y, z)"};
  return texts;
}

std::string script_words() {
  std::string texts;
  if (speech().language == Language::german)
    for (const std::string& text : script_texts())
      texts += (texts.empty() ? "" : ",\n") + script_text(text) + ":" + script_text(german().find(text).value_or(text));
  return "{\"texts\":{" + texts + "}" + (speech().language == Language::german ? ",\"decimal\":\",\"" : "") +
         (speech().units == Units::inches ? ",\"unit\":" + script_text(unit_of_lengths()) : "") + "}";
}

std::string script_vector(const Eigen::Vector3d& v, int decimals) {
  return "[" + script_number(v.x(), decimals) + "," + script_number(v.y(), decimals) + "," +
         script_number(v.z(), decimals) + "]";
}

}  // namespace plumbline::report
