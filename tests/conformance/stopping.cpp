// Ctrl-C in shipped pipelines, node by node, each in a harness, so that it can be stopped at places that do not depend
// on how fast the machine is: every kind that asks whether it is to stop must then stop. Kinds of a role are stopped in
// its kit, too. What never asks is done in a moment: the list below is whole, and one that is added to a pipeline has
// to ask or to be put here by somebody who has looked at it.
#include "stopping.hpp"

#include <set>

#include "node_by_node.hpp"

namespace plumbline::test {
namespace stopping_tests {

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
