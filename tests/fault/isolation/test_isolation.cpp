// A node in a process of its own can do what it likes: it is an error of that node, told with its cause, and all else
// goes on.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "isolated_run.hpp"

namespace plumbline::test {
namespace test_isolation {

TEST_F(Isolation, AnAccidentIsAnErrorOfItsNodeAndOtherBranchesGoOn) {
  const std::pair<const char*, const char*> accidents[] = {
#if !defined(__SANITIZE_ADDRESS__)  // whose own report it is then
    {"crash", "died of signal 11 (Segmentation fault)"},
#endif
    {"abort", "died of signal 6 (Aborted)"},
    {"exit", "ended by itself with exit code 0"},
    {"kill", "died of signal 9 (Killed)"},
    {"throw", "thrown on purpose"},
  };
  for (const auto& [how, words] : accidents) {
    run("  bad: {use: accident.happens, isolate: process, with: {how: " + std::string(how) + "}}\n" +
        "  after: {use: accident.happens, in: {number: bad.number}}\n" + "  other: {use: accident.happens}\n" +
        "  more: {use: accident.happens, isolate: process, in: {number: other.number}}\n");
    EXPECT_EQ(node("bad").status, NodeStatus::failed) << how;
    EXPECT_TRUE(contains(node("bad").error, words)) << node("bad").error;
    EXPECT_TRUE(contains(node("bad").error, "p.yaml:4:")) << node("bad").error;
    EXPECT_EQ(node("after").status, NodeStatus::skipped) << how;
    EXPECT_TRUE(node("more").error.empty()) << node("more").error;
    EXPECT_TRUE(contains(value("more"), "2")) << value("more");
    EXPECT_EQ(contains(node("bad").error, "about to " + std::string(how)), std::string(how) != "throw");
  }
}

/// A library that was linked anew to the same bytes is the one that was looked at.
TEST_F(Isolation, AFileWithTheSameBytesIsTheSameLibrary) {
  fs::permissions(PLUMBLINE_ACCIDENT_PLUGIN, fs::perms::owner_read, fs::perm_options::add);  // another time of change
  run("  bad: {use: accident.happens, isolate: process}\n");
  EXPECT_EQ(node("bad").status, NodeStatus::executed) << node("bad").error;
}

TEST_F(Isolation, AHangIsKilledAtItsTimeLimit) {
  run("  bad: {use: accident.happens, time_limit: 0.3 s, with: {how: hang}}\n");
  EXPECT_TRUE(contains(node("bad").error, "took longer than its limit of 0.3 s and was killed")) << node("bad").error;
}

TEST_F(Isolation, HungerEndsAtTheLimitOfMemory) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer's allocator ends the process itself when there is no memory";
#endif
  run("  bad: {use: accident.happens, memory_limit: 200MiB, with: {how: eat}}\n"
      "  worse: {use: accident.happens, memory_limit: 200MiB, with: {how: eat_unchecked}}\n");
  EXPECT_TRUE(contains(node("bad").error, "bad_alloc: its limit of memory is 200 MiB")) << node("bad").error;
  EXPECT_TRUE(contains(node("worse").error, "died of signal 11")) << node("worse").error;
  EXPECT_TRUE(contains(node("worse").error, "its limit of memory is 200 MiB")) << node("worse").error;
}

/// Memory that RLIMIT_DATA does not count.
TEST_F(Isolation, SharedMemoryAndMemfdsCountInTheLimit) {
  for (const std::string how : {"share", "memfd"}) {
    run("  bad: {use: accident.happens, memory_limit: 200MiB, with: {how: " + how + "}}\n");
    EXPECT_TRUE(contains(node("bad").error, "more than its limit of 200 MiB, and was killed"))
        << how << node("bad").error;
  }
}

/// Of what it prints only the end is kept: it neither fills the memory nor the error.
TEST_F(Isolation, OneThatPrintsWithoutEndIsKilledAtItsTimeLimit) {
  run("  bad: {use: accident.happens, time_limit: 0.5 s, with: {how: shout}}\n");
  EXPECT_TRUE(contains(node("bad").error, "took longer than its limit of 0.5 s")) << node("bad").error;
  EXPECT_LT(node("bad").error.size(), 1000u);
}

TEST_F(Isolation, TwoRunAtATimeInProcessesOfTheirOwn) {
  const TemporaryFolder place;
  const auto node_that_takes = [&](const std::string& mebibytes) {  // equal ones would be computed once
    return "{use: accident.happens, isolate: process, with: {how: meet, mebibytes: " + mebibytes +
           ", place: " + place.path().string() + "}}\n";
  };
  run("  a: " + node_that_takes("1") + "  b: " + node_that_takes("2"));
  EXPECT_TRUE(result_.ok()) << node("a").error << node("b").error;
  EXPECT_EQ(std::distance(fs::directory_iterator(place.path()), {}), 2);
}

/// a -> b -> c, of which b is isolated and fails or does not; d aside. What was done before is kept.
TEST_F(Isolation, InTheMiddleOfAGraph) {
  const auto graph = [](const std::string& how) {
    return "  a: {use: accident.happens}\n"
           "  b: {use: accident.happens, isolate: process, in: {number: a.number}, with: {how: " +
           how +
           "}}\n"
           "  c: {use: accident.happens, in: {number: b.number}}\n  d: {use: accident.happens}\n";
  };
  run(graph("crash"));
  EXPECT_EQ(to_text(node("a").status) + std::string(to_text(node("b").status)) + to_text(node("c").status) +
                to_text(node("d").status),
            "executedfailedskippedexecuted");
  EXPECT_EQ(node("c").cause, "b");
  EXPECT_FALSE(result_.ok());
  run(graph("not"));
  EXPECT_EQ(node("a").status, NodeStatus::reused);
  EXPECT_TRUE(contains(value("c"), "3")) << value("c");
}

/// A worker that is killed between two nodes is replaced, and no node suffers.
TEST_F(Isolation, AWorkerThatIsKilledWhileItWaitsIsReplaced) {
  run("  who: {use: accident.happens, isolate: process, with: {how: say_pid}}\n"
      "  killer: {use: accident.happens, in: {number: who.number}, with: {how: kill_pid}}\n"
      "  next: {use: accident.happens, isolate: process, in: {number: killer.number}}\n");
  EXPECT_TRUE(result_.ok()) << node("next").error;
}

/// One process serves many nodes, one that failed is not used again.
TEST_F(Isolation, WorkersArePooled) {
  run("  a: {use: accident.happens, isolate: process, with: {how: say_pid}}\n"
      "  b: {use: accident.happens, isolate: process, in: {number: a.number}, with: {how: say_pid}}\n"
      "  c: {use: accident.happens, isolate: process, in: {number: b.number}, with: {how: throw}}\n");
  EXPECT_EQ(value("a"), value("b"));
  EXPECT_EQ(value("a").find(std::to_string(getpid())), std::string::npos);
  EXPECT_TRUE(contains(node("c").error, "thrown on purpose"));
}

/// The result is that of a run without isolation: same key, same bits, metrics, seed.
TEST_F(Isolation, NothingElseChanges) {
  const std::string nodes =
      "  series: {use: story.series}\n  many: {use: accident.count, in: {number: series.numbers}}\n"
      "  draw: {use: accident.happens}\n  folder: {use: story.folder}\n"
      "  length: {use: story.read, in: {folder: folder.folder}}\n";
  run(nodes);
  const RunResult plain = result_;
  std::filesystem::remove_all(folder_.path() / "store");
  run(nodes, true);
  ASSERT_EQ(plain.nodes.size(), result_.nodes.size());
  for (size_t i = 0; i < plain.nodes.size(); ++i) {
    EXPECT_EQ(result_.nodes[i].error, "");
    EXPECT_EQ(result_.nodes[i].status, NodeStatus::executed);
    EXPECT_EQ(plain.nodes[i].outputs, result_.nodes[i].outputs) << graph_.nodes[i].name;
    EXPECT_EQ(plain.nodes[i].keys, result_.nodes[i].keys) << graph_.nodes[i].name;
    ASSERT_EQ(plain.nodes[i].metrics.size(), result_.nodes[i].metrics.size());
  }
  run(nodes);
  EXPECT_EQ(result_.count(NodeStatus::reused), plain.nodes.size());
}

TEST_F(Isolation, OneThatDoesNotStopWhenItIsToldIsKilled) {
  std::atomic<bool> cancel = false;
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    cancel = true;
  });
  run("  bad: {use: accident.happens, isolate: process, with: {how: hang}}\n", false, &cancel);
  later.join();
  EXPECT_NE(node("bad").status, NodeStatus::executed);
  EXPECT_TRUE(result_.cancelled);
}

