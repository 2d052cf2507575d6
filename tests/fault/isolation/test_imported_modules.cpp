// Modules that a node in Python imports: part of what its result depends on, whether its manifest names them or not.
#include <gtest/gtest.h>

#include "isolated_run.hpp"
#include "runtime/run/plan.hpp"

namespace plumbline::test {
namespace test_imported_modules {

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

}  // namespace test_imported_modules
}  // namespace plumbline::test
