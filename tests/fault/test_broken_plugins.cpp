// A plugin that is broken is refused with the reason and its mend; the ones beside it work on.
#include <cstring>
#include <functional>

#include "runtime/graph/graph.hpp"
#include "runtime/plugins/registry.hpp"
#include "test_support.hpp"

namespace plumbline::test {
namespace test_broken_plugins {

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
  expect_refusal("wrong_major", "is built for plugin ABI " + std::to_string(PLUMBLINE_ABI_MAJOR + 1) + ".0");
}
TEST_F(BrokenPlugin, NewerMinorIsRefusedBeforeItsCodeRuns) {
  expect_refusal("newer_minor", "needs plugin ABI " + std::to_string(PLUMBLINE_ABI_MAJOR) + "." +
                                    std::to_string(PLUMBLINE_ABI_MINOR + 1));
}
TEST_F(BrokenPlugin, TableOfOtherAbi) {
  expect_refusal("table_of_other_abi", "is built for plugin ABI " + std::to_string(PLUMBLINE_ABI_MAJOR + 7) + ".0");
}
TEST_F(BrokenPlugin, BadMagic) { expect_refusal("bad_magic", "magic"); }
TEST_F(BrokenPlugin, NullTable) { expect_refusal("null_table", "table"); }
TEST_F(BrokenPlugin, NoEntry) { expect_refusal("no_entry", "plumbline_plugin()"); }
TEST_F(BrokenPlugin, MissingSymbol) { expect_refusal("missing_symbol", "function_of_a_library_that_was_not_linked"); }
TEST_F(BrokenPlugin, CrashIsContained) { expect_refusal("crashes", "signal 11"); }
TEST_F(BrokenPlugin, ExceptionIsContained) { expect_refusal("throws_in_table", "no table today"); }
TEST_F(BrokenPlugin, DuplicateKind) { expect_refusal("duplicate_kind", "story.constant"); }

/// Of two libraries only the kind that both offer is in question.
TEST_F(BrokenPlugin, AKindOfferedTwiceCostsNoOther) {
  Registry registry;
  ASSERT_TRUE(registry.load(std::string(PLUMBLINE_BROKEN_PLUGINS) + "/duplicate_kind.so"));
  EXPECT_TRUE(registry.load(PLUMBLINE_STORY_PLUGIN));
  EXPECT_TRUE(registry.find("story.add")) << "all others of the second library are taken";
  EXPECT_EQ(registry.find("story.constant")->plugin->identity.path.filename(), "duplicate_kind.so");
  EXPECT_EQ(registry.offered_twice_by("story.constant"), std::vector<std::filesystem::path>{PLUMBLINE_STORY_PLUGIN});
  EXPECT_TRUE(registry.offered_twice_by("story.add").empty());
  ASSERT_EQ(registry.refused().size(), 1u);
  EXPECT_NE(registry.refused()[0].problem.find("its other nodes are taken"), std::string::npos);
  EXPECT_EQ(registry.refused()[0].path, PLUMBLINE_STORY_PLUGIN);
  EXPECT_EQ(registry.refused()[0].hidden_by.filename(), "duplicate_kind.so");
}

/// A copy of a library hides all of it: one sentence, and nothing that says that some of it is taken.
TEST_F(BrokenPlugin, ACopyIsHiddenAsAWhole) {
  const TemporaryFolder folder;
  const std::filesystem::path copies[] = {folder.path() / "a.so", folder.path() / "b.so"};
  std::filesystem::copy(std::filesystem::path(PLUMBLINE_STORY_PLUGIN).parent_path() / "roles", folder.path() / "roles");
  Registry registry;
  ASSERT_TRUE(registry.load(PLUMBLINE_STORY_PLUGIN));
  for (const auto& copy : copies) {
    std::filesystem::copy_file(PLUMBLINE_STORY_PLUGIN, copy);
    EXPECT_FALSE(registry.load(copy));
  }
  ASSERT_EQ(registry.refused().size(), 2u);
  for (const auto& refused : registry.refused()) {
    EXPECT_EQ(refused.hidden_by, PLUMBLINE_STORY_PLUGIN);
    EXPECT_NE(refused.problem.find("'story.add', "), std::string::npos) << refused.problem;
    EXPECT_EQ(refused.problem.find("its other nodes are taken"), std::string::npos) << refused.problem;
  }
  EXPECT_EQ(registry.offered_twice_by("story.add"), std::vector<std::filesystem::path>(copies, copies + 2));
}

/// What a node gave is read by the type of its own plugin: another one may call something else by that name.
TEST_F(BrokenPlugin, TypesOfOneNameArePartedByTheirPlugins) {
  Registry registry;
  ASSERT_TRUE(registry.load(PLUMBLINE_STORY_PLUGIN));
  ASSERT_TRUE(registry.load(std::string(PLUMBLINE_BROKEN_PLUGINS) + "/other_unit.so"));
  const std::string name = "plumbline.Number/1";
  const auto* mine = registry.type_of_output("fault.millimetres", "number", name);
  ASSERT_TRUE(mine && registry.type(name));
  EXPECT_STRNE(mine->fingerprint, registry.type(name)->fingerprint);
  EXPECT_EQ(registry.type_of_output("story.add", "sum", name), registry.type(name));
  EXPECT_EQ(registry.type_of_output("gone.since", "sum", name), registry.type(name));
  ASSERT_EQ(registry.refused().size(), 1u) << "that they are two is said";
  EXPECT_EQ(registry.refused()[0].path.filename(), "other_unit.so");
  EXPECT_EQ(registry.refused()[0].hidden_by, PLUMBLINE_STORY_PLUGIN);
}

/// Every fixture made from good.cpp: what is broken, and words of the refusal.
TEST_F(BrokenPlugin, EveryFlawOfATableIsNamed) {
  const std::pair<const char*, const char*> flaws[] = {
      {"null_nodes", "null pointer in place of its 1 nodes"},
      {"null_node", "null pointer as number 1 of its nodes"},
      {"null_types", "null pointer in place of its 1 types"},
      {"null_inputs", "null pointer in place of its 1 inputs of 'broken.node'"},
      {"null_param", "number 2 of its parameters of 'broken.node'"},
      {"null_choices", "choices of parameter 'mode' of 'broken.node'"},
      {"null_choice", "null pointer as a choice of parameter 'mode'"},
      {"null_name", "null pointer as the name of an output of 'broken.node'"},
      {"null_summary", "null pointer as the summary of 'broken.node'"},
      {"role_not_utf8", "not UTF-8 as the role of 'broken.node'"},
      {"null_frames", "null pointer as the frames of input 'in' of 'broken.node'"},
      {"null_run", "null pointer as run() of 'broken.node'"},
      {"small_table", "the struct of the table has"},
      {"small_node", "rebuild the plugin against this host's plugin.h"},
      {"small_port", "the struct of number 1 of its inputs of 'broken.node'"},
      {"small_param", "the struct of number 1 of its parameters"},
      {"small_type", "the struct of number 1 of its types has 8 bytes"},
      {"schema_missing", "has no schema; make it with plumbline_add_artifacts()"},
      {"schema_garbage", "no binary FlatBuffers schema"},
      {"schema_cut", "schema"},
      {"schema_of_another_type", "has the schema of plumbline.Place/1"},
      {"fingerprint_wrong", "has the fingerprint 00000000, its schema gives"},
      {"fingerprint_of_port", "with the fingerprint 12345678, but brings plumbline.Place/1 with"},
      {"type_not_brought", "of the type plumbline.Place/1, which it does not bring"},
      {"kind_twice", "offers the node 'broken.node' twice"},
      {"kind_unwritable", "'broken node' as the kind of a node"},
      {"parameter_twice", "the parameter 'height' of 'broken.node' twice"},
      {"input_twice", "input 'in' of 'broken.node' twice"},
      {"cardinality_of_output", "with the cardinality 3"},
      {"cardinality_unknown", "with the cardinality 9"},
      {"each_twice", "2 inputs of 'broken.node' of which it runs once for each item"},
      {"parameter_kind_unknown", "of the kind 77"},
      {"default_out_of_bounds",
       "the default '2000' for parameter 'height' of 'broken.node', which is not within its bounds"},
      {"default_no_number", "the default 'three'"},
      {"default_no_choice",
       "the default 'triple' for parameter 'mode' of 'broken.node', which is not one of its choices"},
      {"bounds_reversed", "bounds that nothing is between"},
      {"bounds_nan", "bounds that nothing is between"},
      {"frame_mistyped",
       "the frame parameter 'fraem' of input 'in' of 'broken.node', which plumbline.Place/1 does not have — did you "
       "mean 'frame'?"},
      {"frame_unfinished", "binds the frame parameter 'frame'"},
      {"role_unknown", "did you mean 'pose_initialiser'?"},
      {"role_not_kept", "in the role 'registrar', but it has no input 'source'"},
      {"text_not_utf8", "not UTF-8"},
      {"note_differs", "says in its note that it is broken 0.1.0, and in its table sound 0.1.0"},
      {"wild_pointer", "signal 11"},
      {"another_table_each_time", "another table at the second call"},
      {"crashes_on_the_second_call", "dies while it is loaded"},
      {"exits_in_table", "ends the program while it is loaded (exit code 0)"},
      {"exits", "ends the program while it is loaded (exit code 0)"},
      {"aborts_in_table", "it printed: licence server not found"},
  };
  for (const auto& [name, words] : flaws) expect_refusal(name, words);
}

TEST_F(BrokenPlugin, TheGoodOneThatTheyAreMadeFromIsTaken) { EXPECT_EQ(refusal(fixture("no_flaw")), ""); }

TEST_F(BrokenPlugin, OneOfAnOlderMinorVersionIsTaken) {
  Registry registry;
  ASSERT_TRUE(registry.load(fixture("older_minor"))) << refusal(fixture("older_minor"));
  EXPECT_STREQ(registry.find("broken.node")->node->lacks, "");
}
TEST_F(BrokenPlugin, ADescriptionThatComesInPiecesIsReadWhole) { EXPECT_EQ(refusal(fixture("long_description")), ""); }

TEST_F(BrokenPlugin, WhatHangsIsKilledWhateverItIgnores) {
  setenv("PLUMBLINE_SCAN_SECONDS", "1", 1);
  for (const char* name : {"hangs", "hangs_and_closes", "stops_itself"})
    expect_refusal(name, "hangs while it is loaded");
  unsetenv("PLUMBLINE_SCAN_SECONDS");
}

/// It is looked at in a child, and what the child told is remembered: this process never loads it.
TEST_F(BrokenPlugin, OneThatCrashesOnTheSecondLoadIsNotLoadedToSeeWhatItOffers) {
  const std::string trace = (cache_.path() / "loaded").string();
  setenv("PLUMBLINE_TEST_SECOND_LOAD", trace.c_str(), 1);
  EXPECT_EQ(refusal(fixture("crashes_on_the_second_load")), "");
  EXPECT_TRUE(fs::exists(trace));
  EXPECT_EQ(refusal(fixture("crashes_on_the_second_load")), "");
  fs::remove_all(cache_.path() / "plumbline");  // nothing remembered: the next look is the second load
  EXPECT_NE(refusal(fixture("crashes_on_the_second_load")).find("dies while it is loaded"), std::string::npos);
  unsetenv("PLUMBLINE_TEST_SECOND_LOAD");
}

TEST_F(BrokenPlugin, ADescriptionThatWasDamagedIsMadeAnew) {
  EXPECT_EQ(refusal(PLUMBLINE_BROKEN_PLUGINS "/no_flaw.so"), "");
  for (const auto& entry : fs::directory_iterator(cache_.path() / "plumbline" / "plugins")) {
    std::string bytes = read_file(entry.path());
    for (size_t at = bytes.size() / 2; at < bytes.size(); at += 7) bytes[at] = static_cast<char>(~bytes[at]);
    std::ofstream(entry.path(), std::ios::binary) << bytes;
  }
  EXPECT_EQ(refusal(PLUMBLINE_BROKEN_PLUGINS "/no_flaw.so"), "");
}

std::string problems_of(const std::string& nodes, const std::vector<fs::path>& libraries) {
  Registry registry;
  for (const fs::path& library : libraries) registry.load(library);
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "p.yaml") << "plumbline: 1\nnodes:\n" << nodes;
  try {
    runtime::load_pipeline(folder.path() / "p.yaml", {}, registry);
  } catch (const runtime::InvalidPipeline& error) {
    return error.what();
  }
  return "";
}

