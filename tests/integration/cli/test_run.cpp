// `plumbline run` from outside: outputs, reuse, failure, cancellation, a killed process.
#include <sys/stat.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "program.hpp"

namespace plumbline::test {
namespace test_run {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// A file appears, or a minute has passed.
bool wait_for(const fs::path& file) {
  for (int i = 0; i < 12'000 && !fs::exists(file); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return fs::exists(file);
}

size_t files_in(const fs::path& folder) {
  size_t count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) count += entry.is_regular_file();
  return count;
}

TEST(Run, WritesItsOutputsAndReusesThem) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  Answer answer = plumbline({"run", "p.yaml"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "executed  a (story.constant)")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "p.yaml: 2 executed, 0 reused, 0 failed")) << answer.out;
  EXPECT_FALSE(contains(answer.out, "\033")) << "no colours in a file";
  EXPECT_EQ(answer.err, "");
  EXPECT_EQ(Json::parse(read_file(plumbline.work() / "out/p/b.json")), (Json{{"value", 4.0}}));
  answer = plumbline({"run", "p.yaml", "--out", "elsewhere"});
  EXPECT_TRUE(contains(answer.out, "reused    a (story.constant)")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "p.yaml: 0 executed, 2 reused, 0 failed")) << answer.out;
  EXPECT_EQ(read_file(plumbline.work() / "elsewhere/b.json"), read_file(plumbline.work() / "out/p/b.json"));
}

TEST(Run, ASolverWithoutResultHasAnExitCodeOfItsOwn) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nnodes:\n  a: {use: story.throws}\n");
  EXPECT_EQ(plumbline({"run", "p.yaml", "a.with.how=not_converged"}).code, 4);
  std::istringstream record(read_file(plumbline.work() / "out/p/run.jsonl"));
  std::string line;
  std::getline(record, line) && std::getline(record, line);
  EXPECT_EQ(Json::parse(line).at("failure"), "not_converged") << line;
  for (const char* how : {"plain", "bad_input"})
    EXPECT_EQ(plumbline({"run", "p.yaml", std::string("a.with.how=") + how}).code, 1) << how;
}

TEST(Run, SaysThatItReplacesAnotherVariant) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  EXPECT_FALSE(contains(plumbline({"run", "p.yaml"}).out, "note:"));
  EXPECT_FALSE(contains(plumbline({"run", "p.yaml"}).out, "note:"));
  const std::string told = plumbline({"run", "p.yaml", "value=10"}).out;
  EXPECT_TRUE(contains(told, "the results of another variant (without overrides) in out/p are replaced")) << told;
  EXPECT_TRUE(contains(plumbline({"run", "p.yaml"}).out, "another variant (value=10)"));
  EXPECT_FALSE(contains(plumbline({"run", "p.yaml", "value=3", "--out", "out/p"}).out, "note:"));
}

TEST(Run, TakesOverridesAndIsQuiet) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  const Answer answer =
      plumbline({"run", "p.yaml", "value=10", "b.with.offset=-2", "-q", "--durable", "--threads", "1"});
  EXPECT_EQ(answer.code, 0);
  EXPECT_EQ(answer.out + answer.err, "");
  EXPECT_EQ(Json::parse(read_file(plumbline.work() / "out/p/b.json")), (Json{{"value", 8.0}}));
}

/// Whatever a node prints: a program reads what comes with --json line by line.
TEST(Run, JsonIsAloneOnStandardOutput) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nnodes:\n  a: {use: story.twice}\n  b: {use: story.constant}\n");
  const Answer answer = plumbline({"run", "p.yaml", "--json"});
  std::istringstream lines(answer.out);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) EXPECT_TRUE(Json::accept(line)) << line;
  EXPECT_EQ(count, 3) << answer.out;
  EXPECT_TRUE(contains(answer.err, "{\"first\": ")) << answer.err;
}

TEST(Run, JsonIsTheRecord) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  std::istringstream lines(plumbline({"run", "p.yaml", "--json"}).out);
  std::vector<Json> events;
  for (std::string line; std::getline(lines, line);) events.push_back(Json::parse(line));
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0]["name"], "a");
  EXPECT_EQ(events[2]["event"], "run_end");
  EXPECT_EQ(events[2]["status"], "ok");
}

