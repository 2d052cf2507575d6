// A graph told in a few lines of YAML, run with the nodes of tests/fixtures/plugins/story.cpp in a store of its own:
//
//   Story story("a: {use: story.constant}\nb: {use: story.add, in: {a: a.number}}\n");
//   story.run();
//   EXPECT_EQ(story.executed(), "a b");
//   story.run({"b.with.offset=2"});
//   EXPECT_EQ(story.executed(), "b");
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "artifacts/number.hpp"
#include "runtime/graph/graph.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/record/record.hpp"
#include "runtime/run/executor.hpp"
#include "runtime/run/plan.hpp"
#include "store_record.hpp"
#include "test_support.hpp"

namespace plumbline::test {

inline const runtime::Registry& story_registry() {
  static const runtime::Registry registry = [] {
    runtime::Registry made;
    if (!made.load(PLUMBLINE_STORY_PLUGIN)) throw std::runtime_error(made.refused().at(0).problem);
    return made;
  }();
  return registry;
}

class Story {
 public:
  /// `nodes` are lines under "nodes:", without indent; `rest` stands after them.
  explicit Story(const std::string& nodes, const std::string& rest = "") { tell(nodes, rest); }

  /// Writes the pipeline anew.
  void tell(const std::string& nodes, const std::string& rest = "") {
    std::string text = "plumbline: 1\nvars: {seed: 1}\nnodes:\n  ";
    for (const char c : nodes) text += c == '\n' ? std::string("\n  ") : std::string(1, c);
    std::ofstream(pipeline()) << text << "\n" << rest;
  }

  const runtime::RunResult& run(const std::vector<std::string>& overrides = {}, int threads = 2, uint64_t memory = 0,
                                const std::atomic<bool>* cancel = nullptr) {
    runtime::Observer silent;
    // A store of its own for each run, as another process would have: nothing is remembered but what is on the disk.
    store = std::make_unique<runtime::Store>(folder.path() / "store");
    graph = load_pipeline(pipeline(), overrides, story_registry());
    runtime::RunOptions options{threads, memory, cancel};
    options.keep_memory = keep_memory;
    result = execute(graph, story_registry(), *store, options, silent);
    return result;
  }
  bool keep_memory = false;  ///< of run()
  std::vector<runtime::PlannedNode> plan(const std::vector<std::string>& overrides = {}) {
    store = std::make_unique<runtime::Store>(folder.path() / "store");
    graph = load_pipeline(pipeline(), overrides, story_registry());
    return runtime::plan(graph, *store);
  }

  const runtime::NodeResult& node(const std::string& name) const {
    for (size_t i = 0; i < graph.nodes.size(); ++i)
      if (graph.nodes[i].name == name) return result.nodes[i];
    throw std::runtime_error("no node " + name);
  }
  std::string status(const std::string& name) const { return to_text(node(name).status); }
  /// Names of the nodes with that status, in the graph's order.
  std::string with_status(runtime::NodeStatus status) const {
    std::string names;
    for (size_t i = 0; i < graph.nodes.size(); ++i)
      if (result.nodes[i].status == status) names += (names.empty() ? "" : " ") + graph.nodes[i].name;
    return names;
  }
  std::string executed() const { return with_status(runtime::NodeStatus::executed); }

  std::vector<double> values(const std::string& name, const std::string& port) const {
    std::vector<double> numbers;
    for (const std::string& hash : node(name).outputs.at(port))
      numbers.push_back(flatbuffers::GetRoot<Number>(store->get(hash).bytes().data)->value());
    return numbers;
  }
  double value(const std::string& name, const std::string& port) const { return values(name, port).at(0); }

  std::filesystem::path pipeline() const { return folder.path() / "story.yaml"; }
  std::filesystem::path blob(const std::string& hash) const {
    return folder.path() / "store" / "blobs" / hash.substr(0, 2) / hash;
  }
  /// The records of all runs, as JSON text.
  std::vector<std::filesystem::path> records() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path() / "store" / "runs"))
      if (entry.is_regular_file()) files.push_back(entry.path());
    return files;
  }
  /// Small outputs leave the records and become blobs, as large ones are.
  void move_contents_to_blobs() {
    for (const auto& file : records()) {
      auto record = stored_record(file);
      for (const auto& [port, hashes] : record.at("outputs").items())
        for (const std::string hash : hashes) {
          const auto bytes = store->get(hash).bytes();
          store->put(bytes.data, bytes.size);
        }
      record.erase("contents");
      store_record(file, record);
    }
  }

  TemporaryFolder folder;
  std::unique_ptr<runtime::Store> store;
  runtime::Graph graph;
  runtime::RunResult result;
};

/// Three nodes in a row and one aside: a -> b -> c, and d.
inline const std::string small_chain =
    "a: {use: story.constant, with: {value: 3}}\n"
    "b: {use: story.add, in: {a: a.number}, with: {offset: 1}}\n"
    "c: {use: story.add, in: {a: b.sum}, with: {offset: 10}}\n"
    "d: {use: story.constant, with: {value: 5}}";

}  // namespace plumbline::test
