#include "loop/state/journal.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>

namespace plumbline::loop {
namespace journal_test {

namespace fs = std::filesystem;

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

struct Journal : testing::Test {
  fs::path folder = fs::temp_directory_path() / ("journal_test_" + std::to_string(getpid()));
  fs::path path = folder / "journal.jsonl";
  Journal() { fs::create_directories(folder); }
  ~Journal() override { fs::remove_all(folder); }
};

JournalEntry entry(const std::string& item) {
  return {1, item, "panel", "PLANNED", "RELEASED", "robot-1", "", "GO", {"ab"}};
}

TEST_F(Journal, ChainsEachLineToTheOneBefore) {
  append_to_journal(path, {entry("a"), entry("b")});
  append_to_journal(path, {entry("c")});
  const auto lines = lines_of(path);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(check_journal(lines).words, "");
  EXPECT_NE(lines[0].find("\"previous\":\"" + journal_start()), std::string::npos);
}

TEST_F(Journal, AChangedInsertedOrMissingLineBreaksIt) {
  append_to_journal(path, {entry("a"), entry("b"), entry("c"), entry("d")});
  const auto good = lines_of(path);
  auto changed = good;
  changed[1].replace(changed[1].find("robot-1"), 7, "robot-2");
  EXPECT_EQ(check_journal(changed).line, 3u);
  auto missing = good;
  missing.erase(missing.begin() + 2);
  EXPECT_EQ(check_journal(missing).line, 3u);
  auto headless = good;
  headless.erase(headless.begin());
  EXPECT_EQ(check_journal(headless).line, 1u);
  auto inserted = good;
  inserted.insert(inserted.begin() + 1, journal_line(entry("x"), journal_head({good[0]})));
  EXPECT_EQ(check_journal(inserted).line, 3u);
}

TEST_F(Journal, TwoWritersAtOnceLoseNothing) {
  constexpr int kWriters = 4, kEach = 100;
  std::vector<pid_t> children;
  for (int w = 0; w < kWriters; ++w) {
    const pid_t child = fork();
    if (child == 0) {
      for (int i = 0; i < kEach; ++i)
        append_to_journal(path, {entry(std::to_string(w) + "-" + std::to_string(i)), entry("second")});
      _exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  const auto lines = lines_of(path);
  EXPECT_EQ(lines.size(), 2u * kWriters * kEach);
  EXPECT_EQ(check_journal(lines).words, "");
  EXPECT_EQ(std::set<std::string>(lines.begin(), lines.end()).size(), lines.size());
}

TEST_F(Journal, HalfALineOfAKilledWriterIsSetAside) {
  append_to_journal(path, {entry("a")});
  std::ofstream(path, std::ios::app) << "{\"previous\":\"123";
  append_to_journal(path, {entry("b")});
  EXPECT_EQ(lines_of(path).size(), 2u);
  EXPECT_EQ(check_journal(lines_of(path)).words, "");
  EXPECT_EQ(lines_of(path.string() + ".torn"), std::vector<std::string>{"{\"previous\":\"123"});
}

TEST_F(Journal, AFolderThatIsNotThereIsNamed) {
  try {
    append_to_journal(folder / "no" / "journal.jsonl", {entry("a")});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("no/journal.jsonl cannot be opened: No such file"), std::string::npos);
  }
}

}  // namespace journal_test
}  // namespace plumbline::loop
