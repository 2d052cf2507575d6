#include "runtime/base/printable.hpp"

#include <cstdint>

namespace plumbline::runtime {

namespace {

/// Length of the UTF-8 sequence at `at`, 0 if there is none, and its character.
size_t sequence(const std::string& text, size_t at, uint32_t& character) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at);
  const size_t length = first < 0x80                    ? 1
                        : first >= 0xc2 && first < 0xe0 ? 2
                        : first >= 0xe0 && first < 0xf0 ? 3
                        : first >= 0xf0 && first < 0xf5 ? 4
                                                        : 0;
  if (length == 0 || at + length > text.size()) return 0;
  character = length == 1 ? first : first & (0x7fu >> length);
  for (size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xc0) != 0x80) return 0;
    character = (character << 6) | (byte(at + i) & 0x3fu);
  }
  constexpr uint32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = character >= 0xd800 && character < 0xe000;
  return character < smallest[length] || character > 0x10ffff || surrogate ? 0 : length;
}

/// Controls of both tables, and the characters that turn the direction of what follows.
bool is_control(uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || (c >= 0x202a && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

void write_out(const std::string& text, size_t at, size_t length, std::string& result) {
  for (size_t i = at; i < at + length; ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    result += {'\\', 'x', "0123456789abcdef"[c >> 4], "0123456789abcdef"[c & 15]};
  }
}

std::string printable(const std::string& text, bool keep_lines) {
  std::string result;
  result.reserve(text.size());
  for (size_t at = 0; at < text.size();) {
    uint32_t character = 0;
    const size_t length = sequence(text, at, character);
    const bool line_end_or_tab = keep_lines && (character == '\n' || character == '\t');
    if (length > 0 && (!is_control(character) || line_end_or_tab))
      result.append(text, at, length);
    else
      write_out(text, at, length > 0 ? length : 1, result);
    at += length > 0 ? length : 1;
  }
  return result;
}

}  // namespace

std::string printable(const std::string& text) { return printable(text, true); }

std::string printable_line(const std::string& text) { return printable(text, false); }

}  // namespace plumbline::runtime
