// dense.import: units, frames and registrations of scans.
#include <gtest/gtest.h>

#include <cmath>

#include "artifacts/design.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/surface_points.hpp"
#include "artifacts/surfaces.hpp"
#include "artifacts/transform.hpp"
#include "cloud_bytes.hpp"
#include "node_harness.hpp"
#include "surface_artifact.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::test;
using Places = std::vector<Eigen::Vector3d>;

/// Two panels of 1.5 m x 3 m to the south, the middle of their faces at (120, 80, 10) and (121.52, 80, 10).
DesignT two_panels() {
  DesignT design;
  design.facade_normal = Eigen::Vector3d::Constant(std::nan(""));
  design.site_origin = design.facade_normal;
  for (int i : {0, 1}) {
    auto element = std::make_unique<DesignElementT>();
    element->guid = "guid-" + std::to_string(i), element->name = "P" + std::to_string(i + 1),
    element->class_ = "IfcPlate";
    element->is_panel = true;
    element->placement = {Eigen::Quaterniond::Identity(), {120 + 1.52 * i, 80, 10}};
    element->position = element->placement.translation;
    element->box_low = {-0.75, 0, -1.5}, element->box_high = {0.75, 0.05, 1.5};
    element->facade = std::make_unique<FacadeFrameT>();
    element->facade->out = {0, -1, 0}, element->facade->up = {0, 0, 1}, element->facade->right = {1, 0, 0};
    element->facade->confirmed = true, element->facade->source = "own_axes";
    design.elements.push_back(std::move(element));
  }
  return design;
}

/// The first panel stands 4 mm further out than designed; other things lie around it.
Places scan() {
  Places points;
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) points.push_back({119.3 + 0.0237 * i, 79.996, 8.55 + 0.0487 * j});
  for (int i = 0; i < 500; ++i) points.push_back({110.0 + 0.05 * i, 70, 8});
  return points;
}

std::string xyz(const Places& points, double scale) {
  std::string text;
  for (const auto& p : points) {
    char line[120];
    std::snprintf(line, sizeof line, "%.6f %.6f %.6f 17\n", scale * p.x(), scale * p.y(), scale * p.z());
    text += line;
  }
  return text;
}