TEST(Run, FilesOfOthersAreRefusedBeforeAnythingRuns) {
  const Program plumbline;
  plumbline.write("p.yaml",
                  "plumbline: 1\nnodes:\n  a: {use: story.constant}\n  w: {use: story.folder}\n"
                  "outputs: {report.html: a.number, campaign: w.folder}\n");
  fs::create_directories(plumbline.work() / "site/campaign/images");
  plumbline.write("site/campaign/images/1.jpg", "photograph");
  plumbline.write("site/report.html", "my own");
  Answer answer = plumbline({"run", "p.yaml", "--out", "site"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_EQ(answer.out, "") << "something ran";
  EXPECT_TRUE(contains(answer.err, "site/report.html was not written by a run")) << answer.err;
  EXPECT_TRUE(contains(answer.err, "site/campaign/images/1.jpg")) << answer.err;
  EXPECT_TRUE(contains(answer.err, "--out") && contains(answer.err, "--overwrite")) << answer.err;
  EXPECT_EQ(read_file(plumbline.work() / "site/campaign/images/1.jpg"), "photograph");
  EXPECT_EQ(read_file(plumbline.work() / "site/report.html"), "my own");
  EXPECT_FALSE(fs::exists(plumbline.work() / "site/run.jsonl"));
  answer = plumbline({"run", "p.yaml", "--out", "site", "--overwrite"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.err, "stays there beside")) << answer.err;
  EXPECT_EQ(read_file(plumbline.work() / "site/campaign/images/1.jpg"), "photograph");
  EXPECT_EQ(read_file(plumbline.work() / "site/campaign/a.txt"), "hello");
}

TEST(Run, AnOutputCannotBeTheFolderItself) {
  const Program plumbline;
  plumbline.write("keep.txt", "keep");
  for (const std::string name : {".", "./", "a/..", "run.jsonl"}) {
    plumbline.write("p.yaml", "plumbline: 1\nnodes: {w: {use: story.throws}}\noutputs: {\"" + name + "\": w.number}\n");
    const Answer answer = plumbline({"run", "p.yaml", "--out", "."});
    EXPECT_EQ(answer.code, 2) << answer.out << answer.err;
    EXPECT_TRUE(contains(answer.err, "p.yaml:3:11: '" + name + "' cannot be the name of an output")) << answer.err;
    EXPECT_EQ(read_file(plumbline.work() / "keep.txt"), "keep");
  }
}

TEST(Run, AnInvalidPipelineLeavesNoTrace) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nnodes: {a: {use: story.nothing}}\n");
  const Answer answer = plumbline({"run", "p.yaml"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "p.yaml:2:18: there is no node 'story.nothing'")) << answer.err;
  EXPECT_FALSE(fs::exists(plumbline.work() / "out"));
}

TEST(Run, AFailureIsExitCode1AndTheOtherBranchIsDelivered) {
  const Program plumbline;
  plumbline.write("f.yaml",
                  "plumbline: 1\nnodes:\n  x: {use: story.throws}\n  y: {use: story.add, in: {a: x.number}}\n"
                  "  c: {use: story.constant}\noutputs: {y.json: y.sum, c.json: c.number}\n");
  const Answer answer = plumbline({"run", "f.yaml", "--out", "out"});
  EXPECT_EQ(answer.code, 1);
  // What failed stands last, and what follows from it is one line.
  EXPECT_TRUE(contains(answer.err,
                       "\nFAILED\nf.yaml:3:3: node 'x' (story.throws) failed: the bridge is out\n1 node that needs it "
                       "did not run; not written: y.json.\nMend it and give the same command again: what was done is "
                       "kept.\n"))
      << answer.err;
  EXPECT_EQ(answer.err.find("the bridge is out"), answer.err.rfind("the bridge is out")) << "told once\n" << answer.err;
  EXPECT_FALSE(contains(answer.out, "y (story.add)")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "f.yaml: 1 executed, 0 reused, 1 failed, 1 skipped")) << answer.out;
  EXPECT_TRUE(fs::exists(plumbline.work() / "out/c.json"));
  EXPECT_FALSE(fs::exists(plumbline.work() / "out/y.json"));
}

