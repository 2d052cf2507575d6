// Bundle adjustment problems in text, held by the formula of the format written out a second time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "photo/block/bal_files.hpp"
#include "photo/block/image_block_folder.hpp"
#include "plumbline/stop.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace test_bal_files {

using namespace plumbline;
using block::PointBlock;
using test::error_of;
using testing::HasSubstr;

/// What the file says of a camera.
struct Camera {
  Eigen::Vector3d turn, shift;
  double f, k1, k2;
};

/// f r(p) p with p = −(P_x, P_y)/P_z and P = R X + t, R by Rodrigues' formula.
Eigen::Vector2d measured(const Camera& camera, const Eigen::Vector3d& x) {
  const double angle = camera.turn.norm();
  const Eigen::Vector3d axis = angle > 0 ? Eigen::Vector3d(camera.turn / angle) : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d p =
      std::cos(angle) * x + std::sin(angle) * axis.cross(x) + (1 - std::cos(angle)) * axis.dot(x) * axis + camera.shift;
  const Eigen::Vector2d ideal = -p.head<2>() / p.z();
  const double s = ideal.squaredNorm();
  return camera.f * (1 + camera.k1 * s + camera.k2 * s * s) * ideal;
}

struct Made {
  std::vector<Camera> cameras;
  std::vector<Eigen::Vector3d> points;
  std::string text;
};

/// Cameras around the negative z axis, one of them turned by nearly half a turn, one not at all.
Made make() {
  Made made;
  test::Random random(11);
  made.cameras = {{{0, 0, 0}, {0.2, 0.1, -6}, 1400, -0.08, 0.03},
                  {{0.1, -0.2, 3.0}, {-0.5, 0.4, -6.5}, 1450, -0.1, 0.02},
                  {{-0.3, 0.25, 0.1}, {0.6, -0.3, -5.5}, 1380, 0.05, 0},
                  {{0.2, 0.4, -1.2}, {0.1, 0.2, -6.2}, 1420, -0.02, 0.01}};
  for (int j = 0; j < 12; ++j) made.points.emplace_back(random.normal(), random.normal(), random.normal());
  char line[200];
  std::snprintf(line, sizeof line, "%zu %zu %zu\n\n", made.cameras.size(), made.points.size(),
                made.cameras.size() * made.points.size());
  made.text = line;
  for (size_t j = 0; j < made.points.size(); ++j)
    for (size_t i = 0; i < made.cameras.size(); ++i) {
      const Eigen::Vector2d at = measured(made.cameras[i], made.points[j]);
      std::snprintf(line, sizeof line, "%zu %zu     %.16e %.16e\n", i, j, at.x(), at.y());
      made.text += line;
    }
  for (const auto& c : made.cameras)
    for (double v : {c.turn.x(), c.turn.y(), c.turn.z(), c.shift.x(), c.shift.y(), c.shift.z(), c.f, c.k1, c.k2})
      std::snprintf(line, sizeof line, "%.16e\n", v), made.text += line;
  for (const auto& p : made.points)
    for (double v : {p.x(), p.y(), p.z()}) std::snprintf(line, sizeof line, "%.16e\n", v), made.text += line;
  return made;
}

class Bal : public testing::Test {
 protected:
  block::ReadBlock read(const std::string& text, double pitch = 0.002) {
    return block::read_bal_file(write("problem.txt", text), pitch);
  }
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    return folder_.path() / name;
  }
  test::TemporaryFolder folder_;
};

/// Σ of squared residuals at the values of the block itself [mm²].
double misfit(const PointBlock& block) {
  double sum = 0;
  for (const auto& m : block.measurements) {
    const auto& image = block.images[m.image];
    const auto& camera = block.cameras[image.camera];
    bundle::LensRows rows;
    EXPECT_TRUE(bundle::evaluate_lens(
        camera.lens, camera.values.data(), camera.balance_radius, 0,
        block::rotation_from_angles(image.angles).transpose() * (block.points[m.point].position - image.centre),
        m.position, false, rows));
    sum += rows.misclosure.squaredNorm();
  }
  return sum;
}

TEST_F(Bal, IsReadAsItsFormulaSays) {
  const auto block = read(make().text).block;
  EXPECT_EQ(block.measurements.size(), 48u);
  EXPECT_LT(misfit(block), 1e-22);
  EXPECT_NEAR(block.cameras[0].values[0], -1400 * 0.002, 1e-12);
}

TEST_F(Bal, IsAdjustedWithPrincipalDistanceAndRadialDistortionOfEveryCamera) {
  auto block = read(make().text).block;
  test::Random random(2);
  for (auto& camera : block.cameras) camera.values[0] *= 1 + 0.002 * random.normal();
  for (auto& point : block.points)
    for (int c = 0; c < 3; ++c) point.position(c) += 0.01 * random.normal();
  const auto result = block::adjust_point_block(block, {});
  EXPECT_EQ(result.unknowns, 4 * 9 + 12 * 3);
  EXPECT_LT(result.sigma0, 1e-9);
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(result.block.cameras[i].values[0], -0.002 * make().cameras[i].f, 1e-8);
}

TEST_F(Bal, ComesBackAsItWasWritten) {
  std::vector<std::string> notes;
  const auto first = read(make().text).block;
  const auto second = read(block::bal_text(first, notes)).block;
  EXPECT_TRUE(notes.empty());
  for (size_t i = 0; i < 4; ++i)
    for (size_t k = 0; k < 5; ++k)
      EXPECT_NEAR(second.cameras[i].values[k], first.cameras[i].values[k],
                  1e-12 * (1 + std::abs(first.cameras[i].values[k])));
  EXPECT_LT(misfit(second), 1e-22);
}

