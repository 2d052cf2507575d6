// site_surfaces.yaml and photo_surfaces.yaml as a whole, on the folder of a small simulated site with rendered
// photographs.

#include <memory>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace {

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

}  // namespace
}  // namespace plumbline::test
