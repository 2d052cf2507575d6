// Files that are cut short, that announce what they do not have, that are something else: refused with name and place.
#include <gtest/gtest.h>

#include <fstream>

#include "cloud_bytes.hpp"
#include "surface/cloud/cloud_file.hpp"
#include "test_support.hpp"

namespace plumbline::cloud {
namespace test_bad_cloud {

using namespace plumbline::cloud_bytes;

std::string refusal(const std::string& name, const std::string& bytes) {
  const plumbline::test::TemporaryFolder folder;
  const std::string path = (folder.path() / name).string();
  std::ofstream(path, std::ios::binary) << bytes;
  try {
    read_cloud(path, [](const std::vector<Eigen::Vector3d>&, double, int) {});
  } catch (const CloudError& error) {
    EXPECT_EQ(std::string(error.what()).find(name), 0U) << error.what();
    return error.what();
  }
  return "(read)";
}

void expect_refused(const std::string& name, const std::string& bytes, const std::string& because) {
  const std::string found = refusal(name, bytes);
  EXPECT_NE(found.find(because), std::string::npos) << found;
}

std::string text_ply(const std::string& count, const std::string& body) {
  return "ply\nformat ascii 1.0\nelement vertex " + count +
         "\nproperty float x\nproperty float y\nproperty float z\nend_header\n" + body;
}

const std::vector<Eigen::Vector3d> kTwo = {{500000, 200000, 100}, {500001, 200000, 100}};

TEST(BadCloud, ABillionPointsInAHundredBytes) {
  expect_refused("a.ply",
                 "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\nproperty float x\nproperty float "
                 "y\nproperty float z\nend_header\n12345678",
                 "1000000000 vertices of 12 bytes are announced, the file of");
  expect_refused("a.ply", text_ply("1000000000", "1 2 3\n"),
                 "line 8: 1000000000 vertices are announced, the file ends after 1");
  expect_refused("a.pts", "1000000000\n1 2 3\n", "line 1: 1000000000 points are announced");
  std::string las = las_file({}, kTwo);
  put(las, 107, std::uint32_t{1000000000});
  expect_refused(
      "a.las", las,
      "byte 107: 1000000000 points of 20 bytes from byte 227 on are announced, the file of 267 bytes has room for 2");
  LasFile file;
  file.minor = 4;
  las = las_file(file, kTwo);
  put(las, 247, std::uint64_t{0xFFFFFFFFFFFFFFFF});
  expect_refused("a.las", las, "has room for 2");
}

/// A wall of 20 m at a scale of 1e-9: 32 bits hold 4.3 m of it, and the rest lies folded onto these.
TEST(BadCloud, CoordinatesThatDoNotFitTheirBits) {
  std::vector<Eigen::Vector3d> wall;
  for (int i = 0; i < 2000; ++i) wall.push_back({500000 + 0.01 * i, 200000, 100 + 0.001 * (i % 1000)});
  LasFile file;
  file.scale = 1e-9;
  const std::string wrapped = las_file(file, wall);  // lround, and the lower 32 bits of it
  expect_refused("a.las", wrapped, "byte 131: at a scale of 1e-09 the coordinates x take 100 % of what 32 bits hold");
  file.with_box = true;
  expect_refused("a.las", las_file(file, wall), "outside of the box from (500000.000, 200000.000, 100.000) to");
  std::string stopped = wrapped;
  for (size_t i = 0; i < wall.size(); ++i)
    put(stopped, 227 + 20 * i,
        static_cast<std::int32_t>(std::min<std::int64_t>(std::llround(1e7 * static_cast<double>(i)), 2147483647)));
  expect_refused("a.las", stopped, "and 1785 of 2000 points are at the end");
  // The same wall at a fitting scale; a program that takes the finest that holds it; and one point at the limit.
  file.scale = 1e-4;
  EXPECT_EQ(refusal("a.las", las_file(file, wall)), "(read)");
  file.scale = 19.99 / 2147483647;
  EXPECT_EQ(refusal("a.las", las_file(file, wall)), "(read)");
}

TEST(BadCloud, PointsOutsideOfTheHeadersOwnBox) {
  LasFile file;
  file.with_box = true;
  std::vector<Eigen::Vector3d> points = {{500000, 200000, 100}, {500010, 200000, 104}, {500004, 200000, 103}};
  std::string las = las_file(file, points);
  EXPECT_EQ(refusal("a.las", las), "(read)");
  put(las, 227 + 2 * 20, std::int32_t{104000});
  expect_refused("a.las", las,
                 "byte 267: point 3 lies at (500010.400, 200000.000, 103.000), outside of the box from (500000.000, "
                 "200000.000, 100.000) to (500010.000, 200000.000, 104.000)");
  put(las, 227 + 2 * 20, std::int32_t{100005});
  EXPECT_EQ(refusal("a.las", las), "(read)") << "half a millimetre: the box is rounded";
  las[227 + 2 * 20 + 15] = static_cast<char>(0x80);
  put(las, 227 + 2 * 20, std::int32_t{104000});
  EXPECT_EQ(refusal("a.las", las), "(read)") << "what the file says not to use may lie anywhere";
}

/// As in laspy's simple1_3.las: the box in the whole numbers of the records. One that fits neither is refused as
/// before.
TEST(BadCloud, AHeadersBoxWithoutScaleAndOffset) {
  const std::vector<Eigen::Vector3d> points = {{500001, 200000, 100}, {500010, 200003, 104}, {500004, 200002, 103}};
  std::string las = las_file(LasFile{}, points);
  const double low[] = {10000, 0, 0}, high[] = {100000, 30000, 40000};
  for (size_t axis = 0; axis < 3; ++axis) put(las, 179 + 16 * axis, high[axis]), put(las, 187 + 16 * axis, low[axis]);
  EXPECT_EQ(refusal("a.las", las), "(read)");
  put(las, 227 + 2 * 20, std::int32_t{104000});
  expect_refused("a.las", las, "point 3 lies at (500010.400, 200002.000, 103.000), outside of the box");
}

TEST(BadCloud, NoPoints) {
  expect_refused("a.las", las_file({}, {}), "announces no points");
  expect_refused("a.ply", text_ply("0", ""), "announces no points");
  expect_refused("a.pts", "0\n", "there is no point in it");
  expect_refused("a.xyz", "# nothing\n", "there is no point in it");
  expect_refused("a.xyz", "", "the file is empty");
  expect_refused("a.xyz", "nan nan nan\n", "none of its 1 points has coordinates");
  std::string withheld = las_file({}, {kTwo[0]});
  withheld[227 + 15] = 7;
  expect_refused("a.las", withheld, "withheld or noise");
  EXPECT_THROW(read_cloud("/nowhere/a.las", [](const std::vector<Eigen::Vector3d>&, double, int) {}), CloudError);
}

TEST(BadCloud, OtherFormatsSayWhatToDo) {
  expect_refused("a.pcd", "# .PCD v0.7\n", "PCD file");
  std::string laz = las_file({}, kTwo);
  laz[104] = static_cast<char>(0x80 | 3);
  expect_refused("a.laz", laz, "byte 104: the points are compressed (LAZ)");
  expect_refused("a.xyz", std::string("\x01\x00\x02 1 2", 7), "line 1");
  expect_refused("a.xyz", "1,5 2,5 3,5\n", "decimal commas");
  expect_refused("a.xyz", "hello\n", "line 1: found 'hello'");
  expect_refused("a.xyz", "1 2 3\n4 5\n", "line 2");
  expect_refused("a.xyz", "1 2 3\nx y z\n", "line 2");
  expect_refused("a.pts", "1\n1 2 3\n4 5 6\n", "line 3: more points than the 1");
  expect_refused("a.ptx",
                 "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n4 5 6 0.5\n",
                 "line 2: two whole numbers, 2 and 1, at the start of a scan: this is a PTX file");
  expect_refused("a.xyz", "Punkt Rechts Hoch Kote\n7 1 2 3\n",
                 "line 1: the columns are named 'Punkt Rechts Hoch Kote'");
  expect_refused("a.xyz", "x x y z\n7 1 2 3\n", "line 1: the columns are named");
}

TEST(BadCloud, HeadersThatContradictThemselves) {
  std::string las = las_file({}, kTwo);
  std::string broken = las;
  put(broken, 131, 0.0);
  expect_refused("a.las", broken, "byte 131: the scale");
  broken = las;
  put(broken, 155, std::nan(""));
  expect_refused("a.las", broken, "byte 155");
  broken = las;
  broken[25] = 9;
  expect_refused("a.las", broken, "byte 24: LAS version 1.9");
  broken = las;
  put(broken, 105, std::uint16_t{7});
  expect_refused("a.las", broken, "byte 105: records of 7 bytes");
  broken = las;
  put(broken, 100, std::uint32_t{4000000000});
  expect_refused("a.las", broken, "byte 100: 4000000000 records");
  broken = las;
  put(broken, 96, std::uint32_t{100000});
  expect_refused("a.las", broken, "byte 94");
  expect_refused("a.ply",
                 "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n",
                 "no property 'z'");
  expect_refused("a.ply",
                 "ply\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n",
                 "no 'format' line");
  expect_refused("a.ply", "ply\nformat ascii 1.0\nelement vertex -3\n", "line 3");
  expect_refused("a.ply", "ply\nformat ascii 1.0\nwhat is this\n", "line 3");
}

/// Every file cut at every byte: refused or read, never worse.
TEST(BadCloud, CutAnywhere) {
  LasFile file;
  file.minor = 4, file.format = 6;
  file.records = las_record(2112, R"(PROJCS["A",UNIT["metre",1]])"), file.record_count = 1;
  const std::pair<std::string, std::string> whole[] = {{"a.las", las_file(file, kTwo)},
                                                       {"a.ply", binary_ply(kTwo, true)},
                                                       {"b.ply", text_ply("2", "1 2 3\n4 5 6\n")},
                                                       {"a.pts", "2\n1 2 3\n4 5 6\n"}};
  for (const auto& [name, bytes] : whole) {
    EXPECT_EQ(refusal(name, bytes), "(read)");
    for (size_t size = 0; size + 7 < bytes.size(); ++size)
      EXPECT_NE(refusal(name, bytes.substr(0, size)), "(read)") << name << " cut at " << size;
  }
}

}  // namespace test_bad_cloud
}  // namespace plumbline::cloud
