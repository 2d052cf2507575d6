#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "block/aicon_files.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace {

using namespace plumbline;
using adjust::PointBlock;
using test::error_of;
using testing::HasSubstr;

/// 20 points on a table of half a metre, 8 images around it, distortion-free camera, one scale bar, no noise.
PointBlock small_block() {
  PointBlock block;
  adjust::SensorCamera camera;
  camera.id = 1;
  camera.values = {-28, 0.02, -0.03, 0, 0, 0, 0, 0, 0, 0};
  camera.balance_radius = 13;
  block.cameras.push_back(camera);
  test::Random random(3);
  for (int j = 0; j < 20; ++j)
    block.points.push_back(
        {std::to_string(j + 1), {0.5 * random.uniform(), 0.5 * random.uniform(), 0.1 * random.uniform()}});
  for (int i = 0; i < 8; ++i) {
    const double angle = 2 * M_PI * i / 8;
    const Eigen::Vector3d centre(0.25 + 0.6 * std::cos(angle), 0.25 + 0.6 * std::sin(angle), 0.9);
    // Camera z points away from the scene; roll alternates.
    const Eigen::Vector3d z = (centre - Eigen::Vector3d(0.25, 0.25, 0.05)).normalized();
    const Eigen::Vector3d x = Eigen::Vector3d(std::cos(i), std::sin(1.0 * i), 0).cross(z).normalized();
    Eigen::Matrix3d block_from_camera;
    block_from_camera << x, z.cross(x), z;
    block.images.push_back({i + 1, 0, centre, adjust::angles_from_rotation(block_from_camera)});
    for (int j = 0; j < 20; ++j) {
      const Eigen::Vector3d v =
          block_from_camera.transpose() * (block.points[static_cast<size_t>(j)].position - centre);
      adjust::BlockMeasurement measured;
      measured.image = i;
      measured.point = j;
      measured.position = Eigen::Vector2d(0.02, -0.03) - 28 * v.head<2>() / v.z();
      block.measurements.push_back(measured);
    }
  }
  block.scale_bars.push_back({"bar", 0, 1, (block.points[0].position - block.points[1].position).norm(), 1e-5});
  return block;
}

adjust::PointBlockOptions options() {
  adjust::PointBlockOptions result;
  result.free_parameters = {"Ck", "xh", "yh"};
  return result;
}

TEST(PointBlock, AnglesAndBack) {
  const Eigen::Vector3d angles(2.1, -0.7, -3.0);
  EXPECT_LT((adjust::angles_from_rotation(adjust::rotation_from_angles(angles)) - angles).norm(), 1e-14);
}

TEST(PointBlock, RecoversTruthFromDisturbedValues) {
  const PointBlock truth = small_block();
  PointBlock start = truth;
  for (size_t i = 0; i < start.images.size(); ++i)
    start.images[i].centre += 0.01 * Eigen::Vector3d(std::sin(i), std::cos(i), 0.5);
  start.cameras[0].values[0] = -28.3;
  const auto result = adjust::adjust_point_block(start, options());
  EXPECT_NEAR(result.block.cameras[0].values[0], -28, 1e-7);
  EXPECT_EQ(result.constraints, 6);
  EXPECT_EQ(result.degrees_of_freedom, 2 * 160 + 1 - (60 + 48 + 3) + 6);
  for (size_t j = 0; j < truth.points.size(); ++j)
    EXPECT_LT((result.block.points[j].position - truth.points[j].position).norm(), 1e-8);
}

TEST(PointBlock, WithoutScaleBarScaleIsPartOfTheDatum) {
  PointBlock block = small_block();
  block.scale_bars.clear();
  const auto result = adjust::adjust_point_block(block, options());
  EXPECT_EQ(result.constraints, 7);
  EXPECT_EQ(result.degrees_of_freedom, 2 * 160 - (60 + 48 + 3) + 7);
}

TEST(PointBlock, RefusalsNameTheCause) {
  const auto refusal = [](const PointBlock& block) {
    return error_of([&] { adjust::adjust_point_block(block, options()); });
  };
  PointBlock one_image = small_block();
  one_image.images.resize(1);
  EXPECT_THAT(refusal(one_image), HasSubstr("at least 2 images, this one has 1"));
  PointBlock seen_once = small_block();
  std::erase_if(seen_once.measurements, [](const auto& m) { return m.point == 4 && m.image > 0; });
  EXPECT_THAT(refusal(seen_once), HasSubstr("object point 5 measured in fewer than 2 images"));
  PointBlock loose_image = small_block();
  std::erase_if(loose_image.measurements, [](const auto& m) { return m.image == 2 && m.point > 1; });
  EXPECT_THAT(refusal(loose_image), HasSubstr("image 3 (2) with fewer than 3 measured points"));
  // The same view eight times: no depth at all.
  PointBlock one_view = small_block();
  for (auto& image : one_view.images)
    image.centre = one_view.images[0].centre, image.angles = one_view.images[0].angles;
  for (auto& m : one_view.measurements) m.position = one_view.measurements[static_cast<size_t>(m.point)].position;
  EXPECT_THAT(refusal(one_view), HasSubstr("rank defect"));
}

TEST(AiconFiles, ErrorsNameFileAndLine) {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder.path() / name) << text; };
  const auto read = [&] { return error_of([&] { adjust::read_aicon_folder(folder.path()); }); };
  EXPECT_THAT(read(), HasSubstr("holds no *.ior file"));
  write("b.ior", "1 -999 -28.7 0 0 0 0 13.4\n0\n0 0\n0 0\n");
  EXPECT_THAT(read(), HasSubstr("b.ior:1: the camera that begins here has 4 lines, expected 5"));
  write("b.ior", "1 -999 -28.7 0 0 0 0 13.4\n0\n0 0\n0 0\n36 24 8688 5792\n");
  write("b.eor", "1 2 0 0 0 0 0 0\n");
  EXPECT_THAT(read(), HasSubstr("b.eor:1: camera 2 is not in the .ior file"));
  write("b.eor", "1 1 0 0 0 0 0 0\n\n2 1 0 0 0 0 0\n");
  EXPECT_THAT(read(), HasSubstr("b.eor:3: found 7 columns, expected at least 8"));
  write("b.eor", "1 1 0 0 0 0 0 0\n2 1 0 0 0 0 0 0\n");
  write("b.obc", "7 1.0 2.0 x 0 0 0 5 1\n");
  EXPECT_THAT(read(), HasSubstr("b.obc:1: column 4 is 'x', expected a number"));
  write("b.obc", "7 1.0 2.0 3 0 0 0 5 1\n");
  write("b.phc", "1 7 0 0 0 0 0 0 1 1\n1 7 0 0 0 0 0 0 1 1\n");
  EXPECT_THAT(read(), HasSubstr("b.phc:2: point 7 is measured a second time in image 1, first in line 1"));
  write("b.phc", "1 7 0 0 0 0 0 0 1 1\n");
  write("b.scale", "0 \"my bar\" 7 8 100 0.1 1\n");
  EXPECT_THAT(read(), HasSubstr("b.scale:1: point 8 of scale bar 'my bar'"));
}

}  // namespace
