// dense.import: units, frames and registrations of scans.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "artifacts/design.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/surface_points.hpp"
#include "artifacts/surfaces.hpp"
#include "artifacts/transform.hpp"
#include "cloud_bytes.hpp"
#include "e57_bytes.hpp"
#include "node_harness.hpp"
#include "stopping.hpp"
#include "surface_artifact.hpp"

namespace test_import_node {

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

/// Floats five thousand kilometres from the origin are half a metre apart: no other frame mends that.
TEST(ImportNode, StepsThatTakeAScanOffItsFacesAreNamed) {
  std::string text;
  for (const auto& point : scan())
    text += std::to_string(0.5 * std::round(2 * point.x())) + " " + std::to_string(std::lround(point.y())) + ".5 " +
            std::to_string(0.5 * std::round(2 * point.z())) + "\n";
  Import import("scan.xyz", text);
  import.node.set("unit", "m");
  expect_refused(import, "its coordinates are written in steps of");
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

TEST(ImportNode, ARegistrationWithScaleAndItsCovariance) {
  TransformT registration;
  registration.to_from_from = {quaternion_from_rotation_vector({0, 0, 0.3}), {100, 80, 0}};
  registration.scale = 1.002;
  Eigen::Matrix<double, 7, 1> sigma;
  sigma << 1e-6, 1e-6, 1e-6, 1e-3, 1e-3, 1e-3, 5e-5;
  for (int r = 0; r < 7; ++r)
    for (int c = 0; c <= r; ++c) registration.covariance.push_back(r == c ? sigma(r) * sigma(r) : 0);
  ASSERT_EQ(registration.covariance.size(), 28U);
  Places own = scan();
  for (auto& point : own) point = registration.to_from_from.inverse() * point / registration.scale;
  Import import("scan.xyz", xyz(own, 1));
  import.node.input<Transform>("registration", registration);
  EXPECT_NEAR(import.place(), 79.996, 1e-5);
  const auto surface = import.node.output<SurfacePoints>("surface");
  EXPECT_EQ(surface.rank, 7);
  const auto points = stated_points(surface, import.node.output<Folder>("files").uri);
  // The scale is known to 5e-5 of 1.002, and about 20 m lie between the registration's origin and the panel.
  const Eigen::MatrixXd cov = points[0].by_common_errors * points[0].by_common_errors.transpose();
  const Eigen::Vector3d arm = points[0].place - Eigen::Vector3d(100, 80, 0);
  EXPECT_NEAR(std::sqrt(cov(0, 0)), std::hypot(1e-3, 5e-5 / 1.002 * arm.x()), 2e-5);
}

/// A file whose coordinates are `moved` from the design's, and the registration that leads back.
struct Far : Import {
  Far(const std::string& name, const std::string& bytes, const Eigen::Vector3d& moved) : Import(name, bytes) {
    TransformT registration;
    registration.to_from_from = {Eigen::Quaterniond::Identity(), -moved};
    registration.scale = 1;
    node.input<Transform>("registration", registration);
  }
};

TEST(ImportNode, CoordinatesCoarserThanTheNoiseAreRefused) {
  const Eigen::Vector3d national(350000, 350000, 0);
  Places far = scan();
  for (auto& point : far) point += national;
  std::string in_metres = cloud_bytes::binary_ply(far, false);  // y as a 32-bit float
  in_metres.replace(in_metres.find("comment unit: mm"), 16, "comment unit: m ");
  Far coarse("scan.ply", in_metres, national);
  const std::string found = coarse.refusal();
  EXPECT_NE(found.find("written in steps of 31 mm"), std::string::npos) << found;
  EXPECT_NE(found.find("write doubles"), std::string::npos) << found;

  cloud_bytes::LasFile las;
  las.scale = 0.01, las.offset = {100, 50, 0};
  Import centimetres("scan.las", cloud_bytes::las_file(las, scan()));
  expect_refused(centimetres, "written in steps of 10 mm, 'noise' is 2 mm");
  std::string two_decimals;
  for (const auto& p : scan()) {
    char line[100];
    std::snprintf(line, sizeof line, "%.2f %.2f %.2f\n", p.x(), p.y(), p.z());
    two_decimals += line;
  }
  Import text("scan.xyz", two_decimals);
  expect_refused(text, "written in steps of 10 mm");
  Import noisy("scan.xyz", two_decimals);
  noisy.node.set("noise", "0.02");
  noisy.node.run();

  // Finer steps than the noise are errors that all points have in common.
  las.scale = 0.0015;
  Import fine("scan.las", cloud_bytes::las_file(las, scan()));
  fine.node.set("place_sigma", "0.0001");
  fine.node.run();
  const auto points = stated_points(fine.node.output<SurfacePoints>("surface"), fine.node.output<Folder>("files").uri);
  EXPECT_NEAR(points[0].by_common_errors.row(1).norm(), std::hypot(0.0001, 0.0015 / std::sqrt(12.0)), 1e-6);

  // Where only each scan's own errors are stated, too: the file's steps are common to all of its scans.
  Import apart("scan.las", cloud_bytes::las_file(las, scan()));
  apart.node.set("scan_sigma", "0.0001");
  apart.node.run();
  const auto of_scan =
      stated_points(apart.node.output<SurfacePoints>("surface"), apart.node.output<Folder>("files").uri);
  EXPECT_NEAR(of_scan[0].by_common_errors.row(1).norm(), std::hypot(0.0001, 0.0015 / std::sqrt(12.0)), 1e-6);
}

SurfacesT panels_of(Import& import, const std::string& reach, std::vector<std::string>* warnings = nullptr) {
  import.node.run();
  NodeHarness panels("surface.panels");
  panels.set("reach", reach);
  panels.input<SurfacePoints>("surface", import.node.output<SurfacePoints>("surface"));
  panels.run();
  if (warnings) *warnings = panels.warnings();
  return panels.output<Surfaces>("surfaces");
}

/// The first panel so far before (above 0) or behind its face, with 2 mm of noise.
std::string panel_at(double out) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.002);
  Places points;
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) points.push_back({119.3 + 0.0237 * i, 80 - out + noise(random), 8.55 + 0.0487 * j});
  return xyz(points, 1);
}