/// Whoever waits for another branch learns at once that there is something to mend.
TEST(Run, AFailureIsToldWhileOthersGoOn) {
  const Program plumbline;
  plumbline.write("f.yaml",
                  "plumbline: 1\nnodes:\n  w: {use: story.waits, with: {started: waits}}\n"
                  "  l: {use: story.deaf, with: {started: works, milliseconds: 2300}}\n"
                  "  x: {use: story.throws, in: {number: l.number}}\n");
  const pid_t process = plumbline.start({"run", "f.yaml", "--threads", "2"});
  ASSERT_TRUE(wait_for(plumbline.work() / "works"));
  for (int i = 0; i < 12'000 && !contains(read_file(plumbline.folder.path() / "err"), "the bridge is out"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_TRUE(contains(read_file(plumbline.folder.path() / "err"), "the bridge is out"));
  kill(process, SIGINT);
  EXPECT_EQ(plumbline.finish(process).code, 130);
}

TEST(Run, ListsThatAreCutNameTheFileThatHasAll) {
  const Program plumbline;
  std::string nodes = "plumbline: 1\nnodes:\n", outputs = "outputs:\n";
  fs::create_directory(plumbline.work() / "mine");
  for (int i = 10; i < 30; ++i) {
    const std::string n = std::to_string(i);
    nodes += "  a" + n + ": {use: story.constant, with: {value: " + n + "}}\n  b" + n + ": {use: story.add, in: {a: a" +
             n + ".number}}\n";
    outputs += "  b" + n + ".json: b" + n + ".sum\n";
    plumbline.write("mine/b" + n + ".json", "somebody's");
  }
  plumbline.write("p.yaml", nodes + outputs);
  Answer answer = plumbline({"run", "p.yaml", "--out", "there"});
  EXPECT_TRUE(contains(answer.out, "4 more in there/run.jsonl")) << answer.out;
  answer = plumbline({"run", "p.yaml", "--out", "mine"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "and 10 more in mine")) << answer.err;
}

TEST(Run, PlacesThatCannotBeWritten) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  plumbline.write("file", "in the way");
  Answer answer = plumbline({"run", "p.yaml", "--out", "file/out"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "file/out") && contains(answer.err, "--out")) << answer.err;
  answer = plumbline({"run", "p.yaml", "--store", "file/store"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "file/store") && contains(answer.err, "--store")) << answer.err;
  answer = plumbline({"run", "p.yaml", "--memory", "lots"});
  EXPECT_EQ(answer.code, 2);
}

TEST(Run, InterruptedItEndsWith130AndGoesOnLater) {
  const Program plumbline;
  plumbline.write("p.yaml",
                  "plumbline: 1\nnodes:\n  a: {use: story.constant}\n  b: {use: story.add, in: {a: a.number}}\n"
                  "  w: {use: story.waits}\noutputs: {b.json: b.sum, w: w.folder}\n");
  for (const int signal : {SIGINT, SIGTERM}) {
    const fs::path started = plumbline.work() / ("started" + std::to_string(signal));
    const pid_t process = plumbline.start({"run", "p.yaml", "w.with.started=" + started.string(), "--threads", "2"});
    ASSERT_TRUE(wait_for(started));
    kill(process, signal);
    const Answer answer = plumbline.finish(process);
    EXPECT_EQ(answer.code, 130);
    EXPECT_TRUE(contains(answer.err, "cancelled")) << answer.err;
    EXPECT_FALSE(fs::exists(plumbline.work() / "out/p/b.json"));
    EXPECT_EQ(files_in(plumbline.folder.path() / "store/tmp") + files_in(plumbline.folder.path() / "store/folders"),
              0u);
  }
}

