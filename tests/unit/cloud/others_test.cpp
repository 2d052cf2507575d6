// E57 files that other programs wrote: points, boxes and means as web-e57 1.2.0 (another reader) gives them, and what
// it cannot read either.
#include <gtest/gtest.h>

#include "surface/cloud/cloud_file.hpp"
#include "test_support.hpp"

namespace plumbline::cloud {
namespace {

struct Expected {
  const char* file;
  std::uint64_t points;
  Eigen::Vector3d low, high, mean;
};

const Eigen::Vector3d kBunnyLow(-0.09469, 0.04001, -0.06187), kBunnyHigh(0.06101, 0.18732, 0.05880),
    kBunnyMean(-0.02751, 0.10308, 0.00864);

const Expected kFiles[] = {
    {"bunnyDouble.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyFloat.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyInt19.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyInt21.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyInt24.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"bunnyInt32.e57", 30571, kBunnyLow, kBunnyHigh, kBunnyMean},
    {"float_intensity_without_min_max.e57", 1, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}},
    {"integer_intensity.e57", 2, {1.1, 2.2, 3.3}, {4.4, 5.5, 6.6}, {2.75, 3.85, 4.95}},
    {"scaled_integer_intensity.e57", 2, {1.1, 2.2, 3.3}, {4.4, 5.5, 6.6}, {2.75, 3.85, 4.95}},
    {"original_guids.e57", 1, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}},
    {"tiny_pc_with_extension.e57", 1, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}},
    {"tiny_pc_and_images.e57", 2, {0, 0, 0}, {1, 1, 1}, {0.5, 0.5, 0.5}},
    {"tinyCartesianFloatRgb.e57",
     2090,
     {-9.77953, 4.51388, 295.52469},
     {-6.77424, 7.51546, 298.53217},
     {-8.04414, 6.01253, 297.00220}},
    {"tiny_spherical.e57", 180, {0, -0.5, 0}, {1, 0.5, 1}, {0.49975, 0, 0.63692}},
};

TEST(E57OfOthers, PointsAreThoseThatAnotherReaderGives) {
  PLUMBLINE_REQUIRE_DATA("clouds/e57");
  const auto folder = plumbline::test::data_file("clouds/e57");
  for (const Expected& expected : kFiles) {
    SCOPED_TRACE(expected.file);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    CloudSummary summary;
    try {
      summary =
          read_cloud((folder / expected.file).string(), [&](const std::vector<Eigen::Vector3d>& some, double, int) {
            for (const Eigen::Vector3d& point : some) sum += point;
          });
    } catch (const CloudError& error) {
      ADD_FAILURE() << error.what();
      continue;
    }
    EXPECT_EQ(summary.points, expected.points);
    EXPECT_LT((summary.low - expected.low).cwiseAbs().maxCoeff(), 1e-5) << summary.low.transpose();
    EXPECT_LT((summary.high - expected.high).cwiseAbs().maxCoeff(), 1e-5) << summary.high.transpose();
    EXPECT_LT((sum / static_cast<double>(summary.points) - expected.mean).cwiseAbs().maxCoeff(), 1e-5);
  }
}

TEST(E57OfOthers, WhatIsBrokenOrEmptyIsRefused) {
  PLUMBLINE_REQUIRE_DATA("clouds/e57");
  const auto folder = plumbline::test::data_file("clouds/e57");
  for (const auto& [file, because] :
       {std::pair("corrupt_crc.e57", "checksum"), {"empty.e57", ""}, {"empty_pc.e57", ""}}) {
    try {
      read_cloud((folder / file).string(), [](const std::vector<Eigen::Vector3d>&, double, int) {});
      ADD_FAILURE() << file << " is read";
    } catch (const CloudError& error) {
      EXPECT_NE(std::string(error.what()).find(because), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace plumbline::cloud
