#include "base/text/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <system_error>

namespace plumbline::text {
namespace {

// Windows-1252 0x80..0x9F; zero where the code page leaves the byte open.
constexpr std::array<char32_t, 32> kWindows1252High = {0x20AC, 0,      0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                                       0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0,      0x017D, 0,
                                                       0,      0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                                       0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0,      0x017E, 0x0178};

unsigned char byte_at(std::string_view text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

void append_utf8(std::string& out, char32_t c) {
  const auto put = [&out](char32_t value) { out.push_back(static_cast<char>(static_cast<unsigned char>(value))); };
  if (c < 0x80) {
    put(c);
  } else if (c < 0x800) {
    put(0xC0 | (c >> 6)), put(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    put(0xE0 | (c >> 12)), put(0x80 | ((c >> 6) & 0x3F)), put(0x80 | (c & 0x3F));
  } else {
    put(0xF0 | (c >> 18)), put(0x80 | ((c >> 12) & 0x3F)), put(0x80 | ((c >> 6) & 0x3F)), put(0x80 | (c & 0x3F));
  }
}

// Length of the valid UTF-8 sequence at `i` and its character; length 0 if there is none.
struct Sequence {
  std::size_t length = 0;
  char32_t character = 0;
};

Sequence utf8_sequence(std::string_view text, std::size_t i) {
  const unsigned char first = byte_at(text, i);
  if (first < 0x80) return {1, first};
  std::size_t length = 0;
  char32_t c = 0, smallest = 0;
  if (first >= 0xC2 && first <= 0xDF) {
    length = 2, c = first & 0x1Fu, smallest = 0x80;
  } else if ((first & 0xF0) == 0xE0) {
    length = 3, c = first & 0x0Fu, smallest = 0x800;
  } else if (first >= 0xF0 && first <= 0xF4) {
    length = 4, c = first & 0x07u, smallest = 0x10000;
  } else {
    return {};
  }
  if (i + length > text.size()) return {};
  for (std::size_t k = 1; k < length; ++k) {
    const unsigned char next = byte_at(text, i + k);
    if ((next & 0xC0) != 0x80) return {};
    c = (c << 6) | (next & 0x3Fu);
  }
  if (c < smallest || c > 0x10FFFF || (c >= 0xD800 && c <= 0xDFFF)) return {};
  return {length, c};
}

bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_sequence(text, i).length;
    if (length == 0) return false;
    i += length;
  }
  return true;
}

std::string from_utf16(std::string_view bytes, bool little) {
  std::string out;
  out.reserve(bytes.size() / 2);
  const auto unit = [&](std::size_t i) -> char32_t {
    const char32_t a = byte_at(bytes, i), b = byte_at(bytes, i + 1);
    return little ? (b << 8 | a) : (a << 8 | b);
  };
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    char32_t c = unit(i);
    if (c >= 0xD800 && c <= 0xDBFF && i + 3 < bytes.size()) {
      const char32_t low = unit(i + 2);
      if (low >= 0xDC00 && low <= 0xDFFF) {
        c = 0x10000 + ((c - 0xD800) << 10) + (low - 0xDC00);
        i += 2;
      }
    }
    if (c >= 0xD800 && c <= 0xDFFF) c = 0xFFFD;
    append_utf8(out, c);
  }
  return out;
}

std::string from_windows_1252(std::string_view bytes) {
  std::string out;
  out.reserve(bytes.size() + bytes.size() / 8);
  for (const char raw : bytes) {
    char32_t c = static_cast<unsigned char>(raw);
    if (c >= 0x80 && c < 0xA0 && kWindows1252High[c - 0x80] != 0) c = kWindows1252High[c - 0x80];
    append_utf8(out, c);
  }
  return out;
}

// Zero bytes only at even or only at odd places among the first 64: two-byte text without a byte order mark.
std::optional<Encoding> guess_utf16(std::string_view bytes) {
  const std::size_t n = std::min<std::size_t>(bytes.size() & ~std::size_t{1}, 64);
  if (n < 8) return std::nullopt;
  std::size_t even = 0, odd = 0;
  for (std::size_t i = 0; i < n; ++i) (i % 2 ? odd : even) += bytes[i] == '\0' ? 1 : 0;
  if (even == 0 && odd * 4 >= n) return Encoding::utf16_little_endian;
  if (odd == 0 && even * 4 >= n) return Encoding::utf16_big_endian;
  return std::nullopt;
}

// Control characters have no meaning in any of the formats but turn up in damaged files: what dumps are padded with
// becomes a blank, the others '?', so that columns stay and names can be printed.
DecodedText printable(DecodedText decoded) {
  for (char& c : decoded.text) {
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7F) continue;
    if (c == '\n' || c == '\r' || c == '\t') continue;
    c = c == '\0' || c == '\f' || c == '\v' || c == 0x1A ? ' ' : '?';
  }
  return decoded;
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\0'; }

// Blanks that nobody sees are in names that came from a web page or a PDF: no-break space, the narrow and the figure
// space, those without width, a byte order mark in the middle of a file.
constexpr std::array<std::string_view, 9> kWideBlanks = {"\xC2\xA0",     "\xE2\x80\xAF", "\xE2\x80\x87",
                                                         "\xE2\x80\x89", "\xE2\x80\x8B", "\xE2\x80\x8E",
                                                         "\xE2\x80\x8F", "\xE3\x80\x80", "\xEF\xBB\xBF"};

std::size_t blank_before(std::string_view text) {
  if (text.empty() || static_cast<unsigned char>(text.front()) < 0x80) return !text.empty() && is_blank(text.front());
  for (const std::string_view blank : kWideBlanks)
    if (text.starts_with(blank)) return blank.size();
  return 0;
}

std::size_t blank_behind(std::string_view text) {
  if (text.empty() || static_cast<unsigned char>(text.back()) < 0x80) return !text.empty() && is_blank(text.back());
  for (const std::string_view blank : kWideBlanks)
    if (text.ends_with(blank)) return blank.size();
  return 0;
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

DecodedText decode(std::string_view bytes) {
  if (bytes.starts_with("\xEF\xBB\xBF")) {
    bytes.remove_prefix(3);
    return is_utf8(bytes) ? DecodedText{std::string(bytes), Encoding::utf8}
                          : DecodedText{from_windows_1252(bytes), Encoding::windows_1252};
  }
  if (bytes.starts_with("\xFF\xFE")) return {from_utf16(bytes.substr(2), true), Encoding::utf16_little_endian};
  if (bytes.starts_with("\xFE\xFF")) return {from_utf16(bytes.substr(2), false), Encoding::utf16_big_endian};
  if (const auto guess = guess_utf16(bytes))
    return {from_utf16(bytes, *guess == Encoding::utf16_little_endian), *guess};
  if (is_utf8(bytes)) return {std::string(bytes), Encoding::utf8};
  return {from_windows_1252(bytes), Encoding::windows_1252};
}

}  // namespace

const char* name_of(Encoding encoding) {
  switch (encoding) {
    case Encoding::utf16_little_endian:
      return "UTF-16 (little endian)";
    case Encoding::utf16_big_endian:
      return "UTF-16 (big endian)";
    case Encoding::windows_1252:
      return "Windows-1252";
    case Encoding::utf8:
      break;
  }
  return "UTF-8";
}

DecodedText decode_text(std::string_view bytes) { return printable(decode(bytes)); }

std::optional<std::string> encode_windows_1252(std::string_view utf8) {
  std::string out;
  for (std::size_t i = 0; i < utf8.size();) {
    const Sequence sequence = utf8_sequence(utf8, i);
    if (sequence.length == 0) return std::nullopt;
    i += sequence.length;
    const char32_t c = sequence.character;
    if (c < 0x80 || (c >= 0xA0 && c <= 0xFF)) {
      out.push_back(static_cast<char>(static_cast<unsigned char>(c)));
      continue;
    }
    const auto found = std::find(kWindows1252High.begin(), kWindows1252High.end(), c);
    if (c == 0 || found == kWindows1252High.end()) return std::nullopt;
    out.push_back(static_cast<char>(static_cast<unsigned char>(0x80 + (found - kWindows1252High.begin()))));
  }
  return out;
}

std::vector<Line> split_lines(std::string_view text) {
  std::vector<Line> lines;
  int number = 1;
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t end = std::min(text.find_first_of("\r\n", start), text.size());
    lines.push_back({text.substr(start, end - start), number++});
    start = end + (text.substr(end).starts_with("\r\n") ? 2 : 1);
  }
  return lines;
}

