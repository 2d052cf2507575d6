// Solvers alone, and our own for three points.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "geometry/random.hpp"
#include "photo/pose/lambda_twist.hpp"
#include "photo/pose/raw_pose.hpp"
#include "place/pose/opencv_solvers.hpp"
#include "place/pose/opengv_solvers.hpp"

namespace plumbline {
namespace test_raw_pose {

struct Scene {
  BrownCamera camera;
  RigidTransform cam_from_world;
  std::vector<TagView> views;
};

/// Six tags of 0.2 m on a facade, seen obliquely from 6 m, near national coordinates.
Scene scene_of(double pixel_sigma, std::uint64_t seed) {
  Scene scene;
  scene.camera.width = 6000, scene.camera.height = 4000;
  scene.camera.fx = scene.camera.fy = 5000, scene.camera.cx = 2990, scene.camera.cy = 2010, scene.camera.k1 = -0.04;
  const Eigen::Vector3d far(4.5e5, 5.4e6, 300);
  Random random(seed);
  Eigen::Matrix3d facing, looking;
  facing << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  looking << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.35, Eigen::Vector3d(0.3, 1, 0.1).normalized()));
  scene.cam_from_world.rotation = tilt * Eigen::Quaterniond(looking);
  scene.cam_from_world.translation = -(scene.cam_from_world.rotation * (far + Eigen::Vector3d(-2, -6, 1)));
  for (int k = 0; k < 6; ++k) {
    TagView view;
    view.id = k, view.tag_size = 0.2;
    view.anchor_in_world = far + Eigen::Vector3d(-1 + k % 3, 0.05 * (k % 2), 0.5 + k / 3);
    view.anchor_covariance.setZero();
    view.world_from_tag = {Eigen::Quaterniond(facing), view.anchor_in_world};
    for (int i = 0; i < 4; ++i) {
      const auto pixel = project(scene.camera, scene.cam_from_world * view.corner_in_world(i));
      EXPECT_TRUE(pixel.has_value());
      const auto at = static_cast<std::size_t>(i);
      view.pixels[at] = *pixel + pixel_sigma * Eigen::Vector2d(random.normal(), random.normal());
      view.pixel_covariances[at].setIdentity();
      view.bearings[at] = unproject(scene.camera, view.pixels[at])->homogeneous().normalized();
    }
    scene.views.push_back(view);
  }
  return scene;
}

double centre_error(const RigidTransform& found, const Scene& scene) {
  return (found.inverse().translation - scene.cam_from_world.inverse().translation).norm();
}

std::vector<std::pair<std::string, TagPoseSolver>> solvers() {
  std::vector<std::pair<std::string, TagPoseSolver>> list{{"lambda_twist", pose::lambda_twist_of_tags}};
  for (const char* name : {"p3p_kneip", "p3p_gao", "upnp"}) list.emplace_back(name, pose::make_opengv_solver(name));
  for (const char* name : {"sqpnp", "p3p", "ap3p", "ippe_square"})
    list.emplace_back(name, pose::make_opencv_solver(name));
  return list;
}

/// Not OpenCV's p3p (4.6): of one tag without noise it makes a pose that is 5 m off, of two one that is 35 mm off.
TEST(RawPose, IsThePoseWithoutNoiseWhateverTheNumberOfTags) {
  const Scene scene = scene_of(0, 1);
  for (const auto& [name, solver] : solvers())
    for (const int tags : {1, 2, 3, 6}) {
      if (name == "p3p") continue;
      const TagPose found = pose::raw_tag_pose(scene.camera, scene.views, solver, tags);
      EXPECT_LT(centre_error(found.cam_from_world, scene), 2e-4) << name << ", " << tags << " tags";
      EXPECT_EQ(found.inlier_count, tags);
    }
}

/// Once all solvers gave the same to 1e-11, so that 25 600 cells of a bench compared one thing with itself.
TEST(RawPose, TellsSolversApartWhereTheCommonFrameDoesNot) {
  const Scene scene = scene_of(0.3, 2);
  std::vector<double> raw, common;
  for (const auto& [name, solver] : solvers()) {
    raw.push_back(centre_error(pose::raw_tag_pose(scene.camera, scene.views, solver, 3).cam_from_world, scene));
    common.push_back(centre_error(estimate_tag_pose(scene.camera, scene.views, solver, {}).cam_from_world, scene));
  }
  std::size_t different = 0;
  for (std::size_t k = 1; k < raw.size(); ++k) {
    EXPECT_NEAR(common[k], common[0], 1e-6);
    different += std::abs(raw[k] - raw[0]) > 1e-4;
  }
  EXPECT_GE(different, 3u);
}

TEST(RawPose, OfTooFewTagsIsRefused) {
  const Scene scene = scene_of(0, 1);
  EXPECT_THROW(pose::raw_tag_pose(scene.camera, scene.views, pose::lambda_twist_of_tags, 7), NoTagPose);
}

/// Random triangles in random poses: one of the solutions is the true pose, and every solution sees the points where
/// they are.
TEST(LambdaTwist, FindsTheTruePoseAndNoneThatIsWrong) {
  Random random(11);
  double largest = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const RigidTransform truth{
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized(),
        random.normal3(1)};
    std::array<Eigen::Vector3d, 3> points, bearings;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d in_camera(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(2, 10));
      points[k] = truth.inverse() * in_camera;
      bearings[k] = in_camera.normalized();
    }
    const PoseHypotheses found = pose::lambda_twist(points, bearings);
    double nearest = 1e9;
    ASSERT_LE(found.size(), 4u);
    for (const RigidTransform& pose : found) {
      nearest = std::min(nearest, (pose.inverse().translation - truth.inverse().translation).norm());
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_LT((pose * points[k]).normalized().cross(bearings[k]).norm(), 1e-7) << trial;
    }
    largest = std::max(largest, nearest);
    EXPECT_LT(nearest, 1e-3) << trial;
  }
  RecordProperty("largest error", std::to_string(largest));
}

TEST(LambdaTwist, OfPointsOnALineHasNoPose) {
  const Eigen::Vector3d a(0, 0, 5), b(1, 0, 5), c(2, 0, 5);
  EXPECT_TRUE(pose::lambda_twist({a, b, c}, {a.normalized(), b.normalized(), c.normalized()}).empty());
}

}  // namespace test_raw_pose
}  // namespace plumbline