/// The record is of the run that was stopped, the files beside it are of the one before: both are told.
TEST(Run, AStoppedRunSaysWhoseOutputsLieThere) {
  const Program plumbline;
  plumbline.write("p.yaml",
                  "plumbline: 1\nvars: {value: 3}\nnodes:\n"
                  "  a: {use: story.constant, with: {value: \"${value}\"}}\noutputs: {a.json: a.number}\n");
  fs::copy_file(plumbline.work() / "p.yaml", plumbline.work() / "q.yaml");
  ASSERT_EQ(plumbline({"run", "p.yaml", "value=4"}).code, 0);
  const std::string before = read_file(plumbline.work() / "out/p/a.json");
  const fs::path started = plumbline.work() / "started";
  plumbline.write("p.yaml",
                  "plumbline: 1\nvars: {value: 3}\nnodes:\n"
                  "  a: {use: story.constant, with: {value: \"${value}\"}}\n  w: {use: story.waits, with: {started: " +
                      started.string() + "}}\noutputs: {a.json: a.number}\n");
  const pid_t process = plumbline.start({"run", "p.yaml", "value=5", "--threads", "2"});
  ASSERT_TRUE(wait_for(started));
  kill(process, SIGINT);
  const Answer answer = plumbline.finish(process);
  EXPECT_EQ(answer.code, 130);
  EXPECT_TRUE(contains(answer.err, "a.json in out/p: not of this run, but of the run of 2")) << answer.err;
  EXPECT_TRUE(contains(answer.err, "(value=4)")) << answer.err;
  EXPECT_EQ(read_file(plumbline.work() / "out/p/a.json"), before);
  const Json crate = Json::parse(plumbline({"export", "out/p", "--format", "ro-crate"}).out);
  for (const Json& item : crate.at("@graph")) EXPECT_NE(item.at("@id"), "a.json") << "the stopped run did not give it";
  // The next run knows still whose they are.
  fs::remove(plumbline.work() / "p.yaml");
  fs::rename(plumbline.work() / "q.yaml", plumbline.work() / "p.yaml");
  const Answer next = plumbline({"run", "p.yaml", "value=5"});
  EXPECT_TRUE(contains(next.out, "the results of another variant (value=4) in out/p are replaced")) << next.out;
  EXPECT_TRUE(contains(plumbline({"export", "out/p", "--format", "ro-crate"}).out, "\"a.json\""));
}

/// What a memory of hashes says of a file is believed; --rehash reads it once more.
TEST(Run, RehashReadsWhatTheMemoryOfHashesHasWrong) {
  const Program plumbline;
  fs::create_directory(plumbline.work() / "photographs");
  plumbline.write("photographs/1.jpg", "seven b");
  plumbline.write("p.yaml",
                  "plumbline: 1\nnodes:\n  l: {use: story.length, with: {folder: photographs}}\n"
                  "outputs: {l.json: l.number}\n");
  const auto tree_of_run = [&](const std::vector<std::string>& words) {
    const Answer answer = plumbline(words);
    EXPECT_EQ(answer.code, 0) << answer.err;
    std::istringstream lines(read_file(plumbline.work() / "out/p/run.jsonl"));
    for (std::string line; std::getline(lines, line);)
      if (const Json json = Json::parse(line); json.at("event") == "node")
        return json.at("fields").at("parameter folder").get<std::string>();
    return std::string();
  };
  const std::string right = tree_of_run({"run", "p.yaml"});
  struct stat info {};
  ASSERT_EQ(stat((plumbline.work() / "photographs/1.jpg").c_str(), &info), 0);
  const auto time = [](const timespec& t) { return std::to_string(t.tv_sec) + "." + std::to_string(t.tv_nsec); };
  std::ofstream(plumbline.folder.path() / "store/file-hashes", std::ios::app)
      << info.st_dev << ':' << info.st_ino << ':' << info.st_size << ':' << time(info.st_mtim) << ':'
      << time(info.st_ctim) << ' ' << std::string(64, 'a') << ' ' << (plumbline.work() / "photographs/1.jpg").string()
      << '\n';
  EXPECT_NE(tree_of_run({"run", "p.yaml"}), right) << "this test must be able to fail";
  EXPECT_EQ(tree_of_run({"run", "p.yaml", "--rehash"}), right);
}

TEST(Run, KilledItResumes) {
  const Program plumbline;
  const std::string nodes =
      "plumbline: 1\nnodes:\n  a: {use: story.constant}\n  b: {use: story.add, in: {a: a.number}}\n"
      "outputs: {b.json: b.sum}\n";
  plumbline.write("p.yaml", nodes);
  // The node that waits follows b, so b is in the store when the process is killed.
  plumbline.write("k.yaml", "plumbline: 1\ninclude: p.yaml\nnodes:\n  w: {use: story.waits, in: {after: b.sum}}\n");
  const fs::path started = plumbline.work() / "started";
  const pid_t process = plumbline.start({"run", "k.yaml", "w.with.started=" + started.string()});
  ASSERT_TRUE(wait_for(started));
  kill(process, SIGKILL);
  EXPECT_EQ(plumbline.finish(process).code, 128 + SIGKILL);
  EXPECT_FALSE(fs::exists(plumbline.work() / "out/k/b.json"));
  const Answer answer = plumbline({"run", "p.yaml"});
  EXPECT_EQ(answer.code, 0);
  EXPECT_TRUE(contains(answer.out, "p.yaml: 0 executed, 2 reused, 0 failed")) << answer.out;
}

