// A pipeline without rounds, run node by node in harnesses, so that each node can be looked at with inputs that the
// ones before it made.
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "runtime/graph/graph.hpp"
#include "test_paths.hpp"

namespace plumbline::test {

/// `examine` gets each node's first run, ready to run, as often as it wants.
class NodeByNode {
 public:
  using Examine = std::function<void(const std::string& kind, const Situation&)>;

  static void run(const std::string& pipeline, const std::vector<std::string>& overrides, const Examine& examine) {
    const std::filesystem::path folder = std::filesystem::path(source_dir()) / "pipelines";
    NodeByNode run(runtime::load_pipeline(folder / (pipeline + ".yaml"), overrides, built_registry(), {folder}));
    for (const runtime::GraphNode& node : run.graph_.nodes) run.one(node, examine);
  }

 private:
  explicit NodeByNode(runtime::Graph graph) : graph_(std::move(graph)) {}

  void one(const runtime::GraphNode& node, const Examine& examine) {
    const size_t runs = node.maps ? items(node, node.each_port).size() : 1;
    if (runs > 0) examine(node.kind.node->kind, [&] { return prepared(node, 0); });
    std::deque<NodeHarness>& done = done_.emplace_back();  // folders of outputs live as long as what wrote them
    for (size_t i = 0; i < runs; ++i) done.push_back(prepared(node, i)), done.back().run();
  }

  std::vector<std::vector<uint8_t>> items(const runtime::GraphNode& node, const std::string& port) const {
    std::vector<std::vector<uint8_t>> all;
    const auto [begin, end] = node.inputs.equal_range(port);
    for (auto source = begin; source != end; ++source)
      for (const NodeHarness& from : done_.at(source->second.node))
        for (size_t k = 0; k < from.output_count(source->second.port); ++k)
          all.push_back(from.output_bytes(source->second.port, k));
    return all;
  }

  NodeHarness prepared(const runtime::GraphNode& node, size_t run) const {
    NodeHarness harness(node.kind.node->kind);
    for (const auto& [name, text] : node.parameters) harness.set(name, text);
    for (uint32_t p = 0; p < node.kind.node->input_count; ++p) {
      const plumbline_port& port = *node.kind.node->inputs[p];
      const auto all = items(node, port.name);
      for (size_t k = 0; k < all.size(); ++k)
        if (!node.maps || node.each_port != port.name || k == run) harness.input_bytes(port.name, port.type, all[k]);
    }
    return harness;
  }

  const runtime::Graph graph_;
  std::vector<std::deque<NodeHarness>> done_;  // by node, a harness a run
};

}  // namespace plumbline::test