TEST(ImportNode, APanelAtTheBorderOfTheSearchIsNotMeasured) {
  for (const double out : {0.044, 0.05, 0.055, -0.05}) {
    Import import("scan.xyz", panel_at(out));
    const auto panel = std::move(panels_of(import, "0.05").panels[0]);
    EXPECT_NE(panel->not_measured.find("at the border of the search"), std::string::npos)
        << out << ": " << panel->offset << " " << panel->not_measured;
  }
  Import inside("scan.xyz", panel_at(0.035));
  EXPECT_NEAR(panels_of(inside, "0.05").panels[0]->offset, 0.035, 2e-4);
  Import wide("scan.xyz", panel_at(0.055));
  wide.node.set("search", "0.2");
  EXPECT_NE(panels_of(wide, "0.06").panels[0]->not_measured, "") << "what the panels' own reach cuts";
  Import wider("scan.xyz", panel_at(0.055));
  wider.node.set("search", "0.2");
  EXPECT_NEAR(panels_of(wider, "0.2").panels[0]->offset, 0.055, 2e-4);
}

TEST(ImportNode, TheInnerSideOfAThinPanelIsNotItsFace) {
  Import behind("scan.xyz", panel_at(-0.05));
  behind.node.set("search", "0.1"), behind.node.set("seen_from",
                                                    "120.5\x1f"
                                                    "90\x1f"
                                                    "10");
  expect_refused(behind, "P1: all 1 stations of 'seen_from' that look at it see it from behind");
  Import before("scan.xyz", panel_at(0));
  before.node.set("seen_from",
                  "120.5\x1f"
                  "70\x1f"
                  "10");
  EXPECT_EQ(panels_of(before, "0.05").panels.size(), 2U);
  std::vector<std::string> warnings;
  Import untold("scan.xyz", panel_at(-0.05));
  untold.node.set("search", "0.1");
  panels_of(untold, "0.1", &warnings);
  EXPECT_NE(testing::PrintToString(warnings).find("are these points of its inner side?"), std::string::npos)
      << testing::PrintToString(warnings);
  Import outside("scan.xyz", panel_at(0));
  panels_of(outside, "0.05", &warnings);
  EXPECT_EQ(testing::PrintToString(warnings).find("inner side"), std::string::npos);
}

