// frames.to_building and frames.graph as nodes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/site_frames.hpp"
#include "artifacts/transform.hpp"
#include "geometry/packed_symmetric.hpp"
#include "node_harness.hpp"
#include "survey/model/map_frame.hpp"

namespace plumbline {
namespace test_frame_nodes {

using test::NodeFailed;
using test::NodeHarness;
using ::testing::HasSubstr;

PointsT points_at(const std::vector<Eigen::Vector3d>& positions) {
  PointsT out;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    auto point = std::make_unique<PointT>();
    point->id = "A" + std::to_string(i);
    point->position = positions[i];
    point->sigma = Eigen::Vector3d::Constant(1e-3);
    out.points.push_back(std::move(point));
  }
  return out;
}

const std::vector<Eigen::Vector3d> in_building{{0, 0, 3}, {10, 0, 60}, {10, 5, 3}, {0, 5, 60}};

/// p_map = 0.9996 Rz(30°) p + (691000, 5335000, 500) in the plan; heights keep their lengths.
Eigen::Vector3d in_map(const Eigen::Vector3d& p) {
  const double c = 0.9996 * std::cos(M_PI / 6), s = 0.9996 * std::sin(M_PI / 6);
  return {691000 + c * p.x() - s * p.y(), 5335000 + s * p.x() + c * p.y(), 500 + p.z()};
}

DesignT design_with_map() {
  DesignT design;
  design.file_name = "tower.ifc";
  design.length_unit = 1;
  design.map_conversion = std::make_unique<DesignMapConversionT>();
  DesignMapConversionT& map = *design.map_conversion;
  map.eastings = 691000, map.northings = 5335000, map.orthogonal_height = 500;
  map.x_axis_abscissa = std::cos(M_PI / 6), map.x_axis_ordinate = std::sin(M_PI / 6);
  map.scale = 0.9996, map.scale_given = true, map.map_unit = 1, map.crs_name = "EPSG:25832";
  return design;
}

PointsT surveyed_in_map() {
  std::vector<Eigen::Vector3d> positions;
  for (const auto& p : in_building) positions.push_back(in_map(p));
  return points_at(positions);
}

TransformT brought_to_building(NodeHarness& node) {
  node.input<Points>("points", surveyed_in_map());
  node.input<Points>("designed", points_at(in_building));
  node.input<Design>("design", design_with_map());
  node.input<Plates>("plates", PlatesT());
  node.set("use", "map_conversion");
  node.run();
  return node.output<Transform>("transform");
}

TEST(ToBuilding, AMapConversionScalesThePlanAndNotTheHeights) {
  NodeHarness node("frames.to_building");
  const TransformT transform = brought_to_building(node);
  const PointsT there = node.output<Points>("points");
  for (std::size_t i = 0; i < in_building.size(); ++i)
    EXPECT_NEAR((there.points[i]->position - in_building[i]).norm(), 0, 1e-8) << i;
  EXPECT_NEAR(there.points[0]->sigma.x(), 1e-3 / 0.9996, 1e-9);
  EXPECT_NEAR(there.points[0]->sigma.z(), 1e-3, 1e-12);
  EXPECT_TRUE(transform.plan_only);
  EXPECT_NEAR(transform.scale, 1 / 0.9996, 1e-12);
  EXPECT_EQ(transform.origin, "its map conversion (tower.ifc)");
}

/// Once stretched by 400 ppm without a word: up to 6.5 mm where the tolerance was 5.
TEST(ToBuilding, ASurveyAtGroundScaleIsNotDividedByTheScaleOfTheMap) {
  NodeHarness node("frames.to_building");
  std::vector<Eigen::Vector3d> ground;
  const Eigen::Vector3d noise[] = {{1, -1, 0}, {-1, 0.5, 1}, {0.5, 1, -1}, {-0.5, -0.5, 0}};  // [0.1 mm]
  for (std::size_t i = 0; i < in_building.size(); ++i) {
    const Eigen::Vector3d p = in_map({0, 0, 0}), q = in_map(in_building[i]);
    ground.push_back(p + Eigen::Vector3d((q - p).x() / 0.9996, (q - p).y() / 0.9996, (q - p).z()) + 1e-4 * noise[i]);
  }
  node.input<Points>("points", points_at(ground));
  node.input<Points>("designed", points_at(in_building));
  node.input<Design>("design", design_with_map());
  node.input<Plates>("plates", PlatesT());
  node.set("use", "map_conversion");
  try {
    node.run();
    FAIL();
  } catch (const NodeFailed& error) {
    EXPECT_THAT(error.what(), HasSubstr("at ground scale"));
    EXPECT_THAT(error.what(), HasSubstr("0.999600"));
  }
}

/// A design beside a network on its map. Where the ground has a point is computed in X, Y, Z of the earth, from the
/// tangent plane of the design's origin; the network's frame then says which E, N, H that is.
struct DesignOnMap {
  explicit DesignOnMap(double east = 691000) : origin(east, 5335000, 500) {}

