// E57: what was written comes back, wherever bits, packets and pages end; what is wrong is refused with its place.
#include <gtest/gtest.h>

#include <fstream>

#include "e57_bytes.hpp"
#include "surface/cloud/cloud_file.hpp"
#include "surface/cloud/e57_pages.hpp"
#include "test_support.hpp"

namespace plumbline::cloud {
namespace test_e57 {

using namespace plumbline::cloud_bytes;
using Places = std::vector<Eigen::Vector3d>;

struct E57Read {
  CloudSummary summary;
  Places points;
  std::vector<int> scans;
  std::string refused;
};

E57Read read_e57_bytes(const std::string& bytes) {
  const plumbline::test::TemporaryFolder folder;
  const std::string path = (folder.path() / "a.e57").string();
  std::ofstream(path, std::ios::binary) << bytes;
  E57Read read;
  try {
    read.summary = read_cloud(path, [&](const Places& some, double, int scan) {
      read.points.insert(read.points.end(), some.begin(), some.end());
      read.scans.insert(read.scans.end(), some.size(), scan);
    });
  } catch (const CloudError& error) {
    read.refused = error.what();
  }
  return read;
}

Places places(int count) {
  Places points;
  for (int i = 0; i < count; ++i)
    points.push_back({100 + 1e-4 * (7 * i % 1000), -3.5 + 1e-4 * i, 12 + 1e-4 * (i * i % 997)});
  return points;
}

void expect_e57_refused(const std::string& bytes, const std::string& because) {
  const E57Read read = read_e57_bytes(bytes);
  EXPECT_NE(read.refused.find(because), std::string::npos) << (read.refused.empty() ? "(read)" : read.refused);
}

TEST(E57, TheChecksumIsCastagnolis) {
  const std::string text = "123456789";
  EXPECT_EQ(crc32c(reinterpret_cast<const unsigned char*>(text.data()), text.size()), 0xe3069283u);
  EXPECT_EQ(slow_crc32c(text), 0xe3069283u);
}

TEST(E57, EveryEncodingComesBackWhereverPacketsEnd) {
  const Places points = places(2500);
  for (const char* kind : {"scaled", "single", "double", "spherical"})
    for (size_t a_packet : {1UL, 7UL, 1000UL}) {
      if (a_packet == 1 && std::string(kind) != "scaled") continue;
      const E57Read read = read_e57_bytes(e57_file({{points, {}, "", kind, a_packet}}));
      ASSERT_EQ(read.points.size(), points.size()) << kind << read.refused;
      const double within = std::string(kind) == "single" ? 1e-5 : 1e-9;
      for (size_t i = 0; i < points.size(); ++i)
        ASSERT_LT((read.points[i] - points[i]).norm(), within) << kind << " " << i;
      EXPECT_EQ(read.summary.unit, 1) << "metres, by the standard";
    }
}

TEST(E57, StepsAreThoseOfTheNumbers) {
  EXPECT_NEAR(read_e57_bytes(e57_file({{places(10)}})).summary.resolution.x(), 1e-4, 1e-12);
  EXPECT_NEAR(read_e57_bytes(e57_file({{places(10), {}, "", "single"}})).summary.resolution.x(), std::ldexp(1, -17),
              1e-12)
      << "what a 32-bit float tells apart at 100";
  EXPECT_EQ(read_e57_bytes(e57_file({{places(10), {}, "", "double"}})).summary.resolution.x(), 0);
}

TEST(E57, WhatHasNoFinitePlaceIsLeftOutAndSaysNothingOfSteps) {
  for (const char* kind : {"single", "double"}) {
    Places points = places(10);
    points[2].x() = std::numeric_limits<double>::infinity(), points[5].z() = std::numeric_limits<double>::quiet_NaN();
    const E57Read read = read_e57_bytes(e57_file({{points, {}, "", kind}}));
    EXPECT_EQ(read.points.size(), 8U) << read.refused;
    EXPECT_EQ(read.summary.without_place, 2U);
    EXPECT_NEAR(read.summary.resolution.x(), kind == std::string("single") ? std::ldexp(1, -17) : 0, 1e-12) << kind;
  }
}

TEST(E57, EachScanHasItsPoseAndPointsWithoutAPlaceAreLeftOut) {
  const double half = std::sqrt(0.5);
  const std::string pose = "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">" +
                           std::to_string(half) + "</w><x type=\"Float\"/><y type=\"Float\"/><z type=\"Float\">" +
                           std::to_string(half) +
                           "</z></rotation><translation type=\"Structure\"><x type=\"Float\">1000</x><y "
                           "type=\"Float\">2e3</y><z type=\"Float\"/></translation></pose>";
  const Places points = places(300);
  std::vector<int> invalid(300, 0);
  invalid[3] = 2, invalid[17] = 1;
  const E57Read read = read_e57_bytes(e57_file({{points}, {points, invalid, pose}, {points, {}, "", "double"}}));
  ASSERT_EQ(read.points.size(), 898U) << read.refused;
  EXPECT_EQ(read.summary.without_place, 2U);
  EXPECT_EQ(read.summary.scans, 3);
  EXPECT_EQ(read.scans.front(), 0);
  EXPECT_EQ(read.scans.back(), 2);
  // A quarter turn about z: x becomes y.
  const Eigen::Vector3d expected(1000 - points[0].y(), 2000 + points[0].x(), points[0].z());
  EXPECT_LT((read.points[300] - expected).norm(), 1e-3);
  EXPECT_LT((read.points[303] - Eigen::Vector3d(1000 - points[4].y(), 2000 + points[4].x(), points[4].z())).norm(),
            1e-3)
      << "the fourth was left out";
}

TEST(E57, WhatIsDamagedOrCutShortIsRefusedWithItsPlace) {
  const std::string good = e57_file({{places(500)}});
  ASSERT_EQ(read_e57_bytes(good).points.size(), 500U);
  std::string bad = good;
  bad[1500] = static_cast<char>(bad[1500] ^ 1);
  expect_e57_refused(bad, "byte 1024: the checksum of this page of 1024 bytes does not fit what is in it");
  expect_e57_refused(good.substr(0, good.size() - 1024),
                     "its head says " + std::to_string(good.size()) + "; it was cut short");
  expect_e57_refused(good.substr(0, 30), "within the head of 48 bytes");
  bad = good, put(bad, 8, std::uint32_t{2});
  expect_e57_refused(with_new_checksums(bad), "E57 version 2.0");
  bad = good, put(bad, 40, std::uint64_t{512});
  expect_e57_refused(with_new_checksums(bad), "pages of 512 bytes");
  bad = good, put(bad, 24, std::uint64_t{1022});
  expect_e57_refused(with_new_checksums(bad), "byte 1022, where the XML section should be, is in a page's checksum");
  bad = good, put(bad, 24, std::uint64_t{1} << 40);
  expect_e57_refused(with_new_checksums(bad), "is beyond the file's");
  bad = good, put(bad, 32, std::uint64_t{1} << 60);
  expect_e57_refused(with_new_checksums(bad), "an XML section of 1152921504606846976 bytes");
  bad = good, put(bad, 32, std::uint64_t{good.size()});
  expect_e57_refused(with_new_checksums(bad),
                     "the file ends after " + std::to_string(good.size()) + " bytes, within the XML section");
  bad = good, put(bad, 48, std::uint8_t{7});
  expect_e57_refused(with_new_checksums(bad), "the points of scan 1: a section of the kind 7, expected 1");
  bad = good, put(bad, 48 + 32 + 16, std::uint8_t{9});
  expect_e57_refused(with_new_checksums(bad), "a packet of the kind 9");
  bad = good, put(bad, 48 + 32 + 16 + 4, std::uint16_t{3});
  expect_e57_refused(with_new_checksums(bad), "a packet of 3 streams, its points have 4 fields");
  bad = good, put(bad, 48 + 32 + 16 + 6, std::uint16_t{60000});
  expect_e57_refused(with_new_checksums(bad), "the streams of a packet are longer than its");
}

TEST(E57, WhatIsAnnouncedAndNotThereIsRefusedBeforeAnythingIsMadeOfIt) {
  E57ScanBytes scan{places(5)};
  scan.announced = 1000000000;
  expect_e57_refused(e57_file({scan}),
                     "scan 1 ('station 1'): 1000000000 points of 95 bits are announced, the file has");
  scan.announced = 60;
  expect_e57_refused(e57_file({scan}), "its packets end after 5 of 60 points");
  expect_e57_refused(e57_file({}), "there is no scan in it");
  expect_e57_refused(e57_file({{{}}}), "there is no point in it");
  // A billion points of which every number is the same need no byte.
  scan.announced = 1000000000;
  expect_e57_refused(
      e57_file({scan}, {{"maximum=\"1000000000\"", "maximum=\"-1000000000\""}, {"maximum=\"2\"", "maximum=\"0\""}}),
      "1000000000 points of 0 bits are announced");
}

TEST(E57, WhatIsNotTakenIsNamed) {
  const E57ScanBytes scan{places(5)};
  for (const std::string name : {"fileOffset", "recordCount"})
    expect_e57_refused(e57_file({{places(5)}, scan}, {{" " + name + "=", " other="}}), "have no " + name);
  expect_e57_refused(e57_file({scan}, {{"cartesianY", "ownY"}}), "neither cartesianX, Y and Z nor sphericalRange");
  expect_e57_refused(e57_file({scan}, {{"scale=\"1.0e-4\"", "scale=\"nan\""}}), "'cartesianX' has a scale of");
  expect_e57_refused(e57_file({scan}, {{"scale=\"1.0e-4\"", "scale=\"much\""}}),
                     "scale of 'cartesianX' is 'much', expected a number");
  expect_e57_refused(e57_file({scan}, {{"\"1000000000\"", "\"-2000000000\""}}), "a maximum below its minimum");
  expect_e57_refused(
      e57_file({scan},
               {{"<codecs type=\"Vector\" allowHeterogeneousChildren=\"1\">",
                 "<codecs type=\"Vector\" allowHeterogeneousChildren=\"1\"><vectorChild><zip/></vectorChild>"}}),
      "packed by a codec of its own");
  expect_e57_refused(e57_file({scan}, {{"</data3D>", ""}}), "the XML section does not parse");
  expect_e57_refused(e57_file({{places(5), {}, "<pose><rotation><w>3</w></rotation></pose>"}}),
                     "a quaternion of length 3");
}

TEST(E57, DamagedFilesNeverEndTheProgram) {
  const std::string good = e57_file({{places(300)}, {places(20), {}, "", "single", 3}});
  std::uint32_t state = 12345;
  for (int trial = 0; trial < 400; ++trial) {
    std::string bad = good;
    for (int k = 0; k < 3; ++k) {
      state = state * 1664525u + 1013904223u;
      bad[(state >> 8) % bad.size()] = static_cast<char>(state >> 3);
    }
    const E57Read read = read_e57_bytes(with_new_checksums(bad));
    EXPECT_LE(read.points.size(), 320U);
  }
}

/// Files by other programs: libE57Format and las2e57, where they are at hand.
TEST(E57, FilesOfOthers) {
  PLUMBLINE_REQUIRE_DATA("clouds/e57/reference/bunnyInt32.e57");  // asmaloney/libE57Format-test-data
  const std::string folder = plumbline::test::data_file("clouds/e57").string();
  CloudSummary summaries[2];
  Eigen::Vector3d sums[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (int i : {0, 1})
    summaries[i] = read_cloud(folder + (i ? "/reference/bunnyDouble.e57" : "/reference/bunnyInt32.e57"),
                              [&](const Places& some, double, int) {
                                for (const auto& p : some) sums[i] += p;
                              });
  EXPECT_EQ(summaries[0].points, 30571U);
  EXPECT_LT((summaries[0].low - Eigen::Vector3d(-0.0946890, 0.0400110, -0.0618730)).norm(), 1e-9) << "as its XML says";
  EXPECT_LT((sums[0] - sums[1]).norm(), 1e-6);
}

}  // namespace test_e57
}  // namespace plumbline::cloud
