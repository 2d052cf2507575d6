// Numbers and words beside those that were found right when they were looked at, in a file under tests/. For code that
// only decides which of several good ways is taken: no single property would notice a line of it that is wrong. A
// change that is meant is taken over with PLUMBLINE_UPDATE_GOLDEN=1, after reading the difference.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "test_support.hpp"

namespace plumbline::test {

/// Five digits; what is zero but for rounding is zero.
inline std::string digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.5g", std::abs(value) < 1e-8 ? 0.0 : value);
  return text;
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