TEST_F(Bal, CamerasOfOtherProgramsArriveWithTheSameRays) {
  const auto plain = read(make().text).block;
  for (int kind = 0; kind < 4; ++kind) {
    PointBlock block = plain;
    for (auto& camera : block.cameras) {
      if (kind == 3)  // of an aircraft: coordinates of a hundred millimetres have fewer digits
        camera.values = {-300, 0.2, -0.3, -1e-8, 1e-13, 1e-18, 1e-7, -2e-7, 2e-5, -1e-5};
      if (kind == 0) camera.values = {-2.8, 0.02, -0.03, -4e-4, 1.5e-6}, camera.balance_radius = 1.1;
      if (kind == 1) camera.values = {-2.8, 0.02, -0.03, -4e-4, 1.5e-6, 1e-8, 6e-5, -9e-5, 2e-4, -1e-4};
      if (kind == 2) {
        camera.lens = bundle::Lens::correcting;
        camera.values = {2.8, 1.5, 1.1, 5e-3, -1e-4, 1e-6, -6e-5, -3e-5, 1e-3, -2e-3};
      }
    }
    for (auto& m : block.measurements) {  // what these cameras measure: Newton on the misclosure
      const auto& image = block.images[m.image];
      const auto& camera = block.cameras[image.camera];
      const Eigen::Vector3d v =
          block::rotation_from_angles(image.angles).transpose() * (block.points[m.point].position - image.centre);
      m.position = {1.5, 1.1};
      for (int step = 0; step < 60; ++step) {
        bundle::LensRows rows;
        ASSERT_TRUE(bundle::evaluate_lens(camera.lens, camera.values.data(), camera.balance_radius, 0, v, m.position,
                                          false, rows));
        m.position += kind == 2 ? Eigen::Vector2d(rows.misclosure.x(), -rows.misclosure.y()) : rows.misclosure;
      }
    }
    ASSERT_LT(misfit(block), kind == 3 ? 1e-16 : 1e-18) << kind;
    std::vector<std::string> notes;
    const auto back = read(block::bal_text(block, notes)).block;
    EXPECT_EQ(notes.size(), kind == 0 ? 0u : 1u);
    EXPECT_LT(misfit(back), kind == 3 ? 1e-16 : 1e-18) << kind;
  }
}

TEST_F(Bal, WhatLiesBehindItsCameraIsLeftOutAndToldOf) {
  Made made = make();
  made.text.replace(made.text.rfind("\n", made.text.size() - 2) + 1, std::string::npos, "2e1\n");
  const auto block = read(made.text);
  EXPECT_LT(block.block.measurements.size(), 48u);
  ASSERT_EQ(block.left_out.size(), 1u);
  EXPECT_THAT(block.left_out[0], HasSubstr("behind the camera"));
}

TEST_F(Bal, IsAskedAtEachLineAndEachLookAtAMeasurement) {
  const Made made = make();
  std::size_t asked = 0;
  const StopScope scope([](const void* count) { return ++*static_cast<std::size_t*>(const_cast<void*>(count)) == 0; },
                        &asked);
  const auto block = read(made.text).block;
  EXPECT_GE(asked, 2 * block.measurements.size() + block.points.size());
}

TEST_F(Bal, WhatCannotBeReadIsRefusedWithItsLine) {
  const auto refusal = [&](const std::string& text) { return error_of([&] { read(text); }); };
  EXPECT_THAT(refusal(""), HasSubstr(":1: the file ends, expected the number of cameras"));
  EXPECT_THAT(refusal("4000000000 100000000000 9\n0 0 1 1\n"), HasSubstr("too short for them"));
  EXPECT_THAT(refusal("1 1 1\n0 0 1"), HasSubstr("too short for them"));
  std::string text = make().text;
  EXPECT_THAT(refusal(text.substr(0, text.size() / 2)), HasSubstr(": the file ends, expected "));
  const size_t at = text.find("\n3 0 ");
  EXPECT_THAT(refusal(std::string(text).replace(at, 5, "\n4 0 ")), HasSubstr(":6: 4 is no number of a camera"));
  EXPECT_THAT(refusal(std::string(text).replace(at, 5, "\nx 0 ")), HasSubstr(":6: found 'x', expected number of a"));
  EXPECT_THAT(refusal(std::string(text).replace(at, 11, "\n3 0   nan ")), HasSubstr(":6: found 'nan'"));
}

TEST_F(Bal, CountsThatAreNotThoseOfTheFileAreRefused) {
  const std::string text = make().text;
  EXPECT_THAT(
      error_of([&] { read(text + "1.5 2 3\n"); }),
      testing::AllOf(HasSubstr("goes on behind its last point"), HasSubstr("(4 cameras, 12 points and 48 obs")));
  EXPECT_THAT(error_of([&] { read("4 12 47" + text.substr(text.find('\n'))); }), HasSubstr("problem.txt:"));
  EXPECT_EQ(read(text + "\n \r\n").block.points.size(), 12u);
}

TEST_F(Bal, AnEditorsMarkInFrontIsNoPartOfIt) {
  const auto file = write("marked.txt", "\xEF\xBB\xBF" + make().text);
  EXPECT_TRUE(block::looks_like_bal(file));
  EXPECT_EQ(block::read_bal_file(file, 0.002).block.points.size(), 12u);
}

TEST_F(Bal, AFolderIsKnownByItsContent) {
  write("some.txt", make().text);
  write("notes.txt", "3 cameras were used\n");
  EXPECT_EQ(block::read_image_block(folder_.path(), "", "", {}).block.images.size(), 4u);
}

}  // namespace test_bal_files
