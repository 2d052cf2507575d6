// Several programs on one store: what they share is computed once, whatever happens to one of them. A node that ends
// the process is named.
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "program.hpp"

namespace plumbline::test {
namespace test_once {

namespace fs = std::filesystem;

/// Programs that share the store of the first.
class Together {
 public:
  explicit Together(size_t count, const std::string& nodes) {
    for (size_t i = 0; i < count; ++i) {
      programs.push_back(std::make_unique<Program>());
      programs[i]->write("p.yaml", "plumbline: 1\nvars: {seed: 1}\nnodes:\n" + nodes);
    }
  }
  pid_t start(size_t i, std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"run", "p.yaml", "--threads", "3", "--store", store().string()};
    words.insert(words.end(), more.begin(), more.end());
    return programs[i]->start(words);
  }
  fs::path store() const { return programs[0]->folder.path() / "store"; }
  std::vector<std::unique_ptr<Program>> programs;
};

size_t lines_of(const fs::path& file) {
  std::ifstream stream(file);
  size_t count = 0;
  for (std::string line; std::getline(stream, line);) ++count;
  return count;
}

bool wait_for_lines(const fs::path& file, size_t count) {
  for (int i = 0; i < 6000 && lines_of(file) < count; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return lines_of(file) >= count;
}

std::string three(const fs::path& log, int milliseconds) {
  std::string text;
  for (int i = 0; i < 3; ++i)
    text += "  n" + std::to_string(i) + ": {use: story.logs, with: {log: " + log.string() +
            ", value: " + std::to_string(i) + ", milliseconds: " + std::to_string(milliseconds) + "}}\n";
  return text;
}

TEST(Once, FourRunsThatShareThreeNodesExecuteThree) {
  const TemporaryFolder folder;
  const fs::path log = folder.path() / "log";
  const Together together(4, three(log, 300));
  std::vector<pid_t> processes;
  for (size_t i = 0; i < 4; ++i) processes.push_back(together.start(i));
  for (size_t i = 0; i < 4; ++i) {
    const Answer answer = together.programs[i]->finish(processes[i]);
    EXPECT_EQ(answer.code, 0) << answer.err;
  }
  EXPECT_EQ(lines_of(log), 3u);
}

TEST(Once, AClaimGoesWithAKilledOwner) {
  const TemporaryFolder folder;
  const fs::path log = folder.path() / "log";
  const Together together(3, three(log, 1500));
  const pid_t first = together.start(0);
  ASSERT_TRUE(wait_for_lines(log, 3));
  const pid_t second = together.start(1), third = together.start(2);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(lines_of(log), 3u) << "they do not wait for the first";
  kill(first, SIGKILL);
  EXPECT_EQ(together.programs[0]->finish(first).code, 128 + SIGKILL);
  EXPECT_EQ(together.programs[1]->finish(second).code, 0);
  EXPECT_EQ(together.programs[2]->finish(third).code, 0);
  EXPECT_EQ(lines_of(log), 6u) << "three that were killed, and each of them once more";
}

TEST(Once, AStoppedOwnerKeepsNobodyWaiting) {
  const TemporaryFolder folder;
  const fs::path log = folder.path() / "log";
  const Together together(2, three(log, 200));
  const pid_t first = together.start(0);
  ASSERT_TRUE(wait_for_lines(log, 3));
  kill(first, SIGSTOP);
  const Answer answer = together.programs[1]->finish(together.start(1));
  EXPECT_EQ(answer.code, 0) << answer.err;
  kill(first, SIGCONT);
  EXPECT_EQ(together.programs[0]->finish(first).code, 0);
}

TEST(Ends, ANodeThatEndsTheProcessIsNamedAndTheExitCodeIsNotZero) {
  const Program plumbline;
  plumbline.write(
      "p.yaml", "plumbline: 1\nnodes:\n  a: {use: story.constant}\n  bad: {use: story.ends, in: {after: a.number}}\n");
  for (const std::string how : {"exit", "abort", "crash", "overflow", "throw_in_thread"}) {
    const Answer answer = plumbline({"run", "p.yaml", "bad.with.how=" + how});
    EXPECT_NE(answer.code, 0) << how;
    EXPECT_TRUE(contains(answer.err, "p.yaml:4:3: node 'bad' (story.ends) " +
                                         std::string(how == "exit" ? "called exit()" : "crashed: SIG")))
        << how << ": " << answer.err;
    EXPECT_EQ(answer.code, how == "exit" ? 1 : 128 + (how == "crash" || how == "overflow" ? SIGSEGV : SIGABRT)) << how;
  }
  // What leaves the process without any handler of exit(), and with exit code 0.
  for (const auto& [how, call] : {std::pair{"_exit", "_exit()"}, std::pair{"exec", "execl()"}}) {
    const Answer answer = plumbline({"run", "p.yaml", "bad.with.how=" + std::string(how)});
    EXPECT_EQ(answer.code, 1) << how;
    const std::string words =
        "p.yaml:4:3: node 'bad' (story.ends) ended the program, which a node must not do: it called ";
    EXPECT_TRUE(contains(answer.err, words + call)) << answer.err;
    EXPECT_TRUE(
        contains(read_file(plumbline.work() / "out/p/run.jsonl"), "{\"event\": \"killed\", \"by\": \"" + words + call));
    const Answer why = plumbline({"why", "a", "out/p"});
    EXPECT_EQ(why.code, 0) << why.err;
  }
  EXPECT_EQ(plumbline({"run", "p.yaml", "bad.with.how=fork"}).code, 0) << "processes of its own may end as they like";
  plumbline.write("a.yaml", "plumbline: 1\nnodes:\n  a: {use: story.constant}\n");
  EXPECT_TRUE(contains(plumbline({"run", "a.yaml"}).out, "1 reused")) << "what was done before is kept";
}

TEST(Ends, AnInterruptIsAnsweredAtOnce) {
  const Program plumbline;
  const fs::path log = plumbline.work() / "log";
  plumbline.write("p.yaml", "plumbline: 1\nnodes:\n  w: {use: story.logs, with: {log: " + log.string() +
                                ", milliseconds: 60000}}\n");
  const pid_t process = plumbline.start({"run", "p.yaml"});
  ASSERT_TRUE(wait_for_lines(log, 1));
  kill(process, SIGINT);
  const Answer answer = plumbline.finish(process);
  EXPECT_EQ(answer.code, 130);
  EXPECT_TRUE(contains(answer.err, "stopping as soon as the nodes that run now can")) << answer.err;
}

bool wait_for_text(const fs::path& file, const std::string& text) {
  for (int i = 0; i < 6000 && !contains(read_file(file), text); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return contains(read_file(file), text);
}

nlohmann::json last_line_of(const std::string& text) {
  std::istringstream lines(text);
  std::string last;
  for (std::string line; std::getline(lines, line);) last = line;
  return nlohmann::json::parse(last, nullptr, false);
}

/// A node that does not listen is left behind: the program ends, and nothing of the node is stored.
TEST(Ends, AnInterruptEndsTheProgramEvenIfANodeDoesNotListen) {
  for (const bool apart : {false, true})
    for (const int signal : {SIGINT, SIGTERM}) {
      const Program plumbline;
      if (apart) {
        fs::create_directories(plumbline.folder.path() / "lib/plumbline");
        fs::copy_file(PLUMBLINE_WORKER, plumbline.folder.path() / "lib/plumbline/plumbline-worker");
      }
      const fs::path started = plumbline.work() / "started";
      plumbline.write("p.yaml",
                      "plumbline: 1\nnodes:\n  a: {use: story.constant}\n  d: {use: story.deaf, with: {started: " +
                          started.string() + ", milliseconds: 60000}}\noutputs: {a.json: a.number}\n");
      std::vector<std::string> words{"run", "p.yaml", "--json"};
      if (apart) words.emplace_back("--isolate");
      const pid_t process = plumbline.start(words);
      ASSERT_TRUE(wait_for_lines(started, 1));
      const fs::path record = plumbline.work() / "out/p/run.jsonl";
      ASSERT_TRUE(wait_for_text(record, "\"event\":\"node\",\"name\":\"a\"") ||
                  contains(read_file(record), "\"event\": \"node\", \"name\": \"a\""))
          << read_file(record);
      kill(process, signal);
      const Answer answer = plumbline.finish(process);
      EXPECT_EQ(answer.code, 130) << answer.err;
      EXPECT_EQ(contains(answer.err, "nodes that did not stop in time were left"), !apart) << answer.err;
      const nlohmann::json end = last_line_of(read_file(record));
      EXPECT_EQ(end.value("event", ""), "run_end") << end;
      EXPECT_EQ(end.value("status", ""), "cancelled") << end;
      EXPECT_EQ(end.value("executed", -1), 1) << "what had ended before is told: " << end;
      EXPECT_EQ(end.value("cancelled", -1), 1) << end;
      EXPECT_EQ(last_line_of(answer.out), end) << "who reads standard output is told the end, too";
      EXPECT_FALSE(fs::exists(plumbline.work() / "out/p/a.json"));
      const Answer again = plumbline({"run", "p.yaml", "d.with.milliseconds=0"});
      EXPECT_EQ(again.code, 0) << again.err;
    }
}

}  // namespace test_once
}  // namespace plumbline::test