struct Import {
  TemporaryFolder folder;
  NodeHarness node{"dense.import"};
  Import(const std::string& name, const std::string& bytes) {
    const std::string path = (folder.path() / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    node.set("file", path);
    node.input<Design>("design", two_panels());
  }
  std::string refusal() {
    try {
      node.run();
    } catch (const NodeFailed& error) {
      return error.what();
    }
    return "(read)";
  }
  /// Mean of y of the points that were kept.
  double place() {
    node.run();
    const auto points = stated_points(node.output<SurfacePoints>("surface"), node.output<Folder>("files").uri);
    EXPECT_EQ(points.size(), 3600U);
    double sum = 0;
    for (const StatedPoint& point : points) sum += point.place.y();
    return sum / static_cast<double>(points.size());
  }
};

void expect_refused(Import& import, const std::string& because) {
  const std::string found = import.refusal();
  EXPECT_NE(found.find(because), std::string::npos) << found;
}

TEST(ImportNode, KeepsThePointsOfTheFacesAndSaysWhichPartsHaveNone) {
  Import import("scan.xyz", xyz(scan(), 1));
  EXPECT_NEAR(import.place(), 79.996, 1e-6);
  const auto surface = import.node.output<SurfacePoints>("surface");
  EXPECT_EQ(surface.source, "scan");
  EXPECT_EQ(surface.rank, 0) << "nobody said how well the scan is registered";
  ASSERT_EQ(surface.holes.size(), 1U);
  EXPECT_EQ(surface.holes[0]->count, 18) << "the second panel's tiles of half a metre";
  ASSERT_FALSE(import.node.warnings().empty());
  EXPECT_NE(import.node.warnings()[0].find("does not say its unit"), std::string::npos);
}

TEST(ImportNode, FeetAndMillimetresAreToldOrFound) {
  for (const auto& [unit, metres] :
       {std::pair<const char*, double>{"ft", 0.3048}, {"mm", 0.001}, {"us_ft", 1200.0 / 3937}}) {
    Import silent("scan.xyz", xyz(scan(), 1 / metres));
    if (std::string(unit) != "us_ft") expect_refused(silent, std::string("set unit: ") + unit);
    Import told("scan.xyz", xyz(scan(), 1 / metres));
    told.node.set("unit", unit);
    EXPECT_NEAR(told.place(), 79.996, 1e-5) << unit;
  }
  // A LAS file that says feet is read in feet, and contradicted by nobody.
  std::string content;
  for (int word : {1, 1, 0, 1, 3076, 0, 1, 9002}) content += cloud_bytes::bytes_of(static_cast<std::uint16_t>(word));
  cloud_bytes::LasFile file;
  file.offset = {0, 0, 0}, file.records = cloud_bytes::las_record(34735, content), file.record_count = 1;
  Places feet = scan();
  for (auto& point : feet) point /= 0.3048;
  const std::string las = cloud_bytes::las_file(file, feet);
  Import said("scan.las", las);
  EXPECT_NEAR(said.place(), 79.996, 1e-4);
  Import contradicted("scan.las", las);
  contradicted.node.set("unit", "m");
  expect_refused(contradicted, "the file says that its coordinates are in ft");
}

TEST(ImportNode, AnotherFrameIsNamedWithBothPlaces) {
  Places moved = scan();
  for (auto& point : moved) point += Eigen::Vector3d(500, 0, 0);
  Import import("scan.xyz", xyz(moved, 1));
  expect_refused(import, "is it in another frame?");
}

TEST(ImportNode, ARegistrationMovesTheScanAndItsCovarianceIsCommonToAllPoints) {
  TransformT registration;
  registration.to_from_from = {quaternion_from_rotation_vector({0, 0, 0.3}), {120, 80, 0}};
  registration.scale = 1;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c <= r; ++c) registration.covariance.push_back(r != c ? 0 : r < 3 ? 1e-10 : 4e-6);
  Places own = scan();
  for (auto& point : own) point = registration.to_from_from.inverse() * point;
  Import import("scan.xyz", xyz(own, 1));
  import.node.input<Transform>("registration", registration);
  EXPECT_NEAR(import.place(), 79.996, 1e-5);
  const auto surface = import.node.output<SurfacePoints>("surface");
  EXPECT_EQ(surface.rank, 6);
  const auto points = stated_points(surface, import.node.output<Folder>("files").uri);
  // 2 mm of place, and 1e-5 rad at 10 m above the registration's origin.
  const double out = points[0].by_common_errors.row(1).norm();
  EXPECT_NEAR(out, std::hypot(0.002, 1e-5 * (points[0].place - Eigen::Vector3d(120, 80, 0)).norm()), 1e-6);
  // Two points a metre apart go the same way.
  EXPECT_LT((points.front().by_common_errors - points.back().by_common_errors).norm(), 1e-4);
}

TEST(ImportNode, ThePanelsOfAScan) {
  Import import("scan.xyz", xyz(scan(), 1));
  import.node.set("place_sigma", "0.0015");
  import.node.run();
  NodeHarness panels("surface.panels");
  panels.input<SurfacePoints>("surface", import.node.output<SurfacePoints>("surface"));
  panels.run();
  const auto surfaces = panels.output<Surfaces>("surfaces");
  ASSERT_EQ(surfaces.panels.size(), 2U);
  EXPECT_EQ(surfaces.panels[0]->not_measured, "");
  EXPECT_NEAR(surfaces.panels[0]->offset, 0.004, 1e-5);
  EXPECT_NEAR(std::sqrt(surfaces.panels[0]->covariance[0]), 0.0015, 5e-5)
      << "3600 points do not make the registration better";
  EXPECT_EQ(surfaces.panels[1]->not_measured, "no point was measured on it");
}

}  // namespace
