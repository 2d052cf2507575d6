// Executables as nodes: what they give, leave running, fail with, and what their manifest may say.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "isolated_run.hpp"

namespace plumbline::test {
namespace test_executable_nodes {

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

/// A limit in the pipeline stands in place of the manifest's.
TEST_F(Isolation, APipelineLimitsAnExecutable) {
  ASSERT_TRUE(
      registry_.load_manifest(write_node(folder_.path(), "import time\ntime.sleep(3600)", "time_limit: 1 h\n")));
  run("  a: {use: story.constant}\n  b: {use: outside.add, in: {number: a.number}, time_limit: 0.5 s}\n");
  EXPECT_TRUE(contains(node("b").error, "longer than its limit of 0.5 s")) << node("b").error;
}

}  // namespace test_executable_nodes
}  // namespace plumbline::test
