// pose.opengv_rig: cameras that show two tags each are oriented together.
#include <gmock/gmock.h>

#include <fstream>
#include <memory>
#include <sstream>

#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace plumbline {
namespace test_rig_nodes {

using test::NodeFailed;
using test::NodeHarness;
using testing::HasSubstr;

struct Scene {
  test::SyntheticFacade facade;
  RigidTransform right_from_left;
  std::unique_ptr<test::TemporaryFolder> folder = std::make_unique<test::TemporaryFolder>();

  std::string file(const std::string& text) const {
    const auto path = folder->path() / "calibration.json";
    std::ofstream(path) << text;
    return path.string();
  }
  /// The same rig with either camera as its reference.
  std::string rig(const std::string& reference = "left") const {
    const RigidTransform t = reference == "left" ? right_from_left : right_from_left.inverse();
    std::ostringstream text;
    text.precision(17);
    text << R"({"rig": [{"camera": ")" << (reference == "left" ? "right" : "left") << R"(", "reference": ")"
         << reference << R"(", "rotation": [)" << t.rotation.w() << "," << t.rotation.x() << "," << t.rotation.y()
         << "," << t.rotation.z() << R"(], "translation": [)" << t.translation.x() << "," << t.translation.y() << ","
         << t.translation.z() << "]}]}";
    return file(text.str());
  }
};

/// Four moments of two cameras that look 40 degrees apart and stand 0.6 m apart; each photograph shows two tags.
Scene make_scene(std::size_t tags = 2) {
  Scene scene;
  const test::FacadeOptions options{.columns = 8, .pixel_sigma = 0.1};
  scene.facade = test::make_facade(options);
  scene.facade.images.clear(), scene.facade.poses.poses.clear();
  scene.right_from_left = {quaternion_from_rotation_vector({0.05, -0.7, 0.1}), {-0.6, 0.02, 0.1}};
  test::Random random(3);
  for (int moment = 1; moment <= 4; ++moment) {
    const RigidTransform left =
        test::detail::look_at({4.0 + moment, -7.0 - 0.2 * moment, 1.5}, {4.0, 0, 1.2}, 0.1 * moment);
    for (const std::string name : {"left", "right"}) {
      test::detail::add_image(scene.facade, options, random, name == "left" ? left : scene.right_from_left * left);
      ImageTagsT& image = scene.facade.images.back();
      image.path = name + "/" + std::to_string(moment) + ".jpg", image.camera = name;
      scene.facade.poses.poses.back()->path = image.path;
      image.tags.resize(std::min(image.tags.size(), tags));
    }
  }
  return scene;
}

NodeHarness prepared(const std::string& kind, const Scene& scene, const std::string& reference = "left") {
  NodeHarness node(kind);
  CameraT both = scene.facade.camera_artifact();
  both.id = "left";
  both.others.push_back(std::make_unique<CameraT>(scene.facade.camera_artifact()));
  both.others[0]->id = "right";
  node.input<Camera>("camera", both);
  node.input<Plates>("plates", scene.facade.plates);
  node.input<Points>("points", scene.facade.truth);
  for (const ImageTagsT& image : scene.facade.images) node.input<ImageTags>("observations", image);
  if (kind == "pose.opengv_rig") node.set("rig", scene.rig(reference));
  return node;
}

std::string failure_of(NodeHarness& node) {
  try {
    node.run();
  } catch (const NodeFailed& error) {
    return error.what();
  }
  return "";
}

/// Largest distance of a projection centre from its true place [m].
double worst_centre(const PosesT& found, const PosesT& truth) {
  double worst = 0;
  for (const auto& pose : found.poses) {
    const auto at = std::find_if(truth.poses.begin(), truth.poses.end(),
                                 [&](const auto& candidate) { return candidate->path == pose->path; });
    worst = std::max(worst,
                     ((*at)->cam_from_world.inverse().translation - pose->cam_from_world.inverse().translation).norm());
  }
  return worst;
}

class RigSolvers : public testing::TestWithParam<std::string> {};

TEST_P(RigSolvers, OrientPhotographsOfTwoTagsEachTogether) {
  const Scene scene = make_scene();
  NodeHarness alone = prepared("pose.opengv", scene);
  EXPECT_THAT(failure_of(alone), HasSubstr("shows 2 markers"));
  NodeHarness node = prepared("pose.opengv_rig", scene);
  node.set("solver", GetParam());
  node.run();
  const PosesT poses = node.output<Poses>("poses");
  ASSERT_EQ(poses.poses.size(), scene.facade.images.size());
  // The plates are turned by degrees against their nominal rotation, so some centimetres are all that can be asked.
  EXPECT_LT(worst_centre(poses, scene.facade.poses), 0.1);
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    EXPECT_EQ(poses.poses[i]->path, scene.facade.images[i].path);
    EXPECT_EQ(poses.poses[i]->inliers, 8);
    EXPECT_EQ(poses.poses[i]->correspondences, 8);
  }
}

TEST_P(RigSolvers, FindTheWrongTag) {
  Scene scene = make_scene(3);
  for (auto& corner : scene.facade.images[1].tags[2]->corners) corner += Eigen::Vector2d(431.0, -377.0);
  NodeHarness node = prepared("pose.opengv_rig", scene);
  node.set("solver", GetParam());
  node.run();
  const PosesT poses = node.output<Poses>("poses");
  EXPECT_EQ(poses.poses[0]->inliers, 12);
  EXPECT_EQ(poses.poses[1]->inliers, 8);
  EXPECT_LT(worst_centre(poses, scene.facade.poses), 0.1);
}

