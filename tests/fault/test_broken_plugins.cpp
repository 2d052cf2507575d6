// A plugin that is broken is refused with the reason and its mend; the ones beside it work on.
#include <cstring>
#include <functional>

#include "runtime/registry.hpp"
#include "test_support.hpp"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;
using runtime::Registry;

/// Why the host refuses the library after it has loaded a good one; "" if it takes it.
std::string refusal(const fs::path& library) {
  Registry registry;
  if (!registry.load(PLUMBLINE_STORY_PLUGIN)) return "the story plugin does not load";
  const size_t kinds = registry.kinds().size();
  if (registry.load(library)) return "";
  if (registry.kinds().size() != kinds) return "a refused plugin left nodes behind";
  if (registry.refused().size() != 1) return "the refused plugin is not shown";
  return registry.refused()[0].problem;
}

fs::path fixture(const std::string& name) { return fs::path(PLUMBLINE_BROKEN_PLUGINS) / (name + ".so"); }

class BrokenPlugin : public testing::Test {
 protected:
  // What passed once is remembered by hash in the cache; the tests start without memory.
  void SetUp() override { setenv("XDG_CACHE_HOME", cache_.path().c_str(), 1); }
  void TearDown() override { unsetenv("XDG_CACHE_HOME"); }
  TemporaryFolder cache_;
};

void expect_refusal(const std::string& name, const std::string& words) {
  ASSERT_TRUE(fs::exists(fixture(name))) << fixture(name);
  const std::string problem = refusal(fixture(name));
  EXPECT_NE(problem.find(words), std::string::npos) << name << ": " << problem;
}

TEST_F(BrokenPlugin, NoNote) { expect_refusal("no_note", "note"); }
TEST_F(BrokenPlugin, WrongMajorIsRefusedBeforeItsCodeRuns) {
  expect_refusal("wrong_major", "is built for plugin ABI 2.0");
}
TEST_F(BrokenPlugin, NewerMinorIsRefusedBeforeItsCodeRuns) { expect_refusal("newer_minor", "needs plugin ABI 1.1"); }
TEST_F(BrokenPlugin, TableOfOtherAbi) { expect_refusal("table_of_other_abi", "is built for plugin ABI 8.0"); }
TEST_F(BrokenPlugin, BadMagic) { expect_refusal("bad_magic", "magic"); }
TEST_F(BrokenPlugin, NullTable) { expect_refusal("null_table", "table"); }
TEST_F(BrokenPlugin, NoEntry) { expect_refusal("no_entry", "plumbline_plugin()"); }
TEST_F(BrokenPlugin, MissingSymbol) { expect_refusal("missing_symbol", "function_of_a_library_that_was_not_linked"); }
TEST_F(BrokenPlugin, CrashIsContained) { expect_refusal("crashes", "signal 11"); }
TEST_F(BrokenPlugin, ExceptionIsContained) { expect_refusal("throws_in_table", "no table today"); }
TEST_F(BrokenPlugin, DuplicateKind) { expect_refusal("duplicate_kind", "story.constant"); }
TEST_F(BrokenPlugin, OtherUnit) { expect_refusal("other_unit", "'mm'"); }

/// The good plugin with some bytes changed.
fs::path damaged(const fs::path& folder, const std::string& name, const std::function<void(std::string&)>& damage) {
  std::string bytes = read_file(PLUMBLINE_STORY_PLUGIN);
  damage(bytes);
  std::ofstream(folder / name, std::ios::binary) << bytes;
  return folder / name;
}

TEST_F(BrokenPlugin, FilesThatAreNoLibraryOfThisMachine) {
  const TemporaryFolder folder;
  const auto empty = damaged(folder.path(), "empty.so", [](std::string& bytes) { bytes.clear(); });
  EXPECT_NE(refusal(empty), "");
  const auto text = damaged(folder.path(), "text.so", [](std::string& bytes) { bytes = "#!/bin/sh\necho hello\n"; });
  EXPECT_NE(refusal(text).find("ELF"), std::string::npos) << refusal(text);
  const auto arm = damaged(folder.path(), "arm.so", [](std::string& bytes) { bytes[18] = '\xb7'; });  // EM_AARCH64
  EXPECT_NE(refusal(arm), "");
  const auto narrow = damaged(folder.path(), "narrow.so", [](std::string& bytes) { bytes[4] = 1; });  // ELFCLASS32
  EXPECT_NE(refusal(narrow), "");
  EXPECT_NE(refusal(folder.path() / "missing.so"), "");
  EXPECT_NE(refusal(folder.path()), "");
}

TEST_F(BrokenPlugin, CutOffAnywhere) {
  const TemporaryFolder folder;
  const size_t size = read_file(PLUMBLINE_STORY_PLUGIN).size();
  for (const size_t keep : {size_t{10}, size_t{64}, size_t{300}, size_t{4096}, size / 2}) {
    const auto cut =
        damaged(folder.path(), std::to_string(keep) + ".so", [&](std::string& bytes) { bytes.resize(keep); });
    EXPECT_NE(refusal(cut), "") << keep << " bytes";
  }
}

TEST_F(BrokenPlugin, HeadersThatLie) {
  const TemporaryFolder folder;
  // Program header table beyond the end, of absurd count, of absurd entry size; section table likewise.
  for (const auto& [offset, width] : {std::pair<size_t, size_t>{32, 8}, {40, 8}, {54, 2}, {56, 2}}) {
    const auto liar =
        damaged(folder.path(), std::to_string(offset) + ".so",
                [&, o = offset, w = width](std::string& bytes) { std::memset(bytes.data() + o, 0xff, w); });
    refusal(liar);  // refused or not, it must not bring the host down
  }
}

TEST_F(BrokenPlugin, TheOnesBesideItWork) {
  auto registry =
      Registry::discover({fs::path(PLUMBLINE_STORY_PLUGIN).parent_path(), fs::path(PLUMBLINE_BROKEN_PLUGINS)});
  EXPECT_TRUE(registry.find("story.add"));
  EXPECT_GE(registry.refused().size(), 9u);
  for (const auto& refused : registry.refused()) EXPECT_NE(refused.problem, "") << refused.path;
}

}  // namespace
}  // namespace plumbline::test
