// adjust.marker_board, write.ply and read.images over their artifacts: what they refuse.
#include <gmock/gmock.h>

#include <filesystem>

#include "artifacts/image.hpp"
#include "artifacts/points.hpp"
#include "artifacts/tag_observations.hpp"
#include "node_harness.hpp"
#include "scene.hpp"

namespace plumbline::markers {
namespace {

using testing::HasSubstr;
using testing::Not;

/// What the node says of the block of scene.hpp, whose tags 0 and 1 are 0.3 m apart, with this distance.
std::string said_of(const std::string& distance) {
  const Scene s = scene(0.05, 3);
  test::NodeHarness node("adjust.marker_board");
  TagObservationsT seen;
  for (std::size_t i = 0; i < s.block.images.size(); ++i) {
    ImageT photograph;
    photograph.path = s.block.images[i].path;
    photograph.width = true_camera().width, photograph.height = true_camera().height;
    node.input<Image>("images", photograph);
    auto image = std::make_unique<ImageTagsT>();
    image->path = photograph.path, image->width = photograph.width, image->height = photograph.height;
    for (const MarkerView& view : s.block.views) {
      if (view.image != static_cast<int>(i)) continue;
      auto tag = std::make_unique<TagT>();
      tag->family = "tag36h11", tag->id = s.block.markers[static_cast<std::size_t>(view.marker)].id,
      tag->refined = true;
      tag->corners.assign(view.corners.begin(), view.corners.end());
      for (const Eigen::Matrix2d& c : view.covariances)
        for (const double value : {c(0, 0), c(0, 1), c(1, 1)}) tag->corner_covariances.push_back(value);
      image->tags.push_back(std::move(tag));
    }
    seen.images.push_back(std::move(image));
  }
  node.input<TagObservations>("observations", seen);
  node.set("tag_size", "0.12");
  node.set("distance", distance);
  node.set("compare_halves", "false");
  try {
    node.run();
  } catch (const test::NodeFailed& error) {
    return error.what();
  }
  std::string said;
  for (const std::string& warning : node.warnings()) said += warning + "\n";
  return said;
}

TEST(MarkerBoardDistance, IsThreePlainNumbersOrFour) {
  EXPECT_THAT(said_of("0,1,0.3"), Not(HasSubstr("distance")));
  EXPECT_THAT(said_of("0,1,0.3,0.0002"), Not(HasSubstr("distance")));
  EXPECT_THAT(said_of("0,1,0.3m"), HasSubstr("'0.3m' is no number of metres"));
  EXPECT_THAT(said_of("0,1,1,3"), HasSubstr("3 m of 1 m is no measurement; a decimal comma, perhaps"));
  EXPECT_THAT(said_of("0,one,0.3"), HasSubstr("'one' is no tag's id"));
  EXPECT_THAT(said_of("0,1.5,0.3"), HasSubstr("'1.5' is no tag's id"));
}

TEST(MarkerBoardDistance, InAnotherUnitThanMetresIsTold) {
  EXPECT_THAT(said_of("0,1,300"), HasSubstr("with distance=0,1,300 the tags measure 1200"));
}

TEST(WritePly, RefusesWhatIsNoCoordinate) {
  for (const double height : {300.0, 1e308}) {
    PointsT points;
    points.points.push_back(std::make_unique<PointT>());
    points.points.back()->id = "far", points.points.back()->position = {4.5e5, 5.4e6, height};
    test::NodeHarness node("write.ply");
    node.input<Points>("points", points);
    try {
      node.run();
      EXPECT_EQ(height, 300.0);
    } catch (const test::NodeFailed& error) {
      EXPECT_THAT(error.what(), HasSubstr("point 'far' has a coordinate beyond 1e9 m"));
      EXPECT_EQ(height, 1e308);
    }
  }
}

TEST(ReadImages, NamesALinkToNothing) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("gone.jpg", folder.path() / "a.jpg");
  test::NodeHarness node("read.images");
  node.set("folder", folder.path().string());
  try {
    node.run();
    FAIL();
  } catch (const test::NodeFailed& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.jpg of "));
    EXPECT_THAT(error.what(), HasSubstr("a link to a file that is not there"));
  }
}

}  // namespace
}  // namespace plumbline::markers
