#include <thread>

#include "runtime/base/memory_budget.hpp"
#include "story.hpp"

namespace plumbline::test {
namespace test_cancel {

namespace fs = std::filesystem;

const std::string waiting = small_chain + "\nw: {use: story.waits}\nr: {use: story.read, in: {folder: w.folder}}";

void wait_for(const fs::path& file) {
  while (!fs::exists(file)) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

TEST(Cancel, EndsTheRunAndLeavesNothingHalfWritten) {
  Story story(waiting);
  const fs::path started = story.folder.path() / "started";
  std::atomic<bool> cancel = false;
  std::thread person([&] {
    wait_for(started);
    cancel = true;
  });
  story.run({"w.with.started=" + started.string()}, 2, 0, &cancel);
  person.join();
  EXPECT_TRUE(story.result.cancelled);
  EXPECT_EQ(story.status("w"), "cancelled");
  EXPECT_EQ(story.status("r"), "cancelled");
  EXPECT_TRUE(fs::is_empty(story.folder.path() / "store" / "folders"));
  EXPECT_TRUE(fs::is_empty(story.folder.path() / "store" / "tmp"));
}

TEST(Cancel, WhatANodeGaveAfterItWasToldToStopIsNotStored) {
  // story.logs ends without an error when it is told to stop.
  Story story("");
  const std::string log = (story.folder.path() / "log").string();
  story.tell("l: {use: story.logs, with: {log: " + log + ", milliseconds: 60000}}");
  std::atomic<bool> cancel = false;
  std::thread person([&] {
    wait_for(log);
    cancel = true;
  });
  story.run({}, 2, 0, &cancel);
  person.join();
  EXPECT_EQ(story.status("l"), "cancelled");
  story.run({"l.with.milliseconds=60000"}, 2, 0, &cancel);
  EXPECT_EQ(story.status("l"), "cancelled") << "half a result was taken from the store";
}

/// Who stopped the run wants nothing of it any more, whether the node asked or not.
TEST(Cancel, WhatANodeGaveThatDidNotAskIsNotStored) {
  Story story("");
  const fs::path started = story.folder.path() / "started";
  story.tell("d: {use: story.deaf, with: {started: " + started.string() +
             ", milliseconds: 300}}\nn: {use: story.add, in: {a: d.number}}");
  std::atomic<bool> cancel = false;
  std::thread person([&] {
    wait_for(started);
    cancel = true;
  });
  story.run({}, 2, 0, &cancel);
  person.join();
  EXPECT_EQ(story.status("d"), "cancelled");
  EXPECT_EQ(story.status("n"), "cancelled");
  EXPECT_TRUE(story.result.cancelled);
  story.run();
  EXPECT_EQ(story.executed(), "d n");
}

TEST(Cancel, WakesThoseWhoWaitForMemory) {
  runtime::MemoryBudget budget(1000);
  std::atomic<bool> cancel = false;
  ASSERT_TRUE(budget.acquire(1000, 0, cancel));
  std::thread person([&] { cancel = true; });
  EXPECT_FALSE(budget.acquire(1, 0, cancel));
  person.join();
}

}  // namespace test_cancel
}  // namespace plumbline::test