TEST(ImportNode, BothFeetAreNamedAndHowFarApartTheyAre) {
  Import silent("scan.xyz", xyz(scan(), 1 / 0.3048));
  const std::string found = silent.refusal();
  // 144 m from the origin: 2e-6 of it.
  EXPECT_NE(found.find("unit: ft for international feet (0.3048 m) or unit: us_ft for US survey feet"),
            std::string::npos)
      << found;
  EXPECT_NE(found.find("here they lie 0.31 mm apart"), std::string::npos) << found;
  Places feet = scan();
  for (auto& point : feet) point /= 0.3048;
  std::string ply = cloud_bytes::binary_ply(feet, false);
  ply.replace(ply.find("comment unit: mm"), 16, "comment unit: ft");
  Import said("scan.ply", ply);
  said.node.run();
  EXPECT_NE(testing::PrintToString(said.node.warnings()).find("says feet and not which"), std::string::npos);
  Import chosen("scan.ply", ply);
  chosen.node.set("unit", "us_ft");
  chosen.node.run();
  EXPECT_EQ(testing::PrintToString(chosen.node.warnings()).find("says feet"), std::string::npos);
}

TEST(ImportNode, ARightScanIsReadWhateverElseIsInIt) {
  Places points = scan();
  for (int i = 0; i < 40000; ++i)  // a lawn that would lie on the panel if its metres were feet
    points.push_back(Eigen::Vector3d(120.1 + 0.00001 * i, 80, 10.1) / 0.3048);
  Import guessed("scan.xyz", xyz(points, 1));
  EXPECT_NEAR(guessed.place(), 79.996, 1e-5) << "one part of the panel has more points than all parts in metres";
  // Where the unit is stated nobody argues, even if in feet more of the faces would have points.
  Places little;
  for (int i = 0; i < 3600; ++i) little.push_back({120.1 + 0.00001 * i, 79.996, 10.1});
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) little.push_back(Eigen::Vector3d(119.3 + 0.0237 * i, 80, 8.55 + 0.0487 * j) / 0.3048);
  Import unstated("scan.xyz", xyz(little, 1));
  expect_refused(unstated, "1 of 36 parts of the faces have points if the coordinates are in m, 18 if they are in ft");
  Import stated("scan.xyz", xyz(little, 1));
  stated.node.set("unit", "m");
  EXPECT_NEAR(stated.place(), 79.996, 1e-5);
}

TEST(ImportNode, SeveralScansInAFileAreSaid) {
  const std::string points = xyz(scan(), 1);
  const std::string count = std::to_string(std::count(points.begin(), points.end(), '\n')) + "\n";
  Import import("scan.pts", count + points + count + points);
  import.node.run();
  EXPECT_NE(testing::PrintToString(import.node.warnings()).find("there are 2 scans in the file"), std::string::npos)
      << testing::PrintToString(import.node.warnings());
}

/// Its points lay beside the faces without a word.
TEST(ImportNode, AScanWithoutAPoseBesideOthersIsSaid) {
  const std::string pose = "<pose><translation><x>0</x><y>0</y><z>0</z></translation></pose>";
  Places unregistered;
  for (const Eigen::Vector3d& point : scan()) unregistered.push_back(point - Eigen::Vector3d(100, 60, 8));
  Import import("scans.e57", cloud_bytes::e57_file({{scan(), {}, pose, "double"}, {unregistered, {}, "", "double"}}));
  import.node.run();
  EXPECT_NE(testing::PrintToString(import.node.warnings()).find("1 of the 2 scans in the file have no pose"),
            std::string::npos);
  Import registered("scans.e57", cloud_bytes::e57_file({{scan(), {}, "", "double"}, {scan(), {}, "", "double"}}));
  registered.node.run();
  EXPECT_EQ(testing::PrintToString(registered.node.warnings()).find("have no pose"), std::string::npos);
}