TEST_P(RigSolvers, OrientAMomentThatOneCameraShowsAlone) {
  Scene scene = make_scene(6);
  scene.facade.images[3].tags.clear();
  NodeHarness node = prepared("pose.opengv_rig", scene);
  node.set("solver", GetParam());
  node.run();
  const PosesT poses = node.output<Poses>("poses");
  ASSERT_EQ(poses.poses.size(), scene.facade.images.size() - 1);
  EXPECT_EQ(poses.poses[2]->path, "left/2.jpg");
  EXPECT_EQ(poses.poses[3]->path, "left/3.jpg");
  EXPECT_LT(worst_centre(poses, scene.facade.poses), 0.1);
}

INSTANTIATE_TEST_SUITE_P(OpenGv, RigSolvers, testing::Values("gp3p", "gpnp", "upnp"),
                         [](const auto& test) { return test.param; });

TEST(RigPoses, AreTheSameWhicheverCameraTheRigRefersTo) {
  const Scene scene = make_scene();
  NodeHarness left = prepared("pose.opengv_rig", scene), right = prepared("pose.opengv_rig", scene, "right");
  left.run();  // before the other's file is written in its place
  right.set("rig", scene.rig("right"));
  right.run();
  const PosesT a = left.output<Poses>("poses"), b = right.output<Poses>("poses");
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_LT((a.poses[i]->cam_from_world.translation - b.poses[i]->cam_from_world.translation).norm(), 1e-6);
    for (std::size_t k = 0; k < 21; ++k)
      EXPECT_NEAR(a.poses[i]->covariance[k], b.poses[i]->covariance[k], 1e-4 * a.poses[i]->covariance[20]) << k;
  }
}

/// "0001/left.jpg", "0001/right.jpg", and the cameras are told by nothing else.
TEST(RigPoses, AFolderMayBeAMoment) {
  Scene scene = make_scene();
  for (ImageTagsT& image : scene.facade.images) {
    const auto slash = image.path.find('/');
    image.path = "000" + image.path.substr(slash + 1, 1) + "/" + image.path.substr(0, slash) + ".jpg";
  }
  NodeHarness node = prepared("pose.opengv_rig", scene);
  node.run();
  EXPECT_EQ(node.output<Poses>("poses").poses.size(), scene.facade.images.size());
}

/// One camera of a rig, whose frame is the rig's, against the same photographs each by itself.
TEST(RigPoses, OfOneCameraAreThoseOfItsPhotographs) {
  Scene scene = make_scene(6);
  for (std::size_t i = 1; i < scene.facade.images.size(); i += 2) scene.facade.images[i].tags.clear();
  NodeHarness alone = prepared("pose.opengv", scene), rig = prepared("pose.opengv_rig", scene);
  alone.set("on_too_few", "skip");
  alone.run();
  rig.run();
  const PosesT a = alone.output<Poses>("poses"), b = rig.output<Poses>("poses");
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_LT((a.poses[i]->cam_from_world.translation - b.poses[i]->cam_from_world.translation).norm(), 1e-7);
    EXPECT_NEAR(a.poses[i]->rms, b.poses[i]->rms, 1e-6);
    for (std::size_t k = 0; k < 21; ++k)
      EXPECT_NEAR(a.poses[i]->covariance[k], b.poses[i]->covariance[k], 1e-6 * a.poses[i]->covariance[20]) << k;
  }
}

TEST(RigPoses, NameAMomentWithTooFewMarkers) {
  Scene scene = make_scene();
  scene.facade.images[4].tags.clear();
  NodeHarness node = prepared("pose.opengv_rig", scene);
  EXPECT_THAT(failure_of(node), testing::AllOf(HasSubstr("moment 3 of the rig (left/3.jpg, right/3.jpg)"),
                                               HasSubstr("shows 2 markers"), HasSubstr("needed are 3")));
  node.set("on_too_few", "skip");
  node.run();
  EXPECT_EQ(node.output<Poses>("poses").poses.size(), scene.facade.images.size() - 2);
  EXPECT_THAT(node.warnings(), testing::ElementsAre(HasSubstr("moment 3")));
}

TEST(RigPoses, RefuseWhatIsNoRig) {
  const Scene scene = make_scene();
  NodeHarness node = prepared("pose.opengv_rig", scene);
  for (const auto& [text, said] : std::vector<std::pair<std::string, std::string>>{
           {R"({"rig": []})", "its rig is empty; the warnings of calibrate_camera say why"},
           {R"({"cameras": 1})", "expected the calibration.json that calibrate_camera makes of several cameras"},
           {R"({"rig": [{"camera": "right", "reference": "left", "rotation": [2,0,0,0], "translation": [0,0,0]}]})",
            "rotation is no unit quaternion"},
           {"", "no rig"}}) {
    node.set("rig", scene.file(text));
    EXPECT_THAT(failure_of(node), testing::AllOf(HasSubstr("calibration.json: "), HasSubstr(said))) << text;
  }
}

TEST(RigPoses, RefusePhotographsThatTheRigDoesNotExplain) {
  Scene scene = make_scene();
  scene.facade.images[2].camera = "third", scene.facade.images[2].path = "third/2.jpg";
  NodeHarness other = prepared("pose.opengv_rig", scene);
  EXPECT_THAT(failure_of(other), HasSubstr("image third/2.jpg is of camera 'third', the rig has 'left', 'right'"));
  scene.facade.images[2].camera = "left", scene.facade.images[2].path = "left/b_1.jpg";
  NodeHarness twice = prepared("pose.opengv_rig", scene);
  EXPECT_THAT(failure_of(twice), HasSubstr("left/1.jpg and left/b_1.jpg are both of one camera at moment 1"));
}

}  // namespace test_rig_nodes
}  // namespace plumbline
