#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "camera.hpp"

namespace plumbline::simulate {
namespace test_camera_network {

TEST(CameraNetwork, EveryImageSeesFourTagsAndAdjacentFloorsAreLinked) {
  for (const std::string& name : camera_profile_names()) {
    for (int floors = 1; floors <= 5; ++floors) {
      for (int columns = 3; columns <= 4; ++columns) {
        const Building b = make_building({.floors = floors, .columns = columns}, 1);
        const SimulatedCamera camera = make_camera(camera_profile(name), 1);
        std::vector<int> links(static_cast<std::size_t>(floors), 0);
        std::map<std::string, int> seen;
        Eigen::Vector2d largest(0, 0);
        for (const CameraStation& s : plan_camera_stations(b, camera, {}, 1)) {
          const auto tags = visible_tags(b, camera.truth, s.camera_from_building);
          EXPECT_GE(tags.size(), 4u) << s.image;
          std::set<int> on;
          for (const auto& tag : tags) {
            on.insert(tag.anchor->floor), ++seen[tag.anchor->id];
            for (const Eigen::Vector2d& corner : tag.corners) {
              EXPECT_GE(corner.minCoeff(), 0) << s.image;
              EXPECT_LE(corner.x(), camera.truth.width - 1) << s.image;
              EXPECT_LE(corner.y(), camera.truth.height - 1) << s.image;
              largest = largest.cwiseMax(corner);
            }
          }
          for (int f = 1; f < floors; ++f) links[f] += on.count(f) && on.count(f + 1);
        }
        EXPECT_GT(largest.x(), camera.truth.height) << name << ": of the longer side all is used";
        for (int f = 1; f < floors; ++f) EXPECT_GE(links[f], 4) << name << " floor " << f;
        for (const Anchor& a : b.anchors) EXPECT_GE(seen[a.id], 4) << name << " " << a.id;
      }
    }
  }
}

TEST(CameraNetwork, IsConvergentAndRolled) {
  const Building b = make_building({.floors = 2}, 1);
  const SimulatedCamera camera = make_camera(camera_profile("demo_24mp"), 1);
  std::set<int> rolls;
  double left = 0, right = 0;
  for (const CameraStation& s : plan_camera_stations(b, camera, {}, 1)) {
    const Eigen::Matrix3d r = s.camera_from_building.rotation.toRotationMatrix();
    rolls.insert(static_cast<int>(std::lround(2 * std::atan2(r(0, 2), -r(1, 2)) / 3.14159265)));
    const double yaw = std::atan2(r(2, 0), r(2, 1));
    left = std::min(left, yaw), right = std::max(right, yaw);
  }
  EXPECT_GE(rolls.size(), 3u);
  EXPECT_GT(right - left, 0.8);
}

TEST(CameraNetwork, TurnsAsManyImagesAsAskedForUntilTheirBorderCutsATag) {
  const Building b = make_building({.floors = 3}, 1);
  const SimulatedCamera camera = make_camera(camera_profile("demo_24mp"), 1);
  const auto on_the_border = [&](const Eigen::Vector2d& p) {
    const BrownCamera& c = camera.truth;
    return std::min({std::abs(p.x()), std::abs(p.y()), std::abs(p.x() - c.width + 1), std::abs(p.y() - c.height + 1)}) <
           2;
  };
  for (const double share : {0.0, 1.0}) {
    int cut = 0, all = 0;
    for (const CameraStation& s : plan_camera_stations(b, camera, {.cut_tags = share}, 1)) {
      bool cuts = false;
      for (const VisibleTag& tag : visible_tags(b, camera.truth, s.camera_from_building, -1000))
        cuts = cuts || on_the_border(0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]));
      EXPECT_GE(visible_tags(b, camera.truth, s.camera_from_building).size(), 4u) << s.image;
      cut += cuts, ++all;
    }
    EXPECT_NEAR(cut, share * all, 0.1 * all) << share;
  }
}