/// Two scans of the first panel, the second 3 mm behind the first, as E57 with what each is off by.
TEST(ImportNode, ScansOfAFileErrEachByItself) {
  Places first, second;
  for (const Eigen::Vector3d& point : scan()) {
    if (point.x() < 120.02) first.push_back(point - Eigen::Vector3d(119, 79, 9));
    if (point.x() > 119.9) second.push_back(point - Eigen::Vector3d(119, 79 - 0.003, 9));
  }
  const std::string pose = "<pose><translation><x>119</x><y>79</y><z>9</z></translation></pose>";
  Import import("scans.e57", cloud_bytes::e57_file({{first, {}, pose, "double"}, {second, {}, pose, "double"}}));
  import.node.set("place_sigma", "0.001"), import.node.set("scan_sigma", "0.002");
  import.node.run();
  EXPECT_EQ(testing::PrintToString(import.node.warnings()).find("scans in the file"), std::string::npos);
  const auto surface = import.node.output<SurfacePoints>("surface");
  ASSERT_EQ(surface.rank, 18) << "six of all, six of each";
  double of_both = 0;
  for (const StatedPoint& point : stated_points(surface, import.node.output<Folder>("files").uri)) {
    const bool late = point.place.y() > 79.998;
    EXPECT_NEAR(point.by_common_errors.leftCols(6).row(1).norm(), 0.001, 1e-9);
    EXPECT_NEAR(point.by_common_errors.middleCols(late ? 12 : 6, 6).row(1).norm(), 0.002, 1e-9);
    EXPECT_EQ(point.by_common_errors.middleCols(late ? 6 : 12, 6).norm(), 0);
    of_both += late;
  }
  EXPECT_GT(of_both, 1000);
  // A panel of two scans is known as well as two of them are, beside what they share.
  NodeHarness panels("surface.panels");
  panels.input<SurfacePoints>("surface", surface);
  panels.run();
  const auto measured = panels.output<Surfaces>("surfaces");
  const double sigma = std::sqrt(measured.panels[0]->covariance[0]);
  EXPECT_GT(sigma, std::hypot(0.001, 0.0013));
  EXPECT_LT(sigma, std::hypot(0.001, 0.0021));
}

/// What a scan is off by does not go away because no other one of the file, or none at all, is on the faces.
TEST(ImportNode, TheOnlyScanOnTheFacesErrsByItselfToo) {
  Places here, elsewhere;
  for (const Eigen::Vector3d& point : scan()) {
    here.push_back(point - Eigen::Vector3d(119, 79, 9));
    elsewhere.push_back(here.back() + Eigen::Vector3d(0, 40, 0));
  }
  const std::string pose = "<pose><translation><x>119</x><y>79</y><z>9</z></translation></pose>";
  const cloud_bytes::E57ScanBytes on{here, {}, pose, "double"}, off{elsewhere, {}, pose, "double"};
  for (const std::vector<cloud_bytes::E57ScanBytes>& file : {std::vector{on, off}, std::vector{on}}) {
    Import import("scans.e57", cloud_bytes::e57_file(file));
    import.node.set("scan_sigma", "0.002");
    import.node.run();
    const auto surface = import.node.output<SurfacePoints>("surface");
    ASSERT_EQ(surface.rank, 6) << file.size() << " scans";
    for (const StatedPoint& point : stated_points(surface, import.node.output<Folder>("files").uri))
      EXPECT_NEAR(point.by_common_errors.row(1).norm(), 0.002, 1e-9);
  }
}

