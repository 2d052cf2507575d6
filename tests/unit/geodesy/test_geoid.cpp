// Geoid heights from a grid and from constants. egm96_15.gtx comes with PROJ (proj-data).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "geometry/geodesy/geoid.hpp"

namespace plumbline::geodesy {
namespace test_geoid {

constexpr double kDegree = std::numbers::pi / 180, kSecond = kDegree / 3600;
constexpr const char* kEgm96 = "/usr/share/proj/egm96_15.gtx";

/// A file of its own for each test, gone afterwards.
struct File {
  std::filesystem::path path;
  explicit File(const std::string& name) : path(std::filesystem::temp_directory_path() / name) {}
  ~File() { std::filesystem::remove(path); }
};

void put(std::ofstream& out, const void* value, size_t size) {  // big endian
  const auto* bytes = static_cast<const char*>(value);
  for (size_t i = size; i-- > 0;) out.put(bytes[i]);
}

/// .gtx: south-west corner and steps in degrees, rows and columns, heights row by row from the south.
template <class Height>
void write_gtx(const std::filesystem::path& path, double south, double west, double step, int32_t rows, int32_t columns,
               const Height& height) {
  std::ofstream out(path, std::ios::binary);
  for (const double value : {south, west, step, step}) put(out, &value, 8);
  for (const int32_t value : {rows, columns}) put(out, &value, 4);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const auto value = static_cast<float>(height(south + r * step, west + c * step));
      put(out, &value, 4);
    }
}

std::string error_of(const std::string& path, const Place& at) {
  try {
    GeoidGrid(path).height(at);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

/// Heights that NGA publishes to check programs with (EGM96, F477). The grid has a node each quarter of a degree.
TEST(GeoidGrid, HasThePublishedHeightsOfEgm96) {
  if (!std::filesystem::exists(kEgm96)) GTEST_SKIP() << kEgm96 << " is not there";
  const GeoidGrid grid(kEgm96);
  const auto at = [&](double latitude, double longitude) {
    return grid.height({latitude * kDegree, longitude * kDegree});
  };
  EXPECT_NEAR(at(38.6281550, 269.7791550 - 360), -31.628, 0.15);
  EXPECT_NEAR(at(-14.6212170, 305.0211140 - 360), -2.969, 0.15);
  EXPECT_NEAR(at(46.8743190, 102.4487290), -43.575, 0.15);
  EXPECT_NEAR(at(-23.6174460, 133.8747120), 15.871, 0.15);
  EXPECT_NEAR(at(-0.4667440, 0.0023000), 17.329, 0.15);
}

TEST(GeoidGrid, GivesItsNodesItsSlopeAndItsBorder) {
  const File file("plumbline geoid of a test.gtx");  // with blanks
  write_gtx(file.path, 47, 10, 0.1, 11, 11, [](double b, double l) { return 47.5 + 2 * (b - 47.5) - (l - 10.5); });
  const auto grid = std::make_shared<const GeoidGrid>(file.path.string());
  const Geoid geoid(grid);
  const Place middle{47.5 * kDegree, 10.5 * kDegree};
  EXPECT_NEAR(geoid.height(middle), 47.5, 1e-5);
  EXPECT_NEAR(geoid.height({47.53 * kDegree, 10.46 * kDegree}), 47.6, 1e-5);
  // 2 m a degree to the north, -1 m to the east: the plumb line leans the other way.
  const double degree = 6371000 * kDegree;
  EXPECT_NEAR(geoid.deflection(middle).x() / kSecond, -2 / degree / kSecond, 0.01);
  EXPECT_NEAR(geoid.deflection(middle).y() / kSecond, 1 / (degree * std::cos(middle.latitude)) / kSecond, 0.01);
  const std::string outside = error_of(file.path, {50 * kDegree, 10.5 * kDegree});
  EXPECT_NE(outside.find("is not in the geoid grid"), std::string::npos) << outside;
  EXPECT_NE(error_of("/nowhere/geoid.gtx", middle).find("/nowhere/geoid.gtx cannot be read"), std::string::npos);
  const File text("plumbline_no_geoid.gtx");
  std::ofstream(text.path) << "no grid";
  EXPECT_NE(error_of(text.path, middle).find("cannot be read"), std::string::npos) << error_of(text.path, middle);
}

TEST(Geoid, OfConstantsIsAPlane) {
  const Place middle{47.5 * kDegree, 10.5 * kDegree};
  const Geoid geoid(47.5, kSecond * Eigen::Vector2d(10, -5), middle);
  EXPECT_NEAR(geoid.height(middle), 47.5, 1e-12);
  const double kilometre = 1000.0 / 6371000;
  EXPECT_NEAR(geoid.height({middle.latitude + kilometre, middle.longitude}), 47.5 - 10 * kSecond * 1000, 1e-6);
  EXPECT_NEAR(geoid.height({middle.latitude, middle.longitude + kilometre / std::cos(middle.latitude)}),
              47.5 + 5 * kSecond * 1000, 1e-6);
  EXPECT_FALSE(Geoid().has_deflection());
  EXPECT_TRUE(geoid.has_deflection());
}

}  // namespace test_geoid
}  // namespace plumbline::geodesy
