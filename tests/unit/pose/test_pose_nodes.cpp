// pose.opengv and pose.opencv as nodes; what every pose initialiser must do is in tests/conformance.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace plumbline {
namespace test_pose_nodes {

using test::NodeFailed;
using test::NodeHarness;
using testing::HasSubstr;

NodeHarness prepared(const std::string& kind, const test::SyntheticFacade& facade, const CameraT& camera) {
  NodeHarness node(kind);
  node.input<Camera>("camera", camera);
  node.input<Plates>("plates", facade.plates);
  node.input<Points>("points", facade.truth);
  for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
  return node;
}

NodeHarness prepared(const std::string& kind, const test::SyntheticFacade& facade) {
  return prepared(kind, facade, facade.camera_artifact());
}

std::string failure_of(NodeHarness& node) {
  try {
    node.run();
  } catch (const NodeFailed& error) {
    return error.what();
  }
  return "";
}

class PoseNodes : public testing::TestWithParam<std::string> {};

TEST_P(PoseNodes, LeaveOutAnImageWithTooFewMarkersIfAsked) {
  auto facade = test::make_facade({.floors = 1});
  facade.images[2].tags.resize(2);
  NodeHarness node = prepared(GetParam(), facade);
  node.set("on_too_few", "skip");
  node.run();
  EXPECT_EQ(node.output<Poses>("poses").poses.size(), facade.images.size() - 1);
  ASSERT_EQ(node.warnings().size(), 1u);
  EXPECT_THAT(node.warnings()[0], testing::AllOf(HasSubstr(facade.images[2].path), HasSubstr("shows 2 markers")));
}

TEST_P(PoseNodes, SayWhatToDoAboutTooFewMarkers) {
  auto facade = test::make_facade({.floors = 1});
  facade.images[2].tags.resize(2);
  NodeHarness node = prepared(GetParam(), facade);
  EXPECT_THAT(failure_of(node),
              testing::AllOf(HasSubstr("shows 2 markers"), HasSubstr("needed are 3"), HasSubstr("on_too_few")));
}

/// Eleven tags in a blurred photograph are no reason to photograph more of them.
TEST_P(PoseNodes, SayThatAPhotographIsBlurred) {
  auto facade = test::make_facade({.floors = 1, .columns = 6});
  for (ImageTagsT& image : facade.images)
    for (auto& tag : image.tags) tag->refined = true;
  ImageTagsT& blurred = facade.images[2];
  test::Random random(4);
  for (auto& tag : blurred.tags) {
    tag->refined = false;
    for (auto& corner : tag->corners) corner += 300 * Eigen::Vector2d(random.normal(), random.normal());
  }
  NodeHarness node = prepared(GetParam(), facade);
  node.set("look_for_causes", "false");
  const std::string count = std::to_string(blurred.tags.size());
  EXPECT_THAT(failure_of(node),
              testing::AllOf(HasSubstr(blurred.path), HasSubstr(count + " of its " + count + " tags are too blurred"),
                             testing::Not(HasSubstr("more markers"))));
  node.set("on_too_few", "skip");
  node.run();
  EXPECT_THAT(node.warnings(), testing::Contains(testing::AllOf(HasSubstr(blurred.path), HasSubstr("too blurred"),
                                                                HasSubstr("it is left out"))));
}

TEST_P(PoseNodes, DoNotCountTagsThatAreNotInThePlateTable) {
  auto facade = test::make_facade({.floors = 1});
  for (auto& tag : facade.images[0].tags) tag->id += 400;
  NodeHarness node = prepared(GetParam(), facade);
  EXPECT_THAT(failure_of(node), testing::AllOf(HasSubstr(facade.images[0].path), HasSubstr("shows 0 markers")));
}

TEST_P(PoseNodes, RefuseATagThatStandsForTwoAnchors) {
  auto facade = test::make_facade({.floors = 1});
  facade.plates.plates[3]->tag_id = facade.plates.plates[1]->tag_id;
  NodeHarness node = prepared(GetParam(), facade);
  EXPECT_THAT(failure_of(node), HasSubstr("stands for two anchors"));
}

TEST_P(PoseNodes, NameAnAnchorWhoseCoordinatesAreNone) {
  auto facade = test::make_facade({.floors = 1});
  facade.truth.points[2]->position.z() = 1e308;
  NodeHarness node = prepared(GetParam(), facade);
  EXPECT_THAT(failure_of(node), testing::AllOf(HasSubstr("anchor " + facade.truth.points[2]->id), HasSubstr("metres")));
}

TEST_P(PoseNodes, RefuseACameraOfAnotherImageSize) {
  auto facade = test::make_facade({.floors = 1});
  facade.images[1].width = 6000;
  NodeHarness node = prepared(GetParam(), facade);
  EXPECT_THAT(failure_of(node), testing::AllOf(HasSubstr(facade.images[1].path), HasSubstr("6000 x 8742")));
}

/// A facade whose odd photographs were taken with a second camera, of another principal point and size.
test::SyntheticFacade of_two_cameras(CameraT& both) {
  auto facade = test::make_facade({.floors = 1});
  both = facade.camera_artifact();
  auto second = std::make_unique<CameraT>(both);
  second->id = "second";
  second->width += 600;
  second->parameters[2] += 400;
  for (std::size_t i = 0; i < facade.images.size(); ++i) {
    ImageTagsT& image = facade.images[i];
    image.camera = i % 2 ? "second" : "camera";
    if (i % 2 == 0) continue;
    image.width = second->width;
    for (const auto& tag : image.tags)
      for (Eigen::Vector2d& corner : tag->corners) corner.x() += 400;
  }
  both.others.push_back(std::move(second));
  return facade;
}

TEST_P(PoseNodes, OrientThePhotographsOfSeveralCamerasEachWithItsOwn) {
  CameraT both;
  const auto facade = of_two_cameras(both);
  NodeHarness of_both = prepared(GetParam(), facade, both),
              alone = prepared(GetParam(), test::make_facade({.floors = 1}));
  of_both.run();
  alone.run();
  EXPECT_EQ(of_both.warnings(), std::vector<std::string>());
  const PosesT a = of_both.output<Poses>("poses"), b = alone.output<Poses>("poses");
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i)
    EXPECT_LT((a.poses[i]->cam_from_world.translation - b.poses[i]->cam_from_world.translation).norm(), 1e-6);
}

