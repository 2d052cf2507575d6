// A node in a process of its own can do what it likes: it is an error of that node, told with its cause, and all else
// goes on.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <tuple>

#include "runtime/plugins/artifact_type.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/run/executor.hpp"
#include "runtime/run/plan.hpp"
#include "test_support.hpp"

namespace plumbline::test {
namespace {

using namespace runtime;
namespace fs = std::filesystem;
using Json = nlohmann::json;

class Isolation : public testing::Test {
 protected:
  Isolation() {
    for (const char* library : {PLUMBLINE_ACCIDENT_PLUGIN, PLUMBLINE_STORY_PLUGIN})
      if (!registry_.load(library)) throw std::runtime_error(registry_.refused().back().problem);
  }

  /// Runs nodes given as lines of YAML; all of them in workers if `all`.
  RunResult& run(const std::string& nodes, bool all = false, const std::atomic<bool>* cancel = nullptr) {
    std::ofstream(folder_.path() / "p.yaml") << "plumbline: 1\nvars: {seed: 1}\nnodes:\n" << nodes;
    graph_ = load_pipeline(folder_.path() / "p.yaml", {}, registry_);
    store_ = std::make_unique<Store>(folder_.path() / "store");
    Observer silent;
    RunOptions options;
    options.threads = 2;
    options.memory = uint64_t{1} << 30;
    options.cancel = cancel;
    options.isolate = all;
    options.worker = PLUMBLINE_WORKER_PROGRAM;
    result_ = execute(graph_, registry_, *store_, options, silent);
    return result_;
  }
  const NodeResult& node(const std::string& name) const {
    for (size_t i = 0; i < graph_.nodes.size(); ++i)
      if (graph_.nodes[i].name == name) return result_.nodes[i];
    throw std::runtime_error("no node " + name);
  }
  std::string value(const std::string& name) {
    const NodeResult& found = node(name);
    return blob_to_json(*store_, *registry_.type("plumbline.Number/1"), found.outputs.at("number").at(0));
  }