  const Eigen::Vector3d origin;
  const survey::MapFrame frame{"EPSG:25832", {}, origin.head<2>()};
  const geodesy::MapProjection map{"EPSG:25832"};
  const geodesy::MapFactors factors = map.factors(origin.head<2>());
  const double radius = map.radius(map.inverse(origin.head<2>()));
  const double scale = factors.scale * radius / (radius + origin.z());

  /// `p` stands on the ground with its x axis 30 degrees north of the map's east.
  Eigen::Vector3d on_map(const Eigen::Vector3d& p) const {
    const double turn = M_PI / 6 - factors.convergence, c = std::cos(turn), s = std::sin(turn);
    const Eigen::Vector3d level(c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z());
    const Eigen::Vector3d earth = frame.geocentric(origin) + frame.horizon(origin).transpose() * level;
    Eigen::Vector3d at = origin + level;
    for (int i = 0; i < 10; ++i) {
      Eigen::Matrix3d jacobian;
      const Eigen::Vector3d off = earth - frame.geocentric(at, &jacobian);
      at += jacobian.inverse() * off;
    }
    return at;
  }
  PointsT surveyed(double noise = 0) const {
    std::vector<Eigen::Vector3d> positions;
    for (std::size_t i = 0; i < in_building.size(); ++i)
      positions.push_back(on_map(in_building[i]) + noise * Eigen::Vector3d(i % 2 ? 1 : -1, i < 2 ? 1 : -1, 0));
    return points_at(positions);
  }
};

TEST(ToBuilding, AMapConversionAndANetworkOnItsMapHaveAPointAtOnePlace) {
  const DesignOnMap site;
  NodeHarness node("frames.to_building");
  DesignT design = design_with_map();
  design.map_conversion->scale = site.scale;
  node.input<Points>("points", site.surveyed());
  node.input<Points>("designed", points_at(in_building));
  node.input<Design>("design", design);
  node.input<Plates>("plates", PlatesT());
  node.set("use", "map_conversion");
  node.run();
  const PointsT there = node.output<Points>("points");
  for (std::size_t i = 0; i < in_building.size(); ++i)
    EXPECT_LT((there.points[i]->position - in_building[i]).norm(), 1e-4) << i;
  EXPECT_LT(node.warnings().size(), 1u) << node.warnings().front();
}

/// Once silent: 4.7 mm at 10 m, as if all anchors stood too near to each other.
TEST(ToBuilding, ADesignWithoutItsGridScaleIsNotHeldAgainstASurveyOnTheMap) {
  const DesignOnMap site(530000);
  NodeHarness node("frames.to_building");
  DesignT design = design_with_map();
  design.map_conversion->eastings = 530000, design.map_conversion->scale = 1;
  std::vector<Eigen::Vector3d> wide, surveyed;
  for (const Eigen::Vector3d& p : in_building) wide.push_back(5 * p), surveyed.push_back(site.on_map(wide.back()));
  node.input<Points>("points", points_at(surveyed));
  node.input<Points>("designed", points_at(wide));
  node.input<Design>("design", design);
  node.input<Plates>("plates", PlatesT());
  node.set("use", "map_conversion");
  try {
    node.run();
    FAIL();
  } catch (const NodeFailed& error) {
    EXPECT_THAT(error.what(), HasSubstr("EPSG:25832, which draws lengths there at 0.99953"));
    EXPECT_THAT(error.what(), HasSubstr("grid_scale=0.99953"));
  }
}

/// Heights above a geoid in place of the ellipsoid are 8 ppm at 50 m: on a wide site that is said, on a small one it is
/// nothing.
TEST(ToBuilding, AScaleOfAnotherHeightIsSaidWhereItAmountsToSomething) {
  const DesignOnMap site(530000);
  for (const double size : {5.0, 60.0}) {  // anchors of some 40 m, and 500 m
    NodeHarness node("frames.to_building");
    DesignT design = design_with_map();
    design.map_conversion->eastings = 530000, design.map_conversion->scale = site.scale * (1 - 8e-6);
    std::vector<Eigen::Vector3d> wide, surveyed;
    for (const Eigen::Vector3d& p : in_building)
      wide.emplace_back(size * p.x(), size * p.y(), p.z()), surveyed.push_back(site.on_map(wide.back()));
    node.input<Points>("points", points_at(surveyed));
    node.input<Points>("designed", points_at(wide));
    node.input<Design>("design", design);
    node.input<Plates>("plates", PlatesT());
    node.set("use", "map_conversion");
    node.run();
    const bool said = !node.warnings().empty() && node.warnings().front().find("8 ppm, ") != std::string::npos;
    EXPECT_EQ(said, size > 10) << size;
  }
}

/// Once all three coordinates of such a point were lost without a word, and of a plan network the output was blamed.
TEST(ToBuilding, PointsWithoutAHeightOrAPlanAreLeftOutByName) {
  PointsT survey = points_at(in_building);
  auto levelled = std::make_unique<PointT>();
  levelled->id = "BM", levelled->position = {NAN, NAN, 12}, levelled->sigma = {NAN, NAN, 1e-3};
  survey.points.insert(survey.points.begin(), std::move(levelled));
  survey.points[2]->position.z() = NAN;  // A1
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(15, 15);
  for (int i = 0; i < 15; ++i) covariance(i, i) = 1e-6 * (i + 1);
  survey.covariance = pack_symmetric(covariance);
  NodeHarness node("frames.to_building");
  node.input<Points>("points", survey);
  node.input<Points>("designed", points_at(in_building));
  node.input<Design>("design", DesignT());
  node.input<Plates>("plates", PlatesT());
  node.run();
  const PointsT out = node.output<Points>("points");
  ASSERT_EQ(out.points.size(), 3u);
  EXPECT_EQ(out.points[1]->id, "A2");
  EXPECT_NEAR(out.points[1]->sigma.x(), std::sqrt(1e-6 * 10), 1e-12);  // its own row of the covariance
  EXPECT_THAT(node.warnings(), testing::IsSupersetOf({HasSubstr("left out: 1 point (A1) without a height"),
                                                      HasSubstr("left out: 1 point (BM) without east and north")}));
  for (auto& point : survey.points) point->position.z() = NAN;
  survey.points.erase(survey.points.begin()), survey.covariance.clear();
  NodeHarness flat("frames.to_building");
  flat.input<Points>("points", survey);
  flat.input<Points>("designed", points_at(in_building));
  flat.input<Design>("design", DesignT());
  flat.input<Plates>("plates", PlatesT());
  try {
    flat.run();
    FAIL() << "a plan network was taken for one in space";
  } catch (const NodeFailed& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("no anchor has all of east, north and height: 4 points (A0, A1, A2, A3) without"));
  }
}

