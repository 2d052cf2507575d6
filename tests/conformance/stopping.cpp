// Ctrl-C in shipped pipelines, node by node, each in a harness, so that it can be stopped at places that do not depend
// on how fast the machine is: every kind that asks whether it is to stop must then stop. Kinds of a role are stopped in
// its kit, too. What never asks is done in a moment: the list below is whole, and one that is added to a pipeline has
// to ask or to be put here by somebody who has looked at it.
#include "stopping.hpp"

#include <deque>
#include <set>

#include "runtime/graph/graph.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace stopping_tests {

using runtime::GraphNode;

/// A pipeline without rounds; `examine` gets each node's first run, ready to run, as often as it wants.
class NodeByNode {
 public:
  using Examine = std::function<void(const std::string& kind, const Situation&)>;

  static void run(const std::string& pipeline, const std::vector<std::string>& overrides, const Examine& examine) {
    const std::filesystem::path folder = std::filesystem::path(source_dir()) / "pipelines";
    NodeByNode run(runtime::load_pipeline(folder / (pipeline + ".yaml"), overrides, built_registry(), {folder}));
    for (const GraphNode& node : run.graph_.nodes) run.one(node, examine);
  }

 private:
  explicit NodeByNode(runtime::Graph graph) : graph_(std::move(graph)) {}

  void one(const GraphNode& node, const Examine& examine) {
    const size_t runs = node.maps ? items(node, node.each_port).size() : 1;
    if (runs > 0) examine(node.kind.node->kind, [&] { return prepared(node, 0); });
    std::deque<NodeHarness>& done = done_.emplace_back();  // folders of outputs live as long as what wrote them
    for (size_t i = 0; i < runs; ++i) done.push_back(prepared(node, i)), done.back().run();
  }

  std::vector<std::vector<uint8_t>> items(const GraphNode& node, const std::string& port) const {
    std::vector<std::vector<uint8_t>> all;
    const auto [begin, end] = node.inputs.equal_range(port);
    for (auto source = begin; source != end; ++source)
      for (const NodeHarness& from : done_.at(source->second.node))
        for (size_t k = 0; k < from.output_count(source->second.port); ++k)
          all.push_back(from.output_bytes(source->second.port, k));
    return all;
  }

  NodeHarness prepared(const GraphNode& node, size_t run) const {
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

TEST(Stopping, NodesOfShippedPipelinesStopWhereTheyAskOrAreDoneInAMoment) {
  const std::set<std::string> moments{"evaluate.epochs",    "evaluate.errors",   "bim.write_ids", "frames.graph",
                                      "frames.to_building", "read.truth",        "report.dxf",    "report.excel",
                                      "report.summary",     "report.photographs"};
  std::set<std::string> seen;
  const auto examine = [&](const std::string& kind, const Situation& situation) {
    if (!seen.insert(kind).second) return;
    EXPECT_EQ(stopping_at_fault(situation, moments.count(kind) ? MayTakeLong::no : MayTakeLong::yes), "") << kind;
  };
  NodeByNode::run("observations", {"floors=1", "survey=readings"}, examine);
  NodeByNode::run("full_height", {"floors=1", "columns=2", "camera=quick_6mp", "site.with.images_per_floor=4"},
                  examine);
  for (const std::string& kind : moments) EXPECT_TRUE(seen.count(kind)) << kind << " is in none of the pipelines";
}

}  // namespace stopping_tests
}  // namespace plumbline::test
