// The nodes around the detector, on files.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/tag_observations.hpp"
#include "node_harness.hpp"
#include "tag_rendering.hpp"

namespace plumbline {
namespace {

namespace fs = std::filesystem;
using test::write_png;
using testing::HasSubstr;

test::TagScene scene() {
  test::TagScene scene;
  scene.corners = test::square_corners({100.3, 99.1}, 80, 0.4);
  scene.noise = 1;
  return scene;
}

std::string failure_of(test::NodeHarness& node) {
  try {
    node.run();
  } catch (const test::NodeFailed& error) {
    return error.what();
  }
  return "";
}

TEST(DetectNodes, GoFromAFolderOfImagesToCollectedObservations) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder.path() / "floor 1");
  write_png(folder.path() / "floor 1" / "b.png", render(scene()));
  write_png(folder.path() / "a.PNG", render(scene()));
  std::ofstream(folder.path() / "notes.txt") << "not an image";

  test::NodeHarness read("read.images");
  read.set("folder", folder.path().string());
  read.set("camera", "left");
  read.run();
  ASSERT_EQ(read.output_count("images"), 2u);

  test::NodeHarness collect("detect.collect");
  for (size_t i = 0; i < 2; ++i) {
    const ImageT image = read.output<Image>("images", i);
    EXPECT_EQ(image.width, 200);
    EXPECT_EQ(image.sha256.size(), 64u);
    test::NodeHarness detect("detect.apriltag");
    detect.input<Image>("images", image);
    detect.run();
    collect.input<ImageTags>("observations", detect.output<ImageTags>("observations"));
  }
  collect.run();
  const auto all = collect.output<TagObservations>("observations");
  ASSERT_EQ(all.images.size(), 2u);
  EXPECT_EQ(all.images[0]->path, "a.PNG");
  EXPECT_EQ(all.images[1]->path, "floor 1/b.png");
  EXPECT_EQ(all.images[1]->camera, "left");
  ASSERT_EQ(all.images[1]->tags.size(), 1u);
  const TagT& tag = *all.images[1]->tags[0];
  EXPECT_EQ(tag.id, 7);
  ASSERT_EQ(tag.corners.size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_LT((tag.corners[i] - scene().corners[i]).norm(), 0.05);
  ASSERT_EQ(tag.corner_covariances.size(), 12u);
  for (size_t i = 0; i < 4; ++i) EXPECT_LT(tag.corner_covariances[3 * i], 0.05 * 0.05);
}

TEST(DetectNodes, NameADamagedImage) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "whole.png", render(scene()));
  const std::string bytes = test::read_file(folder.path() / "whole.png");
  std::ofstream(folder.path() / "cut.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  test::NodeHarness detect("detect.apriltag");
  ImageT image;
  image.path = "cut.png";
  image.uri = (folder.path() / "cut.png").string();
  detect.input<Image>("images", image);
  EXPECT_THAT(failure_of(detect), testing::AllOf(HasSubstr("cut.png"), HasSubstr("truncated PNG")));
}

TEST(DetectNodes, SayThatAFolderHoldsNoImage) {
  const test::TemporaryFolder folder;
  test::NodeHarness read("read.images");
  read.set("folder", folder.path().string());
  EXPECT_THAT(failure_of(read), HasSubstr("no image in " + folder.path().string()));
}

TEST(DetectNodes, WarnOfAnImageWithoutTags) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "grey.png", GreyImage{64, 64, std::vector<std::uint8_t>(4096, 77)});
  for (const std::string detector : {"detect.apriltag", "detect.tag_pyramid"}) {
    test::NodeHarness detect(detector);
    ImageT image;
    image.path = "grey.png";
    image.uri = (folder.path() / "grey.png").string();
    detect.input<Image>("images", image);
    detect.run();
    EXPECT_TRUE(detect.output<ImageTags>("observations").tags.empty());
    ASSERT_EQ(detect.warnings().size(), 1u);
    EXPECT_THAT(detect.warnings()[0], HasSubstr("grey.png"));
  }
}

TEST(DetectNodes, SayThatAllTagsAreNegativeOrMirrored) {
  const test::TemporaryFolder folder;
  GreyImage inverse = render(scene()), mirror = inverse;
  for (auto& pixel : inverse.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);
  for (int y = 0; y < mirror.height; ++y)
    std::reverse(mirror.pixels.begin() + y * mirror.width, mirror.pixels.begin() + (y + 1) * mirror.width);
  write_png(folder.path() / "negative.png", inverse);
  write_png(folder.path() / "mirror.png", mirror);
  for (const std::string name : {"negative", "mirror"}) {
    test::NodeHarness detect("detect.aruco");
    detect.set("dictionary", "tag36h11");
    ImageT image;
    image.path = name + ".png";
    image.uri = (folder.path() / image.path).string();
    detect.input<Image>("images", image);
    detect.run();
    const ImageTagsT result = detect.output<ImageTags>("observations");
    EXPECT_TRUE(result.tags.empty());
    EXPECT_THAT(result.problem, HasSubstr(name == "mirror" ? "is mirrored" : "white on black"));
  }
}

TEST(DetectNodes, SearchStripByStripLeavesOutWhatCannotBeRead) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "whole.png", render(scene()));
  const std::string bytes = test::read_file(folder.path() / "whole.png");
  std::ofstream(folder.path() / "cut.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  const auto run = [&](const std::string& name, int width) {
    test::NodeHarness detect("detect.tag_pyramid");
    detect.set("on_bad_image", "leave_out");
    ImageT image;
    image.path = name;
    image.uri = (folder.path() / name).string();
    image.width = width, image.height = 200;
    detect.input<Image>("images", image);
    detect.run();
    return detect.output<ImageTags>("observations");
  };
  const ImageTagsT found = run("whole.png", 200);
  ASSERT_EQ(found.tags.size(), 1u);
  EXPECT_EQ(found.tags[0]->id, 7);
  for (size_t i = 0; i < 4; ++i) EXPECT_LT((found.tags[0]->corners[i] - scene().corners[i]).norm(), 0.05);
  EXPECT_THAT(run("cut.png", 200).problem, testing::AllOf(HasSubstr("cut.png"), HasSubstr("truncated PNG")));
  EXPECT_THAT(run("whole.png", 300).problem, HasSubstr("was registered with 300 x 200"));
}

}  // namespace
}  // namespace plumbline