  TemporaryFolder folder_;
  Registry registry_;
  Graph graph_;
  std::unique_ptr<Store> store_;
  RunResult result_;
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

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

/// A manifest and a script beside it, in a folder of plugins.
fs::path write_node(const fs::path& folder, const std::string& script, const std::string& more = "") {
  std::ofstream(folder / "add.node.yaml")
      << "plumbline_node: 1\nkind: outside.add\nversion: 1\nsummary: Adds a number\nrun: [/usr/bin/python3, add.py]\n"
         "inputs: {number: {type: plumbline.Number/1, doc: a number}}\n"
         "outputs: {number: {type: plumbline.Number/1, doc: the sum}}\n"
         "parameters: {offset: {kind: number, default: 1, unit: m, minimum: 0, maximum: 100, doc: added}}\n"
      << more;
  std::ofstream(folder / "add.py") << "from plumbline_artifacts import Call\nimport os, sys\ncall = Call()\n" << script;
  return folder / "add.node.yaml";
}

const char* const adds =
    "value = call.inputs('number', 'plumbline.Number/1')[0].value\n"
    "print('warning: adding', file=sys.stderr)\n"
    "call.commit('number', 'plumbline.Number/1', {'value': value + call.parameters['offset']})\n";

TEST_F(Isolation, AllThatANodeStartsCountsInItsLimit) {
  ASSERT_TRUE(registry_.load_manifest(
      write_node(folder_.path(),
                 "import subprocess\n"
                 "for i in range(4):\n"
                 "  subprocess.Popen([sys.executable, '-c', 'x = b\"1\" * (150 << 20); import time; time.sleep(20)'])\n"
                 "import time\ntime.sleep(20)\n",
                 "memory_limit: 300MiB\n")));
  run("  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}}\n");
  EXPECT_TRUE(contains(node("b").error, "with all that it started")) << node("b").error;
}

/// In the program itself: a child that nobody waited for might write on, and one that returns would be the program
/// twice, with the same record and the same outputs.
TEST_F(Isolation, WhatANodeForksInTheProgramEndsWithIt) {
  run("  a: {use: accident.happens, with: {how: fork}}\n");
  EXPECT_TRUE(contains(node("a").error, "what it had forked went on (process ")) << node("a").error;
  run("  a: {use: accident.happens, with: {how: fork_and_return}}\n  b: {use: accident.happens, in: {number: "
      "a.number}}\n");
  EXPECT_TRUE(contains(value("a"), "1")) << value("a");
  EXPECT_TRUE(contains(value("b"), "2")) << value("b");
}

/// What it left running might write outputs after they were taken. What ends by itself in a moment is waited for.
TEST_F(Isolation, ANodeInPythonThatLeavesSomethingRunningIsRefused) {
  const std::tuple<const char*, const char*> ways[] = {
      {"import subprocess\nsubprocess.Popen(['sleep', '30'])\n", "'sleep' (process "},
      {"if os.fork() == 0:\n  os.setsid()\n  if os.fork() == 0:\n    import time\n    time.sleep(30)\n  os._exit(0)\n",
       "might still have written its outputs: '"},
      {"import subprocess\nsubprocess.Popen(['sleep', '0.3'], start_new_session=True)\n", ""},
  };
  for (const auto& [script, words] : ways) {
    const TemporaryFolder folder;
    Registry registry;
    ASSERT_TRUE(registry.load(PLUMBLINE_STORY_PLUGIN));
    ASSERT_TRUE(registry.load_manifest(write_node(folder.path(), adds + std::string(script))));
    std::swap(registry, registry_);
    run("  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}}\n");
    if (*words)
      EXPECT_TRUE(contains(node("b").error, words)) << script << ": " << node("b").error;
    else
      EXPECT_EQ(node("b").error, "") << script;
    std::swap(registry, registry_);
  }
}

TEST_F(Isolation, ANodeInPythonIsANodeLikeAnyOther) {
  ASSERT_TRUE(registry_.load_manifest(write_node(folder_.path(), adds))) << registry_.refused().back().problem;
  const std::string nodes =
      "  a: {use: story.constant, with: {value: 3}}\n"
      "  b: {use: outside.add, in: {number: a.number}, with: {offset: 4}}\n"
      "  c: {use: accident.happens, in: {number: b.number}}\n";
  run(nodes, true);
  ASSERT_EQ(node("b").error, "");
  EXPECT_TRUE(contains(value("b"), "7")) << value("b");
  EXPECT_TRUE(contains(value("c"), "8")) << value("c");
  EXPECT_EQ(node("b").warnings, std::vector<std::string>{"adding"});
  run(nodes);
  EXPECT_EQ(node("b").status, NodeStatus::reused);
}

/// What a bench can measure: an evaluator in numpy.
TEST_F(Isolation, ANodeInPythonGivesMetrics) {
  ASSERT_TRUE(registry_.load_manifest(
      write_node(folder_.path(),
                 std::string(adds) + "call.metric('rmse_z', 0.0012, 'm')\ncall.metric('bound', float('nan'), 'm')\n")));
  run("  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}}\n");
  ASSERT_EQ(node("b").error, "");
  ASSERT_EQ(node("b").metrics.size(), 2u);
  for (const Metric& metric : node("b").metrics) {
    EXPECT_EQ(metric.unit, "m");
    if (metric.name == "rmse_z")
      EXPECT_EQ(metric.value, 0.0012);
    else
      EXPECT_TRUE(std::isnan(metric.value)) << metric.name;
  }
}

TEST_F(Isolation, ANodeInPythonThatFailsIsNamedWithItsLastWords) {
  const std::tuple<const char*, const char*, const char*> accidents[] = {
      {"raise RuntimeError('no such thing')", "", "RuntimeError: no such thing"},
      {"os.kill(os.getpid(), 11)", "", "died of signal 11"},
      {"", "", "without committing its output 'number'"},
      {"open(os.path.join(call.folder, 'outputs/number/0'), 'wb').write(b'rubbish!')", "",
       "is no valid plumbline.Number/1"},
      {"open(os.path.join(call.folder, 'metrics.json'), 'w').write('{\"rmse\": \"good\"}')", "",
       "the metric 'rmse' in its metrics.json is no [VALUE, \"UNIT\"]"},
      {"import time\ntime.sleep(3600)", "time_limit: 0.5 s\n", "longer than its limit of 0.5 s"},
  };
  for (const auto& [script, more, words] : accidents) {
    const TemporaryFolder folder;
    Registry registry;
    ASSERT_TRUE(registry.load(PLUMBLINE_STORY_PLUGIN));
    ASSERT_TRUE(registry.load_manifest(write_node(folder.path(), script, more))) << registry.refused().back().problem;
    std::swap(registry, registry_);
    run("  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}}\n");
    EXPECT_TRUE(contains(node("b").error, words)) << script << ": " << node("b").error;
    std::swap(registry, registry_);
  }
}

TEST_F(Isolation, AManifestIsCheckedLikeATable) {
  const std::pair<const char*, const char*> flaws[] = {
      {"licens: MIT\n", "is wrong at line 9: a manifest has no 'licens' — did you mean 'licence'?"},
      {"kind: outside.add\n", "line 9: 'kind' stands twice in a manifest"},
      {"needs: [weights.bin]\n", "line 9: there is no file"},
      {"needs: weights.bin\n", "line 9: 'needs' is a list"},
      {"seed: maybe\n", "line 9: 'seed' is true or false"},
      {"memory_limit: []\n", "line 9: 'memory_limit' is one plain value"},
      {"licence: [\n", "is wrong at line"},
      {"role: detector\n", "in the role 'detector', but it has no input 'images'"},
      {"time_limit: soon\n", "'time_limit' is a time"},
  };
  for (const auto& [more, words] : flaws) {
    const TemporaryFolder folder;
    EXPECT_FALSE(registry_.load_manifest(write_node(folder.path(), adds, more)));
    EXPECT_TRUE(contains(registry_.refused().back().problem, words)) << registry_.refused().back().problem;
  }
}

/// `needs` and the script are part of the key.
TEST_F(Isolation, AChangeOfWhatAnExecutableNeedsRunsItAgain) {
  const std::string nodes = "  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}}\n";
  const fs::path plugins = folder_.path() / "plugins";
  fs::create_directory(plugins);
  const auto run_with = [&](const std::string& table) {
    std::ofstream(plugins / "table.txt") << table;
    Registry registry;
    ASSERT_TRUE(registry.load(PLUMBLINE_STORY_PLUGIN));
    ASSERT_TRUE(registry.load_manifest(write_node(plugins, adds, "needs: [table.txt]\n")));
    std::swap(registry, registry_);
    run(nodes);
    std::swap(registry, registry_);
  };
  run_with("1");
  run_with("1");
  EXPECT_EQ(node("b").status, NodeStatus::reused) << node("b").error;
  run_with("2");
  EXPECT_EQ(node("b").status, NodeStatus::executed) << node("b").error;
}

/// What an executable does it does with the user's rights: nobody else may have written it.
TEST_F(Isolation, AnExecutableThatOthersMayWriteIsRefused) {
  for (const std::string file : {"", "add.node.yaml", "add.py"}) {
    const TemporaryFolder folder;
    const fs::path manifest = write_node(folder.path(), adds);
    fs::permissions(folder.path() / file, fs::perms::others_write, fs::perm_options::add);
    EXPECT_FALSE(registry_.load_manifest(manifest)) << file;
    EXPECT_TRUE(contains(registry_.refused().back().problem, "may be written by everybody on this machine"))
        << registry_.refused().back().problem;
  }
}

/// Modules that a node imports are part of what its result depends on, whether its manifest names them or not.
TEST_F(Isolation, AChangeOfAModuleThatANodeImportsRunsItAgain) {
  const fs::path manifest = write_node(folder_.path(),
                                       "from helper import more\n"
                                       "call.commit('number', 'plumbline.Number/1', {'value': more})\n");
  const fs::path helper = folder_.path() / "helper.py";
  const std::string nodes = "  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}}\n";
  std::ofstream(helper) << "more = 1\n";
  ASSERT_TRUE(registry_.load_manifest(manifest)) << registry_.refused().back().problem;
  run(nodes);
  ASSERT_EQ(node("b").error, "");
  EXPECT_TRUE(node("b").used.count(helper.string()));
  run(nodes);
  EXPECT_EQ(node("b").status, NodeStatus::reused);
  EXPECT_TRUE(node("b").used.count(helper.string())) << "what it used is told of a reused result, too";
  std::ofstream(helper) << "more = 23\n";
  EXPECT_EQ(plan(graph_, *store_).at(1).reasons,
            std::vector<std::string>{helper.string() + ", which it used, has changed"});
  run(nodes);
  EXPECT_EQ(node("b").status, NodeStatus::executed);
  EXPECT_EQ(node("b").why, std::vector<std::string>{helper.string() + ", which it used, has changed"});
  EXPECT_TRUE(contains(value("b"), "23")) << value("b");
  fs::rename(helper, folder_.path() / "other.py");
  run(nodes);
  EXPECT_EQ(node("b").status, NodeStatus::failed) << "a module that is gone is not forgotten";
}

const char* const kUsesHelper =
    "from helper import more\n"
    "call.commit('number', 'plumbline.Number/1', {'value': more})\n";
const std::string kHelped = "  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}}\n";

/// Hashed after the end, the new content would stand for what came of the old one.
TEST_F(Isolation, AModuleThatChangesWhileTheNodeRunsIsRefused) {
  const fs::path helper = folder_.path() / "helper.py", edited = folder_.path() / "edited";
  std::ofstream(helper) << "more = 1\n";
  std::ofstream(edited) << "1";
  // As an editor does it, once: the node itself waits for nobody.
  ASSERT_TRUE(registry_.load_manifest(
      write_node(folder_.path(), std::string("from helper import more\n") + "if os.path.exists('" + edited.string() +
                                     "'):\n  os.remove('" + edited.string() + "')\n  open('" + helper.string() +
                                     "', 'w').write('more = 2\\n')\n" +
                                     "call.commit('number', 'plumbline.Number/1', {'value': more})\n")));
  run(kHelped);
  EXPECT_EQ(node("b").status, NodeStatus::failed);
  EXPECT_TRUE(contains(node("b").error, helper.string() + " changed while the node worked with it; run again"))
      << node("b").error;
  run(kHelped);
  EXPECT_EQ(node("b").status, NodeStatus::executed) << node("b").error;
  EXPECT_TRUE(contains(value("b"), "2")) << value("b");
}

/// The key has the script as it was when it was found.
TEST_F(Isolation, AScriptThatChangedSinceItWasFoundIsRefused) {
  ASSERT_TRUE(registry_.load_manifest(write_node(folder_.path(), adds)));
  std::ofstream(folder_.path() / "add.py", std::ios::app) << "# another\n";
  run(kHelped);
  EXPECT_TRUE(contains(node("b").error, "add.py is not the file any more that was looked at; run again"))
      << node("b").error;
  Registry again;
  ASSERT_TRUE(again.load(PLUMBLINE_STORY_PLUGIN));
  ASSERT_TRUE(again.load_manifest(write_node(
      folder_.path(), "open('" + (folder_.path() / "add.py").string() + "', 'a').write('# more\\n')\n" + adds)));
  std::swap(again, registry_);
  run(kHelped);
  EXPECT_TRUE(contains(node("b").error, "add.py is not the file any more that was looked at")) << node("b").error;
  std::swap(again, registry_);
}

TEST_F(Isolation, AModuleThatStandsBeforeTheOneThatWasImportedRunsItAgain) {
  const fs::path before = folder_.path() / "before", behind = folder_.path() / "behind";
  fs::create_directories(before);
  fs::create_directories(behind);
  setenv("PYTHONPATH", (before.string() + ":" + behind.string()).c_str(), 1);
  std::ofstream(behind / "helper.py") << "more = 1\n";
  ASSERT_TRUE(registry_.load_manifest(write_node(folder_.path(), kUsesHelper)));
  run(kHelped);
  ASSERT_EQ(node("b").error, "");
  run(kHelped);
  ASSERT_EQ(node("b").status, NodeStatus::reused);
  std::ofstream(before / "helper.py") << "more = 23\n";
  run(kHelped);
  EXPECT_EQ(node("b").why, std::vector<std::string>{(before / "helper.py").string() +
                                                    " is there now, and may be taken in place of what it used"});
  EXPECT_TRUE(contains(value("b"), "23")) << value("b");
  EXPECT_FALSE(node("b").used.count((before / "helper/__init__.py").string())) << "what is not there was not used";
  unsetenv("PYTHONPATH");
}

TEST_F(Isolation, AModuleBehindALinkThatWasSwitchedRunsItAgain) {
  const fs::path link = folder_.path() / "current";
  for (const std::string version : {"1", "2"}) {
    fs::create_directory(folder_.path() / version);
    std::ofstream(folder_.path() / version / "helper.py") << "more = 4" << version << "\n";
  }
  fs::create_directory_symlink("1", link);
  setenv("PYTHONPATH", link.c_str(), 1);
  ASSERT_TRUE(registry_.load_manifest(write_node(folder_.path(), kUsesHelper)));
  run(kHelped);
  ASSERT_EQ(node("b").error, "");
  EXPECT_TRUE(contains(value("b"), "41")) << value("b");
  fs::remove(link);
  fs::create_directory_symlink("2", link);
  run(kHelped);
  EXPECT_EQ(node("b").status, NodeStatus::executed);
  EXPECT_TRUE(contains(value("b"), "42")) << value("b");
  unsetenv("PYTHONPATH");
}

TEST_F(Isolation, ThePathOfPythonIsPartOfTheKey) {
  for (const std::string version : {"1", "2"}) {
    fs::create_directory(folder_.path() / version);
    std::ofstream(folder_.path() / version / "helper.py") << "more = 4" << version << "\n";
  }
  ASSERT_TRUE(registry_.load_manifest(write_node(folder_.path(), kUsesHelper)));
  for (const std::string version : {"1", "2"}) {
    setenv("PYTHONPATH", (folder_.path() / version).c_str(), 1);
    run(kHelped);
    EXPECT_TRUE(contains(value("b"), "4" + version)) << value("b");
  }
  EXPECT_EQ(node("b").fields.count("environment PYTHONPATH"), 1u);
  EXPECT_EQ(node("a").fields.count("environment PYTHONPATH"), 0u) << "a library does not look at it";
  unsetenv("PYTHONPATH");
}

/// And what others may write is not run, wherever in the script it is imported.
TEST_F(Isolation, AModuleThatOthersMayWriteIsNotImported) {
  const fs::path helper = folder_.path() / "helper.py", ran = folder_.path() / "ran";
  std::ofstream(helper) << "open('" << ran.string() << "', 'w')\nmore = 1\n";
  const std::string commits = "call.commit('number', 'plumbline.Number/1', {'value': more})\n";
  ASSERT_TRUE(registry_.load_manifest(write_node(folder_.path(), "from helper import more\n" + commits)));
  const std::string nodes = "  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}}\n";
  fs::permissions(helper, fs::perms::others_write, fs::perm_options::add);
  run(nodes);
  EXPECT_TRUE(contains(node("b").error, "the module 'helper' is not imported: " + helper.string() +
                                            " may be written by everybody on this machine"))
      << node("b").error;
  EXPECT_FALSE(fs::exists(ran));
  fs::permissions(helper, fs::perms::others_write, fs::perm_options::remove);
  run(nodes);
  EXPECT_EQ(node("b").error, "");
  // Imported before the module that watches.
  std::ofstream(folder_.path() / "add.py")
      << "from helper import more\nfrom plumbline_artifacts import Call\ncall = Call()\n"
      << commits;
  Registry registry;
  ASSERT_TRUE(registry.load(PLUMBLINE_STORY_PLUGIN));
  fs::permissions(helper, fs::perms::others_write, fs::perm_options::add);
  ASSERT_TRUE(registry.load_manifest(folder_.path() / "add.node.yaml"));
  std::swap(registry, registry_);
  run(nodes);
  EXPECT_TRUE(contains(node("b").error, "a module was imported that is not believed")) << node("b").error;
  std::swap(registry, registry_);
}

/// A limit in the pipeline stands in place of the manifest's.
TEST_F(Isolation, APipelineLimitsAnExecutable) {
  ASSERT_TRUE(
      registry_.load_manifest(write_node(folder_.path(), "import time\ntime.sleep(3600)", "time_limit: 1 h\n")));
  run("  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}, time_limit: 0.5 s}\n");
  EXPECT_TRUE(contains(node("b").error, "longer than its limit of 0.5 s")) << node("b").error;
}

const std::pair<const char*, const char*> changes[] = {
    {"blocked", "the signals that its thread blocks"},
    {"umask", "the umask (0000 in place of "},
    {"folder", "the working folder"},
    {"locale", "the locale (C.UTF-8 in place of C)"},
    {"environment", "the environment (ACCIDENT_WAS_HERE, PATH)"},
    {"signals", "what signals do (SIGCHLD)"},
    // These last: after them all nodes of this process run apart.
    {"rounding", "the floating-point mode of its thread: rounding (upwards)"},
#if defined(__x86_64__)
    {"subnormals", "subnormal results (set to zero), subnormal operands (taken as zero)"},
    {"traps", "traps of floating-point exceptions"},
#endif
};

/// The sum as it is in the mode that IEEE 754 has by default.
double thirds() {
  volatile double one = 1, three = 3, sum = 0;
  for (int i = 0; i < 1000; ++i) sum = sum + one / three;
  return sum + 1;
}

/// What a node leaves changed is named, its result is not kept, and what runs afterwards knows nothing of it.
TEST_F(Isolation, WhatANodeLeavesChangedIsNamedAndReachesNoOther) {
  int salt = 0;
  for (const bool apart : {false, true})
    for (const auto& [what, words] : changes) {
      const std::string bad = "  bad: {use: accident.leaves_changed, with: {what: " + std::string(what) + "}}\n";
      run(bad, apart);
      EXPECT_EQ(node("bad").status, NodeStatus::failed) << what << apart;
      EXPECT_TRUE(contains(node("bad").error, "node 'bad' (accident.leaves_changed) failed: it left changed"))
          << node("bad").error;
      EXPECT_TRUE(contains(node("bad").error, words)) << node("bad").error;
      run("  next: {use: accident.thirds, with: {salt: " + std::to_string(++salt) + "}}\n", apart);
      ASSERT_EQ(node("next").error, "") << what << apart;
      EXPECT_EQ(Json::parse(value("next")).at("value").get<double>(), thirds()) << what << apart;
      run(bad, apart);
      EXPECT_EQ(node("bad").status, NodeStatus::failed) << what << ": it must not have been stored";
    }
}

/// Who ran beside it when the process changed may have suffered from it: it is run again apart, and is not blamed.
TEST_F(Isolation, WhoRunsBesideOneThatChangesTheProcessIsRunAgainApart) {
  const TemporaryFolder place;
  const fs::path before = fs::current_path();
  run("  bad: {use: accident.leaves_changed, with: {what: folder, place: " + place.path().string() +
      "}}\n  good: {use: accident.thirds, with: {place: " + place.path().string() + "}}\n");
  EXPECT_EQ(node("bad").status, NodeStatus::failed);
  EXPECT_TRUE(contains(node("bad").error, "it left changed what it must leave as it finds it: the working folder"))
      << node("bad").error;
  EXPECT_EQ(node("good").error, "");
  EXPECT_EQ(Json::parse(value("good")).at("value").get<double>(), thirds());
  EXPECT_EQ(fs::current_path(), before);
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

}  // namespace
}  // namespace plumbline::test