TEST_P(PoseNodes, RefuseAPhotographOfACameraThatNobodyGave) {
  CameraT both;
  auto facade = of_two_cameras(both);
  facade.images[2].camera = "third";
  NodeHarness node = prepared(GetParam(), facade, both);
  EXPECT_THAT(failure_of(node), testing::AllOf(HasSubstr(facade.images[2].path),
                                               HasSubstr("is of camera 'third', expected one of 'camera', 'second'")));
}

TEST_P(PoseNodes, NameTheCameraThatTookThePhotographsOfAnother) {
  CameraT both;
  auto facade = of_two_cameras(both);
  both.others[0]->width = both.width;
  both.others[0]->parameters[0] *= 1.5, both.others[0]->parameters[1] *= 1.5;
  for (ImageTagsT& image : facade.images) {
    image.width = both.width;
    if (image.camera == "second")
      for (const auto& tag : image.tags)
        for (Eigen::Vector2d& corner : tag->corners) corner.x() -= 400;  // they are of the first
  }
  NodeHarness node = prepared(GetParam(), facade, both);
  node.set("on_too_few", "skip");
  std::string said = failure_of(node);
  for (const std::string& warning : node.warnings()) said += "\n" + warning;
  EXPECT_THAT(said, HasSubstr("camera 'second': its photographs look as if taken with camera 'camera'"));
}

