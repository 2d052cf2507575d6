// The photographs of what is not in order: which are taken, and where the marker and the design are drawn.
#include <gtest/gtest.h>

#include <fstream>

#include "geometry/camera.hpp"
#include "photo/images/jpeg_writer.hpp"
#include "show/report/anchor_photographs.hpp"
#include "test_support.hpp"

namespace plumbline::report {
namespace test_anchor_photographs {

constexpr int kWidth = 900, kHeight = 600;

/// A grey photograph with a bright square of `side` pixels about (x, y).
void write_photograph(const std::filesystem::path& path, int x, int y, int side) {
  GreyImage image{kWidth, kHeight, std::vector<std::uint8_t>(kWidth * kHeight, 60)};
  for (int row = y - side / 2; row < y + side / 2; ++row)
    for (int column = x - side / 2; column < x + side / 2; ++column) image.pixels[row * kWidth + column] = 220;
  std::ofstream(path, std::ios::binary) << grey_jpeg(image, 95);
}

ImageTagsT seen(const std::string& path, int id, double x, double y, double side) {
  ImageTagsT image;
  image.path = path, image.width = kWidth, image.height = kHeight;
  auto tag = std::make_unique<TagT>();
  tag->family = "tag36h11", tag->id = id;
  const double h = 0.5 * side;
  tag->corners = {{x - h, y + h}, {x + h, y + h}, {x + h, y - h}, {x - h, y - h}};
  image.tags.push_back(std::move(tag));
  return image;
}

std::unique_ptr<AnchorDeviationT> anchor(const std::string& id, ToleranceVerdict verdict) {
  auto made = std::make_unique<AnchorDeviationT>();
  made->id = id, made->verdict = verdict;
  made->design = {0.01, 0.02, 0}, made->as_built = {0, 0, 0}, made->deviation = made->as_built - made->design;
  return made;
}

struct Site {
  test::TemporaryFolder folder;
  DeviationT deviation;
  PhotographSources sources;

  Site() {
    write_photograph(folder.path() / "near.jpg", 450, 300, 100);
    write_photograph(folder.path() / "far.jpg", 300, 200, 40);
    write_photograph(folder.path() / "edge.jpg", 880, 590, 20);
    for (const char* name : {"near.jpg", "far.jpg", "edge.jpg"}) sources.files[name] = (folder.path() / name).string();
    sources.tags = {seen("far.jpg", 1, 299.5, 199.5, 40), seen("near.jpg", 1, 449.5, 299.5, 100),
                    seen("edge.jpg", 1, 879.5, 589.5, 20)};
    auto plate = std::make_unique<PlateT>();
    plate->anchor = "A", plate->tag_family = "tag36h11", plate->tag_id = 1;
    sources.plates.plates.push_back(std::move(plate));
    deviation.anchors.push_back(anchor("A", ToleranceVerdict::fail));
    deviation.anchors.push_back(anchor("B", ToleranceVerdict::undecided));
    deviation.anchors.push_back(anchor("C", ToleranceVerdict::pass));
  }

