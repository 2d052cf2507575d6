// The fuzzers' corpora without libFuzzer, in every run of the tests: all fixtures through all targets, whole, cut, and
// with bytes changed; and what fuzzing has found before (tests/fuzz/findings).
#include <gtest/gtest.h>

#include <algorithm>

#include "survey_readers.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_replay {

namespace fs = std::filesystem;

std::vector<std::string> files_in(const char* folder) {
  std::vector<fs::path> paths;
  const fs::path root = fs::path(plumbline::test::source_dir()) / folder;
  if (fs::exists(root))
    for (const auto& entry : fs::directory_iterator(root))
      if (entry.is_regular_file()) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> contents;
  for (const fs::path& path : paths) contents.push_back(test::read_file(path));
  return contents;
}

TEST(FuzzReplay, FixturesAndFindingsThroughAllTargets) {
  for (const char* folder : {"tests/unit/survey_files/fixtures", "tests/fuzz/findings"})
    for (const std::string& bytes : files_in(folder))
      for (const fuzz::Target& target : fuzz::kTargets) target.run(bytes);
}

TEST(FuzzReplay, DamagedFixturesThroughAllTargets) {
  unsigned long long state = 1;
  const auto random = [&state](std::size_t below) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::size_t>((state >> 33) % below);
  };
  for (const std::string& bytes : files_in("tests/unit/survey_files/fixtures")) {
    for (int round = 0; round < 20 && !bytes.empty(); ++round) {
      std::string damaged = bytes.substr(0, random(bytes.size()) + 1);
      for (int k = 0; k < 3; ++k) damaged[random(damaged.size())] = static_cast<char>(random(256));
      for (const fuzz::Target& target : fuzz::kTargets) target.run(damaged);
    }
  }
}

}  // namespace test_replay
}  // namespace plumbline
