// Numbers and words beside those that were found right when they were looked at, in a file under tests/. For code that
// only decides which of several good ways is taken: no single property would notice a line of it that is wrong. A
// change that is meant is taken over with PLUMBLINE_UPDATE_GOLDEN=1, after reading the difference.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "test_support.hpp"

namespace plumbline::test {

/// Five digits; what is zero but for rounding is zero.
inline std::string digits(double value, int kept = 5) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", kept, std::abs(value) < 1e-8 ? 0.0 : value);
  return text;
}

/// Numbers with a decimal point to `kept` significant digits: what another compiler may round otherwise is not held.
inline std::string with_few_digits(const std::string& text, int kept = 5) {
  static const std::regex number("-?\\d+\\.\\d+(?:e[-+]?\\d+)?");
  std::string result;
  std::size_t done = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), number); at != std::sregex_iterator(); ++at) {
    const auto begin = static_cast<std::size_t>(at->position());
    result += text.substr(done, begin - done) + digits(std::stod(at->str()), kept);
    done = begin + static_cast<std::size_t>(at->length());
  }
  return result + text.substr(done);
}

/// A line an element, without scripts and styles.
inline std::string elements_of(std::string html) {
  for (const std::string tag : {"script", "style"})
    for (std::size_t at = 0; (at = html.find("<" + tag, at)) != std::string::npos;)
      html.erase(at, html.find("</" + tag + ">", at) + tag.size() + 3 - at);
  html = std::regex_replace(html, std::regex("</[a-z0-9]+>"), "");
  html = std::regex_replace(html, std::regex("<"), "\n<");
  return with_few_digits(html) + "\n";
}

/// `file` in the folder tests/.
inline void expect_recorded(const std::string& file, const std::string& found) {
  const std::string path = source_dir() + ("/tests/" + file);
  if (std::getenv("PLUMBLINE_UPDATE_GOLDEN")) std::ofstream(path) << found;
  std::istringstream now(found), then(read_file(path));
  std::string is, was;
  for (int line = 1; std::getline(now, is); ++line) {
    std::getline(then, was);
    ASSERT_EQ(is, was) << file << ":" << line;
  }
  EXPECT_FALSE(std::getline(then, was)) << file << " goes on: " << was;
}

}  // namespace plumbline::test
