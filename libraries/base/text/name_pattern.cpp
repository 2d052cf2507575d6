#include "base/text/name_pattern.hpp"

#include <algorithm>

#include "base/text/composed.hpp"

namespace plumbline::text {
namespace {

bool matches(const char* pattern, const char* text) {
  if (!*pattern) return !*text;
  if (*pattern == '*' && pattern[1] == '*') {
    const char* after = pattern + 2;
    if (*after == '/' && matches(after + 1, text)) return true;  // no folder at all
    for (const char* rest = text;; ++rest) {
      if (matches(after, rest)) return true;
      if (!*rest) return false;
    }
  }
  if (*pattern == '*') {
    for (const char* rest = text;; ++rest) {
      if (matches(pattern + 1, rest)) return true;
      if (!*rest || *rest == '/') return false;
    }
  }
  if (!*text) return false;
  if (*pattern == '?') {
    if (*text == '/') return false;
    for (++text; (static_cast<unsigned char>(*text) & 0xC0) == 0x80;) ++text;  // the rest of one character
    return matches(pattern + 1, text);
  }
  return *pattern == *text && matches(pattern + 1, text + 1);
}

std::string in_small(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

}  // namespace

bool matches_pattern(const std::string& pattern, const std::string& name) {
  return matches(composed(pattern).c_str(), composed(name).c_str());
}

bool is_named_by(const std::vector<std::string>& patterns, const std::string& path) {
  const std::string last = path.substr(path.rfind('/') + 1);
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    return matches_pattern(in_small(pattern), in_small(pattern.find('/') == std::string::npos ? last : path));
  });
}

}  // namespace plumbline::text
