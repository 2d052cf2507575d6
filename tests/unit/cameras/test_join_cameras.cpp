// join.cameras, and that what it gives is what a pose initialiser takes.
#include <gmock/gmock.h>

#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace plumbline {
namespace test_join_cameras {

using test::NodeFailed;
using test::NodeHarness;
using testing::HasSubstr;

CameraT named(const test::SyntheticFacade& facade, const std::string& id) {
  CameraT camera = facade.camera_artifact();
  camera.id = id;
  return camera;
}

TEST(JoinCameras, GivesWhatAPoseInitialiserTakes) {
  auto facade = test::make_facade({.floors = 1});
  NodeHarness join("join.cameras");
  for (const char* id : {"left", "right"}) join.input<Camera>("cameras", named(facade, id));
  join.run();
  NodeHarness pose("pose.opengv");
  pose.input<Camera>("camera", join.output<Camera>("camera"));
  pose.input<Plates>("plates", facade.plates);
  pose.input<Points>("points", facade.truth);
  for (std::size_t i = 0; i < facade.images.size(); ++i) {
    facade.images[i].camera = i % 2 ? "right" : "left";
    pose.input<ImageTags>("observations", facade.images[i]);
  }
  pose.run();
  EXPECT_EQ(pose.output<Poses>("poses").poses.size(), facade.images.size());
}

TEST(JoinCameras, TakesWhatWasJoinedBefore) {
  const auto facade = test::make_facade({.floors = 1});
  NodeHarness first("join.cameras"), second("join.cameras");
  for (const char* id : {"a", "b"}) first.input<Camera>("cameras", named(facade, id));
  first.run();
  second.input<Camera>("cameras", first.output<Camera>("camera"));
  second.input<Camera>("cameras", named(facade, "c"));
  second.run();
  const CameraT all = second.output<Camera>("camera");
  EXPECT_EQ(all.id, "a");
  ASSERT_EQ(all.others.size(), 2u);
  EXPECT_EQ(all.others[1]->id, "c");
}

TEST(JoinCameras, RefusesNoneAndTwoOfOneName) {
  const auto facade = test::make_facade({.floors = 1});
  NodeHarness none("join.cameras"), twice("join.cameras");
  const auto failure = [](NodeHarness& node) -> std::string {
    try {
      node.run();
    } catch (const NodeFailed& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(failure(none), HasSubstr("no camera was given"));
  for (int k = 0; k < 2; ++k) twice.input<Camera>("cameras", named(facade, "camera"));
  EXPECT_THAT(failure(twice), HasSubstr("two cameras are called 'camera'"));
}

}  // namespace test_join_cameras
}  // namespace plumbline
