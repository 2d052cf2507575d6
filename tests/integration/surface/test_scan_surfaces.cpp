// scan_surfaces.yaml as a whole: a design as IFC, a simulated cloud of its panel, verdicts and exit codes.
#include <cmath>
#include <random>
#include <sstream>

#include "building/ifc/design.hpp"
#include "building/step/step.hpp"
#include "cloud_bytes.hpp"
#include "program.hpp"
#include "small_building.hpp"
#include "test_paths.hpp"
#include "unzipped.hpp"

namespace plumbline::test {
namespace test_scan_surfaces {

/// The building's one panel, 2.2 m wide, 1 m high and 20 mm thick, and a scanner that sees its southern side.
class ScanOfAPanel : public testing::Test {
 protected:
  void SetUp() override {
    const std::string ifc = small_building("IFC4");
    plumbline.write("design.ifc", ifc);
    for (const ifc::Element& element : ifc::read_design(step::File(ifc, "design.ifc"), {}).elements)
      if (element.name == "Panel 1") panel = element;
    ASSERT_TRUE(panel.has_box);
  }
  /// Its outer face, `out` before the design's, with a bow of 2 mm and 1 mm of noise; a wall 3 m behind it.
  std::vector<Eigen::Vector3d> points(double out) const {
    std::mt19937_64 random(2);
    std::normal_distribution<double> noise(0, 0.001);
    const Eigen::Vector3d size = panel.box_high - panel.box_low, low = panel.box_low;
    std::vector<Eigen::Vector3d> cloud;
    for (int i = 0; i < 220; ++i)
      for (int j = 0; j < 100; ++j) {
        const double u = (i + 0.5) / 220, v = (j + 0.5) / 100, x = 2 * u - 1;
        const double across = low.y() - (out + 0.002 * (1 - x * x) + noise(random));
        cloud.push_back(panel.project_from_element *
                        Eigen::Vector3d(low.x() + u * size.x(), across, low.z() + v * size.z()));
      }
    for (int i = 0; i < 2000; ++i)
      cloud.push_back(panel.project_from_element * Eigen::Vector3d(0.001 * i, 3.0, 0.5 + noise(random)));
    return cloud;
  }
  void write_scan(const std::vector<Eigen::Vector3d>& cloud, double scale = 1e-4) const {
    cloud_bytes::LasFile las;
    las.minor = 4, las.format = 6, las.scale = scale, las.offset = panel.project_from_element.translation;
    plumbline.write("scan.las", cloud_bytes::las_file(las, cloud));
  }
  Answer run(std::vector<std::string> more) const {
    more.insert(more.begin(), {"run", std::string(source_dir()) + "/pipelines/scan_surfaces.yaml", "scan=scan.las",
                               "design=design.ifc", "unit=m", "noise=0.001", "place_sigma=0.0005"});
    more.insert(more.end(), {"--out", "out"});
    return plumbline(more);
  }
  /// What the topics of the issues say.
  std::string topics() const {
    std::string text;
    for (const auto& [name, content] : unzipped(read_file(plumbline.work() / "out/issues.bcf")))
      if (name.find("markup.bcf") != std::string::npos) text += content;
    return text;
  }
  /// The panel's line of a table, by the names of its columns.
  std::map<std::string, std::string> row(const std::string& table) const {
    std::istringstream lines(read_file(plumbline.work() / "out" / table));
    std::string names, values, name, value;
    std::getline(lines, names), std::getline(lines, values);
    std::istringstream of_names(names), of_values(values);
    std::map<std::string, std::string> row;
    while (std::getline(of_names, name, ',')) std::getline(of_values, value, ','), row[name] = value;
    return row;
  }

