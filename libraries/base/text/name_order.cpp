#include "base/text/name_order.hpp"

#include <cstddef>

namespace plumbline::text {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

int small(char c) { return static_cast<unsigned char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); }

/// The number that begins at `at`, without leading zeros; goes past it.
std::string number(const std::string& text, std::size_t& at) {
  while (at + 1 < text.size() && text[at] == '0' && is_digit(text[at + 1])) ++at;
  const std::size_t first = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  return text.substr(first, at - first);
}

}  // namespace

bool before_by_name(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string one = number(a, i), two = number(b, j);
      if (one.size() != two.size()) return one.size() < two.size();
      if (one != two) return one < two;
    } else {
      if (small(a[i]) != small(b[j])) return small(a[i]) < small(b[j]);
      ++i, ++j;
    }
  }
  const std::size_t left_of_a = a.size() - i, left_of_b = b.size() - j;
  return left_of_a != left_of_b ? left_of_a < left_of_b : a < b;
}

}  // namespace plumbline::text
