#include "base/text/composed.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

#include "base/text/compositions.hpp"

namespace plumbline::text {
namespace {

/// The character at `at`, which moves behind it; -1 if there is no UTF-8.
std::int32_t next_character(std::string_view text, std::size_t& at) {
  const auto first = static_cast<unsigned char>(text[at]);
  const int more = first < 0x80 ? 0 : first >> 5 == 6 ? 1 : first >> 4 == 14 ? 2 : first >> 3 == 30 ? 3 : -1;
  if (more < 0 || at + static_cast<std::size_t>(more) >= text.size()) return -1;
  std::int32_t value = more == 0 ? first : first & (0x3F >> more);
  for (int k = 1; k <= more; ++k) {
    const auto byte = static_cast<unsigned char>(text[at + static_cast<std::size_t>(k)]);
    if (byte >> 6 != 2) return -1;
    value = value << 6 | (byte & 0x3F);
  }
  at += static_cast<std::size_t>(more) + 1;
  return value;
}

void append(std::int32_t c, std::string& out) {
  const auto byte = [&](std::int32_t value) { out.push_back(static_cast<char>(value)); };
  if (c < 0x80) {
    byte(c);
  } else if (c < 0x800) {
    byte(0xC0 | c >> 6), byte(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    byte(0xE0 | c >> 12), byte(0x80 | (c >> 6 & 0x3F)), byte(0x80 | (c & 0x3F));
  } else {
    byte(0xF0 | c >> 18), byte(0x80 | (c >> 12 & 0x3F)), byte(0x80 | (c >> 6 & 0x3F)), byte(0x80 | (c & 0x3F));
  }
}

/// Korean syllables are computed (The Unicode Standard, 3.12); 0 if the two are not joined.
std::int32_t joined_hangul(std::int32_t a, std::int32_t b) {
  constexpr std::int32_t syllables = 0xAC00, leads = 0x1100, vowels = 0x1161, tails = 0x11A7;
  if (a >= leads && a < leads + 19 && b >= vowels && b < vowels + 21)
    return syllables + ((a - leads) * 21 + (b - vowels)) * 28;
  if (a >= syllables && a < syllables + 11172 && (a - syllables) % 28 == 0 && b > tails && b < tails + 28)
    return a + (b - tails);
  return 0;
}

std::int32_t joined(std::int32_t letter, std::int32_t mark) {
  if (const std::int32_t hangul = joined_hangul(letter, mark)) return hangul;
  const auto found = std::lower_bound(std::begin(kCompositions), std::end(kCompositions), std::pair(letter, mark),
                                      [](const Composition& c, const std::pair<std::int32_t, std::int32_t>& wanted) {
                                        return std::pair<std::int32_t, std::int32_t>(c.letter, c.mark) < wanted;
                                      });
  return found != std::end(kCompositions) && found->letter == letter && found->mark == mark ? found->joined : 0;
}

}  // namespace

std::string composed(std::string_view utf8) {
  std::string out;
  std::int32_t last = -1;  // not written yet
  for (std::size_t at = 0; at < utf8.size();) {
    const std::int32_t c = next_character(utf8, at);
    if (c < 0) return std::string(utf8);
    const std::int32_t one = last < 0 ? 0 : joined(last, c);
    if (one == 0 && last >= 0) append(last, out);
    last = one == 0 ? c : one;
  }
  if (last >= 0) append(last, out);
  return out;
}

}  // namespace plumbline::text