/// Both panels built 3 mm wider at the joint, which is designed with 20 mm and has 14 mm.
TEST(ImportNode, ThePanelsOfAScanHaveTheJointThatIsThere) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> right(119.6, 121.9), up(8.5, 11.5);
  Places points;
  while (points.size() < 400'000)
    if (const double x = right(random); std::abs(x - 120.76) > 0.007)
      points.push_back({x, x < 120.76 ? 79.9975 : 80, up(random)});
  const auto joint_of = [&](const char* beside, const char* search) {
    Import import("scan.xyz", xyz(points, 1));
    import.node.set("noise", "0.0005"), import.node.set("beside", beside);
    import.node.run();
    NodeHarness panels("surface.panels");
    panels.input<SurfacePoints>("surface", import.node.output<SurfacePoints>("surface"));
    panels.run();
    NodeHarness joints("surface.scan_joints");
    joints.input<SurfacePoints>("points", import.node.output<SurfacePoints>("surface"));
    joints.input<Surfaces>("panels", panels.output<Surfaces>("surfaces"));
    joints.set("beam", "0"), joints.set("search", search);
    joints.run();
    return joints.output<Surfaces>("surfaces");
  };
  const SurfacesT surfaces = joint_of("0.02", "0.012");
  ASSERT_EQ(surfaces.joints.size(), 1U);
  const JointFiguresT& joint = *surfaces.joints[0];
  ASSERT_EQ(joint.not_measured, "");
  EXPECT_NEAR(joint.nominal_width, 0.02, 1e-9);
  for (const int at : {joint.narrowest, joint.widest}) {
    const JointPlaceT& place = *joint.places.at(at);
    EXPECT_NEAR(place.width, 0.014, 5 * place.width_sigma);
    EXPECT_LT(place.width_sigma, 0.0008);
  }
  EXPECT_NEAR(joint.places.at(joint.largest_step)->step, -0.0025, 1e-4);
  EXPECT_NE(surfaces.joints_measured.find("last point"), std::string::npos) << "what it costs is said";
  // The panels end 3 mm beside their faces: what was kept up to there says so, and what was cut before is refused.
  const JointFiguresT near = *joint_of("0.004", "0.004").joints[0];
  ASSERT_FALSE(near.places.empty());
  EXPECT_NEAR(near.places.at(near.widest)->width, 0.014, 0.002);
  try {
    ADD_FAILURE() << "a joint of " << joint_of("0.002", "0.012").joints[0]->places.size() << " places";
  } catch (const NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("set 'search' to no more than 2 mm"), std::string::npos) << error.what();
  }
}

/// A third of each panel was its neighbour's, and what was flat passed; the joint was called filled flush.
TEST(ImportNode, AScanThatLiesBesideItsPlaceByAPartOfAPanelIsNotJudged) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> right(119.0, 122.6), up(8.5, 11.5);
  const auto doubt_of = [&](double shift) {
    Places points;
    while (points.size() < 400'000) {
      const double x = right(random);
      const double middle = x - 120.76 - shift;  // from a joint; the next are 1.52 m from it
      if (std::abs(middle - 1.52 * std::round(middle / 1.52)) > 0.01) points.push_back({x, 80, up(random)});
    }
    Import import("scan.xyz", xyz(points, 1));
    import.node.set("noise", "0.0005"), import.node.set("place_confirmed", "true");
    import.node.run();
    NodeHarness panels("surface.panels");
    panels.input<SurfacePoints>("surface", import.node.output<SurfacePoints>("surface"));
    panels.run();
    NodeHarness joints("surface.scan_joints");
    joints.input<SurfacePoints>("points", import.node.output<SurfacePoints>("surface"));
    joints.input<Surfaces>("panels", panels.output<Surfaces>("surfaces"));
    joints.set("beam", "0");
    joints.run();
    return joints.output<Surfaces>("surfaces").place_doubt;
  };
  const std::string doubt = doubt_of(0.5);
  EXPECT_NE(doubt.find("run through 2 of 2 panels, 0.26 m to the left of their middles"), std::string::npos) << doubt;
  EXPECT_EQ(doubt_of(0), "");
  EXPECT_EQ(doubt_of(0.004), "") << "no more than edges are looked for";
}

