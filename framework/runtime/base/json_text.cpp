#include "runtime/base/json_text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace plumbline::runtime {

namespace {

void append_quoted(std::string& to, std::string_view text) {
  const bool plain =
      std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7f && c != '"' && c != '\\'; });
  if (plain)
    to.append(1, '"').append(text).append(1, '"');
  else
    to += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::string json_quoted(std::string_view text) {
  std::string quoted;
  append_quoted(quoted, text);
  return quoted;
}

void JsonText::comma() {
  if (text_.empty()) return;
  const char last = text_.back();
  if (last != '{' && last != '[' && last != ':') text_ += ',';
}

JsonText& JsonText::open(char bracket) {
  comma();
  text_ += bracket;
  return *this;
}

JsonText& JsonText::close(char bracket) {
  text_ += bracket;
  return *this;
}

JsonText& JsonText::name(std::string_view text) {
  comma();
  append_quoted(text_, text);
  text_ += ':';
  return *this;
}

JsonText& JsonText::value(std::string_view text) {
  comma();
  append_quoted(text_, text);
  return *this;
}

JsonText& JsonText::value(double number) {
  comma();
  if (!std::isfinite(number)) {
    text_ += "null";
    return *this;
  }
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
  const std::string_view written(digits, static_cast<std::size_t>(end - digits));
  text_ += written;
  if (written.find_first_of(".e") == std::string_view::npos) text_ += ".0";  // stays a number with a fraction
  return *this;
}

JsonText& JsonText::value(std::uint64_t number) {
  comma();
  text_ += std::to_string(number);
  return *this;
}

JsonText& JsonText::value(const std::vector<std::string>& texts) {
  open('[');
  for (const std::string& text : texts) value(text);
  return close(']');
}

}  // namespace plumbline::runtime
