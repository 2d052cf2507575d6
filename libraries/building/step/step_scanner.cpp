// The cursor of both passes: what it skips, and what it says is wrong.
#include "building/step/step_scanner.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace plumbline::step {
namespace {

/// Characters at which skipping over arguments has to stop and think.
constexpr std::array<bool, 256> kInteresting = [] {
  std::array<bool, 256> table{};
  for (const char c : {'(', ')', '\'', '"', '/', ';'}) table[static_cast<unsigned char>(c)] = true;
  return table;
}();

/// The first of ' " ; / = at or after `at`; the size of the text if there is none. What lies between is skipped sixteen
/// bytes at a time: this loop sees every byte of a model.
std::size_t find_special(std::string_view bytes, std::size_t at) {
#ifdef __SSE2__
  const __m128i quote = _mm_set1_epi8('\''), binary = _mm_set1_epi8('"'), end = _mm_set1_epi8(';'),
                solidus = _mm_set1_epi8('/'), equals = _mm_set1_epi8('=');
  for (; at + 16 <= bytes.size(); at += 16) {
    const __m128i block = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes.data() + at));
    const __m128i found =
        _mm_or_si128(_mm_or_si128(_mm_or_si128(_mm_cmpeq_epi8(block, quote), _mm_cmpeq_epi8(block, end)),
                                  _mm_or_si128(_mm_cmpeq_epi8(block, binary), _mm_cmpeq_epi8(block, solidus))),
                     _mm_cmpeq_epi8(block, equals));
    if (const int mask = _mm_movemask_epi8(found))
      return at + static_cast<std::size_t>(__builtin_ctz(static_cast<unsigned>(mask)));
  }
#endif
  constexpr std::string_view special = "'\";/=";
  while (at < bytes.size() && special.find(bytes[at]) == std::string_view::npos) ++at;
  return at;
}

/// Whether the apostrophe at `quote`, in the string that begins at `begin`, belongs to \S\' (U+00A7): the one directive
/// whose character may be an apostrophe that is not doubled (ISO 10303-21, LATIN_CODEPOINT).
bool shifts_code_page(std::string_view bytes, std::size_t begin, std::size_t quote) {
  if (quote < begin + 4 || bytes.substr(quote - 3, 3) != "\\S\\") return false;
  std::size_t solidi = 0;  // an even number before the S are solidi of the text
  while (quote - 3 - solidi > begin && bytes[quote - 3 - solidi] == '\\') ++solidi;
  return solidi % 2 == 1;
}

}  // namespace

std::string place(std::string_view bytes, const std::string& name, std::size_t offset) {
  std::size_t line = 1, line_begin = 0;
  for (std::size_t i = 0; i < std::min(offset, bytes.size()); ++i) {
    const bool carriage_return_alone = bytes[i] == '\r' && (i + 1 >= bytes.size() || bytes[i + 1] != '\n');
    if (bytes[i] == '\n' || carriage_return_alone) ++line, line_begin = i + 1;
  }
  return name + ":" + std::to_string(line) + ":" + std::to_string(offset - line_begin + 1);
}

void Scanner::fail_at(std::size_t offset, const std::string& message) const {
  throw Error(place(bytes_, name_, offset) + ": " + message);
}

void Scanner::fail(const std::string& expected) const {
  std::string found = "the end of the file";
  if (!ended()) {
    const auto byte = static_cast<unsigned char>(peek());
    found = "'" + std::string(1, peek()) + "'";
    if (byte < 0x20 || byte >= 0x7F) found = "byte " + std::to_string(byte);
  }
  fail_at(at, "found " + found + ", expected " + expected);
}

void Scanner::skip_blanks() {
  for (;;) {
    while (!ended() && static_cast<unsigned char>(bytes_[at]) <= ' ') ++at;
    if (!starts_with("/*")) return;
    const std::size_t end = bytes_.find("*/", at + 2);
    if (end == std::string_view::npos) fail_at(at, "found a comment that is never closed, expected '*/'");
    at = end + 2;
  }
}

void Scanner::skip_string() {
  const char quote = peek();
  std::size_t end = bytes_.find(quote, at + 1);
  while (end != std::string_view::npos && quote == '\'' && shifts_code_page(bytes_, at, end)) {
    // Some exporters double this one too; where it closes the string, a delimiter follows.
    const std::size_t next = bytes_.find_first_not_of(" \t\r\n", end + 2);
    const bool doubled = bytes_.substr(end + 1, 1) == "'" && bytes_.find_first_of(",)/", next) != next;
    end = bytes_.find(quote, end + (doubled ? 2 : 1));
  }
  if (end == std::string_view::npos)
    fail_at(at, std::string("found a string that is never closed, expected ") + quote + " before the end of the file");
  at = end + 1;
}

void Scanner::skip_arguments() {
  const std::size_t begin = at;
  for (int depth = 0; !ended(); ++at) {
    if (!kInteresting[static_cast<unsigned char>(bytes_[at])]) continue;
    switch (bytes_[at]) {
      case '(':
        if (++depth > kDeepest) fail_at(at, "found arguments nested deeper than " + std::to_string(kDeepest));
        break;
      case ')':
        if (--depth == 0) {
          ++at;
          return;
        }
        break;
      case '\'':
      case '"':
        skip_string();
        --at;
        break;
      case '/':
        if (starts_with("/*")) {
          skip_blank();
          --at;
        }
        break;
      default:
        fail("')' that closes the arguments opened at " + place(bytes_, name_, begin));
    }
  }
  fail("')' that closes the arguments opened at " + place(bytes_, name_, begin));
}

/// Fast over what is well formed; what is not goes the slow way, which says what is wrong. An '=' outside strings means
/// that the instance was never closed.
void Scanner::skip_instance(std::uint64_t id) {
  const std::size_t begin = at;
  for (;;) {
    const std::size_t found = find_special(bytes_, at);
    const char c = found < bytes_.size() ? bytes_[found] : '=';
    if (c == ';') {
      std::size_t last = found - 1;
      while (last > begin && static_cast<unsigned char>(bytes_[last]) <= ' ') --last;
      if (bytes_[last] != ')' && bytes_[last] != '/') break;
      at = found + 1;
      return;
    }
    if (c == '=') break;
    at = found;
    if (c != '/')
      skip_string();
    else if (starts_with("/*"))
      skip_blank();
    else
      ++at;
  }
  at = begin;
  skip_arguments();
  skip_blank();
  expect(';', ("at the end of #" + std::to_string(id)).c_str());
}

std::string Scanner::read_keyword() {
  if (!is_letter(peek())) fail("a keyword");
  std::string keyword;
  while (is_letter(peek()) || is_digit(peek()) || peek() == '-') keyword += upper(bytes_[at++]);
  return keyword;
}

std::uint64_t Scanner::read_number() {
  std::uint64_t number = 0;
  const char* begin = bytes_.data() + at;
  const auto [end, error] = std::from_chars(begin, bytes_.data() + bytes_.size(), number);
  if (error != std::errc{}) fail("the number of an instance, at most 18446744073709551615");
  at += static_cast<std::size_t>(end - begin);
  return number;
}

}  // namespace plumbline::step