TEST(ToBuilding, ASurveyElsewhereIsRefusedWithWhatWouldExplainIt) {
  NodeHarness node("frames.to_building");
  node.input<Points>("points", surveyed_in_map());
  node.input<Points>("designed", points_at(in_building));
  node.input<Design>("design", design_with_map());
  node.input<Plates>("plates", PlatesT());
  try {
    node.run();
    FAIL();
  } catch (const NodeFailed& error) {
    EXPECT_THAT(error.what(), HasSubstr("frames.with.use=map_conversion"));
  }
}

/// With `given` and its sigmas: what the transform is uncertain by, all points have in common.
TEST(ToBuilding, AGivenTransformBringsItsUncertainty) {
  NodeHarness node("frames.to_building");
  node.input<Points>("points", points_at(in_building));
  node.input<Points>("designed", points_at(in_building));
  node.input<Design>("design", DesignT());
  node.input<Plates>("plates", PlatesT());
  node.set("use", "given");
  // Items of a list are separated by the unit separator, as the host hands them on.
  node.set("translation",
           "0\x1f"
           "0\x1f"
           "0");
  node.set("sigmas",
           "0.001\x1f"
           "0\x1f"
           "0\x1f"
           "0.004");
  node.run();
  const PointsT there = node.output<Points>("points");
  EXPECT_NEAR(there.points[1]->sigma.z(), std::hypot(1e-3, 4e-3), 1e-9);
  EXPECT_NEAR(there.points[1]->sigma.y(), std::hypot(1e-3, 1e-3 * 10), 1e-9) << "the turn acts on a lever of 10 m";
  EXPECT_NEAR(there.points[1]->sigma.x(), 1e-3, 1e-9);
}

