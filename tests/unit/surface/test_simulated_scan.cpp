// A facade of panels as it was planted, scanned, measured and held against what was planted: simulate.facade,
// simulate.scan, dense.import, surface.panels and evaluate.surfaces in a row.
#include <cmath>
#include <sstream>

#include "artifacts/camera.hpp"
#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/image.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/surface_points.hpp"
#include "artifacts/surfaces.hpp"
#include "node_harness.hpp"
#include "stopping.hpp"

namespace test_simulated_scan {

using namespace plumbline;
using namespace plumbline::test;

/// Three panels beside each other, the last one of glass; as few and as small photographs as there may be.
struct ScannedFacade {
  NodeHarness site{"simulate.facade"}, scan{"simulate.scan"}, depth{"dense.import"}, panels{"surface.panels"},
      errors{"evaluate.surfaces"};

  explicit ScannedFacade(std::uint64_t seed = 1, const char* facades = "1") {
    const std::pair<const char*, const char*> settings[] = {
        {"columns", "3"}, {"rows", "1"},     {"plain", "0"},         {"glass", "1"},         {"photographs", "2"},
        {"width", "200"}, {"height", "200"}, {"panel_width", "0.5"}, {"panel_height", "0.4"}};
    for (const auto& [name, value] : settings) site.set(name, value);
    site.set("facades", facades), site.seed(seed), site.run();
    scan.input<Surfaces>("surfaces", site.output<Surfaces>("planted"));
    scan.set("pitch", "0.005"), scan.seed(seed), scan.run();
    depth.input<Design>("design", site.output<Design>("design"));
    depth.input<File>("scan", scan.output<File>("scan"));
    depth.set("noise", "0.001"), depth.set("place_sigma", "0.0002"), depth.set("unit", "m");
  }
  void measure() {
    depth.run();
    panels.input<SurfacePoints>("surface", depth.output<SurfacePoints>("surface")), panels.run();
    errors.input<Surfaces>("surfaces", panels.output<Surfaces>("surfaces"));
    errors.input<Surfaces>("truth", site.output<Surfaces>("planted")), errors.run();
  }
  std::string refusal() {
    try {
      depth.run();
    } catch (const NodeFailed& error) {
      return error.what();
    }
    return "(read)";
  }
};

std::map<std::string, double> planted_figures(const NodeHarness& site, const std::string& panel) {
  const FileT table = site.output<File>("truth");
  std::istringstream lines(std::string(table.content.begin(), table.content.end()));
  std::string names, line, name, value;
  for (std::getline(lines, names); std::getline(lines, line);) {
    if (line.rfind(panel + ",", 0) != 0) continue;
    std::map<std::string, double> row;
    std::istringstream of_names(names), of_values(line);
    while (std::getline(of_names, name, ',') && std::getline(of_values, value, ','))
      if (name != "panel" && name != "skin") row[name] = std::stod(value);
    return row;
  }
  return {};
}

TEST(PlantedSurfaces, SayWhatTheTableSays) {
  const ScannedFacade facade;
  const SurfacesT planted = facade.site.output<Surfaces>("planted");
  ASSERT_EQ(planted.panels.size(), 3U);
  ASSERT_EQ(planted.joints.size(), 2U);
  EXPECT_EQ(planted.panels[0]->not_measured, "");
  EXPECT_EQ(planted.panels[2]->not_measured, "glass");
  const auto a = planted_figures(facade.site, "P01-01"), b = planted_figures(facade.site, "P01-02");
  const std::vector<double>& c = planted.panels[0]->coefficients;
  EXPECT_NEAR(1e3 * (c[0] + 2.0 / 3 * (c[3] + c[4])), a.at("offset_mm"), 1e-6);
  EXPECT_NEAR(1e3 * c[1] / (0.5 * a.at("width_m")), a.at("tilt_right_mm_per_m"), 1e-5);
  EXPECT_NEAR(1e3 * c[4], a.at("bow_up_mm"), 1e-6);
  const JointPlaceT& middle = *planted.joints[0]->places[planted.joints[0]->places.size() / 2];
  EXPECT_NEAR(middle.along, 0, 1e-12);
  EXPECT_NEAR(middle.width, b.at("u_m") - a.at("u_m") - 0.5 * (a.at("width_m") + b.at("width_m")), 1e-6);
  // Heights at the edges that face each other, by the formula of the table's figures, at the height of both middles.
  const auto height = [&](const std::map<std::string, double>& panel, double x) {
    const double y = 0.5 * (a.at("v_m") + b.at("v_m")) - panel.at("v_m");
    const double p = 2 * x / panel.at("width_m"), q = 2 * y / panel.at("height_m");
    return panel.at("offset_mm") + panel.at("tilt_right_mm_per_m") * x + panel.at("tilt_up_mm_per_m") * y +
           panel.at("bow_across_mm") * (1.0 / 3 - p * p) + panel.at("bow_up_mm") * (1.0 / 3 - q * q);
  };
  EXPECT_NEAR(1e3 * middle.step, height(b, -0.5 * b.at("width_m")) - height(a, 0.5 * a.at("width_m")), 1e-5);
}

TEST(SimulatedScan, IsMeasuredAsItWasPlantedWithinWhatIsStated) {
  ScannedFacade facade;
  facade.measure();
  EXPECT_EQ(facade.errors.metric("panels_wanted"), 2);
  EXPECT_EQ(facade.errors.metric("panels_missing"), 0);
  EXPECT_EQ(facade.errors.metric("panels_invented"), 0) << "a beam goes through glass";
  EXPECT_LT(facade.errors.metric("rmse_offset"), 6e-4) << "the scan's place is known to 0.2 mm";
  EXPECT_LT(facade.errors.metric("rmse_bow"), 2e-4);
  for (const char* of : {"offset", "tilt", "bow", "twist"}) {
    const double freedom = facade.errors.metric(std::string(of) + "_freedom");
    EXPECT_EQ(freedom, std::string(of) == "tilt" || std::string(of) == "bow" ? 4 : 2) << of;
    EXPECT_LT(facade.errors.metric(std::string(of) + "_nees"), 18.5) << of << ": one of a thousand of 4 is above";
  }
  const FileT table = facade.errors.output<File>("table");
  const std::string text(table.content.begin(), table.content.end());
  EXPECT_EQ(text.rfind("where,quantity,found_mm,true_mm,error_mm,sigma_mm\nP01-01,offset,", 0), 0U) << text;
}

/// The same over many scans, one after the other: what is stated holds on average.
TEST(SimulatedScan, SquaredErrorsOverWhatIsStatedAverageOne) {
  double place = 0, form = 0, freedom_of_place = 0, freedom_of_form = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    ScannedFacade facade(seed);
    facade.measure();
    place += facade.errors.metric("offset_nees"), freedom_of_place += facade.errors.metric("offset_freedom");
    for (const char* of : {"bow", "twist"})
      form += facade.errors.metric(std::string(of) + "_nees"),
          freedom_of_form += facade.errors.metric(std::string(of) + "_freedom");
  }
  // Chi-square of 24 and 72 degrees of freedom over them, 99.8 %.
  EXPECT_GT(place / freedom_of_place, 0.31);
  EXPECT_LT(place / freedom_of_place, 2.2);
  EXPECT_GT(form / freedom_of_form, 0.53);
  EXPECT_LT(form / freedom_of_form, 1.6);
}

