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

/// The longest waits that users had were here: half a minute after Ctrl-C in a block of tags. What takes more than a
/// second of larger inputs must ask; the others of these pipelines may.
TEST(Stopping, NodesOfPhotographsSurfacesAndPlansDo) {
  const std::set<std::string> take_long{"adjust.marker_board", "report.image_block", "simulate.facade",
                                        "dense.plane_sweep",   "surface.panels",     "surface.joints",
                                        "surface.orthophoto",  "report.surfaces",    "plan.images"};
  std::set<std::string> seen;
  const auto examine = [&](const std::string& kind, const Situation& situation) {
    if (!seen.insert(kind).second) return;
    EXPECT_EQ(stopping_at_fault(situation, take_long.count(kind) ? MayTakeLong::yes : MayTakeLong::no), "") << kind;
  };
  NodeByNode::run("marker_board",
                  {"folder=" + std::string(source_dir()) + "/examples/board", "detector=aruco", "family=DICT_6X6_1000",
                   "tag_size=0.0375"},
                  examine);
  std::vector<std::string> facade;
  for (const char* const one : {"columns=2", "rows=2", "photographs=6", "width=760", "height=620", "panel_width=0.5",
                                "panel_height=0.4", "distance=3"})
    facade.push_back(std::string("site.with.") + one);
  NodeByNode::run("facade_surfaces", facade, examine);
  NodeByNode::run("plan_images", {"floors=1"}, examine);
  for (const std::string& kind : take_long) EXPECT_TRUE(seen.count(kind)) << kind << " is in none of the pipelines";
}

/// Of a survey alone; what joins readings and photographs, boards, series of epochs, scans and states is stopped beside
/// its other tests (`CanBeStopped`).
TEST(Stopping, NodesOfASurveyDo) {
  const std::set<std::string> take_long{"survey.adjust", "survey.tables", "report.survey"};
  std::set<std::string> seen;
  const auto examine = [&](const std::string& kind, const Situation& situation) {
    if (!seen.insert(kind).second) return;
    EXPECT_EQ(stopping_at_fault(situation, take_long.count(kind) ? MayTakeLong::yes : MayTakeLong::no), "") << kind;
  };
  NodeByNode::run("survey_network", {"file=" + std::string(source_dir()) + "/docs/examples/before.csv"}, examine);
  for (const std::string& kind : take_long) EXPECT_TRUE(seen.count(kind)) << kind << " is in none of the pipelines";
}

}  // namespace stopping_tests
}  // namespace plumbline::test
