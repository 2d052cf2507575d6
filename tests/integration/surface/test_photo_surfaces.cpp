// site_surfaces.yaml and photo_surfaces.yaml as a whole, on the folder of a small simulated site with rendered
// photographs.

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <sstream>
#include <vector>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_photo_surfaces {

namespace fs = std::filesystem;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// The folder, made once.
class PhotoSurfaces : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    made = std::make_unique<Program>(PLUMBLINE_PLUGIN_FOLDER);
    made->write(
        "make.yaml",
        "plumbline: 1\nvars: {seed: 2}\nnodes:\n  site: {use: simulate.campaign, with: {floors: 1, columns: 3, camera: "
        "quick_6mp, images_per_floor: 4}}\noutputs: {site: site.folder}\n");
    const Answer answer = (*made)({"run", "make.yaml", "--out", "made"});
    ASSERT_EQ(answer.code, 0) << answer.err;
  }
  static void TearDownTestSuite() { made.reset(); }
  static Answer run(const std::string& pipeline, const std::string& out, std::vector<std::string> more = {}) {
    more.insert(more.begin(),
                {"run", std::string(source_dir()) + "/pipelines/" + pipeline, "folder=made/site", "--out", out});
    return (*made)(more);
  }
  static std::string file(const std::string& name) { return read_file(made->work() / name); }

  inline static std::unique_ptr<Program> made;
};

/// The simulator paints a wall with nothing on it between the tags: what nobody can measure is not judged, everywhere.
TEST_F(PhotoSurfaces, WhatASiteAsksForAndNobodyCanMeasureWithholdsReadyToInstall) {
  const Answer plain = run("site_campaign.yaml", "anchors");
  ASSERT_EQ(plain.code, 0) << plain.err;
  const Answer answer = run("site_surfaces.yaml", "site");
  EXPECT_EQ(answer.code, 3) << answer.err;
  for (const char* name : {"panels.csv", "joints.csv", "surface_verdicts.csv", "as_built.ifc", "issues.bcf",
                           "report.html", "summary.txt", "metrics.xml"})
    EXPECT_TRUE(fs::exists(made->work() / "site" / name)) << name;
  EXPECT_FALSE(has(file("site/report.html"), "Ready to install"));
  EXPECT_TRUE(has(file("site/report.html"), "Surfaces and joints"));
  EXPECT_TRUE(has(file("site/summary.txt"), "NOT JUDGED: surfaces, ")) << file("site/summary.txt");
  EXPECT_TRUE(has(file("site/metrics.xml"), "<testsuite name=\"surfaces\"")) << file("site/metrics.xml");
  EXPECT_TRUE(has(file("site/as_built.ifc"), "'SurfacesNotJudged'"));
  EXPECT_TRUE(has(file("site/as_built.ifc"), "ASB_PanelSurface"));
  EXPECT_TRUE(has(file("site/surface_verdicts.csv"), "NOT JUDGED"));
  EXPECT_FALSE(has(file("site/surface_verdicts.csv"), "PASS")) << "nothing smooth is invented on a plain wall";
}

/// Rows of a table by their first cell, cells by the header's names.
std::map<std::string, std::map<std::string, std::string>> table_of(const std::string& text) {
  std::map<std::string, std::map<std::string, std::string>> rows;
  std::istringstream lines(text);
  std::vector<std::string> header;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (header.empty()) {
      header = cells;
      continue;
    }
    for (size_t c = 1; c < std::min(cells.size(), header.size()); ++c) rows[cells[0]][header[c]] = cells[c];
  }
  return rows;
}

/// From the folder of a site to its as-built model: tags, survey, orientations with their joint covariance, depth,
/// panels, joints, verdicts. Each planted quantity lies within what is stated of it.
TEST_F(PhotoSurfaces, PanelsThatHangAreMeasuredFromTheCampaignToTheModel) {
  made->write(
      "hung.yaml",
      "plumbline: 1\nvars: {seed: 3}\nnodes:\n  site: {use: simulate.campaign, with: {floors: 1, columns: 3, camera: "
      "quick_6mp, images_per_floor: 6, panels: 1, panel_sigma: 0.003}}\noutputs: {site: site.folder, truth: "
      "site.truth}\n");
  const Answer hung = (*made)({"run", "hung.yaml", "--out", "hung"});
  ASSERT_EQ(hung.code, 0) << hung.err;
  const Answer answer = (*made)({"run", std::string(source_dir()) + "/pipelines/site_surfaces.yaml", "folder=hung/site",
                                 "--out", "surfaces", "rule=*: offset=15mm, step=15mm, narrowest=6mm, widest=14mm"});
  EXPECT_LE(answer.code, 3) << answer.err;
  const auto planted = table_of(file("hung/truth/panels.csv")), found = table_of(file("surfaces/panels.csv"));
  ASSERT_EQ(planted.size(), 2U);
  const std::pair<const char*, const char*> quantities[] = {{"offset_mm", "offset_sigma_mm"},
                                                            {"tilt_right_mm_per_m", "tilt_right_sigma"},
                                                            {"tilt_up_mm_per_m", "tilt_up_sigma"},
                                                            {"bow_across_mm", "bow_across_sigma"},
                                                            {"bow_up_mm", "bow_up_sigma"}};
  double squares = 0;
  for (const auto& [name, truth] : planted) {
    ASSERT_TRUE(found.contains(name)) << answer.err;
    const auto& panel = found.at(name);
    ASSERT_EQ(panel.at("not_measured"), "") << name;
    for (const auto& [quantity, sigma] : quantities) {
      const double error = std::stod(panel.at(quantity)) - std::stod(truth.at(quantity));
      std::printf("%s %s: %s, error %.3f, stated %s\n", name.c_str(), quantity, truth.at(quantity).c_str(), error,
                  panel.at(sigma).c_str());
      EXPECT_LT(std::abs(error), 4 * std::stod(panel.at(sigma)) + 0.02) << name << " " << quantity;
      squares += std::pow(error / std::stod(panel.at(sigma)), 2) / 10;
    }
    EXPECT_LT(std::stod(panel.at("offset_sigma_mm")), 1);
  }
  EXPECT_LT(squares, 4) << "of ten quantities";
  EXPECT_TRUE(has(file("surfaces/as_built.ifc"), "ASB_PanelSurface"));
  EXPECT_TRUE(has(file("surfaces/as_built.ifc"), "ASB_Joint"));
  const std::string joints = file("surfaces/joints.csv");
  EXPECT_TRUE(has(joints, "F01-P01,F01-P02,up,,10.00,")) << joints;
}

