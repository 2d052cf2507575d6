// The contract against inputs that nobody thought of: random plugin tables, descriptions, manifests and pipelines. Each
// is refused with a sentence or taken, and what is taken holds what it promises. A few thousand of each always, a
// million together with PLUMBLINE_LONG.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "random_table.hpp"
#include "runtime/graph/graph.hpp"
#include "runtime/graph/parameters.hpp"
#include "runtime/plugins/executable_node.hpp"
#include "runtime/plugins/plugin_check.hpp"
#include "runtime/plugins/plugin_table.hpp"
#include "test_support.hpp"

namespace plumbline::test {
namespace test_contract {

using namespace runtime;
namespace fs = std::filesystem;

int trials() { return std::getenv("PLUMBLINE_LONG") ? 250000 : 1500; }

const Registry& registry() {
  static const Registry made = [] {
    Registry registry;
    if (!registry.load(PLUMBLINE_STORY_PLUGIN)) throw std::runtime_error(registry.refused().at(0).problem);
    return registry;
  }();
  return made;
}

const plumbline_plugin_table& sound_table() { return *registry().plugins().at(0)->table; }

/// Those of the runtime and that of the story's plugin.
const Roles& registry_roles() {
  static const Roles made = [] {
    Roles roles = Roles::builtin();
    roles.add(fs::path(PLUMBLINE_STORY_PLUGIN).parent_path() / "roles" / "source.yaml");
    return roles;
  }();
  return made;
}

/// What a person reads: neither a word nor a flood.
void expect_sentence(const std::string& text, uint64_t trial) {
  EXPECT_GT(text.size(), 8u) << trial;
  EXPECT_LT(text.size(), 4096u) << trial;
}

/// Deletes, doubles, swaps and inserts, most often what means something there.
std::string changed(std::string text, const std::vector<std::string>& words, Random& random) {
  for (size_t changes = 1 + below(random, 5); changes > 0; --changes) {
    const size_t at = below(random, text.size() + 1), length = std::min(below(random, 20), text.size() - at);
    switch (below(random, 6)) {
      case 0:
        text.erase(at, length);
        break;
      case 1:
        text.insert(at, text.substr(at, length));
        break;
      case 2:
        if (at < text.size()) text[at] = static_cast<char>(random());
        break;
      case 3: {
        const size_t line = text.find('\n', at), next = text.find('\n', std::min(line, text.size() - 1) + 1);
        if (line != std::string::npos && next != std::string::npos) text += text.substr(line + 1, next - line);
        break;
      }
      default:
        text.replace(at, below(random, 2) ? length : 0, words[below(random, words.size())]);
    }
  }
  return text;
}

TEST(FuzzContract, Tables) {
  int taken = 0;
  for (int trial = 0; trial < trials(); ++trial) {
    Random random(static_cast<uint64_t>(trial));
    RandomTable made(sound_table(), random);
    for (size_t changes = below(random, 4); changes > 0; --changes) made.change();
    const std::string problem = check_table(&made.table(), registry_roles());
    if (!problem.empty()) {
      expect_sentence(problem, static_cast<uint64_t>(trial));
      continue;
    }
    ++taken;
    const PluginTable copy(made.table());
    EXPECT_EQ(serialise(copy.table()), serialise(made.table())) << trial;
    EXPECT_EQ(check_table(&copy.table(), registry_roles()), "") << trial;
  }
  EXPECT_GT(taken, trials() / 10) << "most changes should be harmless or named, not all fatal";
}

/// What a scan remembered, damaged on the disk.
TEST(FuzzContract, Descriptions) {
  const std::string sound = serialise(sound_table());
  for (int trial = 0; trial < trials(); ++trial) {
    Random random(static_cast<uint64_t>(trial));
    std::string bytes = sound;
    for (size_t changes = 1 + below(random, 3); changes > 0; --changes)
      bytes[below(random, bytes.size())] = static_cast<char>(random());
    if (below(random, 4) == 0) bytes.resize(below(random, bytes.size()));
    try {
      const PluginTable copy(bytes);
      check_table(&copy.table(), registry_roles());
    } catch (const std::runtime_error& error) {
      expect_sentence(error.what(), static_cast<uint64_t>(trial));
    }
  }
}

TEST(FuzzContract, Manifests) {
  const TemporaryFolder folder;
  const std::string sound =
      "plumbline_node: 1\nkind: outside.add\nversion: 1\nsummary: Adds\nlicence: MIT\nrun: [/bin/sh, -c, 'exit 0']\n"
      "needs: []\nseed: false\ntime_limit: 5 min\nmemory_limit: 2GiB\n"
      "inputs: {number: {type: plumbline.Number/1, cardinality: each, doc: a number}}\n"
      "outputs: {number: {type: plumbline.Number/1, frames: '', doc: the sum}}\n"
      "parameters:\n  offset: {kind: number, default: 1, unit: m, minimum: 0, maximum: 100, doc: added}\n"
      "  which: {kind: text, list: true, default: [a, b], choices: [a, b, c], doc: which}\n";
  const std::vector<std::string> words = {"[",
                                          "]",
                                          "{",
                                          "}",
                                          ": ",
                                          "&a ",
                                          "*a",
                                          "!!binary ",
                                          "~",
                                          "- ",
                                          "\n",
                                          "\t",
                                          "\"",
                                          "'",
                                          "<<: *a",
                                          "#",
                                          "kind",
                                          "text",
                                          "list",
                                          "-1",
                                          ".nan",
                                          ".inf",
                                          "1e999",
                                          "? ",
                                          "| ",
                                          "\xff",
                                          "/bin",
                                          "..",
                                          "role: detector\n",
                                          "true"};
  const auto type_of = [](const std::string& name) { return registry().type(name); };
  int taken = 0;
  for (int trial = 0; trial < trials(); ++trial) {
    Random random(static_cast<uint64_t>(trial));
    const fs::path file = folder.path() / "x.node.yaml";
    std::ofstream(file) << (trial ? changed(sound, words, random) : sound);
    try {
      const auto node = read_manifest(file, type_of);
      taken += check_table(&node->table->table(), registry_roles()).empty();
    } catch (const std::runtime_error& error) {
      expect_sentence(error.what(), static_cast<uint64_t>(trial));
    }
  }
  EXPECT_GT(taken, 0);
}

/// What a linked graph promises: sources before who takes from them, every needed input there, every parameter.
void expect_sound(const Graph& graph, int trial) {
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    const GraphNode& node = graph.nodes[i];
    ASSERT_NE(node.kind.node, nullptr) << trial;
    for (const auto& [port, source] : node.inputs) {
      EXPECT_LT(source.node, i) << trial;
      ASSERT_NE(node.kind.input(port), nullptr) << trial;
      ASSERT_NE(graph.nodes[source.node].kind.output(source.port), nullptr) << trial;
    }
    for (uint32_t k = 0; k < node.kind.node->input_count; ++k)
      EXPECT_TRUE(node.kind.node->inputs[k]->cardinality == PLUMBLINE_OPTIONAL ||
                  node.inputs.count(node.kind.node->inputs[k]->name))
          << trial;
    EXPECT_EQ(node.parameters.size(), node.kind.node->param_count) << trial;
    for (const auto& [name, value] : node.parameters) EXPECT_EQ(value.find("${"), std::string::npos) << trial;
  }
  for (const auto& output : graph.outputs) EXPECT_LT(output.from.node, graph.nodes.size()) << trial;
}

TEST(FuzzContract, Pipelines) {
  const TemporaryFolder folder;
  const std::string sound =
      "plumbline: 1\nvars: {seed: 1, k: \"${j}\", j: 2}\nnodes:\n"
      "  a: {use: story.constant, with: {value: \"${k}\"}}\n"
      "  b: {use: story.add, in: {a: a.number}, with: {offset: 1, mode: plain}, isolate: process, time_limit: 5 s}\n"
      "  s: {use: story.series}\n  q: {use: story.square, in: {number: s.numbers}}\n"
      "  t: {use: story.sum, in: {numbers: q.square}}\n  f: {use: story.folder}\n"
      "outputs: {b.json: b.sum, dir/f: f.folder}\n";
  std::ofstream(folder.path() / "part.yaml") << "plumbline: 1\nvars: {j: 5}\nnodes:\n  a: {with: {value: 7}}\n";
  const std::vector<std::string> words = {"[",
                                          "]",
                                          "{",
                                          "}",
                                          ": ",
                                          ", ",
                                          "&a ",
                                          "*a",
                                          "!!binary ",
                                          "~",
                                          "- ",
                                          "\n",
                                          "\t",
                                          "\"",
                                          "'",
                                          "<<: *a",
                                          "#",
                                          "${",
                                          "${k}",
                                          "${nothing}",
                                          "}",
                                          "a.number",
                                          "b.sum",
                                          "t.sum",
                                          "use: ",
                                          "in: ",
                                          "with: ",
                                          "vars: ",
                                          "nodes:\n",
                                          "include: part.yaml\n",
                                          "include: [p.yaml, part.yaml]\n",
                                          "\xff",
                                          "\xc3\xa4",
                                          "story.add",
                                          "story.sum",
                                          ".nan",
                                          "1e999",
                                          "0x1f",
                                          "-1",
                                          "outputs: {../x: a.number}\n",
                                          "memory_limit: 1k",
                                          "isolate: no",
                                          "s: {use: story.add, in: {a: t.sum}}\n"};
  const std::vector<std::string> overrides = {"k=3",
                                              "j=${k}",
                                              "a.use=story.series",
                                              "b.in.a=t.sum",
                                              "b.with.mode=double",
                                              "a.with.value=",
                                              "b.time_limit=1",
                                              "x.y.z=1",
                                              "=",
                                              "b.in.a=b.sum",
                                              "a.with.x=[1,2",
                                              "seed=-1",
                                              "b.isolate=no",
                                              "seed=99999999999999999999"};
  int taken = 0;
  for (int trial = 0; trial < trials(); ++trial) {
    Random random(static_cast<uint64_t>(trial));
    const fs::path file = folder.path() / "p.yaml";
    std::ofstream(file) << (trial ? changed(sound, words, random) : sound);
    std::vector<std::string> given;
    for (size_t i = trial ? below(random, 3) : 0; i > 0; --i)
      given.push_back(overrides[below(random, overrides.size())]);
    try {
      expect_sound(load_pipeline(file, given, registry()), trial);
      ++taken;
    } catch (const InvalidPipeline& error) {
      for (const Problem& problem : error.problems()) expect_sentence(problem.message, static_cast<uint64_t>(trial));
    }
  }
  EXPECT_GT(taken, 0);
}

}  // namespace test_contract
}  // namespace plumbline::test