/// Anchors of two facades over four floors, built with an error of some millimetres.
std::vector<Eigen::Vector3d> facade_anchors() {
  std::vector<Eigen::Vector3d> anchors;
  for (int floor = 0; floor < 4; ++floor)
    for (int column = 0; column < 5; ++column) anchors.emplace_back(4.0 * column, column > 2 ? 6.0 : 0.0, 3.0 * floor);
  return anchors;
}

Eigen::Vector3d built(const Eigen::Vector3d& p, std::size_t i) {
  return p + 1e-3 * Eigen::Vector3d(static_cast<double>(i % 3) - 1, static_cast<double>(i % 5) - 2,
                                    static_cast<double>(i % 7) - 3);
}

void fit_to_design(NodeHarness& node, const std::vector<Eigen::Vector3d>& surveyed, const std::string& use) {
  node.input<Points>("points", points_at(surveyed));
  node.input<Points>("designed", points_at(facade_anchors()));
  node.input<Design>("design", DesignT());
  node.input<Plates>("plates", PlatesT());
  node.set("use", use);
}

/// Once one anchor that stood 400 mm out moved the frame, and with it all 19 others by 20 mm.
TEST(ToBuilding, AFitToTheDesignLeavesOutWhatStandsElsewhereAndSaysSo) {
  for (const std::string use : {"fitted", "fitted_in_space"}) {
    std::vector<Eigen::Vector3d> surveyed;
    const Eigen::AngleAxisd turn(0.3, use == "fitted" ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(0.6, 0, 0.8));
    for (const Eigen::Vector3d& p : facade_anchors())
      surveyed.push_back(turn * built(p, surveyed.size()) + Eigen::Vector3d(100, 200, 30));
    const std::vector<Eigen::Vector3d> sound = surveyed;
    surveyed[7] += turn * Eigen::Vector3d(0, 0.4, 0);
    const auto brought = [&](const std::vector<Eigen::Vector3d>& points, std::string& origin) {
      NodeHarness node("frames.to_building");
      fit_to_design(node, points, use);
      node.run();
      origin = node.output<Transform>("transform").origin;
      return node.output<Points>("points");
    };
    std::string origin, origin_of_sound;
    const PointsT there = brought(surveyed, origin), without = brought(sound, origin_of_sound);
    EXPECT_EQ(origin, "fitted to 19 of 20 anchors, without A7, which stand elsewhere");
    EXPECT_EQ(origin_of_sound, "fitted to 20 anchors");
    for (std::size_t i = 0; i < surveyed.size(); ++i) {
      const Eigen::Vector3d off(0, i == 7 ? 0.4 : 0, 0);
      EXPECT_LT((there.points[i]->position - without.points[i]->position - off).norm(), 1e-3) << use << " " << i;
      EXPECT_LT((without.points[i]->position - built(facade_anchors()[i], i)).norm(), 3e-3) << use << " " << i;
    }
  }
}