/// Two plugins may be built from different schemas of one name. Both load; what must not be is that they are linked.
TEST_F(BrokenPlugin, PluginsThatDisagreeOnATypeCannotBeLinked) {
  const std::string nodes = "  mm: {use: fault.millimetres}\n  sum: {use: story.add, in: {a: mm.number}}\n";
  const std::string problem = problems_of(nodes, {PLUMBLINE_STORY_PLUGIN, fixture("other_unit")});
  EXPECT_NE(problem.find("plumbline.Number.value is in unit '1' here and 'mm' there"), std::string::npos) << problem;
  EXPECT_NE(problem.find("other_unit.so"), std::string::npos) << problem;
  EXPECT_NE(problem.find(":4:"), std::string::npos) << problem;
}

TEST_F(BrokenPlugin, WhoMissesANodeIsToldWhatWasRefused) {
  const std::string problem =
      problems_of("  a: {use: broken.node}\n  b: {use: broken.other}\n", {fixture("kind_twice")});
  EXPECT_NE(problem.find("there is no node 'broken.node'"), std::string::npos) << problem;
  EXPECT_NE(problem.find("kind_twice.so, which offers the node 'broken.node' twice"), std::string::npos) << problem;
}

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
  setenv("PLUMBLINE_SCAN_SECONDS", "3", 1);  // three of them hang
  auto registry =
      Registry::discover({fs::path(PLUMBLINE_STORY_PLUGIN).parent_path(), fs::path(PLUMBLINE_BROKEN_PLUGINS)});
  unsetenv("PLUMBLINE_SCAN_SECONDS");
  EXPECT_TRUE(registry.find("story.add"));
  EXPECT_GE(registry.refused().size(), 50u);
  for (const auto& refused : registry.refused()) EXPECT_NE(refused.problem, "") << refused.path;
}

}  // namespace test_broken_plugins
}  // namespace plumbline::test