/// What a node announces in a worker counts in the budget of the run: two times 600 of 1024 MiB cannot be at once.
TEST_F(Isolation, MemoryIsAnnouncedToTheOneBudget) {
  const TemporaryFolder place;
  const auto node_that_takes = [&](const std::string& mebibytes) {
    return "{use: accident.happens, isolate: process, with: {how: alone, mebibytes: " + mebibytes +
           ", place: " + place.path().string() + "}}\n";
  };
  run("  a: " + node_that_takes("600") + "  b: " + node_that_takes("601") + "  c: " + node_that_takes("602"));
  EXPECT_TRUE(result_.ok()) << node("a").error << node("b").error << node("c").error;
  EXPECT_EQ(node("b").memory_announced, uint64_t{601} << 20);
}

/// A child that nobody waited for might write on, and one that returns would be the program twice, with the same record
/// and the same outputs; in a process of its own no less than in the program.
TEST_F(Isolation, WhatANodeStartsEndsWithIt) {
  for (const bool apart : {false, true}) {
    for (const std::string how : {"fork", "spawn", "popen"}) {
      run("  a: {use: accident.happens, with: {how: " + how + "}}\n", apart);
      const std::string& error = node("a").error;
      EXPECT_TRUE(contains(error, "a process that it had started went on (process ")) << how << apart << error;
      const auto at = error.find("(process ");
      if (at == std::string::npos) continue;
      const int left = std::stoi(error.substr(at + std::strlen("(process ")));
      EXPECT_FALSE(std::filesystem::exists("/proc/" + std::to_string(left))) << how << apart;
    }
    run("  a: {use: accident.happens, with: {how: spawn_and_wait, mebibytes: " + std::to_string(3 + apart) + "}}\n",
        apart);
    EXPECT_EQ(node("a").status, NodeStatus::executed) << apart << node("a").error;
    run("  a: {use: accident.happens, with: {how: fork_and_return, mebibytes: " + std::to_string(1 + apart) +
            "}}\n  b: {use: accident.happens, in: {number: a.number}}\n",
        apart);
    EXPECT_TRUE(contains(value("a"), "1")) << apart << value("a");
    EXPECT_TRUE(contains(value("b"), "2")) << apart << value("b");
  }
}

