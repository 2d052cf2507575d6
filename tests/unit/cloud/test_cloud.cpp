// Points of every format come back where they were put, with what the file says of its unit.
#include <gtest/gtest.h>

#include <array>
#include <fstream>

#include "cloud_bytes.hpp"
#include "surface/cloud/cloud_file.hpp"
#include "surface/cloud/cloud_writer.hpp"
#include "test_support.hpp"

namespace plumbline::cloud {
namespace test_cloud {

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
  read.summary = read_cloud(path, [&](const Points& some, double done, int scan) {
    EXPECT_GE(scan, 0);
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
  LasFile heights;
  heights.records = keys(4099, 9002), heights.record_count = 1;
  const CloudSummary of_heights = read_bytes("a.las", las_file(heights, {heights.offset})).summary;
  EXPECT_TRUE(std::isnan(of_heights.unit)) << "of the plan it says nothing";
  EXPECT_EQ(of_heights.unit_of_heights, 0.3048);
  const std::string wkt =
      R"(PROJCS["A",GEOGCS["B",UNIT["degree",0.0174532925199433]],PROJECTION["C"],UNIT["US survey foot",0.304800609601219]])";
  EXPECT_NEAR(unit(las_record(2112, wkt)), 0.304800609601219, 1e-15);
  EXPECT_THROW(unit(keys(1024, 2)), CloudError) << "degrees are no lengths";
  const std::string mixed = R"(COMPD_CS["A",PROJCS["A",UNIT["metre",1]],VERT_CS["V",UNIT["foot",0.3048]]])";
  EXPECT_THROW(unit(las_record(2112, mixed)), CloudError);
}

/// Unit by a WKT, of each point's own axes: before the points or, in LAS 1.4, behind them.
Read with_wkt(const std::string& wkt, bool behind) {
  LasFile file;
  file.minor = 4, file.format = 6;
  if (!behind) file.records = las_record(2112, wkt), file.record_count = 1;
  std::string bytes = las_file(file, {file.offset});
  if (behind) {
    std::string record(60, '\0');
    std::memcpy(record.data() + 2, "LASF_Projection", 15);
    put(record, 18, std::uint16_t{2112}), put(record, 20, static_cast<std::uint64_t>(wkt.size()));
    put(bytes, 235, static_cast<std::uint64_t>(bytes.size())), put(bytes, 243, std::uint32_t{1});
    bytes += record + wkt;
  }
  return read_bytes("a.las", bytes);
}

TEST(Cloud, LasTakesTheUnitOfTheAxesAndNotOfTheEllipsoid) {
  const std::string base =
      R"w(BASEGEOGCRS["NAD83",DATUM["D",ELLIPSOID["GRS 1980",6378137,298.257222101,LENGTHUNIT["metre",1]]],)w"
      R"w(PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]]],)w"
      R"w(CONVERSION["C",METHOD["Transverse Mercator"],PARAMETER["False easting",500000,LENGTHUNIT["metre",1]]],)w"
      R"w(CS[Cartesian,2],)w";
  const std::string foot = R"w(LENGTHUNIT["US survey foot",0.304800609601219])w";
  const std::string at_the_end = R"w(PROJCRS["New York Long Island (ftUS)",)w" + base +
                                 R"w(AXIS["easting (X)",east,ORDER[1]],AXIS["northing (Y)",north,ORDER[2]],)w" + foot +
                                 "]";
  const std::string by_axis = R"w(PROJCRS["New York",)w" + base + R"w(AXIS["easting (X)",east,ORDER[1],)w" + foot +
                              R"w(],AXIS["northing (Y)",north,ORDER[2],)w" + foot + "]]";
  for (const bool behind : {false, true})
    for (const std::string& wkt : {at_the_end, by_axis})
      EXPECT_NEAR(with_wkt(wkt, behind).summary.unit, 0.304800609601219, 1e-15) << behind << wkt;
  const std::string heights = R"w(,VERTCRS["NAVD88",VDATUM["N"],CS[vertical,1],AXIS["up (H)",up],)w";
  EXPECT_NEAR(with_wkt(R"w(COMPOUNDCRS["both",)w" + at_the_end + heights + foot + "]]", false).summary.unit,
              0.304800609601219, 1e-15);
  EXPECT_THROW(
      with_wkt(R"w(COMPOUNDCRS["both",)w" + at_the_end + heights + R"w(LENGTHUNIT["metre",1])w" + std::string("]]"),
               false),
      CloudError)
      << "plan in feet, heights in metres";
  const std::string degrees =
      R"w(GEODCRS["WGS 84",DATUM["W",ELLIPSOID["WGS 84",6378137,298.257223563,LENGTHUNIT["metre",1]]],)w"
      R"w(CS[ellipsoidal,2],AXIS["latitude",north],AXIS["longitude",east],ANGLEUNIT["degree",0.0174532925199433]])w";
  for (const bool behind : {false, true}) EXPECT_THROW(with_wkt(degrees, behind), CloudError) << behind;
  EXPECT_TRUE(std::isnan(with_wkt("PROJCRS[[[[\"", false).summary.unit)) << "no WKT at all";
}

TEST(Cloud, StepsThatCoordinatesAreWrittenIn) {
  const auto steps = [](const std::string& name, const std::string& bytes) {
    return read_bytes(name, bytes).summary.resolution;
  };
  const Points national = {{350123.456, 5600321.123, 81.25}, {350124.789, 5600322.789, 82.75}};
  LasFile las;
  las.scale = 0.01, las.offset = {350000, 5600000, 0};
  EXPECT_EQ(steps("a.las", las_file(las, national)), Eigen::Vector3d::Constant(0.01));
  const Eigen::Vector3d ply = steps("a.ply", binary_ply(national, false));  // x double, y and z float
  EXPECT_EQ(ply.x(), 0);
  EXPECT_EQ(ply.y(), 0.5) << "a 32-bit float at 5600 km";
  const Eigen::Vector3d text = steps("a.xyz", "350123.45 5600321.1 81.250\n350124.7 5600322 8.2751e1\n");
  EXPECT_NEAR(text.x(), 0.01, 1e-15);
  EXPECT_NEAR(text.y(), 0.1, 1e-15);
  EXPECT_NEAR(text.z(), 0.001, 1e-15);
  // Floats that a program has written out with six decimals, or as doubles, are no finer for it.
  EXPECT_EQ(steps("a.xyz", "350123.468750 1.5 1\n350124.781250 1.6 2\n").x(), 0.03125);
  const Points floats = {{350123.46875, 1, 1}, {350124.78125, 1, 1}};
  EXPECT_EQ(steps("a.ply", binary_ply(floats, false)).x(), 0.03125);
}

TEST(Cloud, LasLeavesOutWhatItWithholds) {
  LasFile file;
  std::string bytes = las_file(file, {file.offset, file.offset, file.offset});
  bytes[227 + 15] = static_cast<char>(0x80);  // withheld
  bytes[227 + 20 + 15] = 7;                   // noise
  const Read read = read_bytes("a.las", bytes);
  EXPECT_EQ(read.points.size(), 1U);
  EXPECT_EQ(read.summary.withheld, 2U);
  // Formats from 6 on have their flags in another byte, and classes of their own.
  file.minor = 4, file.format = 6;
  bytes = las_file(file, Points(4, file.offset));
  bytes[375 + 15] = 0x04;           // withheld
  bytes[375 + 30 + 16] = 18;        // high noise
  bytes[375 + 2 * 30 + 15] = 0x08;  // overlap: to be used
  EXPECT_EQ(read_bytes("a.las", bytes).points.size(), 2U);
}

TEST(Cloud, LasCountsItsScansByTheirSource) {
  for (const auto& [minor, format, header, record, at] :
       {std::array{2, 0, 227, 20, 18}, std::array{4, 6, 375, 30, 20}}) {
    LasFile file;
    file.minor = minor, file.format = format;
    std::string bytes = las_file(file, Points(3, file.offset));
    EXPECT_EQ(read_bytes("a.las", bytes).summary.scans, 1);
    put(bytes, static_cast<size_t>(header + 2 * record + at), std::uint16_t{7});
    EXPECT_EQ(read_bytes("a.las", bytes).summary.scans, 2) << format;
  }
}

TEST(Cloud, LasOfTwoCountsThatAgree) {
  LasFile file;
  file.minor = 4;
  std::string bytes = las_file(file, {file.offset, file.offset});
  put(bytes, 107, std::uint32_t{2});  // as files of 1.4 for older readers have it
  EXPECT_EQ(read_bytes("a.las", bytes).points.size(), 2U);
  put(bytes, 247, std::uint64_t{0});
  EXPECT_EQ(read_bytes("a.las", bytes).points.size(), 2U);
  put(bytes, 247, std::uint64_t{1});
  EXPECT_THROW(read_bytes("a.las", bytes), CloudError) << "2 points at byte 107, 1 at byte 247";
}

TEST(Cloud, PtsOfTwoScans) {
  const Read read =
      read_bytes("a.pts", "2\n1.5 -2.25 3.125 -1200 10 20 30\n1000.5 0 -0.5 0 0 0 0\n1\n0.001 0.002 0.003 5 5 5 5\n");
  expect_near(read.points, kPoints, 1e-12);
  EXPECT_EQ(read.summary.format, "PTS");
  EXPECT_EQ(read.summary.scans, 2);
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

TEST(Cloud, XyzInTheUnitOfItsColumns) {
  const auto unit = [](const std::string& head) { return read_bytes("a.xyz", head + "\n1 2 3\n").summary; };
  EXPECT_EQ(unit("X[ft],Y[ft],Z[ft]").unit, 0.3048);
  EXPECT_TRUE(unit("X[ft],Y[ft],Z[ft]").either_foot);
  EXPECT_EQ(unit("//X (mm) Y (mm) Z (mm)").unit, 0.001);
  EXPECT_TRUE(std::isnan(unit("x y z").unit));
  EXPECT_THROW(unit("X[m] Y[m] Z[ft]"), CloudError);
}

TEST(Cloud, XyzByTheNamesOfItsColumns) {
  const Points one = {{1.5, 2.5, 3.5}};
  for (const char* text :
       {"Row Column X Y Z\n7 8 1.5 2.5 3.5\n", "id,x,y,z\n7,1.5,2.5,3.5\n", "Northing Easting Height\n2.5 1.5 3.5\n",
        "\"N\";\"E\";\"H\"\n2.5;1.5;3.5\n", "//Nx Ny Nz X Y Z\n0 0 1 1.5 2.5 3.5\n",
        "Easting[m] Northing[m] Elevation[m]\n1.5 2.5 3.5\n", "X [m] Y [m] Z [m] Intensity\n1.5 2.5 3.5 206\n",
        "# 2026-05-12 scanner x y z exported\n1.5 2.5 3.5\n",
        "\xEF\xBB\xBF"
        "1.5 2.5 3.5\n",
        "\xEF\xBB\xBFX Y Z\n1.5 2.5 3.5\n"})
    expect_near(read_bytes("a.xyz", text).points, one, 1e-12);
}

/// Numbers of points taken for x: once the scan was said to be in another frame.
TEST(Cloud, AFirstColumnThatCountsThePointsIsNoCoordinate) {
  const auto numbered = [](int count, const char* head, double step) {
    std::string text = head;
    for (int i = 0; i < count; ++i)
      text += std::to_string(step * i) + " " + std::to_string(1.5 + 0.01 * (i % 7)) + " 2.5 3.5\n";
    return text;
  };
  for (const int count : {12, 500}) {
    try {
      read_bytes("a.xyz", numbered(count, "", 1));
      ADD_FAILURE() << count;
    } catch (const CloudError& error) {
      EXPECT_NE(std::string(error.what()).find("the first column counts the points"), std::string::npos)
          << error.what();
    }
  }
  EXPECT_EQ(read_bytes("a.xyz", numbered(500, "index x y z\n", 1)).points.at(0), Eigen::Vector3d(1.5, 2.5, 3.5));
  EXPECT_EQ(read_bytes("a.xyz", numbered(500, "", 0.5)).points.size(), 500U) << "a row of points, and its colour";
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

TEST(CloudWriter, WhatIsWrittenComesBackInMetres) {
  const plumbline::test::TemporaryFolder folder;
  const Points points = {{352118.25, 5810443.5, 34.0001}, {352118.3333, 5810440.25, 33.5}, {352000.5, 5810443, -2}};
  for (const auto& [format, name, step] :
       {std::tuple(CloudFormat::las, "a.las", 5.1e-5), {CloudFormat::ply, "a.ply", 0.0}}) {
    const std::string path = (folder.path() / name).string();
    CloudWriter writer(path, format, points.size(), points[1], "grid of the site");
    for (const Eigen::Vector3d& point : points) writer.add(point, 0.0003f);
    writer.finish();
    Points found;
    const CloudSummary read =
        read_cloud(path, [&](const Points& some, double, int) { found.insert(found.end(), some.begin(), some.end()); });
    expect_near(found, points, step);
    EXPECT_EQ(read.unit, 1) << name;
    EXPECT_EQ(read.scans, 1) << name;
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    EXPECT_NE(bytes.find("grid of the site"), std::string::npos) << name << " names the frame";
    EXPECT_EQ(bytes.find("EAST"), std::string::npos) << name << ": nobody said which way its axes point";
  }
}

TEST(CloudWriter, WhatDoesNotFitIsRefused) {
  const plumbline::test::TemporaryFolder folder;
  const std::string path = (folder.path() / "a.las").string();
  CloudWriter writer(path, CloudFormat::las, 2, {0, 0, 0}, "");
  EXPECT_THROW(writer.add({3e5, 0, 0}, 0), CloudError) << "beyond 32 bits of steps";
  EXPECT_THROW(writer.add({std::nan(""), 0, 0}, 0), CloudError);
  CloudWriter shorter(path, CloudFormat::las, 2, {0, 0, 0}, "");
  shorter.add({1, 2, 3}, 0);
  EXPECT_THROW(shorter.finish(), CloudError) << "two were announced";
  EXPECT_THROW(CloudWriter(path, CloudFormat::las, 1, {0, 0, 0}, "a \"name\""), CloudError) << "WKT would end there";
  EXPECT_THROW(CloudWriter("/nowhere/a.las", CloudFormat::las, 1, {0, 0, 0}, ""), CloudError);
}

}  // namespace test_cloud
}  // namespace plumbline::cloud