TEST_P(PoseNodes, SayThatNoPhotographShowsATagOfTheFamily) {
  auto facade = test::make_facade({.floors = 1});
  for (ImageTagsT& image : facade.images) image.tags.clear();
  NodeHarness node = prepared(GetParam(), facade);
  EXPECT_THAT(failure_of(node), testing::AllOf(HasSubstr("shows a tag of the family that the detector looks for"),
                                               HasSubstr("the plate table lists tag36h11")));
}

/// What the node says, as an error or a warning, when all plates are given as looking elsewhere than they do.
std::string said_of_azimuths(const std::string& kind, const std::function<double(double)>& given) {
  auto facade = test::make_facade({.floors = 1});
  facade.images.resize(2);  // every mistake that people make is tried on every image
  for (ImageTagsT& image : facade.images) image.tags.resize(std::min<std::size_t>(image.tags.size(), 6));
  for (auto& plate : facade.plates.plates) {
    const Eigen::Vector3d normal = plate->nominal_rotation * Eigen::Vector3d::UnitZ();
    const double azimuth = std::atan2(normal.x(), normal.y()), now = given(azimuth < 0 ? azimuth + 2 * M_PI : azimuth);
    plate->nominal_rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(azimuth - now, Eigen::Vector3d::UnitZ())) * plate->nominal_rotation;
  }
  NodeHarness node = prepared(kind, facade);
  std::string said = failure_of(node);
  if (said.empty())
    for (const std::string& warning : node.warnings()) said += warning + "\n";
  return said;
}

TEST_P(PoseNodes, SayThatPlatesLookElsewhere) {
  EXPECT_THAT(said_of_azimuths(GetParam(), [](double) { return 0.0; }),
              HasSubstr("facing_azimuth of the plate table is wrong by 180 degrees"));
  if (GetParam() != "pose.opengv") return;  // the quicker one
  EXPECT_THAT(said_of_azimuths(GetParam(), [](double a) { return a + M_PI / 2; }),
              HasSubstr("facing_azimuth of the plate table is wrong by 90 degrees"));
  EXPECT_THAT(said_of_azimuths(GetParam(), [](double a) { return a * M_PI / 180; }),
              HasSubstr("facing_azimuth of the plate table is in radians"));
}

TEST_P(PoseNodes, GiveWhatTheSolverAloneMakesOfOneTagIfAsked) {
  const auto facade = test::make_facade({.floors = 1, .pixel_sigma = 0.1});
  NodeHarness node = prepared(GetParam(), facade);
  node.set("raw_tags", "1");
  node.set("min_markers", "1000");  // is not asked
  node.run();
  const PosesT poses = node.output<Poses>("poses");
  ASSERT_EQ(poses.poses.size(), facade.images.size());
  for (const auto& pose : poses.poses) {
    EXPECT_EQ(pose->inliers, 4);
    EXPECT_TRUE(pose->covariance.empty()) << "nobody knows it";
  }
}

TEST_P(PoseNodes, CountCornersAndGiveACovariance) {
  const auto facade = test::make_facade({.floors = 1, .pixel_sigma = 0.1});
  NodeHarness node = prepared(GetParam(), facade);
  node.run();
  const PosesT poses = node.output<Poses>("poses");
  ASSERT_EQ(poses.poses.size(), facade.images.size());
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    EXPECT_EQ(poses.poses[i]->path, facade.images[i].path);
    EXPECT_EQ(poses.poses[i]->correspondences, static_cast<int>(4 * facade.images[i].tags.size()));
    EXPECT_EQ(poses.poses[i]->inliers, poses.poses[i]->correspondences);
    EXPECT_EQ(poses.poses[i]->covariance.size(), 21u);
    EXPECT_GT(poses.poses[i]->rms, 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, PoseNodes, testing::Values("pose.opengv", "pose.opencv", "pose.lambda_twist"),
                         [](const auto& test) { return test.param.substr(5); });

}  // namespace test_pose_nodes
}  // namespace plumbline