/// What the datum is uncertain by, all anchors have in common: their differences know nothing of the shift.
TEST(ToBuilding, TheUncertaintyOfTheDatumIsCommonToAllAnchors) {
  for (const std::string use : {"fitted", "fitted_in_space"}) {
    std::vector<Eigen::Vector3d> surveyed;
    for (const Eigen::Vector3d& p : facade_anchors()) surveyed.push_back(built(p, surveyed.size()));
    const auto covariance = [&](const char* sigma) {
      NodeHarness node("frames.to_building");
      fit_to_design(node, surveyed, use);
      if (*sigma) node.set("datum_sigma", sigma);
      node.run();
      const TransformT transform = node.output<Transform>("transform");
      EXPECT_TRUE(transform.fitted_to_design);
      const PointsT points = node.output<Points>("points");
      EXPECT_TRUE(points.fitted_to_design);
      if (points.fitted_to_design) {
        EXPECT_EQ(points.fitted_to_design->origin, transform.origin);
        EXPECT_EQ(std::isfinite(points.fitted_to_design->datum_sigma), *sigma != 0);
      }
      EXPECT_EQ(std::isfinite(transform.datum_sigma), *sigma != 0);
      return unpack_symmetric(node.output<Points>("points").covariance, 60, "points");
    };
    const Eigen::MatrixXd unsaid = covariance(""), zero = covariance("0"), known = covariance("0.004");
    EXPECT_EQ((unsaid - zero).cwiseAbs().maxCoeff(), 0);
    const Eigen::MatrixXd datum = known - zero;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto& p : facade_anchors()) middle += p / 20;
    Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
    double of_turn = 0;
    for (int i = 0; i < 20; ++i)
      for (int j = 0; j < 20; ++j) mean += datum.block<3, 3>(3 * i, 3 * j) / 400;
    for (int i = 0; i < 20; ++i) of_turn += (datum.block<3, 3>(3 * i, 3 * i).trace() - 3 * 16e-6) / 20;
    EXPECT_LT((mean - 16e-6 * Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-9) << "4 mm of the middle";
    // Of one turn what it does at the mean distance is 4 mm; of three as much each.
    EXPECT_NEAR(of_turn, (use == "fitted" ? 1 : 3) * 16e-6, 5e-8);
  }
}