/// How many processes run that have this text among their arguments.
int running_with(const std::string& argument) {
  int count = 0;
  std::error_code ignored;
  for (std::filesystem::directory_iterator entry("/proc", ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    std::ifstream stream(entry->path() / "cmdline", std::ios::binary);
    const std::string words(std::istreambuf_iterator<char>(stream), {});
    count += words.find(argument) != std::string::npos;
  }
  return count;
}

/// What a shell had started went on when the shell had ended or was ended, and nobody saw it: init had it.
TEST_F(Isolation, WhatAShellOfANodeLeavesEndsWithIt) {
  for (const bool apart : {false, true})
    for (const std::string how : {"system", "system_of_two", "popen_of_two"}) {
      run("  a: {use: accident.happens, with: {how: " + how + "}}\n", apart);
      const std::string& error = node("a").error;
      EXPECT_EQ(node("a").status, NodeStatus::failed) << how << apart;
      EXPECT_TRUE(contains(error, "(process ")) << how << apart << error;
      EXPECT_TRUE(contains(error, "went on")) << how << apart << error;
      EXPECT_EQ(running_with("30.125"), 0) << how << apart;
      run("  b: {use: accident.happens}\n", apart);
      EXPECT_EQ(node("b").error, "") << how << apart;
    }
}

/// A shell that somebody waits for is no orphan, whoever ends beside it.
TEST_F(Isolation, ACommandThatIsWaitedForEndsByItself) {
  std::string nodes = "  a: {use: accident.happens, with: {how: system_and_wait}}\n  b0: {use: accident.happens}\n";
  for (int i = 1; i < 40; ++i)
    nodes +=
        "  b" + std::to_string(i) + ": {use: accident.happens, in: {number: b" + std::to_string(i - 1) + ".number}}\n";
  run(nodes);
  EXPECT_TRUE(result_.ok()) << node("a").error;
}

/// In a pooled worker it took the next node down, which was blamed for it.
TEST_F(Isolation, ANodeThatLeavesAThreadRunningIsNamedAndHarmsNoOther) {
  run("  bad: {use: accident.happens, with: {how: leave_thread}}\n"
      "  other: {use: accident.happens, with: {how: leave_grandchild}}\n",
      true);
  for (const char* name : {"bad", "other"})
    EXPECT_TRUE(contains(node(name).error, "it ended while a thread that it had started went on")) << node(name).error;
  // Longer than the thread that was left would have taken to crash.
  run("  after: {use: accident.happens, isolate: process, time_limit: 0.9 s, with: {how: hang}}\n");
  EXPECT_TRUE(contains(node("after").error, "took longer than its limit of 0.9 s")) << node("after").error;
  run("  other: {use: accident.happens, with: {how: leave_grandchild}}\n");
  EXPECT_TRUE(contains(node("other").error, "it ended while a thread that it had started went on"))
      << node("other").error;
}

/// A pool that sleeps until it has work does no harm, and who has told a thread to end need not wait for it.
TEST_F(Isolation, ThreadsThatSleepOrEndAreNoneThatGoOn) {
  for (const bool apart : {false, true})
    for (const std::string how : {"leave_pool", "leave_soon"}) {
      run("  a: {use: accident.happens, with: {how: " + how + ", mebibytes: " + std::to_string(1 + apart) + "}}\n",
          apart);
      EXPECT_EQ(node("a").status, NodeStatus::executed) << how << apart << node("a").error;
    }
}

TEST_F(Isolation, ConditionsAreChecked) {
  try {
    run("  a: {use: accident.happens, isolate: thread}\n  b: {use: accident.happens, time_limit: soon}\n"
        "  c: {use: accident.happens, memory_limit: much}\n  d: {use: accident.happens, isolate: no, time_limit: 5}\n");
    FAIL();
  } catch (const InvalidPipeline& error) {
    const std::string text = error.what();
    EXPECT_TRUE(contains(text, "'isolate' of node 'a' is process or no, found 'thread'")) << text;
    EXPECT_TRUE(contains(text, "'time_limit' of node 'b' is a time, such as 90 s or 5 min, found 'soon'")) << text;
    EXPECT_TRUE(contains(text, "'memory_limit' of node 'c' is a size of memory")) << text;
    EXPECT_TRUE(contains(text, "node 'd' has a limit, which is kept only in a process of its own")) << text;
  }
}

}  // namespace test_isolation
}  // namespace plumbline::test
