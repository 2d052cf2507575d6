// Points of every format come back where they were put, with what the file says of its unit.
#include <gtest/gtest.h>

#include <fstream>

#include "cloud/cloud_file.hpp"
#include "cloud_bytes.hpp"
#include "test_support.hpp"

namespace plumbline::cloud {
namespace {

using namespace plumbline::cloud_bytes;
using Points = std::vector<Eigen::Vector3d>;

struct Read {
  CloudSummary summary;
  Points points;
};

Read read_bytes(const std::string& name, const std::string& bytes) {
  const plumbline::test::TemporaryFolder folder;
  const std::string path = (folder.path() / name).string();
  std::ofstream(path, std::ios::binary) << bytes;
  Read read;
  double last = 0;
  read.summary = read_cloud(path, [&](const Points& some, double done) {
    EXPECT_GE(done, last);
    EXPECT_LE(done, 1);
    last = done;
    read.points.insert(read.points.end(), some.begin(), some.end());
  });
  EXPECT_EQ(read.summary.points, read.points.size());
  return read;
}

void expect_near(const Points& found, const Points& expected, double within) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) EXPECT_LE((found[i] - expected[i]).cwiseAbs().maxCoeff(), within) << i;
}

const Points kPoints = {{1.5, -2.25, 3.125}, {1000.5, 0, -0.5}, {0.001, 0.002, 0.003}};

TEST(Cloud, PlyAsText) {
  const Read read = read_bytes(
      "a.ply",
      "ply\r\nformat ascii 1.0\r\nelement camera 1\r\nproperty float f\r\nelement vertex 3\r\n"
      "property float nx\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\nelement face 1\r\n"
      "property list uchar int vertex_indices\r\nend_header\r\n50\r\n0 1.5 -2.25 3.125\r\n"
      "0 1000.5 0 -0.5\r\n0 1e-3 +0.002 0.003\r\n3 0 1 2\r\n");
  expect_near(read.points, kPoints, 1e-12);
  EXPECT_TRUE(std::isnan(read.summary.unit)) << "it says nothing of its unit";
}

TEST(Cloud, PlyBinaryInBothByteOrders) {
  for (bool big : {false, true}) {
    const Read read = read_bytes("a.ply", binary_ply(kPoints, big));
    expect_near(read.points, kPoints, 1e-9);
    EXPECT_EQ(read.summary.unit, 0.001);
    EXPECT_EQ(read.summary.low.x(), 0.001);
    EXPECT_EQ(read.summary.high.x(), 1000.5);
  }
}

TEST(Cloud, LasOfAllVersionsAndFormats) {
  const Points points = {{500012.3456, 200001.5, 103.25}, {499999, 199999.9999, 99.0001}};
  for (int minor : {1, 2, 3, 4})
    for (int format : {0, 1, 3, 6, 7, 10}) {
      LasFile file;
      file.minor = minor, file.format = format, file.extra_bytes = 5;
      expect_near(read_bytes("a.las", las_file(file, points)).points, points, 1e-8);
    }
}

TEST(Cloud, LasSaysItsUnitByKeysOrText) {
  const auto keys = [](std::uint16_t key, std::uint16_t value) {
    std::string content;
    for (int word : {1, 1, 0, 1, 0, 0, 1, 0}) content += bytes_of(static_cast<std::uint16_t>(word));
    put(content, 8, key), put(content, 14, value);
    return las_record(34735, content);
  };
  const auto unit = [](const std::string& record) {
    LasFile file;
    file.records = record, file.record_count = 1;
    return read_bytes("a.las", las_file(file, {file.offset})).summary.unit;
  };
  EXPECT_EQ(unit(keys(3076, 9001)), 1);
  EXPECT_EQ(unit(keys(3076, 9002)), 0.3048);
  EXPECT_NEAR(unit(keys(3076, 9003)), 0.3048006096, 1e-10);
  EXPECT_TRUE(std::isnan(unit(keys(3072, 25832))));
  const std::string wkt =
      R"(PROJCS["A",GEOGCS["B",UNIT["degree",0.0174532925199433]],PROJECTION["C"],UNIT["US survey foot",0.304800609601219]])";
  EXPECT_NEAR(unit(las_record(2112, wkt)), 0.304800609601219, 1e-15);
  EXPECT_THROW(unit(keys(1024, 2)), CloudError) << "degrees are no lengths";
  const std::string mixed = R"(COMPD_CS["A",PROJCS["A",UNIT["metre",1]],VERT_CS["V",UNIT["foot",0.3048]]])";
  EXPECT_THROW(unit(las_record(2112, mixed)), CloudError);
}

TEST(Cloud, LasLeavesOutWhatItWithholds) {
  LasFile file;
  std::string bytes = las_file(file, {file.offset, file.offset, file.offset});
  bytes[227 + 15] = static_cast<char>(0x80);  // withheld
  bytes[227 + 20 + 15] = 7;                   // noise
  const Read read = read_bytes("a.las", bytes);
  EXPECT_EQ(read.points.size(), 1U);
  EXPECT_EQ(read.summary.withheld, 2U);
}

TEST(Cloud, PtsOfTwoScans) {
  const Read read =
      read_bytes("a.pts", "2\n1.5 -2.25 3.125 -1200 10 20 30\n1000.5 0 -0.5 0 0 0 0\n1\n0.001 0.002 0.003 5 5 5 5\n");
  expect_near(read.points, kPoints, 1e-12);
  EXPECT_EQ(read.summary.format, "PTS");
}

TEST(Cloud, XyzWithSeparatorsHeaderRemarksAndWithoutLastLineEnd) {
  for (const std::string between : {" ", ",", ";", "\t", ", "}) {
    std::string text = "X" + between + "Y" + between + "Z\n# a remark\n\n";
    for (const char* row : {"1.5 -2.25 3.125", "1000.5 0 -0.5", "0.001 0.002 0.003"}) {
      std::string line = row;
      for (size_t at = line.find(' '); at != std::string::npos; at = line.find(' ', at + between.size()))
        line.replace(at, 1, between);
      text += line + "\n";
    }
    text.pop_back();
    expect_near(read_bytes("a.xyz", text).points, kPoints, 1e-12);
  }
}

TEST(Cloud, PointsWithoutPlaceAreLeftOutAndCounted) {
  const Read read = read_bytes("a.xyz", "1 2 3\nnan nan nan\n4 5 6\ninf 0 0\n");
  EXPECT_EQ(read.points.size(), 2U);
  EXPECT_EQ(read.summary.without_place, 2U);
  const Points holes = {{1, 2, 3}, Eigen::Vector3d::Constant(std::nan(""))};
  EXPECT_EQ(read_bytes("a.ply", binary_ply(holes, false)).summary.without_place, 1U);
}

TEST(Cloud, ManyPointsComeInPieces) {
  Points points;
  for (int i = 0; i < 150000; ++i) points.push_back({500000.0 + 0.001 * i, 200000, 100});
  expect_near(read_bytes("a.las", las_file({}, points)).points, points, 1e-8);
}

}  // namespace
}  // namespace plumbline::cloud