TEST(Run, TwoAtOnceShareTheStore) {
  const Program first, second;
  const std::string nodes =
      "plumbline: 1\nnodes:\n  s: {use: story.series, with: {values: [1, 2, 3, 4, 5, 6, 7, 8]}}\n"
      "  q: {use: story.square, in: {number: s.numbers}}\n  t: {use: story.sum, in: {numbers: q.square}}\n"
      "  f: {use: story.folder}\noutputs: {t.json: t.sum, f: f.folder}\n";
  first.write("p.yaml", nodes);
  second.write("p.yaml", nodes);
  for (int i = 0; i < 5; ++i) {
    const std::string store = (first.folder.path() / ("shared" + std::to_string(i))).string();
    const pid_t one = first.start({"run", "p.yaml", "--store", store});
    const pid_t other = second.start({"run", "p.yaml", "--store", store});
    EXPECT_EQ(first.finish(one).code, 0);
    EXPECT_EQ(second.finish(other).code, 0);
    EXPECT_EQ(read_file(first.work() / "out/p/t.json"), read_file(second.work() / "out/p/t.json"));
    EXPECT_TRUE(contains(first({"run", "p.yaml", "--store", store}).out, "0 executed, 4 reused"));
  }
}

TEST(Run, OutputsInsideAnInputAreNoContentOfIt) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nnodes:\n  l: {use: story.length, with: {folder: .}}\n");
  EXPECT_EQ(plumbline({"run", "p.yaml", "--out", "out"}).code, 0);
  const Answer again = plumbline({"run", "p.yaml", "--out", "out"});
  EXPECT_TRUE(contains(again.out, "0 executed, 1 reused")) << again.out << again.err;
  const Answer among = plumbline({"run", "p.yaml", "--out", "."});
  EXPECT_TRUE(contains(among.out, "0 executed, 1 reused")) << among.out << among.err;
}

/// A metric is what a bench measures, and `invalid` what decides on exit code 3: both may differ where outputs do not.
TEST(Verify, ComparesNumbersAndWordsAndNotOutputsAlone) {
  Program plumbline;
  std::filesystem::create_directory(plumbline.work() / "nodes");
  plumbline.use_plugins(plumbline.work() / "nodes");
  const auto node = [&](const std::string& metrics) {
    plumbline.write("nodes/own.node.yaml",
                    "plumbline_node: 1\nkind: own.number\nversion: 1\nsummary: A number\nlicence: MIT\n"
                    "run: [/bin/sh, own.sh]\n");
    plumbline.write("nodes/own.sh",
                    "n=$(od -An -N4 -tu4 /dev/urandom)\nprintf '" + metrics + "' $n > \"$1/metrics.json\"\n");
  };
  plumbline.write("p.yaml", "plumbline: 1\nnodes: {a: {use: own.number}}\n");
  node("{\"error\": [%s, \"m\"]}");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"verify", "p.yaml"}, {"verify", "--each", "p.yaml"}}) {
    const Answer answer = plumbline(words);
    EXPECT_EQ(answer.code, 1) << answer.out << answer.err;
    EXPECT_TRUE(contains(answer.out, "metric error differs: ")) << answer.out;
  }
  node("{\"error\": [null, \"m\"], \"count\": [3, \"1\"]}");
  const Answer same = plumbline({"verify", "p.yaml"});
  EXPECT_EQ(same.code, 0) << same.out << same.err;
  node("{\"error\": [NaN, \"m\"]}");
  const Answer no_json = plumbline({"run", "p.yaml"});
  EXPECT_EQ(no_json.code, 1);
  EXPECT_TRUE(contains(no_json.err, "its metrics.json is no JSON, which has no NaN")) << no_json.err;
}

}  // namespace test_run
}  // namespace plumbline::test
