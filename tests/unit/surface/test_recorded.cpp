// What the nodes of surfaces find on one small simulated facade, photographed and scanned, as it was when it was looked
// at (recorded/NAME.txt), to three digits. Whether it is right the other tests say; a line that is wrong shows here.
#include "artifacts/camera.hpp"
#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/image.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/surface_points.hpp"
#include "artifacts/surfaces.hpp"
#include "node_harness.hpp"
#include "record.hpp"

namespace test_recorded {

using namespace plumbline;
using namespace plumbline::test;

/// Two by two panels, of which the last one has nothing on it that could be measured in photographs.
const NodeHarness& site() {
  static const NodeHarness* const made = [] {
    auto* node = new NodeHarness("simulate.facade");
    const std::pair<const char*, const char*> settings[] = {
        {"columns", "2"},  {"rows", "2"},          {"plain", "1"},          {"photographs", "6"}, {"width", "760"},
        {"height", "620"}, {"panel_width", "0.5"}, {"panel_height", "0.4"}, {"distance", "3"}};
    for (const auto& [name, value] : settings) node->set(name, value);
    node->run();
    return node;
  }();
  return *made;
}

NodeHarness of_photographs(const char* kind) {
  NodeHarness node(kind);
  for (size_t i = 0; i < site().output_count("images"); ++i)
    node.input<Image>("images", site().output<Image>("images", i));
  node.input<Poses>("poses", site().output<Poses>("poses"));
  node.input<Camera>("camera", site().output<Camera>("camera"));
  return node;
}

NodeHarness panels_of(const NodeHarness& depth) {
  NodeHarness node("surface.panels");
  node.input<SurfacePoints>("surface", depth.output<SurfacePoints>("surface"));
  node.run();
  return node;
}

std::string table_of(const NodeHarness& node, const char* port) {
  const FileT file = node.output<File>(port);
  return std::string(file.content.begin(), file.content.end());
}

void expect_table(const std::string& name, const std::string& table) {
  expect_recorded("unit/surface/recorded/" + name + ".txt", with_few_digits(table, 3));
}

NodeHarness scanned() {
  NodeHarness scan("simulate.scan"), depth("dense.import");
  scan.input<Surfaces>("surfaces", site().output<Surfaces>("planted"));
  scan.set("pitch", "0.005"), scan.run();
  depth.input<Design>("design", site().output<Design>("design"));
  depth.input<File>("scan", scan.output<File>("scan"));
  depth.set("noise", "0.001"), depth.set("place_sigma", "0.0002"), depth.set("unit", "m");
  depth.run();
  return depth;
}

NodeHarness photographed(const char* kind) {
  NodeHarness depth = of_photographs(kind);
  depth.input<Design>("design", site().output<Design>("design"));
  depth.run();
  return depth;
}

/// Joints and pictures of measured panels, and what is said of both.
void expect_all_of(const std::string& name, const NodeHarness& panels) {
  NodeHarness joints = of_photographs("surface.joints"), pictures = of_photographs("surface.orthophoto"),
              judged("surface.judge");
  joints.input<Surfaces>("panels", panels.output<Surfaces>("surfaces"));
  joints.run();
  expect_table(name + "_joints", table_of(joints, "table"));
  pictures.input<Surfaces>("panels", panels.output<Surfaces>("surfaces"));
  pictures.run();
  expect_table(name + "_pictures", table_of(pictures, "seams"));
  judged.input<Surfaces>("surfaces", joints.output<Surfaces>("surfaces"));
  judged.input<Design>("design", site().output<Design>("design"));
  judged.set("rules", "*: flatness(0.3m)=2mm, bow=3mm, step=4mm, joint=3mm");
  judged.run();
  expect_table(name + "_judged", table_of(judged, "table"));
}

TEST(RecordedSurfaces, OfPhotographsAScanAndBoth) {
  const NodeHarness swept = photographed("dense.plane_sweep"), scan = scanned();
  const NodeHarness panels = panels_of(swept), of_scan = panels_of(scan);
  expect_table("sweep", table_of(panels, "table"));
  expect_all_of("sweep", panels);
  expect_table("sgm", table_of(panels_of(photographed("dense.sgm")), "table"));
  expect_table("scan", table_of(of_scan, "table"));
  NodeHarness joints("surface.scan_joints"), both("surface.fuse");
  joints.input<SurfacePoints>("points", scan.output<SurfacePoints>("surface"));
  joints.input<Surfaces>("panels", of_scan.output<Surfaces>("surfaces"));
  joints.run();
  expect_table("scan_joints", table_of(joints, "table"));
  for (const NodeHarness* one : {&swept, &scan})
    both.input<SurfacePoints>("surfaces", one->output<SurfacePoints>("surface"));
  both.run();
  expect_table("both", table_of(panels_of(both), "table"));
}

}  // namespace test_recorded