TEST_F(PhotoSurfaces, ASurfaceThatNobodyCanMeasureIsNotUsed) {
  const Answer answer = run("photo_surfaces.yaml", "photo");
  EXPECT_EQ(answer.code, 3) << "plates and the wall behind them are no one surface" << answer.err;
  EXPECT_TRUE(has(answer.err, "plane of the points is not measured")) << answer.err;
  EXPECT_TRUE(fs::exists(made->work() / "photo/panels.csv"));
}

TEST_F(PhotoSurfaces, WithoutJointCovarianceItSaysWhatToSet) {
  const Answer answer = run("site_surfaces.yaml", "without", {"block.with.joint_orientations=false"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(has(answer.err, "joint_orientations: true")) << answer.err;
}

/// Photographs of two panels, made once; then only what measures them runs.
class StoppedSurfaces : public testing::Test {
 protected:
  void SetUp() override {
    program.write(
        "site.yaml",
        "plumbline: 1\nnodes:\n"
        "  site: {use: simulate.facade, with: {columns: 2, rows: 1, photographs: 4, width: 1200, height: 800}}\n"
        "outputs: {truth.csv: site.truth}\n");
    program.write(
        "depth.yaml",
        "plumbline: 1\ninclude: site.yaml\nvars: {kind: dense.plane_sweep}\nnodes:\n"
        "  depth: {use: \"${kind}\", in: {images: site.images, poses: site.poses, camera: site.camera, design: "
        "site.design}}\n  panels: {use: surface.panels, in: {surface: depth.surface}}\n"
        "outputs: {panels.csv: panels.table}\n");
    ASSERT_EQ(program({"run", "site.yaml", "--out", "site"}).code, 0);
  }
  std::vector<std::string> run(const std::string& kind) const {
    return {"run", "depth.yaml", "kind=" + kind, "--out", kind};
  }
  std::vector<fs::path> kept() const {
    std::vector<fs::path> tiles;
    std::error_code none;
    for (fs::recursive_directory_iterator entry(program.folder.path() / "store" / "partial", none), end;
         !none && entry != end; entry.increment(none))
      if (entry->path().extension() == ".tile") tiles.push_back(entry->path());
    return tiles;
  }
  Program program{PLUMBLINE_PLUGIN_FOLDER};
};

TEST_F(StoppedSurfaces, AKilledRunGoesOnWithThePartsThatAreMissing) {
  const pid_t first = program.start(run("dense.plane_sweep"));
  while (kept().empty() && waitpid(first, nullptr, WNOHANG) == 0) usleep(1000);
  kill(first, SIGKILL);
  program.finish(first);
  const std::vector<fs::path> tiles = kept();
  ASSERT_FALSE(tiles.empty());
  // One that is not whole, as after a power cut, is measured again.
  fs::resize_file(tiles.front(), fs::file_size(tiles.front()) / 2);
  const Answer second = program(run("dense.plane_sweep"));
  EXPECT_LE(second.code, 3) << second.err;
  const std::string record = read_file(program.work() / "dense.plane_sweep/run.jsonl");
  EXPECT_EQ(has(record, "parts were there from a run that was stopped"), tiles.size() > 1) << tiles.size();
  EXPECT_TRUE(kept().empty()) << "what is done is not kept twice";
  const std::string resumed = read_file(program.work() / "dense.plane_sweep/panels.csv");
  fs::remove_all(program.folder.path() / "store");
  program(run("dense.plane_sweep"));
  EXPECT_EQ(read_file(program.work() / "dense.plane_sweep/panels.csv"), resumed) << "the same bits as of one run";
}

TEST_F(StoppedSurfaces, AnInterruptEndsItAndKeepsWhatIsDone) {
  const pid_t first = program.start(run("dense.plane_sweep"));
  while (kept().empty() && waitpid(first, nullptr, WNOHANG) == 0) usleep(1000);
  kill(first, SIGINT);
  EXPECT_EQ(program.finish(first).code, 130);
  EXPECT_FALSE(kept().empty());
  EXPECT_FALSE(fs::exists(program.work() / "dense.plane_sweep/panels.csv"));
}

}  // namespace test_photo_surfaces
}  // namespace plumbline::test
