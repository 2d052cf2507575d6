// Where tests find their files. Public data is not part of the project: it is looked for in $PLUMBLINE_TEST_DATA, else
// in
// ../shared/data beside the checkout; a test that lacks it skips and says so with PLUMBLINE_REQUIRE_DATA.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "test_paths.hpp"

namespace plumbline::test {

inline std::filesystem::path data_folder() {
  if (const char* set = std::getenv("PLUMBLINE_TEST_DATA")) return set;
  return std::filesystem::path(plumbline::test::source_dir()) / ".." / "shared" / "data";
}

inline std::filesystem::path data_file(const std::string& relative) { return data_folder() / relative; }

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + path.string());
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// A folder that is empty at the start of the test and removed at its end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "plumbline-test-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("cannot make " + name);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace plumbline::test

#define PLUMBLINE_REQUIRE_DATA(relative)                                                 \
  do {                                                                                   \
    if (!std::filesystem::exists(plumbline::test::data_file(relative)))                  \
      GTEST_SKIP() << "test data not found: " << plumbline::test::data_file(relative)    \
                   << "; set PLUMBLINE_TEST_DATA to the folder that holds " << relative; \
  } while (false)