TEST(FuseNode, ASourceWithoutPlaceAmongOthersIsRefused) {
  Import placed("a.xyz", xyz(scan(), 1)), alone("b.xyz", xyz(scan(), 1));
  placed.node.set("place_sigma", "0.0015");
  placed.node.run(), alone.node.run();
  const auto fuse = [](const std::vector<SurfacePointsT>& sources) {
    NodeHarness node("surface.fuse");
    node.set("least_points", "1");
    for (const SurfacePointsT& source : sources) node.input<SurfacePoints>("surfaces", source);
    try {
      node.run();
    } catch (const NodeFailed& error) {
      return std::string(error.what());
    }
    return std::to_string(node.output<SurfacePoints>("surface").measured) + " points";
  };
  const auto with = placed.node.output<SurfacePoints>("surface"), without = alone.node.output<SurfacePoints>("surface");
  EXPECT_NE(fuse({with, without}).find("source 2 of 2 states no systematic errors"), std::string::npos)
      << "its points would be believed to lie where they say";
  EXPECT_EQ(fuse({with, with}), "7200 points");
  EXPECT_EQ(fuse({without, without}), "7200 points") << "nobody's place is known: surface.panels says it";
}

TEST(WriteCloud, PointsOfSurfacesComeBackFromTheFile) {
  Import import("scan.xyz", xyz(scan(), 1));
  import.node.run();
  for (const char* format : {"las", "ply"}) {
    NodeHarness write("write.cloud");
    write.input<SurfacePoints>("surface", import.node.output<SurfacePoints>("surface"));
    write.set("format", format);
    if (std::string(format) == "las") write.set("frame", "scan");
    write.run();
    std::ifstream file(write.output<Folder>("folder").uri + "/points." + format, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    EXPECT_NE(bytes.find(std::string(format) == "las" ? "LOCAL_CS[\"scan\"" : "frame: frame not stated"),
              std::string::npos);
    NodeHarness again("dense.import");
    again.set("file", write.output<Folder>("folder").uri + "/points." + format);
    again.input<Design>("design", two_panels());
    again.run();
    const auto points = stated_points(again.output<SurfacePoints>("surface"), again.output<Folder>("files").uri);
    ASSERT_EQ(points.size(), 3600U) << format;
    for (const StatedPoint& point : points) EXPECT_NEAR(point.place.y(), 79.996, 1e-4);
  }
}

TEST(FindPlanesNode, APlaneIsMeasuredAsAPanelIs) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "scan.xyz").string();
  Places points;
  for (int i = 0; i < 150; ++i)
    for (int j = 0; j < 150; ++j)
      points.push_back({119.3 + 0.02 * i, 79.996 + 1e-4 * ((7 * i + 3 * j) % 11), 8.55 + 0.02 * j});
  std::ofstream(path) << xyz(points, 1);
  NodeHarness planes("surface.planes");
  planes.set("file", path);
  EXPECT_THROW(planes.run(), NodeFailed) << "nobody says which side is outside";
  planes.set("seen_from",
             "120\x1f"
             "70\x1f"
             "9");
  planes.run();
  EXPECT_EQ(stopping_at_fault([&] {
              NodeHarness again("surface.planes");
              again.set("file", path);
              again.set("seen_from",
                        "120\x1f"
                        "70\x1f"
                        "9");
              return again;
            }),
            "");
  const DesignT design = planes.output<Design>("design");
  ASSERT_EQ(design.elements.size(), 1U);
  EXPECT_NEAR(design.elements[0]->facade->out.y(), -1, 1e-5) << "towards the scanner";
  NodeHarness import("dense.import");
  import.set("file", path), import.set("place_sigma", "0.0015");
  import.input<Design>("design", design);
  import.run();
  NodeHarness panels("surface.panels");
  panels.input<SurfacePoints>("surface", import.output<SurfacePoints>("surface"));
  panels.run();
  const auto surfaces = panels.output<Surfaces>("surfaces");
  ASSERT_EQ(surfaces.panels.size(), 1U);
  EXPECT_EQ(surfaces.panels[0]->not_measured, "");
  EXPECT_NEAR(surfaces.panels[0]->offset, 0, 1e-4);
  EXPECT_NEAR(std::sqrt(surfaces.panels[0]->covariance[0]), 0.0015, 5e-5) << "with the scan's place in it";
}

}  // namespace test_import_node