TEST(CameraNetwork, TooCloseIsAnErrorThatNamesTheImage) {
  const Building b = make_building({.floors = 1}, 1);
  const SimulatedCamera camera = make_camera(camera_profile("demo_24mp"), 1);
  try {
    plan_camera_stations(b, camera, {.distance = 1.5}, 1);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("F01-"), std::string::npos);
  }
}

TEST(CameraNetwork, RefusesFewerImagesThanAFloorNeedsAndMoreThanAnybodyTakes) {
  const Building b = make_building({.floors = 1}, 1);
  const SimulatedCamera camera = make_camera(camera_profile("hasselblad_100mp"), 1);
  const auto planned = [&](int images) {
    CameraNetworkOptions options;
    options.images_per_floor = images;
    return plan_camera_stations(b, camera, options, 1).size();
  };
  EXPECT_EQ(planned(4), 4u);
  EXPECT_EQ(planned(100), 100u);
  EXPECT_THROW(planned(3), std::invalid_argument);
  EXPECT_THROW(planned(101), std::invalid_argument);
}

/// No two lenses are equal: principal points 5 px apart rms from their design, either way, focal lengths by 2e-3.
TEST(Camera, NoTwoBodiesAreEqual) {
  constexpr int bodies = 400;
  const CameraProfile profile = camera_profile("hasselblad_100mp");
  double x = 0, y = 0, focal = 0;
  for (std::uint64_t seed = 0; seed < bodies; ++seed) {
    const BrownCamera truth = make_camera(profile, seed).truth;
    x += std::pow(truth.cx - profile.nominal.cx, 2), y += std::pow(truth.cy - profile.nominal.cy, 2);
    focal += std::pow(truth.fx / profile.nominal.fx - 1, 2);
    EXPECT_NEAR(truth.fx - profile.nominal.fx, truth.fy - profile.nominal.fy, 1e-9);
  }
  const double within = 4 / std::sqrt(2.0 * bodies);  // of a standard deviation, relative
  EXPECT_NEAR(std::sqrt(x / bodies), 5, 5 * within);
  EXPECT_NEAR(std::sqrt(y / bodies), 5, 5 * within);
  EXPECT_NEAR(std::sqrt(focal / bodies), 2e-3, 2e-3 * within);
}

TEST(Camera, CalibrationIsWrongByAboutItsSigma) {
  double sum = 0;
  int n = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const SimulatedCamera camera = make_camera(camera_profile("hasselblad_100mp"), seed);
    const auto truth = camera.truth.parameters(), given = camera.calibration.parameters();
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double sigma = camera.profile.calibration_sigmas[i];
      if (sigma > 0) {
        sum += std::pow((given[i] - truth[i]) / sigma, 2);
        ++n;
      } else {
        EXPECT_EQ(given[i], truth[i]);
      }
    }
  }
  EXPECT_NEAR(sum / n, 1, 4 * std::sqrt(2.0 / n));
}

TEST(Camera, UnknownProfileListsTheKnown) {
  try {
    camera_profile("leica");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("demo_24mp, hasselblad_100mp"), std::string::npos);
  }
}

TEST(LookAt, PutsTheTargetInTheMiddleAndUpUp) {
  const RigidTransform pose = look_at({1, -8, 2}, {3, 0, 4}, 0);
  const Eigen::Vector3d target = pose * Eigen::Vector3d(3, 0, 4);
  EXPECT_NEAR(target.head<2>().norm(), 0, 1e-12);
  EXPECT_GT(target.z(), 8);
  EXPECT_LT((pose.rotation * Eigen::Vector3d::UnitZ()).y(), 0);  // up in the building is up in the image
  EXPECT_GT((pose.rotation * Eigen::Vector3d::UnitX()).x(), 0);  // right is right
}

}  // namespace test_camera_network
}  // namespace plumbline::simulate
