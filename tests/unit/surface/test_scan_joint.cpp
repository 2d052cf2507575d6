// Joints from simulated scans of two panels whose edges are known: errors against what is stated of them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "surface/dense/joint_pairs.hpp"
#include "surface/dense/scan_joint.hpp"

namespace plumbline::surface {
namespace test_scan_joint {

const FacadePlane kPlane = facade_plane({105, 212, 31}, {-0.6, -0.8, 0});
constexpr double kDesigned = 0.015, kStep = 0.002;  // [m]

std::vector<PanelFace> designed() {
  std::vector<PanelFace> faces = {{"left", kPlane, 0.2, 0.4}, {"right", kPlane, 0.2, 0.4}};
  faces[0].plane.origin = kPlane.world({-0.1 - 0.5 * kDesigned, 0, 0});
  faces[1].plane.origin = kPlane.world({0.1 + 0.5 * kDesigned, 0, 0});
  return faces;
}

enum class Pattern { random, turned, upright };
enum class Beam { point, first, mean };

struct Scan {
  double width = 0.0138, shift = 0.0011;  ///< of the joint as built, and of its middle [m]
  double spacing = 0.0025, noise = 0.001;
  double ground = 0.03;  ///< how far what lies in the joint is behind the panels [m]
  Pattern pattern = Pattern::random;
  Beam beam = Beam::point;
  double diameter = 0;  ///< of the beam [m]
  double mixed = 0;     ///< share of the points in the joint that come back from between panel and ground
};

/// Height of what a beam at u comes back from.
double height_of(const Scan& scan, double u) {
  const double left = scan.shift - 0.5 * scan.width, right = scan.shift + 0.5 * scan.width;
  const double panel = u > scan.shift ? kStep : 0.0, inside = u > scan.shift ? u - right : left - u;
  if (scan.beam == Beam::point) return inside > 0 ? panel : -scan.ground;
  const double share = std::clamp(inside / scan.diameter + 0.5, 0.0, 1.0);  // of the beam on the panel
  if (scan.beam == Beam::first) return share > 0.02 ? panel : -scan.ground;
  return share * panel - (1 - share) * scan.ground;
}

std::vector<MeasuredTile> scanned(const Scan& scan, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> uniform(0, 1);
  MeasuredTile tile;
  tile.centre = kPlane.origin, tile.factor.resize(6, 0);
  const auto add = [&](double u, double v) {
    if (std::abs(u) > 0.2 || std::abs(v) > 0.2) return;
    double height = height_of(scan, u);
    if (scan.mixed > 0 && height == -scan.ground && uniform(random) < scan.mixed) {  // denser towards the face
      const double depth = uniform(random);
      height = (u > scan.shift ? kStep : 0.0) - depth * depth * scan.ground;
    }
    const Eigen::Vector3d place = kPlane.world({u, v, height + scan.noise * normal(random)});
    tile.points.push_back({(place - tile.centre).cast<float>(), static_cast<float>(scan.noise)});
  };
  if (scan.pattern == Pattern::random) {
    const auto count = static_cast<int>(0.16 / (scan.spacing * scan.spacing));
    for (int i = 0; i < count; ++i) add(0.4 * uniform(random) - 0.2, 0.4 * uniform(random) - 0.2);
    return {tile};
  }
  const double turn = scan.pattern == Pattern::turned ? 0.1 + uniform(random) : 0, du = uniform(random),
               dv = uniform(random);
  const auto half = static_cast<int>(0.3 / scan.spacing);
  for (int i = -half; i <= half; ++i)
    for (int j = -half; j <= half; ++j) {
      const double a = (i + du) * scan.spacing, b = (j + dv) * scan.spacing;
      add(a * std::cos(turn) - b * std::sin(turn), a * std::sin(turn) + b * std::cos(turn));
    }
  return {tile};
}

MeasuredJoint measured(const std::vector<MeasuredTile>& tiles, const ScanJointOptions& options) {
  const std::vector<PanelFace> faces = designed();
  std::vector<PanelSurface> surfaces;
  for (const PanelFace& face : faces) surfaces.push_back(measure_panel(face, tiles, {}));
  const std::vector<Joint> joints = joints_of(faces);
  EXPECT_EQ(joints.size(), 1U);
  return measure_scan_joint(joints.at(0), faces, surfaces, tiles, options);
}

ScanJointOptions of_beam(double beam) {
  ScanJointOptions options;
  options.beam = beam;
  return options;
}

/// Errors of many scans of one pattern over what is stated.
struct Errors {
  double width = 0, step = 0, mean = 0, sigma = 0, count = 0;
};
Errors errors_of(Scan scan, double beam, int scans) {
  std::mt19937_64 random(11);
  const double width = scan.width;
  Errors errors;
  for (int k = 0; k < scans; ++k) {
    // Both edges cut the same columns: of one width the error's variance is s² f (1 - f), with the rest f of width over
    // spacing s, which is up to half more than it is over all widths.
    scan.width = width + scan.spacing * ((k + 0.5) / scans - 0.5);
    const MeasuredJoint joint = measured(scanned(scan, random), of_beam(beam));
    EXPECT_EQ(joint.not_measured, "");
    EXPECT_EQ(joint.stations_looked_at, 8);
    for (const JointStation& station : joint.stations) {
      const double off = station.width - scan.width;
      errors.width += std::pow(off / station.width_sigma, 2), errors.mean += off, errors.sigma += station.width_sigma;
      errors.step += std::pow((station.step - kStep) / station.step_sigma, 2), errors.count += 1;
    }
  }
  for (double* sum : {&errors.width, &errors.step, &errors.mean, &errors.sigma}) *sum /= errors.count;
  return errors;
}

TEST(ScanJoint, WidthsAndStepsHaveTheErrorsTheyStateWhateverThePattern) {
  for (const Pattern pattern : {Pattern::random, Pattern::turned, Pattern::upright}) {
    Scan scan;
    scan.pattern = pattern;
    const Errors errors = errors_of(scan, 0, 50);
    const int which = static_cast<int>(pattern);
    std::printf("pattern %d: width %.2f, mean error %.3f mm, stated %.3f mm, step %.2f, %g places\n", which,
                errors.width, 1e3 * errors.mean, 1e3 * errors.sigma, errors.step, errors.count);
    EXPECT_GE(errors.count, 0.9 * 8 * 50) << which;
    // Columns that run along the joint have the same error at all its places: 50 trials then, and 400 at random.
    EXPECT_GT(errors.width, 0.6) << which;
    EXPECT_LT(errors.width, 1.5) << which;
    EXPECT_GT(errors.step, 0.5) << which;
    EXPECT_LT(errors.step, 1.6) << which;
    EXPECT_LT(std::abs(errors.mean), pattern == Pattern::upright ? 5e-4 : 6e-5) << which;
  }
}

/// A beam that meets edge and ground comes back from between them, and some of it as near to the face as its noise: the
/// largest hole between two such points is no joint.
TEST(ScanJoint, MixedPixelsDoNotNarrowIt) {
  for (const double mixed : {0.2, 0.35})
    for (const Pattern pattern : {Pattern::random, Pattern::turned}) {
      Scan scan;
      scan.mixed = mixed, scan.pattern = pattern, scan.width = 0.018;
      const Errors errors = errors_of(scan, 0, 20);
      std::printf("mixed %g, pattern %d: width %.2f, mean error %.3f mm, stated %.3f mm, %g places\n", mixed,
                  static_cast<int>(pattern), errors.width, 1e3 * errors.mean, 1e3 * errors.sigma, errors.count);
      EXPECT_GE(errors.count, 0.9 * 8 * 20);
      EXPECT_LT(errors.width, 1.5);
      EXPECT_LT(std::abs(errors.mean), 5e-4);
      EXPECT_LT(errors.sigma, 0.002);
    }
}

TEST(ScanJoint, AnEdgeFurtherInThanItIsLookedForIsNotAtTheBorderOfTheSearch) {
  std::mt19937_64 random(5);
  Scan scan;
  ScanJointOptions near = of_beam(0);
  near.search = 0.003, scan.width = 0.007, scan.shift = 0.0001;  // each edge 4 mm in
  const MeasuredJoint joint = measured(scanned(scan, random), near);
  EXPECT_NE(joint.not_measured.find("further into it than 3 mm"), std::string::npos) << joint.not_measured;
  near.search = 0.006;
  EXPECT_EQ(measured(scanned(scan, random), near).not_measured, "");
}

TEST(ScanJoint, ABeamThatMeetsBothIsOffByNoMoreThanItsWidthAndThatIsStated) {
  Scan scan;
  scan.width = 0.02, scan.diameter = 0.004;
  scan.beam = Beam::first;
  const Errors first = errors_of(scan, 0.004, 4);
  scan.beam = Beam::mean;
  const Errors mean = errors_of(scan, 0.004, 4);
  EXPECT_NEAR(first.mean, -0.004, 4e-4) << "the first return shows panels half a beam too wide on each side";
  EXPECT_GT(mean.mean, 0.0015) << "the mean of both shows them too narrow";
  EXPECT_LT(mean.mean, 0.004);
  EXPECT_NEAR(mean.sigma, 0.004 / std::sqrt(3.0), 1e-4) << "more points do not make it better";
}

TEST(ScanJoint, ASingleFalsePointInTheJointIsNotItsEdge) {
  Scan scan;
  std::mt19937_64 random(5);
  std::vector<MeasuredTile> tiles = scanned(scan, random);
  const MeasuredJoint without = measured(tiles, of_beam(0));
  const double along = without.stations.at(2).along;
  tiles[0].points.push_back({(kPlane.world({0.002, along, 0.001}) - tiles[0].centre).cast<float>(), 0.001F});
  const MeasuredJoint with = measured(tiles, of_beam(0));
  ASSERT_EQ(with.stations.size(), without.stations.size());
  EXPECT_NEAR(with.stations[2].width, without.stations[2].width, 1e-5);
}

TEST(ScanJoint, WhatAScanCannotTellHasAReason) {
  std::mt19937_64 random(7);
  Scan flush;
  flush.ground = 0;
  EXPECT_NE(measured(scanned(flush, random), {}).not_measured.find("filled flush"), std::string::npos);
  Scan shallow;
  shallow.ground = 0.0048;
  EXPECT_NE(measured(scanned(shallow, random), {}).not_measured, "") << "points on the sealant within the noise";
  Scan sparse;
  sparse.spacing = 0.006, sparse.width = 0.002;
  EXPECT_NE(measured(scanned(sparse, random), {}).not_measured.find("too narrow for the scan"), std::string::npos);
  sparse.spacing = 0.02;
  EXPECT_NE(measured(scanned(sparse, random), {}).not_measured.find("fewer than 12 points"), std::string::npos);
  Scan dense;
  std::vector<MeasuredTile> half = scanned(dense, random);
  std::erase_if(half[0].points, [&](const MeasuredPoint& point) { return kPlane.local(half[0].at(point)).x() > 0; });
  EXPECT_NE(measured(half, {}).not_measured.find("panel right is not measured"), std::string::npos);
}

/// Points close to each other along the joint and columns 35 mm apart: the strip beside the edge holds one of them.
TEST(ScanJoint, OneColumnBesideAnEdgeDoesNotTellWhereThePanelEnds) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 1);
  MeasuredTile tile;
  tile.centre = kPlane.origin, tile.factor.resize(6, 0);
  for (const double u : {-0.155, -0.12, -0.085, -0.05, -0.015, 0.015, 0.05, 0.085, 0.12, 0.155})
    for (double v = -0.199; v < 0.2; v += 0.0025) {
      const double height = (u > 0 ? kStep : 0.0) + 0.001 * normal(random);
      const Eigen::Vector3d place = kPlane.world({u + 1e-5 * normal(random), v, height});
      tile.points.push_back({(place - tile.centre).cast<float>(), 0.001F});
    }
  const MeasuredJoint joint = measured({tile}, of_beam(0));
  EXPECT_NE(joint.not_measured.find("columns along it"), std::string::npos) << joint.not_measured;
  EXPECT_TRUE(joint.stations.empty()) << "30 mm with a standard deviation near zero, where 15 mm may be";
}

TEST(ScanJoint, WhatACutLeavesOut) {
  const CutOff even = cut_off({0, 1, 2, 3});
  EXPECT_NEAR(even.mean, 0.5, 1e-12);
  EXPECT_NEAR(even.variance, 1.0 / 12, 1e-12);
  EXPECT_EQ(even.largest, 1);
  EXPECT_NEAR(cut_off({0, 3, 4}).mean, 0.25 * 0.5 + 0.75 * 1.5, 1e-12) << "a cut falls into wide steps more often";
}

}  // namespace test_scan_joint
}  // namespace plumbline::surface
