// Files that other programs wrote: points, boxes and means as other readers give them (of E57 web-e57 1.2.0, of LAS
// laz-perf 0.0.7), and what they cannot read either. Small ones lie in tests/fixtures/clouds.
#include <gtest/gtest.h>

#include "surface/cloud/cloud_file.hpp"
#include "test_support.hpp"

namespace plumbline::cloud {
namespace test_others {

struct Expected {
  const char* file;
  std::uint64_t points;
  Eigen::Vector3d low, high, mean;
};

const Eigen::Vector3d kBunnyLow(-0.09469, 0.04001, -0.06187), kBunnyHigh(0.06101, 0.18732, 0.05880),
    kBunnyMean(-0.02751, 0.10308, 0.00864);

const Expected kLarge[] = {
    {"bunnyDouble.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyFloat.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyInt19.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyInt21.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyInt24.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyInt32.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"tinyCartesianFloatRgb.e57",
     2090,
     {-9.77953, 4.51388, 295.52469},
     {-6.77424, 7.51546, 298.53217},
     {-8.04414, 6.01253, 297.00220}},
};

const Expected kSmall[] = {
    {"float_intensity_without_min_max.e57", 1, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}},
    {"integer_intensity.e57", 2, {1.1, 2.2, 3.3}, {4.4, 5.5, 6.6}, {2.75, 3.85, 4.95}},
    {"scaled_integer_intensity.e57", 2, {1.1, 2.2, 3.3}, {4.4, 5.5, 6.6}, {2.75, 3.85, 4.95}},
    {"original_guids.e57", 1, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}},
    {"tiny_pc_with_extension.e57", 1, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}},
    {"tiny_pc_and_images.e57", 2, {0, 0, 0}, {1, 1, 1}, {0.5, 0.5, 0.5}},
    {"tiny_spherical.e57", 180, {0, -0.5, 0}, {1, 0.5, 1}, {0.49975, 0, 0.63692}},
    {"1.0_0.las", 1, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}},
    {"1.0_1.las", 1, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}},
    {"1.1_0.las", 1, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}},
    {"1.1_1.las", 1, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}},
    {"1.2_0.las", 1, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}},
    {"1.2_1.las", 1, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}},
    {"1.2_2.las", 1, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}},
    {"1.2_3.las", 1, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}, {470692.44, 4602888.9, 16}},
    {"100-points.las",
     100,
     {635717.85, 848953.74, 409.19},
     {638944.95, 853483.3, 530.61},
     {637357.3438, 851359.1747, 433.4589}},
    {"prec3.las",
     110,
     {636034.83, 848941.72, 407.32},
     {637177.98, 849442.38, 496.19},
     {636551.416636, 849147.516455, 430.851545}},
    {"hextest.las", 8, {0, 0, 0}, {2, 2.31, 0}, {1, 1.01875, 0}},
    {"test1_4.las",
     1000,
     {1694038.445637, 1816492.70627, 5592.749917},
     {1694539.677014, 1816497.976262, 5599.069687},
     {1694379.477654, 1816495.465573, 5597.520533}},
};

void expect_as_others(const std::filesystem::path& path, const Expected& expected) {
  SCOPED_TRACE(expected.file);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  CloudSummary summary;
  try {
    summary = read_cloud(path.string(), [&](const std::vector<Eigen::Vector3d>& some, double, int) {
      for (const Eigen::Vector3d& point : some) sum += point;
    });
  } catch (const CloudError& error) {
    ADD_FAILURE() << error.what();
    return;
  }
  EXPECT_EQ(summary.points, expected.points);
  EXPECT_LT((summary.low - expected.low).cwiseAbs().maxCoeff(), 1e-5) << summary.low.transpose();
  EXPECT_LT((summary.high - expected.high).cwiseAbs().maxCoeff(), 1e-5) << summary.high.transpose();
  EXPECT_LT((sum / static_cast<double>(summary.points) - expected.mean).cwiseAbs().maxCoeff(), 1e-5);
}

std::filesystem::path fixture(const char* file) {
  return std::filesystem::path(plumbline::test::source_dir()) / "tests/fixtures/clouds" / file;
}

TEST(CloudsOfOthers, SmallOnesAreThoseThatOtherReadersGive) {
  for (const Expected& expected : kSmall) expect_as_others(fixture(expected.file), expected);
}

TEST(CloudsOfOthers, LargerOnesToo) {
  PLUMBLINE_REQUIRE_DATA("clouds/e57");
  for (const Expected& expected : kLarge)
    expect_as_others(plumbline::test::data_file("clouds/e57") / expected.file, expected);
}

TEST(CloudsOfOthers, WhatIsEmptyIsRefused) {
  for (const char* file : {"empty.e57", "empty_pc.e57", "no-points.las"})
    EXPECT_THROW(read_cloud(fixture(file).string(), [](const std::vector<Eigen::Vector3d>&, double, int) {}),
                 CloudError)
        << file;
}

TEST(CloudsOfOthers, ADamagedPageIsRefused) {
  PLUMBLINE_REQUIRE_DATA("clouds/e57");
  const auto path = plumbline::test::data_file("clouds/e57") / "corrupt_crc.e57";
  try {
    read_cloud(path.string(), [](const std::vector<Eigen::Vector3d>&, double, int) {});
    ADD_FAILURE() << "corrupt_crc.e57 is read";
  } catch (const CloudError& error) {
    EXPECT_NE(std::string(error.what()).find("checksum"), std::string::npos) << error.what();
  }
}

}  // namespace test_others
}  // namespace plumbline::cloud
