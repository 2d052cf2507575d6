// Texts that are kept beside the tests: what a part of the program says of a small input, line by line. They hold what
// other tests do not look at: every number, word and order. With PLUMBLINE_WRITE_GOLDEN=1 in the environment the texts
// are written anew; read the difference before it is committed, it is what users will see.
#pragma once

#include <cstdio>
#include <regex>
#include <string>
#include <vector>

#include "test_support.hpp"

namespace plumbline::test {

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Numbers with a decimal point to `digits` significant ones: what another compiler may round otherwise is not held.
inline std::string with_digits(const std::string& text, int digits) {
  static const std::regex number("-?\\d+\\.\\d+(?:e[-+]?\\d+)?");
  std::string result;
  std::sregex_iterator at(text.begin(), text.end(), number);
  size_t done = 0;
  for (; at != std::sregex_iterator(); ++at) {
    char shown[40];
    const double value = std::stod(at->str());
    std::snprintf(shown, sizeof shown, "%.*g", digits, std::abs(value) < 1e-12 ? 0.0 : value);
    const auto begin = static_cast<size_t>(at->position());
    result += text.substr(done, begin - done) + shown;
    done = begin + static_cast<size_t>(at->length());
  }
  return result + text.substr(done);
}

/// Whether `text` is what `file`, relative to the source tree, has. The first lines that differ are said.
inline void expect_golden(const std::string& file, const std::string& text) {
  const std::filesystem::path path = std::filesystem::path(source_dir()) / file;
  if (std::getenv("PLUMBLINE_WRITE_GOLDEN")) std::ofstream(path, std::ios::binary) << text;
  ASSERT_TRUE(std::filesystem::exists(path)) << path << ": PLUMBLINE_WRITE_GOLDEN=1 writes it";
  const std::vector<std::string> expected = lines_of(read_file(path)), found = lines_of(text);
  size_t told = 0;
  for (size_t i = 0; i < std::max(expected.size(), found.size()) && told < 6; ++i) {
    const std::string is = i < found.size() ? found[i] : "(no line)",
                      was = i < expected.size() ? expected[i] : "(no line)";
    if (is != was) ++told, ADD_FAILURE() << file << ":" << i + 1 << "\n  has  " << was << "\n  now  " << is;
  }
}

}  // namespace plumbline::test
