// Graphs of nodes that misbehave, run with workers, and nodes in Python beside a manifest.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>

#include "runtime/plugins/artifact_type.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/run/executor.hpp"
#include "test_support.hpp"

namespace plumbline::test {

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

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A manifest and a script beside it, in a folder of plugins.
inline fs::path write_node(const fs::path& folder, const std::string& script, const std::string& more = "") {
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

}  // namespace plumbline::test
