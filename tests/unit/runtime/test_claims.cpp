// Nothing is computed twice at the same time. Between processes: tests/integration/cli/test_once.cpp.
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "runtime/run/key.hpp"
#include "runtime/store/claims.hpp"
#include "story.hpp"

namespace plumbline::test {
namespace test_claims {

namespace fs = std::filesystem;

const std::string key_a(64, 'a'), key_b(64, 'b'), key_c(64, 'c');

TEST(Claims, ExcludeEachOtherAndGoWithTheirOwner) {
  const TemporaryFolder folder;
  runtime::Claims mine(folder.path() / "claims"), others(folder.path() / "claims");
  ASSERT_TRUE(mine.take(key_a));
  EXPECT_FALSE(mine.take(key_a)) << "another thread";
  EXPECT_FALSE(others.take(key_a)) << "another process";
  EXPECT_TRUE(others.take(key_b));
  mine.begin(key_a);
  EXPECT_FALSE(others.is_done(key_a));
  EXPECT_NE(others.holder(key_a).find("process " + std::to_string(getpid())), std::string::npos);
  mine.give_back(key_a, true);
  EXPECT_TRUE(others.is_done(key_a));
  EXPECT_TRUE(others.take(key_a));

  const pid_t child = fork();
  if (child == 0) {
    runtime::Claims own(folder.path() / "claims");
    own.take(key_c);
    _exit(0);  // without giving it back
  }
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(mine.take(key_c)) << "the claim outlived its owner";
}

TEST(Claims, AHolderThatIsStoppedIsSeen) {
  const TemporaryFolder folder;
  runtime::Claims mine(folder.path() / "claims");
  const pid_t child = fork();
  if (child == 0) {
    runtime::Claims own(folder.path() / "claims");
    own.take(key_a);
    own.begin(key_a);
    raise(SIGSTOP);
    _exit(0);
  }
  waitpid(child, nullptr, WUNTRACED);
  EXPECT_FALSE(mine.take(key_a));
  EXPECT_TRUE(mine.holder_is_stopped(key_a));
  kill(child, SIGCONT);
  waitpid(child, nullptr, 0);
  EXPECT_FALSE(mine.holder_is_stopped(key_a));
}

TEST(Claims, OnceTheSeedIsDrawnOtherSeedsNeedNotWait) {
  const TemporaryFolder folder;
  runtime::Claims claims(folder.path() / "claims");
  runtime::Turn one(claims, key_a, key_b), other_seed(claims, key_a, key_c), same_seed(claims, key_a, key_b);
  ASSERT_TRUE(one.take());
  EXPECT_FALSE(other_seed.take());
  one.seed_was_drawn();
  EXPECT_FALSE(same_seed.take());
  EXPECT_TRUE(other_seed.take());
}

TEST(Claims, WhereTheFileCannotBeWrittenAllAreGranted) {
  runtime::Claims claims("/nowhere/claims");
  EXPECT_TRUE(claims.take(key_a));
  claims.begin(key_a);
  claims.give_back(key_a, true);
  EXPECT_FALSE(claims.is_done(key_a));
}

TEST(Claims, EqualNodesOfOneGraphRunOnce) {
  Story story("");
  const std::string log = (story.folder.path() / "log").string();
  std::string nodes;
  for (const char* name : {"a", "b", "c", "d"})
    nodes += std::string(name) + ": {use: story.logs, with: {log: " + log + "}}\n";
  story.tell(nodes);
  story.run({}, 4);
  EXPECT_TRUE(story.result.ok());
  EXPECT_EQ(read_file(log), "started\n");
  EXPECT_EQ(story.result.count(runtime::NodeStatus::reused), 3u);
}

TEST(Claims, AResultThatASharedFolderShowsLateIsTakenOver) {
  Story story("a: {use: story.constant}");
  story.run();
  const std::string key = story.node("a").keys.at(0);
  const fs::path record = story.folder.path() / "store/runs" / key.substr(0, 2) / (key + ".json");
  const fs::path hidden = story.folder.path() / "hidden";
  fs::rename(record, hidden);
  // Another machine has the claim, writes the result and gives the claim back; its file shows half a second later.
  runtime::Claims other(story.folder.path() / "store/claims");
  ASSERT_TRUE(other.take(key));
  other.begin(key);
  std::thread machine([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    other.give_back(key, true);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    fs::rename(hidden, record);
  });
  story.run();
  machine.join();
  EXPECT_EQ(story.status("a"), "reused");
}

}  // namespace test_claims
}  // namespace plumbline::test
