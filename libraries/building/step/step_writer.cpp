#include "building/step/step_writer.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace plumbline::step {
namespace {

/// Part 21 wants digits, a point, and an exponent in capitals: "1e-07" → "1.E-07".
std::string with_point(std::string_view digits) {
  const std::size_t exponent = digits.find('e');
  std::string mantissa(digits.substr(0, exponent));
  if (mantissa.find('.') == std::string::npos) mantissa += '.';
  if (exponent != std::string_view::npos) mantissa.append("E").append(digits.substr(exponent + 1));
  return mantissa;
}

void require_finite(double value) {
  if (!std::isfinite(value)) throw std::invalid_argument("step: a real that is not finite cannot be written");
}

/// Length of the UTF-8 sequence at the front of `bytes` and its code point; 0 if the bytes are not well-formed UTF-8.
int decode_utf8(std::string_view bytes, char32_t& code) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  const unsigned char first = at(0);
  const int length = first < 0x80 ? 1 : (first >> 5) == 6 ? 2 : (first >> 4) == 14 ? 3 : (first >> 3) == 30 ? 4 : 0;
  if (length == 0 || bytes.size() < static_cast<std::size_t>(length)) return 0;
  code = length == 1 ? first : static_cast<char32_t>(first & (0xFF >> (length + 1)));
  for (int i = 1; i < length; ++i) {
    if ((at(i) & 0xC0) != 0x80) return 0;
    code = (code << 6) | (at(i) & 0x3F);
  }
  constexpr std::array<char32_t, 5> smallest{0, 0, 0x80, 0x800, 0x10000};  // anything below is an overlong form
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  return code < smallest[length] || code > 0x10FFFF || surrogate ? 0 : length;
}

void append_hex(std::string& out, char32_t value, int digits) {
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) out += "0123456789ABCDEF"[(value >> shift) & 15];
}

}  // namespace

std::string real(double value) {
  require_finite(value);
  if (value == 0) return "0.";  // also minus zero: a sign there says nothing and makes lines differ
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return with_point({buffer.data(), end});
}

std::string real_rounded(double value, int decimals) {
  require_finite(value);
  if (std::abs(value) > 1e15) return real(value);
  std::array<char, 64> buffer;
  auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals).ptr;
  std::string digits(buffer.data(), end);
  if (digits.find('.') == std::string::npos) digits += '.';
  while (digits.back() == '0') digits.pop_back();
  return digits == "-0." ? "0." : digits;
}

std::string integer(std::int64_t value) { return std::to_string(value); }

std::string text(std::string_view utf8) {
  std::string out = "'";
  int width = 0;  // hex digits a character in the open \X2\ or \X4\ run; 0 outside a run
  const auto close_run = [&] {
    if (width != 0) out += "\\X0\\";
    width = 0;
  };
  while (!utf8.empty()) {
    char32_t code = static_cast<unsigned char>(utf8[0]);
    const int length = std::max(1, decode_utf8(utf8, code));
    utf8.remove_prefix(static_cast<std::size_t>(length));
    if (code >= 0x20 && code < 0x7F) {
      close_run();
      out += static_cast<char>(code);
      if (code == '\'' || code == '\\') out += static_cast<char>(code);
      continue;
    }
    const int needed = code > 0xFFFF ? 8 : 4;
    if (needed != width) {
      close_run();
      out += needed == 8 ? "\\X4\\" : "\\X2\\";
      width = needed;
    }
    append_hex(out, code, width);
  }
  close_run();
  return out + "'";
}

std::string enumeration(std::string_view name) { return "." + std::string(name) + "."; }
std::string boolean(bool value) { return value ? ".T." : ".F."; }
std::string reference(std::uint64_t id) { return "#" + std::to_string(id); }

std::string list(const std::vector<std::string>& items) {
  std::string out = "(";
  for (std::size_t i = 0; i < items.size(); ++i) out.append(i ? "," : "").append(items[i]);
  return out + ")";
}

std::string typed(std::string_view keyword, const std::string& value) {
  return std::string(keyword) + "(" + value + ")";
}

std::string instance(std::uint64_t id, std::string_view keyword, const std::vector<std::string>& arguments) {
  return reference(id) + "=" + std::string(keyword) + list(arguments) + ";";
}

}  // namespace plumbline::step
