// plumbline run with nodes in processes of their own.
#include <signal.h>

#include <chrono>
#include <thread>

#include "program.hpp"

namespace plumbline::test {
namespace test_isolate {

namespace fs = std::filesystem;

class Isolated : public testing::Test {
 protected:
  Isolated() {
    fs::create_directories(worker().parent_path());
    fs::copy_file(PLUMBLINE_WORKER, worker());
  }
  fs::path worker() const { return program_.folder.path() / "lib/plumbline/plumbline-worker"; }

  /// True as soon as it is; false if it is not within half a minute.
  template <typename Condition>
  static bool comes_true(const Condition& condition) {
    for (int i = 0; i < 3000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  Program program_;
};

TEST_F(Isolated, ACrashIsAnErrorOfItsNode) {
  for (const std::string how : {"exit", "abort", "crash", "overflow", "throw_in_thread"}) {
    program_.write("p.yaml", "plumbline: 1\nnodes:\n  bad: {use: story.ends, with: {how: " + how +
                                 "}}\n  good: {use: story.constant, with: {value: 5}}\n"
                                 "outputs: {good.json: good.number}\n");
    const Answer answer = program_({"run", "p.yaml", "--isolate", "--threads", "1"});
    EXPECT_EQ(answer.code, 1) << how << answer.err;
    EXPECT_TRUE(contains(answer.err, "p.yaml:3:3: node 'bad' (story.ends) failed: its process ")) << answer.err;
    EXPECT_TRUE(contains(answer.out, "1 executed, 0 reused, 1 failed") || how != "exit") << answer.out;
    EXPECT_TRUE(fs::exists(program_.work() / "out/p/good.json")) << how;
  }
}

/// Same results, same keys: a run without isolation takes over what one with it did.
TEST_F(Isolated, ResultsAreTheSame) {
  program_.write("p.yaml", chain);
  EXPECT_EQ(program_({"run", "p.yaml", "--isolate", "--out", "isolated"}).code, 0);
  const Answer again = program_({"run", "p.yaml", "--out", "plain"});
  EXPECT_TRUE(contains(again.out, "0 executed, 2 reused")) << again.out;
  EXPECT_EQ(program_({"run", "p.yaml", "--out", "fresh", "--store", (program_.folder.path() / "fresh").string()}).code,
            0);
  EXPECT_EQ(read_file(program_.work() / "isolated/b.json"), read_file(program_.work() / "fresh/b.json"));
}

TEST_F(Isolated, AnOverrideIsolatesOneNode) {
  program_.write("p.yaml", chain);
  fs::remove(worker());
  const Answer answer = program_({"run", "p.yaml", "b.isolate=process"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "node 'b' (story.add) failed: a process of its own needs the program"))
      << answer.err;
  EXPECT_FALSE(contains(answer.err, "node 'a'")) << answer.err;
}

/// A node in any language, here in that of the shell, which says who it is and then takes for ever.
class Sleeper : public Isolated {
 protected:
  Sleeper() {
    const fs::path plugins = program_.folder.path() / "plugins";
    fs::create_directory(plugins);
    fs::copy_file(PLUMBLINE_STORY_PLUGIN, plugins / "story.so");
    fs::copy(fs::path(PLUMBLINE_STORY_PLUGIN).parent_path() / "roles", plugins / "roles");
    std::ofstream(plugins / "sleep.node.yaml") << "plumbline_node: 1\nkind: shell.sleep\nversion: 1\nsummary: Sleeps\n"
                                                  "run: [/bin/sh, -c, 'echo $$ > "
                                               << said().string()
                                               << "; exec sleep 1000']\n"
                                                  "outputs: {number: {type: plumbline.Number/1, doc: never}}\n";
    program_.use_plugins(plugins);
    program_.write("p.yaml", "plumbline: 1\nnodes:\n  s: {use: shell.sleep}\n");
  }
  fs::path said() const { return program_.folder.path() / "said"; }
  pid_t sleeper() const {
    pid_t process = 0;
    std::ifstream(said()) >> process;
    return process;
  }
};

TEST_F(Sleeper, IsToldByCtrlC) {
  const pid_t host = program_.start({"run", "p.yaml"});
  ASSERT_TRUE(comes_true([&] { return sleeper() > 0; }));
  const pid_t process = sleeper();
  kill(host, SIGINT);
  EXPECT_EQ(program_.finish(host).code, 130);
  EXPECT_NE(kill(process, 0), 0);
}

TEST_F(Sleeper, DoesNotOutliveItsHost) {
  const pid_t host = program_.start({"run", "p.yaml"});
  ASSERT_TRUE(comes_true([&] { return sleeper() > 0; }));
  const pid_t process = sleeper();
  kill(host, SIGKILL);
  EXPECT_EQ(program_.finish(host).code, 128 + SIGKILL);
  EXPECT_TRUE(comes_true([&] { return kill(process, 0) != 0; }));
}

TEST_F(Isolated, AWorkerDoesNotOutliveItsHost) {
  program_.write("p.yaml", "plumbline: 1\nnodes:\n  w: {use: story.waits, isolate: process}\n");
  const pid_t host = program_.start({"run", "p.yaml", "--quiet"});
  const auto process_of_worker = [&] {
    std::error_code ignored;
    for (const auto& process : fs::directory_iterator("/proc", ignored))
      if (fs::read_symlink(process.path() / "exe", ignored) == worker())
        return static_cast<pid_t>(std::atoi(process.path().filename().c_str()));
    return pid_t{0};
  };
  ASSERT_TRUE(comes_true([&] { return process_of_worker() > 0; }));
  const pid_t process = process_of_worker();
  kill(host, SIGKILL);
  EXPECT_EQ(program_.finish(host).code, 128 + SIGKILL);
  EXPECT_TRUE(comes_true([&] { return kill(process, 0) != 0; }));
}

/// What a script had started before it became the program is the script's, and goes on.
TEST(BackgroundJobs, OfTheShellThatBecameTheProgramGoOn) {
  const Program program;
  program.write("p.yaml", chain);
  const fs::path job = program.work() / "job";
  const std::string said = " > '" + (program.folder.path() / "said").string() + "' 2>&1";
  setenv("PLUMBLINE_PLUGIN_PATH", program.plugins().c_str(), 1);
  EXPECT_EQ(std::system(("cd '" + program.work().string() + "'; sleep 30" + said + " & echo $! > job; exec '" +
                         (program.folder.path() / "bin/plumbline").string() + "' run p.yaml --store store" + said)
                            .c_str()),
            0)
      << read_file(program.folder.path() / "said");
  unsetenv("PLUMBLINE_PLUGIN_PATH");
  pid_t process = 0;
  std::ifstream(job) >> process;
  ASSERT_GT(process, 0);
  EXPECT_EQ(kill(process, SIGKILL), 0) << "it was ended";
}

}  // namespace test_isolate
}  // namespace plumbline::test