TEST(SimulatedScan, CanBeStopped) {
  const ScannedFacade facade;
  EXPECT_EQ(stopping_at_fault([&] {
              NodeHarness scan("simulate.scan");
              scan.input<Surfaces>("surfaces", facade.site.output<Surfaces>("planted"));
              scan.set("pitch", "0.005");
              return scan;
            }),
            "");
}

TEST(SimulatedScan, GivesTheSameBytesTwice) {
  const ScannedFacade once, again;
  EXPECT_EQ(once.scan.output<File>("scan").sha256, again.scan.output<File>("scan").sha256);
}

/// Around a corner of the building: what the scan's place is off by acts in another direction there.
TEST(SimulatedScan, OfTwoFacadesIsMeasuredOnBoth) {
  ScannedFacade block(1, "2");
  block.measure();
  EXPECT_EQ(block.errors.metric("panels_wanted"), 5);
  EXPECT_EQ(block.errors.metric("panels_missing"), 0);
  EXPECT_LT(block.errors.metric("rmse_offset"), 6e-4) << "the scan's place is known to 0.2 mm";
  EXPECT_LT(block.errors.metric("offset_nees"), 20.5) << "one of a thousand of 5 is above";
}

TEST(ImportOfAReference, IsOneCloudAndNoMore) {
  ScannedFacade facade;
  facade.depth.set("file", "/somewhere/else.las");
  EXPECT_NE(facade.refusal().find("Take one of them away"), std::string::npos);
  NodeHarness none("dense.import");
  none.input<Design>("design", facade.site.output<Design>("design"));
  try {
    none.run();
    FAIL();
  } catch (const NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("set 'file' to its path, or connect 'scan'"), std::string::npos);
  }
  NodeHarness held("dense.import");
  FileT file;
  file.name = "scan.las", file.content = {'L', 'A', 'S', 'F'};
  held.input<Design>("design", facade.site.output<Design>("design")), held.input<File>("scan", file);
  EXPECT_THROW(held.run(), NodeFailed);
}

}  // namespace test_simulated_scan
