#include <gtest/gtest.h>

#include "loop/state/journal.hpp"

namespace plumbline::loop {
namespace test_journal {

JournalEntry entry(const std::string& item) {
  return {1, item, "panel", "PLANNED", "RELEASED", "robot-1", "", "GO", {"ab"}};
}

std::vector<std::string> journal_of(const std::vector<std::string>& items) {
  std::vector<std::string> lines;
  for (const std::string& item : items) lines.push_back(journal_line(entry(item), journal_head(lines)));
  return lines;
}

TEST(Journal, ChainsEachLineToTheOneBefore) {
  const auto lines = journal_of({"a", "b", "c"});
  EXPECT_EQ(check_journal(lines).words, "");
  EXPECT_NE(lines[0].find("\"previous\":\"" + journal_start()), std::string::npos);
}

TEST(Journal, AChangedInsertedOrMissingLineBreaksIt) {
  const auto good = journal_of({"a", "b", "c", "d"});
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

}  // namespace test_journal
}  // namespace plumbline::loop