  Program plumbline;
  ifc::Element panel;
};

TEST_F(ScanOfAPanel, IsMeasuredAndJudged) {
  write_scan(points(0.004));
  const Answer answer = run({"rule=*: flatness(1m)=8mm, bow=3mm"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  const auto panels = row("panels.csv");
  EXPECT_EQ(panels.at("panel"), "Panel 1") << "and not the curtain wall that it is the one part of";
  EXPECT_EQ(panels.at("not_measured"), "");
  EXPECT_NEAR(std::stod(panels.at("bow_across_mm")), 2, 0.1);
  // The plane of a bow lies two thirds of it before its edges.
  EXPECT_NEAR(std::stod(panels.at("offset_mm")), 4 + 2 * 2.0 / 3, 0.1);
  EXPECT_NEAR(std::stod(panels.at("offset_sigma_mm")), 0.5, 0.05);
  const std::string verdicts = read_file(plumbline.work() / "out/surface_verdicts.csv");
  EXPECT_NE(verdicts.find("Panel 1,,flatness(1m),PASS"), std::string::npos) << verdicts;
  EXPECT_NE(verdicts.find("Panel 1,,bow,PASS"), std::string::npos) << verdicts;
}

/// The verdicts of a scan stand where those of photographs do: in the as-built model, and as an issue where one fails.
TEST_F(ScanOfAPanel, IsInTheModelAndInTheIssues) {
  write_scan(points(0.004));
  EXPECT_EQ(run({"rule=*: flatness(1m)=8mm, bow=3mm", "measured=2026-05-12T10:30:00"}).code, 0);
  std::string model = read_file(plumbline.work() / "out/as_built.ifc");
  for (const char* part : {"ASB_PanelSurface", "'SurfacesPassed'", "laser scan", "2026-05-12T10:30:00"})
    EXPECT_NE(model.find(part), std::string::npos) << part;
  EXPECT_EQ(model.find("'AnchorsPassed'"), std::string::npos) << "nobody looked for anchors";
  const step::File read(model, "as_built.ifc");
  EXPECT_EQ(ifc::read_design(read, {}).elements.size(),
            ifc::read_design(step::File(small_building("IFC4"), "design.ifc"), {}).elements.size());
  EXPECT_EQ(topics(), "");
  EXPECT_EQ(run({"rule=*: bow=1mm"}).code, 0) << "judged, and out of tolerance";
  model = read_file(plumbline.work() / "out/as_built.ifc");
  EXPECT_NE(model.find("'SurfacesFailed',$,IFCINTEGER(1)"), std::string::npos)
      << read_file(plumbline.work() / "out/surface_verdicts.csv");
  EXPECT_NE(topics().find("Panel 1"), std::string::npos) << topics();
}

TEST_F(ScanOfAPanel, RulesWithoutAnAnswerEndWithExitCode3) {
  write_scan(points(0.004));
  for (const char* rule : {"rule=*: flatness(5m)=3mm", "rule=*: bow=3mm, step=2mm", "rule=storey=Roof: bow=3mm"}) {
    const Answer answer = run({rule});
    EXPECT_EQ(answer.code, 3) << rule << answer.err;
    EXPECT_NE(answer.err.find("not judged"), std::string::npos) << answer.err;
  }
}

TEST_F(ScanOfAPanel, TheBorderOfTheSearchMovesWithIt) {
  write_scan(points(0.055));
  EXPECT_EQ(run({"search=0.05"}).code, 3) << "what is asked for is not judged";
  EXPECT_NE(row("panels.csv").at("not_measured").find("at the border of the search"), std::string::npos);
  const Answer found = run({"search=0.2", "rule=*: bow=4mm"});
  EXPECT_NEAR(std::stod(row("panels.csv").at("offset_mm")), 55 + 2 * 2.0 / 3, 0.1);
  EXPECT_EQ(found.code, 3) << "so far before its place it may be a net";
  EXPECT_NE(read_file(plumbline.work() / "out/surface_verdicts.csv").find("before the design's face"),
            std::string::npos);
  EXPECT_NE(read_file(plumbline.work() / "out/surfaces.html").find("a net, a board or a scaffold"), std::string::npos);
  EXPECT_EQ(run({"search=0.2", "rule=*: bow=4mm", "verdicts.with.within=0.1"}).code, 0);
}

TEST_F(ScanOfAPanel, IsLeftOutIfTheScannerStoodBehindIt) {
  write_scan(points(0));
  const auto station = [&](double to) {
    const Eigen::Vector3d at = panel.project_from_element * Eigen::Vector3d(0, to, 0.5);
    return "depth.with.seen_from=[" + std::to_string(at.x()) + ", " + std::to_string(at.y()) + ", " +
           std::to_string(at.z()) + "]";
  };
  EXPECT_EQ(run({station(-8), "rule=*: bow=4mm"}).code, 0);
  const Answer behind = run({station(8)});
  EXPECT_EQ(behind.code, 1);
  EXPECT_NE(behind.err.find("see it from behind"), std::string::npos) << behind.err;
}

TEST_F(ScanOfAPanel, StandsInForPhotographsByOneWord) {
  write_scan(points(0));
  const std::string pipeline = std::string(source_dir()) + "/pipelines/facade_surfaces.yaml";
  const Answer swapped =
      plumbline({"validate", pipeline, "depth.use=dense.import", "depth.with.file=scan.las", "depth.with.pitch=~"});
  EXPECT_EQ(swapped.code, 0) << "photographs, orientations and cameras are connected, and it takes none: "
                             << swapped.err;
  const Answer unknown = plumbline({"validate", pipeline, "depth.use=dense.import", "depth.with.file=scan.las",
                                    "depth.with.pitch=~", "depth.in.scans=site.images"});
  EXPECT_EQ(unknown.code, 1) << "what no kind of the role takes is still refused";
  EXPECT_NE(unknown.err.find("has no input 'scans'"), std::string::npos) << unknown.err;
}

/// The bench's own pipeline: photographs and a scanner's cloud of the same facade, taken by whichever kind.
TEST_F(ScanOfAPanel, BothAreConnectedToOneDepth) {
  const std::string pipeline = std::string(source_dir()) + "/benchmarks/surfaces/facade_kinds.yaml";
  EXPECT_EQ(plumbline({"validate", pipeline}).code, 0);
  const Answer scanned = plumbline({"validate", pipeline, "depth.use=dense.import", "depth.with.pitch=~"});
  EXPECT_EQ(scanned.code, 0) << scanned.err;
}

/// One takes photographs, the other a scan: what they started from is the same facade.
TEST_F(ScanOfAPanel, KindsOfDepthAreComparedInABench) {
  const Answer answer = plumbline({"bench", std::string(source_dir()) + "/benchmarks/surfaces/depth_kinds.yaml",
                                   "--seeds", "1", "site.with.width=500", "site.with.height=340", "--out", "out"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  const std::string said = read_file(plumbline.work() / "out/bench.md");
  EXPECT_NE(said.find("3 finished, 0 failed"), std::string::npos) << said;
  EXPECT_EQ(said.find("did not get the same inputs"), std::string::npos) << said;
}

TEST_F(ScanOfAPanel, CoarseStepsAreRefused) {
  write_scan(points(0), 0.01);
  const Answer answer = run({});
  EXPECT_EQ(answer.code, 1);
  EXPECT_NE(answer.err.find("written in steps of 10 mm"), std::string::npos) << answer.err;
}

}  // namespace test_scan_surfaces
}  // namespace plumbline::test