  /// One pinhole, 1000 px, 2 m before the plane z = 0 on which the anchors are; in `path`.
  void add_pose(const std::string& path, const Eigen::Vector3d& centre) {
    if (!sources.poses) {
      sources.poses.emplace();
      sources.camera.emplace();
      sources.camera->id = "c", sources.camera->width = kWidth, sources.camera->height = kHeight;
      sources.camera->parameters = {1000, 1000, 449.5, 299.5, 0, 0, 0, 0, 0};
    }
    auto pose = std::make_unique<PoseT>();
    pose->path = path, pose->cam_from_world.translation = -centre;
    sources.poses->poses.push_back(std::move(pose));
  }
};

TEST(AnchorPhotographs, TheLargestMarkersOfWhatIsNotInOrder) {
  Site site;
  const AnchorPhotographs found = photographs_of(site.deviation, site.sources);
  ASSERT_EQ(found.parts.size(), 2u) << "the best two of the worst";
  EXPECT_EQ(found.parts[0].photograph, "near.jpg");
  EXPECT_EQ(found.parts[1].photograph, "far.jpg");
  EXPECT_EQ(found.not_shown, std::vector<std::string>{"B"}) << "C passes";
  EXPECT_FALSE(found.parts[0].design) << "without poses";
  EXPECT_EQ(photographs_of(site.deviation, site.sources).parts[0].jpeg, found.parts[0].jpeg);
}

/// Worked out by hand: 10 mm at 2 m and 1000 px are 5 px.
TEST(AnchorPhotographs, TheDesignStandsWhereTheCameraSeesIt) {
  Site site;
  site.add_pose("near.jpg", {0, 0, -2});
  const AnchorPhotographs found = photographs_of(site.deviation, site.sources);
  const AnchorPhotograph& part = found.parts.at(0);
  ASSERT_TRUE(part.design && part.as_built);
  EXPECT_NEAR((*part.design - *part.as_built - Eigen::Vector2d(5, 10)).norm(), 0, 1e-9);
  const Eigen::Vector2d middle = 0.25 * (part.outline[0] + part.outline[1] + part.outline[2] + part.outline[3]);
  EXPECT_NEAR((middle - *part.as_built).norm(), 0, 1e-9);
  // The marker is where it is drawn: bright inside its outline, dark outside.
  test::TemporaryFolder folder;
  std::ofstream(folder.path() / "part.jpg", std::ios::binary) << part.jpeg;
  const GreyImage image = read_grey_image(folder.path() / "part.jpg");
  const double scale = image.width / part.width;
  const auto grey = [&](const Eigen::Vector2d& at) {
    const auto pixel = [&](double v) { return static_cast<std::size_t>(std::floor(scale * v)); };
    return image.pixels[pixel(at.y()) * static_cast<std::size_t>(image.width) + pixel(at.x())];
  };
  for (const Eigen::Vector2d& corner : part.outline) {
    EXPECT_GT(grey(corner + 4 * (middle - corner).normalized()), 150);
    EXPECT_LT(grey(corner - 4 * (middle - corner).normalized()), 130);
  }
  EXPECT_FALSE(found.parts.at(1).design) << "far.jpg has no pose";
}

TEST(AnchorPhotographs, WhatIsNotThereOrDamagedIsSaid) {
  Site site;
  site.sources.files.erase("near.jpg");
  std::ofstream(site.folder.path() / "far.jpg", std::ios::binary) << "no photograph";
  const AnchorPhotographs found = photographs_of(site.deviation, site.sources);
  ASSERT_EQ(found.parts.size(), 1u);
  EXPECT_EQ(found.parts[0].photograph, "edge.jpg");
  EXPECT_LT(found.parts[0].width, 100) << "cut off at the border";
  ASSERT_EQ(found.not_read.count("far.jpg"), 1u);
  EXPECT_TRUE(found.not_cut.empty()) << "edge.jpg shows A";
  site.sources.files.erase("edge.jpg");
  EXPECT_EQ(photographs_of(site.deviation, site.sources).not_cut.at("A"), "far.jpg cannot be read");
  site.sources.files.clear();
  EXPECT_EQ(photographs_of(site.deviation, site.sources).not_shown, (std::vector<std::string>{"A", "B"}));
}

/// A marker that was detected in a larger copy of the photograph lies outside of this one.
TEST(AnchorPhotographs, AnAnchorThatCannotBeCutOutIsListedWithTheReason) {
  Site site;
  site.sources.tags = {seen("near.jpg", 1, 1800, 1300, 100)};
  const AnchorPhotographs found = photographs_of(site.deviation, site.sources);
  EXPECT_TRUE(found.parts.empty());
  ASSERT_EQ(found.not_cut.size(), 1u);
  EXPECT_EQ(found.not_cut.at("A"), "near.jpg has 900 × 600 pixels, and its marker was detected outside of them");
}

}  // namespace test_anchor_photographs
}  // namespace plumbline::report