CharacterLine::CharacterLine(std::string_view utf8) : text_(utf8) {
  ascii_ = std::all_of(utf8.begin(), utf8.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
  if (ascii_) return;
  for (std::size_t i = 0; i < utf8.size();) {
    starts_.push_back(i);
    i += std::max<std::size_t>(1, utf8_sequence(utf8, i).length);
  }
  starts_.push_back(utf8.size());
}

char CharacterLine::at(std::size_t index) const {
  const char c = text_[ascii_ ? index : starts_[index]];
  return static_cast<unsigned char>(c) < 0x80 ? c : '\x01';
}

std::string_view CharacterLine::part(std::size_t index, std::size_t count) const {
  if (index >= size()) return {};
  count = std::min(count, size() - index);
  if (ascii_) return text_.substr(index, count);
  return text_.substr(starts_[index], starts_[index + count] - starts_[index]);
}

std::string_view trim(std::string_view text) {
  while (const std::size_t n = blank_before(text)) text.remove_prefix(n);
  while (const std::size_t n = blank_behind(text)) text.remove_suffix(n);
  return text;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

std::string to_lower(std::string_view ascii) {
  std::string out(ascii);
  std::transform(out.begin(), out.end(), out.begin(), lower);
  return out;
}

std::vector<std::string_view> split(std::string_view text, char delimiter) {
  std::vector<std::string_view> parts;
  for (std::size_t start = 0;;) {
    const std::size_t end = text.find(delimiter, start);
    parts.push_back(text.substr(start, end == std::string_view::npos ? end : end - start));
    if (end == std::string_view::npos) return parts;
    start = end + 1;
  }
}

std::vector<std::string_view> split_blanks(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t i = 0; i < text.size();) {
    while (i < text.size() && is_blank(text[i])) ++i;
    const std::size_t start = i;
    while (i < text.size() && !is_blank(text[i])) ++i;
    if (i > start) parts.push_back(text.substr(start, i - start));
  }
  return parts;
}

std::optional<double> parse_number(std::string_view token, char decimal) {
  token = trim(token);
  const bool plus = !token.empty() && token.front() == '+';
  if (plus) token.remove_prefix(1);
  // from_chars would take 'nan' and 'infinity'; a longer token than this is no measured value.
  if (token.empty() || token.size() > 64 || (plus && token.front() == '-')) return std::nullopt;
  std::array<char, 64> digits{};
  for (std::size_t i = 0; i < token.size(); ++i) {
    char c = token[i];
    if (c == decimal) {
      c = '.';
    } else if (!((c >= '0' && c <= '9') || c == '-' || c == '+' || c == 'e' || c == 'E')) {
      return std::nullopt;
    }
    digits[i] = c;
  }
  double value = 0;
  const char* end = digits.data() + token.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<long long> parse_integer(std::string_view token) {
  token = trim(token);
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  long long value = 0;
  const auto [stop, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (token.empty() || error != std::errc() || stop != token.data() + token.size()) return std::nullopt;
  return value;
}

std::string quoted(std::string_view text, std::size_t longest) {
  const CharacterLine line(text);
  std::string out = "'";
  for (const char c : line.part(0, longest)) out.push_back(static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c);
  out += line.size() > longest ? "...'" : "'";
  return out;
}

std::string format_shortest(double value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string format_fixed(double value, int decimals) {
  std::array<char, 400> buffer{};  // 309 digits of the largest double, the point and the decimals
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed,
                                    std::clamp(decimals, 0, 60));
  std::string text(buffer.data(), result.ptr);
  if (text.front() == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

}  // namespace plumbline::text