TEST(ToBuilding, AFitNeedsAnchorsThatTellIt) {
  const auto message = [](const std::vector<Eigen::Vector3d>& anchors, const char* use, const char* datum = "") {
    NodeHarness node("frames.to_building");
    node.input<Points>("points", points_at(anchors));
    node.input<Points>("designed", points_at(anchors));
    node.input<Design>("design", DesignT());
    node.input<Plates>("plates", PlatesT());
    node.set("use", use);
    if (*datum) node.set("datum_sigma", datum);
    try {
      node.run();
    } catch (const NodeFailed& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_THAT(message({{0, 0, 0}, {5, 0, 0}, {0, 5, 0}}, "fitted"), HasSubstr("four anchors or more"));
  EXPECT_THAT(message({{0, 0, 0}, {0, 0, 3}, {0, 0, 6}, {0, 0, 9}}, "fitted"), HasSubstr("one vertical line"));
  EXPECT_THAT(message({{0, 0, 0}, {4, 0, 3}, {8, 0, 6}, {12, 0, 9}}, "fitted_in_space"), HasSubstr("in one line"));
  EXPECT_EQ(message(in_building, "same", "0.002"), "nothing") << "control may have the coordinates of the design";
  EXPECT_EQ(message(in_building, "fitted"), "nothing");
}

std::string text_of(const FileT& file) { return {file.content.begin(), file.content.end()}; }

TEST(FramesGraph, GivesPointsInEveryFrame) {
  TransformT same;
  same.scale = 1;
  same.origin = "survey and design share one frame";
  NodeHarness node("frames.graph");
  node.input<Transform>("survey", same);
  node.input<Design>("design", design_with_map());
  node.input<Points>("points", points_at(in_building));
  node.run();
  const SiteFramesT frames = node.output<SiteFrames>("frames");
  ASSERT_EQ(frames.links.size(), 2u);
  EXPECT_EQ(frames.links[1]->to, "map");
  EXPECT_EQ(frames.links[1]->transform->origin,
            "map conversion of tower.ifc to EPSG:25832, as the standard reads it; not checked against surveyed points");
  const std::string table = text_of(node.output<File>("coordinates"));
  EXPECT_THAT(table, HasSubstr("A1,survey,10.00000,0.00000,60.00000,"));
  const Eigen::Vector3d expected = in_map(in_building[1]);
  char line[100];
  std::snprintf(line, sizeof line, "A1,map,%.5f,%.5f,%.5f,", expected.x(), expected.y(), expected.z());
  EXPECT_THAT(table, HasSubstr(line));
}

TEST(FramesGraph, ASurveyInMapCoordinatesIsTheMap) {
  NodeHarness survey("frames.to_building"), node("frames.graph");
  node.input<Transform>("survey", brought_to_building(survey));
  node.input<Design>("design", design_with_map());
  node.run();
  EXPECT_EQ(node.output<SiteFrames>("frames").links.size(), 1u);
}

/// A run keeps its limit of memory by what nodes announce: 138 MB were taken without a word.
TEST(Frames, AJointCovarianceIsAnnounced) {
  const auto announced = [](std::size_t count) {
    std::vector<Eigen::Vector3d> positions, there;
    for (std::size_t i = 0; i < count; ++i)
      positions.emplace_back(static_cast<double>(i % 25), static_cast<double>(i / 25), static_cast<double>(i % 7));
    for (const auto& p : positions) there.push_back(in_map(p));
    PointsT points = points_at(there), in_frame = points_at(positions);
    const auto n = static_cast<Eigen::Index>(3 * count);
    points.covariance = in_frame.covariance = pack_symmetric(Eigen::MatrixXd(1e-6 * Eigen::MatrixXd::Identity(n, n)));
    NodeHarness moved("frames.to_building"), graph("frames.graph");
    moved.input<Points>("points", points);
    moved.input<Points>("designed", points_at(positions));
    moved.input<Design>("design", design_with_map());
    moved.input<Plates>("plates", PlatesT());
    moved.set("use", "map_conversion");
    moved.run();
    graph.input<Transform>("survey", moved.output<Transform>("transform"));
    graph.input<Points>("points", in_frame);
    graph.run();
    return std::make_pair(moved.announced(), graph.announced());
  };
  const std::uint64_t packed = 1800 * 1801 / 2 * sizeof(double);
  EXPECT_EQ(announced(600), std::make_pair(12 * packed, 6 * packed));
  EXPECT_EQ(announced(20), std::make_pair(std::uint64_t{0}, std::uint64_t{0}));
}

}  // namespace test_frame_nodes
}  // namespace plumbline
